//! Full spheres listed with their poses, in CSV or GeoJSON.

use std::path::Path;

use glam::{DMat3, DVec3};
use serde_json::Value;

use super::csv;
use super::draft::{Draft, DraftCamera, DraftLens};
use super::files::read_whole;
use super::pose::{PoseFrame, PublishedPose, checked_name, checked_time};
use crate::crs::Crs;
use crate::ingest::street::EquirectangularSpec;
use crate::ingest::{BadInput, IngestError, Job};

/// The panoramas of the list, in its order, each of one camera named `sphere`.
pub(super) fn read(
    job: &Job,
    spec: &EquirectangularSpec,
    crs: &Crs,
) -> Result<Vec<Draft>, IngestError> {
    let file = &spec.list;
    let text = String::from_utf8(read_whole(job, file)?).map_err(|e| {
        let place = format!("byte {}", e.utf8_error().valid_up_to());
        BadInput::error(file, place, "it is no UTF-8", "save the list as UTF-8")
    })?;
    let is_csv = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let rows = if is_csv { csv_rows(file, &text)? } else { geojson_rows(file, &text)? };
    if crs.epsg().is_some() {
        refuse_degrees(file, &rows)?;
    }
    let convergence = |at| crs.meridian_convergence(at);
    let frame = PoseFrame {
        north: spec.heading,
        convergence: &convergence,
        height_offset_m: spec.height_offset_m,
        boresight_deg: spec.boresight_deg,
    };
    let mut drafts = Vec::with_capacity(rows.len());
    for row in rows {
        job.check()?;
        let id = checked_name(row.id, file, &row.place)?;
        let (position, world_from_rig) = frame.resolve(&row.pose, file, &row.place)?;
        let image = spec.root.resolve(&spec.images, &row.image, file, &row.place)?;
        drafts.push(Draft {
            id,
            position,
            world_from_rig,
            time: checked_time(row.time),
            uncertainty_m: spec.uncertainty_m,
            cameras: vec![DraftCamera {
                id: "sphere".into(),
                position_in_rig: DVec3::ZERO,
                cam_from_rig: DMat3::IDENTITY,
                lens: DraftLens::Sphere,
                image,
                mask: None,
            }],
            file: file.clone(),
            place: row.place,
        });
    }
    Ok(drafts)
}

/// A panorama of the list.
struct Row {
    id: String,
    pose: PublishedPose,
    image: String,
    time: Option<String>,
    place: String,
}

const COLUMNS: &str = "id, x, y, z, heading_deg, pitch_deg, roll_deg, image and perhaps time";

fn csv_rows(file: &Path, text: &str) -> Result<Vec<Row>, IngestError> {
    let remedy = format!("give the columns {COLUMNS}");
    let mut records = csv::parse(text)
        .map_err(|(line, problem)| BadInput::error(file, format!("line {line}"), problem, &remedy))?
        .into_iter();
    let header = records.next().map(|(_, names)| names).unwrap_or_default();
    let column = |name: &str| header.iter().position(|column| column.trim() == name);
    let needed = |name: &str| {
        column(name).ok_or_else(|| {
            BadInput::error(file, "line 1", format!("there is no column {name:?}"), &remedy)
        })
    };
    let (id, image) = (needed("id")?, needed("image")?);
    let numbers = ["x", "y", "z", "heading_deg", "pitch_deg", "roll_deg"];
    let mut columns = [0; 6];
    for (column, name) in columns.iter_mut().zip(numbers) {
        *column = needed(name)?;
    }
    let time = column("time");
    let mut rows = Vec::new();
    for (line, mut fields) in records {
        let place = format!("line {line}");
        if fields.len() != header.len() {
            return Err(BadInput::error(
                file,
                place,
                format!("{} fields, where the header has {}", fields.len(), header.len()),
                &remedy,
            ));
        }
        let mut values = [0.0; 6];
        for ((value, &column), name) in values.iter_mut().zip(&columns).zip(numbers) {
            let field = fields[column].trim();
            *value = field.parse().map_err(|_| {
                BadInput::error(file, &place, format!("{name} is {field:?}"), "give a number")
            })?;
        }
        let mut take = |column: usize| std::mem::take(&mut fields[column]).trim().to_owned();
        rows.push(Row {
            id: take(id),
            pose: pose(values),
            image: take(image),
            time: time.map(take).filter(|time| !time.is_empty()),
            place,
        });
    }
    Ok(rows)
}

fn geojson_rows(file: &Path, text: &str) -> Result<Vec<Row>, IngestError> {
    const REMEDY: &str = "give a FeatureCollection of Points in the street's CRS";
    let document: Value =
        serde_json::from_str(text).map_err(|e| BadInput::json(file, &e, REMEDY))?;
    let features = document.get("features").and_then(Value::as_array);
    let features = features
        .ok_or_else(|| BadInput::error(file, "", "it has no list of \"features\"", REMEDY))?;
    let properties_remedy = format!("give the properties {COLUMNS}");
    let mut rows = Vec::with_capacity(features.len());
    for (i, feature) in features.iter().enumerate() {
        let place = format!("feature {}", i + 1);
        let refuse = |problem: String, remedy: &str| BadInput::error(file, &place, problem, remedy);
        let geometry = &feature["geometry"];
        if geometry["type"] != "Point" {
            return Err(refuse(format!("its geometry is a {}", geometry["type"]), REMEDY));
        }
        let properties = &feature["properties"];
        let number = |name: &str| {
            properties[name].as_f64().ok_or_else(|| {
                refuse(format!("{name:?} is {}", properties[name]), &properties_remedy)
            })
        };
        let coordinate = |axis: usize| geometry["coordinates"][axis].as_f64();
        let (Some(x), Some(y)) = (coordinate(0), coordinate(1)) else {
            let problem = format!("its coordinates are {}", geometry["coordinates"]);
            return Err(refuse(problem, REMEDY));
        };
        let z = coordinate(2).map_or_else(|| number("z"), Ok)?;
        let text = |value: &Value| match value {
            Value::String(text) => Some(text.clone()),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        };
        let missing = |name: &str| refuse(format!("it has no {name:?}"), &properties_remedy);
        rows.push(Row {
            id: text(&properties["id"])
                .or_else(|| text(&feature["id"]))
                .ok_or_else(|| missing("id"))?,
            pose: pose([
                x,
                y,
                z,
                number("heading_deg")?,
                number("pitch_deg")?,
                number("roll_deg")?,
            ]),
            image: text(&properties["image"]).ok_or_else(|| missing("image"))?,
            time: text(&properties["time"]),
            place,
        });
    }
    Ok(rows)
}

fn pose([x, y, z, heading_deg, pitch_deg, roll_deg]: [f64; 6]) -> PublishedPose {
    PublishedPose { position: DVec3::new(x, y, z), heading_deg, pitch_deg, roll_deg }
}

/// GeoJSON from elsewhere is in degrees, which no projected street within reach would be.
fn refuse_degrees(file: &Path, rows: &[Row]) -> Result<(), IngestError> {
    let is_degrees = |p: DVec3| p.x.abs() <= 180.0 && p.y.abs() <= 90.0;
    match rows.first() {
        Some(first) if rows.iter().all(|row| is_degrees(row.pose.position)) => {
            let DVec3 { x, y, .. } = first.pose.position;
            Err(BadInput::error(
                file,
                &first.place,
                format!("its position ({x}, {y}) looks like degrees, as every other does"),
                "give positions in the CRS of the street",
            ))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
