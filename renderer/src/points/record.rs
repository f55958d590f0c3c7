//! A point as the device holds it.

use flaneur_scene::{Bounds3, PointChunk};
use glam::{DVec3, Vec3};

use super::{BLOCK_POINTS, surveyed};
use crate::octahedral::plane_code;

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
    // What is no number takes the largest.
    ((8.0 * (radius_m / 0.001).log2()).round().min(127.0) as u32).max(1)
}

/// The points of a chunk that can be drawn, column by column.
pub(crate) struct Drawable {
    pub(crate) records: Vec<Record>,
    /// The code of each point's radius, where nothing finer is around it.
    pub(crate) radii: Vec<u8>,
    /// A code a point, as of [`plane_code`]; empty where none were wanted.
    pub(crate) normals: Vec<u32>,
    /// The box of each block of points, in the world.
    pub(crate) boxes: Vec<Bounds3>,
    /// The mean of the places that the points of each block were taken from; `None` where none
    /// is known.
    pub(crate) stations: Vec<Option<DVec3>>,
}

/// What can be drawn of a chunk; `radius_m` is the radius of a point by the distance to its
/// neighbours.
pub(crate) fn drawable(
    chunk: &PointChunk,
    radius_m: impl Fn(f32) -> f32,
    with_normals: bool,
) -> Drawable {
    let count = chunk.positions.len();
    let of_chunk = radius_code(radius_m(chunk.spacing_m));
    let mut records = Vec::with_capacity(count);
    let mut radii = Vec::with_capacity(count);
    let mut normals = Vec::with_capacity(if with_normals { count } else { 0 });
    let mut boxes = Vec::with_capacity(count.div_ceil(BLOCK_POINTS));
    let mut stations: Vec<Mean> = Vec::with_capacity(count.div_ceil(BLOCK_POINTS));
    for (i, &position) in chunk.positions.iter().enumerate() {
        // Written so that NaN is refused.
        if !position.iter().all(|x| x.abs() <= MAX_OFFSET_M) {
            continue;
        }
        if records.len() % BLOCK_POINTS == 0 {
            boxes.push(Bounds3::EMPTY);
            stations.push(Mean::default());
        }
        if let Some(block) = boxes.last_mut() {
            block.include(chunk.origin + Vec3::from_array(position).as_dvec3());
        }
        if let (Some(mean), Some(station)) = (stations.last_mut(), chunk.stations.of_point(i)) {
            mean.include(station);
        }
        let colour = surveyed::colour(chunk, i)
            .map_or(0, |[r, g, b]| HAS_COLOUR | u32::from_le_bytes([r, g, b, 0]));
        // Those of a few that stand apart would swell.
        let own = chunk.spacings_m.get(i).map(|&spacing_m| radius_code(radius_m(spacing_m)));
        let code = own.map_or(of_chunk, |own| own.min(of_chunk));
        let [x, y, z] = position.map(f32::to_bits);
        records.push([x, y, z, colour | code << 24]);
        radii.push(code as u8);
        if with_normals {
            let normal = chunk.normals.get(i).copied().unwrap_or_default();
            normals.push(plane_code(Vec3::from_array(normal)));
        }
    }
    let stations = stations.into_iter().map(Mean::get).collect();
    Drawable { records, radii, normals, boxes, stations }
}

/// The mean of some places.
#[derive(Clone, Copy, Default)]
struct Mean {
    sum: DVec3,
    count: u32,
}

impl Mean {
    fn include(&mut self, place: DVec3) {
        self.sum += place;
        self.count += 1;
    }

