//! Tiles of terrain.

use flaneur_scene::{GroundLayout, GroundTile};

use crate::error::{FieldError, not_negative, positive};
use crate::geometry::point2;
use crate::v1;

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

impl From<GroundTile> for v1::GroundTile {
    fn from(tile: GroundTile) -> Self {
        Self {
            column: tile.index.0,
            row: tile.index.1,
            origin: Some(tile.origin.into()),
            spacing_m: tile.spacing_m,
            columns: tile.columns,
            heights: tile.heights,
            uncertainty_m: tile.uncertainty_m,
        }
    }
}

impl TryFrom<v1::GroundTile> for GroundTile {
    type Error = FieldError;

    /// Whole rows of at least one node; heights may be NaN, not infinite.
    fn try_from(message: v1::GroundTile) -> Result<Self, FieldError> {
        let nodes = message.heights.len();
        let columns = usize::try_from(message.columns).unwrap_or(usize::MAX);
        if columns == 0 || nodes == 0 || !nodes.is_multiple_of(columns) {
            return Err(FieldError::new(
                "columns",
                format!("is {columns}, but {nodes} heights are no whole rows of that"),
            ));
        }
        if let Some(index) = message.heights.iter().position(|h| h.is_infinite()) {
            return Err(FieldError::new(format!("heights[{index}]"), "is infinite"));
        }
        Ok(Self {
            index: (message.column, message.row),
            origin: point2("origin", message.origin)?,
            spacing_m: positive("spacing_m", message.spacing_m)?,
            columns: message.columns,
            heights: message.heights,
            uncertainty_m: not_negative("uncertainty_m", message.uncertainty_m)?,
        })
    }
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
            let mut message = v1::GroundTile::from(tile());
            change(&mut message);
            GroundTile::try_from(message).expect_err("bad tile").field
        };
        assert_eq!(field(|m| m.columns = 0), "columns");
        assert_eq!(field(|m| m.columns = 4), "columns");
        assert_eq!(field(|m| m.columns = u32::MAX), "columns");
        assert_eq!(field(|m| m.heights.clear()), "columns");
        assert_eq!(field(|m| m.heights[4] = f32::NEG_INFINITY), "heights[4]");
        assert_eq!(field(|m| m.spacing_m = 0.0), "spacing_m");
        assert_eq!(field(|m| m.origin = None), "origin");
    }

    proptest! {
        #[test]
        fn tiles_come_back_with_their_unknown_heights(
            column in any::<i32>(), row in any::<i32>(), columns in 1u32..5, rows in 1usize..5,
            seed in prop::collection::vec(prop_oneof![-100f32..5000.0, Just(f32::NAN)], 16),
        ) {
            let heights: Vec<f32> =
                seed.into_iter().cycle().take(columns as usize * rows).collect();
            let sent = GroundTile { index: (column, row), columns, heights, ..tile() };
            let back = GroundTile::try_from(v1::GroundTile::from(sent.clone())).expect("valid");
            let bits = |t: &GroundTile| t.heights.iter().map(|h| h.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&back), bits(&sent));
            prop_assert_eq!(
                GroundTile { heights: vec![], ..back },
                GroundTile { heights: vec![], ..sent }
            );
        }
    }
}
