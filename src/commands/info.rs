//! `flaneur info`: what a scene holds.

use std::collections::BTreeSet;

use clap::Args;
use flaneur_scene::{Bounds3, ImageId, PointSource, Region, SceneInfo};
use flaneur_streamer::Client;
use futures::TryStreamExt;
use serde::Serialize;

use super::Context;
use crate::exit::Exit;
use crate::output;
use crate::source::{Source, stream_exit};

const EXAMPLES: &str = "\
Examples:
  flaneur info scenes                           every scene of a store
  flaneur info scenes/paris
  flaneur info http://127.0.0.1:7878/paris --json";

/// Arguments of `flaneur info`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct InfoArguments {
    /// Scene, store or server: a folder, s3://bucket/prefix, http://host:port, each with or
    /// without /scene at its end
    #[arg(value_name = "SOURCE")]
    source: String,
    /// Print one JSON document: an object for one scene, an array for several; it also lists the
    /// photographs' ids, in image_ids
    #[arg(long)]
    json: bool,
}

/// Prints what every scene of the source holds.
pub(crate) async fn run(arguments: InfoArguments, context: &Context) -> Result<(), Exit> {
    tokio::select! {
        () = context.cancel.cancelled() => Err(Exit::Interrupted),
        outcome = print(&arguments) => outcome,
    }
}

async fn print(arguments: &InfoArguments) -> Result<(), Exit> {
    let source = Source::open(&arguments.source).await?;
    let mut reports = Vec::new();
    for scene in source.scenes().await? {
        let photographs = photographs(&source.client_of(&scene.name)).await?;
        reports.push(Report::new(scene, photographs));
    }
    match (&reports[..], arguments.json) {
        ([one], true) => output::print_json(one),
        (several, true) => output::print_json(&several),
        (reports, false) => {
            let texts: Vec<String> = reports.iter().map(Report::text).collect();
            output::print(&texts.join("\n"))
        }
    }
}

/// What there is to say of a scene's photographs.
#[derive(Default)]
struct Photographs {
    /// Their names, in order.
    ids: BTreeSet<ImageId>,
    /// The first and the last exposure, where any has a time.
    times: Option<[String; 2]>,
}

/// Asks for all of them. RFC 3339 in one zone sorts as text.
async fn photographs(client: &Client) -> Result<Photographs, Exit> {
    let mut found = Photographs::default();
    let panoramas = client.panoramas(Region::All).await.map_err(stream_exit)?;
    let mut panoramas = std::pin::pin!(panoramas);
    while let Some(panorama) = panoramas.try_next().await.map_err(stream_exit)? {
        found.ids.extend(panorama.photographs()?.into_iter().map(|(id, _)| id));
        let Some(time) = panorama.time else { continue };
        match &mut found.times {
            None => found.times = Some([time.clone(), time]),
            Some([first, _]) if time < *first => *first = time,
            Some([_, last]) if time > *last => *last = time,
            Some(_) => {}
        }
    }
    Ok(found)
}

/// What is said of a scene.
#[derive(Serialize)]
struct Report {
    name: String,
    crs: String,
    /// Latitude, longitude (degrees) and height (metres) of a local CRS's zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    geographic_origin: Option<[f64; 3]>,
    origin: [f64; 3],
    bounds: Box3,
    footprints: u64,
    has_ground: bool,
    panoramas: u64,
    images: u64,
    first_time: Option<String>,
    last_time: Option<String>,
    points: u64,
    point_sources: Vec<PointReport>,
    /// The photographs by the names that other commands take, faces of spheres each for itself.
    image_ids: BTreeSet<ImageId>,
}

#[derive(Serialize)]
struct PointReport {
    name: String,
    points: u64,
    point_format: u8,
    record_length: u16,
    scale: [f64; 3],
    spacing_m: f64,
    bounds: Box3,
}

#[derive(Serialize)]
struct Box3 {
    min: [f64; 3],
    max: [f64; 3],
}

impl Report {
    fn new(scene: SceneInfo, photographs: Photographs) -> Self {
        let (first_time, last_time) = photographs.times.map(|[first, last]| (first, last)).unzip();
        Self {
            name: scene.name,
            crs: scene.crs,
            geographic_origin: scene.geographic_origin,
            origin: scene.origin.to_array(),
            bounds: Box3::from(scene.bounds),
            footprints: scene.footprints,
            has_ground: scene.ground.is_some(),
            panoramas: scene.panoramas,
            images: scene.images,
            first_time,
            last_time,
            points: scene.point_sources.iter().map(|source| source.point_count).sum(),
            point_sources: scene.point_sources.into_iter().map(PointReport::from).collect(),
            image_ids: photographs.ids,
        }
    }

    fn text(&self) -> String {
        let [x, y, z] = self.bounds.size();
        let place = |p: [f64; 3]| format!("{:.2} {:.2} {:.2}", p[0], p[1], p[2]);
        let mut lines = vec![
            self.name.clone(),
            format!("  crs         {}", self.crs),
            format!("  bounds      {} to {}", place(self.bounds.min), place(self.bounds.max)),
            format!("  extent      {x:.1} x {y:.1} x {z:.1} m"),
            format!("  footprints  {}", self.footprints),
            format!("  ground      {}", if self.has_ground { "yes" } else { "none" }),
            format!("  panoramas   {} ({} images)", self.panoramas, self.images),
        ];
        if let (Some(first), Some(last)) = (self.image_ids.first(), self.image_ids.last()) {
            lines.push(format!("  image ids   {first} to {last} (--json lists them all)"));
        }
        if let (Some(first), Some(last)) = (&self.first_time, &self.last_time) {
            lines.push(format!("  taken       {first} to {last}"));
        }
        lines.push(format!("  points      {}", self.points));
        lines.extend(self.point_sources.iter().map(|source| {
            format!(
                "    {}: {} points, format {}, spacing {} m at the root",
                source.name, source.points, source.point_format, source.spacing_m
            )
        }));
        lines.join("\n") + "\n"
    }
}

impl From<PointSource> for PointReport {
    fn from(source: PointSource) -> Self {
        Self {
            name: source.name,
            points: source.point_count,
            point_format: source.point_format,
            record_length: source.record_length,
            scale: source.scale.to_array(),
            spacing_m: source.cube.spacing_m,
            bounds: Box3::from(source.bounds),
        }
    }
}

impl From<Bounds3> for Box3 {
    fn from(bounds: Bounds3) -> Self {
        Self { min: bounds.min.to_array(), max: bounds.max.to_array() }
    }
}

impl Box3 {
    fn size(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.max[axis] - self.min[axis])
    }
}
