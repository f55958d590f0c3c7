//! Where one stands at first: the web page begins at the same places.

use std::f64::consts::TAU;
use std::sync::Arc;

use flaneur_scene::{Region, SceneInfo, SceneUpdate, heading_pitch_roll, triangulate_ground};
use flaneur_streamer::Client;
use glam::DVec2;

use super::buildings::{Buildings, Walls};
use super::ground::Ground;
use super::opened::nearest;
use super::pose::Pose;
use super::surroundings::SURROUNDINGS_M;
use super::visitor::EYE_HEIGHT;
use crate::exit::Exit;
use crate::source::stream_exit;

/// The terrain under one's feet is asked for so far around, metres.
const FEET_M: f64 = 5.0;
/// An open place is looked for so far, and a view is no farther, metres.
const FARTHEST_M: f64 = 100.0;
/// An open place has no house within so many metres, where there is one; less where it is narrow.
const CLEARANCES: [f64; 3] = [8.0, 4.0, 2.0];

/// At the photograph nearest to the scene's middle, looking as its vehicle did. Without photographs in
/// the open nearest to the middle, along the street.
pub(super) async fn start(client: &Client, info: &SceneInfo, fov_y: f64) -> Result<Pose, Exit> {
    let middle = info.origin.truncate();
    if info.panoramas > 0
        && let Some((panorama, centre)) = nearest(client, middle).await?
    {
        let [heading, ..] = heading_pitch_roll(&panorama.world_from_rig);
        return Ok(Pose::new(centre, heading, 0.0, fov_y));
    }
    let buildings = Buildings::around(client, middle, SURROUNDINGS_M).await?;
    let place = open(middle, &buildings);
    let feet = Region::Disc { centre: place, radius_m: FEET_M };
    let mut ground = Ground::default();
    for tile in client.terrain(feet).await.map_err(stream_exit)? {
        ground.note(&SceneUpdate::Mesh(Arc::new(triangulate_ground(&tile))));
    }
    let bounds = info.bounds;
    let lowest = if bounds.is_empty() { info.origin.z } else { bounds.min.z };
    let height = ground.height(place).unwrap_or(lowest);
    let heading = farthest_view(place, &buildings);
    Ok(Pose::new(place.extend(height + EYE_HEIGHT), heading, 0.0, fov_y))
}

/// The place nearest to the middle, on growing rings, that is well away from any house; where it is
/// narrow, nearer to them; the middle where all is built up.
fn open(middle: DVec2, walls: &impl Walls) -> DVec2 {
    let radii = || (0..).map(|step| 4.0 * f64::from(step)).take_while(|r| *r <= FARTHEST_M);
    let found = CLEARANCES.into_iter().find_map(|clearance| {
        let is_clear = |place: &DVec2| {
            let mut around = ring(*place, clearance, 12);
            !walls.contain(*place) && !around.any(|place| walls.contain(place))
        };
        radii().find_map(|radius| ring(middle, radius, (1.5 * radius) as u32).find(is_clear))
    });
    found.unwrap_or(middle)
}

/// The heading, radians, in which one sees farthest between the houses, the first of equals; north
/// where nothing is built.
fn farthest_view(from: DVec2, walls: &impl Walls) -> f64 {
    let mut best = (0.0, -1.0);
    for step in 0..36 {
        let heading = f64::from(step) * TAU / 36.0;
        let direction = DVec2::new(heading.sin(), heading.cos());
        let mut metres = 0.0;
        while metres < FARTHEST_M && !walls.contain(from + direction * metres) {
            metres += 2.0;
        }
        // Where nothing is built there is nothing to see.
        if metres < FARTHEST_M && metres > best.1 {
            best = (heading, metres);
        }
    }
    best.0
}

/// Places on a circle, from north clockwise: at least one.
fn ring(centre: DVec2, radius: f64, count: u32) -> impl Iterator<Item = DVec2> {
    let count = count.max(1);
    (0..count).map(move |index| {
        let (sin, cos) = (TAU * f64::from(index) / f64::from(count)).sin_cos();
        centre + radius * DVec2::new(sin, cos)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    impl<F: Fn(DVec2) -> bool> Walls for F {
        fn contain(&self, place: DVec2) -> bool {
            self(place)
        }
    }

    /// A street from west to east, 20 m wide, with its end 40 m to the east and 60 m to the west.
    fn street(place: DVec2) -> bool {
        (place.y - 30.0).abs() > 10.0 || place.x > 40.0 || place.x < -60.0
    }

    #[test]
    fn one_begins_in_the_open_near_the_middle() {
        let place = open(DVec2::ZERO, &street);
        assert!((place.y - 30.0).abs() <= 2.0 && place.length() < 36.0, "{place}");
        let anywhere = DVec2::new(5.0, 31.0);
        assert_eq!(open(anywhere, &|_: DVec2| false), anywhere);
        // Nearer to the walls where it is narrow, and in the middle where all is built up.
        let alley = open(DVec2::ZERO, &|place: DVec2| (place.x - 8.0).abs() > 3.0);
        assert!((alley.x - 8.0).abs() <= 1.0, "{alley}");
        assert_eq!(open(anywhere, &|_: DVec2| true), anywhere);
    }

    #[test]
    fn one_looks_along_the_street() {
        let looks = |x: f64| farthest_view(DVec2::new(x, 30.0), &street).to_degrees();
        assert!((looks(0.0) - 270.0).abs() < 1e-9 && (looks(-50.0) - 90.0).abs() < 1e-9);
        assert_eq!(farthest_view(DVec2::ZERO, &|_: DVec2| false), 0.0);
    }
}
