//! Reads the panorama table by ranges.

use std::sync::Arc;

use flaneur_scene::{Bounds2, ImageId, Panorama, Region, RigCamera};
use geozero::ColumnValue;
use glam::{DMat3, DVec3};
use object_store::ObjectStore;
use object_store::path::Path;

use super::COLUMNS;
use crate::layers::LayerError;
use crate::layers::fgb::{FgbCursor, FgbFeature, FgbFile};

/// The panoramas of a selection, one after the other, in the file's order.
#[derive(Debug)]
pub struct PanoramaCursor {
    features: FgbCursor,
    region: Region,
}

/// The panoramas whose position lies in the region, nearest to the centre first where the
/// region is a disc, else in the file's order. Memory grows with what lies in the region;
/// [`open`] reads one at a time.
pub async fn read(
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    region: Region,
) -> Result<Vec<Panorama>, LayerError> {
    let mut cursor = open(store, path, size, region).await?;
    let mut panoramas = Vec::new();
    while let Some(panorama) = cursor.next().await? {
        panoramas.push(panorama);
    }
    if let Region::Disc { centre, .. } = region {
        let distance = |p: &Panorama| p.position.truncate().distance(centre);
        panoramas.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then_with(|| a.id.cmp(&b.id)));
    }
    Ok(panoramas)
}

/// Opens the table at `path`, of `size` bytes, and finds what lies in the region.
pub async fn open(
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    region: Region,
) -> Result<PanoramaCursor, LayerError> {
    let file = FgbFile::open(store, path, size).await?;
    Ok(PanoramaCursor { features: file.select(&region).await?, region })
}

impl PanoramaCursor {
    /// The next panorama, or `None` after the last.
    pub async fn next(&mut self) -> Result<Option<Panorama>, LayerError> {
        loop {
            let offset = self.features.offset();
            let Some(feature) = self.features.next().await? else { return Ok(None) };
            let panorama = self
                .decode(&feature)
                .map_err(|problem| LayerError::at_byte(self.features.path(), offset, problem))?;
            let position = panorama.position.truncate();
            if self.region.meets(&Bounds2 { min: position, max: position }) {
                return Ok(Some(panorama));
            }
        }
    }

    fn decode(&self, feature: &FgbFeature) -> Result<Panorama, String> {
        let position = position(feature).ok_or("a panorama without a finite Point Z")?;
        let header = self.features.header();
        let names = header.columns();
        let [mut id, mut time, mut rotation, mut cameras] = [None; 4];
        let mut uncertainty_m = 0.0;
        for (index, value) in feature.properties(&header)? {
            let name =
                names.filter(|names| index < names.len()).map(|names| names.get(index).name());
            match (name, value) {
                (Some("id"), ColumnValue::String(text)) => id = Some(text),
                (Some("time"), ColumnValue::DateTime(text)) => time = Some(text),
                (Some("uncertainty_m"), ColumnValue::Double(number)) => uncertainty_m = number,
                (Some("world_from_rig"), ColumnValue::Json(text)) => rotation = Some(text),
                (Some("cameras"), ColumnValue::Json(text)) => cameras = Some(text),
                // Derived columns, and what later versions may add.
                _ => {}
            }
        }
        let id = id.ok_or_else(|| missing("id"))?.to_owned();
        let world_from_rig: DMat3 = parse(rotation, "world_from_rig", &id)?;
        let cameras: Vec<RigCamera> = parse(cameras, "cameras", &id)?;
        if cameras.is_empty() {
            return Err(format!("panorama {id:?} has no camera"));
        }
        // Names become paths of objects, so they are checked before anyone asks for one.
        for camera in &cameras {
            ImageId::new(&id, &camera.id).map_err(|e| e.to_string())?;
            let mask = camera.mask.as_ref();
            let parts = [Some(&camera.version), mask.map(|mask| &mask.name)];
            for part in parts.into_iter().flatten() {
                ImageId::check_part(part).map_err(|e| e.to_string())?;
            }
            let size = camera.projection.size();
            let levels = camera.levels.len();
            if size.min_element() == 0 || levels == 0 || levels > 32 {
                return Err(format!(
                    "image {id}/{} of {size} pixels with {levels} levels",
                    camera.id
                ));
            }
            if camera.levels.iter().chain(mask.map(|mask| &mask.image)).any(|file| file.bytes == 0)
            {
                return Err(format!("image {id}/{} has an empty file", camera.id));
            }
        }
        Ok(Panorama {
            id,
            position,
            world_from_rig,
            time: time.map(ToOwned::to_owned),
            uncertainty_m,
            cameras,
        })
    }
}

fn position(feature: &FgbFeature) -> Option<DVec3> {
    let geometry = feature.geometry()?;
    let (xy, z) = (geometry.xy()?, geometry.z()?);
    let position =
        (xy.len() == 2 && z.len() == 1).then(|| DVec3::new(xy.get(0), xy.get(1), z.get(0)))?;
    position.is_finite().then_some(position)
}

fn parse<T: serde::de::DeserializeOwned>(
    text: Option<&str>,
    column: &str,
    id: &str,
) -> Result<T, String> {
    let text = text.ok_or_else(|| missing(column))?;
    serde_json::from_str(text).map_err(|e| format!("panorama {id:?}, column {column:?}: {e}"))
}

fn missing(column: &str) -> String {
    format!("a panorama without {column:?}; the columns are {COLUMNS:?}")
}

#[cfg(test)]
mod tests;
