//! The packed R-tree of a FlatGeobuf: where its nodes lie, and which of them meet a box.

use std::collections::VecDeque;
use std::ops::Range;

use flaneur_scene::Bounds2;
use glam::DVec2;

use super::{FgbFile, GAP};
use crate::layers::LayerError;
use object_store::ObjectStore;

/// Where the levels of the tree lie in the file. The layout follows from the feature count
/// and the node size alone, so no pointer of the file needs to be trusted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct IndexLayout {
    start: u64,
    node_size: u64,
    /// Node indices of each level, the root first, the features last.
    levels: Vec<Range<u64>>,
}

/// Four f64 and a u64.
const NODE_BYTES: u64 = 40;

impl IndexLayout {
    /// The layout of an index of `count` > 0 features at byte `start`, or `None` where it
    /// does not fit into `size` bytes.
    pub(super) fn new(start: u64, count: u64, node_size: u16, size: u64) -> Option<Self> {
        let room = size.checked_sub(start)? / NODE_BYTES;
        let node_size = u64::from(node_size);
        if node_size < 2 || count == 0 || count > room {
            return None;
        }
        let mut counts = vec![count];
        // The format stores a root even above a single feature.
        loop {
            let above = counts.last()?.div_ceil(node_size);
            counts.push(above);
            if above == 1 {
                break;
            }
        }
        if counts.iter().sum::<u64>() > room {
            return None;
        }
        let mut first = 0;
        let levels = counts.iter().rev().map(|n| {
            let level = first..first + n;
            first = level.end;
            level
        });
        Some(Self { start, node_size, levels: levels.collect() })
    }

    /// The byte after the index, where the features begin.
    pub(super) fn end(&self) -> u64 {
        self.start + NODE_BYTES * self.levels.last().map_or(0, |level| level.end)
    }

    /// Byte ranges, ascending and disjoint, that hold every feature whose box meets
    /// `bounds`; features less than [`GAP`] apart share a range.
    pub(super) async fn search(
        &self,
        file: &FgbFile,
        bounds: &Bounds2,
    ) -> Result<VecDeque<Range<u64>>, LayerError> {
        let mut runs: VecDeque<Range<u64>> = VecDeque::new();
        // Ranges of nodes on the current level whose boxes are to be tested, ascending.
        let mut candidates = vec![self.levels[0].clone()];
        for (depth, level) in self.levels.iter().enumerate() {
            let leaves = depth + 1 == self.levels.len();
            // One node more on the leaf level: where a feature ends is where the next begins.
            let wanted: Vec<Range<u64>> = candidates
                .iter()
                .map(|r| r.start..if leaves { level.end.min(r.end + 1) } else { r.end })
                .collect();
            let bytes_wanted: Vec<Range<u64>> = wanted
                .iter()
                .map(|r| self.start + NODE_BYTES * r.start..self.start + NODE_BYTES * r.end)
                .collect();
            let pieces = file.store.get_ranges(&file.path, &bytes_wanted).await?;
            let mut below = Vec::new();
            for ((range, nodes), piece) in candidates.iter().zip(&wanted).zip(&pieces) {
                let (parsed, _) = piece.as_chunks::<{ NODE_BYTES as usize }>();
                if parsed.len() as u64 != nodes.end - nodes.start {
                    let problem = format!("the store gave {} bytes of the index", piece.len());
                    return Err(file.damaged(self.start + NODE_BYTES * nodes.start, problem));
                }
                let parsed: Vec<(Bounds2, u64)> = parsed.iter().map(parse_node).collect();
                for (i, (node, _)) in (range.clone()).zip(&parsed) {
                    if !node.intersects(bounds) {
                        continue;
                    }
                    let at = (i - range.start) as usize;
                    if leaves {
                        self.add_feature(file, &mut runs, &parsed[at..], i)?;
                    } else {
                        let child_level = &self.levels[depth + 1];
                        let first = child_level.start + (i - level.start) * self.node_size;
                        let children = first..child_level.end.min(first + self.node_size);
                        extend_or_push(&mut below, children, 0);
                    }
                }
            }
            candidates = below;
        }
        Ok(runs)
    }

    /// Adds the bytes of the feature whose node comes first in `nodes`.
    fn add_feature(
        &self,
        file: &FgbFile,
        runs: &mut VecDeque<Range<u64>>,
        nodes: &[(Bounds2, u64)],
        node_index: u64,
    ) -> Result<(), LayerError> {
        let absolute = |offset: u64| self.end().checked_add(offset).filter(|&o| o < file.size);
        let start = nodes.first().and_then(|node| absolute(node.1));
        let end = nodes.get(1).map_or(Some(file.size), |node| absolute(node.1));
        match (start, end) {
            (Some(start), Some(end))
                if start < end && runs.back().is_none_or(|run| run.end <= start) =>
            {
                let run = start..end;
                match runs.back_mut() {
                    Some(last) if run.start - last.end <= GAP => last.end = run.end,
                    _ => runs.push_back(run),
                }
                Ok(())
            }
            _ => Err(file.damaged(
                self.start + NODE_BYTES * node_index,
                format!("the index places a feature at bytes {start:?} to {end:?}"),
            )),
        }
    }
}

/// Box and payload of a node.
fn parse_node(bytes: &[u8; NODE_BYTES as usize]) -> (Bounds2, u64) {
    let (words, _) = bytes.as_chunks::<8>();
    let number = |i: usize| words.get(i).map_or(f64::NAN, |word| f64::from_le_bytes(*word));
    let bounds =
        Bounds2 { min: DVec2::new(number(0), number(1)), max: DVec2::new(number(2), number(3)) };
    (bounds, words.get(4).map_or(0, |word| u64::from_le_bytes(*word)))
}

/// Appends a range, joined to the last where at most `gap` lies between them.
fn extend_or_push(ranges: &mut Vec<Range<u64>>, range: Range<u64>, gap: u64) {
    match ranges.last_mut() {
        Some(last) if range.start <= last.end + gap => last.end = last.end.max(range.end),
        _ => ranges.push(range),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_agrees_with_the_writer() {
        use flatgeobuf::packed_r_tree::PackedRTree;
        for count in [1_u64, 2, 15, 16, 17, 256, 257, 5000] {
            let layout = IndexLayout::new(100, count, 16, 1 << 40).expect("fits");
            let bytes = PackedRTree::index_size(count as usize, 16) as u64;
            assert_eq!(layout.end(), 100 + bytes, "{count}");
        }
    }

    #[test]
    fn counts_beyond_the_file_are_refused() {
        assert_eq!(IndexLayout::new(100, u64::MAX, 16, 1 << 20), None);
        assert_eq!(IndexLayout::new(100, 3, 16, 200), None);
        assert_eq!(IndexLayout::new(100, 3, 1, 1 << 20), None);
        assert_eq!(IndexLayout::new(100, 3, 16, 50), None);
    }
}
