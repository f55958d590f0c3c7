//! A polygon with holes as one ring.

use glam::DVec2;

use super::signed_area;
use crate::Polygon;

/// The outline of `polygon` relative to `origin`, counter-clockwise, each hole joined to it by a
/// bridge that is run through in both directions. Relative, since triangulation loses its
/// precision on far coordinates.
///
/// After Eberly ("Triangulation by Ear Clipping", section 4): from the easternmost vertex M of a
/// hole look east to the first edge of the ring; its eastern end is visible from M, unless a
/// vertex of the ring lies in the triangle between, and then the one nearest to the line of sight is.
/// Takes time in proportion to vertices × holes. Holes that are not inside are left out; rings
/// that cross give some ring, but it always ends.
pub(super) fn one_ring(polygon: &Polygon, origin: DVec2) -> Vec<DVec2> {
    let oriented = |ring: &Vec<DVec2>, clockwise: bool| {
        let mut ring: Vec<DVec2> = ring.iter().map(|p| *p - origin).collect();
        if (signed_area(&ring) < 0.0) != clockwise {
            ring.reverse();
        }
        ring
    };
    let mut rings = polygon.rings.iter();
    let mut outline = rings.next().map(|ring| oriented(ring, false)).unwrap_or_default();
    let holes = rings.filter(|hole| hole.len() >= 3).map(|hole| oriented(hole, true));
    let mut holes: Vec<(usize, Vec<DVec2>)> =
        holes.filter_map(|hole| Some((easternmost(&hole)?, hole))).collect();
    // From the east, so that the line of sight meets no hole that is not yet part of the ring.
    holes.sort_by(|(m, a), (n, b)| b[*n].x.total_cmp(&a[*m].x));
    for (start, hole) in holes {
        let beside = hole[(start + 1) % hole.len()];
        if let Some(end) = visible(&outline, hole[start], beside) {
            let bridged = hole.iter().cycle().skip(start).take(hole.len() + 1).copied();
            let back = outline[end];
            outline.splice(end + 1..end + 1, bridged.chain([back]));
        }
    }
    outline
}

fn easternmost(ring: &[DVec2]) -> Option<usize> {
    (0..ring.len()).max_by(|i, j| ring[*i].x.total_cmp(&ring[*j].x))
}

/// A vertex of `ring` to which a straight line from `m` crosses no edge. `beside` is the vertex
/// after `m` in its hole: where the hole touches the ring at `m`, it tells on which side.
fn visible(ring: &[DVec2], m: DVec2, beside: DVec2) -> Option<usize> {
    let touching = (0..ring.len()).find(|&i| ring[i] == m && faces(ring, i, beside));
    if touching.is_some() {
        return touching;
    }
    let next = |i: usize| (i + 1) % ring.len();
    // The ring is counter-clockwise: seen from inside, its eastern edges run north.
    let (edge, x) = (0..ring.len())
        .filter(|&i| ring[i].y <= m.y && m.y < ring[next(i)].y)
        .map(|i| {
            let (a, b) = (ring[i], ring[next(i)]);
            (i, a.x + (m.y - a.y) / (b.y - a.y) * (b.x - a.x))
        })
        .filter(|(_, x)| *x >= m.x)
        .min_by(|(_, x), (_, y)| x.total_cmp(y))?;
    let hit = DVec2::new(x, m.y);
    let end = if ring[edge].x > ring[next(edge)].x { edge } else { next(edge) };
    if ring[end] == hit {
        return Some(end);
    }
    let triangle = [m, hit, ring[end]];
    let slope = |i: usize| (ring[i].y - m.y).abs() / (ring[i].x - m.x).max(f64::MIN_POSITIVE);
    (0..ring.len())
        .filter(|&i| ring[i] != ring[end] && ring[i].x > m.x && holds(&triangle, ring[i]))
        .filter(|&i| faces(ring, i, m))
        .min_by(|&i, &j| {
            let near = |k: usize| ring[k].distance_squared(m);
            slope(i).total_cmp(&slope(j)).then(near(i).total_cmp(&near(j)))
        })
        .or(Some(end))
}

/// Whether `p` lies in the triangle, its border included.
fn holds(triangle: &[DVec2; 3], p: DVec2) -> bool {
    let [a, b, c] = *triangle;
    let side = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a);
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// Whether the inside of the ring at vertex `i` opens towards `m`: of the copies of a vertex that
/// bridges have made, one does.
fn faces(ring: &[DVec2], i: usize, m: DVec2) -> bool {
    let here = ring[i];
    let before = ring[(i + ring.len() - 1) % ring.len()] - here;
    let after = ring[(i + 1) % ring.len()] - here;
    let to = m - here;
    if after.perp_dot(before) > 0.0 {
        after.perp_dot(to) >= 0.0 && to.perp_dot(before) >= 0.0
    } else {
        after.perp_dot(to) >= 0.0 || to.perp_dot(before) >= 0.0
    }
}
