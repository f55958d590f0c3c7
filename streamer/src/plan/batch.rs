//! Parts that share a request.

use std::collections::BTreeSet;

use super::part::{Part, Want};

/// Most parts of a batch.
const MOST_PARTS: usize = 64;
/// How many wants behind the first are looked at: what comes much later must not come along.
const REACH: usize = 256;

/// Names a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct BatchId(pub(super) u64);

/// What may be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Room {
    /// Bytes at once, where they are more than one part.
    pub(crate) bytes: u64,
    /// Bytes that will have come in a moment: a level of an image whose finer one is among them is not
    /// worth its own.
    pub(crate) soon: u64,
}

/// Parts for one request, in the order in which they are wanted. Where requests ask for cells, they
/// are a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Batch {
    /// Its name.
    pub(crate) id: BatchId,
    /// The parts.
    pub(crate) parts: Vec<Part>,
    /// Bytes that are expected.
    pub(crate) bytes: u64,
}

/// The first of `missing` with what may go along: of the same kind and stage, as many as are not
/// more than `most_bytes` together.
pub(super) fn gather(missing: &[&Want], most_bytes: u64) -> (Vec<Part>, u64) {
    let Some(first) = missing.first() else { return (Vec::new(), 0) };
    let along = missing.iter().take(REACH).filter(|want| {
        want.stage == first.stage && (want.part == first.part || want.part.goes_with(&first.part))
    });
    let mut parts: Vec<&Want> = Vec::new();
    let mut bytes = 0;
    for want in along.take(MOST_PARTS) {
        if !parts.is_empty() && bytes + want.bytes > most_bytes {
            break;
        }
        bytes += want.bytes;
        parts.push(want);
    }
    if first.part.cell().is_some() {
        let cells: BTreeSet<(i32, i32)> = parts.iter().filter_map(|w| w.part.cell()).collect();
        let inside = first.part.cell().map(|cell| rectangle(cell, &cells));
        parts.retain(|want| want.part.cell().zip(inside).is_some_and(|(c, r)| r.holds(c)));
        bytes = parts.iter().map(|want| want.bytes).sum();
    }
    (parts.into_iter().map(|want| want.part.clone()).collect(), bytes)
}

/// Cells from a low corner to a high one, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rectangle {
    low: (i32, i32),
    high: (i32, i32),
}

impl Rectangle {
    fn holds(self, (x, y): (i32, i32)) -> bool {
        (self.low.0..=self.high.0).contains(&x) && (self.low.1..=self.high.1).contains(&y)
    }

    /// Whether all of its cells are in `cells`.
    fn is_full(self, cells: &BTreeSet<(i32, i32)>) -> bool {
        (self.low.1..=self.high.1)
            .all(|y| (self.low.0..=self.high.0).all(|x| cells.contains(&(x, y))))
    }
}

/// A rectangle around `cell`, all of whose cells are in `cells`, grown until no side can move.
fn rectangle(cell: (i32, i32), cells: &BTreeSet<(i32, i32)>) -> Rectangle {
    let mut found = Rectangle { low: cell, high: cell };
    loop {
        let Rectangle { low, high } = found;
        let grown = [
            Rectangle { low: (low.0.saturating_sub(1), low.1), high },
            Rectangle { low, high: (high.0.saturating_add(1), high.1) },
            Rectangle { low: (low.0, low.1.saturating_sub(1)), high },
            Rectangle { low, high: (high.0, high.1.saturating_add(1)) },
        ];
        match grown.into_iter().find(|next| *next != found && next.is_full(cells)) {
            Some(next) => found = next,
            None => return found,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_hold_nothing_that_is_not_wanted() {
        let block = |x: std::ops::Range<i32>, y: std::ops::Range<i32>| {
            y.flat_map(move |y| x.clone().map(move |x| (x, y)))
        };
        let whole: BTreeSet<_> = block(-1..2, 5..8).collect();
        let all = Rectangle { low: (-1, 5), high: (1, 7) };
        assert_eq!(rectangle((0, 6), &whole), all);
        let with_hole: BTreeSet<_> = whole.iter().copied().filter(|c| *c != (0, 6)).collect();
        let part = rectangle((-1, 5), &with_hole);
        assert!(part.is_full(&with_hole) && part.holds((-1, 5)) && part != all);
        let edge = BTreeSet::from([(i32::MAX, i32::MIN)]);
        assert!(rectangle((i32::MAX, i32::MIN), &edge).is_full(&edge));
    }
}
