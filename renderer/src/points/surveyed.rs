//! What a point looks like before any photograph says so.

use flaneur_scene::PointChunk;

/// Colours by which maps tell what was classified, sRGB, by the classes of ASPRS LAS 1.4-R15, table 17.
const GROUND: [f32; 3] = [0.74, 0.70, 0.63];
const PLANTS: [f32; 3] = [0.56, 0.68, 0.48];
const BUILDING: [f32; 3] = [0.80, 0.69, 0.62];
const WATER: [f32; 3] = [0.54, 0.65, 0.76];
const ROAD: [f32; 3] = [0.64, 0.64, 0.65];
const OTHER: [f32; 3] = [0.70, 0.70, 0.68];

/// Brightness of the weakest return, and what the strongest that has a number adds: surveys scale their
/// intensities as they like, so that it goes by their logarithms.
const DARK: f32 = 0.65;
const RANGE: f32 = 0.6;

/// The colour of a chunk's point, sRGB: its own; where it has none, that of its class, as bright as its
/// return was strong. `None` where the survey says neither. Black is none: surveys give it to points
/// that their cameras did not see.
pub(crate) fn colour(chunk: &PointChunk, index: usize) -> Option<[u8; 3]> {
    let own = chunk.colours.get(index).copied().filter(|colour| *colour != [0; 3]);
    own.or_else(|| {
        let of_class = match chunk.classes.get(index)? {
            2 | 8 | 20 => GROUND,
            3..=5 => PLANTS,
            6 => BUILDING,
            9 => WATER,
            10 | 11 => ROAD,
            // Never classified, and nothing else is known.
            0 if chunk.intensities.is_empty() => return None,
            _ => OTHER,
        };
        let strength = chunk.intensities.get(index).map(|&intensity| {
            let octaves = (1.0 + f32::from(intensity)).log2() / 16.0;
            DARK + RANGE * octaves
        });
        let lit = of_class.map(|channel| 255.0 * (channel * strength.unwrap_or(1.0)).min(1.0));
        Some(lit.map(|channel| channel.round() as u8))
    })
}

#[cfg(test)]
mod tests {
    use flaneur_scene::{NodeKey, PointNodeId, PointStations};
    use glam::DVec3;

    use super::*;

    #[test]
    fn points_without_colours_look_like_what_they_are_and_as_strong_as_their_return() {
        let mut chunk = PointChunk {
            id: PointNodeId { source: 0, key: NodeKey::ROOT },
            origin: DVec3::ZERO,
            positions: vec![[0.0; 3]; 6],
            colours: vec![[1, 2, 3], [0; 3], [0; 3], [0; 3], [0; 3], [0; 3]],
            intensities: vec![9, 10, 1000, 60_000, 10, 0],
            classes: vec![2, 2, 2, 2, 5, 0],
            normals: Vec::new(),
            stations: PointStations::default(),
            spacing_m: 0.1,
            spacings_m: Vec::new(),
        };
        let at = |chunk: &PointChunk, index| colour(chunk, index).expect("a colour");
        assert_eq!(at(&chunk, 0), [1, 2, 3], "its own");
        let [weak, strong, strongest] = [1, 2, 3].map(|index| at(&chunk, index));
        assert!(weak[0] < strong[0] && strong[0] < strongest[0], "{weak:?} {strong:?}");
        let plants = at(&chunk, 4);
        assert!(plants[1] > plants[0] && plants[1] > plants[2], "{plants:?}");
        let unknown = at(&chunk, 5);
        assert!(unknown[0] == unknown[1] && unknown[0] > 80, "{unknown:?}");
        chunk.intensities.clear();
        assert_eq!(colour(&chunk, 5), None, "nothing is known of it");
        assert_eq!(at(&chunk, 1), at(&chunk, 2));
        chunk.classes.clear();
        assert_eq!((colour(&chunk, 0), colour(&chunk, 1)), (Some([1, 2, 3]), None));
    }
}
