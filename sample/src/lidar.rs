//! The simulated lidar: a slanted line scanner on the survey vehicle, streamed to LAZ.
//!
//! The scanner turns about an axis along the drive, leaned so that its scan lines cut
//! facades at an angle and see into recesses. Lines are traced in batches, in parallel,
//! and written in order: memory is bounded by the batch, not by the number of points.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DMat3, DVec3};
use las::point::Classification;
use las::{
    Builder, GpsTimeType, Header, Point, PointData, PointDataBuilder, Transform, Vector, Vlr,
    Writer,
};
use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;

use crate::SampleError;
use crate::frame::StreetFrame;
use crate::geometry::Ray;
use crate::look::Material;
use crate::street::{Purpose, Street, random};

/// Standard deviation of the ranges, metres.
pub const RANGE_SIGMA_M: f64 = 0.012;
/// Farthest return.
const RANGE_M: f64 = 90.0;
const SCANNER_HEIGHT_M: f64 = 2.05;
/// Speed of the vehicle, metres a second, and when it began, in adjusted GPS seconds.
const SPEED_M_S: f64 = 4.2;
const START_GPS_S: f64 = 399_712_818.0;
/// Points a file at most.
const FILE_POINTS: u64 = 4_000_000;
/// Pulses that a batch of scan lines holds, nearly.
const BATCH_PULSES: u64 = 1 << 20;
/// The coordinate system of [`StreetFrame::PLACE`], as LAS 1.4 wants it.
const LAMBERT_93: &str = concat!(
    r#"PROJCS["RGF93 / Lambert-93",GEOGCS["RGF93",DATUM["Reseau_Geodesique_Francais_1993","#,
    r#"SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],"#,
    r#"UNIT["degree",0.0174532925199433]],PROJECTION["Lambert_Conformal_Conic_2SP"],"#,
    r#"PARAMETER["standard_parallel_1",49],PARAMETER["standard_parallel_2",44],"#,
    r#"PARAMETER["latitude_of_origin",46.5],PARAMETER["central_meridian",3],"#,
    r#"PARAMETER["false_easting",700000],PARAMETER["false_northing",6600000],"#,
    r#"UNIT["metre",1],AUTHORITY["EPSG","2154"]]"#
);

/// How the drive is cut into pulses.
#[derive(Clone, Copy, Debug)]
struct Plan {
    lines: u64,
    pulses_per_line: u64,
    start_m: f64,
    end_m: f64,
}

/// Writes `lidar_001.laz`, … with about `points` points into `folder`; gives the number of
/// points and of files. `advance` is told how many points have been written so far.
pub(crate) fn scan(
    street: &Street,
    seed: u64,
    points: u64,
    folder: &Path,
    advance: &(dyn Fn(u64) + Sync),
    cancel: &AtomicBool,
) -> Result<(u64, u32), SampleError> {
    if points == 0 {
        return Ok((0, 0));
    }
    let plan = Plan::new(street, seed, points);
    let files = u32::try_from(points.div_ceil(FILE_POINTS).max(2)).unwrap_or(u32::MAX);
    let mut written = 0;
    for file in 0..u64::from(files) {
        let first = plan.lines * file / u64::from(files);
        let last = plan.lines * (file + 1) / u64::from(files);
        let path = folder.join(format!("lidar_{:03}.laz", file + 1));
        let failed = |source: las::Error| SampleError::Points { source, path: path.clone() };
        let source_id = u16::try_from(file + 1).unwrap_or(u16::MAX);
        let mut writer = Writer::from_path(&path, header().map_err(failed)?).map_err(failed)?;
        let encoder = PointDataBuilder::new().for_header(writer.header());
        let batch = (BATCH_PULSES / plan.pulses_per_line).max(1);
        let mut line = first;
        while line < last {
            if cancel.load(Ordering::Relaxed) {
                return Err(SampleError::Cancelled);
            }
            let end = (line + batch).min(last);
            let encoded: Result<Vec<PointData>, las::Error> = (line..end)
                .into_par_iter()
                .map(|line| {
                    let points = trace_line(street, seed, &plan, line, source_id);
                    encoder.clone().build_from_points(points)
                })
                .collect();
            for data in encoded.map_err(failed)? {
                written += data.len() as u64;
                writer.write_points(&data).map_err(failed)?;
            }
            advance(written);
            line = end;
        }
        writer.close().map_err(failed)?;
    }
    Ok((written, files))
}

impl Plan {
    /// Lines as far apart as the pulses of a line at ten metres, and as many of both as give
    /// about `points` returns; some of the pulses go to the sky, how many a trial tells.
    fn new(street: &Street, seed: u64, points: u64) -> Self {
        let (start_m, end_m) = (-6.0, street.length_m + 6.0);
        let trial = Self { lines: 97, pulses_per_line: 360, start_m, end_m };
        let returns: usize =
            (0..trial.lines).map(|line| trace_line(street, seed, &trial, line, 0).len()).sum();
        let share = returns.max(1) as f64 / (trial.lines * trial.pulses_per_line) as f64;
        let pulses = points as f64 / share;
        // lines · pulses_per_line = pulses, (length / lines) = 2π 10 m / pulses_per_line.
        let ratio = (end_m - start_m) / (std::f64::consts::TAU * 10.0);
        let lines = (pulses * ratio).sqrt().ceil().max(8.0);
        let pulses_per_line = (pulses / lines).round().max(8.0);
        Self { lines: lines as u64, pulses_per_line: pulses_per_line as u64, start_m, end_m }
    }
}

