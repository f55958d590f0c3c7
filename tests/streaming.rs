//! The streamer against the real services, over a street ingested for it.

mod street;

use std::collections::{BTreeMap, BTreeSet};

use flaneur_scene::{ImageId, PointNodeId, Region, SceneUpdate, TileKey, View};
use flaneur_services::grpc::in_process;
use flaneur_services::store::{Catalog, Store};
use flaneur_streamer::{Event, FetchLimits, Progress, StreamError, Streamer, ViewRequest};
use futures::{StreamExt, TryStreamExt};
use glam::{DVec3, UVec2};
use street::SampleStreet;
use tokio_util::sync::CancellationToken;

async fn streamer(street: &SampleStreet) -> Streamer {
    let store = Store::open_existing(street.store.to_str().expect("text")).expect("ingested");
    let catalog = Catalog::open([store]).await.expect("ingested");
    let channel = in_process(catalog).await.expect("in process");
    Streamer::connect(channel, "sample").await.expect("the sample's scene")
}

/// The view of a panorama's eye towards `heading`.
fn view(eye: DVec3, heading: f64) -> View {
    View::look(eye, heading, 0.05, 1.0, UVec2::new(320, 160))
}

/// Positions of the panoramas, in the order of their names.
async fn eyes(streamer: &Streamer) -> Vec<DVec3> {
    let panoramas = streamer.client().panoramas(Region::All).await.expect("there are some");
    let mut panoramas: Vec<_> = panoramas.try_collect().await.expect("sound");
    panoramas.sort_by(|a, b| a.id.cmp(&b.id));
    panoramas.into_iter().map(|panorama| panorama.position).collect()
}

fn update_of(event: &Event) -> Option<SceneUpdate> {
    match event {
        Event::Update(update) => Some(update.clone()),
        Event::Progress(_) | Event::Fault { .. } => None,
    }
}

async fn updates(streamer: &mut Streamer, request: ViewRequest) -> (Vec<SceneUpdate>, Progress) {
    let events = streamer.stream(request, &CancellationToken::new());
    let events: Vec<Event> = events.try_collect().await.expect("a sound scene");
    let (mut updates, mut last) = (Vec::new(), Progress::default());
    for event in events {
        match event {
            Event::Update(update) => updates.push(update),
            Event::Progress(progress) => last = progress,
            Event::Fault { error, .. } => panic!("{error}"),
        }
    }
    (updates, last)
}

/// What a receiver holds after some updates: payloads in a form that can be compared.
#[derive(Debug, Default, PartialEq)]
struct Held {
    tiles: BTreeMap<TileKey, Vec<[u32; 3]>>,
    images: BTreeMap<ImageId, (u32, Vec<u8>)>,
    nodes: BTreeMap<PointNodeId, Vec<[u32; 3]>>,
}

impl Held {
    fn apply(&mut self, updates: &[SceneUpdate]) {
        let bits = |p: &[f32; 3]| p.map(f32::to_bits);
        for update in updates {
            match update {
                SceneUpdate::Mesh(tile) => {
                    let vertices = tile.vertices.iter().map(|v| bits(&v.position)).collect();
                    self.tiles.insert(tile.key, vertices);
                }
                SceneUpdate::Image(image) => {
                    self.images.insert(image.id.clone(), (image.level, image.rgba.clone()));
                }
                SceneUpdate::Points(chunk) => {
                    self.nodes.insert(chunk.id, chunk.positions.iter().map(bits).collect());
                }
                SceneUpdate::DropMesh(key) => drop(self.tiles.remove(key).expect("held")),
                SceneUpdate::DropImage(id) => drop(self.images.remove(id).expect("held")),
                SceneUpdate::DropPoints(id) => drop(self.nodes.remove(id).expect("held")),
            }
        }
    }
}

/// One scene serves all: making it takes longer than what is tested.
#[tokio::test(flavor = "multi_thread")]
async fn a_scene_streams() {
    let street = SampleStreet::dense("streaming").await;
    order_is_sensible(&street).await;
    the_outcome_does_not_depend_on_what_was_before(&street).await;
    limits_and_exclusions_hold(&street).await;
    normals_come_where_they_are_asked_for(&street).await;
    cancelling_ends_the_stream(&street).await;
    what_two_receivers_want_comes_once(&street).await;
    what_lies_ahead_is_there_when_one_comes(&street).await;
    unknown_scenes_are_named(&street).await;
}

