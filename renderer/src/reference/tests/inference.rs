//! Where there is no geometry: what the device infers against f64, step by step and as frames.

use flaneur_scene::{Distortion, Lens, SceneUpdate, View};
use glam::{DVec2, DVec3, UVec2};

use super::common::{DISTORTIONS, Street, camera, image_update, mesh_update, with_lens};
use super::{SIZE, Scene, both, keep_both, settings};
use crate::infer::reference::Past;
use crate::kernel_tests::channels::texels;
use crate::kernel_tests::{gpu, positions};
use crate::reference::difference::DOUBT;
use crate::reference::field::{Field, cells};
use crate::reference::inference::{Hypotheses, Inferred, Sights};
use crate::reference::surfaces;
use crate::reference::triangles::Triangles;
use crate::tolerances::{
    CELL_DIRECTION, COST_ROUNDING, DIFFUSION_RELATIVE, FILLED_RELATIVE, FRAME_ALIKE_SHARE,
    INFERRED_ALIKE_SHARE, LENS_PX, SETTLED_RELATIVE, SIGHT_BRIGHTNESS, SIGHT_SHARE,
};
use crate::{Mode, Renderer, Settings, Surface};

const FAR: DVec3 = DVec3::new(651_187.3, 6_861_353.6, 42.8);

const RIGS: usize = 3;

pub(super) fn inferring() -> Settings {
    Settings { infer: true, ..settings() }
}

/// A street without the wall at which the view looks, and without its pole, whose shadows would lie on
/// inferred depths: what was there is in the photographs alone.
pub(super) fn updates(origin: DVec3) -> Vec<SceneUpdate> {
    let street = Street::with_pole(origin);
    let without_pole = Street { blocks: vec![street.blocks[0], street.blocks[2]], ..street };
    let taken = |id: &str, at: [f64; 3], heading: f64| {
        let camera = camera(origin, at, heading, 8.0, 75.0, UVec2::new(480, 360));
        image_update(without_pole.photograph(id, camera))
    };
    vec![
        mesh_update(without_pole.mesh(&[1, 2], 0.05)),
        taken("a/east", [-1.0, -0.9, 1.9], 85.0),
        taken("a/north", [-1.0, -0.8, 1.9], 20.0),
        taken("b/east", [-0.9, 1.9, 2.0], 95.0),
        taken("c/east", [-0.5, 5.0, 2.2], 110.0),
    ]
}

fn view(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, 8.0, 60.0, SIZE))
}

fn rendered(origin: DVec3) -> (Renderer, Scene, Hypotheses, Vec<Vec<Sights>>) {
    rendered_as(origin, &view(origin))
}

fn rendered_as(origin: DVec3, view: &View) -> (Renderer, Scene, Hypotheses, Vec<Vec<Sights>>) {
    let mut renderer = Renderer::with_settings(gpu(), inferring());
    let mut scene = Scene::new(inferring());
    for update in updates(origin) {
        scene.apply(update.clone());
        renderer.apply(update).expect("a good update");
    }
    renderer.render(view).expect("a frame");
    let (hypotheses, sights) = scene.inference(view).expect("a grid");
    (renderer, scene, hypotheses, sights)
}

/// What the device's photographs show, hypothesis by hypothesis and rig by rig.
fn sights_on_device(renderer: &Renderer, hypotheses: &Hypotheses) -> Vec<Vec<Sights>> {
    let size = hypotheses.grid.cells;
    let tall: Vec<Field<[f32; 4]>> =
        renderer.infer_pass().last_cells().expect("a frame").sights.iter().map(texels).collect();
    let sight = |rig: &Field<[f32; 4]>, index: u32| {
        Field::new(size, |cell| {
            let [stands_out, sees, ..] = rig.at(cell + UVec2::new(0, index * size.y));
            (sees > 0.5).then_some(f64::from(stands_out))
        })
    };
    let rigs = |index| tall.iter().take(RIGS).map(|rig| sight(rig, index)).collect();
    (0..hypotheses.grid.hypotheses).map(rigs).collect()
}

