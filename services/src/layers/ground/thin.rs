//! Tiles with fewer nodes.

use flaneur_scene::GroundTile;

/// Every `step`-th node of each row and column, from the south-west one. Where the tile ends
/// between two of them, the last ones have the heights of the tile's border, so that its
/// surface is not cut off.
pub(super) fn thinned(tile: GroundTile, step: u32) -> GroundTile {
    let (columns, rows) = (tile.columns, tile.rows());
    if step <= 1 || columns == 0 || rows == 0 {
        return tile;
    }
    let places = |count: u32| {
        (0..=(count - 1).div_ceil(step)).map(move |place| (place * step).min(count - 1))
    };
    let node = |column: u32, row: u32| {
        let index = row as usize * columns as usize + column as usize;
        tile.heights.get(index).copied().unwrap_or(f32::NAN)
    };
    let heights = places(rows).flat_map(|row| places(columns).map(move |column| (column, row)));
    GroundTile {
        heights: heights.map(|(column, row)| node(column, row)).collect(),
        columns: (columns - 1).div_ceil(step) + 1,
        spacing_m: tile.spacing_m * f64::from(step),
        ..tile
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn tile(columns: u32, rows: u32) -> GroundTile {
        GroundTile {
            index: (2, 3),
            origin: DVec2::new(5.0, 6.0),
            spacing_m: 0.5,
            columns,
            heights: (0..columns * rows).map(|i| i as f32).collect(),
            uncertainty_m: 0.1,
        }
    }

    #[test]
    fn every_stepth_node_is_kept_with_its_place() {
        let whole = tile(65, 65);
        let thin = thinned(whole.clone(), 16);
        assert_eq!((thin.columns, thin.rows(), thin.spacing_m), (5, 5, 8.0));
        assert_eq!((thin.index, thin.bounds()), (whole.index, whole.bounds()));
        for (i, height) in thin.heights.iter().enumerate() {
            assert_eq!(*height, (i / 5 * 16 * 65 + i % 5 * 16) as f32);
        }
        assert_eq!(thinned(whole.clone(), 1), whole);
        assert_eq!(thinned(whole, 64).heights, [0.0, 64.0, 4160.0, 4224.0]);
    }

    #[test]
    fn what_ends_between_nodes_is_not_cut_off() {
        let thin = thinned(tile(4, 2), 2);
        // Columns 0, 2 and, for 4, the last; rows 0 and, for 2, the last.
        assert_eq!((thin.columns, thin.heights), (3, vec![0.0, 2.0, 3.0, 4.0, 6.0, 7.0]));
    }
}
