//! The part of the plan that a request asks for.

use flaneur_scene::{Bounds2, Region};
use glam::DVec2;

use crate::error::{FieldError, not_negative};
use crate::v1;

/// Gives a request its region, and takes it out again, checked.
macro_rules! regional_request {
    ($($request:ident),*) => {$(
        impl v1::$request {
            /// The request for what lies in `region` of a scene, all else as by default.
            #[allow(clippy::needless_update, reason = "some requests have further fields")]
            pub fn new(scene: impl Into<String>, region: Region) -> Self {
                let (bbox, centre, radius_m) = fields(region);
                Self { scene: scene.into(), bbox, centre, radius_m, ..Self::default() }
            }

            /// The region asked for: everything where neither bbox nor centre is given.
            ///
            /// An error names the field where a number is not finite, the box is upside
            /// down, the radius negative or without a centre, or both shapes are given.
            pub fn region(&self) -> Result<Region, FieldError> {
                region(self.bbox, self.centre, self.radius_m)
            }
        }
    )*};
}

regional_request!(StreamFootprintsRequest, StreamGroundRequest, StreamPanoramasRequest);

fn fields(region: Region) -> (Option<v1::BoundingBox>, Option<v1::Point2>, f64) {
    match region {
        Region::All => (None, None, 0.0),
        Region::Box(bounds) => (Some(bounds.into()), None, 0.0),
        Region::Disc { centre, radius_m } => (None, Some(centre.into()), radius_m),
    }
}

fn region(
    bbox: Option<v1::BoundingBox>,
    centre: Option<v1::Point2>,
    radius_m: f64,
) -> Result<Region, FieldError> {
    let radius_m = not_negative("radius_m", radius_m)?;
    match (bbox, centre) {
        (Some(_), Some(_)) => {
            Err(FieldError::new("centre", "is given together with bbox: only one may be"))
        }
        (_, None) if radius_m > 0.0 => {
            Err(FieldError::new("centre", "is absent, but radius_m is given"))
        }
        (None, None) => Ok(Region::All),
        (Some(bbox), None) => {
            Ok(Region::Box(Bounds2::try_from(bbox).map_err(|e| e.within("bbox"))?))
        }
        (None, Some(centre)) => Ok(Region::Disc {
            centre: DVec2::try_from(centre).map_err(|e| e.within("centre"))?,
            radius_m,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_come_back_and_contradictions_are_named() {
        let bounds = Bounds2 { min: DVec2::new(1.0, 2.0), max: DVec2::new(3.0, 4.0) };
        let disc = Region::Disc { centre: DVec2::new(651_000.25, 6.86e6), radius_m: 0.0 };
        for wanted in [Region::All, Region::Box(bounds), disc] {
            let request = v1::StreamPanoramasRequest::new("street", wanted);
            assert_eq!(request.region(), Ok(wanted));
        }
        let bbox = Some(v1::BoundingBox::from(bounds));
        let centre = Some(v1::Point2 { x: 0.0, y: f64::NAN });
        let field = |bbox, centre, radius| region(bbox, centre, radius).expect_err("bad").field;
        assert_eq!(field(bbox, centre, 0.0), "centre");
        assert_eq!(field(None, None, 1.0), "centre");
        assert_eq!(field(None, centre, 1.0), "centre.y");
        assert_eq!(field(None, None, -1.0), "radius_m");
        assert_eq!(field(None, None, f64::NAN), "radius_m");
        let upside_down = v1::BoundingBox { min_x: 5.0, min_y: 0.0, max_x: 1.0, max_y: 1.0 };
        assert_eq!(field(Some(upside_down), None, 0.0), "bbox.min_x");
    }
}
