//! What the render service refuses, and what it says.

use std::ffi::OsStr;
use std::time::Duration;

use flaneur_proto::v1;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Code;
use tonic_types::StatusExt;
use v1::scene_service_client::SceneServiceClient;

use crate::served::Served;
use crate::street::SampleStreet;
use crate::walker::{Walker, update};
use crate::{SCENE, client, decoded, serve, still, view};

#[tokio::test(flavor = "multi_thread")]
async fn what_is_wrong_with_a_request_is_named() {
    let street = SampleStreet::ingested("render-service-refusals").await;
    let served = serve(&street.store, &["--max-sessions", "2", "--max-idle", "2"]);
    let mut client = client(&served).await;
    for (field, change) in [
        ("view", (|r| r.view = None) as fn(&mut v1::RenderFrameRequest)),
        ("view.width", |r| {
            let view = r.view.as_mut().expect("set");
            (view.width, view.height) = (5000, 5000);
        }),
        ("view.width", |r| {
            // As many pixels as may be, but no device has pictures as wide.
            let view = r.view.as_mut().expect("set");
            (view.width, view.height) = (20_000, 100);
        }),
        ("view.height", |r| r.view.as_mut().expect("set").height = 0),
        ("view.extent", |r| r.view.as_mut().expect("set").extent = None),
        ("view.mode", |r| r.view.as_mut().expect("set").mode = 77),
        ("view.eye.y", |r| {
            r.view.as_mut().expect("set").eye.as_mut().expect("set").y = f64::NAN;
        }),
        ("quality.jpeg_quality", |r| r.quality.as_mut().expect("set").jpeg_quality = 101),
        ("quality.encoding", |r| r.quality.as_mut().expect("set").encoding = 9),
        ("quality.frame_budget_ms", |r| r.quality.as_mut().expect("set").frame_budget_ms = -1.0),
    ] {
        let mut request = still(0.0);
        change(&mut request);
        let status = client.render_frame(request).await.expect_err(field);
        let violations = status.get_details_bad_request().expect("it names the field");
        let named = &violations.field_violations[0].field;
        assert_eq!((status.code(), named.as_str()), (Code::InvalidArgument, field), "{status}");
    }
    for (field, x, y) in [("pixel.x", 999.0, 10.0), ("pixel.y", 10.0, -0.5)] {
        let pixel = Some(v1::Point2 { x, y });
        let view = Some(view(0.0));
        let beside = v1::PickRequest { scene: SCENE.to_owned(), view, pixel, photographs: false };
        let status = client.pick(beside).await.expect_err(field);
        let violations = status.get_details_bad_request().expect("it names the field");
        assert_eq!(status.code(), Code::InvalidArgument, "{status}");
        assert_eq!(violations.field_violations[0].field, field, "{status}");
    }
    let elsewhere = v1::RenderFrameRequest { scene: "nowhere".to_owned(), ..still(0.0) };
    let status = client.render_frame(elsewhere).await.expect_err("no such scene");
    assert_eq!(status.code(), Code::NotFound, "{status}");
    assert!(status.message().contains("nowhere"), "{status}");

    let session =
        |name: &str| v1::WatchRequest { session: name.to_owned(), update: Some(update(1, 0.0)) };
    let status = client.watch(session("short")).await.expect_err("a name to be guessed");
    assert_eq!(status.code(), Code::InvalidArgument, "{status}");
    let nobody = v1::UpdateViewRequest {
        session: "0123456789abcdef".to_owned(),
        update: Some(update(1, 0.0)),
    };
    let status = client.update_view(nobody).await.expect_err("nobody watches");
    assert_eq!(status.code(), Code::NotFound, "{status}");
    assert!(status.message().contains("begin another"), "{status}");

    // Of an update, in the course of a walk.
    let mut walker = Walker::begin(&mut client, 0.0).await.expect("a walk");
    let bad = v1::View { pitch_deg: 91.0, ..view(0.0) };
    walker.send(v1::ViewUpdate { view: Some(bad), ..update(2, 0.0) }).await;
    let status = loop {
        if let Err(status) = walker.next().await {
            break status;
        }
    };
    assert_eq!(status.code(), Code::InvalidArgument, "{status}");
    assert!(status.message().contains("pitch_deg: is 91"), "{status}");

    // Two may walk, a third must wait; and who says nothing for two seconds has gone.
    let mut first = Walker::begin(&mut client, 0.0).await.expect("a walk");
    // Who has not said what to show keeps nobody out.
    let (_silent, nothing) = tokio::sync::mpsc::channel(1);
    let waiting = {
        let mut client = client.clone();
        tokio::spawn(async move { client.navigate(ReceiverStream::new(nothing)).await })
    };
    tokio::time::sleep(Duration::from_millis(200)).await;
    let second = Walker::begin(&mut client, 0.0).await.expect("another");
    assert!(!waiting.is_finished(), "it may still say what to show");
    let status = match Walker::begin(&mut client, 0.0).await {
        Err(status) => status,
        Ok(mut third) => third.next().await.expect_err("there is no place"),
    };
    assert_eq!(status.code(), Code::ResourceExhausted, "{status}");
    assert!(status.get_details_retry_info().is_some(), "{status}");
    drop(second);
    let status = loop {
        match first.next().await {
            Ok(Some(_)) => {}
            Ok(None) => panic!("it says why it ends"),
            Err(status) => break status,
        }
    };
    assert_eq!(status.code(), Code::DeadlineExceeded, "{status}");
    let status = served.stop();
    assert!(status.success(), "{status}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_that_may_shrink_is_made_as_large_as_the_server_makes() {
    let street = SampleStreet::ingested("render-service-shrinks").await;
    // A quarter of what the view wants.
    let served = serve(&street.store, &["--max-pixels", "12800", "--max-views-per-s", "3"]);
    let mut client = client(&served).await;
    let status = client.render_frame(still(40.0)).await.expect_err("too large");
    assert_eq!(status.code(), Code::InvalidArgument, "{status}");
    let may_shrink = v1::View { may_shrink: true, ..view(40.0) };
    let request = v1::RenderFrameRequest { view: Some(may_shrink), ..still(40.0) };
    let frame = client.render_frame(request).await.expect("a frame").into_inner();
    let strip = v1::View { width: u32::MAX, height: 1, ..may_shrink };
    let request = v1::RenderFrameRequest { view: Some(strip), ..still(40.0) };
    let thin = client.render_frame(request).await.expect("even that").into_inner();
    assert_eq!(thin.view, Some(v1::View { width: 8192, height: 1, ..may_shrink }));
    assert_eq!(frame.view, Some(v1::View { width: 160, height: 80, ..may_shrink }));
    assert_eq!(decoded(&frame).dimensions(), (160, 80));

    // What is asked of the view and what is asked of the picture that was made of it is the same.
    let mut found = Vec::new();
    for (view, x, y) in [(may_shrink, 101.0, 121.0), (frame.view.expect("set"), 50.5, 60.5)] {
        let (view, pixel) = (Some(view), Some(v1::Point2 { x, y }));
        let request = v1::PickRequest { scene: SCENE.to_owned(), view, pixel, photographs: false };
        let place = client.pick(request).await.expect("a pick").into_inner().place;
        found.push(place.expect("the road").position.expect("set"));
    }
    assert_eq!(found[0], found[1]);
    let status = served.stop();
    assert!(status.success(), "{status}");
}

#[tokio::test(flavor = "multi_thread")]
async fn without_a_driver_the_data_are_served_and_the_remedy_is_named() {
    let street = SampleStreet::ingested("render-service-no-driver").await;
    let mut command = Served::command([
        street.store.as_os_str(),
        OsStr::new("--listen"),
        OsStr::new("127.0.0.1:0"),
    ]);
    // A driver that is not there hides those that are.
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        command.env(variable, street.store.join("no-driver.json"));
    }
    let served = Served::run(&mut command);
    let status = client(&served).await.render_frame(still(0.0)).await.expect_err("no driver");
    assert_eq!(status.code(), Code::Unavailable, "{status}");
    assert!(status.message().contains("mesa-vulkan-drivers"), "{status}");
    let mut scenes = SceneServiceClient::connect(served.url.clone()).await.expect("it answers");
    let listed = scenes.list_scenes(v1::ListScenesRequest {}).await.expect("data").into_inner();
    assert_eq!(listed.scenes.len(), 1);

    let data = Served::start(&[&street.store]);
    let status = client(&data).await.render_frame(still(0.0)).await.expect_err("data alone");
    assert_eq!(status.code(), Code::Unimplemented, "{status}");
}
