//! A stored photograph as one looks at it: upright, no larger than there is room, and where in it a place is.

use std::sync::Arc;

use flaneur_scene::{Panorama, Region, RigCamera};
use flaneur_services::place::StoredSight;
use flaneur_streamer::{Picture, Streamer};
use futures::TryStreamExt;
use glam::{DVec2, DVec3, UVec2, Vec2Swizzles};
use image::{RgbImage, imageops};

use crate::exit::Exit;
use crate::source::stream_exit;

/// A camera is this far from the place of its rig, at most, metres.
const RIG_M: f64 = 5.0;

/// A photograph to be shown.
#[derive(Debug)]
pub(super) struct Photograph {
    pub(super) image: RgbImage,
    /// Where the place is, in parts of the sides.
    pub(super) mark: DVec2,
}

/// Fetches the photograph of `sight`, and decodes the level of it that fits into `room` pixels.
///
/// # Errors
/// Where the service fails, or does not know the photograph any more.
pub(super) async fn develop(
    streamer: &Streamer,
    sight: &StoredSight,
    room: UVec2,
) -> Result<Photograph, Exit> {
    let gone =
        || Exit::failed(anyhow::anyhow!("the service does not know this photograph any more"));
    let region = Region::Disc { centre: sight.centre.truncate(), radius_m: RIG_M };
    let panoramas = streamer.client().panoramas(region).await.map_err(stream_exit)?;
    let mut panoramas = std::pin::pin!(
        panoramas.try_filter(|found| std::future::ready(found.id == sight.panorama))
    );
    let panorama =
        panoramas.try_next().await.map_err(stream_exit)?.map(Arc::new).ok_or_else(gone)?;
    let named = |camera: &RigCamera| camera.id == sight.camera;
    let index = panorama.cameras.iter().position(named).ok_or_else(gone)?;
    let camera = &panorama.cameras[index];
    let turns = quarter_turns(&panorama, camera);
    let room = if turns % 2 == 1 { room.yx() } else { room };
    let level = level_for(camera, room);
    let picture = streamer.picture(&panorama, index, level).await.map_err(stream_exit)?;
    let picture = picture.ok_or_else(gone)?;
    let mark = turned(sight.pixel / camera.projection.size().as_dvec2(), turns);
    let image = tokio::task::spawn_blocking(move || upright(picture, room, turns));
    Ok(Photograph { image: image.await.map_err(Exit::failed)?, mark })
}

/// The coarsest level that is no smaller than what fits into `room`.
fn level_for(camera: &RigCamera, room: UVec2) -> u32 {
    let size = |level| camera.projection.level_size(level);
    let least = fitted(size(0), room);
    let levels = 0..camera.levels.len() as u32;
    levels.rev().find(|&level| size(level).cmpge(least).all()).unwrap_or(0)
}

/// As large as fits, in the same shape, and no larger than it is.
fn fitted(size: UVec2, room: UVec2) -> UVec2 {
    let share = (room.as_dvec2() / size.as_dvec2()).min_element().min(1.0);
    (size.as_dvec2() * share).as_uvec2().max(UVec2::ONE)
}

fn upright(picture: Picture, room: UVec2, turns: u32) -> RgbImage {
    let Picture { size, rgb } = picture;
    let least = fitted(size, room);
    let image = RgbImage::from_raw(size.x, size.y, rgb).unwrap_or_default();
    let image = imageops::thumbnail(&image, least.x, least.y);
    match turns {
        1 => imageops::rotate90(&image),
        2 => imageops::rotate180(&image),
        3 => imageops::rotate270(&image),
        _ => image,
    }
}

/// A place of a picture, in parts of its sides, after so many quarter turns clockwise.
fn turned(at: DVec2, turns: u32) -> DVec2 {
    (0..turns).fold(at, |at, _| DVec2::new(1.0 - at.y, at.x))
}

/// By how many quarter turns clockwise a photograph is to be shown so that what is up in the world is up in
/// it: cameras of a rig may hang on their side, or upside down. As on the web page.
fn quarter_turns(panorama: &Panorama, camera: &RigCamera) -> u32 {
    let up = camera.cam_from_rig * (panorama.world_from_rig.transpose() * DVec3::Z);
    if up.truncate().length() < 1e-6 {
        return 0;
    }
    let quarters = (up.x.atan2(-up.y) / std::f64::consts::FRAC_PI_2).round();
    (4.0 - quarters) as u32 % 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_photograph_is_turned_with_its_mark_and_fits() {
        let picture = Picture { size: UVec2::new(4, 2), rgb: (0..24).collect() };
        let shown = upright(picture, UVec2::new(400, 400), 1);
        assert_eq!(shown.dimensions(), (2, 4), "no larger than it is");
        // What was at the bottom on the left is at the top on the left.
        assert_eq!(shown.get_pixel(0, 0).0, [12, 13, 14]);
        assert_eq!(turned(DVec2::new(0.0, 1.0), 1), DVec2::ZERO);
        assert_eq!(turned(DVec2::new(0.25, 0.5), 4), DVec2::new(0.25, 0.5));
        assert_eq!(fitted(UVec2::new(4000, 2000), UVec2::new(800, 600)), UVec2::new(800, 400));
    }
}
