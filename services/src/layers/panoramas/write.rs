//! Writes the panorama table.

use std::io::Write;

use flaneur_scene::{Panorama, heading_pitch_roll};
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use geozero::error::Result as GeozeroResult;
use geozero::{ColumnValue, CoordDimensions, GeomProcessor, GeozeroGeometry, PropertyProcessor};
use glam::DVec3;

use super::COLUMNS;

/// Why the table was not written.
#[derive(Debug, thiserror::Error)]
pub enum PanoramaTableError {
    /// The file could not be written.
    #[error("cannot write the panorama table: {0}")]
    Write(String),
    /// A panorama holds something that the format does not.
    #[error("panorama {id:?} cannot be stored: {problem}")]
    Panorama {
        /// Its name.
        id: String,
        /// What is in the way.
        problem: String,
    },
}

/// Writes the panoramas as a spatially indexed FlatGeobuf. `epsg` is the code of the
/// scene's CRS, where it has one. The same panoramas give the same bytes.
pub fn write<'a>(
    out: impl Write,
    panoramas: impl IntoIterator<Item = &'a Panorama>,
    epsg: Option<u16>,
) -> Result<(), PanoramaTableError> {
    let failed = |e: flatgeobuf::Error| PanoramaTableError::Write(e.to_string());
    let options = FgbWriterOptions {
        detect_type: false,
        promote_to_multi: false,
        has_z: true,
        description: Some(
            "rigs of cameras: rig x right, y forward, z up; camera x right, y down, z forward",
        ),
        crs: FgbCrs {
            org: epsg.map(|_| "EPSG"),
            code: epsg.map_or(0, i32::from),
            ..FgbCrs::default()
        },
        ..FgbWriterOptions::default()
    };
    let mut writer = FgbWriter::create_with_options("panoramas", GeometryType::Point, options)
        .map_err(failed)?;
    for name in COLUMNS {
        let (kind, description) = column(name);
        writer.add_column(name, kind, |fbb, args| {
            args.description = Some(fbb.create_string(description));
            args.nullable = name == "time";
        });
    }
    for panorama in panoramas {
        add(&mut writer, panorama)?;
    }
    writer.write(out).map_err(failed)
}

fn column(name: &str) -> (ColumnType, &'static str) {
    match name {
        "id" => (ColumnType::String, "name, unique in the scene"),
        "time" => (ColumnType::DateTime, "RFC 3339"),
        "heading_deg" => (ColumnType::Double, "degrees clockwise from grid north, derived"),
        "pitch_deg" => (ColumnType::Double, "degrees, positive looks up, derived"),
        "roll_deg" => (ColumnType::Double, "degrees, positive lowers the right side, derived"),
        "uncertainty_m" => {
            (ColumnType::Double, "standard deviation of the position, 0 where unknown")
        }
        "world_from_rig" => (ColumnType::Json, "rotation, 9 numbers, column after column"),
        _ => (
            ColumnType::Json,
            "cameras of the rig: p_cam = cam_from_rig (p_rig - position_in_rig), matrices column after column",
        ),
    }
}

fn add(writer: &mut FgbWriter<'_>, panorama: &Panorama) -> Result<(), PanoramaTableError> {
    let refused =
        |problem: String| PanoramaTableError::Panorama { id: panorama.id.clone(), problem };
    if !panorama.position.is_finite() {
        return Err(refused(format!("its position is {}", panorama.position)));
    }
    // serde_json writes NaN as null, which would not come back.
    if !panorama.world_from_rig.is_finite() {
        return Err(refused(format!("its rotation is {}", panorama.world_from_rig)));
    }
    let rotation = serde_json::to_string(&panorama.world_from_rig);
    let rotation = rotation.map_err(|e| refused(e.to_string()))?;
    let cameras = serde_json::to_string(&panorama.cameras).map_err(|e| refused(e.to_string()))?;
    let angles = heading_pitch_roll(&panorama.world_from_rig).map(f64::to_degrees);
    let values = [
        Some(ColumnValue::String(&panorama.id)),
        panorama.time.as_deref().map(ColumnValue::DateTime),
        Some(ColumnValue::Double(angles[0])),
        Some(ColumnValue::Double(angles[1])),
        Some(ColumnValue::Double(angles[2])),
        Some(ColumnValue::Double(panorama.uncertainty_m)),
        Some(ColumnValue::Json(&rotation)),
        Some(ColumnValue::Json(&cameras)),
    ];
    let mut properties = Ok(());
    writer
        .add_feature_geom(PointZ(panorama.position), |feature| {
            properties =
                values.iter().zip(COLUMNS).enumerate().try_for_each(|(i, (value, name))| {
                    value
                        .as_ref()
                        .map_or(Ok(()), |value| feature.property(i, name, value).map(|_| ()))
                });
        })
        .and(properties)
        .map_err(|e| PanoramaTableError::Write(e.to_string()))
}

/// A point with its height, which geo-types points lack.
struct PointZ(DVec3);

impl GeozeroGeometry for PointZ {
    fn process_geom<P: GeomProcessor>(&self, processor: &mut P) -> GeozeroResult<()> {
        let DVec3 { x, y, z } = self.0;
        processor.point_begin(0)?;
        processor.coordinate(x, y, Some(z), None, None, None, 0)?;
        processor.point_end(0)
    }

    fn dims(&self) -> CoordDimensions {
        CoordDimensions::xyz()
    }
}
