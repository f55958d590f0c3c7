//! The polygons of a feature's geometry.

use flaneur_scene::Polygon;
use flatgeobuf::{Geometry, GeometryType};
use glam::DVec2;

/// The polygons of a geometry, with the lowest of their heights where they have any.
#[derive(Debug, Default, PartialEq)]
pub struct Polygons {
    /// Rings without the repeated last vertex.
    pub polygons: Vec<Polygon>,
    /// Lowest z, metres.
    pub lowest_m: Option<f64>,
}

impl Polygons {
    /// The polygons of `geometry`. `kind` is the type that the file's header states.
    ///
    /// # Errors
    ///
    /// Says which type is not made of polygons, or what is wrong with a ring.
    pub fn of(geometry: &Geometry<'_>, kind: GeometryType) -> Result<Self, String> {
        let mut found = Self::default();
        found.collect(geometry, kind)?;
        Ok(found)
    }

    fn collect(&mut self, geometry: &Geometry<'_>, kind: GeometryType) -> Result<(), String> {
        let kind = if kind == GeometryType::Unknown { geometry.type_() } else { kind };
        let parts = geometry.parts().into_iter().flatten();
        match kind {
            GeometryType::Polygon | GeometryType::Triangle => {
                self.polygons.push(polygon(geometry)?);
                let lowest = geometry.z().into_iter().flatten().fold(f64::INFINITY, f64::min);
                if lowest.is_finite() {
                    self.lowest_m = Some(self.lowest_m.map_or(lowest, |m| m.min(lowest)));
                }
            }
            GeometryType::MultiPolygon => {
                for part in parts {
                    self.collect(&part, GeometryType::Polygon)?;
                }
            }
            GeometryType::GeometryCollection => {
                for part in parts {
                    self.collect(&part, GeometryType::Unknown)?;
                }
            }
            other => {
                let name = other.variant_name().unwrap_or("unknown");
                return Err(format!("its geometry is of type {name}, not polygons"));
            }
        }
        Ok(())
    }
}

fn polygon(geometry: &Geometry<'_>) -> Result<Polygon, String> {
    let xy: Vec<f64> = geometry.xy().into_iter().flatten().collect();
    let (points, _) = xy.as_chunks::<2>();
    let ends: Vec<usize> = match geometry.ends() {
        Some(ends) if !ends.is_empty() => ends.iter().map(|end| end as usize).collect(),
        _ => vec![points.len()],
    };
    let mut rings = Vec::with_capacity(ends.len());
    let mut start = 0;
    for end in ends {
        let ring = points
            .get(start..end)
            .ok_or_else(|| format!("a ring of vertices {start} to {end} of {}", points.len()))?;
        let ring = match ring {
            [first, between @ .., last] if first == last && !between.is_empty() => {
                &ring[..ring.len() - 1]
            }
            _ => ring,
        };
        rings.push(ring.iter().copied().map(DVec2::from_array).collect());
        start = end;
    }
    Ok(Polygon { rings })
}
