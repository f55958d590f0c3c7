//! From the work folder into the store: objects first, the manifest last.
//!
//! Whoever reads the scene meanwhile reads the previous one: no object that a published
//! manifest names is altered, for every path holds a version made from the content.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use flaneur_scene::Region;
use futures::stream::{FuturesUnordered, StreamExt};

use super::leftovers::Leftovers;
use super::{IngestError, Job, Unit};
use crate::layers::panoramas;
use crate::store::{Manifest, SceneFolder, Store, StoreError};

/// Objects that are written at a time.
const CONCURRENT_PUTS: usize = 8;

/// How often a store that does not answer is asked whether anyone still waits.
const CANCEL_INTERVAL: Duration = Duration::from_millis(100);

/// A scene's place in a store, and what is there already.
pub(super) struct Destination {
    store: Store,
    folder: SceneFolder,
    leftovers: Leftovers,
    /// The scene as it is published now.
    pub(super) previous: Option<Manifest>,
    /// Every object of the scene and its size.
    existing: BTreeMap<String, u64>,
}

/// An object to be published: its path below the scene's prefix, and the file with its
/// content.
pub(super) type StagedObject = (String, PathBuf);

impl Destination {
    /// Looks at the scene `name` of `store`. A manifest that cannot be read counts as none.
    pub(super) async fn open(store: &Store, name: &str, job: &Job) -> Result<Self, IngestError> {
        let failed =
            |action, error| IngestError::store(action, object_name(store, name, ""), error);
        let folder = store.scene_folder(name).map_err(|error| failed("open", error))?;
        let leftovers = Leftovers::new(store.folder(), name);
        let previous = match unless_cancelled(job, folder.manifest()).await? {
            Err(StoreError::BadManifest { problem, .. }) => {
                tracing::warn!(problem, "the scene's manifest cannot be read: it is made anew");
                None
            }
            other => other.map_err(|error| failed("read", error))?,
        };
        let existing = unless_cancelled(job, folder.list()).await?;
        let existing = existing.map_err(|error| failed("list", error))?;
        let existing = existing.into_iter().collect();
        Ok(Self { store: store.clone(), folder, leftovers, previous, existing })
    }

    /// Whether the published scene has this fingerprint and all of its layers' files.
    pub(super) fn is_published(&self, fingerprint: &str) -> bool {
        self.previous.as_ref().is_some_and(|manifest| {
            manifest.fingerprint == fingerprint
                && layer_files(manifest)
                    .all(|file| self.existing.get(&file.path) == Some(&file.bytes))
        })
    }

    /// Removes the beginnings of objects that a kill left. Nobody else may be publishing.
    pub(super) fn tidy(&self) {
        self.leftovers.tidy();
    }

    /// Bytes of all objects of the scene but its manifest, those included that only readers
    /// of the scene before it may need.
    pub(super) fn bytes(&self) -> u64 {
        let objects = self.existing.iter().filter(|(path, _)| *path != Manifest::PATH);
        objects.map(|(_, size)| size).sum()
    }

    /// An error where the store cannot be written, before hours of work are spent.
    pub(super) async fn check_writable(&self, job: &Job) -> Result<(), IngestError> {
        let path = format!(".probe-{}", std::process::id());
        let full = self.folder.path(&path).map_err(|e| self.failed("write", &path, e))?;
        let store = self.folder.object_store();
        let probe = object_store::PutPayload::from_static(b"flaneur");
        let put = object_store::ObjectStoreExt::put(&*store, &full, probe);
        let outcome = match unless_cancelled(job, put).await? {
            Ok(_) => self.folder.delete(&path).await,
            Err(error) => Err(error.into()),
        };
        self.leftovers.tidy();
        outcome.map_err(|error| self.failed("write to", "", error))
    }

    /// Puts the objects, then the manifest, then removes what neither it nor the previous
    /// manifest names. Objects that are there already with the same size are kept, unless
    /// `force` is set.
    ///
    /// # Errors
    ///
    /// The published scene is then as it was, and what was put is removed as far as the store
    /// lets us.
    pub(super) async fn publish(
        &mut self,
        objects: &[StagedObject],
        manifest: &Manifest,
        force: bool,
        job: &Job,
    ) -> Result<(), IngestError> {
        // Read while all of it is there.
        let mut named = match self.previous.take() {
            Some(previous) => self.objects_of(&previous).await,
            None => BTreeSet::new(),
        };
        let mut put = Vec::new();
        let outcome = async {
            self.put_all(objects, force, job, &mut put).await?;
            let failed = |error| self.failed("write", Manifest::PATH, error);
            self.folder.put_manifest(manifest).await.map_err(failed)
        };
        if let Err(error) = outcome.await {
            for path in &put {
                self.remove(path).await;
            }
            self.leftovers.tidy();
            return Err(error);
        }
        named.extend(objects.iter().map(|(path, _)| path.clone()));
        named.insert(Manifest::PATH.to_owned());
        for path in self.existing.keys().filter(|path| !named.contains(*path)) {
            self.remove(path).await;
        }
        self.leftovers.tidy();
        Ok(())
    }