/// The returns of one turn of the scanner.
fn trace_line(street: &Street, seed: u64, plan: &Plan, line: u64, source_id: u16) -> Vec<Point> {
    let mut rng = random(seed, Purpose::Lidar, line);
    let noise = Normal::new(0.0, RANGE_SIGMA_M).expect("a finite, positive deviation");
    let frame = StreetFrame::PLACE;
    // Two heads, leaned to either side, take turns.
    let lean = if line.is_multiple_of(2) { 0.5 } else { -0.5 };
    let street_from_head = DMat3::from_rotation_z(lean) * DMat3::from_rotation_y(0.35);
    let mut points = Vec::new();
    for pulse in 0..plan.pulses_per_line {
        let turn = pulse as f64 / plan.pulses_per_line as f64;
        let t = (line as f64 + turn) / plan.lines as f64;
        let x = plan.start_m + t * (plan.end_m - plan.start_m);
        let origin = DVec3::new(
            x,
            -1.35 + 0.25 * (x / 17.0).sin(),
            street.terrain.axis(x) + SCANNER_HEIGHT_M,
        );
        let angle = turn * std::f64::consts::TAU;
        let spin = DVec3::new(0.0, angle.sin(), -angle.cos());
        let jitter = DVec3::new(0.0, rng.random_range(-2e-4..2e-4), rng.random_range(-2e-4..2e-4));
        let direction = (street_from_head * spin + jitter).normalize();
        let range_error = noise.sample(&mut rng);
        let ray = Ray { origin, direction };
        let Some(hit) = street.tree.nearest(&ray, RANGE_M) else { continue };
        let surface = street.surface(&hit);
        let Some(class) = surface.class.las() else { continue };
        let range = hit.contact.distance;
        let incidence = hit.contact.normal.dot(direction).abs();
        // Glass returns little, and at a slant nothing at all.
        let glass = matches!(
            surface.material,
            Material::Pane { .. } | Material::Display { .. } | Material::CarGlass
        );
        if glass && rng.random_bool(1.0 - 0.6 * incidence) {
            continue;
        }
        let p = frame.world_from_point(ray.at((range + range_error).max(0.5)));
        let reflectance = reflectance(&surface.material) * (0.25 + 0.75 * incidence);
        let fall = (1.0 - 0.006 * range).max(0.2);
        points.push(Point {
            x: p.x,
            y: p.y,
            z: p.z,
            intensity: (reflectance * fall * rng.random_range(0.85..1.15) * 52_000.0) as u16,
            return_number: 1,
            number_of_returns: 1,
            classification: Classification::new(class).unwrap_or_default(),
            scan_angle: ((turn * 360.0 + 180.0).rem_euclid(360.0) - 180.0) as f32,
            point_source_id: source_id,
            scanner_channel: u8::from(lean < 0.0),
            gps_time: Some(START_GPS_S + (x - plan.start_m) / SPEED_M_S),
            ..Point::default()
        });
    }
    points
}

/// Share of the near infrared that a material sends back, about.
fn reflectance(material: &Material) -> f64 {
    match *material {
        Material::Road { .. } | Material::Rubber => 0.14,
        Material::Plaster { colour, .. }
        | Material::Stone { colour, .. }
        | Material::Trim { colour, .. } => 0.2 + 0.8 * colour.x,
        Material::Brick { .. } | Material::Tiles { .. } => 0.42,
        Material::Pane { .. } | Material::Display { .. } | Material::CarGlass => 0.06,
        Material::Leaf { .. } => 0.62,
        Material::Bark { .. } => 0.35,
        Material::Paving | Material::Kerb => 0.38,
        Material::CarPaint { colour }
        | Material::Paintwork { colour }
        | Material::Louvres { colour }
        | Material::Door { colour, .. }
        | Material::Sign { colour, .. }
        | Material::Awning { colour, .. } => 0.1 + 0.7 * colour.x,
        Material::Zinc { .. } => 0.3,
    }
}

/// LAS 1.4, point format 6: intensity, class and time, no colour, as scanners deliver.
fn header() -> Result<Header, las::Error> {
    let mut builder = Builder::from((1, 4));
    builder.point_format = las::point::Format::new(6)?;
    builder.point_format.is_compressed = true;
    let axis = |offset: f64| Transform { scale: 0.001, offset };
    let origin = StreetFrame::PLACE.world_from_point(DVec3::ZERO);
    builder.transforms =
        Vector { x: axis(origin.x.round()), y: axis(origin.y.round()), z: axis(0.0) };
    builder.gps_time_type = GpsTimeType::Standard;
    builder.has_wkt_crs = true;
    builder.generating_software = "flaneur sample".to_owned();
    builder.system_identifier = "simulated drive".to_owned();
    let mut data = LAMBERT_93.as_bytes().to_vec();
    data.push(0);
    builder.vlrs.push(Vlr {
        user_id: "LASF_Projection".to_owned(),
        record_id: 2112,
        description: "WKT".to_owned(),
        data,
    });
    builder.into_header()
}
