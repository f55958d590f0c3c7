//! Services that lie for a while, fail for a while, or fall silent: what they have is had in the
//! end, from them or from another.
//!
//! Time is paused: where nothing is left to do, it jumps to whatever is waited for.

mod liar;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::{SceneUpdate, View};
use flaneur_streamer::{Event, Servers, Statistics, StreamError, Streamer, ViewRequest};
use glam::{DVec3, UVec2};
use liar::{Answer, Liar, connect, connect_slowly, jpeg, part};
use tokio_util::sync::CancellationToken;
use tonic::{Code, Status};

/// What came of streaming a view.
#[derive(Debug)]
struct Outcome {
    photographs: usize,
    faults: Vec<StreamError>,
    statistics: Statistics,
}

async fn stream(servers: impl Into<Servers>) -> Outcome {
    let mut streamer = Streamer::connect(servers, "street").await.expect("a scene");
    let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(64, 64));
    let view = streamer.look(ViewRequest::new(view));
    let (mut photographs, mut faults) = (0, Vec::new());
    loop {
        match streamer.next().await {
            Event::Update(SceneUpdate::Image(image)) => {
                assert_eq!((image.size, image.level), (UVec2::splat(16), 0));
                photographs += 1;
            }
            Event::Update(other) => panic!("there is no {other:?}"),
            Event::Fault { error, .. } => faults.push(error),
            Event::Progress(progress) if progress.view == view && progress.finished => break,
            Event::Progress(_) => {}
        }
    }
    Outcome { photographs, faults, statistics: streamer.statistics() }
}

/// An answer with the photograph.
fn honest(key: v1::ImageKey) -> Answer {
    let picture = jpeg(16, 16);
    Ok(vec![part(key, picture.len() as u64, 0, &picture)])
}

/// A service that answers `lies` times with `lie`, and honestly from then on.
fn liar(lies: usize, lie: impl Fn(v1::ImageKey) -> Answer + Send + Sync + 'static) -> Liar {
    let asked = AtomicUsize::new(0);
    let answer = move |key| {
        let is_lie = asked.fetch_add(1, Ordering::Relaxed) < lies;
        if is_lie { lie(key) } else { honest(key) }
    };
    Liar { parts: Some(Arc::new(answer)), ..Liar::honest() }
}

