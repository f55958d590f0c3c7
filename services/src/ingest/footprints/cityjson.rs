//! CityJSON 1.0 to 2.0: the buildings of a city model, each with the outline it stands on and
//! its height.
//!
//! The file is read twice: first the vertices and what buildings hand down to their parts, both of
//! which may come after the parts themselves, then the objects, one at a time.

use std::collections::HashMap;
use std::fmt;
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde_json::{Map, Value};

use super::each::{EachElement, EachEntry};
use super::limited::{Allowance, Limited};
use super::nested::Nested;
use super::shell::{Face, footprint};
use super::source::{Collector, Found};
use crate::crs::Crs;
use crate::ingest::{BadInput, IngestError};

const REMEDY: &str = "export it again as CityJSON 1.0, 1.1 or 2.0";

/// Objects that stand on a footprint.
const BUILDINGS: [&str; 2] = ["Building", "BuildingPart"];

/// Hands the buildings of the file at `path` to `collector`. Where the model names a reference
/// system, it must agree with `crs`.
pub(super) fn read(
    path: &Path,
    crs: &Crs,
    collector: &mut Collector<'_>,
) -> Result<(), IngestError> {
    let fail = |problem: String| BadInput::error(path, "", problem, REMEDY);
    let parse = |visitor: &mut dyn FnMut(Limited, Allowance) -> serde_json::Result<()>| {
        let (source, allowance) = Limited::open(path).map_err(|error| fail(error.to_string()))?;
        visitor(source, allowance).map_err(|error| BadInput::json(path, &error, REMEDY))
    };
    let most_vertices = collector.job().memory / 4 / size_of::<DVec3>() as u64;
    let mut model = Model::default();
    parse(&mut |source, allowance| {
        let mut source = serde_json::Deserializer::from_reader(source);
        let preamble = Preamble { model: &mut model, allowance, most_vertices };
        serde::Deserializer::deserialize_map(&mut source, preamble)?;
        source.end()
    })?;
    model.settle().map_err(fail)?;
    if let Some(named) = &model.reference_system {
        collector.check_crs(named, crs)?;
    }
    let mut stopped = None;
    let outcome = parse(&mut |source, allowance| {
        let mut source = serde_json::Deserializer::from_reader(source);
        let objects = Objects { model: &model, collector, allowance, stopped: &mut stopped };
        serde::Deserializer::deserialize_map(&mut source, objects)
    });
    stopped.map_or(outcome, Err)
}

/// What objects refer to.
#[derive(Default)]
struct Model {
    kind: String,
    version: String,
    transform: Option<Transform>,
    reference_system: Option<String>,
    vertices: Vec<DVec3>,
    /// Attributes of buildings that have parts.
    handed_down: HashMap<String, Map<String, Value>>,
}

#[derive(Deserialize)]
struct Transform {
    scale: [f64; 3],
    translate: [f64; 3],
}

#[derive(Deserialize)]
struct Metadata {
    #[serde(rename = "referenceSystem")]
    reference_system: Option<Value>,
}

#[derive(Deserialize)]
struct Parent {
    attributes: Option<Map<String, Value>>,
    children: Option<Vec<IgnoredAny>>,
}

#[derive(Deserialize)]
struct CityObject {
    r#type: String,
    attributes: Option<Map<String, Value>>,
    #[serde(default)]
    geometry: Vec<Geometry>,
    #[serde(default)]
    parents: Vec<String>,
}

#[derive(Deserialize)]
struct Geometry {
    r#type: String,
    lod: Option<Value>,
    #[serde(default)]
    boundaries: Nested,
    semantics: Option<Semantics>,
}

#[derive(Deserialize)]
struct Semantics {
    #[serde(default)]
    surfaces: Vec<Surface>,
    /// For each face the index of its surface; NaN for none.
    #[serde(default)]
    values: Nested,
}

#[derive(Deserialize)]
struct Surface {
    r#type: String,
}

impl Model {
    /// Checks what the preamble said, and puts the vertices where they are in the world.
    fn settle(&mut self) -> Result<(), String> {
        if self.kind != "CityJSON" {
            return Err(format!("its \"type\" is {:?}, not \"CityJSON\"", self.kind));
        }
        if !["1.0", "1.1", "2.0"].iter().any(|version| self.version.starts_with(version)) {
            return Err(format!("its version is {:?}", self.version));
        }
        if let Some(Transform { scale, translate }) = &self.transform {
            let (scale, translate) = (DVec3::from_array(*scale), DVec3::from_array(*translate));
            self.vertices.iter_mut().for_each(|vertex| *vertex = *vertex * scale + translate);
        }
        Ok(())
    }

