//! Footprints as FlatGeobuf: one feature a building, its polygons bit for bit, its attributes in
//! typed columns, and Flaneur's own in columns that begin with `flaneur_`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path as FilePath;
use std::sync::Arc;

use flaneur_scene::{Bounds2, Footprint, Region};
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType, Header};
use geozero::error::Result as GeozeroResult;
use geozero::{ColumnValue, GeomProcessor, GeozeroGeometry, PropertyProcessor};
use object_store::ObjectStore;
use object_store::path::Path;
use serde_json::{Map, Value};

use super::AttributeColumns;
use super::fgb::{FgbCursor, FgbFeature, FgbFile, Polygons, attributes};
use crate::crs::Crs;
use crate::layers::LayerError;

/// The column of identifiers.
pub(crate) const ID: &str = "flaneur_id";
const BASE: &str = "flaneur_base_m";
const HEIGHT: &str = "flaneur_height_m";
const UNCERTAINTY: &str = "flaneur_uncertainty_m";
/// Attributes that have no column of their own, a JSON object.
const MORE: &str = "flaneur_more";

/// Writes a layer of footprints.
pub struct FootprintsWriter {
    writer: FgbWriter<'static>,
    columns: AttributeColumns,
    /// Footprints written so far.
    pub count: u64,
    /// The rectangle around them.
    pub bounds: Bounds2,
}

impl FootprintsWriter {
    /// A layer in `crs` whose attributes fit into `columns`.
    ///
    /// # Errors
    ///
    /// Where the system has no room for temporary files.
    pub fn new(crs: &Crs, columns: AttributeColumns) -> std::io::Result<Self> {
        let name = crs.to_string();
        let options = FgbWriterOptions {
            crs: FgbCrs {
                org: crs.epsg().map(|_| "EPSG"),
                code: crs.epsg().map_or(0, i32::from),
                name: Some(&name),
                ..FgbCrs::default()
            },
            ..FgbWriterOptions::default()
        };
        let mut writer =
            FgbWriter::create_with_options("footprints", GeometryType::MultiPolygon, options)
                .map_err(std::io::Error::other)?;
        let own = [
            (ID, ColumnType::String),
            (BASE, ColumnType::Double),
            (HEIGHT, ColumnType::Double),
            (UNCERTAINTY, ColumnType::Double),
        ];
        for (name, kind) in columns.columns().chain(own) {
            writer.add_column(name, kind, |_, _| {});
        }
        if columns.overflows() {
            writer.add_column(MORE, ColumnType::Json, |_, _| {});
        }
        Ok(Self { writer, columns, count: 0, bounds: Bounds2::EMPTY })
    }

    /// Adds a footprint. Its attributes must have been observed by the columns.
    ///
    /// # Errors
    ///
    /// Where the attributes are not a JSON object, or the disk is full.
    pub fn push(&mut self, footprint: &Footprint) -> std::io::Result<()> {
        let attributes: Map<String, Value> = serde_json::from_str(&footprint.attributes)?;
        let columns = &self.columns;
        let mut outcome = Ok(());
        self.writer
            .add_feature_geom(Shape(footprint), |feature| {
                outcome = (|| {
                    let rest = columns.write(&attributes, |index, name, value| {
                        feature.property(index, name, value).map(drop)
                    })?;
                    let rest = (!rest.is_empty()).then(|| Value::Object(rest).to_string());
                    let own = [
                        (ID, Some(ColumnValue::String(&footprint.id))),
                        (BASE, Some(ColumnValue::Double(footprint.base_m))),
                        (HEIGHT, Some(ColumnValue::Double(footprint.height_m))),
                        (UNCERTAINTY, Some(ColumnValue::Double(footprint.uncertainty_m))),
                        (MORE, rest.as_deref().map(ColumnValue::Json)),
                    ];
                    for (i, (name, value)) in own.into_iter().enumerate() {
                        if let Some(value) = value {
                            feature.property(columns.len() + i, name, &value)?;
                        }
                    }
                    GeozeroResult::Ok(())
                })();
            })
            .map_err(std::io::Error::other)?;
        outcome.map_err(std::io::Error::other)?;
        self.count += 1;
        let bounds = footprint.bounds();
        self.bounds.include(bounds.min);
        self.bounds.include(bounds.max);
        Ok(())
    }

