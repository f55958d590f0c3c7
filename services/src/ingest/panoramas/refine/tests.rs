//! A drive down a street of noise, ray-traced: with poses that are off, and with poses that are not.

use flaneur_scene::{Intrinsics, Lens};
use glam::{DMat3, DVec2, DVec3, UVec2};
use image::RgbImage;

use super::*;

const SIZE: UVec2 = UVec2::new(480, 300);
/// Far from zero, as surveys are.
const ORIGIN: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 40.0);
/// Rig axes (right, forward, up) as camera axes.
const CAM_FROM_RIG: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

/// A photograph every metre along y; each other one of a second camera beside the first.
fn drive(folder: &std::path::Path) -> Vec<Draft> {
    let lens = Lens::pinhole(SIZE, Intrinsics::from_fov_y(0.9, SIZE));
    (0..16u32)
        .map(|index| {
            let (along, side) = (f64::from(index / 2), 0.5 * f64::from(index % 2));
            let position = ORIGIN + DVec3::new(side, along, 2.0);
            let world_from_rig = DMat3::from_rotation_z(0.02 * (0.7 * along).sin());
            let image = folder.join(format!("{index}.png"));
            photograph(position, CAM_FROM_RIG * world_from_rig.transpose(), lens)
                .save(&image)
                .expect("a file");
            Draft {
                id: index.to_string(),
                position,
                world_from_rig,
                time: None,
                uncertainty_m: 0.0,
                cameras: vec![DraftCamera {
                    id: "a".into(),
                    position_in_rig: DVec3::ZERO,
                    cam_from_rig: CAM_FROM_RIG,
                    lens: DraftLens::Calibrated(lens),
                    image,
                    mask: None,
                }],
                file: "poses".into(),
                place: String::new(),
            }
        })
        .collect()
}

/// What a camera sees of a street 12 m wide and 40 m long.
fn photograph(centre: DVec3, cam_from_world: DMat3, lens: Lens) -> RgbImage {
    RgbImage::from_fn(SIZE.x, SIZE.y, |x, y| {
        let mut sum = 0.0;
        for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let pixel = DVec2::new(f64::from(x) + dx, f64::from(y) + dy);
            let ray = cam_from_world.transpose() * lens.unproject(pixel).expect("a pinhole");
            let eye = centre - ORIGIN;
            // Walls, ground, the end of the street.
            let planes = [
                ((6.0 * ray.x.signum() - eye.x) / ray.x, [1, 2]),
                (-eye.z / ray.z, [0, 1]),
                ((40.0 - eye.y) / ray.y, [0, 2]),
            ];
            let met = planes.iter().enumerate().filter(|(_, (t, _))| *t > 0.0);
            let (plane, (t, axes)) =
                met.min_by(|a, b| a.1.0.total_cmp(&b.1.0)).expect("the end is ahead");
            let place = eye + *t * ray;
            sum += brightness(plane as i64, place[axes[0]], place[axes[1]]);
        }
        let value = (sum / 4.0) as u8;
        image::Rgb([value; 3])
    })
}

