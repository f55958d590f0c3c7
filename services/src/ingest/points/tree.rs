//! The octree of points that fit in memory.
//!
//! Top down: a node takes one point of each occupied cell of its grid (2^`grid_bits` along
//! an edge), the one nearest the cell's centre, so that each level is spread evenly; the
//! others go to its children. A node with few points keeps them all and is a leaf, and a
//! child that would be tiny stays in its parent. Every point ends up in exactly one node.

use std::ops::Range;

use flaneur_scene::NodeKey;
use rayon::prelude::*;

use super::morton::{CELL_LEVELS, CODE_BITS, distance_to_centre};

/// A node with at most this many points is a leaf.
pub(super) const LEAF_POINTS: usize = 65_536;

/// A child with fewer points than this stays in its parent.
pub(super) const LEAST_CHILD: usize = 2_048;

/// The root's grid is the finest, of at most 2⁷ cells along an edge, that samples no more
/// points than this. Surfaces get 2⁷, and solids a coarser one.
const MOST_SAMPLED: usize = 100_000;

/// The level from which codes are counted, once those counted from 0 end.
const SECOND_BASE: u32 = CELL_LEVELS - CODE_BITS;

/// A point: its Morton code and its place in the list of records. Twelve bytes, so the code
/// is kept in halves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    high: u32,
    low: u32,
    pub(super) index: u32,
}

/// A node's points, as a range of the list of keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct NodePoints {
    pub(super) key: NodeKey,
    pub(super) range: Range<usize>,
}

impl Key {
    pub(super) fn new(code: u64, index: u32) -> Self {
        Self { high: (code >> 32) as u32, low: code as u32, index }
    }

    pub(super) fn code(self) -> u64 {
        u64::from(self.high) << 32 | u64::from(self.low)
    }
}

/// The level from which the codes for a node of this level are counted.
pub(super) fn code_base(level: u32, grid_bits: u32) -> u32 {
    if level + grid_bits <= CODE_BITS { 0 } else { SECOND_BASE }
}

/// Bits of the grid that suits points that occupy `occupied(bits)` cells of a grid with
/// 2^`bits` along the root's edge.
pub(super) fn suitable_grid_bits(occupied: impl Fn(u32) -> usize) -> u32 {
    [7, 6].into_iter().find(|bits| occupied(*bits) <= MOST_SAMPLED).unwrap_or(5)
}

/// Cells of the root's grid with 2^`bits` along an edge that hold points with these sorted
/// codes counted from level 0.
pub(super) fn occupied_cells(keys: &[Key], bits: u32) -> usize {
    let shift = 3 * (CODE_BITS - bits);
    1 + keys.windows(2).filter(|w| w[0].code() >> shift != w[1].code() >> shift).count()
}

/// Distributes `keys`, sorted and all inside `root`, over nodes, reordering them. `rekey`
/// gives keys the codes that are counted from a level.
///
/// The nodes come with every parent before its children and in Morton order within a level.
pub(super) fn build_tree(
    keys: &mut [Key],
    root: NodeKey,
    grid_bits: u32,
    rekey: &(impl Fn(&mut [Key], u32) + Sync),
) -> Vec<NodePoints> {
    let builder = Builder { grid_bits, rekey };
    let mut nodes = builder.build(keys, 0, root, code_base(root.level, grid_bits));
    nodes.sort_by_key(|node| node.key.level);
    nodes
}

/// Moves one point of each cell of the `level`-th level to the end of `keys`, keeping the
/// order of the others; returns how many others there are. The codes are counted from
/// `base`, and all points are in one cell of that level.
pub(super) fn sample_to_end(keys: &mut [Key], level: u32, base: u32) -> usize {
    let level = level.max(base);
    let picks = nearest_to_centres(keys, cell_bits(level, base));
    move_to_end(keys, picks.into_iter().map(|pick| pick..pick + 1))
}

struct Builder<'a, F> {
    grid_bits: u32,
    rekey: &'a F,
}