    /// Writes everything to `path`.
    ///
    /// # Errors
    ///
    /// Where the file cannot be written.
    pub fn finish(self, path: &FilePath) -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        self.writer.write(&mut file).map_err(|error| match error {
            flatgeobuf::Error::IO(source) => source,
            other => std::io::Error::other(other),
        })?;
        file.flush()?;
        file.get_ref().sync_all()
    }
}

/// The footprints of a selection, one after the other, in the file's order.
#[derive(Debug)]
pub struct FootprintCursor {
    features: FgbCursor,
    region: Region,
}

/// Opens the layer of `size` bytes at `path`, and finds the footprints whose rectangle meets
/// `region`. Only what the region needs is read.
///
/// # Errors
///
/// Where the object is not such a layer.
pub async fn open(
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    region: Region,
) -> Result<FootprintCursor, LayerError> {
    let file = FgbFile::open(store, path, size).await?;
    Ok(FootprintCursor { features: file.select(&region).await?, region })
}

impl FootprintCursor {
    /// The next footprint, or `None` after the last.
    ///
    /// # Errors
    ///
    /// Where the store fails or the layer is damaged; the selection cannot be read further.
    pub async fn next(&mut self) -> Result<Option<Footprint>, LayerError> {
        loop {
            let offset = self.features.offset();
            let Some(feature) = self.features.next().await? else { return Ok(None) };
            let path = self.features.path();
            let footprint = decode(&feature, &self.features.header())
                .map_err(|problem| LayerError::at_byte(path, offset, problem))?;
            if self.region.meets(&footprint.bounds()) {
                return Ok(Some(footprint));
            }
        }
    }
}

fn decode(feature: &FgbFeature, header: &Header<'_>) -> Result<Footprint, String> {
    let geometry = feature.geometry().ok_or("a footprint without geometry")?;
    let polygons = Polygons::of(&geometry, header.geometry_type())?.polygons;
    let mut attributes = attributes(feature, header)?;
    let mut number = |name: &str| {
        attributes
            .shift_remove(name)
            .and_then(|value| value.as_f64())
            .ok_or_else(|| format!("a footprint without a number in column {name:?}"))
    };
    let (base_m, height_m) = (number(BASE)?, number(HEIGHT)?);
    let uncertainty_m = number(UNCERTAINTY)?;
    let id = match attributes.shift_remove(ID) {
        Some(Value::String(id)) => id,
        _ => return Err(format!("a footprint without a text in column {ID:?}")),
    };
    if let Some(Value::Object(more)) = attributes.shift_remove(MORE) {
        attributes.extend(more);
    }
    let attributes = Value::Object(attributes).to_string();
    Ok(Footprint { id, polygons, base_m, height_m, uncertainty_m, attributes })
}

/// The geometry of a footprint, as a writer takes it: rings closed by their first vertex.
struct Shape<'a>(&'a Footprint);

impl GeozeroGeometry for Shape<'_> {
    fn process_geom<P: GeomProcessor>(&self, out: &mut P) -> GeozeroResult<()> {
        let polygons = &self.0.polygons;
        out.multipolygon_begin(polygons.len(), 0)?;
        for (i, polygon) in polygons.iter().enumerate() {
            out.polygon_begin(false, polygon.rings.len(), i)?;
            for (j, ring) in polygon.rings.iter().enumerate() {
                out.linestring_begin(false, ring.len() + 1, j)?;
                for (k, vertex) in ring.iter().chain(ring.first()).enumerate() {
                    out.xy(vertex.x, vertex.y, k)?;
                }
                out.linestring_end(false, j)?;
            }
            out.polygon_end(false, i)?;
        }
        out.multipolygon_end(0)
    }
}

#[cfg(test)]
mod tests;
