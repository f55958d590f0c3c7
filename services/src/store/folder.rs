//! A scene's place in a store: the objects below its prefix.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use flaneur_scene::ImageId;
use futures::TryStreamExt;
use object_store::path::{Path, PathPart};
use object_store::{GetOptions, ObjectMeta, ObjectStore, ObjectStoreExt};

use super::{Manifest, StoreError};

/// Largest manifest that is read, bytes. One of a thousand point sources takes a few MiB.
const MAX_MANIFEST_BYTES: u64 = 64 << 20;

/// The objects of one scene, whether or not it is published yet. No path leaves its prefix.
#[derive(Clone)]
pub struct SceneFolder {
    name: String,
    pub(super) store: Arc<dyn ObjectStore>,
    prefix: Path,
}

impl SceneFolder {
    pub(super) fn new(
        name: &str,
        store: Arc<dyn ObjectStore>,
        parent: &Path,
    ) -> Result<Self, StoreError> {
        check_name(name)?;
        let part = PathPart::parse(name).map_err(|e| StoreError::BadSceneName {
            name: name.to_owned(),
            problem: e.to_string(),
        })?;
        // Joined as text: `Path::join` would percent-encode what is a valid name.
        let prefix = Path::parse(format!("{parent}/{}", part.as_ref()))
            .map_err(object_store::Error::from)?;
        Ok(Self { name: name.to_owned(), store, prefix })
    }

    /// The scene's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The object store that [`SceneFolder::path`] addresses.
    pub fn object_store(&self) -> Arc<dyn ObjectStore> {
        self.store.clone()
    }

    /// The full path of the object at `relative` below the scene. Empty segments, `.`, `..`
    /// and control characters are refused, so the path stays below the scene.
    pub fn path(&self, relative: &str) -> Result<Path, StoreError> {
        let bad = |problem: String| StoreError::BadPath { path: relative.to_owned(), problem };
        if relative.is_empty() || relative.starts_with('/') || relative.ends_with('/') {
            return Err(bad("must be relative and name an object".to_owned()));
        }
        if relative.contains('\\') {
            return Err(bad("holds a backslash".to_owned()));
        }
        Path::parse(format!("{}/{relative}", self.prefix)).map_err(|e| bad(e.to_string()))
    }

    /// Size and version of an object, or `None` where it does not exist.
    pub async fn head(&self, relative: &str) -> Result<Option<ObjectMeta>, StoreError> {
        match self.store.head(&self.path(relative)?).await {
            Ok(meta) => Ok(Some(meta)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Exactly these bytes of an object.
    pub async fn get_range(&self, relative: &str, range: Range<u64>) -> Result<Bytes, StoreError> {
        let path = self.path(relative)?;
        let bytes = self.store.get_range(&path, range.clone()).await?;
        if bytes.len() as u64 != range.end - range.start {
            return Err(StoreError::Damaged {
                object: path.to_string(),
                problem: format!("bytes {range:?} are only {}", bytes.len()),
            });
        }
        Ok(bytes)
    }

    /// The manifest's bytes, or `None` where the scene is not published.
    pub async fn manifest_bytes(&self) -> Result<Option<Bytes>, StoreError> {
        let path = self.path(Manifest::PATH)?;
        let result = match self.store.get_opts(&path, GetOptions::default()).await {
            Ok(result) => result,
            Err(object_store::Error::NotFound { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        if result.meta.size > MAX_MANIFEST_BYTES {
            let problem = format!("{} bytes, more than {MAX_MANIFEST_BYTES}", result.meta.size);
            return Err(StoreError::BadManifest { scene: self.name.clone(), problem });
        }
        Ok(Some(result.bytes().await?))
    }

    /// The manifest, or `None` where the scene is not published.
    pub async fn manifest(&self) -> Result<Option<Manifest>, StoreError> {
        let bytes = self.manifest_bytes().await?;
        bytes.map(|bytes| Manifest::parse(&self.name, &bytes)).transpose()
    }

    /// Path below the scene and size of every object.
    pub async fn list(&self) -> Result<Vec<(String, u64)>, StoreError> {
        let prefix = format!("{}/", self.prefix);
        let objects = self.store.list(Some(&self.prefix)).try_filter_map(|meta| {
            let relative = meta.location.as_ref().strip_prefix(&prefix).map(ToOwned::to_owned);
            std::future::ready(Ok(relative.map(|relative| (relative, meta.size))))
        });
        let mut objects: Vec<_> = objects.try_collect().await?;
        objects.sort();
        Ok(objects)
    }

    /// Removes an object; one that does not exist is fine.
    pub async fn delete(&self, relative: &str) -> Result<(), StoreError> {
        match self.store.delete(&self.path(relative)?).await {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

impl fmt::Debug for SceneFolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SceneFolder({}: {})", self.store, self.prefix)
    }
}

/// A scene's name is one segment of a path, as the names of panoramas are.
pub(super) fn check_name(name: &str) -> Result<(), StoreError> {
    ImageId::check_part(name)
        .map_err(|e| StoreError::BadSceneName { name: name.to_owned(), problem: e.to_string() })
}
