//! Exposure gains: neighbouring photographs differ in brightness, and a factor for each takes
//! the seams between them away.
//!
//! The photographs of a frame are compared where they see the same places ([`measure`],
//! [`overlaps`]), and one system of least squares gives each a factor a channel ([`solve`]). That
//! is done when another photograph is used, or another level of one, or when geometry changed what
//! one sees; the result depends on those alone, not on the eye nor on the order in which anything
//! arrived. A photograph that is already on display then goes to its new gain over some frames,
//! unless the view has jumped.
//!
//! Overlaps say how much brighter one photograph is than another, not how bright the street is.
//! The picture is as bright as the photographs near the eye that see something of it: their weighted
//! mean gain is 1. Weights are continuous in the eye's position; as it turns, photographs enter the
//! view and leave it, and the picture's brightness goes to theirs over some frames, too.

use std::collections::BTreeMap;

use flaneur_scene::{ImageId, PosedCamera};
use glam::DVec3;

use crate::depth_map::DepthMaps;
use crate::photographs::Photograph;
use crate::photographs::atlas::Atlas;
use crate::shade::photograph::{Drawn, Standing};
use crate::stages::Stages;
use crate::{Gpu, RenderError};

pub(crate) mod measure;
mod overlaps;
pub(crate) mod reference;
mod solve;
#[cfg(test)]
mod tests;

use measure::MeasurePass;

/// Share of the way to its new gain that a photograph goes each frame.
const STEP: f64 = 0.15;
/// Logarithms that differ by less are the same: no colour changes by a byte.
const SAME: f64 = 1e-3;
/// Photographs nearer to the eye than this, metres, all decide how bright the picture is.
pub(crate) const NEAR_M: f64 = 1.0;
/// From one frame to the next a view that moves further, metres, has jumped …
const JUMP_M: f64 = 0.5;
/// … and so has one that turns further: cosine of 20°.
const JUMP_COSINE: f64 = 0.94;

/// The gains of the photographs in use.
#[derive(Debug)]
pub(crate) struct Gains {
    pass: MeasurePass,
    past: Past,
}

/// What is remembered of a frame for the next of whoever looks.
#[derive(Debug, Default)]
pub(crate) struct Past {
    /// What `solved` was measured on.
    measured: Vec<State>,
    /// Logarithms for linear red, green and blue.
    solved: BTreeMap<ImageId, [f64; 3]>,
    shown: BTreeMap<ImageId, [f64; 3]>,
    /// What is taken from all that is shown.
    level: [f64; 3],
    /// The camera of the frame before.
    camera: Option<PosedCamera>,
}

/// A photograph and what was known of it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct State {
    id: ImageId,
    pixels: u64,
    map: u64,
}

