//! A painter at work, without a window.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, channel};

use flaneur_sample::{SampleOptions, write_street};
use flaneur_services::ingest::street::Street;
use flaneur_services::ingest::{IngestOptions, Job, ingest};
use flaneur_services::store::Store;
use flaneur_streamer::StreamOptions;
use glam::DVec3;

use super::*;
use crate::commands::view::place::{Place, PlaceKind};
use crate::commands::view::pose::Pose;

/// How long a frame may take.
const PATIENCE: Duration = Duration::from_secs(60);
const SIZE: UVec2 = UVec2::new(160, 96);

/// A street of its own for each seed, opened.
async fn opened(folder: &Path, seed: u64) -> Opened {
    let (survey, store) = (folder.join(format!("{seed}")), folder.join(format!("{seed}-store")));
    write_street(&survey, &SampleOptions::tiny(seed), &|_| {}, &AtomicBool::new(false))
        .expect("a street");
    let survey = Street::open(&survey, false).expect("the sample's own format");
    let to = Store::open(store.to_str().expect("text")).expect("a folder");
    let job = Arc::new(Job::new(folder.join("work"), 1 << 30));
    ingest(survey, to, IngestOptions::default(), job).await.expect("a sound survey");
    let text = store.to_str().expect("text");
    Opened::open(text, StreamOptions::default(), 1.0).await.expect("a scene")
}

/// The final frame of what was wished for last, and how many came before it.
fn final_frame(news: &Receiver<News>, wish: &Wish) -> (Box<Shown>, usize) {
    for earlier in 0.. {
        match news.recv_timeout(PATIENCE).expect("a frame") {
            News::Frame(shown) if shown.is_final && shown.view == wish.view => {
                return (shown, earlier);
            }
            News::Frame(_) => {}
            News::Fault(fault) => panic!("{fault}"),
            News::Failed(exit) => panic!("{}", exit.message()),
            News::Picked(..) => panic!("nobody clicks"),
        }
    }
    unreachable!("frames do not end")
}

#[tokio::test(flavor = "multi_thread")]
async fn a_painter_shows_one_scene_and_then_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let (first, second) = (opened(folder.path(), 7).await, opened(folder.path(), 8).await);
    let (start, other) = (first.start, second.start);
    let options = PaintOptions {
        settings: Settings::default(),
        limits: FetchLimits::default(),
        budget: Duration::from_millis(50),
    };
    let (sender, news) = channel();
    let gpu = tokio::task::spawn_blocking(Gpu::new).await.expect("no panic").expect("a driver");
    let painter = Painter::start(gpu, first, options, move |news| drop(sender.send(news)));
    let painter = painter.expect("a thread");
    tokio::task::block_in_place(|| {
        let wish = |pose: &Pose, moving| Wish { view: pose.view(SIZE), mode: Mode::Hybrid, moving };
        // Who moves is shown what is there; only who stands, the whole.
        painter.wish(wish(&start.turned(0.5, 0.0), true));
        let News::Frame(moving) = news.recv_timeout(PATIENCE).expect("a frame") else {
            panic!("a frame comes first");
        };
        assert!(!moving.is_final && moving.view == start.turned(0.5, 0.0).view(SIZE));
        painter.wish(wish(&start, false));
        let (shown, _) = final_frame(&news, &wish(&start, false));
        assert_eq!((shown.size, shown.rgba.len()), (SIZE, 4 * 160 * 96));
        assert!(shown.remaining == 0 && shown.stats.coverage() > 0.5, "{:?}", shown.stats);
        assert!(news.recv_timeout(Duration::from_millis(300)).is_err(), "then nothing more");

        // The road is under one's feet, and a click on it says so.
        let down = start.turned(0.0, -1.0).view(SIZE);
        let click = Click { view: down, pixel: SIZE.as_dvec2() / 2.0, purpose: Purpose::Go };
        painter.order(Order::Pick(Box::new(click)));
        let picked = std::iter::from_fn(|| news.recv_timeout(PATIENCE).ok())
            .find_map(|news| if let News::Picked(_, found) = news { found } else { None });
        let found = picked.expect("the road");
        let place = Place::met(&down, &found.picked);
        let road = painter.ground().height(place.position.truncate()).expect("known by now");
        assert_eq!(place.kind(Some(road)), PlaceKind::Ground);
        assert!((place.position.z - road).abs() < 0.3, "{place:?} {road}");

        painter.order(Order::Open(Box::new(second)));
        painter.wish(wish(&other, false));
        let (elsewhere, _) = final_frame(&news, &wish(&other, false));
        assert!(elsewhere.stats.coverage() > 0.5, "{:?}", elsewhere.stats);
        assert_ne!(elsewhere.rgba, shown.rgba);
        let far = other.eye + DVec3::X * 1e4;
        assert_eq!(painter.ground().height(far.truncate()), None);
    });
}
