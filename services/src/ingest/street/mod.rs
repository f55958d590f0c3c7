//! `street.toml`: what a survey's files are, and how to read them.
//!
//! ```toml
//! [scene]
//! name = "paris"
//! crs = "EPSG:2154"             # or "local", with geographic_origin = [lat, lon, height]
//!
//! [ground]
//! format = "points-json"        # or "constant" + height_m, or "points" (+ classes)
//! path = "dtm.json"
//!
//! [[footprints]]
//! path = "buildings.geojson"
//! height_property = "height"    # or height = "points", or height = 12.0
//!
//! [[panoramas]]
//! format = "itowns"             # or "colmap", or "equirectangular"
//! poses = "poses.json"
//! calibration = "calibration.json"
//! images = "images/{camera}_{panorama:07}.jpg"
//!
//! [[points]]
//! path = "tiles/*.laz"
//! ```
//!
//! Relative paths start at the file's folder.

pub(in crate::ingest) mod glob;
mod parse;
mod pattern;
mod root;
mod section;
mod spec;
#[cfg(test)]
mod tests;

pub use pattern::ImagePattern;
pub use root::Root;
pub use spec::{
    ColmapSpec, EquirectangularSpec, FootprintsFormat, FootprintsSpec, GroundSpec, HeightSource,
    ItownsSpec, MaskColour, North, PanoramasSpec, PointsSpec, SceneSpec, Street,
};
