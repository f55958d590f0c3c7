//! The `street.toml` that tells ingest what is there.

use crate::SampleOptions;
use crate::cadastre::UNCERTAINTY_M;
use crate::camera::{BORESIGHT_DEG, HEIGHT_OFFSET_M};

/// The description of a sample of this kind.
pub(crate) fn description(options: &SampleOptions) -> String {
    let mut text = format!(
        r#"# A synthetic street, made by `flaneur sample`. Paths are relative to this file.
[scene]
name = "sample"
crs = "EPSG:2154"

[ground]
format = "points-json"
path = "ground.json"

[[footprints]]
path = "footprints.geojson"
height_property = "height"
uncertainty_m = {UNCERTAINTY_M:?}
"#
    );
    if options.exposures > 0 {
        text += &format!(
            r#"
[[panoramas]]
format = "itowns"
poses = "poses.json"
calibration = "calibration.json"
images = "images/{{camera}}_{{panorama:07}}.jpg"
masks_exclude = "white"
heading = "grid-north"
height_offset_m = {HEIGHT_OFFSET_M:?}
boresight_deg = [{BORESIGHT_DEG:?}, 0.0, 0.0]
"#
        );
    }
    if options.spheres > 0 {
        text += r#"
[[panoramas]]
format = "equirectangular"
list = "equirectangular.csv"
heading = "grid-north"
"#;
    }
    if options.points > 0 {
        text += r#"
[[points]]
path = "lidar_*.laz"
"#;
    }
    text
}
