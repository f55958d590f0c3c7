//! Whence points were taken, and how far that puts them behind others for a camera. Equations in
//! points/remote.rs.

use std::sync::Arc;

use flaneur_scene::{Bounds3, PointChunk};
use glam::DVec3;

use crate::points::BLOCK_POINTS;

/// What the points of a block have in common; world frame.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    station: DVec3,
    middle: DVec3,
    /// All places from which the source was taken.
    places: Arc<[DVec3]>,
}

impl Taken {
    /// Of the blocks of a chunk's points, given by index and position; `None` for a block of which
    /// it is not known.
    pub(super) fn of_blocks(
        chunk: &PointChunk,
        points: &[(usize, DVec3)],
    ) -> Vec<Option<Arc<Self>>> {
        let of_block = |block: &[(usize, DVec3)]| {
            let stations: Vec<DVec3> =
                block.iter().filter_map(|(i, _)| chunk.stations.of_point(*i)).collect();
            let mut bounds = Bounds3::EMPTY;
            block.iter().for_each(|(_, position)| bounds.include(*position));
            (!stations.is_empty()).then(|| {
                Arc::new(Self {
                    station: stations.iter().sum::<DVec3>() / stations.len() as f64,
                    middle: 0.5 * (bounds.min + bounds.max),
                    places: Arc::clone(&chunk.stations.places),
                })
            })
        };
        points.chunks(BLOCK_POINTS).map(of_block).collect()
    }

    /// Metres behind in a view from `eye`.
    pub(super) fn behind_in_view_m(&self, eye: DVec3) -> f64 {
        match self.remoteness(eye) {
            u if u < 1.0 => 0.0,
            u if 0.3 * (u - 1.0) > 10.0 => 10.0,
            u => 0.3 * (u - 1.0),
        }
    }

    /// Rank in the depth map of a photograph; `None` where that leaves it out.
    pub(super) fn rank_in_map(&self, centre: DVec3) -> Option<u32> {
        let u = self.remoteness(centre);
        (u <= (self.middle - centre).length().max(3.0)).then_some((u as u32).min(15))
    }

    fn remoteness(&self, centre: DVec3) -> f64 {
        let away = |place: &DVec3| (*place - centre).length();
        let nearest = self.places.iter().map(away).min_by(f64::total_cmp).unwrap_or(0.0);
        let excess = away(&self.station) - nearest;
        if excess <= 0.0 {
            0.0
        } else if nearest <= 3.0 {
            excess
        } else {
            excess * 3.0 / nearest
        }
    }
}
