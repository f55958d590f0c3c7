//! FlatGeobuf, one feature at a time.

use std::path::Path;
use std::sync::Arc;

use flaneur_scene::Region;
use object_store::local::LocalFileSystem;
use object_store::{ObjectStore, ObjectStoreExt};

use super::source::{Collector, Found};
use crate::crs::Crs;
use crate::ingest::{BadInput, IngestError};
use crate::layers::LayerError;
use crate::layers::fgb::{FgbFile, Polygons, attributes};

/// Hands the features of the file at `path` to `collector`. The CRS in its header, where there
/// is one, must agree with `crs`.
pub(super) fn read(
    path: &Path,
    crs: &Crs,
    collector: &mut Collector<'_>,
) -> Result<(), IngestError> {
    // The reader is that of the stored layer, which asks a store for ranges; here the store is
    // the file system, and this thread may block.
    futures::executor::block_on(async {
        let fail = |error| bad(path, error);
        let place = std::path::absolute(path)
            .map_err(|error| BadInput::error(path, "", error.to_string(), "check the file"))?;
        let place = object_store::path::Path::from_absolute_path(place)
            .map_err(|error| fail(LayerError::Store(error.into())))?;
        let store: Arc<dyn ObjectStore> = Arc::new(LocalFileSystem::new());
        let size = store.head(&place).await.map_err(|error| fail(error.into()))?.size;
        let file = FgbFile::open(store, place, size).await.map_err(fail)?;
        let header = file.header();
        if let Some(found) = header.crs().filter(|found| found.code() != 0) {
            let named = format!("{}:{}", found.org().unwrap_or("EPSG"), found.code());
            collector.check_crs(&named, crs)?;
        }
        let mut features = file.select(&Region::All).await.map_err(fail)?;
        loop {
            let offset = features.offset();
            let Some(feature) = features.next().await.map_err(fail)? else { return Ok(()) };
            let attributes = attributes(&feature, &header)
                .map_err(|problem| fail(LayerError::at_byte(features.path(), offset, problem)))?;
            let found = match feature.geometry() {
                Some(geometry) => Polygons::of(&geometry, header.geometry_type()),
                None => Err("it has no geometry".to_owned()),
            };
            let (polygons, lowest_m) = match found {
                Ok(found) => (Ok(found.polygons), found.lowest_m),
                Err(reason) => (Err(reason), None),
            };
            collector.take(Found { id: None, polygons, lowest_m, top_m: None, attributes })?;
        }
    })
}

fn bad(path: &Path, error: LayerError) -> IngestError {
    let (place, problem) = match error {
        LayerError::Store(error) => (String::new(), error.to_string()),
        LayerError::Damaged { place, problem, .. } => (place, problem),
    };
    BadInput::error(path, place, problem, "export the FlatGeobuf again")
}
