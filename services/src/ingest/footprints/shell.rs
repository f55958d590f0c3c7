//! The outline on which a solid stands.

use std::collections::{BTreeMap, HashMap};

use flaneur_scene::Polygon;
use glam::{DVec2, DVec3};

use super::outline;

/// A face of a solid: its outer ring, then its holes.
pub(super) struct Face {
    pub(super) rings: Vec<Vec<DVec3>>,
    /// Whether the file says that it is the ground surface.
    pub(super) is_ground: bool,
}

/// A downward face belongs to the foot of a building when it lies in this lowest part of its
/// height: others are the undersides of what juts out.
const FOOT_SHARE: f64 = 0.25;

/// The cosine of the steepest face that counts as looking down or up.
const LEVEL: f64 = 0.05;

/// The plan outlines of the solid: of its ground surfaces where it names some, else of the faces
/// that look down at its foot, else, where it has no floor, of those that look up.
///
/// Faces that share an edge become one polygon. Vertices are those of the faces, unaltered.
pub(super) fn footprint(faces: &[Face]) -> Vec<Polygon> {
    let heights = || faces.iter().flat_map(|face| face.rings.iter().flatten().map(|p| p.z));
    let (lowest, top) =
        heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
    let foot = lowest + FOOT_SHARE * (top - lowest);
    let steps: [&dyn Fn(&Face) -> bool; 3] = [
        &|face| face.is_ground,
        &|face| {
            let at_foot = face.rings.iter().flatten().all(|p| p.z <= foot);
            at_foot && upness(face).is_some_and(|up| up < -LEVEL)
        },
        &|face| upness(face).is_some_and(|up| up > LEVEL),
    ];
    for step in steps {
        let polygons = union(faces.iter().filter(|face| step(face)));
        if !polygons.is_empty() {
            return polygons;
        }
    }
    Vec::new()
}

/// The vertical part of a face's unit normal (Newell's), 1 for a floor seen from above.
fn upness(face: &Face) -> Option<f64> {
    let ring = face.rings.first()?;
    let first = *ring.first()?;
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let normal: DVec3 = edges.map(|(a, b)| (*a - first).cross(*b - first)).sum();
    normal.try_normalize().map(|normal| normal.z)
}

/// A place in the plan, as the key of a map. Adding zero makes one of the two zeros.
fn key(p: DVec2) -> [u64; 2] {
    [(p.x + 0.0).to_bits(), (p.y + 0.0).to_bits()]
}

/// Joins faces that meet without overlap, seen from above: an edge that two of them run through in
/// opposite directions is inside, and what remains is the outline.
fn union<'a>(faces: impl Iterator<Item = &'a Face>) -> Vec<Polygon> {
    let mut edges: HashMap<([u64; 2], [u64; 2]), usize> = HashMap::new();
    for face in faces {
        for (index, ring) in face.rings.iter().enumerate() {
            let mut ring: Vec<DVec2> = ring.iter().map(|p| p.truncate()).collect();
            // Outer rings run counter-clockwise, holes clockwise: the face is on the left.
            if (turning(&ring) > 0.0) != (index == 0) {
                ring.reverse();
            }
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let (a, b) = (key(*a), key(*b));
                if let Some(opposite) = edges.get_mut(&(b, a)).filter(|count| **count > 0) {
                    *opposite -= 1;
                } else if a != b {
                    *edges.entry((a, b)).or_default() += 1;
                }
            }
        }
    }
    // Ordered, so that the same file always gives the same outline.
    let mut from: BTreeMap<[u64; 2], Vec<[u64; 2]>> = BTreeMap::new();
    for ((a, b), count) in edges {
        from.entry(a).or_default().extend(std::iter::repeat_n(b, count));
    }
    from.values_mut().for_each(|ends| ends.sort_unstable());
    let mut rings = Vec::new();
    while let Some(start) = from.iter().find(|(_, ends)| !ends.is_empty()).map(|(a, _)| *a) {
        rings.extend(loop_from(start, &mut from));
        from.retain(|_, ends| !ends.is_empty());
    }
    nest(rings)
}

/// Follows edges from `start` until they return, taking them out of the map.
fn loop_from(start: [u64; 2], from: &mut BTreeMap<[u64; 2], Vec<[u64; 2]>>) -> Option<Vec<DVec2>> {
    let point = |key: [u64; 2]| DVec2::new(f64::from_bits(key[0]), f64::from_bits(key[1]));
    let mut ring = vec![point(start)];
    let mut at = from.get_mut(&start)?.pop()?;
    while at != start {
        let (before, here) = (*ring.last()?, point(at));
        let along = here - before;
        // Where outlines touch, the sharpest turn to the left stays on the same one.
        let left = |end: &[u64; 2]| along.angle_to(point(*end) - here);
        let ends = from.get_mut(&at)?;
        let next = (0..ends.len()).max_by(|i, j| left(&ends[*i]).total_cmp(&left(&ends[*j])))?;
        ring.push(here);
        at = ends.swap_remove(next);
    }
    (ring.len() >= 3).then_some(ring)
}

/// Polygons from outer rings (counter-clockwise) and holes.
fn nest(rings: Vec<Vec<DVec2>>) -> Vec<Polygon> {
    let (outer, holes): (Vec<_>, Vec<_>) = rings.into_iter().partition(|r| turning(r) > 0.0);
    let mut polygons: Vec<Polygon> =
        outer.into_iter().map(|ring| Polygon { rings: vec![ring] }).collect();
    for hole in holes {
        let middle = hole.first().zip(hole.get(1)).map(|(a, b)| a.midpoint(*b));
        let around = polygons
            .iter_mut()
            .filter(|polygon| middle.is_some_and(|p| outline::contains(polygon, p)))
            .min_by(|a, b| area(a).total_cmp(&area(b)));
        if let Some(polygon) = around {
            polygon.rings.push(hole);
        }
    }
    polygons
}

fn area(polygon: &Polygon) -> f64 {
    polygon.rings.first().map_or(0.0, |ring| outline::area(ring))
}

/// Twice the signed area of a ring, positive counter-clockwise.
fn turning(ring: &[DVec2]) -> f64 {
    let Some(&first) = ring.first() else { return 0.0 };
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    edges.map(|(a, b)| (a - first).perp_dot(b - first)).sum()
}