    fn get(self) -> Option<DVec3> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// Gives every point within the box `within` its own radius, of the codes `radii`, or the smallest
/// of `around` (boxes in the world, and codes) that it lies in, if that is less. Whether any
/// changed.
pub(crate) fn set_radii(
    records: &mut [Record],
    radii: &[u8],
    origin: DVec3,
    within: &Bounds3,
    around: &[(Bounds3, u32)],
) -> bool {
    let local = |bounds: &Bounds3| Local {
        min: (bounds.min - origin).as_vec3(),
        max: (bounds.max - origin).as_vec3(),
    };
    let within = local(within);
    let around: Vec<(Local, u32)> =
        around.iter().map(|(bounds, code)| (local(bounds), *code)).collect();
    let mut changed = false;
    for (record, &own) in records.iter_mut().zip(radii) {
        let p = Vec3::from_array([record[0], record[1], record[2]].map(f32::from_bits));
        if !within.holds(p) {
            continue;
        }
        let own = u32::from(own);
        let holding = around.iter().filter(|(bounds, code)| *code < own && bounds.holds(p));
        let code = holding.map(|(_, code)| *code).min().unwrap_or(own);
        let updated = record[3] & !RADIUS_BITS | code << 24;
        changed |= updated != record[3];
        record[3] = updated;
    }
    changed
}

/// A box relative to a chunk's origin.
struct Local {
    min: Vec3,
    max: Vec3,
}

impl Local {
    fn holds(&self, p: Vec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

#[cfg(test)]
mod tests {
    use flaneur_scene::{NodeKey, PointNodeId, PointStations};

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
            stations: PointStations::default(),
            spacing_m: 0.1,
            spacings_m: Vec::new(),
        };
        let records = drawable(&chunk, |spacing_m| spacing_m, false).records;
        assert_eq!(records[0][3] & HAS_COLOUR, 0);
        assert_eq!(records[1][3] & (HAS_COLOUR | 0xff_ffff), HAS_COLOUR | 1 << 16);
    }

    #[test]
    fn points_have_the_size_of_their_neighbourhood() {
        let chunk = PointChunk {
            id: PointNodeId { source: 0, key: NodeKey::ROOT },
            origin: DVec3::ZERO,
            positions: vec![[0.0; 3], [f32::NAN; 3], [1.0; 3], [2.0; 3], [3.0; 3], [4.0; 3]],
            colours: Vec::new(),
            intensities: Vec::new(),
            classes: vec![0; 6],
            normals: Vec::new(),
            stations: PointStations::default(),
            spacing_m: 0.1,
            // Those that stand apart do not swell, and what makes no sense is bounded.
            spacings_m: vec![0.05, 0.01, 0.02, 0.4, f32::NAN, -1.0],
        };
        let drawable = drawable(&chunk, |spacing_m| 0.5 * spacing_m, false);
        let expected = [0.025, 0.01, 0.05, 0.05, 0.05].map(|m| radius_code(m) as u8);
        assert_eq!(drawable.radii, expected);
        let drawn = drawable.records.iter().map(|record| (record[3] >> 24 & 0x7f) as u8);
        assert!(drawn.eq(expected));
    }

    #[test]
    fn points_take_the_smallest_radius_around_them() {
        let at = |x: f32, code: u32| [x.to_bits(), 0, 0, HAS_COLOUR | code << 24 | 0x123456];
        let origin = DVec3::new(651_000.0, 6_861_000.0, 40.0);
        let span = |x: f64| Bounds3 { min: origin, max: origin + DVec3::new(x, 0.0, 0.0) };
        let mut records = [at(1.0, 40), at(3.0, 40), at(3.2, 20), at(5.0, 8)];
        let radii = [40, 40, 20, 40];
        let around = [(span(2.0), 16), (span(3.5), 30), (span(9.0), 50)];
        assert!(set_radii(&mut records, &radii, origin, &span(4.0), &around));
        let expected = [at(1.0, 16), at(3.0, 30), at(3.2, 20), at(5.0, 8)];
        assert_eq!(records, expected, "what is outside stays, and what is smaller");
        assert!(!set_radii(&mut records, &radii, origin, &span(4.0), &around));
        assert!(set_radii(&mut records, &radii, origin, &span(9.0), &[]));
        let expected = [at(1.0, 40), at(3.0, 40), at(3.2, 20), at(5.0, 40)];
        assert_eq!(records, expected, "nothing smaller is left");
    }
}
