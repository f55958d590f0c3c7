//! What a survey has stored of a place that a picture shows.

mod footprint;
mod photographs;

use std::collections::BTreeSet;

use flaneur_renderer::{Picked, PickedSurface};
use flaneur_scene::{PointNodeId, SurfaceClass};
use flaneur_streamer::{StreamError, Streamer, SurveyedPoint};

pub use photographs::StoredSight;

/// A surveyed point is this near to the place that a picture shows of its disc, at most, metres.
const REACH_M: f64 = 1.0;

/// What a pixel shows.
#[derive(Clone, Debug)]
pub struct Found {
    /// The place.
    pub picked: Picked,
    /// The nodes of points that are on the device.
    pub nodes: BTreeSet<PointNodeId>,
}

/// What is stored of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// The lidar point that is shown there, as it was surveyed.
    pub point: Option<SurveyedPoint>,
    /// The building whose wall or roof it is.
    pub footprint: Option<String>,
    /// The photographs that see it, the one that counts most in its colour first.
    pub photographs: Vec<StoredSight>,
}

/// Looks up what is stored of a place, with `most` of the photographs that see it.
///
/// # Errors
/// Where the service fails, or sends what cannot be read.
pub async fn look_up(
    streamer: &Streamer,
    found: &Found,
    most: usize,
) -> Result<Record, StreamError> {
    let (picked, client) = (&found.picked, streamer.client());
    let mut record = Record::default();
    match picked.surface {
        PickedSurface::Point => {
            let shown = |id: &_| found.nodes.contains(id);
            record.point = streamer.point_at(picked.position, REACH_M, shown).await?;
        }
        PickedSurface::Mesh(SurfaceClass::Wall | SurfaceClass::Roof) => {
            record.footprint = footprint::nearest(client, picked.position.truncate()).await?;
        }
        PickedSurface::Mesh(SurfaceClass::Ground) => {}
    }
    let sights = picked.seen_by.get(..most).unwrap_or(&picked.seen_by);
    record.photographs = photographs::stored(client, sights, picked.position).await?;
    Ok(record)
}