impl<F: Fn(&mut [Key], u32) + Sync> Builder<'_, F> {
    fn build(
        &self,
        keys: &mut [Key],
        start: usize,
        node: NodeKey,
        mut base: u32,
    ) -> Vec<NodePoints> {
        let deepest = CELL_LEVELS - self.grid_bits;
        if keys.len() <= LEAF_POINTS || node.level == deepest {
            return vec![NodePoints { key: node, range: start..start + keys.len() }];
        }
        if code_base(node.level, self.grid_bits) != base {
            base = SECOND_BASE;
            (self.rekey)(keys, base);
            keys.sort_unstable();
        }
        let picks = nearest_to_centres(keys, cell_bits(node.level + self.grid_bits, base));
        let children = Children::split(keys, node, base, &picks);
        let own = children.own.into_iter();
        let rest = move_to_end(keys, own);

        let mut jobs = Vec::new();
        let mut left = &mut keys[..rest];
        let mut position = start;
        for (child, length) in children.large {
            let (keys, others) = left.split_at_mut(length);
            jobs.push((child, keys, position));
            left = others;
            position += length;
        }
        let below: Vec<_> = jobs
            .into_par_iter()
            .map(|(child, keys, position)| self.build(keys, position, child, base))
            .collect();
        let mut nodes = vec![NodePoints { key: node, range: position..start + keys.len() }];
        nodes.extend(below.into_iter().flatten());
        nodes
    }
}

/// What a node keeps and what goes below.
struct Children {
    /// Ranges of keys that the node keeps: its sample and its tiny children.
    own: Vec<Range<usize>>,
    /// The other children with the number of their points.
    large: Vec<(NodeKey, usize)>,
}

impl Children {
    fn split(keys: &[Key], node: NodeKey, base: u32, picks: &[usize]) -> Self {
        let shift = 3 * cell_bits(node.level + 1, base);
        let octant = |key: &Key| (key.code() >> shift & 7) as usize;
        let mut own = Vec::with_capacity(picks.len());
        let mut large = Vec::new();
        let (mut begin, mut first_pick) = (0, 0);
        for (number, child) in node.children().into_iter().enumerate() {
            let end = begin + keys[begin..].partition_point(|key| octant(key) <= number);
            let last_pick = first_pick + picks[first_pick..].partition_point(|pick| *pick < end);
            let sampled = &picks[first_pick..last_pick];
            let rest = end - begin - sampled.len();
            if rest < LEAST_CHILD {
                own.push(begin..end);
            } else {
                own.extend(sampled.iter().map(|pick| *pick..pick + 1));
                large.push((child, rest));
            }
            (begin, first_pick) = (end, last_pick);
        }
        Self { own, large }
    }
}

/// Levels of a code below a cell of this level.
fn cell_bits(level: u32, base: u32) -> u32 {
    base + CODE_BITS - level
}

/// For each run of keys in one cell, of which `bits` levels lie below, the place of the one
/// nearest the cell's centre; the first where several are equally near.
fn nearest_to_centres(keys: &[Key], bits: u32) -> Vec<usize> {
    let shift = 3 * bits;
    let inside = (1u64 << shift) - 1;
    let mut picks = Vec::new();
    let mut cell = None;
    let mut nearest = u64::MAX;
    for (place, key) in keys.iter().enumerate() {
        let code = key.code();
        if cell != Some(code >> shift) {
            cell = Some(code >> shift);
            picks.push(place);
            nearest = distance_to_centre(code & inside, bits);
        } else {
            let distance = distance_to_centre(code & inside, bits);
            if distance < nearest {
                nearest = distance;
                if let Some(last) = picks.last_mut() {
                    *last = place;
                }
            }
        }
    }
    picks
}

/// Moves the keys in `ranges`, ascending and disjoint, to the end, keeping the order of
/// both parts; returns how many are left before them.
fn move_to_end(keys: &mut [Key], ranges: impl Iterator<Item = Range<usize>>) -> usize {
    let mut moved: Vec<Key> = Vec::new();
    let (mut read, mut write) = (0, 0);
    for range in ranges {
        keys.copy_within(read..range.start, write);
        write += range.start - read;
        moved.extend_from_slice(&keys[range.clone()]);
        read = range.end;
    }
    keys.copy_within(read.., write);
    let rest = keys.len() - moved.len();
    keys[rest..].copy_from_slice(&moved);
    rest
}