impl Gains {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { pass: MeasurePass::new(gpu), past: Past::default() }
    }

    /// Remembers another frame than the one before, which is given back.
    pub(crate) fn exchange(&mut self, past: Past) -> Past {
        std::mem::replace(&mut self.past, past)
    }

    /// What [`Gains::bytes`] is, at most, once so many photographs were measured.
    pub(crate) fn bytes_for(photographs: usize) -> u64 {
        MeasurePass::bytes_for(photographs)
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.pass.bytes()
    }

    /// Gives its buffers back, but where they are those of so many photographs.
    pub(crate) fn release_but(&mut self, photographs: usize) {
        self.pass.release_but(photographs);
    }

    /// Brings the gains of `selected` up to date for a frame of `camera`. Their depth maps must
    /// be, too. Waits for the device where something is to be measured.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        stages: &mut Stages,
        selected: &[(&ImageId, &Photograph, Standing)],
        maps: &DepthMaps,
        atlas: &Atlas,
        camera: &PosedCamera,
    ) -> Result<(), RenderError> {
        // By name, so that it does not matter from where they are looked at.
        let mut used: Vec<(&ImageId, &Photograph)> =
            selected.iter().map(|(id, photograph, _)| (*id, *photograph)).collect();
        used.sort_by_key(|(id, _)| *id);
        let states: Vec<State> = used
            .iter()
            .filter_map(|(id, photograph)| {
                let (pixels, map) = (photograph.revision, maps.revision(id)?);
                Some(State { id: (*id).clone(), pixels, map })
            })
            .collect();
        if states != self.past.measured {
            self.past.solved = self.solve(gpu, stages, &used, maps, atlas)?;
            self.past.measured = states;
        }
        self.follow(camera, selected);
        Ok(())
    }

    /// Says that the next frame does not follow the last: all gains are new ones.
    pub(crate) fn cut(&mut self) {
        self.past.camera = None;
    }

    /// Says that what was measured holds no more: other depth maps take the place of all.
    pub(crate) fn forget(&mut self) {
        self.past.measured.clear();
        self.past.camera = None;
    }

    /// The factors of a photograph's linear colours.
    pub(crate) fn of(&self, id: &ImageId) -> [f32; 3] {
        let logs = self.past.shown.get(id).copied().unwrap_or(self.past.level);
        [0, 1, 2].map(|channel| (logs[channel] - self.past.level[channel]).exp() as f32)
    }

    fn solve(
        &mut self,
        gpu: &Gpu,
        stages: &mut Stages,
        used: &[(&ImageId, &Photograph)],
        maps: &DepthMaps,
        atlas: &Atlas,
    ) -> Result<BTreeMap<ImageId, [f64; 3]>, RenderError> {
        // Nothing is near a photograph's eye here; that of the first serves all as origin.
        let origin = used.first().map_or(DVec3::ZERO, |(_, first)| first.camera.centre);
        let standing = Standing { rig: 0, rigs: 1, nearest_2: 0.0, weight: 1.0 };
        let (ids, drawn): (Vec<&ImageId>, Vec<Drawn>) = used
            .iter()
            .filter_map(|(id, photograph)| {
                let map = maps.place(id)?;
                let plain = [1.0; 3];
                Some((*id, Drawn::new(photograph, origin, standing, map, plain, plain)))
            })
            .unzip();
        if drawn.len() < 2 {
            return Ok(ids.into_iter().map(|id| (id.clone(), [0.0; 3])).collect());
        }
        let samples = self.pass.run(gpu, stages, &drawn, maps, atlas)?;
        let gains = solve::solve(ids.len(), &overlaps::overlaps(&samples));
        Ok(ids.into_iter().cloned().zip(gains).collect())
    }

    /// Moves what is shown towards what was solved, and how bright all of it is towards what the
    /// photographs say that see something of the view: as one turns, others do.
    fn follow(&mut self, camera: &PosedCamera, selected: &[(&ImageId, &Photograph, Standing)]) {
        let jumped = self.past.camera.replace(*camera).is_none_or(|before| {
            before.centre.distance(camera.centre) > JUMP_M
                || before.forward().dot(camera.forward()) < JUMP_COSINE
        });
        let shown = std::mem::take(&mut self.past.shown);
        let step = |(id, target): (&ImageId, &[f64; 3])| {
            let before = shown.get(id).filter(|_| !jumped);
            (id.clone(), before.map_or(*target, |before| towards(*before, *target)))
        };
        self.past.shown = self.past.solved.iter().map(step).collect();
        let level = mean(selected.iter().filter_map(|(id, _, standing)| {
            let share = standing.weight / (standing.nearest_2 + NEAR_M.powi(2));
            Some((*self.past.solved.get(*id)?, share))
        }));
        self.past.level = if jumped { level } else { towards(self.past.level, level) };
    }
}

/// The mean of logarithms by their weights; 0 of nothing.
fn mean(weighted: impl Iterator<Item = ([f64; 3], f64)>) -> [f64; 3] {
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for (logs, weight) in weighted {
        sum = [0, 1, 2].map(|channel| sum[channel] + weight * logs[channel]);
        weights += weight;
    }
    if weights > 0.0 { sum.map(|sum| sum / weights) } else { [0.0; 3] }
}

/// The logarithms of the next frame.
fn towards(before: [f64; 3], target: [f64; 3]) -> [f64; 3] {
    let left = [0, 1, 2].map(|channel| target[channel] - before[channel]);
    if left.iter().all(|left| left.abs() < SAME) {
        return target;
    }
    [0, 1, 2].map(|channel| before[channel] + STEP * left[channel])
}
