//! What is to be fetched, what is under way, and what the receiver holds: decisions alone, without
//! network, clock or task, so that any order of events can be tried.

mod batch;
mod clusters;
mod held;
mod order;
mod part;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use flaneur_scene::{ImageId, PointNodeId, SceneUpdate, TileKey};

pub(crate) use batch::{Batch, BatchId, Room};
pub(crate) use held::Held;
pub use order::Order;
pub(crate) use part::{Part, Stage, Want};

/// How far above its limits a view may let the receiver go before what it does not want is dropped
/// at once, rather than when everything that it wants has come.
const OVERHANG: f64 = 1.25;

/// What a view wants, whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wishes {
    /// The parts, what must come first before what follows it.
    pub(crate) wants: Vec<Want>,
    /// Whether more may be wanted once what is wanted of the survey is known.
    pub(crate) open: bool,
    /// Tiles that stay.
    pub(crate) tiles: BTreeSet<TileKey>,
    /// Photographs that stay.
    pub(crate) images: BTreeSet<ImageId>,
    /// Nodes that stay.
    pub(crate) nodes: BTreeSet<PointNodeId>,
    /// Whether points come with normals.
    pub(crate) normals: bool,
    /// Most points and most pixels of photographs.
    pub(crate) most: (u64, u64),
}

/// How far a view has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Standing {
    /// Parts to come that are shown.
    pub(crate) remaining: u64,
    /// Nothing of the first stage is to come.
    pub(crate) complete_picture: bool,
    /// Nothing at all is to come.
    pub(crate) finished: bool,
}

/// What becomes of a part that could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It is asked for again.
    Again,
    /// It is asked for again, by itself: another part of its batch may be at fault.
    Alone,
    /// It is not, as long as this plan lives.
    Never,
}

/// The state of one receiver.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    order: Order,
    wishes: Wishes,
    held: Held,
    /// Every so many nodes of the terrain that is held; tiles without surface are held, too.
    steps: BTreeMap<TileKey, u32>,
    known: BTreeSet<Part>,
    /// Under way, from the request until it is decoded.
    flying: BTreeMap<Part, BatchId>,
    lost: BTreeSet<Part>,
    /// To be asked for by themselves.
    alone: BTreeSet<Part>,
    /// Fetched ahead, and so to be had without the network.
    ahead: BTreeSet<Part>,
    batches: u64,
}

impl Plan {
    /// Nothing wanted, nothing held.
    pub(crate) fn new(order: Order) -> Self {
        Self { order, ..Self::default() }
    }

    /// What the receiver holds.
    pub(crate) fn held(&self) -> &Held {
        &self.held
    }

    /// Whether a part of the survey is known.
    pub(crate) fn knows(&self, part: &Part) -> bool {
        self.known.contains(part) || self.lost.contains(part)
    }

    /// Wants something else from now on. The batches that this makes useless.
    pub(crate) fn look(&mut self, mut wishes: Wishes) -> Vec<BatchId> {
        order::sort(&mut wishes.wants, self.order);
        self.wishes = wishes;
        let wanted: BTreeSet<&Part> = self.wishes.wants.iter().map(|want| &want.part).collect();
        self.ahead.retain(|part| wanted.contains(part));
        let all: BTreeSet<BatchId> = self.flying.values().copied().collect();
        // The survey stays useful: someone who has gone comes back.
        let useful: BTreeSet<BatchId> = self
            .flying
            .iter()
            .filter(|(part, _)| part.is_survey() || wanted.contains(part))
            .map(|(_, batch)| *batch)
            .collect();
        let useless: Vec<BatchId> = all.difference(&useful).copied().collect();
        self.flying.retain(|_, batch| useful.contains(batch));
        useless
    }

    /// Bytes of what is wanted and not held, as far as they are known.
    pub(crate) fn missing_bytes(&self) -> u64 {
        let missing = self.wishes.wants.iter().filter(|want| self.is_missing(want));
        missing.fold(0, |bytes, want| bytes.saturating_add(want.bytes))
    }

    /// What to ask for next, as much as there is `room` for; `None` where all is there or under way.
    /// Nothing but what is to be known waits behind what a complete picture takes, what is only
    /// wanted ahead comes when nothing else does, and levels of images are passed over whose finer ones
    /// come soon.
    pub(crate) fn next(&mut self, room: Room) -> Option<Batch> {
        let busy = !self.flying.is_empty();
        let mut incomplete = self.wishes.open;
        let mut missing: Vec<&Want> = Vec::new();
        for want in self.wishes.wants.iter().filter(|want| self.is_missing(want)) {
            incomplete |= want.stage == Stage::First;
            let waits = match want.stage {
                Stage::First => false,
                Stage::Detail => incomplete && !want.part.is_survey(),
                Stage::Ahead => busy || incomplete,
            };
            if !waits && !self.flying.contains_key(&want.part) {
                missing.push(want);
            }
            if missing.len() == 512 {
                break;
            }
        }
        pass_over(&mut missing, &self.flying, &self.ahead, room.soon);
        let by_itself = missing.first().filter(|want| self.alone.contains(&want.part));
        let missing: Vec<&Want> = match by_itself {
            Some(want) => vec![want],
            None => missing.into_iter().filter(|want| !self.alone.contains(&want.part)).collect(),
        };
        let (parts, bytes) = batch::gather(&missing, room.bytes);
        if parts.is_empty() {
            return None;
        }
        let id = BatchId(self.batches);
        self.batches += 1;
        self.flying.extend(parts.iter().map(|part| (part.clone(), id)));
        Some(Batch { id, parts, bytes })
    }

