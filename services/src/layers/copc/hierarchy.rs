//! The pages in which a COPC file lists its nodes.

use std::collections::BTreeMap;

use flaneur_scene::NodeKey;

use super::checksums::CHECKSUM_BYTES;

/// Where a node's chunk lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeEntry {
    pub(super) key: NodeKey,
    pub(super) offset: u64,
    pub(super) byte_size: u32,
    pub(super) point_count: u32,
    pub(super) crc32: u32,
}

/// The pages of a file, and what lies beside them.
pub(super) struct Pages {
    /// The entries.
    pub(super) entries: Vec<u8>,
    /// Length of the root page, which comes first.
    pub(super) root_bytes: u64,
    /// [`super::checksums`]: four bytes for each entry, in their order.
    pub(super) checksums: Vec<u8>,
}

/// Nodes that a page lists before it hands deeper ones to pages of their own: 512 entries
/// are 16 kB, one round trip.
const PAGE_ENTRIES: usize = 512;

/// Bytes of an entry.
pub(super) const ENTRY_BYTES: u64 = 32;

/// The pages of a tree one after another, the root page first, as they stand at `offset`
/// in the file.
///
/// A page holds its root and the levels below as long as they stay within [`PAGE_ENTRIES`];
/// a node of the last such level that has descendants becomes a page of its own.
pub(super) fn hierarchy_pages(entries: &[NodeEntry], offset: u64) -> Pages {
    let tree: BTreeMap<NodeKey, &NodeEntry> = entries.iter().map(|e| (e.key, e)).collect();
    let mut pages: Vec<Page> = Vec::new();
    let mut roots = vec![NodeKey::ROOT];
    let mut next = 0;
    while let Some(&root) = roots.get(next) {
        next += 1;
        let page = Page::below(root, &tree);
        roots.extend(&page.sub_pages);
        pages.push(page);
    }
    let mut offsets = BTreeMap::new();
    let mut position = offset;
    for (root, page) in roots.iter().zip(&pages) {
        offsets.insert(*root, (position, page.byte_size()));
        position += page.byte_size();
    }
    let (mut bytes, mut checksums) = (Vec::new(), Vec::new());
    for page in &pages {
        for key in &page.nodes {
            let entry = tree[key];
            write_entry(&mut bytes, *key, entry.offset, entry.byte_size, entry.point_count as i32);
            checksums.extend(entry.crc32.to_le_bytes());
        }
        for key in &page.sub_pages {
            let (offset, size) = offsets[key];
            write_entry(&mut bytes, *key, offset, size as u32, -1);
            checksums.extend([0; CHECKSUM_BYTES as usize]);
        }
    }
    Pages { entries: bytes, root_bytes: pages[0].byte_size(), checksums }
}

/// One page: the nodes it lists itself, and those that it leaves to pages of their own.
struct Page {
    nodes: Vec<NodeKey>,
    sub_pages: Vec<NodeKey>,
}

impl Page {
    fn below(root: NodeKey, tree: &BTreeMap<NodeKey, &NodeEntry>) -> Self {
        let children = |key: &NodeKey| {
            key.children().into_iter().filter(|child| tree.contains_key(child)).collect::<Vec<_>>()
        };
        let mut nodes = vec![root];
        let mut level: Vec<NodeKey> = children(&root);
        while !level.is_empty() && nodes.len() + level.len() <= PAGE_ENTRIES {
            nodes.extend(&level);
            level = level.iter().flat_map(children).collect();
        }
        let (sub_pages, leaves): (Vec<_>, Vec<_>) =
            level.into_iter().partition(|key| !children(key).is_empty());
        nodes.extend(leaves);
        Self { nodes, sub_pages }
    }

    fn byte_size(&self) -> u64 {
        (self.nodes.len() + self.sub_pages.len()) as u64 * ENTRY_BYTES
    }
}

fn write_entry(bytes: &mut Vec<u8>, key: NodeKey, offset: u64, byte_size: u32, count: i32) {
    for value in [key.level, key.x, key.y, key.z] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(offset.to_le_bytes());
    bytes.extend(byte_size.to_le_bytes());
    bytes.extend(count.to_le_bytes());
}