/// Directions of cells, what is known of them, and what that says of the others.
#[test]
fn what_is_gathered_agrees_with_its_reference() {
    for origin in [DVec3::ZERO, FAR] {
        let (renderer, _, expected, _) = rendered(origin);
        let found = renderer.infer_pass().last_cells().expect("a frame");
        let (rays, diffused) = (texels(found.rays), texels(found.diffused));
        let (mut known, mut partly) = (0, 0);
        for cell in cells(expected.grid.cells) {
            let [x, y, z, share] = rays.at(cell).map(f64::from);
            let gathered = expected.gathered.at(cell);
            let off = DVec3::new(x, y, z).distance(gathered.direction);
            assert!(off < CELL_DIRECTION, "{cell}: {off}");
            assert_eq!(share, gathered.share, "{cell}");
            let off = f64::from(diffused.at(cell)[0]) / expected.diffused.at(cell) - 1.0;
            assert!(off.abs() < DIFFUSION_RELATIVE, "{cell}: {off}");
            known += u32::from(share > 0.5);
            partly += u32::from(share > 0.0 && share < 1.0);
        }
        assert!(known > 500 && partly > 50, "{known} {partly}");
    }
}

/// What each rig shows at each hypothesis of each cell.
#[test]
fn sights_agree_with_their_reference() {
    for origin in [DVec3::ZERO, FAR] {
        let (renderer, _, hypotheses, expected) = rendered(origin);
        let found = sights_on_device(&renderer, &hypotheses);
        let (mut all, mut seen, mut alike) = (0, 0, 0);
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            for (found, expected) in found.values.iter().zip(&expected.values) {
                all += 1;
                alike += match (found, expected) {
                    (Some(found), Some(expected)) => {
                        seen += 1;
                        u32::from((found - expected).abs() < SIGHT_BRIGHTNESS)
                    }
                    (found, expected) => u32::from(found.is_some() == expected.is_some()),
                }
            }
        }
        println!("{alike} of {all} alike, {seen} seen");
        assert!(f64::from(alike) > SIGHT_SHARE * f64::from(all), "{alike} of {all}");
        assert!(seen > all / 3, "{seen} of {all}");
    }
}

/// From what the device's photographs show: where every cell is, as far as costs that are rounded
/// leave it open, and exactly there where they do not.
#[test]
fn what_settles_agrees_with_its_reference() {
    for origin in [DVec3::ZERO, FAR] {
        let (renderer, _, hypotheses, _) = rendered(origin);
        let sights = sights_on_device(&renderer, &hypotheses);
        let expected = hypotheses.inferred(&sights, None, COST_ROUNDING);
        let found = texels(renderer.infer_pass().last_cells().expect("a frame").settled);
        let (mut judged, mut decided) = (0, 0);
        for cell in cells(hypotheses.grid.cells) {
            let found = f64::from(found.at(cell)[0]);
            let [a, b] = expected.bounds.each_ref().map(|bound| bound.at(cell));
            let (low, high) = (a.min(b), a.max(b));
            let outside = (low - found).max(found - high) / found;
            assert!(outside < SETTLED_RELATIVE, "{cell}: {found}, not from {low} to {high}");
            if !hypotheses.is_known(cell) {
                judged += 1;
                decided += u32::from(high - low < DOUBT * low);
            }
        }
        println!("{decided} of {judged} decided");
        assert!(judged > 1500 && decided > judged * 6 / 10, "{decided} of {judged}");
    }
}

/// A picture that follows another: what settled there has a say, wherever rounding does not decide which
/// of its cells a hypothesis falls into.
#[test]
fn what_the_picture_before_says_agrees_with_its_reference() {
    let (mut renderer, scene, before, _) = rendered(FAR);
    let settled = texels(renderer.infer_pass().last_cells().expect("a frame").settled);
    let past = Past {
        camera: view(FAR).camera,
        step: before.grid.step.into(),
        settled: settled.each(|[inverse, ..]| f64::from(*inverse)),
    };
    let view = View::from(camera(FAR, [-0.75, 0.58, 1.83], 90.0, 7.0, 60.0, SIZE));
    renderer.render(&view).expect("a frame");
    let (hypotheses, _) = scene.inference(&view).expect("a grid");
    let size = hypotheses.grid.cells;
    let is_clear = |index: u32, cell: UVec2| {
        let place = hypotheses.eye + hypotheses.place(index, cell);
        let pixel = past.camera.project(place).map_or(DVec2::splat(0.5), |(pixel, _)| pixel);
        let cells = pixel / past.step;
        (cells - cells.round()).abs().min_element() * past.step > LENS_PX
    };
    let clear = Field::new(size, |cell| {
        hypotheses.is_known(cell) || (0..hypotheses.grid.hypotheses).all(|i| is_clear(i, cell))
    });
    let sights = sights_on_device(&renderer, &hypotheses);
    let expected = hypotheses.inferred(&sights, Some(&past), COST_ROUNDING);
    let alone = hypotheses.inferred(&sights, None, COST_ROUNDING);
    let found = texels(renderer.infer_pass().last_cells().expect("a frame").settled);
    let (mut compared, mut decided_by_past) = (0, 0);
    for cell in cells(size - 2).map(|cell| cell + 1) {
        if hypotheses.is_known(cell) || !cells(UVec2::splat(3)).all(|o| clear.at(cell + o - 1)) {
            continue;
        }
        compared += 1;
        let found = f64::from(found.at(cell)[0]);
        let outside = |inferred: &Inferred| {
            let [a, b] = inferred.bounds.each_ref().map(|bound| bound.at(cell));
            (a.min(b) - found).max(found - a.max(b)) / found
        };
        assert!(outside(&expected) < SETTLED_RELATIVE, "{cell}: {found}");
        decided_by_past += u32::from(outside(&alone) > SETTLED_RELATIVE);
    }
    println!("{compared} cells, {decided_by_past} other than without the past");
    assert!(compared > 500 && decided_by_past > 50, "{compared} {decided_by_past}");
}

