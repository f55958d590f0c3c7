//! Where the nodes of point sources lie: open files and their pages, as many as fit.

use std::sync::Arc;

use flaneur_scene::NodeKey;
use tonic::Status;

use super::{Version, status};
use crate::cache::ByteCache;
use crate::layers::copc::{CopcFile, Page, PageAddress, PageEntry, PageItem};
use crate::store::{PointsLayer, Scene};

/// Bytes that pages may take in memory: two million nodes.
const PAGE_CACHE_BYTES: usize = 128 << 20;

/// Files that are kept open, by [`OPEN_FILE_BYTES`].
const FILE_CACHE_BYTES: usize = 1024 * OPEN_FILE_BYTES;

/// What an open file is counted as: its paths, mostly.
const OPEN_FILE_BYTES: usize = 1 << 10;

/// The octrees of all scenes.
pub(super) struct Octrees {
    files: ByteCache<Version, CopcFile>,
    pages: ByteCache<(Version, PageAddress), Page>,
}

/// The octree of one point source.
#[derive(Clone)]
pub(super) struct Octree {
    octrees: Arc<Octrees>,
    version: Version,
    file: Arc<CopcFile>,
    /// What it is called in messages.
    pub(super) what: String,
}

/// Where the points of a node lie.
#[derive(Clone, Copy)]
pub(super) struct Chunk {
    pub(super) key: NodeKey,
    pub(super) offset: u64,
    pub(super) byte_size: u32,
    pub(super) point_count: u32,
}

impl Octrees {
    pub(super) fn new() -> Self {
        Self { files: ByteCache::new(FILE_CACHE_BYTES), pages: ByteCache::new(PAGE_CACHE_BYTES) }
    }

    /// The octree of a point source, opened where it is not.
    pub(super) async fn open(
        self: &Arc<Self>,
        scene: &Scene,
        layer: &PointsLayer,
    ) -> Result<Octree, Status> {
        let version = super::version_of(scene, &layer.file);
        let what = format!("point source {:?} of scene {:?}", layer.source, scene.folder.name());
        let file = self.files.get_or_load(&version, async {
            let (store, path, size) = super::object(scene, &layer.file)?;
            let file = CopcFile::open(store, path, size).await;
            let file = file.map_err(|e| status::of_layer(&what, &e))?;
            Ok::<_, Status>((file, OPEN_FILE_BYTES))
        });
        let file = file.await?;
        Ok(Octree { octrees: self.clone(), version, file, what })
    }
}

impl Octree {
    /// Where the root page lies.
    pub(super) fn root(&self) -> PageAddress {
        self.file.root()
    }

    /// Bytes that all pages together can take: a file whose pages overlap is damaged.
    pub(super) fn page_budget(&self) -> u64 {
        self.file.size()
    }

    /// A page of the hierarchy.
    pub(super) async fn page(&self, address: PageAddress) -> Result<Arc<Page>, Status> {
        let load = async {
            let page = self.file.page(address).await;
            let page = page.map_err(|e| status::of_layer(&self.what, &e))?;
            let bytes = size_of::<Page>() + page.entries.len() * size_of::<PageEntry>();
            Ok((page, bytes))
        };
        self.octrees.pages.get_or_load(&(self.version.clone(), address), load).await
    }

    /// The page whose root is `key`; NOT_FOUND where there is none.
    pub(super) async fn page_of(&self, key: NodeKey) -> Result<PageAddress, Status> {
        let mut address = self.root();
        while address.key != key {
            let page = self.page(address).await?;
            address = page
                .towards(key)
                .ok_or_else(|| status::not_found("page", name(key), &self.what))?;
        }
        Ok(address)
    }

    /// The chunk of `key`; NOT_FOUND where it holds no points.
    pub(super) async fn chunk(&self, key: NodeKey) -> Result<Chunk, Status> {
        let mut address = self.root();
        // Each page lies deeper than the one before, so this ends.
        loop {
            let page = self.page(address).await?;
            if let Some(PageEntry {
                item: PageItem::Node { offset, byte_size, point_count, .. },
                ..
            }) = page.entry(key)
                && *point_count > 0
            {
                let (offset, byte_size, point_count) = (*offset, *byte_size, *point_count);
                return Ok(Chunk { key, offset, byte_size, point_count });
            }
            address = page
                .towards(key)
                .ok_or_else(|| status::not_found("node", name(key), &self.what))?;
        }
    }
}

/// A node as people write it: level-x-y-z.
fn name(key: NodeKey) -> String {
    format!("{}-{}-{}-{}", key.level, key.x, key.y, key.z)
}
