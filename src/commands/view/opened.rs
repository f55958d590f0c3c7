//! A scene that has been opened, and where one stands in it at first.

use std::path::Path;

use flaneur_scene::{Panorama, Region};
use flaneur_streamer::{Client, StreamOptions, Streamer};
use futures::TryStreamExt;
use glam::{DVec2, DVec3};

use super::pose::Pose;
use super::start::start;
use crate::exit::Exit;
use crate::source::{Source, stream_exit};

/// The file that makes a folder a scene; opening it opens the folder.
const MANIFEST: &str = "scene.json";
/// How far around a place one looks for a photograph, metres, one after the other.
const RADII: [f64; 3] = [30.0, 200.0, 2000.0];

/// A scene, connected.
pub(super) struct Opened {
    pub(super) streamer: Streamer,
    /// Where one stands at first.
    pub(super) start: Pose,
}

impl Opened {
    /// Opens `text`, as [`Source::open`] does, or a scene's manifest.
    pub(super) async fn open(text: &str, options: StreamOptions, fov_y: f64) -> Result<Self, Exit> {
        let source = Source::open(folder_of(text)).await?;
        let streamer = source.streamer_with(options).await?;
        let start = start(streamer.client(), streamer.info(), fov_y).await?;
        Ok(Self { streamer, start })
    }
}

/// The panorama nearest to a place of the plan, and the centre of its first camera; `None` where
/// there is none within two kilometres.
pub(super) async fn nearest(
    client: &Client,
    place: DVec2,
) -> Result<Option<(Panorama, DVec3)>, Exit> {
    for radius_m in RADII {
        let region = Region::Disc { centre: place, radius_m };
        let panoramas = client.panoramas(region).await.map_err(stream_exit)?;
        let mut panoramas = std::pin::pin!(panoramas);
        if let Some(panorama) = panoramas.try_next().await.map_err(stream_exit)? {
            let cameras = panorama.photographs()?;
            let centre = cameras.first().map_or(panorama.position, |(_, camera)| camera.centre);
            return Ok(Some((panorama, centre)));
        }
    }
    Ok(None)
}

/// The scene's folder where `text` is the path of its manifest.
fn folder_of(text: &str) -> &str {
    let path = Path::new(text);
    let of_manifest = path.file_name().is_some_and(|name| name == MANIFEST) && path.is_file();
    let folder = path.parent().filter(|_| of_manifest).and_then(Path::to_str);
    match folder {
        Some("") => ".",
        Some(folder) => folder,
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_stands_for_its_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().to_str().expect("text");
        let manifest = format!("{path}/{MANIFEST}");
        assert_eq!(folder_of(&manifest), manifest, "it must be a file");
        std::fs::write(&manifest, "{}").expect("writable");
        assert_eq!(folder_of(&manifest), path);
        for other in ["http://h:1/scene.json", "s3://b/scene.json", path] {
            assert_eq!(folder_of(other), other);
        }
    }
}
