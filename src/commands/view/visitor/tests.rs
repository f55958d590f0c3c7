//! What a visitor does, second by second.

use std::sync::Arc;
use std::time::Duration;

use flaneur_scene::{GroundTile, SceneUpdate, triangulate_ground};

use super::*;

const EYE: DVec3 = DVec3::new(651_010.0, 6_861_010.0, 41.7);

/// Nothing is built.
const NOTHING_BUILT: Built = Built { east_of: f64::INFINITY };

/// All is built up east of some place.
struct Built {
    east_of: f64,
}

impl Walls for Built {
    fn contain(&self, place: DVec2) -> bool {
        place.x > self.east_of
    }
}

/// Ground that rises by a tenth to the east, at 40 m under [`EYE`].
fn slope() -> Ground {
    let heights = (0..400).map(|index| 40.0 + 0.1 * ((index % 20) as f32 * 5.0 - 10.0));
    let tile = GroundTile {
        index: (0, 0),
        origin: DVec2::new(651_000.0, 6_861_000.0),
        spacing_m: 5.0,
        columns: 20,
        heights: heights.collect(),
        uncertainty_m: 0.1,
    };
    let mut ground = Ground::default();
    ground.note(&SceneUpdate::Mesh(Arc::new(triangulate_ground(&tile))));
    ground
}

/// A visitor who looks east, and the time.
fn visitor() -> (Visitor, Instant) {
    let now = Instant::now();
    (Visitor::new(Pose::new(EYE, 90f64.to_radians(), 0.0, 1.0), now), now)
}

/// Time passes at 60 frames a second; when it is then, and whether they moved in the end.
fn pass(visitor: &mut Visitor, from: Instant, ms: u64, ground: &Ground) -> (Instant, bool) {
    let (mut now, end) = (from, from + Duration::from_millis(ms));
    let mut moves = false;
    while now < end {
        now = (now + Duration::from_millis(16)).min(end);
        moves = visitor.advance(now, ground, &NOTHING_BUILT);
    }
    (now, moves)
}

#[test]
fn eyes_keep_their_height_above_the_ground() {
    let (mut visitor, now) = visitor();
    let ground = slope();
    let (now, moves) = pass(&mut visitor, now, 50, &ground);
    assert!(!moves && visitor.pose().eye == EYE, "who does nothing stays");
    visitor.press(Step::Ahead, now);
    let (now, moves) = pass(&mut visitor, now, 2000, &ground);
    assert!(moves);
    visitor.release(Step::Ahead);
    let (_, moves) = pass(&mut visitor, now, 2000, &ground);
    let walked = visitor.pose().eye - EYE;
    assert!(!moves && (walked.x - 2.0 * SPEED).abs() < 0.1 && walked.y.abs() < 1e-6, "{walked}");
    assert!((walked.z - 0.1 * walked.x).abs() < 1e-4, "{walked}");
}

#[test]
fn who_walks_ends_before_a_wall_and_who_flies_goes_over_it() {
    let ground = slope();
    let wall = Built { east_of: EYE.x + 4.0 };
    let walk = |above: f64| {
        let (mut visitor, mut now) = visitor();
        visitor.pose.eye.z += above;
        visitor.press(Step::Ahead, now);
        for _ in 0..300 {
            now += Duration::from_millis(16);
            visitor.advance(now, &ground, &wall);
        }
        visitor.pose().eye - EYE
    };
    let walked = walk(0.0);
    assert!((2.5..4.0).contains(&walked.x) && walked.y.abs() < 2.0, "{walked}");
    assert!(walk(50.0).x > 12.0);
}

#[test]
fn who_flies_stays_at_their_height() {
    let (mut visitor, now) = visitor();
    visitor.pose.eye.z += 50.0;
    visitor.press(Step::Right, now);
    pass(&mut visitor, now, 1000, &slope());
    let moved = visitor.pose().eye - EYE;
    assert!(moved.z == 50.0 && (moved.y + SPEED).abs() < 0.1, "south is right of east: {moved}");
}

