//! Scenes behind a URL: a folder, `memory://`, `s3://` and whatever else `object_store` opens.

mod manifest;

pub use manifest::{
    FileEntry, FootprintsLayer, GroundLayer, Manifest, PanoramasLayer, PointsLayer,
};