type Lie = (&'static str, fn(v1::ImageKey) -> Answer);

/// What is no photograph, in every way in which that can be seen.
fn lies() -> Vec<Lie> {
    vec![
        ("other bytes of the same length", |key| {
            let mut picture = jpeg(16, 16);
            let middle = picture.len() / 2;
            picture[middle] ^= 1;
            Ok(vec![part(key, picture.len() as u64, 0, &picture)])
        }),
        ("fewer bytes", |key| Ok(vec![part(key, 3, 0, b"abc")])),
        ("more bytes than any memory holds", |key| Ok(vec![part(key, 1 << 60, 0, b"x")])),
        ("half of it", |key| {
            let picture = jpeg(16, 16);
            Ok(vec![part(key, picture.len() as u64, 0, &picture[..picture.len() / 2])])
        }),
        ("something else", |key| Ok(vec![part(v1::ImageKey { level: 9, ..key }, 1, 0, b"x")])),
        ("nothing", |_| Ok(Vec::new())),
        ("that its own data are lost", |_| Err(Status::data_loss("the file is damaged"))),
    ]
}

#[tokio::test(start_paused = true)]
async fn garbage_is_asked_for_once_more() {
    for (what, lie) in lies() {
        let outcome = stream(connect(liar(1, lie)).await).await;
        assert_eq!(outcome.photographs, 1, "{what}: {outcome:?}");
        assert!(outcome.faults.is_empty(), "{what}: {outcome:?}");
        assert_eq!(outcome.statistics.refetched, 1, "{what}: {outcome:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn what_came_of_answers_that_broke_off_is_lost() {
    let sound = stream(connect(Liar::honest()).await).await.statistics;
    assert_eq!(sound.bytes_wasted, 0, "{sound:?}");
    let liar = Liar { broken_regions: Arc::new(3.into()), ..Liar::honest() };
    let broken = stream(connect(liar).await).await.statistics;
    // Every answer is that one panorama; what broke off is asked for again, in more than one request.
    let more = broken.bytes_received - sound.bytes_received;
    let answers = broken.requests - sound.requests;
    assert!(more > 0 && answers * broken.bytes_wasted == 3 * more, "{broken:?} {sound:?}");
}

#[tokio::test(start_paused = true)]
async fn garbage_that_stays_is_said_and_not_asked_for_again() {
    for (what, lie) in lies() {
        let outcome = stream(connect(liar(usize::MAX, lie)).await).await;
        assert_eq!(outcome.photographs, 0, "{what}: {outcome:?}");
        assert_eq!((outcome.faults.len(), outcome.statistics.refetched), (1, 1), "{what}");
    }
}

#[tokio::test(start_paused = true)]
async fn garbage_is_had_from_another() {
    for (what, lie) in lies() {
        let servers = vec![connect(liar(usize::MAX, lie)).await, connect(Liar::honest()).await];
        let outcome = stream(servers).await;
        assert_eq!((outcome.photographs, outcome.faults.len()), (1, 0), "{what}: {outcome:?}");
        let counted = outcome.statistics;
        assert_eq!((counted.refetched, counted.failovers), (1, 1), "{what}: {outcome:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn what_fails_for_a_while_is_asked_for_until_it_does_not() {
    for code in [Code::Unavailable, Code::ResourceExhausted, Code::Aborted, Code::Internal] {
        let fails = move |_| Err(Status::new(code, "not now"));
        let outcome = stream(connect(liar(7, fails)).await).await;
        assert_eq!(outcome.photographs, 1, "{code}: {outcome:?}");
        assert_eq!(outcome.statistics.retries, 7, "{code}: {outcome:?}");
        assert_eq!(outcome.statistics.refetched, 0, "{code}: {outcome:?}");
    }
}

/// A server that answers, and says every time that it cannot just now, is not believed for ever.
#[tokio::test(start_paused = true)]
async fn an_excuse_that_stays_is_a_refusal() {
    for code in [Code::Unavailable, Code::Internal] {
        let fails = move |_| Err(Status::new(code, "not now"));
        let outcome = stream(connect(liar(usize::MAX, fails)).await).await;
        assert_eq!((outcome.photographs, outcome.faults.len()), (0, 1), "{code}: {outcome:?}");
        assert_eq!(outcome.statistics.retries, 11, "{code}: {outcome:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn what_is_refused_is_said_at_once() {
    for code in [Code::NotFound, Code::PermissionDenied, Code::InvalidArgument] {
        let refuses = move |_| Err(Status::new(code, "never"));
        let outcome = stream(connect(liar(usize::MAX, refuses)).await).await;
        assert_eq!((outcome.photographs, outcome.faults.len()), (0, 1), "{code}: {outcome:?}");
        assert_eq!(outcome.statistics.retries, 0, "{code}: {outcome:?}");
        assert!(outcome.faults[0].to_string().contains("never"), "{code}: {outcome:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn where_one_falls_silent_another_is_asked() {
    let (silent, watch) = Liar::silent();
    let servers = vec![connect(silent).await, connect(Liar::honest()).await];
    let outcome = stream(servers).await;
    assert_eq!((outcome.photographs, outcome.faults.len()), (1, 0), "{outcome:?}");
    assert!(outcome.statistics.retries > 0 && outcome.statistics.failovers == 1, "{outcome:?}");
    // The one that was given up need not go on.
    watch.ended().await;
}

/// A server that is full answers; one that says nothing may as well be gone.
#[tokio::test(start_paused = true)]
async fn only_who_says_nothing_is_out_of_reach() {
    let asked = CancellationToken::new();
    let asks = asked.clone();
    let full = liar(usize::MAX, move |_| {
        asks.cancel();
        Err(Status::resource_exhausted("full"))
    });
    assert!(!is_cut_off_within_a_minute(full, asked.cancelled()).await);
    let (silent, watch) = Liar::silent();
    assert!(is_cut_off_within_a_minute(silent, watch.begun()).await);
}

/// Whether someone at `liar` ever is, from when they have `asked` for the photograph.
async fn is_cut_off_within_a_minute(liar: Liar, asked: impl Future<Output = ()>) -> bool {
    let mut streamer = Streamer::connect(connect(liar).await, "street").await.expect("a scene");
    let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(64, 64));
    streamer.look(ViewRequest::new(view));
    asked.await;
    for _ in 0..60 {
        if streamer.client().is_cut_off() {
            return true;
        }
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
    assert!(streamer.statistics().retries > 0, "it failed again and again");
    false
}

/// What comes drop by drop comes in the end, in one piece and at one go.
#[tokio::test(start_paused = true)]
async fn a_slow_connection_is_no_silence() {
    let mut picture = jpeg(16, 16);
    // A comment that takes 25 s, each frame of it 8 s.
    let comment: Vec<u8> = [0xff, 0xfe, 0xc3, 0x52].into_iter().chain([7; 50_000]).collect();
    picture.splice(2..2, comment);
    let liar = Liar::images(move |key| vec![part(key, picture.len() as u64, 0, &picture)]);
    let outcome = stream(connect_slowly(liar, 2000).await).await;
    assert_eq!((outcome.photographs, outcome.faults.len()), (1, 0), "{outcome:?}");
    assert_eq!(outcome.statistics.retries, 0, "{outcome:?}");
}

/// Not photographs alone: whatever a server says of a scene.
#[tokio::test(start_paused = true)]
async fn what_makes_no_sense_is_had_from_another() {
    for liar in [
        Liar { panorama_x: f64::NAN, ..Liar::honest() },
        Liar { scene_max_x: f64::NAN, ..Liar::honest() },
    ] {
        let outcome = stream(vec![connect(liar).await, connect(Liar::honest()).await]).await;
        assert_eq!((outcome.photographs, outcome.faults.len()), (1, 0), "{outcome:?}");
        assert_eq!(outcome.statistics.failovers, 1, "{outcome:?}");
    }
}
