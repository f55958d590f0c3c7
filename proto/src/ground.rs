//! Tiles of terrain.

use flaneur_scene::{GroundLayout, GroundTile};

use crate::error::{FieldError, not_negative, positive};
use crate::geometry::point2;
use crate::v1;

/// The largest [`v1::StreamGroundRequest::step`]: cells along a side of a tile.
pub const MAX_GROUND_STEP: u32 = 64;

/// The most nodes of a tile that is taken.
const MAX_NODES: u64 = 1 << 20;

/// Heights are within so many millimetres of 0.
const FARTHEST_MM: i32 = 1_000_000_000;

impl From<GroundLayout> for v1::GroundLayout {
    fn from(layout: GroundLayout) -> Self {
        Self {
            origin: Some(layout.origin.into()),
            tile_m: layout.tile_m,
            columns: layout.columns,
            rows: layout.rows,
        }
    }
}

impl TryFrom<v1::GroundLayout> for GroundLayout {
    type Error = FieldError;

    fn try_from(message: v1::GroundLayout) -> Result<Self, FieldError> {
        Ok(Self {
            origin: point2("origin", message.origin)?,
            tile_m: positive("tile_m", message.tile_m)?,
            columns: message.columns,
            rows: message.rows,
        })
    }
}

impl v1::StreamGroundRequest {
    /// The step asked for, 1 where none is; an error names what is no step.
    pub fn checked_step(&self) -> Result<u32, FieldError> {
        let step = self.step.max(1);
        if step.is_power_of_two() && step <= MAX_GROUND_STEP {
            return Ok(step);
        }
        let problem = format!("is {step}, must be a power of two, at most {MAX_GROUND_STEP}");
        Err(FieldError::new("step", problem))
    }
}

impl TryFrom<GroundTile> for v1::GroundTile {
    type Error = FieldError;

    /// An error names a height that is neither NaN nor within ± 1000 km.
    fn try_from(tile: GroundTile) -> Result<Self, FieldError> {
        let mut height_steps_mm = Vec::with_capacity(tile.heights.len());
        let mut known = vec![0; tile.heights.len().div_ceil(8)];
        let mut before = 0;
        for (node, height) in tile.heights.iter().enumerate() {
            if height.is_nan() {
                continue;
            }
            let millimetres = (f64::from(*height) * 1000.0).round();
            if !(millimetres.abs() <= f64::from(FARTHEST_MM)) {
                let problem = format!("is {height}, must be within {FARTHEST_MM} millimetres of 0");
                return Err(FieldError::new(format!("heights[{node}]"), problem));
            }
            let millimetres = millimetres as i32;
            // Twice the farthest is still an i32.
            height_steps_mm.push(millimetres - before);
            before = millimetres;
            if let Some(byte) = known.get_mut(node / 8) {
                *byte |= 1 << (node % 8);
            }
        }
        if height_steps_mm.len() == tile.heights.len() {
            known.clear();
        }
        Ok(Self {
            column: tile.index.0,
            row: tile.index.1,
            origin: Some(tile.origin.into()),
            spacing_m: tile.spacing_m,
            columns: tile.columns,
            rows: tile.rows(),
            uncertainty_m: tile.uncertainty_m,
            height_steps_mm,
            known: known.into(),
        })
    }
}

impl TryFrom<v1::GroundTile> for GroundTile {
    type Error = FieldError;

    /// At least one node; unknown heights become NaN.
    fn try_from(message: v1::GroundTile) -> Result<Self, FieldError> {
        let nodes = u64::from(message.columns) * u64::from(message.rows);
        if nodes == 0 || nodes > MAX_NODES {
            let size = format!("is {}, for {} columns", message.rows, message.columns);
            let problem = format!("{size}: that are {nodes} nodes, must be 1 to {MAX_NODES}");
            return Err(FieldError::new("rows", problem));
        }
        Ok(Self {
            index: (message.column, message.row),
            origin: point2("origin", message.origin)?,
            spacing_m: positive("spacing_m", message.spacing_m)?,
            columns: message.columns,
            heights: heights(nodes as usize, &message.height_steps_mm, &message.known)?,
            uncertainty_m: not_negative("uncertainty_m", message.uncertainty_m)?,
        })
    }
}

