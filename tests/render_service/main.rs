//! The render service of the built binary, called over gRPC.

#[path = "../served/mod.rs"]
mod served;
#[path = "../street/mod.rs"]
mod street;

mod picks;
mod refusals;
mod walker;
mod walks;

use std::ffi::OsStr;
use std::path::Path;

use flaneur_proto::v1;
use image::RgbImage;
use served::{Served, flaneur};
use street::SampleStreet;
use tonic::transport::Channel;
use v1::render_service_client::RenderServiceClient;

/// Name of the scene.
const SCENE: &str = "sample";
/// On the road, looking down the street.
const EYE: [f64; 3] = [651_489.5, 6_861_046.0, 43.4];

type Client = RenderServiceClient<Channel>;

/// Serves a store, and renders. `more` are further arguments.
fn serve(store: &Path, more: &[&str]) -> Served {
    Served::with([store.as_os_str()].into_iter().chain(more.iter().map(OsStr::new)))
}

async fn client(served: &Served) -> Client {
    let client = RenderServiceClient::connect(served.url.clone()).await.expect("it answers");
    client.max_decoding_message_size(4 << 20)
}

/// A view from the road, turned to `heading`.
fn view(heading_deg: f64) -> v1::View {
    let [x, y, z] = EYE;
    v1::View {
        eye: Some(v1::Point3 { x, y, z }),
        heading_deg,
        pitch_deg: 2.0,
        extent: Some(v1::view::Extent::FovDeg(60.0)),
        width: 320,
        height: 160,
        mode: v1::Mode::Hybrid.into(),
        may_shrink: false,
    }
}

/// Without loss.
fn exact() -> v1::Quality {
    v1::Quality { encoding: v1::Encoding::Png.into(), ..v1::Quality::default() }
}

fn still(heading_deg: f64) -> v1::RenderFrameRequest {
    v1::RenderFrameRequest {
        scene: SCENE.to_owned(),
        view: Some(view(heading_deg)),
        quality: Some(exact()),
    }
}

fn decoded(frame: &v1::Frame) -> RgbImage {
    image::load_from_memory(&frame.image).expect("a picture").into_rgb8()
}

/// The largest difference of two pictures, 0 to 255.
fn difference(a: &RgbImage, b: &RgbImage) -> u8 {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// The mean difference of two pictures, 0 to 255.
fn mean_difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    let sum: f64 = pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    sum / a.as_raw().len() as f64
}

#[tokio::test(flavor = "multi_thread")]
async fn a_still_is_what_flaneur_render_makes() {
    let street = SampleStreet::ingested("render-service-still").await;
    let served = serve(&street.store, &[]);
    let mut client = client(&served).await;
    let frame = client.render_frame(still(40.0)).await.expect("a frame").into_inner();
    assert!(frame.r#final && frame.complete && frame.fault.is_empty(), "{frame:?}");
    assert_eq!((frame.media_type.as_str(), frame.remaining), ("image/png", 0));
    assert_eq!(frame.view, Some(view(40.0)));
    assert!(frame.bytes_received > 10_000 && frame.render_ms > 0.0);
    assert!((0.01..0.9).contains(&frame.unsurveyed_share), "{}", frame.unsurveyed_share);
    assert!(frame.blank_share < frame.unsurveyed_share, "the sky is inferred: {frame:?}");

    let out = street.store.with_file_name("frame.png");
    let at = EYE.map(|metres| metres.to_string()).join(",");
    let (at, store) = (format!("{at},40,2"), street.store.join(SCENE));
    let arguments = ["render", store.to_str().expect("text"), "--view", &at, "--size", "320x160"];
    let to = ["--out", out.to_str().expect("text")];
    flaneur(arguments.iter().chain(&to).map(OsStr::new));
    let rendered = image::open(&out).expect("a picture").into_rgb8();
    assert_eq!(difference(&decoded(&frame), &rendered), 0, "the same picture");

    // Other formats, other modes, without perspective.
    let quality = |encoding: v1::Encoding| {
        Some(v1::Quality { encoding: encoding.into(), ..v1::Quality::default() })
    };
    let webp = v1::RenderFrameRequest { quality: quality(v1::Encoding::Webp), ..still(40.0) };
    let webp = client.render_frame(webp).await.expect("a frame").into_inner();
    assert_eq!(difference(&decoded(&webp), &rendered), 0);
    let jpeg = v1::RenderFrameRequest { quality: None, ..still(40.0) };
    let jpeg = client.render_frame(jpeg).await.expect("a frame").into_inner();
    assert_eq!(jpeg.media_type, "image/jpeg");
    assert!(jpeg.image.len() < frame.image.len(), "{} {}", jpeg.image.len(), frame.image.len());
    let apart = mean_difference(&decoded(&jpeg), &rendered);
    assert!(apart > 0.0 && apart < 3.0, "{apart}");
    let plan = v1::View {
        pitch_deg: -90.0,
        extent: Some(v1::view::Extent::HeightM(30.0)),
        mode: v1::Mode::Depth.into(),
        eye: Some(v1::Point3 { z: EYE[2] + 60.0, ..view(0.0).eye.expect("set") }),
        ..view(0.0)
    };
    let plan = v1::RenderFrameRequest { view: Some(plan), ..still(0.0) };
    let plan = decoded(&client.render_frame(plan).await.expect("a frame").into_inner());
    // The ground lies 60 m below, the roofs nearer.
    let greys: Vec<u8> = plan.pixels().map(|pixel| pixel.0[0]).collect();
    let (least, most) = (greys.iter().min(), greys.iter().max());
    assert!(least < most && plan.pixels().all(|p| p.0[0] == p.0[1]), "{least:?} {most:?}");
    let status = served.stop();
    assert!(status.success(), "{status}");
}

#[tokio::test(flavor = "multi_thread")]
async fn another_server_renders_what_one_serves() {
    let street = SampleStreet::ingested("render-service-remote").await;
    let data = Served::start(&[&street.store]);
    let (near, far) = (serve(&street.store, &[]), Served::with([OsStr::new(&data.url)]));
    let mut frames = Vec::new();
    for served in [&near, &far] {
        let mut client = client(served).await;
        frames.push(client.render_frame(still(130.0)).await.expect("a frame").into_inner());
    }
    assert_eq!(difference(&decoded(&frames[0]), &decoded(&frames[1])), 0);
}
