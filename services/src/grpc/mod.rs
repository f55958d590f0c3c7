//! The data services of `flaneur.v1` over a [`crate::store`].
//!
//! [`Server`] answers on a port, [`in_process()`] within the program; both serve the same
//! [`routes`]. Every stream is pulled by its client: nothing is read that was not asked for,
//! and when a client goes away, or its deadline passes, reading ends with its stream.

mod body;
mod call;
mod connections;
mod footprints;
mod ground;
mod image_index;
mod images;
mod in_process;
mod metrics;
mod not_found;
mod octrees;
mod origins;
mod panoramas;
mod pieces;
mod points;
mod routes;
mod scenes;
mod server;
pub(crate) mod status;
mod unsent;

use std::pin::Pin;
use std::sync::Arc;

use futures::Stream;
use object_store::ObjectStore;
use object_store::path::Path;
use tonic::Status;

use crate::cache::ByteCache;
use crate::store::{Catalog, FileEntry, Scene};
use image_index::ImageIndex;
use octrees::Octrees;
use pieces::Ahead;

pub use in_process::in_process;
pub use origins::{NoOrigin, Origin};
pub use routes::{Limits, Offer};
pub use server::{ServeError, Server};

/// Most bytes of a message, well under the 4 MiB that clients take by default.
pub(crate) const MAX_MESSAGE_BYTES: usize = 3 << 20;

/// Bytes that the image indexes of all scenes may take: some two million photographs.
const IMAGE_INDEX_BYTES: usize = 512 << 20;

/// The services over a catalog of scenes. Cheap to clone; keeps nothing that the stores do not
/// hold but caches.
#[derive(Clone)]
struct Services {
    catalog: Catalog,
    octrees: Arc<Octrees>,
    image_indexes: Arc<ByteCache<Version, ImageIndex>>,
    ahead: Ahead,
}

/// Messages that are made as the client takes them.
type MessageStream<M> = Pin<Box<dyn Stream<Item = Result<M, Status>> + Send>>;

/// One version of one object: its scene, its path, and its content's checksum.
type Version = (String, String, String);

impl Services {
    fn new(catalog: Catalog) -> Self {
        Self {
            catalog,
            octrees: Arc::new(Octrees::new()),
            image_indexes: Arc::new(ByteCache::new(IMAGE_INDEX_BYTES)),
            ahead: Ahead::new(),
        }
    }

    async fn scene(&self, name: &str) -> Result<Arc<Scene>, Status> {
        self.catalog.scene(name).await.map_err(|e| status::of_store(&e))
    }
}

/// Where an object of a scene lies, and its size.
fn object(scene: &Scene, file: &FileEntry) -> Result<(Arc<dyn ObjectStore>, Path, u64), Status> {
    let path = scene.folder.path(&file.path).map_err(|e| status::of_store(&e))?;
    Ok((scene.folder.object_store(), path, file.bytes))
}

fn version_of(scene: &Scene, file: &FileEntry) -> Version {
    (scene.folder.name().to_owned(), file.path.clone(), file.blake3.clone())
}

#[cfg(test)]
mod tests;
