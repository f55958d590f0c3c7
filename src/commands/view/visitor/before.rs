//! Where one stands to look at a wall.

use glam::DVec2;

use crate::commands::view::ground::Ground;
use crate::commands::view::place::Place;
use crate::commands::view::pose::Pose;

/// How near one stands before a wall, and how far off at most, metres: farther off one would stand in
/// the houses across the street.
const BEFORE_WALL: [f64; 2] = [3.0, 10.0];
/// Farther away one turns to a wall, and stays, metres.
const REACH: f64 = 30.0;
/// One does not crane one's neck further, radians.
const NECK: f64 = std::f64::consts::FRAC_PI_6;

/// In front of a wall's place, looking straight at it, as high above the ground as now. What is far, or
/// lies flat, is looked at from where one stands.
pub(super) fn before(place: &Place, pose: Pose, ground: &Ground) -> Pose {
    let (at, out) = (place.position.truncate(), place.normal.truncate());
    let facing = |pose: Pose| {
        let turned = pose.facing(place.position);
        Pose { pitch: turned.pitch.clamp(-NECK, NECK), ..turned }
    };
    let far = at.distance(pose.eye.truncate()) > REACH;
    let Some(out) = out.try_normalize().filter(|_| out.length() >= 0.1 && !far) else {
        return facing(pose);
    };
    let off = (pose.eye.truncate() - at).dot(out).clamp(BEFORE_WALL[0], BEFORE_WALL[1]);
    let there = at + out * off;
    let height = |place: DVec2| ground.height(place);
    let rise = height(there).zip(height(pose.eye.truncate())).map_or(0.0, |(to, from)| to - from);
    facing(pose.at(there.extend(pose.eye.z + rise)))
}
