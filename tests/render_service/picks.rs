//! What a click finds, against the survey's own files.

use std::path::Path;

use flaneur_proto::v1;
use glam::DVec3;
use las::Reader;
use tonic::Request;
use tonic::metadata::MetadataValue;

use crate::street::SampleStreet;
use crate::walker::update;
use crate::{Client, SCENE, client, serve, view};

/// Whose pick it is.
const SESSION: &str = "someone-who-clicks-about";

async fn pick(
    client: &mut Client,
    session: Option<&'static str>,
    heading_deg: f64,
    (x, y): (f64, f64),
) -> Option<v1::Place> {
    let mut request = Request::new(v1::PickRequest {
        scene: SCENE.to_owned(),
        view: Some(view(heading_deg)),
        pixel: Some(v1::Point2 { x, y }),
        photographs: true,
    });
    if let Some(session) = session {
        let name = MetadataValue::from_static(session);
        request.metadata_mut().insert("flaneur-session", name);
    }
    client.pick(request).await.expect("a pick").into_inner().place
}

/// Every point of the survey, in whole millimetres.
fn surveyed(survey: &Path) -> std::collections::HashSet<[i64; 3]> {
    let files = std::fs::read_dir(survey).expect("a folder");
    let files = files.map(|file| file.expect("an entry").path());
    let mut points = std::collections::HashSet::new();
    for file in files.filter(|path| path.extension().is_some_and(|e| e == "laz")) {
        let mut reader = Reader::from_path(file).expect("a LAZ file");
        let all = reader.read_points(u64::MAX).expect("points");
        for point in all.points() {
            let point = point.expect("a point");
            points.insert(millimetres(DVec3::new(point.x, point.y, point.z)));
        }
    }
    points
}

fn millimetres(p: DVec3) -> [i64; 3] {
    p.to_array().map(|metres| (metres * 1e3).round() as i64)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_click_finds_what_was_surveyed_there() {
    let street = SampleStreet::ingested("render-service-pick").await;
    let points = surveyed(&street.survey);
    let served = serve(&street.store, &[]);
    let mut client = client(&served).await;
    let (mut of_points, mut of_mesh, mut seen, mut coloured, mut nothing) = (0, 0, 0, 0, 0);
    for heading_deg in [40.0, 130.0] {
        // Someone who walks, and looks at what is there.
        let update = Some(update(1, heading_deg));
        let watch = v1::WatchRequest { session: SESSION.to_owned(), update };
        let mut frames = client.watch(watch).await.expect("a session").into_inner();
        while !frames.message().await.expect("a frame").expect("more").r#final {}
        // Anyone else finds the same, though nothing is loaded for them.
        let at = (160.5, 120.5);
        let (theirs, own) = (
            pick(&mut client, None, heading_deg, at).await.expect("the road"),
            pick(&mut client, Some(SESSION), heading_deg, at).await.expect("the road"),
        );
        let apart_m = DVec3::try_from(theirs.position.expect("set"))
            .expect("finite")
            .distance(DVec3::try_from(own.position.expect("set")).expect("finite"));
        assert!(apart_m < 0.05, "{apart_m}");
        for (x, y) in (0..6).flat_map(|i| (0..5).map(move |j| (f64::from(i), f64::from(j)))) {
            let (x, y) = (20.5 + 53.0 * x, 10.5 + 33.0 * y);
            let Some(place) = pick(&mut client, Some(SESSION), heading_deg, (x, y)).await else {
                nothing += 1;
                continue;
            };
            let position = DVec3::try_from(place.position.expect("set")).expect("finite");
            let eye = DVec3::from_array(crate::EYE);
            assert!((position.distance(eye) - place.distance_m).abs() < 1e-6);
            let on_earth = place.geographic.expect("Lambert-93 is");
            assert!((48.0..49.5).contains(&on_earth.latitude_deg), "{on_earth:?}");
            assert!((2.0..3.0).contains(&on_earth.longitude_deg), "{on_earth:?}");
            match place.surface.expect("something was surveyed") {
                v1::place::Surface::Point(point) => {
                    let at = DVec3::try_from(point.position.expect("set")).expect("finite");
                    assert!(points.contains(&millimetres(at)), "{at} is no point of the survey");
                    assert!(at.distance(position) < 1.0, "{at} {position}");
                    // The drive was on a morning of May; its files count adjusted seconds.
                    assert_eq!(point.gps_time_kind(), v1::GpsTimeKind::Adjusted);
                    assert!((point.gps_time - 399_712_818.0).abs() < 600.0, "{point:?}");
                    assert!(point.time.starts_with("2024-05-14T09:0"), "{point:?}");
                    of_points += 1;
                }
                v1::place::Surface::Mesh(mesh) => {
                    let is_ground = mesh.class == i32::from(v1::mesh_surface::Class::Ground);
                    assert_eq!(mesh.footprint.is_empty(), is_ground, "{mesh:?} at {position}");
                    of_mesh += 1;
                }
            }
            let shares: f64 = place.photographs.iter().map(|sight| sight.share).sum();
            // None where those that see it see its back, or are not among the nearest.
            assert!(shares == 0.0 || (shares - 1.0).abs() < 1e-6, "{shares}");
            coloured += u32::from(shares > 0.0);
            for sight in &place.photographs {
                assert!(!sight.time.is_empty(), "the sample says when");
                seen += 1;
            }
        }
    }
    println!("{of_points} points, {of_mesh} of mesh, {nothing} of nothing, {coloured} coloured");
    assert!(of_points > 5 && of_mesh > 5 && seen > 30 && coloured > 20, "{seen}");
}
