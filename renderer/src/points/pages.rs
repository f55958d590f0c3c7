//! Buffers of points, handed out in blocks.

use std::ops::Range;

use super::BLOCK_POINTS;
use super::record::{NO_POINT, Record};
use crate::Gpu;

/// Blocks of a page: 32 MiB.
const PAGE_BLOCKS: u32 = 8192;
/// Bytes of a point's normal.
const NORMAL_BYTES: u64 = size_of::<u32>() as u64;

/// A run of blocks in one page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) page: usize,
    pub(crate) blocks: Range<u32>,
}

/// Pages that fit the device's storage bindings.
#[derive(Debug)]
pub(crate) struct Pages {
    pages: Vec<Page>,
    with_normals: bool,
}

#[derive(Debug)]
struct Page {
    blocks: u32,
    records: wgpu::Buffer,
    /// A word a point.
    normals: Option<wgpu::Buffer>,
    /// Ascending, disjoint, not touching.
    free: Vec<Range<u32>>,
}

impl Pages {
    pub(crate) fn new(with_normals: bool) -> Self {
        Self { pages: Vec::new(), with_normals }
    }

    /// Bytes of all pages.
    pub(crate) fn bytes(&self) -> u64 {
        let normals = |page: &Page| page.normals.as_ref().map_or(0, wgpu::Buffer::size);
        self.pages.iter().map(|page| page.records.size() + normals(page)).sum()
    }

    pub(crate) fn len(&self) -> usize {
        self.pages.len()
    }

    pub(crate) fn with_normals(&self) -> bool {
        self.with_normals
    }

    /// Bytes that a block takes on the device.
    pub(crate) fn block_bytes(&self) -> u64 {
        let normal = if self.with_normals { NORMAL_BYTES } else { 0 };
        BLOCK_POINTS as u64 * (size_of::<Record>() as u64 + normal)
    }

    /// Records, and codes of normals where pages have them.
    pub(crate) fn buffers(&self, page: usize) -> (&wgpu::Buffer, Option<&wgpu::Buffer>) {
        let Page { records, normals, .. } = &self.pages[page];
        (records, normals.as_ref())
    }

    /// Takes blocks from the pages' free ranges, lowest first, and adds pages as needed.
    /// No more than `most` blocks exist in all.
    pub(crate) fn take(&mut self, gpu: &Gpu, mut blocks: u32, most: u64) -> Vec<Part> {
        let mut parts = Vec::new();
        let mut page = 0;
        while blocks > 0 {
            if page == self.pages.len() {
                let held: u64 = self.pages.iter().map(|page| u64::from(page.blocks)).sum();
                let room = u32::try_from(most.saturating_sub(held)).unwrap_or(PAGE_BLOCKS);
                if room == 0 {
                    return parts;
                }
                self.pages.push(Page::new(gpu, self.with_normals, room.min(PAGE_BLOCKS)));
            }
            let free = &mut self.pages[page].free;
            while blocks > 0
                && let Some(range) = free.first_mut()
            {
                let taken = range.start..range.end.min(range.start + blocks);
                blocks -= taken.end - taken.start;
                range.start = taken.end;
                if range.start == range.end {
                    free.remove(0);
                }
                parts.push(Part { page, blocks: taken });
            }
            page += 1;
        }
        parts
    }

    pub(crate) fn give_back(&mut self, part: Part) {
        release(&mut self.pages[part.page].free, part.blocks);
    }

    /// Writes `records` to the blocks of `parts`; what is left of the last block is emptied.
    pub(crate) fn write_records(&self, gpu: &Gpu, parts: &[Part], records: &[Record]) {
        write(gpu, parts, records, NO_POINT, |page| Some(&self.pages[page].records));
    }

    /// Writes codes of normals beside the records, where pages have them.
    pub(crate) fn write_normals(&self, gpu: &Gpu, parts: &[Part], normals: &[u32]) {
        write(gpu, parts, normals, 0, |page| self.pages[page].normals.as_ref());
    }
}

fn write<'a, T: bytemuck::Pod>(
    gpu: &Gpu,
    parts: &[Part],
    mut rest: &[T],
    nothing: T,
    buffer: impl Fn(usize) -> Option<&'a wgpu::Buffer>,
) {
    for Part { page, blocks } in parts {
        let points = blocks.len() * BLOCK_POINTS;
        let (part, after) = rest.split_at(rest.len().min(points));
        rest = after;
        let Some(buffer) = buffer(*page) else { continue };
        let offset = u64::from(blocks.start) * (BLOCK_POINTS * size_of::<T>()) as u64;
        gpu.queue.write_buffer(buffer, offset, bytemuck::cast_slice(part));
        if part.len() < points {
            let offset = offset + size_of_val(part) as u64;
            let empty = vec![nothing; points - part.len()];
            gpu.queue.write_buffer(buffer, offset, bytemuck::cast_slice(&empty));
        }
    }
}

impl Page {
    fn new(gpu: &Gpu, with_normals: bool, blocks: u32) -> Self {
        let buffer = |label, bytes_a_point: u64| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(blocks) * BLOCK_POINTS as u64 * bytes_a_point,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            blocks,
            records: buffer("points", size_of::<Record>() as u64),
            normals: with_normals.then(|| buffer("normals of points", NORMAL_BYTES)),
            free: std::iter::once(0..blocks).collect(),
        }
    }
}

/// Puts `blocks` back among the free ranges, joined with its neighbours.
fn release(free: &mut Vec<Range<u32>>, blocks: Range<u32>) {
    let at = free.partition_point(|range| range.end < blocks.start);
    let mut joined = blocks;
    while let Some(next) = free.get(at)
        && next.start <= joined.end
    {
        joined = joined.start.min(next.start)..joined.end.max(next.end);
        free.remove(at);
    }
    free.insert(at, joined);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn released_ranges_join() {
        let mut free = vec![0..2, 8..10];
        release(&mut free, 4..6);
        assert_eq!(free, [0..2, 4..6, 8..10]);
        release(&mut free, 2..4);
        assert_eq!(free, [0..6, 8..10]);
        release(&mut free, 6..8);
        assert_eq!(free, vec![0..10]);
    }
}
