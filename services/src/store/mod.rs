//! Scenes behind a URL: a folder, `memory://`, `s3://` and whatever else `object_store` opens.
//!
//! A [`Store`] is a place with scenes, each a prefix that holds a manifest `scene.json`. Its
//! objects are written and read through a [`SceneFolder`]. A [`Catalog`] finds scenes by name in
//! several stores and notices when one is published anew.

mod catalog;
mod error;
mod folder;
mod manifest;
mod open;
mod publish;

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use futures::{StreamExt, TryStreamExt};
use object_store::ObjectStore;
use object_store::path::Path;

pub use catalog::{Catalog, Scene};
pub use error::{StoreError, remedy};
pub use folder::SceneFolder;
pub use manifest::{
    FileEntry, FootprintsLayer, GroundLayer, Manifest, PanoramasLayer, PointsLayer,
};

/// How many manifests are looked for at a time.
const CONCURRENT_HEADS: usize = 16;

/// A place that holds scenes. Cheap to clone.
#[derive(Clone)]
pub struct Store {
    name: String,
    store: Arc<dyn ObjectStore>,
    prefix: Path,
    /// The folder where the store is one.
    folder: Option<PathBuf>,
}

impl Store {
    /// What the store is called in messages: the URL that was opened.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder that the store is, where it is one. It need not exist yet.
    pub fn folder(&self) -> Option<&std::path::Path> {
        self.folder.as_deref()
    }

    /// The place of the scene `name`, which need not exist yet.
    pub fn scene_folder(&self, name: &str) -> Result<SceneFolder, StoreError> {
        SceneFolder::new(name, self.store.clone(), &self.prefix)
    }

    /// Names of the scenes that are published, in order.
    pub async fn scenes(&self) -> Result<Vec<String>, StoreError> {
        let prefix = Some(&self.prefix).filter(|prefix| !prefix.is_root());
        let listed = match self.store.list_with_delimiter(prefix).await {
            Err(object_store::Error::NotFound { .. }) => return Ok(Vec::new()),
            other => other?,
        };
        let candidates = listed.common_prefixes.into_iter().filter_map(|prefix| {
            let folder = self.scene_folder(prefix.filename()?).ok()?;
            Some(async move {
                let found = folder.head(Manifest::PATH).await?;
                Ok::<_, StoreError>(found.map(|_| folder.name().to_owned()))
            })
        });
        let found = futures::stream::iter(candidates).buffer_unordered(CONCURRENT_HEADS);
        let mut names: Vec<String> =
            found.try_filter_map(|name| std::future::ready(Ok(name))).try_collect().await?;
        names.sort();
        Ok(names)
    }

    /// Where the URL was that of a scene rather than of a store: the store above it and the
    /// scene's name.
    pub async fn as_scene(&self) -> Result<Option<(Self, String)>, StoreError> {
        let (Some(name), Some(parent)) = (self.prefix.filename(), self.prefix.parent()) else {
            return Ok(None);
        };
        let above = Self {
            prefix: parent,
            folder: self.folder.as_deref().and_then(|f| f.parent()).map(ToOwned::to_owned),
            ..self.clone()
        };
        let Ok(folder) = above.scene_folder(name) else { return Ok(None) };
        let found = folder.head(Manifest::PATH).await?;
        Ok(found.map(|_| (above, name.to_owned())))
    }
}

impl fmt::Debug for Store {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Store({})", self.name)
    }
}

#[cfg(test)]
pub(crate) mod tests;
