//! The photographs that see a place, as they are stored.

use std::collections::HashMap;

use flaneur_renderer::Sight;
use flaneur_scene::{CubeFace, Panorama, Projection, Region, RigCamera};
use flaneur_streamer::{Client, StreamError};
use futures::StreamExt as _;
use glam::{DVec2, DVec3};

/// A camera is this far from the place of its rig, at most, metres.
const RIG_M: f64 = 5.0;

/// A stored photograph that sees a place.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredSight {
    /// Of which panorama.
    pub panorama: String,
    /// Of which of its cameras.
    pub camera: String,
    /// When it was taken, RFC 3339, where known.
    pub time: Option<String>,
    /// Where its camera was, world, metres.
    pub centre: DVec3,
    /// Where in it the place is, pixels of level 0.
    pub pixel: DVec2,
    /// From its camera to the place, metres.
    pub distance_m: f64,
    /// Its part in the colour that the picture has there, 0 to 1.
    pub share: f64,
}

/// The photographs of `sights`, in their order. Those that are not stored any more are left out.
pub(super) async fn stored(
    client: &Client,
    sights: &[Sight],
    place: DVec3,
) -> Result<Vec<StoredSight>, StreamError> {
    if sights.is_empty() {
        return Ok(Vec::new());
    }
    let farthest_m = sights.iter().map(|sight| sight.distance_m).fold(0.0, f64::max);
    let region = Region::Disc { centre: place.truncate(), radius_m: farthest_m + RIG_M };
    let mut around = Box::pin(client.panoramas(region).await?);
    let mut panoramas: HashMap<String, Panorama> = HashMap::new();
    while let Some(panorama) = around.next().await {
        let panorama = panorama?;
        if sights.iter().any(|sight| sight.id.panorama() == panorama.id) {
            panoramas.insert(panorama.id.clone(), panorama);
        }
    }
    Ok(of_panoramas(&panoramas, sights, place))
}

/// Each photograph once: a face of a sphere is a part of its camera's picture.
fn of_panoramas(
    panoramas: &HashMap<String, Panorama>,
    sights: &[Sight],
    place: DVec3,
) -> Vec<StoredSight> {
    let mut found: Vec<StoredSight> = Vec::new();
    for sight in sights {
        let Some(panorama) = panoramas.get(sight.id.panorama()) else { continue };
        let Some((camera, pixel)) = in_stored(panorama, sight, place) else { continue };
        let known =
            |other: &&mut StoredSight| other.panorama == panorama.id && other.camera == camera.id;
        if let Some(other) = found.iter_mut().find(known) {
            // The edge of two faces.
            other.share += sight.share;
            continue;
        }
        found.push(StoredSight {
            panorama: panorama.id.clone(),
            camera: camera.id.clone(),
            time: panorama.time.clone(),
            centre: panorama.position + panorama.world_from_rig * camera.position_in_rig,
            pixel,
            distance_m: sight.distance_m,
            share: sight.share,
        });
    }
    found
}

/// The stored camera that a photograph is, or is a face of, and where in its picture a place is.
fn in_stored<'a>(
    panorama: &'a Panorama,
    sight: &Sight,
    place: DVec3,
) -> Option<(&'a RigCamera, DVec2)> {
    let is_sphere =
        |camera: &&RigCamera| matches!(camera.projection, Projection::Equirectangular { .. });
    let cameras = &panorama.cameras;
    let own = cameras.iter().find(|camera| camera.id == sight.id.camera() && !is_sphere(camera));
    if let Some(own) = own {
        return Some((own, sight.pixel));
    }
    let sphere = cameras.iter().find(is_sphere)?;
    let in_rig = panorama.world_from_rig.transpose() * (place - panorama.position);
    let direction = sphere.cam_from_rig * (in_rig - sphere.position_in_rig);
    let size = sphere.projection.size();
    Some((sphere, CubeFace::equirectangular_from_rig(direction, size)))
}

#[cfg(test)]
mod tests {
    use flaneur_scene::{ImageId, StoredImage};
    use glam::{DMat3, UVec2};

    use super::*;

    #[test]
    fn faces_of_a_sphere_are_one_photograph_taken_where_its_camera_was() {
        let size = UVec2::new(400, 200);
        let sphere = RigCamera {
            id: "sphere".to_owned(),
            position_in_rig: DVec3::new(0.0, 1.0, 2.0),
            cam_from_rig: DMat3::IDENTITY,
            projection: Projection::Equirectangular { size },
            levels: vec![StoredImage { bytes: 1, crc32: 0 }],
            mask: None,
            version: "1".to_owned(),
        };
        let panorama = Panorama {
            id: "7".to_owned(),
            position: DVec3::new(10.0, 20.0, 30.0),
            // Forward is west.
            world_from_rig: DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2),
            time: Some("2024-05-14T09:06:40Z".to_owned()),
            uncertainty_m: 0.0,
            cameras: vec![sphere],
        };
        let sight = |panorama: &str, camera: &str| Sight {
            id: ImageId::new(panorama, camera).expect("a name"),
            pixel: DVec2::ZERO,
            distance_m: 5.0,
            share: 0.25,
        };
        let sights = [sight("7", "front"), sight("8", "front"), sight("7", "right")];
        let centre = DVec3::new(9.0, 20.0, 32.0);
        let known = HashMap::from([(panorama.id.clone(), panorama)]);
        let found = of_panoramas(&known, &sights, centre + DVec3::Y * 5.0);
        let [one] = &found[..] else { panic!("{found:?}") };
        assert_eq!((one.panorama.as_str(), one.camera.as_str()), ("7", "sphere"));
        assert_eq!((one.share, one.time.as_deref()), (0.5, Some("2024-05-14T09:06:40Z")));
        assert!(one.centre.distance(centre) < 1e-12, "{}", one.centre);
        // A right angle to the right of the middle.
        assert!(one.pixel.distance(DVec2::new(300.0, 100.0)) < 1e-9, "{}", one.pixel);
    }
}
