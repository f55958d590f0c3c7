//! From payloads to what a survey knows and a receiver takes.

use std::sync::Arc;

use flaneur_proto::{FieldError, v1};
use flaneur_scene::{
    CUBE_FACES, Footprint, GroundTile, ImageUpdate, MeshTile, Panorama, Projection, SceneInfo,
    SceneUpdate, Station, TileKey, TileLayer, extrude_footprints, triangulate_ground,
};
use glam::UVec2;
use prost::Message;

use crate::StreamError;
use crate::choose::{FootprintGrid, WantedImage};
use crate::client::{HierarchyEntry, entries};
use crate::decode::{
    Mask, Picture, Track, cube_face, damaged, decode_mask, decode_picture, decode_points,
};
use crate::plan::Part;
use crate::survey::Target;

/// How far walls reach below their foot, metres: terrain falls away from a building's base by
/// less than that within its own length.
const SKIRT_M: f64 = 2.0;
/// Largest stored image that is taken, in pixels.
const MAX_PIXELS: u64 = 1 << 28;

/// What a payload means.
#[derive(Debug)]
pub(super) enum Understood {
    Panoramas(Vec<Arc<Panorama>>),
    Page(Vec<HierarchyEntry>),
    Stations(Arc<Track>),
    Mask(Arc<Mask>),
    Shown(Vec<SceneUpdate>),
}

/// What is needed beside the payload.
#[derive(Clone, Debug)]
pub(super) struct Context {
    pub(super) scene: Arc<SceneInfo>,
    /// Of an image that has one.
    pub(super) mask: Option<Arc<Mask>>,
    /// Of points.
    pub(super) track: Option<Arc<Track>>,
    pub(super) normals: bool,
}

/// What the payload of a part means. Takes milliseconds: not for async threads.
pub(super) fn understand(
    part: &Part,
    target: &Target,
    payload: &[u8],
    context: &Context,
) -> Result<Understood, StreamError> {
    match (part, target) {
        (Part::Panoramas(_), _) => panoramas(payload).map(Understood::Panoramas),
        (Part::Page(_), _) => {
            let field = StreamError::field("GetHierarchy");
            let page =
                v1::HierarchyPage::decode(payload).map_err(|e| unreadable(&e)).map_err(&field)?;
            entries(page).map(Understood::Page).map_err(field)
        }
        (Part::Stations(_), _) => {
            let field = StreamError::field("GetStations");
            let message = v1::Stations::decode(payload).map_err(|e| field(unreadable(&e)))?;
            let found =
                Vec::<Station>::try_from(message).map_err(|e| field(e.within("stations")))?;
            Ok(Understood::Stations(Arc::new(Track::through(&found))))
        }
        (Part::Mask(_), _) => {
            decode_mask(&target.name(), payload).map(|mask| Understood::Mask(Arc::new(mask)))
        }
        (Part::Mesh { key, .. }, _) => {
            let mesh = match key.layer {
                TileLayer::Footprints => Some(buildings(*key, payload, &context.scene)?),
                TileLayer::Ground => ground(*key, payload)?,
            };
            let mesh = mesh.filter(|mesh| !mesh.indices.is_empty());
            let updates = mesh.map(|mesh| SceneUpdate::Mesh(Arc::new(mesh)));
            Ok(Understood::Shown(updates.into_iter().collect()))
        }
        (Part::Image { .. }, Target::Image(image, level)) => {
            photographs(image, *level, payload, context.mask.as_deref()).map(Understood::Shown)
        }
        (Part::Node(id), Target::Node(wanted)) => {
            let sources = &context.scene.point_sources;
            let (Some(source), Some(track)) = (sources.get(usize::from(id.source)), &context.track)
            else {
                return Err(damaged(target.name(), "its point source is not known"));
            };
            let chunk = decode_points(source, *id, &wanted.node, payload, track, context.normals)?;
            Ok(Understood::Shown(vec![SceneUpdate::Points(Arc::new(chunk))]))
        }
        (Part::Image { .. } | Part::Node(_), _) => {
            Err(damaged(target.name(), "it is not known what it is"))
        }
    }
}

fn unreadable(error: &prost::DecodeError) -> FieldError {
    FieldError::new("", format!("is no such message: {error}"))
}

fn panoramas(mut payload: &[u8]) -> Result<Vec<Arc<Panorama>>, StreamError> {
    let field = StreamError::field("StreamPanoramas");
    let mut found = Vec::new();
    while !payload.is_empty() {
        let message = v1::Panorama::decode_length_delimited(&mut payload)
            .map_err(|e| field(unreadable(&e)))?;
        let panorama = Panorama::try_from(message).map_err(&field)?;
        // Whoever chooses among its photographs must be able to name them.
        panorama.photographs().map_err(|e| field(FieldError::new("id", e.to_string())))?;
        found.push(Arc::new(panorama));
    }
    Ok(found)
}

fn buildings(key: TileKey, payload: &[u8], scene: &SceneInfo) -> Result<MeshTile, StreamError> {
    let field = StreamError::field("StreamFootprints");
    let batch = v1::FootprintBatch::decode(payload).map_err(|e| field(unreadable(&e)))?;
    let mut footprints = batch
        .footprints
        .into_iter()
        .map(Footprint::try_from)
        .collect::<Result<Vec<_>, _>>()
        .map_err(field)?;
    FootprintGrid::sort(&mut footprints);
    let middle = FootprintGrid::bounds(key).min + 0.5 * FootprintGrid::TILE_M;
    let origin = middle.extend(scene.origin.z);
    Ok(extrude_footprints(key, origin, &footprints, SKIRT_M))
}

fn ground(key: TileKey, payload: &[u8]) -> Result<Option<MeshTile>, StreamError> {
    let field = StreamError::field("StreamGround");
    if payload.is_empty() {
        return Ok(None);
    }
    let message = v1::GroundTile::decode(payload).map_err(|e| field(unreadable(&e)))?;
    let tile = GroundTile::try_from(message).map_err(&field)?;
    if tile.index != (key.x, key.y) {
        let problem = format!("is {:?}, must be {:?}", tile.index, (key.x, key.y));
        return Err(field(FieldError::new("column", problem)));
    }
    Ok(Some(triangulate_ground(&tile)))
}

fn photographs(
    image: &WantedImage,
    level: u32,
    payload: &[u8],
    mask: Option<&Mask>,
) -> Result<Vec<SceneUpdate>, StreamError> {
    let size = image.rig_camera().projection.level_size(level);
    if u64::from(size.x) * u64::from(size.y) > MAX_PIXELS {
        return Err(damaged(image.name(level), format!("{size} pixels are too many")));
    }
    let picture = decode_picture(&image.name(level), payload, size)?;
    let updates = image.photographs.iter().map(|(id, camera, face)| {
        let (size, rgba) = pixels(image, &picture, mask, *face);
        SceneUpdate::Image(Arc::new(ImageUpdate {
            id: id.clone(),
            level,
            camera: *camera,
            size,
            rgba,
            uncertainty_m: image.panorama.uncertainty_m,
        }))
    });
    Ok(updates.collect())
}

fn pixels(
    image: &WantedImage,
    picture: &Picture,
    mask: Option<&Mask>,
    face: Option<usize>,
) -> (UVec2, Vec<u8>) {
    match (image.rig_camera().projection, face.and_then(|face| CUBE_FACES.get(face))) {
        (Projection::Equirectangular { .. }, Some(face)) => {
            let side = (picture.size.x / 4).max(1);
            (UVec2::splat(side), cube_face(picture, mask, face, side))
        }
        _ => (picture.size, picture.masked(mask)),
    }
}
