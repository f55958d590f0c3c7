//! The settings that frame budgets choose from, and the file that the renderer reads them from.

use std::fmt::Write as _;
use std::path::Path;

use flaneur_services::ingest::{Progress, Unit as Counted};

use super::Context;
use super::feed::Fed;
use super::session::{Session, check};
use super::tally::Tally;
use crate::atomic_file;
use crate::evaluation::speed::ladder::{MOST_UNCOVERED, RIGS, way_down};
use crate::evaluation::speed::{FrontRung, Report, Row, Variant, mark_front};
use crate::exit::Exit;

/// A rung saves at least this share of the time of the one above.
const LEAST_SAVED: f64 = 0.03;

impl Session {
    /// Measures what lies on the way from the most exact settings to the cheapest, and keeps of it
    /// what is on the front.
    pub(super) async fn measure_front(
        &mut self,
        fed: &mut Fed,
        context: &Context,
    ) -> Result<(), Exit> {
        let Some(sweep) = self.sweep() else { return Ok(()) };
        let way = way_down(&sweep);
        let renderings = (way.len() * self.views.len()) as u64;
        let stage = context.console.stage("measure the front", renderings, Counted::Items);
        let mut tallies: Vec<Tally> = way.iter().map(|_| Tally::default()).collect();
        for (view, exact) in self.views.iter().zip(&self.exact) {
            fed.fetch(view, RIGS[0], context).await?;
            for (rung, tally) in way.iter().zip(&mut tallies) {
                check(context).await?;
                let settings = rung.settings(self.base);
                tokio::task::block_in_place(|| {
                    let frame = fed.frame(view, settings)?;
                    tally.difference.add_colours(&frame, &exact.frame);
                    tally.stats.push(frame.stats);
                    for _ in 0..self.repeats {
                        tally.add_frame(fed.timed(view)?.1);
                    }
                    tally.add_bytes(fed.held().total());
                    Ok::<_, Exit>(())
                })?;
                stage.advance(1);
            }
        }
        let measured: Vec<FrontRung> = way
            .iter()
            .zip(&tallies)
            .filter_map(|(rung, tally)| {
                let (single, settings) = (tally.single()?, rung.settings(self.base));
                Some(FrontRung {
                    rigs: settings.rigs,
                    points_share: settings.points_share,
                    inferred_hypotheses: settings.infer.then_some(settings.inferred_hypotheses),
                    align: settings.align,
                    resolution: settings.resolution,
                    ms_median: single.ms,
                    error_rms: single.mse.sqrt(),
                    uncovered: tally.difference.uncovered_share(),
                })
            })
            .collect();
        self.front = front(&measured);
        for (rung, tally) in way.iter().zip(&tallies) {
            let settings = rung.settings(self.base);
            let (method, setting) = ("combined", label(&settings));
            let variant = Variant { method, setting, feed: fed.feed(), settings };
            self.rows.extend(tally.rows(&variant).filter(|row| row.pass == Row::FRAME));
        }
        Ok(())
    }
}

/// Those that nothing beats and that leave next to nothing without colour, most exact first.
fn front(measured: &[FrontRung]) -> Vec<FrontRung> {
    let whole: Vec<FrontRung> =
        measured.iter().filter(|rung| rung.uncovered <= MOST_UNCOVERED).copied().collect();
    let costs: Vec<[f64; 2]> = whole.iter().map(|rung| [rung.ms_median, rung.error_rms]).collect();
    let mut kept: Vec<FrontRung> = Vec::new();
    for (rung, unbeaten) in whole.into_iter().zip(mark_front(&costs)) {
        let saves = |last: &FrontRung| rung.ms_median <= (1.0 - LEAST_SAVED) * last.ms_median;
        if unbeaten && kept.last().is_none_or(saves) {
            kept.push(rung);
        }
    }
    kept
}

/// What a frame budget changes, in a few words.
fn label(settings: &flaneur_renderer::Settings) -> String {
    let points = match settings.points_share {
        1.0 => "all points".to_owned(),
        share => format!("{} % of the points", 100.0 * share),
    };
    let inferred = match settings.infer {
        true => format!("{} depths", settings.inferred_hypotheses),
        false => "not inferred".to_owned(),
    };
    let aligned = if settings.align { "aligned" } else { "not aligned" };
    format!("{} rigs, {points}, {inferred}, {aligned}, {}", settings.rigs, settings.resolution)
}

/// Writes the front as the table in Rust that the renderer's frame budget is compiled with.
pub(super) fn write(file: &Path, report: &Report) -> Result<(), Exit> {
    let described = &report.described;
    let mut text = format!(
        "//! The front of frames, from the most exact to the cheapest. Written by\n\
         //! `flaneur bench SCENE --report FILE --front FILE`; not by hand.\n\
         //!\n\
         //! Measured on the scene {:?}, {} views of {}x{} pixels, on\n\
         //! {}, {} processor cores. Above each rung: the root mean\n\
         //! square of the difference to the most exact frames, 255ths.\n\n\
         use super::{{Rung, rung}};\n\n\
         pub(super) const FRONT: &[Rung] = &[\n",
        report.scene,
        described.views,
        described.width,
        described.height,
        report.adapter,
        report.cpus
    );
    for rung in &report.front {
        let hypotheses = match rung.inferred_hypotheses {
            Some(count) => format!("Some({count})"),
            None => "None".to_owned(),
        };
        let _ = writeln!(
            text,
            "    // {:.2}\n    rung({}, {:?}, {hypotheses}, {}, {:?}, {:.1}),",
            rung.error_rms,
            rung.rigs,
            rung.points_share,
            rung.align,
            rung.resolution,
            rung.ms_median
        );
    }
    text.push_str("];\n");
    atomic_file::write(file, text.as_bytes())
}
