//! Which photographs give way where there is no room for all.

use std::collections::BTreeSet;

use flaneur_scene::{ImageId, ImageUpdate, Lens};
use glam::{DVec3, UVec2};

use super::atlas::level_size;
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

impl PhotographStore {
    /// Makes some room for `update`; `false` where all else is more useful.
    ///
    /// A photograph has the less use for its pixels the more it has of them and the farther it is:
    /// that with the most of one times the other gives up its finest level. Once all have as few as
    /// can be, the farthest goes. At last the coarser pixels go that `update` would replace, where
    /// that makes room.
    pub(super) fn make_room(
        &mut self,
        gpu: &Gpu,
        update: &ImageUpdate,
        eye: DVec3,
        most: u64,
        crowded: &mut Crowded,
    ) -> bool {
        let distance_m = update.camera.centre.distance(eye);
        let detail = |size: UVec2, distance_m: f64| f64::from(size.max_element()) * distance_m;
        let others = || {
            let others = self.photographs.iter().filter(|(id, _)| **id != update.id);
            others.map(|(id, other)| (id, other, other.camera.centre.distance(eye)))
        };
        let finest = others()
            .filter(|(_, other, _)| other.place.size.max_element() > COARSEST_PX)
            .map(|(id, other, distance_m)| (id, detail(other.place.size, distance_m)))
            .filter(|(_, other)| *other > detail(update.size, distance_m))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(b.0)));
        if let Some((id, _)) = finest {
            let id = id.clone();
            if self.coarsen(gpu, &id, most) {
                crowded.coarser.insert(id);
            } else {
                crowded.give_up(id);
            }
            return true;
        }
        let farthest = others()
            .map(|(id, _, farthest_m)| (id, farthest_m))
            .filter(|(_, farthest_m)| *farthest_m > distance_m)
            .max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(b.0)));
        if let Some((id, _)) = farthest {
            let id = id.clone();
            self.remove(&id);
            crowded.give_up(id);
            return true;
        }
        let replaced = self.photographs.get(&update.id).map(|before| before.place);
        let makes_room = replaced.is_some_and(|place| self.atlas.fits_without(&place, update.size));
        if makes_room {
            self.remove(&update.id);
        }
        makes_room
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
