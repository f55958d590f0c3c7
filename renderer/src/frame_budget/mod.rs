//! Settings that hold the time of a frame.
//!
//! The settings that trade time for error are gone through on one ladder, from the most exact
//! downwards: on the front, between its measured rungs, and below it with fewer points and pixels.
//! The front is of the frames that `flaneur bench` measured: those that no other is both faster and
//! nearer to the most exact one than. What they took there only says in what order they come and
//! about how far apart. Nothing is assumed of the machine at hand:
//! frames are timed, and the rung follows. A change needs several frames that agree, so that one
//! that is late moves nothing; it goes as far down as the rungs' costs suggest and up with care, and
//! not soon again to a rung that proved too slow. Between 0.85 and 1.1 times the budget nothing
//! changes: most rungs differ by less than that, so that a rung is found where the machine has one.
//!
//! The very first frame has to pay for what is made once, depth maps above all, and whoever waits for it
//! sees nothing yet: it is made with the cheapest settings that were measured, whatever the budget.

use std::time::Duration;

use crate::Settings;

mod front;
mod ladder;
#[cfg(test)]
mod tests;

use front::FRONT;
use ladder::LADDER;

/// Above this share of the budget frames are made cheaper …
const HIGH: f64 = 1.1;
/// … and below this more exact.
const LOW: f64 = 0.85;
/// What is aimed at when something changes.
const AIM: f64 = 0.95;
/// Up to this share of the budget it is held.
const HELD: f64 = 1.2;
/// Frames of one rung that are judged together, by their median.
const WINDOW: usize = 3;
/// Frames after a change that do not count: buffers may be made anew.
const UNSETTLED: usize = 1;
/// How many judgements a rung that proved too slow is not tried again …
const AVOIDED: u32 = 300;
/// … unless frames take less than this share of what they took on the same rung after it: what
/// is seen has changed.
const EASIER: f64 = 0.6;

/// Chooses settings so that frames take a given time.
///
/// Not used, nothing depends on time: the same scene and view give the same picture.
#[derive(Clone, Debug)]
pub struct FrameBudget {
    budget: Duration,
    /// Whether any frame was timed yet.
    begun: bool,
    rung: usize,
    times: Vec<Duration>,
    to_ignore: usize,
    ceiling: Option<Ceiling>,
    /// Whether the last change was upwards.
    went_up: bool,
    judged: bool,
}

/// The rung above which nothing is tried.
#[derive(Clone, Copy, Debug)]
struct Ceiling {
    rung: usize,
    /// For so many judgements more.
    left: u32,
    /// What frames took when the rung in use was first judged, as a share of the budget.
    share: Option<f64>,
}

impl Ceiling {
    /// After one more judgement; `None` where it holds no longer.
    fn judged(self, share: f64) -> Option<Self> {
        let first = self.share.unwrap_or(share);
        let left = self.left.checked_sub(1)?;
        (share >= EASIER * first).then_some(Self { left, share: Some(first), ..self })
    }
}

/// One rung: the most that is spent on each kind of exactness.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rung {
    rigs: usize,
    /// Share of the points that a view meets.
    points: f32,
    /// Depths between the backdrop and the neighbours' that are tried where nothing is known;
    /// `None` where such pixels stay empty.
    hypotheses: Option<u32>,
    align: bool,
    resolution: f32,
    /// What a frame took where the front was measured, milliseconds.
    ms: f64,
}

const fn rung(
    rigs: usize,
    points: f32,
    hypotheses: Option<u32>,
    align: bool,
    resolution: f32,
    ms: f64,
) -> Rung {
    Rung { rigs, points, hypotheses, align, resolution, ms }
}

/// That of the frame after the very first: whoever takes a first step would wait for what is too exact,
/// and for the frames that it takes to find that out.
fn second_rung(budget: Duration) -> usize {
    let ms = AIM * budget.as_secs_f64() * 1e3;
    let fits = |rung: &Rung| rung.ms <= ms;
    let measured = LADDER.iter().take_while(|rung| !FRONT.last().is_some_and(|last| *rung == last));
    let longer = measured.take_while(|rung| !fits(rung)).count();
    longer.max(LADDER.len() / 3)
}

/// How a budget fares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BudgetStanding {
    /// What was asked for.
    pub asked: Duration,
    /// The median of the last frames that were judged.
    pub reached: Duration,
    /// Whether those took no more than a fifth longer than they should.
    pub held: bool,
    /// Where on the ladder the settings stand, 0 the most exact.
    pub rung: usize,
    /// How many rungs there are.
    pub rungs: usize,
}

impl FrameBudget {
    /// Frames of about `budget`: a first one soon, then of a middling exactness, or of less where a
    /// middling one took longer than that where the front was measured.
    pub fn new(budget: Duration) -> Self {
        Self {
            budget,
            begun: false,
            rung: second_rung(budget),
            times: Vec::with_capacity(WINDOW),
            to_ignore: UNSETTLED,
            ceiling: None,
            went_up: false,
            judged: false,
        }
    }

