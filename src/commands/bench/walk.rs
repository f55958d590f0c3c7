//! Frame budgets while the view moves.

use std::time::Duration;

use flaneur_renderer::{Frame, FrameBudget};
use flaneur_services::ingest::{Progress, Unit as Counted};

use super::Context;
use super::feed::Fed;
use super::session::{Session, check};
use super::tally::Tally;
use crate::evaluation::speed::ladder::RIGS;
use crate::evaluation::speed::{Row, Variant};
use crate::exit::Exit;

/// Frames at the start of the path, at most, in which a budget finds its settings.
const START_FRAMES: usize = 40;
/// How far a frame may be from its budget, as a share of it.
const FIFTH: f64 = 0.2;

impl Session {
    /// Moves along the path under several budgets, and compares the frames with the most exact ones
    /// of the same places. What all of the path wants is there from the start.
    pub(super) async fn walk(&mut self, fed: &mut Fed, context: &Context) -> Result<(), Exit> {
        let budgets = self.budgets_ms();
        let Some(exact) = self.variants.first().map(|variant| variant.settings) else {
            return Ok(());
        };
        if self.path.is_empty() || budgets.is_empty() {
            return Ok(());
        }
        let frames = self.path.len() * (1 + budgets.len());
        let stage = context.console.stage("walk", frames as u64, Counted::Images);
        fed.fetch_path(&self.path, RIGS[0], context).await?;
        let mut expected: Vec<Frame> = Vec::with_capacity(self.path.len());
        for view in &self.path {
            check(context).await?;
            expected.push(tokio::task::block_in_place(|| fed.frame(view, exact))?);
            stage.advance(1);
        }
        let base = FrameBudget::most_exact(self.base);
        for budget_ms in budgets {
            let mut budget = FrameBudget::new(Duration::from_secs_f64(budget_ms / 1e3));
            fed.set(budget.settings(base))?;
            for _ in 0..START_FRAMES {
                check(context).await?;
                let Some(view) = self.path.first() else { break };
                let (_, ms) = tokio::task::block_in_place(|| fed.timed(view))?;
                if budget.observe(Duration::from_secs_f64(ms / 1e3)) {
                    fed.set(budget.settings(base))?;
                } else if budget.is_settled() {
                    break;
                }
            }
            let mut tally = Tally::default();
            for (view, exact) in self.path.iter().zip(&expected) {
                check(context).await?;
                let (frame, ms) = tokio::task::block_in_place(|| fed.timed(view))?;
                tally.add_frame(ms);
                tally.add_bytes(fed.held().total());
                tally.stats.push(frame.stats);
                tally.difference.add_colours(&frame, exact);
                if budget.observe(Duration::from_secs_f64(ms / 1e3)) {
                    fed.set(budget.settings(base))?;
                }
                stage.advance(1);
            }
            let setting = format!("{budget_ms} ms");
            let settings = budget.settings(base);
            let variant = Variant { method: "budget", setting, feed: fed.feed(), settings };
            let times = tally.times(Row::FRAME);
            let share = |counts: &dyn Fn(f64) -> bool| {
                times.iter().filter(|ms| counts(**ms)).count() as f64 / times.len().max(1) as f64
            };
            let within = share(&|ms| (ms / budget_ms - 1.0).abs() <= FIFTH);
            let late = share(&|ms| ms > (1.0 + FIFTH) * budget_ms);
            self.rows.extend(tally.rows(&variant).map(|row| Row {
                within_fifth: Some(within),
                late: Some(late),
                ..row
            }));
        }
        Ok(())
    }

    /// Budgets that this machine can hold: what frames take at places on the front.
    fn budgets_ms(&self) -> Vec<f64> {
        let last = self.front.len().saturating_sub(1);
        let mut rungs = vec![last / 4, last / 2, 3 * last / 4];
        rungs.dedup();
        let ms = rungs.into_iter().filter_map(|rung| self.front.get(rung));
        ms.map(|rung| two_digits(rung.ms_median)).collect()
    }
}

/// The nearest number of two digits.
fn two_digits(ms: f64) -> f64 {
    let unit = 10f64.powf(ms.max(1e-3).log10().floor() - 1.0);
    // Written so that what is printed has no more of them.
    if unit < 1.0 { (ms / unit).round() / (1.0 / unit).round() } else { (ms / unit).round() * unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_round() {
        let given = [0.1234, 3.46, 99.7, 412.0, 1850.0].map(two_digits);
        assert_eq!(given.map(|ms| ms.to_string()), ["0.12", "3.5", "100", "410", "1900"]);
    }
}