    fn faces(&self, geometry: &Geometry) -> Result<Vec<Face>, String> {
        let boundaries = &geometry.boundaries;
        if boundaries.uneven {
            return Err("its boundaries are nested unevenly".to_owned());
        }
        let mut faces = Vec::new();
        for rings in boundaries.lists(1) {
            let rings = boundaries.lists_in(0, rings).map(|ring| {
                let vertices = boundaries.numbers(ring).iter().map(|index| self.vertex(*index));
                vertices.collect::<Result<Vec<_>, _>>()
            });
            faces.push(Face { rings: rings.collect::<Result<_, _>>()?, is_ground: false });
        }
        let Some(semantics) = &geometry.semantics else { return Ok(faces) };
        let values: Vec<f64> = semantics
            .values
            .lists(0)
            .flat_map(|list| semantics.values.numbers(list))
            .copied()
            .collect();
        // A null instead of a list of values says nothing about that shell: then nothing fits.
        if values.len() == faces.len() && !semantics.values.uneven {
            for (face, value) in faces.iter_mut().zip(values) {
                let surface = index(value).and_then(|index| semantics.surfaces.get(index));
                face.is_ground = surface.is_some_and(|surface| surface.r#type == "GroundSurface");
            }
        }
        Ok(faces)
    }

    fn vertex(&self, number: f64) -> Result<DVec3, String> {
        index(number)
            .and_then(|index| self.vertices.get(index))
            .copied()
            .ok_or_else(|| format!("vertex {number} does not exist"))
    }

    /// What is known of a building; `None` where it is no building, or has no geometry.
    fn found(&self, id: String, object: CityObject) -> Option<Found> {
        if !BUILDINGS.contains(&object.r#type.as_str()) {
            return None;
        }
        let (level, geometry) = object
            .geometry
            .iter()
            .filter_map(|geometry| Some((level_of_detail(geometry)?, geometry)))
            .max_by(|(a, _), (b, _)| a.total_cmp(b))?;
        let mut attributes = Map::new();
        let parents = object.parents.iter().filter_map(|parent| self.handed_down.get(parent));
        parents.for_each(|handed_down| attributes.extend(handed_down.clone()));
        attributes.extend(object.attributes.unwrap_or_default());
        let (polygons, heights) = match self.faces(geometry) {
            Ok(faces) => {
                let heights = faces.iter().flat_map(|f| f.rings.iter().flatten().map(|p| p.z));
                (Ok(footprint(&faces)), heights.collect())
            }
            Err(reason) => (Err(reason), Vec::new()),
        };
        let lowest_m = heights.iter().copied().reduce(f64::min);
        let top_m = heights.iter().copied().reduce(f64::max);
        // The outline of LoD0 may lie at any height, and says nothing of the roof.
        let (lowest_m, top_m) = if level < 1.0 { (None, None) } else { (lowest_m, top_m) };
        Some(Found { id: Some(id), polygons, lowest_m, top_m, attributes })
    }
}

/// The level of detail of a geometry that is made of faces, up to LoD2.
fn level_of_detail(geometry: &Geometry) -> Option<f64> {
    const SURFACES: [&str; 5] =
        ["Solid", "MultiSurface", "CompositeSurface", "MultiSolid", "CompositeSolid"];
    let level = match geometry.lod.as_ref()? {
        Value::String(text) => text.parse().ok()?,
        Value::Number(number) => number.as_f64()?,
        _ => return None,
    };
    let usable = SURFACES.contains(&geometry.r#type.as_str()) && (0.0..3.0).contains(&level);
    usable.then_some(level)
}

/// A number as an index.
fn index(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number < 1e15).then_some(number as usize)
}

/// The first reading.
struct Preamble<'a> {
    model: &'a mut Model,
    allowance: Allowance,
    most_vertices: u64,
}

impl<'de> Visitor<'de> for Preamble<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a CityJSON object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        let Self { model, allowance, most_vertices } = self;
        while let Some(name) = members.next_key::<String>()? {
            match name.as_str() {
                "type" => model.kind = members.next_value()?,
                "version" => model.version = members.next_value()?,
                "transform" => model.transform = Some(members.next_value()?),
                "metadata" => {
                    let named = members.next_value::<Metadata>()?.reference_system;
                    model.reference_system =
                        named.and_then(|named| named.as_str().map(ToOwned::to_owned));
                }
                "vertices" => {
                    members.next_value_seed(EachElement::new(|vertex: [f64; 3]| {
                        allowance.renew();
                        model.vertices.push(DVec3::from_array(vertex));
                        if model.vertices.len() as u64 <= most_vertices {
                            Ok(())
                        } else {
                            Err(format!("more than {most_vertices} vertices do not fit into a quarter of --memory"))
                        }
                    }))?;
                }
                "CityObjects" => {
                    members.next_value_seed(EachEntry::new(|id, parent: Parent| {
                        allowance.renew();
                        let has_parts = parent.children.is_some_and(|parts| !parts.is_empty());
                        if let Some(attributes) = parent.attributes.filter(|_| has_parts) {
                            model.handed_down.insert(id, attributes);
                        }
                        Ok(())
                    }))?;
                }
                _ => {
                    allowance.lift();
                    members.next_value::<IgnoredAny>()?;
                }
            }
            allowance.renew();
        }
        Ok(())
    }
}

/// The second reading.
struct Objects<'a, 'c> {
    model: &'a Model,
    collector: &'a mut Collector<'c>,
    allowance: Allowance,
    /// Why the collector wants no more; the parser then stops with an error of its own.
    stopped: &'a mut Option<IngestError>,
}

impl<'de> Visitor<'de> for Objects<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a CityJSON object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        let Self { model, collector, allowance, stopped } = self;
        while let Some(name) = members.next_key::<String>()? {
            if name == "CityObjects" {
                members.next_value_seed(EachEntry::new(|id, object: CityObject| {
                    allowance.renew();
                    let Some(found) = model.found(id, object) else { return Ok(()) };
                    collector.take(found).map_err(|error| {
                        *stopped = Some(error);
                        "stopped".to_owned()
                    })
                }))?;
            } else {
                allowance.lift();
                members.next_value::<IgnoredAny>()?;
            }
            allowance.renew();
        }
        Ok(())
    }
}
