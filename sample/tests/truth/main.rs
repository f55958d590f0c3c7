//! What the sample says about itself agrees with what it shows.

mod survey;

use std::collections::HashMap;

use flaneur_sample::{Class, RANGE_SIGMA_M, read_depths};
use glam::{DVec2, DVec3};
use survey::{Photograph, Point, json, number, numbers, path};

/// Points fall on pixels of their own class: through poses, calibration and distortion for
/// the rig, through the list of poses for the spheres.
///
/// Away from edges between classes this holds but for points behind something that the
/// points nearby do not show. Within a pixel of an edge it only holds for the most part,
/// but there it is sharp: a rig without its boresight of 0.7° (two pixels) or without its
/// distortion falls below the limit for edges.
#[test]
fn points_reproject_onto_their_own_class() {
    let points = survey::points();
    let (rig, spheres) = (survey::rig_photographs(), survey::spheres());
    assert!(rig.len() == 15 && spheres.len() == 2);
    for (kind, photographs, least) in [("rig", rig, 0.975), ("spheres", spheres, 0.955)] {
        let mut inside = Count::default();
        let mut edge = Count::default();
        for photograph in &photographs {
            agreement(photograph, &points, &mut inside, &mut edge);
        }
        println!("{kind}: {inside:?} {:.4}, at edges {edge:?} {:.4}", inside.share(), edge.share());
        assert!(inside.all > 10_000 && inside.share() > 0.995, "{kind}: {inside:?}");
        assert!(edge.all > 1000 && edge.share() > least, "{kind}, at edges: {edge:?}");
    }
}

/// How many points were looked at, and for how many the class was right.
#[derive(Debug, Default)]
struct Count {
    right: u32,
    all: u32,
}

impl Count {
    fn add(&mut self, right: bool) {
        self.all += 1;
        self.right += u32::from(right);
    }

    fn share(&self) -> f64 {
        f64::from(self.right) / f64::from(self.all)
    }
}

/// Compares the points that nothing hides, as far as other points tell, with their pixels:
/// those away from any edge between classes, and those near one. Leaves, which are all
/// edges, only count away from them.
fn agreement(photograph: &Photograph, points: &[Point], inside: &mut Count, edge: &mut Count) {
    let cell = |pixel: DVec2| (pixel / 5.0).floor().as_ivec2();
    let mut nearest: HashMap<_, f64> = HashMap::new();
    let mut seen = Vec::new();
    for point in points {
        if let Some((pixel, depth)) = photograph.project(point.position) {
            let entry = nearest.entry(cell(pixel)).or_insert(depth);
            *entry = entry.min(depth);
            seen.push((point, pixel, depth));
        }
    }
    for (point, pixel, depth) in seen {
        let hidden = (-1..=1).any(|dy| {
            (-1..=1).any(|dx| {
                let beside = cell(pixel) + glam::IVec2::new(dx, dy);
                nearest.get(&beside).is_some_and(|&front| depth > 1.03 * front + 0.3)
            })
        });
        let Some(class) = photograph.class_at(pixel) else { continue };
        if hidden || matches!(class, Class::OwnVehicle | Class::NoData) {
            continue;
        }
        let right = class.las() == Some(point.class);
        match photograph.class_around(pixel) {
            Some(_) => inside.add(right),
            None if point.class != 5 && class != Class::Vegetation => edge.add(right),
            None => {}
        }
    }
}

/// Depth images hold the metres along the axis at which lidar finds the same surfaces.
#[test]
fn depths_of_views_agree_with_the_points() {
    let points = survey::points();
    let mut compared = 0;
    for (view, entry) in survey::views() {
        let file = format!("truth/{}", entry["depth"].as_str().expect("a name"));
        let (size, depths) = read_depths(&path(&file)).expect("depths");
        assert_eq!(size, view.size);
        let sky = Class::Sky.id();
        for (label, depth) in view.labels.iter().zip(&depths) {
            assert_eq!(*label == sky, depth.is_infinite(), "sky alone is infinitely far");
        }
        let mut near = 0;
        let mut total = 0;
        for point in &points {
            let Some((pixel, depth)) = view.project(point.position) else { continue };
            let Some(class) = view.class_around(pixel) else { continue };
            let index = view.index(pixel).expect("in the image");
            let truth = f64::from(depths[index]);
            // Points of what hides the pixel's surface, or is hidden by it, are others.
            if class.las() != Some(point.class) || (depth - truth).abs() > 0.5 {
                continue;
            }
            total += 1;
            // Range noise, and the slope of a surface across half a pixel.
            let slack = 4.0 * RANGE_SIGMA_M + 0.02 * truth;
            near += u32::from((depth - truth).abs() < slack);
        }
        println!("{}: {near} of {total}", view.name);
        assert!(near * 100 >= total * 90, "{}: {near} of {total} agree", view.name);
        compared += total;
    }
    assert!(compared > 10_000, "the views see points: {compared}");
}

