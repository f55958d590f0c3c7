//! Points, boxes and rotations.

use flaneur_scene::{Bounds2, Bounds3};
use glam::{DMat3, DVec2, DVec3};

use crate::error::{FieldError, finite, finite_array, required};
use crate::v1;

/// How far `R Rᵀ` of a received rotation may be from the identity, per entry. Doubles that
/// were made orthonormal are within 1e-15; poses read from text with six digits within 1e-6.
const ORTHONORMAL_TOLERANCE: f64 = 1e-5;

impl From<DVec2> for v1::Point2 {
    fn from(p: DVec2) -> Self {
        Self { x: p.x, y: p.y }
    }
}

impl TryFrom<v1::Point2> for DVec2 {
    type Error = FieldError;

    fn try_from(p: v1::Point2) -> Result<Self, FieldError> {
        Ok(Self::new(finite("x", p.x)?, finite("y", p.y)?))
    }
}

impl From<DVec3> for v1::Point3 {
    fn from(p: DVec3) -> Self {
        Self { x: p.x, y: p.y, z: p.z }
    }
}

impl TryFrom<v1::Point3> for DVec3 {
    type Error = FieldError;

    fn try_from(p: v1::Point3) -> Result<Self, FieldError> {
        Ok(Self::new(finite("x", p.x)?, finite("y", p.y)?, finite("z", p.z)?))
    }
}

impl From<Bounds2> for v1::BoundingBox {
    fn from(b: Bounds2) -> Self {
        Self { min_x: b.min.x, min_y: b.min.y, max_x: b.max.x, max_y: b.max.y }
    }
}

impl TryFrom<v1::BoundingBox> for Bounds2 {
    type Error = FieldError;

    fn try_from(b: v1::BoundingBox) -> Result<Self, FieldError> {
        let min = DVec2::new(finite("min_x", b.min_x)?, finite("min_y", b.min_y)?);
        let max = DVec2::new(finite("max_x", b.max_x)?, finite("max_y", b.max_y)?);
        for (axis, low, high) in [("x", min.x, max.x), ("y", min.y, max.y)] {
            if low > high {
                return Err(FieldError::new(
                    format!("min_{axis}"),
                    format!("is {low:?}, must be at most max_{axis}, which is {high:?}"),
                ));
            }
        }
        Ok(Self { min, max })
    }
}

impl From<Bounds3> for v1::Bounds3 {
    fn from(b: Bounds3) -> Self {
        Self { min: Some(b.min.into()), max: Some(b.max.into()) }
    }
}

impl TryFrom<v1::Bounds3> for Bounds3 {
    type Error = FieldError;

    fn try_from(b: v1::Bounds3) -> Result<Self, FieldError> {
        let bounds = Self { min: point3("min", b.min)?, max: point3("max", b.max)? };
        if bounds.is_empty() {
            return Err(FieldError::new(
                "min",
                format!(
                    "is {:?}, must be at most max, which is {:?}",
                    bounds.min.to_array(),
                    bounds.max.to_array()
                ),
            ));
        }
        Ok(bounds)
    }
}

impl From<DMat3> for v1::Rotation {
    fn from(m: DMat3) -> Self {
        Self { rows: m.transpose().to_cols_array().to_vec() }
    }
}

impl TryFrom<v1::Rotation> for DMat3 {
    type Error = FieldError;

    fn try_from(r: v1::Rotation) -> Result<Self, FieldError> {
        let m = Self::from_cols_array(&finite_array::<9>("rows", &r.rows)?).transpose();
        if !(m * m.transpose()).abs_diff_eq(Self::IDENTITY, ORTHONORMAL_TOLERANCE) {
            return Err(FieldError::new("rows", "is not orthonormal, so no rotation"));
        }
        if m.determinant() < 0.0 {
            return Err(FieldError::new("rows", "mirrors: its determinant is -1, must be 1"));
        }
        Ok(m)
    }
}

/// A point that must be present in `field`.
pub(crate) fn point3(field: &str, point: Option<v1::Point3>) -> Result<DVec3, FieldError> {
    DVec3::try_from(required(field, point)?).map_err(|e| e.within(field))
}

/// A point of the plan that must be present in `field`.
pub(crate) fn point2(field: &str, point: Option<v1::Point2>) -> Result<DVec2, FieldError> {
    DVec2::try_from(required(field, point)?).map_err(|e| e.within(field))
}

/// A rotation that must be present in `field`.
pub(crate) fn rotation(field: &str, rotation: Option<v1::Rotation>) -> Result<DMat3, FieldError> {
    DMat3::try_from(required(field, rotation)?).map_err(|e| e.within(field))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_rotation_is_written_row_by_row_and_a_mirror_is_refused() {
        // v' = R v with R = Rz(90°): x becomes y, so the first row is (0, -1, 0).
        let m = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        let message = v1::Rotation::from(m);
        assert_eq!(message.rows, [0., -1., 0., 1., 0., 0., 0., 0., 1.]);
        assert_eq!(DMat3::try_from(message), Ok(m));
        for bad in [m * 1.001, -m, DMat3::ZERO, m * f64::NAN] {
            DMat3::try_from(v1::Rotation::from(bad)).expect_err("no rotation");
        }
        let short = v1::Rotation { rows: vec![1.0; 8] };
        assert_eq!(
            DMat3::try_from(short).expect_err("eight numbers").to_string(),
            "rows: holds 8 numbers, must hold 9"
        );
    }

    #[test]
    fn a_box_upside_down_or_of_nan_names_its_field() {
        let message = |min_x, max_y| v1::BoundingBox { min_x, min_y: 0.0, max_x: 1.0, max_y };
        let field = |m: v1::BoundingBox| Bounds2::try_from(m).expect_err("bad box").field;
        assert_eq!(field(message(2.0, 1.0)), "min_x");
        assert_eq!(field(message(f64::NAN, 1.0)), "min_x");
        assert_eq!(field(message(0.0, -1.0)), "min_y");
        assert_eq!(field(message(0.0, f64::INFINITY)), "max_y");
        assert!(Bounds2::try_from(message(1.0, 0.0)).is_ok(), "a point is a box");
    }

    proptest! {
        #[test]
        fn numbers_come_back_bit_for_bit(x in any::<f64>(), y in any::<f64>(), z in any::<f64>()) {
            let p = DVec3::new(x, y, z);
            match DVec3::try_from(v1::Point3::from(p)) {
                Ok(back) => prop_assert_eq!(back.to_array().map(f64::to_bits), p.to_array().map(f64::to_bits)),
                Err(_) => prop_assert!(!p.is_finite()),
            }
        }

        #[test]
        fn rotations_come_back_exactly(axis in prop::array::uniform3(-1.0..1.0f64), angle in -7.0..7.0f64) {
            let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::X);
            let m = DMat3::from_axis_angle(axis, angle);
            prop_assert_eq!(DMat3::try_from(v1::Rotation::from(m)), Ok(m));
        }
    }
}
