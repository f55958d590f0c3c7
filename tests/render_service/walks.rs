//! Walks: order, echo, finality, and several at once.

use std::time::Duration;

use flaneur_proto::v1;
use tonic::Code;

use crate::street::SampleStreet;
use crate::walker::{Walker, update};
use crate::{client, decoded, difference, serve, still, view};

#[tokio::test(flavor = "multi_thread")]
async fn frames_come_in_order_and_the_last_is_final() {
    let street = SampleStreet::ingested("render-service-walk").await;
    let served = serve(&street.store, &[]);
    let mut client = client(&served).await;
    let mut walker = Walker::begin(&mut client, 40.0).await.expect("a walk");
    let mut last_number = 0;
    for heading_deg in [40.0, 75.0, 110.0] {
        if heading_deg > 40.0 {
            walker.turn(heading_deg).await;
        }
        let frames = walker.settle().await;
        for frame in &frames {
            assert_eq!(frame.number, last_number + 1, "no frame is left out");
            last_number = frame.number;
            assert_eq!(frame.view, Some(view(heading_deg)), "each says what it shows");
            assert_eq!(frame.sequence, walker.sequence);
            assert!(frame.latency_ms >= frame.render_ms && frame.fault.is_empty(), "{frame:?}");
        }
        let finals = frames.iter().filter(|frame| frame.r#final).count();
        assert_eq!(finals, 1, "and nothing comes after it");
        let bytes = |frame: &v1::Frame| frame.bytes_received;
        assert!(frames.is_sorted_by_key(bytes), "what was received is not given back");
        // As exact as what is waited for.
        let end = frames.last().expect("one at least");
        let still = client.render_frame(still(heading_deg)).await.expect("a frame").into_inner();
        assert!(end.complete && end.remaining == 0, "{end:?}");
        let apart = difference(&decoded(end), &decoded(&still));
        // Who walks holds more than the view alone asks for.
        assert!(apart <= 40, "{apart}");
    }
    // Nothing moves: nothing comes.
    let more = tokio::time::timeout(Duration::from_millis(500), walker.next()).await;
    assert!(more.is_err(), "{more:?}");
    let rest = walker.end().await.expect("a good end");
    assert!(rest.is_empty(), "the last frame was final");

    // Who says no more gets what is still to come, though they acknowledge nothing any more.
    let mut walker = Walker::begin(&mut client, 10.0).await.expect("a walk");
    walker.settle().await;
    walker.turn(200.0).await;
    let rest = walker.end().await.expect("a good end");
    assert!(rest.last().is_some_and(|frame| frame.r#final && frame.sequence == 2), "{rest:?}");

    // A server that is told to stop tells those who walk.
    let mut walker = Walker::begin(&mut client, 40.0).await.expect("a walk");
    walker.settle().await;
    served.signal("-TERM");
    let status = walker.next().await.expect_err("it ends");
    assert_eq!(status.code(), Code::Unavailable, "{status}");
    let status = served.ended();
    assert!(status.success(), "{status}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_new_view_supersedes_the_old_ones() {
    let street = SampleStreet::ingested("render-service-latest").await;
    let served = serve(&street.store, &[]);
    let mut client = client(&served).await;
    let mut walker = Walker::begin(&mut client, 0.0).await.expect("a walk");
    walker.settle().await;
    for step in 1..=60 {
        walker.turn(f64::from(step)).await;
    }
    let frames = walker.settle().await;
    assert!(frames.is_sorted_by_key(|frame| frame.sequence), "never back");
    assert!(frames.len() < 30, "{} frames of 60 views that came at once", frames.len());
    let end = frames.last().expect("one at least");
    assert_eq!((end.sequence, end.view), (61, Some(view(60.0))));

    // A view that is older than the last changes nothing.
    walker.send(update(7, 180.0)).await;
    walker.turn(61.0).await;
    assert!(walker.settle().await.iter().all(|frame| frame.sequence >= 61));
}

#[tokio::test(flavor = "multi_thread")]
async fn of_views_that_come_too_fast_the_latest_is_shown() {
    let street = SampleStreet::ingested("render-service-rate").await;
    let served = serve(&street.store, &["--max-views-per-s", "2"]);
    let mut client = client(&served).await;
    let mut walker = Walker::begin(&mut client, 0.0).await.expect("a walk");
    // Nothing is acknowledged, which would be an update, too.
    while !walker.next().await.expect("a frame").expect("more").r#final {}
    for step in 1..=40 {
        walker.turn(f64::from(step)).await;
    }
    let frames = walker.end().await.expect("a good end");
    let end = frames.last().expect("one at least");
    assert!(end.r#final, "{end:?}");
    assert_eq!(
        (end.sequence, end.view),
        (41, Some(view(40.0))),
        "said last, though nobody listens"
    );
    let mut shown: Vec<u64> = frames.iter().map(|frame| frame.sequence).collect();
    shown.dedup();
    // A second's worth at once, then the latest; one more where the sender was held up.
    assert!(shown.len() <= 4, "{shown:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn who_takes_nothing_keeps_nobody_waiting() {
    let street = SampleStreet::ingested("render-service-slow").await;
    let served = serve(&street.store, &[]);
    let (mut slow_client, mut client) = (client(&served).await, client(&served).await);
    // Never reads, never acknowledges, and moves all the time.
    let mut slow = Walker::begin(&mut slow_client, 200.0).await.expect("a walk");
    let mut walker = Walker::begin(&mut client, 40.0).await.expect("a walk");
    walker.settle().await;
    for step in 1..10 {
        slow.turn(200.0 + f64::from(step)).await;
        walker.turn(40.0 + f64::from(step)).await;
        let frames = walker.settle().await;
        assert!(frames.len() < 30, "{}", frames.len());
    }
    // Its own view is there once it looks.
    let frames = slow.settle().await;
    assert_eq!(frames.last().map(|frame| frame.sequence), Some(slow.sequence));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_is_watched_by_one_and_steered_by_who_knows_its_name() {
    let street = SampleStreet::ingested("render-service-watch").await;
    let served = serve(&street.store, &["--max-sessions", "1"]);
    let mut client = client(&served).await;
    let session = "a-name-nobody-guesses".to_owned();
    let watch = |sequence, heading_deg| v1::WatchRequest {
        session: session.clone(),
        update: Some(update(sequence, heading_deg)),
    };
    let steer = |update| v1::UpdateViewRequest { session: session.clone(), update: Some(update) };
    let mut frames = client.watch(watch(1, 40.0)).await.expect("a session").into_inner();
    let mut sequence = 1;
    loop {
        let frame = frames.message().await.expect("a frame").expect("more");
        let received_frame = frame.number;
        let mut answer = v1::ViewUpdate { received_frame, ..v1::ViewUpdate::default() };
        if frame.r#final {
            if sequence == 3 {
                break;
            }
            sequence += 1;
            answer = v1::ViewUpdate { received_frame, ..update(sequence, 40.0 * sequence as f64) };
        }
        client.update_view(steer(answer)).await.expect("it is watched");
    }
    // Watched again, the first ends, and gives its place, the only one, to the second.
    let mut again = client.watch(watch(9, 10.0)).await.expect("a session").into_inner();
    let ended = loop {
        match frames.message().await {
            Ok(Some(_)) => {}
            Ok(None) => panic!("it says why it ends"),
            Err(status) => break status,
        }
    };
    assert_eq!(ended.code(), Code::Aborted, "{ended}");
    let frame = again.message().await.expect("a frame").expect("more");
    assert_eq!((frame.number, frame.sequence), (1, 9));
    client.update_view(steer(update(10, 11.0))).await.expect("the second is steered");
    drop(again);
    // The session ends with its stream, as soon as the server notices.
    let ended = async {
        while client.clone().update_view(steer(update(11, 12.0))).await.is_ok() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        client.clone().update_view(steer(update(12, 13.0))).await.expect_err("it has ended")
    };
    let ended = tokio::time::timeout(Duration::from_secs(20), ended).await.expect("soon");
    assert_eq!(ended.code(), Code::NotFound, "{ended}");
}
