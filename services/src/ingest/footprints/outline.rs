//! Which polygons can be extruded.

use flaneur_scene::Polygon;
use geo::Coord;
use geo::algorithm::kernels::{Kernel, Orientation, RobustKernel};
use glam::DVec2;

/// Coordinates beyond this, in metres, are no place on Earth.
const FARTHEST_M: f64 = 1e8;

/// The most vertices of a polygon.
const MOST_VERTICES: usize = 1_000_000;

/// The most pairs of edges that are compared for one polygon: honest outlines need a few for each
/// edge.
const MOST_PAIRS: u64 = 20_000_000;

/// The least area, square metres: a decimetre squared is no building.
const LEAST_AREA_M2: f64 = 0.01;

/// The polygon without repeated vertices, and why holes were left out of it.
///
/// # Errors
///
/// Says why the polygon cannot be extruded: a coordinate that is no number or out of range, fewer
/// than three points, edges that cross, or no area.
pub(super) fn clean(polygon: Polygon) -> Result<(Polygon, Vec<String>), String> {
    let vertices: usize = polygon.rings.iter().map(Vec::len).sum();
    if vertices > MOST_VERTICES {
        return Err(format!("it has {vertices} vertices, more than {MOST_VERTICES}"));
    }
    let mut dropped = Vec::new();
    let mut rings = Vec::with_capacity(polygon.rings.len());
    for (index, mut ring) in polygon.rings.into_iter().enumerate() {
        let far = |vertex: &&DVec2| !vertex.abs().cmple(DVec2::splat(FARTHEST_M)).all();
        if let Some(vertex) = ring.iter().find(far) {
            return Err(format!("it has a vertex at {vertex}"));
        }
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        let problem = match ring.len() {
            0 => Some("it has no points".to_owned()),
            n @ 1..=2 => Some(format!("it has {n} points, a polygon has at least 3")),
            _ => None,
        };
        match problem {
            Some(problem) if index == 0 => return Err(problem),
            Some(problem) => dropped.push(format!("hole {index}: {problem}")),
            None => rings.push(ring),
        }
    }
    if rings.is_empty() {
        return Err("it has no points".to_owned());
    }
    if let Some(place) = crossing(&rings)? {
        return Err(format!("its outline crosses itself near {place}"));
    }
    let mut index = 0;
    let mut outer = None;
    rings.retain(|ring| {
        let area = area(ring);
        let kept = area >= LEAST_AREA_M2;
        if index == 0 {
            outer = Some(area);
        } else if !kept {
            dropped.push(format!("hole of {area} m² is left out"));
        }
        index += 1;
        kept
    });
    match outer {
        Some(area) if !(area >= LEAST_AREA_M2) => Err(format!("its area is {area} m²")),
        _ => Ok((Polygon { rings }, dropped)),
    }
}

/// The area of a ring in square metres, relative to its first vertex: far coordinates would cost
/// the sum its precision.
pub(super) fn area(ring: &[DVec2]) -> f64 {
    let Some(&first) = ring.first() else { return 0.0 };
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    edges.map(|(a, b)| (a - first).perp_dot(b - first)).sum::<f64>().abs() / 2.0
}

/// Whether `p` lies in the polygon, by the even-odd rule over all rings.
pub(super) fn contains(polygon: &Polygon, p: DVec2) -> bool {
    let mut inside = false;
    for ring in &polygon.rings {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let upward = b.y > a.y;
            let spans = (a.y > p.y) != (b.y > p.y);
            // Which side of the edge, without a division.
            let left = (p.x - a.x) * (b.y - a.y) < (b.x - a.x) * (p.y - a.y);
            inside ^= spans && left == upward;
        }
    }
    inside
}

struct Edge {
    a: DVec2,
    b: DVec2,
}

/// Where two edges cross, each on both sides of the other. Edges that only touch do no harm:
/// the triangles of a roof are the same.
///
/// A sweep from west to east that compares edges whose ranges of x overlap; signs are exact.
fn crossing(rings: &[Vec<DVec2>]) -> Result<Option<DVec2>, String> {
    let mut edges: Vec<Edge> = rings
        .iter()
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
        .map(|(a, b)| Edge { a: *a, b: *b })
        .collect();
    let west = |edge: &Edge| edge.a.x.min(edge.b.x);
    edges.sort_by(|e, f| west(e).total_cmp(&west(f)));
    let mut active: Vec<&Edge> = Vec::new();
    let mut pairs = 0;
    for edge in &edges {
        active.retain(|other| other.a.x.max(other.b.x) >= west(edge));
        pairs += active.len() as u64;
        if pairs > MOST_PAIRS {
            return Err("its outline is too tangled to be checked".to_owned());
        }
        if let Some(other) = active.iter().find(|other| cross(edge, other)) {
            return Ok(Some((edge.a + edge.b + other.a + other.b) / 4.0));
        }
        active.push(edge);
    }
    Ok(None)
}

fn cross(e: &Edge, f: &Edge) -> bool {
    let apart = e.a.y.max(e.b.y) < f.a.y.min(f.b.y) || f.a.y.max(f.b.y) < e.a.y.min(e.b.y);
    !apart && separates(e, f.a, f.b) && separates(f, e.a, e.b)
}

/// Whether `p` and `q` lie strictly on either side of the line of `e`.
fn separates(e: &Edge, p: DVec2, q: DVec2) -> bool {
    let coord = |v: DVec2| Coord { x: v.x, y: v.y };
    let side = |p| RobustKernel::orient2d(coord(e.a), coord(e.b), coord(p));
    matches!(
        (side(p), side(q)),
        (Orientation::Clockwise, Orientation::CounterClockwise)
            | (Orientation::CounterClockwise, Orientation::Clockwise)
    )
}
