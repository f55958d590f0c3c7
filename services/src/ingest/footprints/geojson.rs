//! GeoJSON, one feature at a time.

use std::fmt;
use std::path::Path;

use flaneur_scene::Polygon;
use glam::DVec2;
use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use serde_json::{Map, Value};

use super::each::EachElement;
use super::limited::{Allowance, Limited};
use super::nested::Nested;
use super::source::{Collector, Found};
use crate::crs::Crs;
use crate::ingest::{BadInput, IngestError};

/// Hands the features of the file at `path` to `collector`. The member `crs`, which older files
/// have, must agree with `crs`; files without one are taken to be in the scene's.
pub(super) fn read(
    path: &Path,
    crs: &Crs,
    collector: &mut Collector<'_>,
) -> Result<(), IngestError> {
    const REMEDY: &str = "export it again as a GeoJSON FeatureCollection of polygons";
    let (source, allowance) = Limited::open(path)
        .map_err(|error| BadInput::error(path, "", error.to_string(), "check the file"))?;
    let mut source = serde_json::Deserializer::from_reader(source);
    let mut stopped = None;
    let document = Document { collector, allowance, stopped: &mut stopped };
    let outcome = source.deserialize_map(document).and_then(|named| source.end().map(|()| named));
    if let Some(error) = stopped {
        return Err(error);
    }
    let named = outcome.map_err(|error| BadInput::json(path, &error, REMEDY))?;
    named.map_or(Ok(()), |named| collector.check_crs(&named, crs))
}

#[derive(Deserialize)]
struct Feature {
    id: Option<Value>,
    geometry: Option<Geometry>,
    properties: Option<Map<String, Value>>,
}

#[derive(Deserialize)]
struct Geometry {
    r#type: String,
    coordinates: Option<Nested>,
    geometries: Option<Vec<Geometry>>,
}

impl Feature {
    fn found(self) -> Found {
        let mut polygons = Ok(Vec::new());
        let mut lowest_m: Option<f64> = None;
        match self.geometry {
            Some(geometry) => geometry.collect(&mut polygons, &mut lowest_m),
            None => polygons = Err("it has no geometry".to_owned()),
        }
        let id = match self.id {
            Some(Value::String(id)) if !id.is_empty() => Some(id),
            Some(Value::Number(id)) => Some(id.to_string()),
            _ => None,
        };
        let attributes = self.properties.unwrap_or_default();
        Found { id, polygons, lowest_m, top_m: None, attributes }
    }
}

impl Geometry {
    fn collect(self, into: &mut Result<Vec<Polygon>, String>, lowest_m: &mut Option<f64>) {
        let Ok(polygons) = into else { return };
        let coordinates = self.coordinates.unwrap_or_default();
        match (self.r#type.as_str(), coordinates.depth) {
            _ if coordinates.uneven => {
                *into = Err("its coordinates are nested unevenly".to_owned());
            }
            // Empty arrays have no depth.
            ("Polygon", 0 | 3) | ("MultiPolygon", 0 | 4) => match polygons_of(&coordinates) {
                Ok((found, lowest)) => {
                    polygons.extend(found);
                    *lowest_m = [*lowest_m, lowest].into_iter().flatten().reduce(f64::min);
                }
                Err(reason) => *into = Err(reason),
            },
            ("GeometryCollection", _) => {
                for geometry in self.geometries.unwrap_or_default() {
                    geometry.collect(into, lowest_m);
                }
            }
            (name @ ("Polygon" | "MultiPolygon"), depth) => {
                *into = Err(format!("its coordinates are nested {depth} deep, not as a {name}'s"));
            }
            (other, _) => *into = Err(format!("its geometry is of type {other:?}, not polygons")),
        }
    }
}

/// The polygons of nested positions, and their lowest height where positions have any.
fn polygons_of(coordinates: &Nested) -> Result<(Vec<Polygon>, Option<f64>), String> {
    let mut lowest = f64::INFINITY;
    let mut position = |numbers: &[f64]| match *numbers {
        [x, y, ref rest @ ..] => {
            lowest = rest.first().map_or(lowest, |z| lowest.min(*z));
            Ok(DVec2::new(x, y))
        }
        _ => Err(format!("a position has {} numbers", numbers.len())),
    };
    let mut polygons = Vec::new();
    for rings in coordinates.lists(2) {
        let mut polygon = Polygon::default();
        for ring in coordinates.lists_in(1, rings) {
            let positions = coordinates.lists_in(0, ring);
            let ring = positions.map(|range| position(coordinates.numbers(range)));
            polygon.rings.push(ring.collect::<Result<_, _>>()?);
        }
        polygons.push(polygon);
    }
    Ok((polygons, Some(lowest).filter(|z| z.is_finite())))
}

/// The outermost object. Gives the name of its CRS.
struct Document<'a, 'c> {
    collector: &'a mut Collector<'c>,
    allowance: Allowance,
    /// Why the collector wants no more; the parser then stops with an error of its own.
    stopped: &'a mut Option<IngestError>,
}

impl<'de> Visitor<'de> for Document<'_, '_> {
    type Value = Option<String>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a GeoJSON object")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut members: A) -> Result<Self::Value, A::Error> {
        let (mut kind, mut named, mut listed) = (None, None, false);
        let mut single = Feature { id: None, geometry: None, properties: None };
        while let Some(name) = members.next_key::<String>()? {
            match name.as_str() {
                "type" => kind = Some(members.next_value::<String>()?),
                "crs" => named = crs_name(&members.next_value::<Value>()?),
                "features" => {
                    let mut take = |feature| self.take(feature);
                    members.next_value_seed(EachElement::new(&mut take))?;
                    listed = true;
                }
                "id" => single.id = members.next_value()?,
                "geometry" => single.geometry = members.next_value()?,
                "properties" => single.properties = members.next_value()?,
                _ => {
                    self.allowance.lift();
                    members.next_value::<IgnoredAny>()?;
                }
            }
            self.allowance.renew();
        }
        match kind.as_deref() {
            Some("FeatureCollection") if listed => {}
            Some("Feature") => self.take(single).map_err(A::Error::custom)?,
            Some("FeatureCollection") => {
                return Err(A::Error::custom("a FeatureCollection without \"features\""));
            }
            other => {
                let other = other.unwrap_or_default();
                return Err(A::Error::custom(format!(
                    "its \"type\" is {other:?}, not \"FeatureCollection\" or \"Feature\""
                )));
            }
        }
        Ok(named)
    }
}

impl Document<'_, '_> {
    fn take(&mut self, feature: Feature) -> Result<(), String> {
        self.allowance.renew();
        self.collector.take(feature.found()).map_err(|error| {
            *self.stopped = Some(error);
            "stopped".to_owned()
        })
    }
}

/// The name in a member `crs`: `{"type": "name", "properties": {"name": …}}`, or the older
/// `{"type": "EPSG", "properties": {"code": …}}`; the member itself where it has another form.
fn crs_name(member: &Value) -> Option<String> {
    if member.is_null() {
        return None;
    }
    let property = |name| match member.get("properties")?.get(name)? {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let coded = || property("code").map(|code| format!("EPSG:{code}"));
    Some(property("name").or_else(coded).unwrap_or_else(|| member.to_string()))
}
