//! What a pixel of a view shows, as exactly as the survey knows.

use std::collections::HashMap;
use std::sync::Arc;

use flaneur_proto::v1;
use flaneur_renderer::{Picked, PickedSurface, Sight};
use flaneur_scene::{CubeFace, Footprint, Panorama, Projection, Region, RigCamera, SurfaceClass};
use flaneur_streamer::Client;
use futures::StreamExt as _;
use glam::{DVec2, DVec3};
use tonic::Status;

use super::refuse;
use super::scenes::OpenScene;
use super::stage::Found;
use super::wanted::Wanted;
use crate::{geography, gps_time};

/// A surveyed point is this near to the place that a picture shows of its disc, at most, metres.
const REACH_M: f64 = 1.0;
/// A building is looked for this far from its wall, metres.
const WALL_M: f64 = 3.0;
/// A camera is this far from the place of its rig, at most, metres.
const RIG_M: f64 = 5.0;

/// What `pixel` shows; with all photographs that see it, or only the first.
///
/// # Errors
/// Where the view cannot be rendered, or what is shown there cannot be read.
pub(super) async fn place(
    scene: &Arc<OpenScene>,
    wanted: Wanted,
    pixel: DVec2,
    photographs: bool,
) -> Result<Option<v1::Place>, Status> {
    let eye = wanted.view.eye();
    let found = scene.stage.pick(wanted, pixel).await.map_err(|e| refuse::of_render(&e))?;
    let Some(Found { picked, nodes }) = found else { return Ok(None) };
    let client = scene.streamer.client();
    let surface = match picked.surface {
        PickedSurface::Point => {
            let shown = |id: &_| nodes.contains(id);
            let point = scene.streamer.point_at(picked.position, REACH_M, shown).await;
            point.map_err(|e| refuse::of_stream(&e))?.map(|point| {
                v1::place::Surface::Point(v1::LidarPoint {
                    source: point.source,
                    position: Some(point.position.into()),
                    classification: point.class.into(),
                    intensity: point.intensity.into(),
                    gps_time: point.gps_time_s,
                    gps_time_kind: v1::GpsTimeKind::from(point.gps_time_kind).into(),
                    time: gps_time::utc(point.gps_time_kind, point.gps_time_s).unwrap_or_default(),
                })
            })
        }
        PickedSurface::Mesh(class) => Some(v1::place::Surface::Mesh(v1::MeshSurface {
            class: match class {
                SurfaceClass::Ground => v1::mesh_surface::Class::Ground,
                SurfaceClass::Wall => v1::mesh_surface::Class::Wall,
                SurfaceClass::Roof => v1::mesh_surface::Class::Roof,
            }
            .into(),
            footprint: match class {
                SurfaceClass::Ground => String::new(),
                SurfaceClass::Wall | SurfaceClass::Roof => footprint_at(client, &picked).await?,
            },
        })),
    };
    let most = if photographs { usize::MAX } else { 1 };
    let sights: Vec<Sight> = picked.seen_by.iter().take(most).cloned().collect();
    Ok(Some(v1::Place {
        position: Some(picked.position.into()),
        geographic: geography::position(scene.streamer.info(), picked.position),
        normal: Some(picked.normal.into()),
        uncertainty_m: picked.uncertainty_m,
        distance_m: picked.position.distance(eye),
        surface,
        photographs: stored(client, &sights, picked.position).await?,
    }))
}

/// The building whose outline is nearest to a wall or a roof; empty where none is near.
async fn footprint_at(client: &Client, picked: &Picked) -> Result<String, Status> {
    let at = picked.position.truncate();
    let region = Region::Disc { centre: at, radius_m: WALL_M };
    let found = client.buildings(region).await.map_err(|e| refuse::of_stream(&e))?;
    let nearest = found
        .into_iter()
        .map(|footprint| (distance_m(&footprint, at), footprint.id))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(nearest.filter(|(metres, _)| *metres <= WALL_M).map(|(_, id)| id).unwrap_or_default())
}