    /// A part of the survey is known now.
    pub(crate) fn learn(&mut self, part: Part) {
        self.flying.remove(&part);
        self.known.insert(part);
    }

    /// A part has come and is decoded. What the receiver is to be told now; `None` where nobody wants
    /// the part any more.
    pub(crate) fn arrive(
        &mut self,
        part: &Part,
        updates: Vec<SceneUpdate>,
    ) -> Option<Vec<SceneUpdate>> {
        self.flying.remove(part);
        let want = self.wishes.wants.iter().find(|want| want.part == *part)?;
        if want.stage == Stage::Ahead {
            self.ahead.insert(part.clone());
            return None;
        }
        if !self.is_missing(want) {
            return None;
        }
        let mut told = Vec::new();
        match part {
            Part::Mesh { key, step } => {
                if updates.is_empty() && self.held.tiles.contains(key) {
                    told.push(SceneUpdate::DropMesh(*key));
                }
                self.steps.insert(*key, *step);
                told.extend(updates);
            }
            _ => told.extend(updates),
        }
        for update in &told {
            self.held.note(update);
        }
        let want = self.wishes.wants.iter().find(|want| want.part == *part);
        let gave = |id: &ImageId| {
            told.iter().any(|update| matches!(update, SceneUpdate::Image(image) if image.id == *id))
        };
        // Where other faces of a sphere are wanted than when it was decoded, it comes once more.
        if want.is_some_and(|want| self.is_missing(want) && want.photographs.iter().all(gave)) {
            // What came is not what was wanted, whatever it is: it would come for ever.
            self.lost.insert(part.clone());
        }
        let room = self.room();
        told.extend(room);
        Some(told)
    }

    /// A part of the survey was forgotten.
    pub(crate) fn unlearn(&mut self, part: &Part) {
        self.known.remove(part);
    }

    /// A part could not be had.
    pub(crate) fn fail(&mut self, part: &Part, verdict: Verdict) {
        self.flying.remove(part);
        match verdict {
            Verdict::Again => {}
            Verdict::Alone => _ = self.alone.insert(part.clone()),
            Verdict::Never => _ = self.lost.insert(part.clone()),
        }
    }

    /// Forgets what could not be had, so that it is asked for again.
    pub(crate) fn forgive(&mut self) {
        self.lost.clear();
        self.alone.clear();
    }

    /// The receiver has done something by itself. What it gave up of what is wanted it has no room
    /// for: it is not sent again before all is forgiven.
    pub(crate) fn note(&mut self, update: &SceneUpdate) {
        self.took_note(update);
        let declined = |want: &&Want| match (&want.part, update) {
            (Part::Mesh { key, .. }, SceneUpdate::DropMesh(dropped)) => key == dropped,
            (Part::Image { .. }, SceneUpdate::DropImage(id)) => want.photographs.contains(id),
            (Part::Node(id), SceneUpdate::DropPoints(dropped)) => id == dropped,
            _ => false,
        };
        let declined = self.wishes.wants.iter().filter(declined).map(|want| want.part.clone());
        self.lost.extend(declined);
    }

    fn took_note(&mut self, update: &SceneUpdate) {
        if let SceneUpdate::DropMesh(key) = update {
            self.steps.remove(key);
        }
        self.held.note(update);
    }

    /// The receiver holds a photograph at another level than it was sent: it has no room for finer
    /// ones, which are not sent again before all is forgiven.
    pub(crate) fn note_level(&mut self, id: &ImageId, level: u32) {
        if let Some((held, _)) = self.held.images.get_mut(id) {
            *held = level;
        }
        let declined = |want: &&Want| match &want.part {
            Part::Image { level: finer, .. } => *finer < level && want.photographs.contains(id),
            _ => false,
        };
        let declined = self.wishes.wants.iter().filter(declined).map(|want| want.part.clone());
        self.lost.extend(declined);
    }

    /// How far the view has come.
    pub(crate) fn standing(&self) -> Standing {
        let missing = || self.wishes.wants.iter().filter(|want| self.is_missing(want));
        let to_come = |want: &&Want| want.stage != Stage::Ahead;
        let shown = missing().filter(to_come).filter(|want| !want.part.is_survey());
        let first = missing().any(|want| want.stage == Stage::First);
        Standing {
            remaining: shown.count() as u64,
            complete_picture: !self.wishes.open && !first,
            finished: !self.wishes.open && !missing().any(|want| want.stage != Stage::Ahead),
        }
    }

