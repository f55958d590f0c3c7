//! A service that lies: whatever it sends, the client says what is wrong and stops.

mod liar;

use std::time::Duration;

use flaneur_proto::v1;
use flaneur_scene::View;
use flaneur_streamer::{Event, StreamError, Streamer, ViewRequest};
use futures::StreamExt;
use glam::{DVec3, UVec2};
use liar::{Liar, connect, jpeg, part};
use tokio_util::sync::CancellationToken;

/// The error with which streaming a view from `liar` ends.
async fn outcome(liar: Liar) -> StreamError {
    let mut streamer = Streamer::connect(connect(liar).await, "street").await.expect("a scene");
    let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(64, 64));
    let mut events = streamer.stream(ViewRequest::new(view), &CancellationToken::new());
    loop {
        match events.next().await {
            Some(Ok(_)) => {}
            Some(Err(error)) => return error,
            None => panic!("it was believed"),
        }
    }
}

/// The field that is at fault in what `liar` sends.
async fn bad_field(liar: Liar) -> String {
    match outcome(liar).await {
        StreamError::BadMessage { source, .. } => source.field,
        other => panic!("{other}"),
    }
}

/// What is damaged of what `liar` sends, and how.
async fn damage(liar: Liar) -> String {
    match outcome(liar).await {
        StreamError::Damaged { what, problem } => format!("{what}: {problem}"),
        other => panic!("{other}"),
    }
}

#[tokio::test]
async fn parts_that_do_not_fit_together_are_refused() {
    // More than any memory holds.
    assert_eq!(
        bad_field(Liar::images(|key| vec![part(key, 1 << 60, 0, b"x")])).await,
        "total_bytes"
    );
    // A part of something else.
    let other = |key: v1::ImageKey| vec![part(v1::ImageKey { level: 9, ..key }, 4, 0, b"abcd")];
    assert_eq!(bad_field(Liar::images(other)).await, "key");
    // A gap.
    let gap = |key: v1::ImageKey| vec![part(key.clone(), 8, 0, b"abcd"), part(key, 8, 5, b"ef")];
    assert_eq!(bad_field(Liar::images(gap)).await, "offset");
    // The end comes too early.
    assert_eq!(bad_field(Liar::images(|key| vec![part(key, 8, 0, b"abcd")])).await, "data");
    assert_eq!(bad_field(Liar::images(|_| Vec::new())).await, "data");
}

#[tokio::test]
async fn pictures_that_are_none_are_damage() {
    let garbage = damage(Liar::images(|key| vec![part(key, 4, 0, b"abcd")])).await;
    assert!(garbage.starts_with("photograph p/c at level 0"), "{garbage}");
    let picture = jpeg(32, 8);
    let size =
        damage(Liar::images(move |key| vec![part(key, picture.len() as u64, 0, &picture)])).await;
    assert!(size.contains("[32, 8]") && size.contains("[16, 16]"), "{size}");
    // A header that claims 60 000² pixels, of which no memory is taken.
    let mut huge = jpeg(16, 16);
    let frame = huge.windows(2).position(|w| w == [0xff, 0xc0]).expect("a frame header");
    huge[frame + 5..frame + 9].copy_from_slice(&[0xea, 0x60, 0xea, 0x60]);
    let size = damage(Liar::images(move |key| vec![part(key, huge.len() as u64, 0, &huge)])).await;
    assert!(size.contains("60000"), "{size}");
}

/// What came is not what was announced: it is asked for once more, and then said.
#[tokio::test]
async fn another_checksum_is_damage() {
    let mut liar = Liar::honest();
    liar.announced.crc32 ^= 1;
    let problem = damage(liar).await;
    assert!(problem.starts_with("photograph p/c at level 0"), "{problem}");
    assert!(problem.contains("checksum"), "{problem}");
}

#[tokio::test]
async fn scenes_and_panoramas_out_of_range_name_their_field() {
    let nan = Liar { panorama_x: f64::NAN, ..Liar::honest() };
    assert!(bad_field(nan).await.contains("position"));
    let bounds = Liar { scene_max_x: f64::NAN, ..Liar::honest() };
    match Streamer::connect(connect(bounds).await, "street").await.expect_err("no bounds") {
        StreamError::BadMessage { call, source } => {
            assert_eq!(call, "GetScene");
            assert!(source.field.starts_with("bounds"), "{source}");
        }
        other => panic!("{other}"),
    }
}

/// A service that never answers: cancelling ends the stream, and the service is told.
#[tokio::test]
async fn cancelling_reaches_the_service() {
    let (liar, dropped) = Liar::silent();
    let mut streamer = Streamer::connect(connect(liar).await, "street").await.expect("a scene");
    let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::new(64, 64));
    let cancel = CancellationToken::new();
    let mut events = streamer.stream(ViewRequest::new(view), &cancel);
    let begun = dropped.begun();
    tokio::pin!(begun);
    loop {
        tokio::select! {
            () = &mut begun => break,
            event = events.next() => assert!(matches!(event, Some(Ok(_))), "{event:?}"),
        }
    }
    cancel.cancel();
    loop {
        match events.next().await {
            Some(Ok(_)) => {}
            Some(Err(error)) => break assert!(matches!(error, StreamError::Cancelled), "{error}"),
            None => panic!("an error comes before the end"),
        }
    }
    // The service drops its answer once the client has gone; a minute is for a busy machine.
    tokio::time::timeout(Duration::from_secs(60), dropped.ended()).await.expect("it is told");
}

/// The same where someone looks elsewhere: what nobody wants any more is ended on the wire, and counted.
#[tokio::test]
async fn another_view_ends_what_it_makes_useless() {
    let (liar, dropped) = Liar::silent();
    let mut streamer = Streamer::connect(connect(liar).await, "street").await.expect("a scene");
    let at = |x: f64| {
        let eye = DVec3::new(x, 0.0, 0.0);
        ViewRequest::new(View::look(eye, 0.0, 0.0, 1.0, UVec2::new(64, 64)))
    };
    streamer.look(at(0.0));
    let begun = dropped.begun();
    tokio::pin!(begun);
    loop {
        tokio::select! {
            () = &mut begun => break,
            _ = streamer.next() => {}
        }
    }
    assert_eq!(streamer.statistics().cancelled, 0);
    let elsewhere = streamer.look(at(1e5));
    loop {
        match streamer.next().await {
            Event::Progress(progress) if progress.view == elsewhere && progress.finished => break,
            Event::Progress(_) => {}
            other => panic!("there is nothing: {other:?}"),
        }
    }
    assert!(streamer.statistics().cancelled >= 1, "{:?}", streamer.statistics());
    tokio::time::timeout(Duration::from_secs(60), dropped.ended()).await.expect("it is told");
}
