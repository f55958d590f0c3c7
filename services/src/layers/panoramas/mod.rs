//! `panoramas.{version}.fgb`: rigs, cameras and poses, one Point Z feature a panorama.
//!
//! | column | type | holds |
//! |---|---|---|
//! | `id` | string | name, unique in the scene |
//! | `time` | date and time | RFC 3339, absent where unknown |
//! | `heading_deg`, `pitch_deg`, `roll_deg` | double | the rotation, for people |
//! | `uncertainty_m` | double | standard deviation of the position |
//! | `world_from_rig` | JSON | the rotation itself, 9 numbers, column after column |
//! | `cameras` | JSON | the rig's cameras as [`flaneur_scene::RigCamera`] |
//!
//! Positions and JSON numbers come back bit for bit; the angles are derived and not read.

mod read;
mod write;

pub use read::{PanoramaCursor, open, read};
pub use write::{PanoramaTableError, write};

/// Path of a stored image level below the scene's prefix.
pub fn image_path(panorama: &str, camera: &str, version: &str, level: u32) -> String {
    format!("panoramas/{panorama}/{camera}/{version}/{level}.jpg")
}

/// Path of a mask below the scene's prefix; `mask` is its [`flaneur_scene::Mask::name`].
pub fn mask_path(mask: &str) -> String {
    format!("masks/{mask}.png")
}

/// The columns, in the file's order.
const COLUMNS: [&str; 8] = [
    "id",
    "time",
    "heading_deg",
    "pitch_deg",
    "roll_deg",
    "uncertainty_m",
    "world_from_rig",
    "cameras",
];