/// Views are as far from the nearest photograph as they say, at the distances in turn.
#[test]
fn views_are_as_far_from_photographs_as_they_say() {
    let centres: Vec<DVec3> = survey::rig_photographs()
        .iter()
        .chain(&survey::spheres())
        .map(|photograph| photograph.centre)
        .collect();
    let views = survey::views();
    assert!(views.len() >= 4, "room for most of the distances: {}", views.len());
    for (view, entry) in views {
        let nearest = centres.iter().map(|c| c.distance(view.centre)).fold(f64::INFINITY, f64::min);
        let stated = number(&entry["nearest_m"]);
        assert!((nearest - stated).abs() < 1e-6, "{}: {nearest} {stated}", view.name);
        let planned = [0.5, 1.0, 2.0, 4.0, 8.0].iter().any(|d| (d - stated).abs() < 2e-3);
        assert!(planned, "{}: {stated}", view.name);
    }
}

/// The real facades, as lidar sees them, stand as far from the footprints as
/// `truth/buildings.json` says, and no farther than `street.toml` allows.
#[test]
fn footprints_are_off_by_what_the_truth_says() {
    let points = survey::points();
    let footprints = json("footprints.geojson");
    let truth = json("truth/buildings.json");
    let uncertainty =
        survey::description()["footprints"][0]["uncertainty_m"].as_float().expect("a number");
    let (mut measured, mut largest) = (0, 0f64);
    for (feature, truth) in
        footprints["features"].as_array().expect("features").iter().zip(truth.as_array().unwrap())
    {
        assert_eq!(feature["id"], truth["id"]);
        let ring = feature["geometry"]["coordinates"][0].as_array().expect("a ring");
        let corner = |i: usize| DVec2::from_array(numbers(&ring[i]));
        let (left, right) = (corner(0), corner(3));
        let along = (right - left).normalize();
        let out = (left - corner(1)).normalize();
        let base = number(&truth["base_m"]);
        // A histogram of distances in front of the outline, in centimetres: the wall is
        // where most points are, windows and mouldings are elsewhere.
        let mut histogram = [0u32; 200];
        for point in points.iter().filter(|point| point.class == 6) {
            let d = point.position.truncate() - left;
            let (a, o) = (d.dot(along), d.dot(out));
            let on_front = a > 0.4 && a < left.distance(right) - 0.4;
            let up = point.position.z - base;
            if on_front && (4.5..10.0).contains(&up) && o.abs() < 0.99 {
                histogram[(100.0 * (o + 1.0)) as usize] += 1;
            }
        }
        let smoothed: Vec<u32> = histogram.windows(5).map(|bins| bins.iter().sum()).collect();
        if histogram.iter().sum::<u32>() < 1500 {
            continue;
        }
        let peak = (0..smoothed.len()).max_by_key(|&i| smoothed[i]).expect("bins");
        let found = (peak as f64 + 2.5) / 100.0 - 1.0;
        let stated = number(&truth["facade_offset_m"]);
        println!("{}: {found:.2} {stated:.3}", truth["id"]);
        // Two bins of the histogram.
        assert!((found - stated).abs() < 0.025, "{}: {found} {stated}", truth["id"]);
        assert!(stated.abs() <= uncertainty);
        measured += 1;
        largest = largest.max(stated.abs());
    }
    assert!(measured >= 4, "facades with enough points: {measured}");
    assert!(largest > 0.15, "some footprint is off by decimetres: {largest}");
}

/// Wherever a photograph shows the own vehicle, the mask of its camera is white.
#[test]
fn masks_cover_the_vehicle() {
    let mut hidden = 0;
    for camera in json("calibration.json").as_array().expect("a list") {
        let mask = camera["mask"].as_str().map(survey::labels);
        for photograph in survey::rig_photographs() {
            if !photograph.name.starts_with(&camera["id"].to_string()) {
                continue;
            }
            for (index, label) in photograph.labels.iter().enumerate() {
                if *label != Class::OwnVehicle.id() {
                    continue;
                }
                let (mask_size, mask) = mask.as_ref().expect("a mask where the vehicle is seen");
                let width = photograph.size.x as usize;
                let pixel = DVec2::new((index % width) as f64, (index / width) as f64) + 0.5;
                let at = (pixel / photograph.size.as_dvec2() * mask_size.as_dvec2()).as_uvec2();
                assert_eq!(mask[(at.y * mask_size.x + at.x) as usize], 255, "{pixel}");
                hidden += 1;
            }
        }
    }
    assert!(hidden > 1000, "the vehicle is seen: {hidden}");
}