#[test]
fn a_click_on_the_ground_goes_there_and_one_on_a_wall_faces_it() {
    let (mut visitor, now) = visitor();
    let ground = slope();
    let (now, _) = pass(&mut visitor, now, 50, &ground);
    let place = Place::on(DVec3::Z, DVec3::new(651_030.0, 6_861_020.0, 42.0));
    visitor.go_to(&place, now, &ground);
    assert!(visitor.destination().is_some());
    let (now, moves) = pass(&mut visitor, now, 400, &ground);
    assert!(!moves && visitor.pose().eye.distance(place.position + DVec3::Z * 1.6) < 1e-3);
    assert!((visitor.pose().heading - 90f64.to_radians()).abs() < 1e-9, "one looks on as before");

    // A wall that looks south, nine metres to the north, four to the east, and three up.
    let above = visitor.pose().eye + DVec3::new(4.0, 9.0, 3.0);
    let wall = Place::on(DVec3::NEG_Y, above);
    visitor.go_to(&wall, now, &ground);
    let (now, _) = pass(&mut visitor, now, 500, &ground);
    let pose = visitor.pose();
    let off = above - pose.eye;
    assert!(off.x.abs() < 1e-9 && (off.y - 9.0).abs() < 1e-9, "{off}");
    assert!((off.z - 2.6).abs() < 1e-3, "four metres on the ground has risen by 0.4: {off}");
    assert!(pose.heading.sin().abs() < 1e-9 && pose.heading.cos() > 0.0);
    assert!((pose.pitch - off.z.atan2(9.0)).abs() < 1e-3);

    // One that is far is looked at, as high as a neck goes, and so is a roof.
    let tower = Place::on(DVec3::NEG_X, pose.eye + DVec3::new(40.0, 0.0, 90.0));
    visitor.go_to(&tower, now, &ground);
    let (now, _) = pass(&mut visitor, now, 500, &ground);
    assert_eq!(visitor.pose().eye, pose.eye);
    assert!((visitor.pose().pitch - 30f64.to_radians()).abs() < 1e-9);
    let roof = Place::on(DVec3::Z, pose.eye + DVec3::new(5.0, 0.0, 5.0));
    visitor.go_to(&roof, now, &ground);
    pass(&mut visitor, now, 500, &ground);
    assert!((visitor.pose().pitch - 45f64.to_radians()).abs() < 1e-9);
}

#[test]
fn a_photograph_is_seen_from_where_it_was_taken() {
    let (mut visitor, now) = visitor();
    let ground = slope();
    let place = Place::on(DVec3::Z, DVec3::new(651_030.0, 6_861_020.0, 42.0));
    visitor.go_to(&place, now, &ground);
    let camera = place.position + DVec3::new(1.0, 0.0, 3.1);
    visitor.go(visitor.pose().at(camera), now + Duration::from_millis(50));
    let (now, _) = pass(&mut visitor, now, 2000, &ground);
    assert_eq!(visitor.pose().eye, camera, "not from as low as one was on the way to");
    visitor.press(Step::TiltDown, now);
    let (now, _) = pass(&mut visitor, now, 500, &ground);
    assert!(visitor.pose().pitch < -0.5);
    visitor.release_all();
    visitor.level(now);
    pass(&mut visitor, now, 500, &ground);
    assert!(visitor.pose().pitch == 0.0 && visitor.pose().eye == camera);
}

#[test]
fn what_is_dragged_stays_under_the_pointer() {
    let (mut visitor, now) = visitor();
    let size = UVec2::new(800, 600);
    let (from, to) = (DVec2::new(300.0, 300.0), DVec2::new(500.0, 380.0));
    let held = visitor.pose().view(size).ray(from).expect("a ray");
    let steps = 40;
    for step in 0..steps {
        let at = |step: i32| from.lerp(to, f64::from(step) / f64::from(steps));
        visitor.drag(at(step), at(step + 1), size);
    }
    let view = visitor.pose().view(size);
    let (pixel, _) = view.camera.project(held.origin + held.direction * 50.0).expect("ahead");
    assert!(pixel.distance(to) < 12.0, "{pixel}");
    // So does what one zooms in on.
    let held = visitor.pose().view(size).ray(to).expect("a ray");
    visitor.zoom(1.5, to, size);
    let view = visitor.pose().view(size);
    let (pixel, _) = view.camera.project(held.origin + held.direction * 50.0).expect("ahead");
    assert!(pixel.distance(to) < 4.0 && visitor.pose().fov_y < 0.7, "{pixel}");
    visitor.go(visitor.pose().turned(1.0, 0.0), now);
    visitor.press(Step::TurnLeft, now);
    assert!(visitor.glide.is_none(), "a key ends a glide");
}

#[test]
fn turning_takes_the_time_it_takes() {
    let (mut visitor, now) = visitor();
    visitor.press(Step::TurnRight, now);
    pass(&mut visitor, now, 1000, &Ground::default());
    let turned = visitor.pose().heading - 90f64.to_radians();
    // The view is narrower than others.
    let slower = TURN / WIDE;
    assert!((turned - slower).abs() < 1e-6, "{turned}");
    visitor.release_all();
    assert!(!pass(&mut visitor, now + Duration::from_secs(1), 100, &Ground::default()).1);
}
