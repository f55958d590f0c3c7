//! Which boxes a ray meets: a tree, so that a ray asks few of many.

use flaneur_scene::Bounds3;
use glam::DVec3;

use super::Ray;

/// Items of a leaf.
const LEAF: usize = 4;

/// Boxes around items, as a binary tree.
#[derive(Debug, Default)]
pub(super) struct Boxes {
    nodes: Vec<Node>,
    /// Items, those of a leaf together.
    items: Vec<usize>,
}

#[derive(Debug)]
struct Node {
    bounds: Bounds3,
    /// Its items; those of a branch are its children's.
    first: usize,
    end: usize,
    /// The second child of a branch; the first one follows the branch.
    second: Option<usize>,
}

/// The first thing that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct First<T> {
    pub(super) item: usize,
    /// What it is ordered by, at least its depth.
    pub(super) key: f64,
    pub(super) hit: T,
}

impl Boxes {
    pub(super) fn new(bounds: &[Bounds3]) -> Self {
        let mut tree = Self { nodes: Vec::new(), items: (0..bounds.len()).collect() };
        if !bounds.is_empty() {
            tree.split(bounds, 0, bounds.len());
        }
        tree
    }

    /// Of the items for which `meet` gives a key and a hit, the one with the lowest key, then
    /// the lowest number. No key may be less than the depth at which the ray enters the box.
    pub(super) fn first<T: Copy>(
        &self,
        ray: &Ray,
        meet: impl Fn(usize) -> Option<(f64, T)>,
    ) -> Option<First<T>> {
        let mut found: Option<First<T>> = None;
        let mut open: Vec<usize> = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(index) = open.pop() {
            let node = &self.nodes[index];
            let limit = found.as_ref().map_or(f64::INFINITY, |first| first.key);
            if !entry(ray, &node.bounds).is_some_and(|depth| depth <= limit) {
                continue;
            }
            if let Some(second) = node.second {
                open.extend([second, index + 1]);
                continue;
            }
            for &item in &self.items[node.first..node.end] {
                let Some((key, hit)) = meet(item) else { continue };
                if found.is_none_or(|f| key < f.key || (key == f.key && item < f.item)) {
                    found = Some(First { item, key, hit });
                }
            }
        }
        found
    }

    fn split(&mut self, bounds: &[Bounds3], first: usize, end: usize) {
        let items = &mut self.items[first..end];
        let (mut whole, mut centres) = (Bounds3::EMPTY, Bounds3::EMPTY);
        for &item in items.iter() {
            whole = whole.union(&bounds[item]);
            centres.include(bounds[item].centre());
        }
        let node = self.nodes.len();
        self.nodes.push(Node { bounds: whole, first, end, second: None });
        if items.len() <= LEAF {
            return;
        }
        let extent = centres.max - centres.min;
        let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
        let middle = items.len() / 2;
        let along = |item: usize| bounds[item].centre()[axis];
        items.select_nth_unstable_by(middle, |&a, &b| along(a).total_cmp(&along(b)));
        self.split(bounds, first, first + middle);
        self.nodes[node].second = Some(self.nodes.len());
        self.split(bounds, first + middle, end);
    }
}

/// Depth at which the ray enters the box, 0 inside; `None` where it misses it.
fn entry(ray: &Ray, bounds: &Bounds3) -> Option<f64> {
    // A little wider than the box, for what lies in its faces.
    let margin = 1e-9 * (1.0 + (bounds.max - bounds.min).max_element());
    let (min, max) = (bounds.min - DVec3::splat(margin), bounds.max + DVec3::splat(margin));
    let (mut enter, mut leave) = (0f64, f64::INFINITY);
    for axis in 0..3 {
        let at = |face: f64| (face - ray.origin[axis]) / ray.direction[axis];
        let (a, b) = (at(min[axis]), at(max[axis]));
        // 0 / 0, where the ray lies in a face, is no number and bounds nothing.
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some(enter)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every ray finds what asking all items finds.
    #[test]
    fn the_tree_misses_nothing() {
        let at = |i: usize, step: f64| ((i as f64 + 0.5) * step).fract() * 20.0 - 10.0;
        let centres: Vec<DVec3> =
            (0..300).map(|i| DVec3::new(at(i, 0.618), at(i, 0.7549), at(i, 0.5698))).collect();
        let radius = 0.8;
        let bounds: Vec<Bounds3> =
            centres.iter().map(|&c| Bounds3 { min: c - radius, max: c + radius }).collect();
        let tree = Boxes::new(&bounds);
        let mut hits = 0;
        for i in 0..500 {
            let direction = DVec3::new(at(i, 0.3247), at(i, 0.4301), at(i, 0.1234));
            // Some along an axis, in the faces of boxes.
            let direction = if i % 5 == 0 { DVec3::X } else { direction };
            let ray = Ray { origin: centres[i % 300] - direction, direction };
            let meet = |item: usize| {
                let to = centres[item] - ray.origin;
                let d = ray.direction;
                let (b, c) = (to.dot(d), to.length_squared() - radius * radius);
                let root = (b * b - c * d.length_squared()).sqrt();
                let t = (b - root) / d.length_squared();
                (t > 0.0).then_some((t, ()))
            };
            let found = tree.first(&ray, meet).map(|f| f.item);
            let expected = (0..300)
                .filter_map(|item| Some((item, meet(item)?.0)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(item, _)| item);
            hits += usize::from(expected.is_some());
            assert_eq!(found, expected, "ray {i}");
        }
        assert!(hits > 200, "{hits}");
        assert!(
            Boxes::new(&[])
                .first(&Ray { origin: DVec3::ZERO, direction: DVec3::X }, |_| Some((0.0, ())))
                .is_none()
        );
    }
}
