//! Where houses stand, in plan.

use flaneur_scene::{Bounds2, Footprint, Polygon, Region};
use flaneur_streamer::Client;
use glam::DVec2;

use crate::exit::Exit;
use crate::source::stream_exit;

/// What has an inside.
pub(super) trait Walls {
    /// Whether a place, world, metres, is inside.
    fn contain(&self, place: DVec2) -> bool;
}

/// The footprints around a place.
#[derive(Debug, Default)]
pub(super) struct Buildings {
    footprints: Vec<(Bounds2, Vec<Polygon>)>,
}

impl Buildings {
    /// Those within `radius_m` of a place.
    pub(super) async fn around(
        client: &Client,
        centre: DVec2,
        radius_m: f64,
    ) -> Result<Self, Exit> {
        let region = Region::Disc { centre, radius_m };
        let footprints = client.buildings(region).await.map_err(stream_exit)?;
        Ok(Self::of(footprints))
    }

    fn of(footprints: Vec<Footprint>) -> Self {
        let with_bounds = |one: Footprint| (one.bounds(), one.polygons);
        Self { footprints: footprints.into_iter().map(with_bounds).collect() }
    }
}

impl Walls for Buildings {
    fn contain(&self, place: DVec2) -> bool {
        let near = self.footprints.iter().filter(|(bounds, _)| bounds.distance(place) <= 0.0);
        near.flat_map(|(_, polygons)| polygons).any(|polygon| is_inside(polygon, place))
    }
}

/// Even-odd: a place in a hole is outside.
fn is_inside(polygon: &Polygon, place: DVec2) -> bool {
    let mut inside = false;
    for ring in &polygon.rings {
        let Some(mut from) = ring.last().copied() else { continue };
        for &to in ring {
            let spans = (to.y > place.y) != (from.y > place.y);
            let x = (from.x - to.x) * (place.y - to.y) / (from.y - to.y) + to.x;
            inside ^= spans && place.x < x;
            from = to;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_court_is_outside_of_the_building_around_it() {
        let square = |from: f64, to: f64| {
            let corner = |x, y| DVec2::new(651_000.0 + x, 6_861_000.0 + y);
            vec![corner(from, from), corner(to, from), corner(to, to), corner(from, to)]
        };
        let polygon = Polygon { rings: vec![square(0.0, 30.0), square(10.0, 20.0)] };
        let footprint = Footprint {
            id: "block".to_owned(),
            polygons: vec![polygon, Polygon::default()],
            base_m: 40.0,
            height_m: 12.0,
            uncertainty_m: 0.1,
            attributes: String::new(),
        };
        let buildings = Buildings::of(vec![footprint]);
        let contain =
            |x: f64, y: f64| buildings.contain(DVec2::new(651_000.0 + x, 6_861_000.0 + y));
        assert!(contain(5.0, 15.0) && contain(25.0, 29.0));
        assert!(!contain(15.0, 15.0) && !contain(-1.0, 15.0) && !contain(15.0, 31.0));
        assert!(!buildings.contain(DVec2::NAN) && !Buildings::default().contain(DVec2::ZERO));
    }
}