/// From where the device's cells are: where every pixel is, through each model of lens.
#[test]
fn what_is_filled_agrees_with_its_reference() {
    let straight = [(DVec3::ZERO, Distortion::None), (FAR, Distortion::None)];
    for (origin, distortion) in straight.into_iter().chain(DISTORTIONS.map(|bent| (FAR, bent))) {
        let pinhole = view(origin).camera;
        let lens = Lens { distortion, ..pinhole.lens };
        let view = View::from(with_lens(pinhole, lens));
        let (renderer, scene, hypotheses, _) = rendered_as(origin, &view);
        let settled = texels(renderer.infer_pass().last_cells().expect("a frame").settled);
        let settled = settled.each(|[inverse, ..]| f64::from(*inverse));
        let mesh = Triangles::new(scene.mesh.values());
        let shown = surfaces::shown(&view, Mode::Hybrid, &mesh, &[]);
        let places = positions(renderer.last_positions().expect("a frame"), SIZE);
        let bent = distortion != Distortion::None;
        let allowed = FILLED_RELATIVE + if bent { LENS_PX / lens.intrinsics.fx } else { 0.0 };
        let (mut inferred, mut worst) = (0, 0f64);
        for (at, place) in cells(SIZE).zip(places) {
            // What shows nothing else; through a lens rounding decides at an edge.
            let around =
                |aside: UVec2| (at + aside).saturating_sub(UVec2::ONE).min(SIZE - UVec2::ONE);
            let shows = |at| shown.at(at).met.is_some();
            if shows(at) || bent && cells(UVec2::splat(3)).any(|aside| shows(around(aside))) {
                continue;
            }
            inferred += 1;
            let pixel = at.as_dvec2() + 0.5;
            let ray = view.camera.lens.unproject(pixel).expect("a ray");
            let direction = (view.camera.cam_from_world.transpose() * ray).normalize();
            let inverse = settled.between(pixel / f64::from(hypotheses.grid.step));
            let off = place.expect("a place").distance(direction / inverse) * inverse;
            assert!(off < allowed, "{distortion:?} {at}: {off}");
            worst = worst.max(off);
        }
        println!("{distortion:?}: {inferred} pixels within {worst:.1e}");
        assert!(inferred > 20_000, "{inferred}");
    }
}

#[test]
fn frames_with_inference() {
    let cases = [
        (DVec3::ZERO, Mode::Hybrid),
        (DVec3::ZERO, Mode::Sources),
        (DVec3::ZERO, Mode::Uncertainty),
        (FAR, Mode::Hybrid),
    ];
    for (origin, mode) in cases {
        let (frame, _, reference) = both(&updates(origin), &view(origin), mode, inferring());
        keep_both(&frame, &reference, &format!("inferred-{mode:?}"));
        let difference = reference.difference(&frame);
        let inferred = |i: &usize| reference.pixels[*i].surface == Surface::Inferred;
        let inferred: Vec<usize> = (0..reference.pixels.len()).filter(inferred).collect();
        let is_alike = |i: &&usize| {
            let bytes = frame.rgba[4 * **i..4 * **i + 3].iter().map(|b| f64::from(*b));
            let exact = (reference.pixels[**i].rgb * 255.0).round().to_array();
            bytes.zip(exact).all(|(found, exact)| (found - exact).abs() <= 1.0)
        };
        let alike = inferred.iter().filter(is_alike).count();
        println!("{mode:?}: {alike} of {} inferred alike, {difference:?}", inferred.len());
        assert!(inferred.len() > 25_000 && difference.compared > 25_000, "{difference:?}");
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert!(difference.same_surface >= FRAME_ALIKE_SHARE, "{difference:?}");
        assert!(alike as f64 > INFERRED_ALIKE_SHARE * inferred.len() as f64, "{alike}");
    }
}
