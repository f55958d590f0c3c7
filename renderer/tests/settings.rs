//! Settings that change between frames.

mod common;

use common::*;
use flaneur_renderer::{Frame, Renderer, Settings, SplatRoute, Texturing};
use flaneur_scene::{NodeKey, SceneUpdate, View};
use glam::{DVec3, UVec2};

fn view() -> View {
    let size = UVec2::new(160, 120);
    camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, size).into()
}

/// The wall and the pole as points of two levels, the ground as mesh, two photographs.
fn scene() -> Vec<SceneUpdate> {
    let street = Street::with_pole(DVec3::ZERO);
    let mut fine = street.points(&[0, 1], 0.06);
    let mut coarse = fine.clone();
    coarse.positions = fine.positions.iter().step_by(9).copied().collect();
    coarse.spacing_m = 0.18;
    fine.id.key = NodeKey { level: 1, x: 0, y: 1, z: 0 };
    let photograph = |id, at| {
        let camera = camera(street.origin, at, 90.0, 5.0, 70.0, UVec2::new(320, 240));
        image_update(street.photograph(id, camera))
    };
    vec![
        mesh_update(street.mesh(&[2, 3], 0.1)),
        photograph("a/x", [-1.0, -2.0, 2.0]),
        photograph("b/x", [-1.0, 3.0, 2.0]),
        points_update(coarse),
        points_update(fine),
    ]
}

fn frame(renderer: &mut Renderer) -> Frame {
    renderer.render(&view()).expect("a frame")
}

/// Whatever the settings were before, the frame is that of a renderer that never had others.
#[test]
fn changed_settings_leave_no_trace() {
    let base = Settings::default();
    let all = [
        Settings { rigs: 1, ..base },
        Settings { depth_map_side: 128, ..base },
        Settings { refine_by_points: false, ..base },
        Settings { splat_route: SplatRoute::Atomic32, ..base },
        Settings { points_share: 0.5, ..base },
        Settings { resolution: 0.5, ..base },
        Settings { texturing: Texturing::Homography, ..base },
        Settings { exposure_gains: false, infer: false, ..base },
        base,
    ];
    let mut changed = renderer(base, scene());
    for settings in all {
        assert!(changed.set_settings(settings));
        changed.cut();
        assert_eq!(changed.settings(), settings);
        let expected = frame(&mut renderer(settings, scene()));
        assert!(frame(&mut changed) == expected, "{settings:?}");
    }
    // Points came with radii that other settings would have made others.
    assert!(!changed.set_settings(Settings { splat_scale: 1.0, ..base }));
    assert_eq!(changed.settings(), base);
}

/// Fewer points are drawn, and coarser ones close what those that are left out leave open.
#[test]
fn a_frame_of_fewer_points_has_no_holes() {
    let mut renderer = renderer(Settings::default(), scene());
    let whole = frame(&mut renderer);
    let all = whole.stats.points_drawn;
    for part in [0.9, 0.5, 0.25] {
        let most = (all as f64 * part) as u64;
        let settings = Settings { points_share: part as f32, ..Settings::default() };
        assert!(renderer.set_settings(settings));
        let thinned = frame(&mut renderer);
        let drawn = thinned.stats.points_drawn;
        assert!(drawn <= most + 1 && drawn + 512 > most, "{drawn} of {most}");
        let lost = whole.surfaces.iter().zip(&thinned.surfaces);
        let lost = lost.filter(|(a, b)| a.is_geometry() && !b.is_geometry()).count();
        assert!(lost * 200 <= whole.surfaces.len(), "{part}: {lost} pixels lost");
    }
    assert!(renderer.set_settings(Settings { points_share: 0.0, ..Settings::default() }));
    assert_eq!(frame(&mut renderer).stats.points_drawn, 0);
}

#[test]
fn a_smaller_picture_is_enlarged() {
    let settings = Settings { resolution: 0.5, ..Settings::default() };
    let mut renderer = renderer(settings, scene());
    let enlarged = frame(&mut renderer);
    assert_eq!(enlarged.size, view().size());
    assert_eq!(renderer.last_depths().expect("depths").len(), 80 * 60);
    assert!(renderer.set_settings(Settings::default()));
    let whole = frame(&mut renderer);
    let off = |a: &u8, b: &u8| f64::from(a.abs_diff(*b));
    let mean = enlarged.rgba.iter().zip(&whole.rgba).map(|(a, b)| off(a, b)).sum::<f64>()
        / whole.rgba.len() as f64;
    assert!(mean > 0.0 && mean < tolerances::ENLARGED_MEAN_255, "{mean}");
}

/// The wall stands 6.8 m east of the eye and 2 m behind its edge, whatever the settings.
#[test]
fn depths_are_those_of_the_street() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(Settings::default(), vec![mesh_update(street.mesh(&[0, 3], 0.0))]);
    assert!(renderer.last_depths().expect("none yet").is_empty());
    frame(&mut renderer);
    let camera = view().camera;
    let truth = street.picture(&camera);
    let depths = renderer.last_depths().expect("depths");
    let mut compared = 0;
    for (index, (depth, hit)) in depths.iter().zip(&truth).enumerate() {
        let (Some(depth), Some((hit, _))) = (depth, hit) else { continue };
        if hit.object != 1 && hit.object != 2 && is_interior(&truth, view().size(), index, 2) {
            let exact = camera.forward().dot(street.origin + hit.position - camera.centre);
            assert!((f64::from(*depth) - exact).abs() < tolerances::DEPTH_M, "{depth} {exact}");
            compared += 1;
        }
    }
    assert!(compared > 5000, "{compared}");
}
