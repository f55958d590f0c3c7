//! Views.

use flaneur_scene::View;
use glam::UVec2;

use crate::error::{FieldError, finite, required};
use crate::geometry::point3;
use crate::v1;

/// Farthest that an eye may be from the CRS's own origin, metres: beyond lies no projected CRS.
const FARTHEST_M: f64 = 1e9;

impl TryFrom<&v1::View> for View {
    type Error = FieldError;

    fn try_from(message: &v1::View) -> Result<Self, FieldError> {
        let eye = point3("eye", message.eye)?;
        if eye.abs().max_element() > FARTHEST_M {
            return Err(FieldError::new(
                "eye",
                format!("is {:?}, must be within {FARTHEST_M} m", eye.to_array()),
            ));
        }
        // Turns are taken off first: the sine of a huge angle is noise.
        let heading = finite("heading_deg", message.heading_deg)?.rem_euclid(360.0).to_radians();
        let pitch = within("pitch_deg", message.pitch_deg, -90.0, 90.0)?.to_radians();
        for (field, pixels) in [("width", message.width), ("height", message.height)] {
            if pixels == 0 {
                return Err(FieldError::new(field, "is 0, must be at least 1"));
            }
        }
        let size = UVec2::new(message.width, message.height);
        Ok(match required("extent", message.extent)? {
            v1::view::Extent::FovDeg(fov_deg) => {
                let fov = within("fov_deg", fov_deg, 1.0, 170.0)?.to_radians();
                Self::look(eye, heading, pitch, fov, size)
            }
            v1::view::Extent::HeightM(height_m) => {
                let height_m = within("height_m", height_m, 0.01, 1e5)?;
                Self::orthographic(eye, heading, pitch, height_m, size)
            }
        })
    }
}

/// A number from `least` to `most`.
fn within(field: &str, value: f64, least: f64, most: f64) -> Result<f64, FieldError> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(FieldError::new(field, format!("is {value:?}, must be {least} to {most}")))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn message() -> v1::View {
        v1::View {
            eye: Some(v1::Point3 { x: 651_000.25, y: 6_861_000.5, z: 40.0 }),
            heading_deg: 450.0,
            pitch_deg: -10.0,
            extent: Some(v1::view::Extent::FovDeg(60.0)),
            width: 1024,
            height: 512,
            mode: 0,
            may_shrink: false,
        }
    }

    #[test]
    fn a_view_is_what_it_says() {
        let view = View::try_from(&message()).expect("good");
        let eye = DVec3::new(651_000.25, 6_861_000.5, 40.0);
        let same = View::look(
            eye,
            90f64.to_radians(),
            -10f64.to_radians(),
            60f64.to_radians(),
            UVec2::new(1024, 512),
        );
        assert_eq!(view, same);
        let extent = Some(v1::view::Extent::HeightM(50.0));
        let plan = View::try_from(&v1::View { extent, ..message() }).expect("good");
        assert!((plan.pixels_a_metre(7.0) - 512.0 / 50.0).abs() < 1e-12);
    }

    #[test]
    fn a_fault_names_its_field() {
        let fault = |change: fn(&mut v1::View)| {
            let mut bad = message();
            change(&mut bad);
            View::try_from(&bad).expect_err("bad").field
        };
        assert_eq!(fault(|v| v.eye = None), "eye");
        assert_eq!(fault(|v| v.eye = Some(v1::Point3 { x: f64::NAN, y: 0.0, z: 0.0 })), "eye.x");
        assert_eq!(fault(|v| v.eye = Some(v1::Point3 { x: 1e12, y: 0.0, z: 0.0 })), "eye");
        assert_eq!(fault(|v| v.heading_deg = f64::INFINITY), "heading_deg");
        assert_eq!(fault(|v| v.pitch_deg = 90.5), "pitch_deg");
        assert_eq!(fault(|v| v.extent = None), "extent");
        assert_eq!(fault(|v| v.extent = Some(v1::view::Extent::FovDeg(f64::NAN))), "fov_deg");
        assert_eq!(fault(|v| v.extent = Some(v1::view::Extent::HeightM(0.0))), "height_m");
        assert_eq!(fault(|v| v.width = 0), "width");
        assert_eq!(fault(|v| v.height = 0), "height");
    }

    #[test]
    fn a_fault_is_short_however_large_the_number() {
        let fault = |change: fn(&mut v1::View)| {
            let mut bad = message();
            change(&mut bad);
            View::try_from(&bad).expect_err("bad").to_string()
        };
        assert_eq!(
            fault(|v| v.eye = Some(v1::Point3 { x: 1e300, y: -0.5, z: 40.0 })),
            "eye: is [1e300, -0.5, 40.0], must be within 1000000000 m"
        );
        assert_eq!(fault(|v| v.pitch_deg = -1e300), "pitch_deg: is -1e300, must be -90 to 90");
        assert_eq!(fault(|v| v.pitch_deg = 90.5), "pitch_deg: is 90.5, must be -90 to 90");
        let of_extent = |extent| {
            let bad = v1::View { extent: Some(extent), ..message() };
            View::try_from(&bad).expect_err("bad").to_string()
        };
        assert_eq!(
            of_extent(v1::view::Extent::FovDeg(1e-300)),
            "fov_deg: is 1e-300, must be 1 to 170"
        );
        assert_eq!(
            of_extent(v1::view::Extent::HeightM(f64::MAX)),
            "height_m: is 1.7976931348623157e308, must be 0.01 to 100000"
        );
    }
}
