//! What a pixel of a view shows, as exactly as the survey knows.

use std::sync::Arc;

use flaneur_proto::v1;
use flaneur_renderer::PickedSurface;
use flaneur_scene::SurfaceClass;
use flaneur_streamer::SurveyedPoint;
use glam::DVec2;
use tonic::Status;

use super::refuse;
use super::scenes::OpenScene;
use super::wanted::Wanted;
use crate::place::{Record, StoredSight, look_up};
use crate::{geography, gps_time};

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
    let Some(found) = found else { return Ok(None) };
    let most = if photographs { usize::MAX } else { 1 };
    let record = look_up(&scene.streamer, &found, most).await;
    let Record { point, footprint, photographs } = record.map_err(|e| refuse::of_stream(&e))?;
    let picked = found.picked;
    let surface = match picked.surface {
        PickedSurface::Point => point.map(|point| v1::place::Surface::Point(of_lidar(point))),
        PickedSurface::Mesh(class) => Some(v1::place::Surface::Mesh(v1::MeshSurface {
            class: match class {
                SurfaceClass::Ground => v1::mesh_surface::Class::Ground,
                SurfaceClass::Wall => v1::mesh_surface::Class::Wall,
                SurfaceClass::Roof => v1::mesh_surface::Class::Roof,
            }
            .into(),
            footprint: footprint.unwrap_or_default(),
        })),
    };
    Ok(Some(v1::Place {
        position: Some(picked.position.into()),
        geographic: geography::position(scene.streamer.info(), picked.position),
        normal: Some(picked.normal.into()),
        uncertainty_m: picked.uncertainty_m,
        distance_m: picked.position.distance(eye),
        surface,
        photographs: photographs.into_iter().map(sight).collect(),
    }))
}

fn of_lidar(point: SurveyedPoint) -> v1::LidarPoint {
    v1::LidarPoint {
        time: gps_time::utc(point.gps_time_kind, point.gps_time_s).unwrap_or_default(),
        source: point.source,
        position: Some(point.position.into()),
        classification: point.class.into(),
        intensity: point.intensity.into(),
        gps_time: point.gps_time_s,
        gps_time_kind: v1::GpsTimeKind::from(point.gps_time_kind).into(),
    }
}

fn sight(stored: StoredSight) -> v1::Sight {
    v1::Sight {
        panorama: stored.panorama,
        camera: stored.camera,
        time: stored.time.unwrap_or_default(),
        pixel: Some(stored.pixel.into()),
        distance_m: stored.distance_m,
        share: stored.share,
    }
}
