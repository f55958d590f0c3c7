//! The building that a wall or a roof belongs to.

use flaneur_scene::{Footprint, Region};
use flaneur_streamer::{Client, StreamError};
use glam::DVec2;

/// A building is looked for this far from its wall, metres.
const WALL_M: f64 = 3.0;

/// The building whose outline is nearest to a place of the plan; `None` where none is near.
pub(super) async fn nearest(client: &Client, at: DVec2) -> Result<Option<String>, StreamError> {
    let found = client.buildings(Region::Disc { centre: at, radius_m: WALL_M }).await?;
    let nearest = found
        .into_iter()
        .map(|footprint| (distance_m(&footprint, at), footprint.id))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(nearest.filter(|(metres, _)| *metres <= WALL_M).map(|(_, id)| id))
}

/// From a place of the plan to a footprint, metres; 0 inside of it.
fn distance_m(footprint: &Footprint, at: DVec2) -> f64 {
    let edges = footprint
        .polygons
        .iter()
        .flat_map(|polygon| &polygon.rings)
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| (*a, *b)));
    let (mut nearest_m, mut inside) = (f64::INFINITY, false);
    for (a, b) in edges {
        let (along, to) = (b - a, at - a);
        let length_2 = along.length_squared();
        let share = if length_2 > 0.0 { (to.dot(along) / length_2).clamp(0.0, 1.0) } else { 0.0 };
        nearest_m = nearest_m.min(at.distance(a + along * share));
        // Whether a ray to the east crosses the edge.
        if (a.y > at.y) != (b.y > at.y) {
            inside ^= at.x < a.x + (at.y - a.y) / along.y * along.x;
        }
    }
    if inside { 0.0 } else { nearest_m }
}

#[cfg(test)]
mod tests {
    use flaneur_scene::Polygon;

    use super::*;

    #[test]
    fn a_place_is_on_the_footprint_whose_edge_is_nearest_unless_it_is_within_one() {
        let square = |x: f64| Footprint {
            id: format!("{x}"),
            polygons: vec![Polygon {
                rings: vec![
                    [(0., 0.), (10., 0.), (10., 10.), (0., 10.)]
                        .map(|(dx, dy)| DVec2::new(x + dx, dy))
                        .to_vec(),
                ],
            }],
            base_m: 0.0,
            height_m: 10.0,
            uncertainty_m: 0.1,
            attributes: String::new(),
        };
        assert_eq!(distance_m(&square(0.0), DVec2::new(12.0, 5.0)), 2.0);
        assert_eq!(distance_m(&square(0.0), DVec2::new(13.0, 14.0)), 5.0);
        assert_eq!(distance_m(&square(0.0), DVec2::new(9.0, 5.0)), 0.0);
        assert_eq!(distance_m(&square(20.0), DVec2::new(12.0, 5.0)), 8.0);
    }
}