async fn order_is_sensible(street: &SampleStreet) {
    let mut streamer = streamer(street).await;
    let eye = eyes(&streamer).await[0];
    let request = ViewRequest::new(view(eye, 1.5));
    let events = streamer.stream(request.clone(), &CancellationToken::new());
    let events: Vec<Event> = events.try_collect().await.expect("a sound scene");
    let updates: Vec<SceneUpdate> = events.iter().filter_map(update_of).collect();
    let Some(Event::Progress(last)) = events.last().cloned() else { panic!("{:?}", events.last()) };
    assert!(last.finished && last.remaining == 0 && last.bytes_received > 0, "{last:?}");

    // What makes a complete picture is there before the rest.
    let is_complete = |e: &Event| matches!(e, Event::Progress(p) if p.complete_picture);
    let complete = events.iter().position(is_complete).expect("complete before it is finished");
    let before: Vec<SceneUpdate> = events[..complete].iter().filter_map(update_of).collect();
    assert!(before.iter().any(|update| matches!(update, SceneUpdate::Mesh(_))));
    assert!(before.iter().any(|update| matches!(update, SceneUpdate::Image(_))));
    assert!(updates.iter().any(|update| matches!(update, SceneUpdate::Points(_))));

    let node_of = |update: &SceneUpdate| match update {
        SceneUpdate::Points(chunk) => Some(chunk.id),
        _ => None,
    };
    let nodes: Vec<PointNodeId> = updates.iter().filter_map(node_of).collect();
    let levels: BTreeSet<u32> = nodes.iter().map(|id| id.key.level).collect();
    assert!(nodes.len() >= 10 && levels.len() >= 3, "a tree of some depth: {nodes:?}");
    assert_eq!(nodes.iter().collect::<BTreeSet<_>>().len(), nodes.len(), "each comes once");
    let mut levels: BTreeMap<&ImageId, u32> = BTreeMap::new();
    for update in &updates {
        if let SceneUpdate::Image(image) = update {
            assert_eq!(image.rgba.len(), 4 * (image.size.x * image.size.y) as usize);
            let before = levels.insert(&image.id, image.level);
            assert!(before.is_none_or(|before| image.level < before), "finer comes later");
        }
    }

    // Nothing is sent again.
    let (again, _) = self::updates(&mut streamer, request).await;
    assert!(again.is_empty(), "{} updates", again.len());
}

async fn the_outcome_does_not_depend_on_what_was_before(street: &SampleStreet) {
    let mut walker = streamer(street).await;
    let eyes = eyes(&walker).await;
    // So tight that what is near one end is not wanted at the other.
    let limits = FetchLimits {
        mesh_radius_m: 20.0,
        panoramas: 2,
        points: 200_000,
        point_radius_m: 15.0,
        ..FetchLimits::default()
    };
    let mut held = Held::default();
    let mut dropped = 0;
    for (eye, heading) in [(eyes[0], 1.5), (eyes[eyes.len() - 1], 4.0), (eyes[1], 0.0)] {
        let request = ViewRequest { limits, ..ViewRequest::new(view(eye, heading)) };
        let (steps, _) = updates(&mut walker, request.clone()).await;
        held.apply(&steps);
        let is_drop = |u: &&SceneUpdate| {
            matches!(
                u,
                SceneUpdate::DropMesh(_) | SceneUpdate::DropImage(_) | SceneUpdate::DropPoints(_)
            )
        };
        dropped += steps.iter().filter(is_drop).count();
        let mut fresh = Held::default();
        fresh.apply(&updates(&mut streamer(street).await, request).await.0);
        assert!(held == fresh, "at {eye}");
    }
    assert!(dropped > 0, "the walk left something behind");
}

async fn limits_and_exclusions_hold(street: &SampleStreet) {
    const MOST: u64 = 250_000;
    let mut streamer = streamer(street).await;
    let eye = eyes(&streamer).await[0];
    let all = ViewRequest::new(view(eye, 1.5));
    let mut held = Held::default();
    held.apply(&updates(&mut streamer, all.clone()).await.0);
    let nodes = held.nodes.len();
    let excluded = held.images.keys().next().expect("some").clone();
    let gone = excluded.clone();
    let request = ViewRequest {
        limits: FetchLimits { points: MOST, image_pixels: 100_000, ..FetchLimits::default() },
        excluded: std::sync::Arc::new(move |id| *id == gone),
        ..all
    };
    held.apply(&updates(&mut streamer, request).await.0);
    let points = held.nodes.values().map(|node| node.len() as u64).sum::<u64>();
    assert!(points > MOST / 4 && points <= MOST, "{points}");
    assert!(held.nodes.len() > 1 && held.nodes.len() < nodes, "{} nodes", held.nodes.len());
    assert!(held.images.values().map(|(_, rgba)| rgba.len() / 4).sum::<usize>() <= 100_000);
    assert!(!held.images.is_empty() && !held.images.contains_key(&excluded));
}

/// Points that a receiver holds without normals come again with them, and the reverse.
async fn normals_come_where_they_are_asked_for(street: &SampleStreet) {
    let mut streamer = streamer(street).await;
    let eye = eyes(&streamer).await[0];
    for (normals, expected) in [(false, true), (true, true), (true, false), (false, true)] {
        let request = ViewRequest { normals, ..ViewRequest::new(view(eye, 1.5)) };
        let mut sent = false;
        for update in updates(&mut streamer, request).await.0 {
            let SceneUpdate::Points(chunk) = update else { continue };
            sent = true;
            let count = if normals { chunk.positions.len() } else { 0 };
            assert_eq!(chunk.normals.len(), count);
            if chunk.positions.len() > 2000 {
                let oriented = chunk.normals.iter().filter(|&&normal| normal != [0.0; 3]).count();
                assert!(!normals || 2 * oriented > count, "{oriented} of {count}");
            }
        }
        assert_eq!(sent, expected, "normals: {normals}");
    }
}

