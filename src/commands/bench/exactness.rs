//! How far frames of the device are from the same frames in f64.

use flaneur_renderer::reference::Scene;
use flaneur_renderer::{Mode, Renderer, Settings, SplatNormals, Texturing};
use flaneur_scene::{SceneUpdate, View};
use flaneur_services::ingest::{Progress, Unit as Counted};
use flaneur_streamer::{Event, FetchLimits, ViewRequest};
use futures::StreamExt;
use glam::UVec2;

use super::Context;
use super::session::{Session, check};
use crate::evaluation::speed::{Inputs, Row, Unit, median, percentile};
use crate::exit::Exit;
use crate::source::stream_exit;

/// Size of the pictures: the reference asks a ray a pixel.
const SIZE: UVec2 = UVec2::new(128, 64);
/// As much of the scene as it goes through in seconds.
const SMALL: FetchLimits = FetchLimits {
    mesh_radius_m: 60.0,
    panoramas: 2,
    panorama_radius_m: 60.0,
    image_pixels: 1 << 20,
    image_side: 8192,
    point_bytes: u64::MAX,
    points: 100_000,
    point_radius_m: 60.0,
    point_spacing_px: 1.0,
};

impl Session {
    /// Renders a small part of the first view in f64 and by each way of texturing, and compares them
    /// away from edges of depth.
    pub(super) async fn compare_with_f64(&mut self, context: &Context) -> Result<(), Exit> {
        let Some(view) = self.views.first().map(small) else { return Ok(()) };
        let ways = Texturing::ALL;
        let stage = context.console.stage("compare with f64", ways.len() as u64, Counted::Items);
        let updates = self.small_scene(&view, context).await?;
        // Alignment is of one way alone, and where nothing is measured there is nothing to compare.
        let settings = Settings { depth_map_side: 128, align: false, infer: false, ..self.base };
        let mut scene = Scene::new(settings);
        updates.iter().for_each(|update| scene.apply(update.clone()));
        check(context).await?;
        let exact = tokio::task::block_in_place(|| scene.render(&view, Mode::Hybrid));
        for texturing in ways {
            check(context).await?;
            let row = tokio::task::block_in_place(|| {
                let settings = Settings { texturing, ..settings };
                let mut renderer = Renderer::with_settings(self.gpu(), settings);
                for update in &updates {
                    renderer.apply(update.clone())?;
                }
                renderer.render(&view)?;
                let mut times = Vec::new();
                for _ in 0..self.repeats {
                    let started = std::time::Instant::now();
                    renderer.render(&view)?;
                    times.push(started.elapsed().as_secs_f64() * 1e3);
                }
                let frame = renderer.render(&view)?;
                let difference = exact.difference(&frame);
                let counts = Inputs::mean(&[frame.stats]);
                Ok::<_, Exit>(Row {
                    pass: Row::FRAME,
                    method: Row::AGAINST_F64,
                    setting: texturing.name().to_owned(),
                    ms_median: median(&times).unwrap_or(f64::NAN),
                    ms_p95: percentile(&times, 0.95).unwrap_or(f64::NAN),
                    error_max: difference.max_255,
                    error_p99: difference.p99_255,
                    // Only what lies away from edges was compared.
                    error_rms: f64::NAN,
                    error_unit: Unit::Colour,
                    uncovered: 0.0,
                    unmatched: 1.0 - difference.same_surface,
                    inputs: format!(
                        "{counts}, {} of {} pixels, {:.2} % within 1/255",
                        difference.compared,
                        difference.pixels,
                        100.0 * difference.alike
                    ),
                    counts,
                    bytes: Some(renderer.memory().total()),
                    front: false,
                    within_fifth: None,
                    late: None,
                })
            })?;
            self.rows.push(row);
            stage.advance(1);
        }
        Ok(())
    }

    async fn small_scene(&self, view: &View, context: &Context) -> Result<Vec<SceneUpdate>, Exit> {
        let mut streamer = self.source().streamer().await?;
        let normals = self.base.splat_normals == SplatNormals::Estimated;
        let request = ViewRequest { limits: SMALL, normals, ..ViewRequest::new(*view) };
        let mut events = streamer.stream(request, &context.cancel);
        let mut updates = Vec::new();
        while let Some(event) = events.next().await {
            if let Event::Update(update) = event.map_err(stream_exit)? {
                updates.push(update);
            }
        }
        Ok(updates)
    }
}

/// The same view as a small picture.
fn small(view: &View) -> View {
    let mut view = *view;
    view.camera.lens = view.camera.lens.scaled_to(SIZE);
    view
}