/// From a place of the plan to a footprint, metres; 0 inside of it.
fn distance_m(footprint: &Footprint, at: DVec2) -> f64 {
    let edges = footprint
        .polygons
        .iter()
        .flat_map(|polygon| &polygon.rings)
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| (*a, *b)));
    let (mut nearest_m, mut inside) = (f64::INFINITY, false);
    for (a, b) in edges {
        let (along, to) = (b - a, at - a);
        let length_2 = along.length_squared();
        let share = if length_2 > 0.0 { (to.dot(along) / length_2).clamp(0.0, 1.0) } else { 0.0 };
        nearest_m = nearest_m.min(at.distance(a + along * share));
        // Whether a ray to the east crosses the edge.
        if (a.y > at.y) != (b.y > at.y) {
            inside ^= at.x < a.x + (at.y - a.y) / along.y * along.x;
        }
    }
    if inside { 0.0 } else { nearest_m }
}

/// The photographs as they are stored: a face of a sphere is a part of its camera's picture.
async fn stored(client: &Client, sights: &[Sight], place: DVec3) -> Result<Vec<v1::Sight>, Status> {
    let farthest_m = sights.iter().map(|sight| sight.distance_m).fold(0.0, f64::max);
    if sights.is_empty() {
        return Ok(Vec::new());
    }
    let failed = |error| refuse::of_stream(&error);
    let region = Region::Disc { centre: place.truncate(), radius_m: farthest_m + RIG_M };
    let mut around = Box::pin(client.panoramas(region).await.map_err(failed)?);
    let mut panoramas: HashMap<String, Panorama> = HashMap::new();
    while let Some(panorama) = around.next().await {
        let panorama = panorama.map_err(failed)?;
        if sights.iter().any(|sight| sight.id.panorama() == panorama.id) {
            panoramas.insert(panorama.id.clone(), panorama);
        }
    }
    let mut found: Vec<v1::Sight> = Vec::new();
    for sight in sights {
        let Some(panorama) = panoramas.get(sight.id.panorama()) else { continue };
        let Some((camera, pixel)) = in_stored(panorama, sight, place) else { continue };
        let known =
            |other: &&mut v1::Sight| other.panorama == panorama.id && other.camera == camera.id;
        if let Some(other) = found.iter_mut().find(known) {
            // The edge of two faces.
            other.share += sight.share;
            continue;
        }
        found.push(v1::Sight {
            panorama: panorama.id.clone(),
            camera: camera.id.clone(),
            time: panorama.time.clone().unwrap_or_default(),
            pixel: Some(pixel.into()),
            distance_m: sight.distance_m,
            share: sight.share,
        });
    }
    Ok(found)
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
    use flaneur_scene::Polygon;

    use super::*;

    #[test]
    fn a_place_is_on_the_footprint_whose_edge_is_nearest_unless_it_is_within_one() {
        let square = |x: f64| Footprint {
            id: format!("{x}"),
            polygons: vec![Polygon {
                rings: vec![
                    [(0., 0.), (10., 0.), (10., 10.), (0., 10.)]
                        .map(|(dx, dy)| DVec2::new(x + dx, dy))
                        .to_vec(),
                ],
            }],
            base_m: 0.0,
            height_m: 10.0,
            uncertainty_m: 0.1,
            attributes: String::new(),
        };
        assert_eq!(distance_m(&square(0.0), DVec2::new(12.0, 5.0)), 2.0);
        assert_eq!(distance_m(&square(0.0), DVec2::new(13.0, 14.0)), 5.0);
        assert_eq!(distance_m(&square(0.0), DVec2::new(9.0, 5.0)), 0.0);
        assert_eq!(distance_m(&square(20.0), DVec2::new(12.0, 5.0)), 8.0);
    }
}