async fn cancelling_ends_the_stream(street: &SampleStreet) {
    let mut streamer = streamer(street).await;
    let eye = eyes(&streamer).await[0];
    let request = ViewRequest::new(view(eye, 1.5));
    let cancel = CancellationToken::new();
    let mut events = streamer.stream(request.clone(), &cancel);
    let mut held = Held::default();
    let end = loop {
        match events.next().await.expect("an error comes before the end") {
            Ok(Event::Update(update)) => {
                held.apply(&[update]);
                cancel.cancel();
            }
            Ok(Event::Progress(_) | Event::Fault { .. }) => {}
            Err(error) => break error,
        }
    };
    assert!(matches!(end, StreamError::Cancelled), "{end}");
    assert!(events.next().await.is_none());
    drop(events);
    // What had not been handed over comes with the next stream.
    held.apply(&updates(&mut streamer, request.clone()).await.0);
    let mut fresh = Held::default();
    let mut other = self::streamer(street).await;
    fresh.apply(&updates(&mut other, request).await.0);
    assert!(held == fresh);
}

/// Two receivers that look at the same thing at once hold the same in the end, for the bytes of one.
async fn what_two_receivers_want_comes_once(street: &SampleStreet) {
    let mut alone = streamer(street).await;
    let request = ViewRequest::new(view(eyes(&alone).await[0], 1.5));
    let mut expected = Held::default();
    expected.apply(&updates(&mut alone, request.clone()).await.0);
    let bytes = alone.statistics().bytes_received;

    let mut one = streamer(street).await;
    // As the one alone has asked.
    eyes(&one).await;
    let mut other = one.beside();
    let (first, second) =
        tokio::join!(updates(&mut one, request.clone()), updates(&mut other, request));
    for steps in [first.0, second.0] {
        let mut held = Held::default();
        held.apply(&steps);
        assert!(held == expected);
    }
    assert_eq!(one.statistics().bytes_received, bytes);
}

/// Someone walks at 5 m/s, and stands still where everything for the place two seconds ahead has come,
/// too: going there takes nothing more.
async fn what_lies_ahead_is_there_when_one_comes(street: &SampleStreet) {
    let mut streamer = streamer(street).await;
    let eyes = eyes(&streamer).await;
    let way = (eyes[1] - eyes[0]).normalize();
    let limits = FetchLimits {
        panoramas: 1,
        mesh_radius_m: 15.0,
        point_radius_m: 12.0,
        ..FetchLimits::default()
    };
    let request = |eye: DVec3| ViewRequest { limits, ..ViewRequest::walking(view(eye, 1.5)) };
    let begun = tokio::time::Instant::now();
    let mut walked = 0.0;
    while walked < 2.5 {
        walked = 5.0 * begun.elapsed().as_secs_f64();
        streamer.look(request(eyes[0] + walked * way));
        let moment = tokio::time::sleep(std::time::Duration::from_millis(50));
        tokio::pin!(moment);
        loop {
            tokio::select! {
                () = &mut moment => break,
                _ = streamer.next() => {}
            }
        }
    }
    // Until nothing has come for a second.
    let quiet = std::time::Duration::from_secs(1);
    let (mut bytes, mut since) = (0, tokio::time::Instant::now());
    while since.elapsed() < quiet {
        _ = tokio::time::timeout(quiet / 10, streamer.next()).await;
        let now = streamer.statistics().bytes_received;
        if std::mem::replace(&mut bytes, now) != now {
            since = tokio::time::Instant::now();
        }
    }
    let before = streamer.statistics();
    let (steps, _) = updates(&mut streamer, request(eyes[0] + (walked + 10.0) * way)).await;
    let after = streamer.statistics();
    assert!(
        steps.iter().any(|step| matches!(step, SceneUpdate::Image(_))),
        "something else is seen"
    );
    assert!(after.cache_hits > before.cache_hits, "{after:?}");
    let more = after.bytes_received - before.bytes_received;
    // The speed is known but roughly: at its border a node or a tile may be missing.
    assert!(10 * more < before.bytes_received, "{more} of {before:?}");
}

async fn unknown_scenes_are_named(street: &SampleStreet) {
    let store = Store::open_existing(street.store.to_str().expect("text")).expect("ingested");
    let channel = in_process(Catalog::open([store]).await.expect("ingested")).await.expect("here");
    let error = Streamer::connect(channel, "elsewhere").await.expect_err("no such scene");
    assert!(error.is_bad_request() && error.to_string().contains("elsewhere"), "{error}");
}