    /// Frames of the same budget for somebody else: a first one soon, then as exact as these are.
    #[must_use]
    pub fn afresh(&self) -> Self {
        Self { rung: self.rung, ..Self::new(self.budget) }
    }

    /// What frames are to take.
    pub fn budget(&self) -> Duration {
        self.budget
    }

    /// The settings of `base`, as exact as any rung is where rungs differ.
    pub fn most_exact(base: Settings) -> Settings {
        LADDER.first().map_or(base, |rung| Settings {
            rigs: rung.rigs,
            points_share: rung.points,
            infer: rung.hypotheses.is_some(),
            inferred_hypotheses: rung.hypotheses.unwrap_or(base.inferred_hypotheses),
            align: rung.align,
            resolution: rung.resolution,
            ..base
        })
    }

    /// What the next frame is to be rendered with: nowhere more exact than `base`.
    pub fn settings(&self, base: Settings) -> Settings {
        let rung = if self.begun { LADDER.get(self.rung) } else { FRONT.last() };
        let Some(rung) = rung else { return base };
        let hypotheses = rung.hypotheses.unwrap_or(u32::MAX);
        Settings {
            rigs: base.rigs.min(rung.rigs),
            points_share: base.points_share.min(rung.points),
            infer: base.infer && rung.hypotheses.is_some(),
            inferred_hypotheses: base.inferred_hypotheses.min(hypotheses),
            align: base.align && rung.align,
            resolution: base.resolution.min(rung.resolution),
            ..base
        }
    }

    /// Takes note of how long a frame took that was rendered with the settings given last;
    /// whether those change.
    pub fn observe(&mut self, time: Duration) -> bool {
        if !std::mem::replace(&mut self.begun, true) {
            return true;
        }
        if self.to_ignore > 0 {
            self.to_ignore -= 1;
            return false;
        }
        self.times.push(time);
        if self.times.len() < WINDOW {
            return false;
        }
        let share = self.median_share();
        self.judged = true;
        self.ceiling = self.ceiling.and_then(|ceiling| ceiling.judged(share));
        let to = if share > HIGH {
            self.cheaper(share)
        } else if share < LOW {
            self.more_exact(share)
        } else {
            self.rung
        };
        if to == self.rung {
            self.times.remove(0);
            return false;
        }
        if to > self.rung && self.went_up {
            self.ceiling = Some(Ceiling { rung: self.rung + 1, left: AVOIDED, share: None });
        } else if let Some(ceiling) = &mut self.ceiling {
            ceiling.share = None;
        }
        self.went_up = to < self.rung;
        self.rung = to;
        self.times.clear();
        self.to_ignore = UNSETTLED;
        self.judged = false;
        true
    }

    /// Whether the last frames were judged and nothing was to be changed: the budget is held, or
    /// there is no more exact rung, or no cheaper one.
    pub fn is_settled(&self) -> bool {
        self.judged
    }

    /// Where on the ladder the settings stand: 0 the most exact, 1 the cheapest.
    pub fn haste(&self) -> f64 {
        self.rung as f64 / (LADDER.len() - 1).max(1) as f64
    }

    /// How the budget fares; `None` before any frame was judged on the rung in use.
    pub fn standing(&self) -> Option<BudgetStanding> {
        let reached = self.median().filter(|_| self.judged)?;
        Some(BudgetStanding {
            asked: self.budget,
            reached,
            held: reached <= self.budget.mul_f64(HELD),
            rung: self.rung,
            rungs: LADDER.len(),
        })
    }

    /// The median of the last times.
    fn median(&self) -> Option<Duration> {
        let mut sorted = self.times.clone();
        sorted.sort_unstable();
        sorted.get(sorted.len() / 2).copied()
    }

    /// The same as a share of the budget.
    fn median_share(&self) -> f64 {
        self.median().unwrap_or_default().as_secs_f64() / self.budget.as_secs_f64().max(1e-6)
    }

    /// The first rung below that should fit, the last where none does.
    fn cheaper(&self, share: f64) -> usize {
        let ms = self.ms() * AIM / share;
        let below = LADDER.iter().enumerate().skip(self.rung + 1);
        let last = LADDER.len() - 1;
        below.into_iter().find(|(_, rung)| rung.ms <= ms).map_or(last, |(index, _)| index)
    }

    /// The most exact rung that should fit, this one where none above does. Half the way there, so
    /// that a rung which costs more than it should is not overshot by much.
    fn more_exact(&self, share: f64) -> usize {
        let ms = self.ms() * AIM / share;
        let ceiling = self.ceiling.map_or(0, |ceiling| ceiling.rung);
        let mut above = (ceiling..self.rung).filter(|&index| LADDER[index].ms <= ms);
        let found = above.next().unwrap_or(self.rung);
        found + (self.rung - found) / 2
    }

    fn ms(&self) -> f64 {
        LADDER.get(self.rung).map_or(1.0, |rung| rung.ms)
    }
}
