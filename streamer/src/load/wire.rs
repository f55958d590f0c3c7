//! Asking the services for parts. Whatever comes becomes one payload a part: files and chunks as they
//! are, and of what answers a region to each part what is its own, encoded again.

use std::collections::{BTreeMap, HashMap};

use bytes::Bytes;
use flaneur_proto::v1;
use flaneur_scene::{Bounds2, Footprint, Panorama, Region, SceneInfo, TileKey, TileLayer};
use prost::Message;

use super::expected;
use crate::StreamError;
use crate::choose::{District, FootprintGrid, district_bounds, district_of};
use crate::client::{Client, Payloads, Piece};
use crate::decode::{damaged, decoded};
use crate::plan::Part;
use crate::servers::Turn;
use crate::survey::Target;

/// Largest stored file that is taken.
const MAX_BYTES: u64 = 1 << 30;
/// Most panoramas of an answer.
const MAX_PANORAMAS: usize = 100_000;
/// Share of a tile's side by which a request stays inside the tiles that it asks for, so that their
/// neighbours do not come along.
const INSET: f64 = 0.25;

/// Takes what has come of a part, and from whom.
pub(super) type Land<'a> = &'a (dyn Fn(&Part, Turn, Result<Bytes, StreamError>) + Send + Sync);

/// Fetches `parts`, all of one kind, and gives each to `land` as it comes. An error says nothing
/// of the parts that have landed.
pub(super) async fn fetch(
    client: &Client,
    scene: &SceneInfo,
    parts: &[(Part, Target)],
    land: Land<'_>,
) -> Result<(), StreamError> {
    let Some((first, _)) = parts.first() else { return Ok(()) };
    match first {
        Part::Panoramas(_) => panoramas(client, parts, land).await,
        Part::Mesh { key, step } => match key.layer {
            TileLayer::Footprints => footprints(client, parts, land).await,
            TileLayer::Ground => ground(client, scene, parts, *step, land).await,
        },
        Part::Page(page) => {
            let source = source_name(scene, page.source);
            let (answer, turn) = client.hierarchy_page(source, page.key).await?;
            land(first, turn, Ok(answer.encode_to_vec().into()));
            Ok(())
        }
        Part::Stations(source) => {
            let (answer, turn) = client.stations(source_name(scene, *source)).await?;
            land(first, turn, Ok(answer.encode_to_vec().into()));
            Ok(())
        }
        Part::Mask(_) | Part::Image { .. } => images(client, parts, land).await,
        Part::Node(id) => chunks(client, source_name(scene, id.source), parts, land).await,
    }
}

async fn images(
    client: &Client,
    parts: &[(Part, Target)],
    land: Land<'_>,
) -> Result<(), StreamError> {
    let keys = parts.iter().filter_map(|(_, target)| match target {
        Target::Mask(key, _) => Some(key.clone()),
        Target::Image(image, level) => Some(image.key(*level, v1::ImageLayer::Colour)),
        Target::Named | Target::Node(_) => None,
    });
    let payloads = client.images(keys.collect(), limit(parts)).await?;
    deliver(client, payloads, parts, land).await
}

async fn chunks(
    client: &Client,
    source: &str,
    parts: &[(Part, Target)],
    land: Land<'_>,
) -> Result<(), StreamError> {
    let keys = parts.iter().filter_map(|(part, _)| match part {
        Part::Node(id) => Some(id.key),
        _ => None,
    });
    let payloads = client.chunks(source, keys.collect(), limit(parts)).await?;
    deliver(client, payloads, parts, land).await
}

/// Gives each of `parts` its payload, in their order.
async fn deliver<P: Piece>(
    client: &Client,
    mut payloads: Payloads<P>,
    parts: &[(Part, Target)],
    land: Land<'_>,
) -> Result<(), StreamError> {
    for (part, target) in parts {
        let Some(payload) = payloads.next().await? else { break };
        let length = payload.len() as u64;
        let payload = checked(target, payload);
        if payload.is_err() {
            payloads.distrust();
            client.traffic().abandoned(length);
        }
        land(part, payloads.turn(), payload);
    }
    Ok(())
}

