//! Reading one file of footprints, whatever its format.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flaneur_scene::{Bounds2, Polygon};
use serde_json::{Map, Value};

use super::{Surveyed, cityjson, geojson, name_of, outline, table};
use crate::crs::{Crs, epsg_code};
use crate::ingest::street::{FootprintsFormat, FootprintsSpec};
use crate::ingest::{BadInput, IngestError, Job, Stage, Unit};

/// The footprints of the file that `spec` names; those that cannot be extruded are left out with
/// a warning.
pub(super) fn read(
    job: &Job,
    spec: &FootprintsSpec,
    crs: &Crs,
) -> Result<Vec<Surveyed>, IngestError> {
    let path = &spec.path;
    let format = match spec.format {
        Some(format) => format,
        None => recognise(path)?,
    };
    let stage = job.stage(&format!("footprints {}", name_of(path)), 0, Unit::Items);
    let mut collector = Collector {
        job,
        path,
        stage,
        extent: Bounds2::EMPTY,
        found: Vec::new(),
        read: 0,
        bytes: 0,
    };
    match format {
        FootprintsFormat::GeoJson => geojson::read(path, crs, &mut collector)?,
        FootprintsFormat::FlatGeobuf => table::read(path, crs, &mut collector)?,
        FootprintsFormat::CityJson => cityjson::read(path, crs, &mut collector)?,
    }
    let degrees = Bounds2 { min: (-180.0, -90.0).into(), max: (180.0, 90.0).into() };
    let extent = collector.extent;
    let inside = extent.min.cmpge(degrees.min).all() && extent.max.cmple(degrees.max).all();
    if crs.epsg().is_some() && !extent.is_empty() && inside {
        let problem = format!(
            "coordinates from {} to {} look like degrees, not metres",
            extent.min, extent.max
        );
        return Err(BadInput::error(path, "", problem, format!("convert the file to {crs}")));
    }
    Ok(collector.found)
}

/// Takes what a reader finds in a file.
pub(super) struct Collector<'a> {
    job: &'a Job,
    path: &'a Path,
    stage: Box<dyn Stage>,
    extent: Bounds2,
    found: Vec<Surveyed>,
    read: u64,
    bytes: u64,
}

/// A feature as a reader found it.
pub(super) struct Found {
    /// Identifier of the feature itself.
    pub(super) id: Option<String>,
    /// Its polygons, rings with or without a repeated last vertex, or why it has none.
    pub(super) polygons: Result<Vec<Polygon>, String>,
    pub(super) lowest_m: Option<f64>,
    pub(super) top_m: Option<f64>,
    pub(super) attributes: Map<String, Value>,
}

impl Collector<'_> {
    /// The job, to ask whether it was cancelled.
    pub(super) fn job(&self) -> &Job {
        self.job
    }

    /// Takes a feature, or warns that it cannot be used.
    pub(super) fn take(&mut self, found: Found) -> Result<(), IngestError> {
        self.job.check()?;
        self.read += 1;
        self.stage.advance(1);
        let Found { id, polygons, lowest_m, top_m, attributes } = found;
        let id = id
            .or_else(|| attributes.iter().find_map(identifier))
            .unwrap_or_else(|| format!("{}:{}", name_of(self.path), self.read - 1));
        let warn = |kind: &'static str, reason: &str| {
            self.job.warn(kind, format!("{}, feature {id:?}: {reason}", self.path.display()));
        };
        let polygons = match polygons {
            Ok(polygons) if polygons.is_empty() => {
                warn("degenerate-polygon", "it has no points");
                return Ok(());
            }
            Ok(polygons) => polygons,
            Err(reason) => {
                warn("not-a-footprint", &reason);
                return Ok(());
            }
        };
        // Before any is left out: in degrees, buildings have hardly any area.
        let vertices = polygons.iter().flat_map(|polygon| polygon.rings.iter().flatten());
        vertices.filter(|v| v.is_finite()).for_each(|vertex| self.extent.include(*vertex));
        let mut kept = Vec::with_capacity(polygons.len());
        for polygon in polygons {
            match outline::clean(polygon) {
                Ok((polygon, holes)) => {
                    holes.iter().for_each(|reason| warn("degenerate-hole", reason));
                    kept.push(polygon);
                }
                Err(reason) => warn("degenerate-polygon", &reason),
            }
        }
        if kept.is_empty() {
            return Ok(());
        }
        let surveyed = Surveyed { id, polygons: kept, lowest_m, top_m, attributes };
        self.bytes += surveyed.bytes();
        if self.bytes > self.job.memory / 2 {
            let problem = format!(
                "its first {} footprints do not fit into half of the memory budget of {} bytes",
                self.read, self.job.memory
            );
            let remedy = "raise --memory, or split the file into several streets";
            return Err(BadInput::error(self.path, "", problem, remedy));
        }
        self.found.push(surveyed);
        Ok(())
    }

    /// Compares the CRS that the file names with that of the scene.
    pub(super) fn check_crs(&self, named: &str, crs: &Crs) -> Result<(), IngestError> {
        let matches = epsg_code(named).map(|code| crs.has_plan_of(code));
        if matches == Some(true) {
            return Ok(());
        }
        Err(BadInput::error(
            self.path,
            "crs",
            format!("the file is in {named:?}, the scene in {crs}"),
            format!("convert the file to {crs}, or change crs in [scene]"),
        ))
    }
}

/// The value of a property that can identify a feature: one named `id`, in any case, or the
/// identifier that a stored layer of footprints gave it.
fn identifier((name, value): (&String, &Value)) -> Option<String> {
    if !name.eq_ignore_ascii_case("id") && name != crate::layers::footprints::ID {
        return None;
    }
    match value {
        Value::String(text) if !text.is_empty() => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// The format of a file, by its first bytes.
fn recognise(path: &Path) -> Result<FootprintsFormat, IngestError> {
    const REMEDY: &str =
        "give GeoJSON, FlatGeobuf or CityJSON, or name the format: format = \"geojson\"";
    let open = |error: std::io::Error| {
        BadInput::error(path, "", error.to_string(), "check the path of [[footprints]]")
    };
    let mut start = Vec::new();
    File::open(path).map_err(open)?.take(4096).read_to_end(&mut start).map_err(open)?;
    if start.starts_with(b"fgb") {
        return Ok(FootprintsFormat::FlatGeobuf);
    }
    let text = String::from_utf8_lossy(&start);
    let name = name_of(path).to_ascii_lowercase();
    if !text.trim_start_matches('\u{feff}').trim_start().starts_with('{') {
        let problem = "it begins neither as JSON nor as FlatGeobuf";
        return Err(BadInput::error(path, "", problem, REMEDY));
    }
    // CityJSON says so in a member that need not come first.
    let tight: String = text.split_ascii_whitespace().collect();
    let says_city = tight.contains("\"type\":\"CityJSON\"") || tight.contains("\"CityObjects\"");
    let says_geo = tight.contains("\"type\":\"Feature") || name.ends_with(".geojson");
    let city = says_city || (!says_geo && name.contains("city"));
    Ok(if city { FootprintsFormat::CityJson } else { FootprintsFormat::GeoJson })
}
