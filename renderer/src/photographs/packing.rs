//! Packing rectangles into a larger one, by cutting it in two again and again.
//!
//! What is given back joins its other half where that is free, so that one from which all was
//! taken away is whole again.

use glam::UVec2;

/// A rectangle that others are taken from and given back to.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    root: Part,
}

/// A rectangle of it.
#[derive(Clone, Debug)]
struct Part {
    corner: UVec2,
    size: UVec2,
    state: State,
}

#[derive(Clone, Debug)]
enum State {
    Free,
    Taken,
    Cut(Box<[Part; 2]>),
}

impl Packing {
    pub(crate) fn new(size: UVec2) -> Self {
        Self { root: Part::free(UVec2::ZERO, size) }
    }

    /// The corner of a free rectangle of `size`, which is then taken: of the free part that it
    /// fills best.
    pub(crate) fn take(&mut self, size: UVec2) -> Option<UVec2> {
        let best = self.root.best(size)?;
        Some(best.take(size))
    }

    /// Gives back the rectangle taken at `corner`.
    pub(crate) fn give_back(&mut self, corner: UVec2) {
        self.root.give_back(corner);
    }

    /// Whether nothing is taken.
    pub(crate) fn is_empty(&self) -> bool {
        matches!(self.root.state, State::Free)
    }
}

impl Part {
    fn free(corner: UVec2, size: UVec2) -> Self {
        Self { corner, size, state: State::Free }
    }

    fn area(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y)
    }

    fn holds(&self, corner: UVec2) -> bool {
        corner.cmpge(self.corner).all() && corner.cmplt(self.corner + self.size).all()
    }

    /// The smallest free part in which `size` has room, the first of equal ones.
    fn best(&mut self, size: UVec2) -> Option<&mut Self> {
        if size.cmpgt(self.size).any() {
            return None;
        }
        if matches!(self.state, State::Free) {
            return Some(self);
        }
        let State::Cut(halves) = &mut self.state else { return None };
        let [a, b] = &mut **halves;
        match (a.best(size), b.best(size)) {
            (Some(a), Some(b)) => Some(if b.area() < a.area() { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// Cuts `size` out of the corner of a free part. What is left over is kept in one piece as
    /// large as can be.
    fn take(&mut self, size: UVec2) -> UVec2 {
        let rest = self.size - size;
        if rest == UVec2::ZERO {
            self.state = State::Taken;
            return self.corner;
        }
        let across = u64::from(rest.x) * u64::from(self.size.y);
        let down = u64::from(rest.y) * u64::from(self.size.x);
        let first = if across > down {
            UVec2::new(size.x, self.size.y)
        } else {
            UVec2::new(self.size.x, size.y)
        };
        let step = if across > down { UVec2::X * size.x } else { UVec2::Y * size.y };
        let mut halves =
            [Self::free(self.corner, first), Self::free(self.corner + step, self.size - step)];
        let corner = halves[0].take(size);
        self.state = State::Cut(Box::new(halves));
        corner
    }

    fn give_back(&mut self, corner: UVec2) {
        match &mut self.state {
            State::Taken if self.corner == corner => self.state = State::Free,
            State::Cut(halves) => {
                if let Some(half) = halves.iter_mut().find(|half| half.holds(corner)) {
                    half.give_back(corner);
                }
                if halves.iter().all(|half| matches!(half.state, State::Free)) {
                    self.state = State::Free;
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever is taken and given back, what is held never overlaps, and what was emptied is
        /// whole again.
        #[test]
        fn what_is_held_never_overlaps(
            steps in prop::collection::vec((1u32..40, 1u32..40, any::<bool>(), 0usize..32), 1..80),
        ) {
            let mut packing = Packing::new(UVec2::splat(100));
            let mut held: Vec<(UVec2, UVec2)> = Vec::new();
            for (width, height, remove, which) in steps {
                if remove && !held.is_empty() {
                    packing.give_back(held.swap_remove(which % held.len()).0);
                } else {
                    let size = UVec2::new(width, height);
                    held.extend(packing.take(size).map(|corner| (corner, size)));
                }
                for (i, (a, a_size)) in held.iter().enumerate() {
                    prop_assert!((a + a_size).max_element() <= 100);
                    for (b, b_size) in &held[..i] {
                        let apart = a.cmpge(b + b_size) | b.cmpge(a + a_size);
                        prop_assert!(apart.any(), "{a} {a_size} meets {b} {b_size}");
                    }
                }
            }
            for (corner, _) in held {
                packing.give_back(corner);
            }
            prop_assert!(packing.is_empty());
            prop_assert_eq!(packing.take(UVec2::splat(100)), Some(UVec2::ZERO));
        }
    }

    #[test]
    fn parts_are_filled() {
        let mut packing = Packing::new(UVec2::splat(64));
        let side = UVec2::splat(32);
        let corners: Vec<UVec2> = (0..4).filter_map(|_| packing.take(side)).collect();
        assert_eq!((corners.len(), packing.take(UVec2::ONE)), (4, None));
        packing.give_back(corners[1]);
        let smaller: Vec<UVec2> = (0..4).filter_map(|_| packing.take(side / 2)).collect();
        assert_eq!((smaller.len(), packing.take(UVec2::ONE)), (4, None), "a quarter each");
    }
}
