//! Building footprints.

use flaneur_scene::{Footprint, Polygon};
use glam::DVec2;

use crate::error::{FieldError, finite, not_negative};
use crate::v1;

impl From<Footprint> for v1::Footprint {
    fn from(footprint: Footprint) -> Self {
        Self {
            id: footprint.id,
            polygons: footprint.polygons.iter().map(v1::Polygon::from).collect(),
            base_m: footprint.base_m,
            height_m: footprint.height_m,
            uncertainty_m: footprint.uncertainty_m,
            attributes_json: footprint.attributes,
        }
    }
}

impl From<&Polygon> for v1::Polygon {
    fn from(polygon: &Polygon) -> Self {
        let ring = |ring: &Vec<DVec2>| v1::Ring {
            coordinates: ring.iter().flat_map(DVec2::to_array).collect(),
        };
        Self { rings: polygon.rings.iter().map(ring).collect() }
    }
}

impl TryFrom<v1::Footprint> for Footprint {
    type Error = FieldError;

    /// The attributes are passed on as they are; who reads them parses them.
    fn try_from(message: v1::Footprint) -> Result<Self, FieldError> {
        let polygon = |(index, polygon): (usize, &v1::Polygon)| {
            Polygon::try_from(polygon).map_err(|e| e.within(format_args!("polygons[{index}]")))
        };
        Ok(Self {
            polygons: message
                .polygons
                .iter()
                .enumerate()
                .map(polygon)
                .collect::<Result<_, FieldError>>()?,
            base_m: finite("base_m", message.base_m)?,
            height_m: not_negative("height_m", message.height_m)?,
            uncertainty_m: not_negative("uncertainty_m", message.uncertainty_m)?,
            id: message.id,
            attributes: message.attributes_json,
        })
    }
}

impl TryFrom<&v1::Polygon> for Polygon {
    type Error = FieldError;

    fn try_from(message: &v1::Polygon) -> Result<Self, FieldError> {
        if message.rings.is_empty() {
            return Err(FieldError::new("rings", "is empty, must hold the outer ring"));
        }
        let rings = message.rings.iter().enumerate().map(|(index, ring)| {
            vertices(ring).map_err(|e| e.within(format_args!("rings[{index}]")))
        });
        Ok(Self { rings: rings.collect::<Result<_, FieldError>>()? })
    }
}

fn vertices(ring: &v1::Ring) -> Result<Vec<DVec2>, FieldError> {
    let (pairs, rest) = ring.coordinates.as_chunks::<2>();
    if !rest.is_empty() || pairs.len() < 3 {
        return Err(FieldError::new(
            "coordinates",
            format!(
                "holds {} numbers, must hold x, y of 3 vertices or more",
                ring.coordinates.len()
            ),
        ));
    }
    if let Some(index) = ring.coordinates.iter().position(|c| !c.is_finite()) {
        return Err(FieldError::new(format!("coordinates[{index}]"), "is not finite"));
    }
    Ok(pairs.iter().copied().map(DVec2::from_array).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square() -> Footprint {
        Footprint {
            id: "b/1".into(),
            polygons: vec![Polygon {
                rings: vec![vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]],
            }],
            base_m: -2.5,
            height_m: 0.0,
            uncertainty_m: 0.5,
            attributes: r#"{"usage":"mixte"}"#.into(),
        }
    }

    #[test]
    fn faults_are_named_down_to_the_number() {
        let field = |change: fn(&mut v1::Footprint)| {
            let mut message = v1::Footprint::from(square());
            change(&mut message);
            Footprint::try_from(message).expect_err("bad footprint").field
        };
        assert_eq!(field(|m| m.height_m = -1.0), "height_m");
        assert_eq!(field(|m| m.base_m = f64::NAN), "base_m");
        assert_eq!(field(|m| m.polygons[0].rings.clear()), "polygons[0].rings");
        let ring = "polygons[0].rings[0].coordinates";
        assert_eq!(field(|m| m.polygons[0].rings[0].coordinates.truncate(7)), ring);
        assert_eq!(field(|m| m.polygons[0].rings[0].coordinates.truncate(4)), ring);
        assert_eq!(
            field(|m| m.polygons[0].rings[0].coordinates[5] = f64::INFINITY),
            format!("{ring}[5]")
        );
    }

    proptest! {
        #[test]
        fn footprints_come_back(
            rings in prop::collection::vec(
                prop::collection::vec(prop::array::uniform2(-1e7..1e7f64), 3..9), 1..4),
            base_m in -500.0..9000.0f64, height_m in 0.0..500.0f64,
        ) {
            let rings: Vec<Vec<DVec2>> = rings.into_iter()
                .map(|ring| ring.into_iter().map(DVec2::from_array).collect())
                .collect();
            let footprint = Footprint {
                polygons: vec![Polygon { rings }, square().polygons.remove(0)],
                base_m, height_m, ..square()
            };
            let message = v1::Footprint::from(footprint.clone());
            prop_assert_eq!(Footprint::try_from(message), Ok(footprint));
        }
    }
}