async fn panoramas(
    client: &Client,
    parts: &[(Part, Target)],
    land: Land<'_>,
) -> Result<(), StreamError> {
    let mut found: BTreeMap<District, Vec<u8>> = BTreeMap::new();
    let mut around = Bounds2::EMPTY;
    for (part, _) in parts {
        let Part::Panoramas(district) = part else { continue };
        found.insert(*district, Vec::new());
        include(&mut around, &district_bounds(*district));
    }
    let mut messages = client.open_panoramas(Region::Box(around)).await?;
    let mut received = Vec::new();
    while let Some(message) = messages.next().await? {
        received.push(message);
        if received.len() > MAX_PANORAMAS {
            let (call, limit) = (messages.call(), MAX_PANORAMAS);
            return Err(StreamError::TooMuch { call, what: "panoramas", limit });
        }
    }
    let call = messages.call();
    let sorted = decoded(call, move || {
        for message in received {
            let bytes = message.encode_length_delimited_to_vec();
            let panorama = Panorama::try_from(message).map_err(StreamError::field(call))?;
            let district = district_of(panorama.position.truncate());
            // Those on the border of the region may be another district's.
            if let Some(found) = district.and_then(|district| found.get_mut(&district)) {
                found.extend_from_slice(&bytes);
            }
        }
        Ok(found)
    });
    let mut found = sorted.await.inspect_err(|_| messages.distrust())?;
    for (part, _) in parts {
        let Part::Panoramas(district) = part else { continue };
        land(part, messages.turn(), Ok(found.remove(district).unwrap_or_default().into()));
    }
    Ok(())
}

async fn footprints(
    client: &Client,
    parts: &[(Part, Target)],
    land: Land<'_>,
) -> Result<(), StreamError> {
    let mut found = BTreeMap::new();
    let mut around = Bounds2::EMPTY;
    for (part, _) in parts {
        let Part::Mesh { key, .. } = part else { continue };
        found.insert(*key, v1::FootprintBatch::default());
        include(&mut around, &FootprintGrid::bounds(*key));
    }
    let (received, turn) = client.footprints(Region::Box(around)).await?;
    let call = "StreamFootprints";
    let sorted = decoded(call, move || {
        for message in received {
            let footprint =
                Footprint::try_from(message.clone()).map_err(StreamError::field(call))?;
            let key = FootprintGrid::key(&footprint);
            if let Some(tile) = key.and_then(|key| found.get_mut(&key)) {
                tile.footprints.push(message);
            }
        }
        Ok(found.into_iter().map(|(key, tile)| (key, tile.encode_to_vec())).collect())
    });
    let mut found: BTreeMap<TileKey, Vec<u8>> =
        sorted.await.inspect_err(|_| client.servers().fails(turn))?;
    for (part, _) in parts {
        let Part::Mesh { key, .. } = part else { continue };
        land(part, turn, Ok(found.remove(key).unwrap_or_default().into()));
    }
    Ok(())
}

async fn ground(
    client: &Client,
    scene: &SceneInfo,
    parts: &[(Part, Target)],
    step: u32,
    land: Land<'_>,
) -> Result<(), StreamError> {
    let Some(layout) = &scene.ground else { return Ok(()) };
    let mut around = Bounds2::EMPTY;
    for (part, _) in parts {
        if let Some(cell) = part.cell() {
            let bounds = layout.bounds(cell);
            let inset = INSET * layout.tile_m;
            include(&mut around, &Bounds2 { min: bounds.min + inset, max: bounds.max - inset });
        }
    }
    let (tiles, turn) = client.ground(Region::Box(around), step).await?;
    let mut found: HashMap<(i32, i32), v1::GroundTile> =
        tiles.into_iter().map(|tile| ((tile.column, tile.row), tile)).collect();
    for (part, _) in parts {
        // Nothing is known of a tile that does not come.
        let tile = part.cell().and_then(|cell| found.remove(&cell));
        let payload = tile.map(|tile| tile.encode_to_vec()).unwrap_or_default();
        land(part, turn, Ok(payload.into()));
    }
    Ok(())
}

fn include(around: &mut Bounds2, bounds: &Bounds2) {
    around.include(bounds.min);
    around.include(bounds.max);
}

fn source_name(scene: &SceneInfo, source: u16) -> &str {
    scene.point_sources.get(usize::from(source)).map_or("", |source| source.name.as_str())
}

/// Most bytes that any of `parts` may take.
fn limit(parts: &[(Part, Target)]) -> u64 {
    let lengths = parts.iter().filter_map(|(_, target)| expected(target));
    lengths.map(|expected| expected.length).max().unwrap_or(0).min(MAX_BYTES)
}

/// The payload, if it is what there is.
fn checked(target: &Target, payload: Bytes) -> Result<Bytes, StreamError> {
    match expected(target) {
        Some(expected) if !expected.holds(&payload) => {
            let problem = format!(
                "{} bytes came with another checksum than is known of its {}",
                payload.len(),
                expected.length
            );
            Err(damaged(target.name(), problem))
        }
        _ => Ok(payload),
    }
}
