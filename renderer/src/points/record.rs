//! A point as the device holds it.

use flaneur_scene::{Bounds3, PointChunk};
use glam::{DVec3, Vec3};

/// Position relative to the chunk's origin as three `f32`, and a code: colour in the low 24
/// bits, radius in bits 24 to 30, bit 31 set where there is a colour. Read by splat.wgsl.
pub(crate) type Record = [u32; 4];

/// The record that is not drawn: its radius code is 0.
pub(crate) const NO_POINT: Record = [0; 4];
const HAS_COLOUR: u32 = 1 << 31;
const RADIUS_BITS: u32 = 0x7f << 24;

/// Points further than this from their chunk's origin are refused: f32 is off by 6 cm there.
const MAX_OFFSET_M: f32 = 1e6;

/// The code (1 to 127) of the radius nearest to `radius_m`: eight steps an octave from 1 mm,
/// so within 4.5 %.
pub(crate) fn radius_code(radius_m: f32) -> u32 {
    (8.0 * (radius_m / 0.001).log2()).round().clamp(1.0, 127.0) as u32
}

/// The records of the points that can be drawn, and their box in the world.
pub(crate) fn records(chunk: &PointChunk, radius_code: u32) -> (Vec<Record>, Bounds3) {
    let mut bounds = Bounds3::EMPTY;
    let mut records = Vec::with_capacity(chunk.positions.len());
    for (i, &position) in chunk.positions.iter().enumerate() {
        // Written so that NaN is refused.
        if !position.iter().all(|x| x.abs() <= MAX_OFFSET_M) {
            continue;
        }
        bounds.include(chunk.origin + Vec3::from_array(position).as_dvec3());
        // Surveys give black to points that their cameras did not see.
        let colour = chunk
            .colours
            .get(i)
            .filter(|colour| **colour != [0; 3])
            .map_or(0, |&[r, g, b]| HAS_COLOUR | u32::from_le_bytes([r, g, b, 0]));
        let [x, y, z] = position.map(f32::to_bits);
        records.push([x, y, z, colour | radius_code << 24]);
    }
    (records, bounds)
}

/// Gives every point within `bounds` (world) at most the radius of `code`; whether any
/// changed.
pub(crate) fn shrink_within(
    records: &mut [Record],
    origin: DVec3,
    bounds: &Bounds3,
    code: u32,
) -> bool {
    let (min, max) = ((bounds.min - origin).as_vec3(), (bounds.max - origin).as_vec3());
    let mut changed = false;
    for record in records {
        let p = Vec3::from_array([record[0], record[1], record[2]].map(f32::from_bits));
        if record[3] & RADIUS_BITS > code << 24 && p.cmpge(min).all() && p.cmple(max).all() {
            set_radius(record, code);
            changed = true;
        }
    }
    changed
}

/// Gives every point the radius of `code`.
pub(crate) fn reset(records: &mut [Record], code: u32) {
    for record in records {
        set_radius(record, code);
    }
}

fn set_radius(record: &mut Record, code: u32) {
    record[3] = record[3] & !RADIUS_BITS | code << 24;
}

#[cfg(test)]
mod tests {
    use flaneur_scene::{NodeKey, PointNodeId};

    use super::*;

    #[test]
    fn radius_codes_are_within_half_a_step() {
        for radius_m in [0.0012f32, 0.035, 0.25, 3.0, 50.0] {
            let decoded = 0.001 * (radius_code(radius_m) as f32 * 0.125).exp2();
            assert!((decoded / radius_m).log2().abs() <= 0.0626, "{radius_m} {decoded}");
        }
    }

    #[test]
    fn black_points_are_uncoloured() {
        let chunk = PointChunk {
            id: PointNodeId { source: 0, key: NodeKey::ROOT },
            origin: DVec3::ZERO,
            positions: vec![[0.0; 3]; 2],
            colours: vec![[0, 0, 0], [0, 0, 1]],
            intensities: Vec::new(),
            classes: vec![0; 2],
            normals: Vec::new(),
            spacing_m: 0.1,
        };
        let (records, _) = records(&chunk, 40);
        assert_eq!(records[0][3] & HAS_COLOUR, 0);
        assert_eq!(records[1][3] & (HAS_COLOUR | 0xff_ffff), HAS_COLOUR | 1 << 16);
    }

    #[test]
    fn shrinking_spares_what_is_outside_or_smaller() {
        let at = |x: f32, code: u32| [x.to_bits(), 0, 0, HAS_COLOUR | code << 24 | 0x123456];
        let mut records = [at(1.0, 40), at(3.0, 40), at(1.0, 8)];
        let origin = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let bounds = Bounds3 { min: origin, max: origin + DVec3::new(2.0, 0.0, 0.0) };
        assert!(shrink_within(&mut records, origin, &bounds, 16));
        assert_eq!(records, [at(1.0, 16), at(3.0, 40), at(1.0, 8)]);
        assert!(!shrink_within(&mut records, origin, &bounds, 16));
    }
}