/// Tiles of three sizes, each of its own shade.
fn brightness(plane: i64, u: f64, v: f64) -> f64 {
    let tile = |size: f64| {
        let (i, j) = ((u / size).floor() as i64, (v / size).floor() as i64);
        let mut hash = (i.wrapping_mul(73_856_093) ^ j.wrapping_mul(19_349_663) ^ plane) as u64;
        hash = (hash ^ (hash >> 13)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (hash >> 40) as f64 / f64::from(1 << 24)
    };
    255.0 * (0.4 * tile(0.23) + 0.3 * tile(0.61) + 0.3 * tile(1.9))
}

/// Each pose's errors against the truth after the turn and the shift that all have in common, which
/// photographs cannot tell: metres and radians.
fn errors(found: &[Draft], truth: &[Draft]) -> (f64, f64) {
    let turns =
        found.iter().zip(truth).map(|(f, t)| t.world_from_rig * f.world_from_rig.transpose());
    let first = turns.clone().next().expect("a panorama");
    let middle = |drafts: &[Draft]| {
        drafts.iter().map(|d| d.position - ORIGIN).sum::<DVec3>() / drafts.len() as f64
    };
    let (mf, mt) = (middle(found), middle(truth));
    let metres = found
        .iter()
        .zip(truth)
        .map(|(f, t)| (first * (f.position - ORIGIN - mf)).distance(t.position - ORIGIN - mt));
    let angle = |turn: DMat3| glam::DQuat::from_mat3(&(turn * first.transpose())).to_scaled_axis();
    let radians = turns.map(|turn| angle(turn).length());
    (metres.fold(0.0, f64::max), radians.fold(0.0, f64::max))
}

#[test]
fn poses_that_are_off_are_found_and_right_ones_stay() {
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job::new(folder.path(), 1 << 30);
    let truth = drive(folder.path());

    let mut right = truth.clone();
    assert_eq!(refine(&job, &mut right).expect("photographs"), []);
    for (draft, truth) in right.iter().zip(&truth) {
        assert_eq!((draft.position, draft.world_from_rig), (truth.position, truth.world_from_rig));
    }

    // A boresight, a wander, and what differs from one photograph to the next.
    let mut off = truth.clone();
    for (index, draft) in off.iter_mut().enumerate() {
        let t = index as f64;
        let jitter = DVec3::new((2.1 * t).sin(), (3.7 * t).cos(), (5.3 * t).sin());
        draft.position += 0.04 * jitter;
        draft.world_from_rig = DMat3::from_rotation_z(0.025)
            * DMat3::from_rotation_x(0.006 * (1.3 * t).sin())
            * draft.world_from_rig;
    }
    let delivered = off.clone();
    let (before_m, before_rad) = errors(&off, &truth);
    let poses = refine(&job, &mut off).expect("photographs");
    let (after_m, after_rad) = errors(&off, &truth);
    println!("from {before_m:.4} m, {before_rad:.5} to {after_m:.4} m, {after_rad:.5}");
    assert!(before_m > 0.04 && before_rad > 0.005, "{before_m} {before_rad}");
    assert!(after_m < 0.01, "{after_m} m instead of {before_m}");
    assert!(after_rad < 0.001, "{after_rad} instead of {before_rad}");
    // What was delivered stays known.
    assert_eq!(poses.len(), delivered.len());
    for ((pose, delivered), draft) in poses.iter().zip(&delivered).zip(&off) {
        assert_eq!((&pose.panorama, pose.position), (&delivered.id, delivered.position));
        assert!((pose.position + pose.shift_m).distance(draft.position) < 1e-9);
    }
}

/// Errors beyond what can be believed are a fault of something else.
#[test]
fn absurd_corrections_and_small_gains_are_told_from_those_to_make() {
    let prior = Prior { shift_m: 0.1, turn_rad: 0.05 };
    let camera = Camera {
        panorama: 0,
        lever: DVec3::ZERO,
        cam_from_world: DMat3::IDENTITY,
        focal_px: 500.0,
    };
    let sightings = |count: usize| (0..count).map(|i| vec![(0, DVec2::splat(0.001 * i as f64))]);
    let of = |count, shift: f64| {
        let (places, priors) = (vec![DVec3::ZERO], vec![prior]);
        let mut all = Adjustment::new(places, priors, vec![camera], sightings(count));
        all.corrections[0].shift.x = shift;
        all
    };
    assert_eq!(verdict(&of(59, 0.1), 2.0, 0.5), Verdict::Unknown);
    assert_eq!(verdict(&of(60, 0.1), 2.0, 0.5), Verdict::Off);
    assert_eq!(verdict(&of(60, 0.1), 2.0, 1.9), Verdict::Right);
    assert_eq!(verdict(&of(60, 0.1), 0.4, 0.1), Verdict::Right);
    assert_eq!(verdict(&of(60, 0.6), 2.0, 0.5), Verdict::Absurd { metres: 0.6, degrees: 0.0 });
}
