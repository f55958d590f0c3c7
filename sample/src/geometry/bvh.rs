//! A bounding volume hierarchy with binned surface-area splits.

use flaneur_scene::Bounds3;
use glam::{DVec3, Vec3A};

use super::{Hit, Primitive, Ray};

/// Boxes are widened by this before they are rounded to f32: more than the rounding of
/// coordinates and slab distances over streets of a few kilometres.
const PADDING_M: f64 = 2e-3;
const BINS: usize = 12;
const LEAF: usize = 3;

/// The tree over a list of primitives.
#[derive(Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    primitives: Vec<Primitive>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    min: Vec3A,
    max: Vec3A,
    /// First primitive of a leaf, or the second child (the first child follows its parent).
    first: u32,
    /// Primitives of a leaf, 0 for an inner node.
    count: u32,
}

/// What building needs of a primitive.
struct Item {
    bounds: Bounds3,
    centre: DVec3,
    index: usize,
}

impl Bvh {
    /// The tree over `primitives`, whose order it changes.
    pub(crate) fn new(primitives: &[Primitive]) -> Self {
        let mut items: Vec<Item> = primitives
            .iter()
            .enumerate()
            .map(|(index, primitive)| {
                let bounds = primitive.shape.bounds();
                Item { centre: bounds.centre(), bounds, index }
            })
            .collect();
        let mut nodes = Vec::with_capacity(items.len());
        if !items.is_empty() {
            build(&mut nodes, &mut items, 0);
        }
        let primitives = items.iter().map(|item| primitives[item.index]).collect();
        Self { nodes, primitives }
    }

    /// The primitive that a hit names.
    pub(crate) fn primitive(&self, index: u32) -> &Primitive {
        &self.primitives[index as usize]
    }

    /// The box around everything.
    pub(crate) fn bounds(&self) -> Bounds3 {
        self.nodes.first().map_or(Bounds3::EMPTY, |root| Bounds3 {
            min: root.min.as_dvec3(),
            max: root.max.as_dvec3(),
        })
    }

    /// The nearest hit within `limit` metres.
    pub(crate) fn nearest(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut nearest = limit;
        self.visit(ray, limit, |index, primitive| {
            if let Some(contact) = primitive.intersect(ray, nearest) {
                nearest = contact.distance;
                best = Some(Hit { contact, primitive: index });
            }
            Some(nearest)
        });
        best
    }

    /// Whether anything lies within `limit` metres.
    pub(crate) fn is_blocked(&self, ray: &Ray, limit: f64) -> bool {
        let mut blocked = false;
        self.visit(ray, limit, |_, primitive| {
            blocked = primitive.intersect(ray, limit).is_some();
            (!blocked).then_some(limit)
        });
        blocked
    }

    /// Calls `meet` for the primitives of every leaf that the ray crosses, nearer boxes first.
    /// `meet` gives the distance that still matters, or `None` to stop.
    fn visit(&self, ray: &Ray, limit: f64, mut meet: impl FnMut(u32, &Primitive) -> Option<f64>) {
        let Some(root) = self.nodes.first() else { return };
        let origin = ray.origin.as_vec3a();
        let inverse = ray.direction.as_vec3a().recip();
        let mut limit = limit as f32;
        let mut stack = [(0u32, 0f32); 64];
        let mut depth = 0;
        if root.enter(origin, inverse, limit).is_some() {
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (index, enter) = stack[depth];
            if enter > limit {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for i in node.first..node.first + node.count {
                    match meet(i, &self.primitives[i as usize]) {
                        // Rounded up: a box that starts at the hit itself still counts.
                        Some(distance) => limit = (distance as f32).next_up(),
                        None => return,
                    }
                }
                continue;
            }
            let children = [index + 1, node.first];
            let enters =
                children.map(|child| self.nodes[child as usize].enter(origin, inverse, limit));
            let (near, far) =
                if enters[0].unwrap_or(f32::INFINITY) <= enters[1].unwrap_or(f32::INFINITY) {
                    (0, 1)
                } else {
                    (1, 0)
                };
            for child in [far, near] {
                if let Some(enter) = enters[child] {
                    stack[depth] = (children[child], enter);
                    depth += 1;
                }
            }
        }
    }
}

impl Node {
    fn enter(&self, origin: Vec3A, inverse: Vec3A, limit: f32) -> Option<f32> {
        let a = (self.min - origin) * inverse;
        let b = (self.max - origin) * inverse;
        let enter = a.min(b).max_element().max(0.0);
        let exit = a.max(b).min_element();
        (enter <= exit && enter <= limit).then_some(enter)
    }
}