    /// Puts the objects, several at a time. `put` receives the paths of those that were not
    /// there before, also when it fails.
    async fn put_all(
        &self,
        objects: &[StagedObject],
        force: bool,
        job: &Job,
        put: &mut Vec<String>,
    ) -> Result<(), IngestError> {
        let mut missing = Vec::new();
        for (path, file) in objects {
            let meta = std::fs::metadata(file).map_err(|e| IngestError::io("read", file, e))?;
            if force || self.existing.get(path) != Some(&meta.len()) {
                missing.push((path, file, meta.len()));
            }
        }
        let stage = job.stage("publish", missing.iter().map(|(.., size)| size).sum(), Unit::Bytes);
        let advance = |bytes: u64| stage.advance(bytes);
        let mut missing = missing.into_iter();
        let mut running = FuturesUnordered::new();
        loop {
            job.check()?;
            while running.len() < CONCURRENT_PUTS
                && let Some((path, file, _)) = missing.next()
            {
                if !self.existing.contains_key(path) {
                    put.push(path.clone());
                }
                let advance = &advance;
                running.push(async move {
                    let outcome = self.folder.publish_object(path, file, advance).await;
                    outcome.map_err(|error| self.failed("write", path, error))
                });
            }
            match unless_cancelled(job, running.next()).await? {
                Some(outcome) => outcome?,
                None => return Ok(()),
            }
        }
    }

    /// Every object that a published manifest names. Where its table of panoramas cannot be
    /// read, all that there is: nothing is then removed that someone may still need.
    async fn objects_of(&self, manifest: &Manifest) -> BTreeSet<String> {
        let mut objects: BTreeSet<String> =
            layer_files(manifest).map(|file| file.path.clone()).collect();
        if let Some(layer) = &manifest.panoramas
            && let Err(error) =
                self.images_of(&layer.file.path, layer.file.bytes, &mut objects).await
        {
            tracing::warn!(error, "the previous panoramas cannot be read: nothing is removed");
            objects.extend(self.existing.keys().cloned());
        }
        objects
    }

    async fn images_of(
        &self,
        table: &str,
        bytes: u64,
        objects: &mut BTreeSet<String>,
    ) -> Result<(), String> {
        let path = self.folder.path(table).map_err(|error| error.to_string())?;
        let store = self.folder.object_store();
        let opened = panoramas::open(store, path, bytes, Region::All).await;
        let mut cursor = opened.map_err(|error| error.to_string())?;
        while let Some(panorama) = cursor.next().await.map_err(|error| error.to_string())? {
            for camera in &panorama.cameras {
                objects.extend((0..camera.level_count()).map(|level| {
                    panoramas::image_path(&panorama.id, &camera.id, &camera.version, level)
                }));
                objects.extend(camera.mask.iter().map(|mask| panoramas::mask_path(&mask.name)));
            }
        }
        Ok(())
    }

    /// Removes an object as well as the store lets us: one that stays costs space only, and
    /// the next ingest tries again.
    async fn remove(&self, path: &str) {
        if let Err(error) = self.folder.delete(path).await {
            tracing::warn!(path, %error, "an object that nobody needs could not be removed");
        }
    }

    fn failed(&self, action: &'static str, path: &str, error: StoreError) -> IngestError {
        IngestError::store(action, object_name(&self.store, self.folder.name(), path), error)
    }
}

/// How people find an object of a scene, or the scene where `path` is empty.
fn object_name(store: &Store, scene: &str, path: &str) -> String {
    let separator = if path.is_empty() { "" } else { "/" };
    format!("{}/{scene}{separator}{path}", store.name().trim_end_matches('/'))
}

/// What `work` gives, unless the job is cancelled first: a store that is far away, or retried,
/// must not keep a person waiting. The upload of a large object that is dropped so may leave
/// parts, which cloud stores keep until their own rules remove them.
async fn unless_cancelled<T>(job: &Job, work: impl Future<Output = T>) -> Result<T, IngestError> {
    let mut work = std::pin::pin!(work);
    loop {
        match tokio::time::timeout(CANCEL_INTERVAL, &mut work).await {
            Ok(done) => return Ok(done),
            Err(_) => job.check()?,
        }
    }
}

/// The layers' own files.
fn layer_files(manifest: &Manifest) -> impl Iterator<Item = &crate::store::FileEntry> {
    let points = manifest.points.iter().map(|layer| &layer.file);
    let stations = manifest.points.iter().filter_map(|layer| layer.stations.as_ref());
    let ground = manifest.ground.iter().map(|layer| &layer.file);
    let footprints = manifest.footprints.iter().map(|layer| &layer.file);
    let panoramas = manifest.panoramas.iter().map(|layer| &layer.file);
    let delivered = manifest.panoramas.iter().filter_map(|layer| layer.delivered.as_ref());
    points.chain(stations).chain(ground).chain(footprints).chain(panoramas).chain(delivered)
}
