//! Packing rectangles into a square, in shelves.

use glam::UVec2;

/// A square that rectangles are taken from and given back to.
#[derive(Debug)]
pub(crate) struct Shelves {
    side: u32,
    /// From the top; together they reach from 0 to `used`.
    shelves: Vec<Shelf>,
    used: u32,
}

#[derive(Debug)]
struct Shelf {
    y: u32,
    height: u32,
    /// Free spans `(start, end)`, ascending, not touching.
    free: Vec<(u32, u32)>,
}

impl Shelves {
    pub(crate) fn new(side: u32) -> Self {
        Self { side, shelves: Vec::new(), used: 0 }
    }

    /// The corner of a free rectangle of `size`, which is then taken.
    pub(crate) fn take(&mut self, size: UVec2) -> Option<UVec2> {
        let shelf = match self.shelves.iter().position(|shelf| shelf.suits(size, self.side)) {
            Some(shelf) => shelf,
            None => self.open(size)?,
        };
        let shelf = &mut self.shelves[shelf];
        let span = shelf.free.iter().position(|(start, end)| end - start >= size.x)?;
        let x = shelf.free[span].0;
        shelf.free[span].0 += size.x;
        shelf.free.retain(|(start, end)| start < end);
        Some(UVec2::new(x, shelf.y))
    }

    /// Gives back the rectangle of `size` taken at `corner`.
    pub(crate) fn give_back(&mut self, corner: UVec2, size: UVec2) {
        let Some(shelf) = self.shelves.iter_mut().find(|shelf| shelf.y == corner.y) else { return };
        shelf.free.push((corner.x, corner.x + size.x));
        shelf.free.sort_unstable();
        shelf.free.dedup_by(|next, last| {
            let touching = last.1 == next.0;
            if touching {
                last.1 = next.1;
            }
            touching
        });
        while self.shelves.last().is_some_and(|shelf| shelf.free == [(0, self.side)]) {
            self.used -= self.shelves.pop().map_or(0, |shelf| shelf.height);
        }
    }

    /// Whether nothing is taken.
    pub(crate) fn is_empty(&self) -> bool {
        self.shelves.iter().all(|shelf| shelf.free == [(0, self.side)])
    }

    fn open(&mut self, size: UVec2) -> Option<usize> {
        if size.x > self.side || size.y > self.side - self.used {
            return None;
        }
        let free = vec![(0, self.side)];
        self.shelves.push(Shelf { y: self.used, height: size.y, free });
        self.used += size.y;
        Some(self.shelves.len() - 1)
    }
}

impl Shelf {
    /// Whether the rectangle fits without wasting more than half of the shelf's height,
    /// unless the shelf is empty anyway.
    fn suits(&self, size: UVec2, side: u32) -> bool {
        let snug = 2 * size.y > self.height || self.free == [(0, side)];
        size.y <= self.height && snug && self.free.iter().any(|(s, e)| e - s >= size.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever is taken and given back, what is held never overlaps, and an emptied
        /// square is whole again.
        #[test]
        fn what_is_held_never_overlaps(
            steps in prop::collection::vec((1u32..40, 1u32..40, any::<bool>(), 0usize..32), 1..80),
        ) {
            let mut shelves = Shelves::new(100);
            let mut held: Vec<(UVec2, UVec2)> = Vec::new();
            for (width, height, remove, which) in steps {
                if remove && !held.is_empty() {
                    let (corner, size) = held.swap_remove(which % held.len());
                    shelves.give_back(corner, size);
                } else if let Some(corner) = shelves.take(UVec2::new(width, height)) {
                    held.push((corner, UVec2::new(width, height)));
                }
                for (i, (a, a_size)) in held.iter().enumerate() {
                    prop_assert!((a + a_size).max_element() <= 100);
                    for (b, b_size) in &held[..i] {
                        let apart = a.cmpge(b + b_size) | b.cmpge(a + a_size);
                        prop_assert!(apart.any(), "{a} {a_size} meets {b} {b_size}");
                    }
                }
            }
            for (corner, size) in held {
                shelves.give_back(corner, size);
            }
            prop_assert_eq!(shelves.take(UVec2::splat(100)), Some(UVec2::ZERO));
        }
    }
}