/// Builds the subtree of `items`, whose first item is primitive `offset`; gives its node.
fn build(nodes: &mut Vec<Node>, items: &mut [Item], offset: usize) -> u32 {
    let index = nodes.len();
    let bounds = items.iter().fold(Bounds3::EMPTY, |all, item| all.union(&item.bounds));
    let as_u32 = |n: usize| u32::try_from(n).expect("fewer than 2^32 primitives");
    nodes.push(Node {
        min: (bounds.min - PADDING_M).as_vec3a(),
        max: (bounds.max + PADDING_M).as_vec3a(),
        first: as_u32(offset),
        count: as_u32(items.len()),
    });
    let split = if items.len() > LEAF { partition(items) } else { None };
    if let Some(middle) = split {
        let (left, right) = items.split_at_mut(middle);
        build(nodes, left, offset);
        let second = build(nodes, right, offset + middle);
        nodes[index].first = second;
        nodes[index].count = 0;
    }
    as_u32(index)
}

/// Reorders the items into two groups at the cheapest of the binned splits and gives the
/// size of the first; the middle where all centres coincide. Depth stays far below the
/// traversal's stack because neither group is empty and splits are by position.
fn partition(items: &mut [Item]) -> Option<usize> {
    let mut centres = Bounds3::EMPTY;
    items.iter().for_each(|item| centres.include(item.centre));
    let extent = centres.max - centres.min;
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b]))?;
    if !(extent[axis] > 1e-9) {
        return Some(items.len() / 2);
    }
    let bin = |item: &Item| {
        let at = (item.centre[axis] - centres.min[axis]) / extent[axis];
        ((at * BINS as f64) as usize).min(BINS - 1)
    };
    let mut bins = [(Bounds3::EMPTY, 0usize); BINS];
    for item in items.iter() {
        let slot = &mut bins[bin(item)];
        *slot = (slot.0.union(&item.bounds), slot.1 + 1);
    }
    let cost = |bins: &[(Bounds3, usize)]| {
        let (bounds, count) =
            bins.iter().fold((Bounds3::EMPTY, 0), |(b, n), x| (b.union(&x.0), n + x.1));
        let size = (bounds.max - bounds.min).max(DVec3::ZERO);
        (size.x * size.y + size.y * size.z + size.z * size.x) * count as f64
    };
    let best = (1..BINS).min_by(|&a, &b| {
        let total = |k: usize| cost(&bins[..k]) + cost(&bins[k..]);
        total(a).total_cmp(&total(b))
    })?;
    items.sort_by_key(|item| bin(item) >= best);
    let middle = items.iter().position(|item| bin(item) >= best)?;
    Some(if middle == 0 { items.len() / 2 } else { middle })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Cutout, Shape};
    use crate::look::noise::unit;

    /// The tree finds what a search through the whole list finds, from far away too.
    #[test]
    fn nearest_agrees_with_exhaustive_search() {
        for shift in [0.0, 2000.0] {
            let point = |i: u32, k: u32| {
                DVec3::new(unit(i, k), unit(i, k + 1), unit(i, k + 2)) * 20.0 + DVec3::X * shift
            };
            let primitives: Vec<Primitive> = (0..400)
                .map(|i| {
                    let at = point(i, 0);
                    let shape = match i % 4 {
                        0 => Shape::Block { min: at, max: at + 0.5 + unit(i, 9) },
                        1 => Shape::Ellipsoid { centre: at, radii: DVec3::new(0.5, 0.3, 1.0) },
                        2 => Shape::triangle(at, at + DVec3::Y, at + DVec3::new(0.3, 0.2, 1.0)),
                        _ => Shape::Disc { centre: at, normal: DVec3::Y, radius: 0.7 },
                    };
                    Primitive { shape, surface: i, cutout: Cutout::None }
                })
                .collect();
            let tree = Bvh::new(&primitives);
            let mut hits = 0;
            for i in 0..2000 {
                let (from, to) = (point(i + 1000, 0), point(i + 1000, 3));
                let ray = Ray { origin: from, direction: (to - from).normalize() };
                let found = tree.nearest(&ray, 1e9);
                let expected = primitives
                    .iter()
                    .filter_map(|p| p.intersect(&ray, 1e9).map(|c| (c.distance, p.surface)))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                let found =
                    found.map(|hit| (hit.contact.distance, tree.primitive(hit.primitive).surface));
                assert_eq!(found, expected, "ray {i}, shift {shift}");
                assert_eq!(tree.is_blocked(&ray, 1e9), expected.is_some());
                hits += u32::from(expected.is_some());
            }
            assert!(hits > 200, "the test has hits: {hits}");
        }
    }
}