/// The heights of `nodes` nodes, metres, NaN where `known` has no bit.
fn heights(nodes: usize, steps_mm: &[i32], known: &[u8]) -> Result<Vec<f32>, FieldError> {
    if !known.is_empty() && known.len() != nodes.div_ceil(8) {
        let problem = format!("holds {} bytes, not a bit for each of {nodes} nodes", known.len());
        return Err(FieldError::new("known", problem));
    }
    let is_known = |node: usize| {
        known.is_empty() || known.get(node / 8).is_some_and(|byte| byte >> (node % 8) & 1 == 1)
    };
    if (nodes..8 * known.len()).any(is_known) {
        return Err(FieldError::new("known", format!("has bits beyond its {nodes} nodes")));
    }
    let count = (0..nodes).filter(|node| is_known(*node)).count();
    if steps_mm.len() != count {
        let problem = format!("holds {}, but {count} nodes are known", steps_mm.len());
        return Err(FieldError::new("height_steps_mm", problem));
    }
    let mut heights = vec![f32::NAN; nodes];
    let known_heights = heights.iter_mut().enumerate().filter(|(node, _)| is_known(*node));
    let mut millimetres = 0_i64;
    for (index, ((_, height), step)) in known_heights.zip(steps_mm).enumerate() {
        millimetres += i64::from(*step);
        if millimetres.abs() > i64::from(FARTHEST_MM) {
            let problem = format!("leads to {millimetres}, must stay within {FARTHEST_MM} of 0");
            return Err(FieldError::new(format!("height_steps_mm[{index}]"), problem));
        }
        *height = (millimetres as f64 / 1000.0) as f32;
    }
    Ok(heights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    fn tile() -> GroundTile {
        GroundTile {
            index: (-1, 7),
            origin: DVec2::new(651_000.0, 6.86e6),
            spacing_m: 0.5,
            columns: 3,
            heights: vec![1.0, f32::NAN, 3.0, 4.0, 5.0, 6.0],
            uncertainty_m: 0.1,
        }
    }

    #[test]
    fn faults_are_named() {
        let field = |change: fn(&mut v1::GroundTile)| {
            let mut message = v1::GroundTile::try_from(tile()).expect("sound");
            change(&mut message);
            GroundTile::try_from(message).expect_err("bad tile").field
        };
        assert_eq!(field(|m| m.columns = 0), "rows");
        assert_eq!(field(|m| m.rows = 0), "rows");
        assert_eq!(field(|m| (m.columns, m.rows) = (u32::MAX, u32::MAX)), "rows");
        // As many bits, but of other nodes.
        assert_eq!(field(|m| (m.columns, m.rows) = (1, 5)), "known");
        assert_eq!(field(|m| (m.columns, m.rows) = (3, 3)), "known");
        assert_eq!(field(|m| m.known = vec![0b1111_1101].into()), "known");
        assert_eq!(field(|m| m.known = vec![].into()), "height_steps_mm");
        assert_eq!(field(|m| m.known = vec![0b11_1111].into()), "height_steps_mm");
        assert_eq!(field(|m| m.height_steps_mm.clear()), "height_steps_mm");
        assert_eq!(field(|m| m.height_steps_mm.push(1)), "height_steps_mm");
        assert_eq!(field(|m| m.height_steps_mm[4] = i32::MIN), "height_steps_mm[4]");
        let far = |m: &mut v1::GroundTile| m.height_steps_mm = vec![600_000_000; 5];
        assert_eq!(field(far), "height_steps_mm[1]");
        assert_eq!(field(|m| m.spacing_m = 0.0), "spacing_m");
        assert_eq!(field(|m| m.origin = None), "origin");
    }

    #[test]
    fn heights_that_no_terrain_has_are_not_sent() {
        for height in [f32::INFINITY, f32::NEG_INFINITY, 1.1e6, -1e30] {
            let heights = vec![1.0, f32::NAN, 3.0, height, 5.0, 6.0];
            let error = v1::GroundTile::try_from(GroundTile { heights, ..tile() });
            assert_eq!(error.expect_err("too far").field, "heights[3]");
        }
    }

    #[test]
    fn steps_are_powers_of_two_that_divide_a_tile() {
        let step = |step| v1::StreamGroundRequest { step, ..Default::default() }.checked_step();
        assert_eq!([0, 1, 2, 8, 64].map(|s| step(s).expect("a step")), [1, 1, 2, 8, 64]);
        for bad in [3, 6, 65, 128, u32::MAX] {
            assert_eq!(step(bad).expect_err("no step").field, "step");
        }
    }

    /// A tile as it is stored in whole takes four bytes a node.
    #[test]
    fn a_street_takes_about_a_byte_a_node() {
        let height = |i: u32| 42.0 + 0.03 * (i % 65) as f32 + 0.05 * (i as f32).sin();
        let heights = (0..65 * 65).map(height).collect();
        let message = v1::GroundTile::try_from(GroundTile { columns: 65, heights, ..tile() });
        let bytes = prost::Message::encoded_len(&message.expect("sound"));
        assert!(bytes < 65 * 65 * 3 / 2, "{bytes}");
    }

    proptest! {
        #[test]
        fn tiles_come_back_to_half_a_millimetre(
            column in any::<i32>(), row in any::<i32>(), columns in 1u32..5, rows in 1usize..5,
            seed in prop::collection::vec(
                prop_oneof![-1e6f32..1e6, -100f32..5000.0, Just(f32::NAN)], 16),
            whole in any::<bool>(),
        ) {
            let heights: Vec<f32> = seed
                .into_iter()
                .map(|h| if whole && h.is_nan() { 0.0 } else { h })
                .cycle()
                .take(columns as usize * rows)
                .collect();
            let sent = GroundTile { index: (column, row), columns, heights, ..tile() };
            let message = v1::GroundTile::try_from(sent.clone()).expect("terrain");
            prop_assert_eq!(message.known.is_empty(), sent.heights.iter().all(|h| !h.is_nan()));
            let back = GroundTile::try_from(message).expect("valid");
            prop_assert_eq!(back.heights.len(), sent.heights.len());
            for (back, sent) in back.heights.iter().zip(&sent.heights) {
                // Half a millimetre, and what an f32 cannot say.
                let bound_m = 0.0005 + f64::from(sent.abs() * f32::EPSILON);
                let off_m = (f64::from(*back) - f64::from(*sent)).abs();
                prop_assert!(back.is_nan() && sent.is_nan() || off_m <= bound_m, "{back} {sent}");
            }
            prop_assert_eq!(
                GroundTile { heights: vec![], ..back },
                GroundTile { heights: vec![], ..sent }
            );
        }

        #[test]
        fn no_message_makes_it_panic_or_take_much(
            columns in any::<u32>(), rows in 0u32..70, steps in prop::collection::vec(any::<i32>(), 0..80),
            known in prop::collection::vec(any::<u8>(), 0..12), narrow in any::<bool>(),
        ) {
            let columns = if narrow { columns % 9 } else { columns };
            let message = v1::GroundTile {
                columns, rows, height_steps_mm: steps, known: known.into(),
                ..v1::GroundTile::try_from(tile()).expect("sound")
            };
            if let Ok(tile) = GroundTile::try_from(message) {
                prop_assert_eq!((tile.columns, tile.rows()), (columns, rows));
            }
        }
    }
}
