//! Points as they were surveyed, for those who measure.

use flaneur_scene::{GpsTimeKind, Node, PointSource};
use glam::{DVec3, IVec3};

use super::Track;
use super::damaged;
use super::laz::Records;
use super::points::{CLASS, FLAGS, GPS_TIME, INTENSITY, WITHHELD, f64_at, i32_at, u16_at};
use crate::StreamError;

/// A point with what its survey says of it, unaltered.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyedPoint {
    /// Name of its source.
    pub source: String,
    /// World, metres: its integers times the source's scale, plus the offset.
    pub position: DVec3,
    /// LAS class.
    pub class: u8,
    /// Intensity of the return.
    pub intensity: u16,
    /// Seconds, as they are stored; 0 where the survey has no times.
    pub gps_time_s: f64,
    /// What they count from.
    pub gps_time_kind: GpsTimeKind,
}

/// The point of a node that is shown nearest to `place` (world), with its distance, metres, from the
/// LAZ bytes of its chunk; `None` where it has none.
pub(crate) fn nearest_point(
    source: &PointSource,
    node: &Node,
    chunk: &[u8],
    track: &Track,
    place: DVec3,
) -> Result<Option<(f64, SurveyedPoint)>, StreamError> {
    let what = || format!("node {:?} of point source {:?}", node.key, source.name);
    let mut records =
        Records::new(source, chunk, node.point_count).map_err(|p| damaged(what(), p))?;
    let mut nearest: Option<(f64, SurveyedPoint)> = None;
    while let Some(record) = records.next() {
        let record = record.map_err(|p| damaged(what(), p))?;
        if record[FLAGS] & WITHHELD != 0 {
            continue;
        }
        let stored = IVec3::new(i32_at(record, 0), i32_at(record, 4), i32_at(record, 8));
        let position = stored.as_dvec3() * source.scale + source.offset;
        let gps_time_s = f64_at(record, GPS_TIME);
        let distance_2 = track.shown(gps_time_s, position).distance_squared(place);
        if nearest.as_ref().is_none_or(|(least, _)| distance_2 < *least) {
            let point = SurveyedPoint {
                source: source.name.clone(),
                position,
                class: record[CLASS],
                intensity: u16_at(record, INTENSITY),
                gps_time_s,
                gps_time_kind: source.gps_time,
            };
            nearest = Some((distance_2, point));
        }
    }
    Ok(nearest.map(|(distance_2, point)| (distance_2.sqrt(), point)))
}
