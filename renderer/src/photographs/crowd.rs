//! Which photographs give way where there is no room for all.

use std::collections::{BTreeMap, BTreeSet};

use flaneur_scene::{ImageId, ImageUpdate, Lens};
use glam::{DVec3, UVec2};

use super::layout::{NoPlace, Place, level_size};
use super::{LensData, Photograph, PhotographStore};
use crate::Gpu;

/// Photographs of at most so many pixels a side are not made coarser: next to nothing is won.
const COARSEST_PX: u32 = 128;

/// What became of photographs for want of room.
#[derive(Debug, Default)]
pub(crate) struct Crowded {
    /// Those that are gone.
    pub(crate) evicted: Vec<ImageId>,
    /// Those that were made coarser and are still there.
    pub(crate) coarser: BTreeSet<ImageId>,
    /// Whether there was no room for what was to be added.
    pub(crate) refused: bool,
}

impl Crowded {
    fn give_up(&mut self, id: ImageId) {
        self.coarser.remove(&id);
        self.evicted.push(id);
    }
}

/// One of the things that together make room.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// A photograph gives up its finest level.
    Coarsen(ImageId),
    /// A photograph goes.
    Remove(ImageId),
}

/// The photographs that are there while room is planned: where they lie, and how far from the eye.
type Crowd<'a> = BTreeMap<&'a ImageId, (Place, f64)>;

impl PhotographStore {
    /// What makes room for `update`; [`NoPlace::Memory`] where all else is more useful. Nothing is
    /// changed yet.
    pub(super) fn plan_room(
        &self,
        update: &ImageUpdate,
        eye: DVec3,
        most: u64,
    ) -> Result<Vec<Step>, NoPlace> {
        let mut layout = self.atlas.layout().clone();
        let mut crowd: Crowd<'_> = self
            .photographs
            .iter()
            .map(|(id, photograph)| {
                (id, (photograph.place, photograph.camera.centre.distance(eye)))
            })
            .collect();
        let mut steps = Vec::new();
        loop {
            match layout.clone().take(update.size, most) {
                Ok(_) => return Ok(steps),
                Err(NoPlace::Memory) => {}
                Err(reason) => return Err(reason),
            }
            let own = crowd.get(&update.id).map(|(place, _)| *place);
            let step = match least_useful(&crowd, update, eye) {
                Some(step) => step,
                // At last the pixels that it would replace, where that makes room.
                None => {
                    let mut without = layout.clone();
                    without.remove(&own.ok_or(NoPlace::Memory)?);
                    without.take(update.size, most)?;
                    Step::Remove(update.id.clone())
                }
            };
            match &step {
                Step::Coarsen(id) => {
                    if let Some((id, (place, distance_m))) = crowd.remove_entry(id)
                        && let Some(moved) = layout.coarsen(&place, most)
                    {
                        crowd.insert(id, (moved, distance_m));
                    }
                }
                Step::Remove(id) => {
                    if let Some((place, _)) = crowd.remove(id) {
                        layout.remove(&place);
                    }
                }
            }
            steps.push(step);
        }
    }

    /// Does what was planned to make room for the photograph `newcomer`.
    pub(super) fn make_room(
        &mut self,
        gpu: &Gpu,
        steps: Vec<Step>,
        newcomer: &ImageId,
        most: u64,
        crowded: &mut Crowded,
    ) {
        for step in steps {
            match step {
                Step::Coarsen(id) => {
                    if self.coarsen(gpu, &id, most) {
                        crowded.coarser.insert(id);
                    } else {
                        crowded.give_up(id);
                    }
                }
                Step::Remove(id) => {
                    self.remove(&id);
                    if id != *newcomer {
                        crowded.give_up(id);
                    }
                }
            }
        }
    }

    /// Keeps the photograph at half its size, where the device can; else it is gone.
    fn coarsen(&mut self, gpu: &Gpu, id: &ImageId, most: u64) -> bool {
        let Some(mut photograph) = self.photographs.remove(id) else { return false };
        let Some(place) = self.atlas.coarsen(gpu, &photograph.place, most) else { return false };
        self.revision += 1;
        photograph.place = place;
        photograph.halve(self.revision);
        self.photographs.insert(id.clone(), photograph);
        true
    }
}

/// Which other photograph is to give way first; `None` where all are more useful than `update`.
///
/// A photograph has the less use for its pixels the more it has of them and the farther it is: that
/// with the most of one times the other gives up its finest level. Once all have as few as can be,
/// the farthest goes.
fn least_useful(crowd: &Crowd<'_>, update: &ImageUpdate, eye: DVec3) -> Option<Step> {
    let own_m = update.camera.centre.distance(eye);
    let detail = |size: UVec2, distance_m: f64| f64::from(size.max_element()) * distance_m;
    let own = detail(update.size, own_m);
    let others = || crowd.iter().filter(|(id, _)| ***id != update.id);
    let finest = others()
        .filter(|(_, (place, _))| place.size.max_element() > COARSEST_PX)
        .map(|(id, (place, distance_m))| (*id, detail(place.size, *distance_m)))
        .filter(|(_, other)| *other > own)
        .max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(b.0)));
    if let Some((id, _)) = finest {
        return Some(Step::Coarsen(id.clone()));
    }
    let farthest = others()
        .map(|(id, (_, distance_m))| (*id, *distance_m))
        .filter(|(_, farthest_m)| *farthest_m > own_m)
        .max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(b.0)));
    farthest.map(|(id, _)| Step::Remove(id.clone()))
}

impl Photograph {
    /// Takes note that its pixels are those of the next level.
    fn halve(&mut self, revision: u64) {
        let size = level_size(self.resident.size, 1);
        // Of an odd size the last pixel stands for half as much: all are twice as large as before.
        self.resident = Lens { size: 2 * size, ..self.resident }.scaled_to(size);
        self.lens = LensData::new(&self.resident);
        self.level += 1;
        self.revision = revision;
    }
}
