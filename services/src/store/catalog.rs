//! Scenes by name, over several stores, kept up to date.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures::{StreamExt, TryStreamExt};

use super::{Manifest, SceneFolder, Store, StoreError};

/// How long a manifest is trusted before the store is asked again.
pub(super) const TRUSTED: Duration = Duration::from_secs(1);

/// How many manifests are read at a time.
const CONCURRENT_READS: usize = 16;

/// A published scene: one version of its manifest, and where its objects lie.
#[derive(Debug)]
pub struct Scene {
    /// Its objects.
    pub folder: SceneFolder,
    /// What it consists of.
    pub manifest: Manifest,
    /// The manifest's bytes, to notice a new one.
    bytes: Bytes,
}

/// The scenes of several stores. Cheap to clone.
///
/// Holds one entry a scene that was asked for, and drops it when the scene is gone.
#[derive(Clone, Debug)]
pub struct Catalog {
    shelves: Arc<Vec<Shelf>>,
    known: Arc<Mutex<HashMap<String, Arc<tokio::sync::Mutex<Entry>>>>>,
}

/// A store, or one scene of it alone.
#[derive(Clone, Debug)]
struct Shelf {
    store: Store,
    only: Option<String>,
}

#[derive(Debug, Default)]
struct Entry {
    scene: Option<Arc<Scene>>,
    checked: Option<Instant>,
}

impl Catalog {
    /// The scenes of all stores. A store that is itself a scene's prefix gives that scene.
    /// An error names the two stores that hold a scene of the same name.
    pub async fn open(stores: impl IntoIterator<Item = Store>) -> Result<Self, StoreError> {
        let mut shelves = Vec::new();
        for store in stores {
            shelves.push(match store.as_scene().await? {
                Some((above, scene)) => Shelf { store: above, only: Some(scene) },
                None => Shelf { store, only: None },
            });
        }
        let catalog = Self { shelves: Arc::new(shelves), known: Arc::default() };
        catalog.names().await?;
        Ok(catalog)
    }

    /// Names of all scenes, in order.
    pub async fn names(&self) -> Result<Vec<String>, StoreError> {
        let mut owners: BTreeMap<String, &Store> = BTreeMap::new();
        for shelf in self.shelves.iter() {
            for name in shelf.names().await? {
                if let Some(first) = owners.insert(name.clone(), &shelf.store) {
                    return Err(StoreError::SceneTwice {
                        name,
                        first: first.name().to_owned(),
                        second: shelf.store.name().to_owned(),
                    });
                }
            }
        }
        Ok(owners.into_keys().collect())
    }

    /// All scenes, in the order of their names.
    pub async fn scenes(&self) -> Result<Vec<Arc<Scene>>, StoreError> {
        let names = self.names().await?;
        let scenes = names.into_iter().map(|name| async move {
            match self.scene(&name).await {
                Ok(scene) => Ok(Some(scene)),
                // Removed since it was listed.
                Err(StoreError::NoScene { .. }) => Ok(None),
                // One damaged scene must not hide the others.
                Err(error @ StoreError::BadManifest { .. }) => {
                    tracing::warn!(%error, "scene left out of the list");
                    Ok(None)
                }
                Err(error) => Err(error),
            }
        });
        let found = futures::stream::iter(scenes).buffered(CONCURRENT_READS);
        found.try_filter_map(|scene| std::future::ready(Ok(scene))).try_collect().await
    }

    /// The scene of this name as it is published now, or was a second ago.
    pub async fn scene(&self, name: &str) -> Result<Arc<Scene>, StoreError> {
        super::folder::check_name(name)?;
        let entry = self.known().entry(name.to_owned()).or_default().clone();
        // Whoever comes while the manifest is read waits for it here, and reads it not again.
        let mut entry = entry.lock().await;
        if let (Some(scene), Some(checked)) = (&entry.scene, entry.checked)
            && checked.elapsed() < TRUSTED
        {
            return Ok(scene.clone());
        }
        let found = self.find(name, entry.scene.as_ref()).await;
        match &found {
            Ok(scene) => {
                *entry = Entry { scene: Some(scene.clone()), checked: Some(Instant::now()) }
            }
            Err(_) => {
                self.known().remove(name);
            }
        }
        found
    }

    async fn find(&self, name: &str, old: Option<&Arc<Scene>>) -> Result<Arc<Scene>, StoreError> {
        for shelf in self.shelves.iter() {
            if shelf.only.as_ref().is_some_and(|only| only != name) {
                continue;
            }
            let folder = shelf.store.scene_folder(name)?;
            let Some(bytes) = folder.manifest_bytes().await? else { continue };
            if let Some(old) = old
                && old.bytes == bytes
            {
                return Ok(old.clone());
            }
            let manifest = Manifest::parse(name, &bytes)?;
            return Ok(Arc::new(Scene { folder, manifest, bytes }));
        }
        Err(StoreError::NoScene { name: name.to_owned() })
    }

    fn known(&self) -> std::sync::MutexGuard<'_, HashMap<String, Arc<tokio::sync::Mutex<Entry>>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shelf {
    async fn names(&self) -> Result<Vec<String>, StoreError> {
        match &self.only {
            Some(name) => Ok(vec![name.clone()]),
            None => self.store.scenes().await,
        }
    }
}
