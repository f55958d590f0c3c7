//! Writing a scene's objects: whole or not at all, the manifest last.

use std::path::Path as FilePath;

use bytes::{Bytes, BytesMut};
use object_store::path::Path;
use object_store::{MultipartUpload, ObjectStoreExt, PutPayload};
use tokio::io::AsyncReadExt;

use super::{Manifest, SceneFolder, StoreError};

/// Bytes of a part of a large object; smaller objects are put in one piece.
const PART_BYTES: u64 = 8 << 20;

/// Most parts of an object; S3 takes 10 000.
const MAX_PARTS: u64 = 9_000;

impl SceneFolder {
    /// Copies a local file to the object at `relative`, and checks the size of what arrived.
    /// The object appears when it is whole. `progress` is told of bytes as they are stored.
    pub async fn publish_object(
        &self,
        relative: &str,
        file: &FilePath,
        progress: &(dyn Fn(u64) + Send + Sync),
    ) -> Result<(), StoreError> {
        let failed = |source| StoreError::LocalFile { path: file.display().to_string(), source };
        let path = self.path(relative)?;
        let mut reader = tokio::fs::File::open(file).await.map_err(failed)?;
        let size = reader.metadata().await.map_err(failed)?.len();
        if size <= PART_BYTES {
            let bytes = read_part(&mut reader, PART_BYTES + 1).await.map_err(failed)?;
            let stored = bytes.len() as u64;
            self.store.put(&path, bytes.into()).await?;
            progress(stored);
        } else {
            let part_bytes = PART_BYTES.max(size.div_ceil(MAX_PARTS));
            let mut upload = self.store.put_multipart(&path).await?;
            let outcome = async {
                loop {
                    let bytes = read_part(&mut reader, part_bytes).await.map_err(failed)?;
                    if bytes.is_empty() {
                        break;
                    }
                    let stored = bytes.len() as u64;
                    upload.put_part(PutPayload::from(bytes)).await?;
                    progress(stored);
                }
                upload.complete().await?;
                Ok(())
            };
            if let Err(error) = outcome.await {
                abandon(upload.as_mut(), &path).await;
                return Err(error);
            }
        }
        let stored = self.store.head(&path).await?.size;
        if stored != size {
            self.delete(relative).await?;
            let problem = format!("{stored} bytes arrived of {size}");
            return Err(StoreError::Damaged { object: path.to_string(), problem });
        }
        Ok(())
    }

    /// Publishes the scene: whoever reads it from now on reads this manifest.
    pub async fn put_manifest(&self, manifest: &Manifest) -> Result<(), StoreError> {
        let text = serde_json::to_vec_pretty(manifest).map_err(|e| StoreError::BadManifest {
            scene: self.name().to_owned(),
            problem: e.to_string(),
        })?;
        // What could not be read again must not be published.
        Manifest::parse(self.name(), &text)?;
        self.store.put(&self.path(Manifest::PATH)?, text.into()).await?;
        Ok(())
    }
}

/// Up to `limit` bytes; fewer only at the end of the file.
async fn read_part(reader: &mut tokio::fs::File, limit: u64) -> std::io::Result<Bytes> {
    let mut part = BytesMut::new();
    let mut rest = reader.take(limit);
    while rest.read_buf(&mut part).await? > 0 {}
    Ok(part.freeze())
}

async fn abandon(upload: &mut dyn MultipartUpload, path: &Path) {
    if let Err(error) = upload.abort().await {
        tracing::debug!(%error, %path, "cannot abandon an upload");
    }
}
