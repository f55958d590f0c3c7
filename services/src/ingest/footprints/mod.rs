//! Building footprints: GeoJSON, FlatGeobuf and CityJSON in, one FlatGeobuf out.
//!
//! Outlines keep the survey's coordinates. What cannot be extruded (a polygon that crosses
//! itself, has two points or no area) is left out, with a warning that names it.

mod cityjson;
mod each;
mod geojson;
mod height;
mod limited;
mod nested;
mod outline;
mod roofs;
mod shell;
mod source;
mod table;

use std::path::{Path, PathBuf};

use flaneur_scene::{Bounds2, Bounds3, Footprint, Polygon};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::ground::Ground;
use super::street::FootprintsSpec;
use super::{IngestError, Job, Unit};
use crate::crs::Crs;
use crate::layers::AttributeColumns;
use crate::layers::footprints::FootprintsWriter;

/// A layer of footprints that waits for publication.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StagedFootprints {
    /// The FlatGeobuf.
    pub file: PathBuf,
    /// Number of footprints.
    pub count: u64,
    /// The box around them, roofs included.
    pub bounds: Bounds3,
}

/// A footprint as a file has it: polygons fit to be extruded, height not yet settled.
struct Surveyed {
    id: String,
    polygons: Vec<Polygon>,
    /// Lowest height that the geometry itself has, metres.
    lowest_m: Option<f64>,
    /// Highest height that the geometry itself has, metres.
    top_m: Option<f64>,
    attributes: Map<String, Value>,
}

/// A footprint on its ground.
struct Placed {
    survey: Surveyed,
    base_m: f64,
    height_m: Option<f64>,
}

/// Reads the footprints of `specs`, puts them on the `ground`, and takes heights from the `points`
/// where a spec says so. `None` where there is no footprint.
///
/// A foot is the lowest ground under the outline. Where no ground is known there, it is the
/// lowest height of the geometry, and where that is flat, 0.
///
/// # Errors
///
/// Where a file is damaged or in another CRS, no height at all can be found, or what is read does
/// not fit into half of the memory budget.
pub fn ingest_footprints(
    job: &Job,
    specs: &[FootprintsSpec],
    crs: &Crs,
    ground: Option<&Ground>,
    points: &[PathBuf],
) -> Result<Option<StagedFootprints>, IngestError> {
    let mut footprints = Vec::new();
    for spec in specs {
        match place(job, spec, crs, ground, points) {
            Err(IngestError::BadInput(fault)) if job.skip_damaged => {
                job.warn("damaged-file", fault.to_string());
            }
            placed => footprints.extend(placed?),
        }
    }
    if footprints.is_empty() {
        return Ok(None);
    }
    write(job, crs, &footprints).map(Some)
}

/// The bounds that the footprints of `specs` will have in the plan; empty where there are none.
/// The ground that they stand on must reach as far.
///
/// # Errors
///
/// As [`ingest_footprints`].
pub fn footprint_extent(
    job: &Job,
    specs: &[FootprintsSpec],
    crs: &Crs,
) -> Result<Bounds2, IngestError> {
    let mut extent = Bounds2::EMPTY;
    // What is wrong with a file is told when it is read in earnest.
    let quiet = job.layer(job.work.clone());
    for spec in specs {
        match source::read(&quiet, spec, crs) {
            Err(IngestError::BadInput(_)) if job.skip_damaged => {}
            surveyed => {
                let surveyed = surveyed?;
                surveyed.iter().flat_map(Surveyed::vertices).for_each(|v| extent.include(v));
            }
        }
    }
    Ok(extent)
}

fn place(
    job: &Job,
    spec: &FootprintsSpec,
    crs: &Crs,
    ground: Option<&Ground>,
    points: &[PathBuf],
) -> Result<Vec<Footprint>, IngestError> {
    let surveyed = source::read(job, spec, crs)?;
    let mut adrift = 0;
    let mut placed: Vec<Placed> = surveyed
        .into_iter()
        .map(|survey| {
            let below = survey.polygons.iter().filter_map(|p| p.rings.first());
            let below = below.filter_map(|ring| ground?.lowest_along(ring)).reduce(f64::min);
            adrift += u64::from(below.is_none());
            let base_m = below.or(survey.lowest_m).unwrap_or(0.0);
            Placed { survey, base_m, height_m: None }
        })
        .collect();
    if adrift > 0 {
        let lowest = "the lowest height of their geometry, or at 0 where that is flat";
        job.warn(
            "no-ground",
            format!(
                "{}: {adrift} footprints without ground stand at {lowest}",
                spec.path.display()
            ),
        );
    }
    height::settle(job, spec, &mut placed, points)?;
    Ok(placed
        .into_iter()
        .map(|Placed { survey, base_m, height_m }| Footprint {
            id: survey.id,
            polygons: survey.polygons,
            base_m,
            height_m: height_m.unwrap_or(0.0),
            uncertainty_m: spec.uncertainty_m,
            attributes: Value::Object(survey.attributes).to_string(),
        })
        .collect())
}

fn write(job: &Job, crs: &Crs, footprints: &[Footprint]) -> Result<StagedFootprints, IngestError> {
    let file = job.work.join("footprints.fgb");
    let fail = |source| IngestError::Io {
        action: "write",
        path: file.clone(),
        source,
        remedy: "free some space or choose another work folder".to_owned(),
    };
    let mut columns = AttributeColumns::default();
    for footprint in footprints {
        let attributes = serde_json::from_str(&footprint.attributes);
        columns.observe(&attributes.map_err(|error| fail(error.into()))?);
    }
    let stage = job.stage("writing footprints", footprints.len() as u64, Unit::Items);
    let mut writer = FootprintsWriter::new(crs, columns).map_err(fail)?;
    let mut bounds = Bounds3::EMPTY;
    for footprint in footprints {
        job.check()?;
        writer.push(footprint).map_err(fail)?;
        let plan = footprint.bounds();
        bounds.include(plan.min.extend(footprint.base_m));
        bounds.include(plan.max.extend(footprint.base_m + footprint.height_m));
        stage.advance(1);
    }
    let count = writer.count;
    writer.finish(&file).map_err(fail)?;
    Ok(StagedFootprints { file, count, bounds })
}

impl Surveyed {
    fn vertices(&self) -> impl Iterator<Item = DVec2> {
        self.polygons.iter().flat_map(|polygon| polygon.rings.iter().flatten().copied())
    }

    /// Bytes of memory that it takes, roughly.
    fn bytes(&self) -> u64 {
        let text = |map: &Map<String, Value>| {
            map.iter().map(|(name, value)| name.len() + 64 + value_bytes(value)).sum::<usize>()
        };
        (size_of::<Self>() + self.vertices().count() * 16 + text(&self.attributes)) as u64
    }
}

fn value_bytes(value: &Value) -> usize {
    match value {
        Value::String(text) => text.len(),
        Value::Array(list) => list.iter().map(|value| 32 + value_bytes(value)).sum(),
        Value::Object(map) => map.iter().map(|(k, v)| 96 + k.len() + value_bytes(v)).sum(),
        _ => 0,
    }
}

/// The name by which messages call a file.
fn name_of(path: &Path) -> std::borrow::Cow<'_, str> {
    path.file_name().map_or_else(|| path.to_string_lossy(), |name| name.to_string_lossy())
}

#[cfg(test)]
mod tests;
