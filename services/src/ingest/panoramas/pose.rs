//! From published angles and heights to a pose in the world frame.

use std::path::Path;

use flaneur_scene::{ImageId, world_from_rig};
use glam::{DMat3, DVec2, DVec3};

use crate::crs::CrsError;
use crate::ingest::street::North;
use crate::ingest::{BadInput, IngestError};

/// Settings of an entry that turn published poses into poses of the world frame.
pub(super) struct PoseFrame<'a> {
    pub(super) north: North,
    /// [`crate::crs::Crs::meridian_convergence`]: `heading_grid = heading_true − convergence`.
    pub(super) convergence: &'a dyn Fn(DVec2) -> Result<f64, CrsError>,
    pub(super) height_offset_m: f64,
    pub(super) boresight_deg: [f64; 3],
}

/// A pose as published, degrees and metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct PublishedPose {
    pub(super) position: DVec3,
    pub(super) heading_deg: f64,
    pub(super) pitch_deg: f64,
    pub(super) roll_deg: f64,
}

/// Farther from the origin than this no projected CRS reaches: metres.
const FARTHEST: f64 = 1e8;

impl PoseFrame<'_> {
    /// Position and `R_world_from_rig = Rz(−h) Rx(pitch) Ry(roll) · Rx(b₀) Ry(b₁) Rz(b₂)`,
    /// with `h` from grid north and the height offset added. Errors name `file` and `place`.
    pub(super) fn resolve(
        &self,
        pose: &PublishedPose,
        file: &Path,
        place: &str,
    ) -> Result<(DVec3, DMat3), IngestError> {
        let refuse = |name: &str, value: f64, remedy: &str| {
            BadInput::error(file, place, format!("{name} is {value:?}"), remedy)
        };
        for (name, value) in ["x", "y", "z"].into_iter().zip(pose.position.to_array()) {
            // Written so that NaN is refused.
            if !(value.abs() <= FARTHEST) {
                return Err(refuse(name, value, "give metres in the CRS of the street"));
            }
        }
        for (name, value, limit, remedy) in [
            ("the heading", pose.heading_deg, 720.0, "give degrees clockwise from north"),
            ("the pitch", pose.pitch_deg, 90.0, "give degrees, positive looking up, within ±90"),
            ("the roll", pose.roll_deg, 360.0, "give degrees, positive lowering the right side"),
        ] {
            if !(value.abs() <= limit) {
                return Err(refuse(name, value, remedy));
            }
        }
        let convergence = match self.north {
            North::Grid => 0.0,
            North::True => (self.convergence)(pose.position.truncate()).map_err(|e| {
                BadInput::error(
                    file,
                    place,
                    format!("its heading cannot be turned to grid north: {e}"),
                    "check the position and the CRS, or give headings from grid north",
                )
            })?,
        };
        let rotation = world_from_rig(
            pose.heading_deg.to_radians() - convergence,
            pose.pitch_deg.to_radians(),
            pose.roll_deg.to_radians(),
        );
        let [x, y, z] = self.boresight_deg.map(f64::to_radians);
        let boresight =
            DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
        let position = pose.position + DVec3::Z * self.height_offset_m;
        Ok((position, rotation * boresight))
    }
}

/// `name` if it can be a path segment of the store.
pub(super) fn checked_name(name: String, file: &Path, place: &str) -> Result<String, IngestError> {
    match ImageId::check_part(&name) {
        Ok(()) => Ok(name),
        Err(e) => Err(BadInput::error(file, place, e.to_string(), "rename it")),
    }
}

/// `text` if it reads as RFC 3339, such as `2014-06-16T12:31:34.841Z`.
pub(super) fn checked_time(text: Option<String>) -> Option<String> {
    text.filter(|text| is_rfc_3339(text))
}

fn is_rfc_3339(text: &str) -> bool {
    let follows = |text: &str, pattern: &str| {
        text.len() == pattern.len()
            && text.bytes().zip(pattern.bytes()).all(|(byte, pattern)| match pattern {
                b'd' => byte.is_ascii_digit(),
                b'T' => matches!(byte, b'T' | b't' | b' '),
                b's' => matches!(byte, b'+' | b'-'),
                separator => byte == separator,
            })
    };
    let Some((date_time, rest)) = text.split_at_checked(19) else { return false };
    let zone = match rest.strip_prefix('.') {
        Some(fraction) => fraction.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => rest,
    };
    text.len() <= 40
        && follows(date_time, "dddd-dd-ddTdd:dd:dd")
        && (matches!(zone, "Z" | "z") || follows(zone, "sdd:dd"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(north: North) -> PoseFrame<'static> {
        PoseFrame {
            north,
            convergence: &|_| Ok(-0.5_f64.to_radians()),
            height_offset_m: 2.0,
            boresight_deg: [0.0; 3],
        }
    }

    const POSE: PublishedPose = PublishedPose {
        position: DVec3::new(10.0, 20.0, 30.0),
        heading_deg: 89.5,
        pitch_deg: 0.0,
        roll_deg: 0.0,
    };

    #[test]
    fn true_north_is_turned_to_grid_north() {
        let (position, rotation) =
            frame(North::True).resolve(&POSE, Path::new("p"), "1").expect("valid");
        assert_eq!(position, DVec3::new(10.0, 20.0, 32.0));
        // 89.5° from true north, grid north half a degree to its west: due east.
        assert!((rotation * DVec3::Y).distance(DVec3::X) < 1e-12, "{rotation}");
        let (_, grid) = frame(North::Grid).resolve(&POSE, Path::new("p"), "1").expect("valid");
        assert!((grid * DVec3::Y).y > 0.008, "{grid}");
    }

    #[test]
    fn boresight_turns_about_the_rigs_own_axes() {
        let tilted = PoseFrame { boresight_deg: [10.0, 0.0, 0.0], ..frame(North::True) };
        let (_, rotation) = tilted.resolve(&POSE, Path::new("p"), "1").expect("valid");
        let forward = rotation * DVec3::Y;
        assert!((forward.z - 10f64.to_radians().sin()).abs() < 1e-12, "{forward}");
        assert!(forward.y.abs() < 1e-12, "{forward}");
    }

    #[test]
    fn poisoned_poses_are_named() {
        let message = |pose: PublishedPose| {
            let result = frame(North::Grid).resolve(&pose, Path::new("poses.json"), "panorama 4");
            result.expect_err("refused").to_string()
        };
        let text = message(PublishedPose { position: DVec3::new(0.0, f64::NAN, 0.0), ..POSE });
        assert!(text.starts_with("poses.json, panorama 4: y is NaN; "), "{text}");
        assert!(message(PublishedPose { pitch_deg: 91.0, ..POSE }).contains("pitch is 91"));
        assert!(message(PublishedPose { heading_deg: f64::INFINITY, ..POSE }).contains("heading"));
    }

    #[test]
    fn times_are_kept_only_where_they_are_rfc_3339() {
        for good in
            ["2014-06-16T12:31:34.841Z", "2014-06-16T12:31:34+02:00", "2014-06-16 12:31:34Z"]
        {
            assert_eq!(checked_time(Some(good.into())).as_deref(), Some(good));
        }
        for bad in
            ["", "yesterday", "2014-06-16", "2014-06-16T12:31:34", "2014-06-16T12:31:34é+00:00"]
        {
            assert_eq!(checked_time(Some(bad.into())), None, "{bad}");
        }
    }
}
