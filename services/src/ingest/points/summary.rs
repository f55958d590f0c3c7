//! What is counted while points go by.

use glam::IVec3;

use super::scan::raw_position;
use crate::layers::copc::CopcSummary;

/// The summary of no points, neutral for [`merge`].
pub(super) const NO_POINTS: CopcSummary = CopcSummary {
    point_count: 0,
    by_return: [0; 15],
    min: IVec3::MAX,
    max: IVec3::MIN,
    gps_time: (f64::INFINITY, f64::NEG_INFINITY),
};

/// Counts a record of format 6, 7 or 8.
pub(super) fn include(summary: &mut CopcSummary, record: &[u8]) {
    let position = raw_position(record);
    summary.point_count += 1;
    summary.min = summary.min.min(position);
    summary.max = summary.max.max(position);
    // Return 0 is not a return; the header has no place for it.
    if let Some(count) = summary.by_return.get_mut(usize::from(record[14] & 15).wrapping_sub(1)) {
        *count += 1;
    }
    let time = f64::from_le_bytes(std::array::from_fn(|i| record[22 + i]));
    // `min` and `max` pass over NaN.
    summary.gps_time = (summary.gps_time.0.min(time), summary.gps_time.1.max(time));
}

/// Adds the counts of other points.
pub(super) fn merge(summary: &mut CopcSummary, other: &CopcSummary) {
    summary.point_count += other.point_count;
    for (count, other) in summary.by_return.iter_mut().zip(other.by_return) {
        *count += other;
    }
    summary.min = summary.min.min(other.min);
    summary.max = summary.max.max(other.max);
    summary.gps_time =
        (summary.gps_time.0.min(other.gps_time.0), summary.gps_time.1.max(other.gps_time.1));
}

/// The summary as a header states it: without infinities where no point has a GPS time.
pub(super) fn finished(mut summary: CopcSummary) -> CopcSummary {
    if !(summary.gps_time.0 <= summary.gps_time.1) {
        summary.gps_time = (0.0, 0.0);
    }
    summary
}
