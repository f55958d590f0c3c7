//! Point nodes.

use flaneur_scene::{Node, PointChunk, PointNodeId, PointSource};
use glam::IVec3;

use super::colour::eight_bit_colours;
use super::damaged;
use super::laz::Records;
use super::normals::normals;
use super::order::{along_a_curve, reordered};
use super::spacing::{spacings_m, typical_spacing_m};
use super::stations::{Track, runs};
use crate::StreamError;

/// Offsets in the point data record formats 6 to 8.
pub(super) const FLAGS: usize = 15;
pub(super) const CLASS: usize = 16;
pub(super) const INTENSITY: usize = 12;
pub(super) const GPS_TIME: usize = 22;
const COLOUR: usize = 30;
/// Bit of [`FLAGS`] that marks a point as deleted.
pub(super) const WITHHELD: u8 = 0b100;

/// The points of the node `id`, from the LAZ bytes of its chunk.
///
/// Points are where `track` shows them. Positions are relative to the centre of the node's cell, whose size bounds them: at f32
/// they are exact to 2⁻²⁴ of it. Points that the survey marks as withheld are left out;
/// the others come along a curve through space, one curve for each stretch of `track`, the
/// source's, that they were taken from.
/// A chunk whose sizes contradict each other, or with a point outside its node's cell by more
/// than the cell's size, is damaged. Normals are estimated where they are asked for.
pub(crate) fn decode_points(
    source: &PointSource,
    id: PointNodeId,
    node: &Node,
    chunk: &[u8],
    track: &Track,
    with_normals: bool,
) -> Result<PointChunk, StreamError> {
    let what = || format!("node {:?} of point source {:?}", node.key, source.name);
    let bounds = source.cube.node_bounds(node.key);
    let origin = bounds.centre();
    let reach = 3.0 * (bounds.max - bounds.min).max_element();
    let has_colour = matches!(source.point_format, 7 | 8);
    let shortest = if has_colour { COLOUR + 6 } else { COLOUR };
    if usize::from(source.record_length) < shortest {
        return Err(damaged(
            what(),
            format!(
                "records of format {} are longer than {} bytes",
                source.point_format, source.record_length
            ),
        ));
    }
    let mut records =
        Records::new(source, chunk, node.point_count).map_err(|p| damaged(what(), p))?;
    // A record is never compressed to nothing, so the chunk's own size bounds what is
    // reserved; a chunk of equal points may grow beyond that.
    let capacity = (node.point_count as usize).min(chunk.len());
    let mut positions = Vec::with_capacity(capacity);
    let mut intensities = Vec::with_capacity(capacity);
    let mut classes = Vec::with_capacity(capacity);
    let mut times_s = Vec::with_capacity(capacity);
    let mut colours = Vec::with_capacity(if has_colour { capacity } else { 0 });
    while let Some(record) = records.next() {
        let record = record.map_err(|p| damaged(what(), p))?;
        if record[FLAGS] & WITHHELD != 0 {
            continue;
        }
        let stored = IVec3::new(i32_at(record, 0), i32_at(record, 4), i32_at(record, 8));
        let surveyed = stored.as_dvec3() * source.scale + source.offset;
        let position = surveyed - origin;
        if !(position.abs().max_element() <= reach) {
            let problem = format!("a point lies {position} m from the middle of its node");
            return Err(damaged(what(), problem));
        }
        let time_s = f64_at(record, GPS_TIME);
        let shown = track.shown(time_s, surveyed) - origin;
        positions.push(shown.as_vec3().to_array());
        intensities.push(u16_at(record, INTENSITY));
        classes.push(record[CLASS]);
        times_s.push(time_s);
        if has_colour {
            colours.push([0, 2, 4].map(|channel| u16_at(record, COLOUR + channel)));
        }
    }
    if intensities.iter().all(|&intensity| intensity == 0) {
        intensities = Vec::new();
    }
    let mut stations = track.stations_of(&times_s);
    let order = along_a_curve(&positions, &runs(&stations.of_points));
    stations.of_points = reordered(&stations.of_points, &order);
    let positions = reordered(&positions, &order);
    let level_m = source.cube.level_spacing_m(node.key.level) as f32;
    let spacing_m = typical_spacing_m(&positions, level_m);
    let spacings_m = spacings_m(&positions, level_m);
    let normals = if with_normals { normals(&positions, spacing_m) } else { Vec::new() };
    Ok(PointChunk {
        id,
        origin,
        positions,
        colours: reordered(&eight_bit_colours(&colours), &order),
        intensities: reordered(&intensities, &order),
        classes: reordered(&classes, &order),
        normals,
        stations,
        spacing_m,
        spacings_m,
    })
}

pub(super) fn i32_at(record: &[u8], at: usize) -> i32 {
    i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
}

pub(super) fn f64_at(record: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(std::array::from_fn(|byte| record[at + byte]))
}

pub(super) fn u16_at(record: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([record[at], record[at + 1]])
}

#[cfg(test)]
mod tests;