    /// What the receiver is to drop once all that the view wants has come: everything else, finer
    /// nodes before those above them.
    pub(crate) fn drops(&mut self) -> Vec<SceneUpdate> {
        let drops: Vec<SceneUpdate> = self
            .unwanted_nodes()
            .into_iter()
            .map(SceneUpdate::DropPoints)
            .chain(self.unwanted_images().into_iter().map(SceneUpdate::DropImage))
            .chain(self.unwanted_tiles().into_iter().map(SceneUpdate::DropMesh))
            .collect();
        drops.iter().for_each(|drop| self.took_note(drop));
        let tiles = &self.wishes.tiles;
        self.steps.retain(|key, _| tiles.contains(key));
        drops
    }

    /// Drops of what the view does not want, as many as bring the receiver back near its limits.
    fn room(&mut self) -> Vec<SceneUpdate> {
        let (points, pixels) = self.wishes.most;
        let above = |held: u64, most: u64| held as f64 > most as f64 * OVERHANG;
        let mut drops = Vec::new();
        if above(self.held.point_count(), points) {
            drops.extend(self.unwanted_nodes().into_iter().map(SceneUpdate::DropPoints));
        }
        if above(self.held.pixels(), pixels) {
            drops.extend(self.unwanted_images().into_iter().map(SceneUpdate::DropImage));
        }
        let tiles = &self.wishes.tiles;
        if self.steps.len() as f64 > tiles.len() as f64 * OVERHANG {
            drops.extend(self.unwanted_tiles().into_iter().map(SceneUpdate::DropMesh));
            self.steps.retain(|key, _| tiles.contains(key));
        }
        drops.iter().for_each(|drop| self.held.note(drop));
        drops
    }

    /// Nodes that are held and not wanted, the deepest first.
    fn unwanted_nodes(&self) -> Vec<PointNodeId> {
        let mut nodes: Vec<_> = self.held.nodes.difference(&self.wishes.nodes).copied().collect();
        nodes.sort_by_key(|id| std::cmp::Reverse(id.key.level));
        nodes
    }

    fn unwanted_images(&self) -> Vec<ImageId> {
        let held = self.held.images.keys();
        held.filter(|id| !self.wishes.images.contains(id)).cloned().collect()
    }

    fn unwanted_tiles(&self) -> Vec<TileKey> {
        self.held.tiles.difference(&self.wishes.tiles).copied().collect()
    }

    /// Whether the receiver lacks what is wanted, and it can be had.
    fn is_missing(&self, want: &Want) -> bool {
        let fetched = want.stage == Stage::Ahead && self.ahead.contains(&want.part);
        if fetched || self.lost.contains(&want.part) {
            return false;
        }
        let serves = |held: u32, wanted: u32| held == wanted || (!want.exact && held < wanted);
        match &want.part {
            part if part.is_survey() => !self.known.contains(part),
            Part::Mesh { key, step } => {
                !self.steps.get(key).is_some_and(|&held| serves(held, *step))
            }
            Part::Image { level, .. } => !want
                .photographs
                .iter()
                .all(|id| self.held.images.get(id).is_some_and(|&(held, _)| serves(held, *level))),
            Part::Node(id) => !self.held.points.get(id).is_some_and(|(_, normals)| {
                normals.is_none_or(|normals| normals == self.wishes.normals)
            }),
            _ => false,
        }
    }
}

/// Leaves those levels of images out of `missing`, which is in the order of fetching, whose finer ones
/// are `flying`, or are to come within the `soon` bytes behind them, unless they were fetched `ahead`; of what is
/// wanted ahead, all but the finest. A level of the first stage makes the picture complete, and is not left out.
fn pass_over(
    missing: &mut Vec<&Want>,
    flying: &BTreeMap<Part, BatchId>,
    ahead: &BTreeSet<Part>,
    soon: u64,
) {
    let mut before: Vec<u64> = Vec::with_capacity(missing.len());
    let mut bytes = 0u64;
    for want in &*missing {
        before.push(bytes);
        bytes = bytes.saturating_add(want.bytes);
    }
    // Bytes until the next finer level of each image has come, from the end.
    let mut finer: HashMap<(Arc<str>, u16), u64> = HashMap::new();
    let mut kept = vec![true; missing.len()];
    for (index, want) in missing.iter().enumerate().rev() {
        let Part::Image { panorama, camera, level } = &want.part else { continue };
        let of_level =
            |level| Part::Image { panorama: Arc::clone(panorama), camera: *camera, level };
        let is_flying = flying.range(of_level(0)..of_level(*level)).next().is_some();
        let is_fetched = ahead.range(of_level(0)..of_level(*level)).next().is_some();
        let end = before[index].saturating_add(want.bytes);
        let next = finer.insert((Arc::clone(panorama), *camera), end);
        let comes_soon = next.is_some_and(|next| next <= before[index].saturating_add(soon));
        kept[index] = match want.stage {
            Stage::First => true,
            // What was fetched ahead is shown at once, and would be wasted otherwise.
            Stage::Detail => ahead.contains(&want.part) || !(is_flying || comes_soon),
            // Nobody waits for it: the finest alone serves, once it is looked at.
            Stage::Ahead => !is_flying && next.is_none() && !is_fetched,
        };
    }
    let mut kept = kept.into_iter();
    missing.retain(|_| kept.next().unwrap_or(true));
}
