//! All that a view wants, as far as the survey is known.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use flaneur_proto::v1;
use flaneur_scene::{IdError, ImageId, Panorama, PointNodeId, StoredImage, TileKey, TileLayer};

use super::node_gains::of_nodes;
use super::{Candidates, Survey, gain};
use crate::ViewRequest;
use crate::choose::{
    WantedImage, WantedNode, choose_nodes, choose_photographs, choose_tiles, district_bounds,
};
use crate::plan::{Held, Part, Stage, Want, Wishes};
use crate::sight::Sight;

/// A complete picture is decided by the first images up to this share.
const COMPLETE: f64 = 0.9;
/// About how many bytes a panorama, a page of a hierarchy, and a tile of buildings take.
const PANORAMAS_BYTES: u64 = 8 << 10;
const PAGE_BYTES: u64 = 4 << 10;
const BUILDINGS_BYTES: u64 = 4 << 10;
/// And a whole tile of terrain, and what is left of it however coarse.
const GROUND_BYTES: u64 = 5 << 10;
const LEAST_GROUND_BYTES: u64 = 64;
/// What a tile of mesh gains that the view does not see, as a share: it hides things from
/// photographs.
const UNSEEN_TILE: f64 = 0.02;
/// What it gains to know what there is: more than anything that is shown.
const KNOWING: f64 = f64::MAX;
/// Mesh in sight within this distance belongs to a complete picture, metres.
const FIRST_MESH_M: f64 = 120.0;

/// What it takes to fetch and decode a part.
#[derive(Clone, Debug)]
pub(crate) enum Target {
    /// Nothing but its name.
    Named,
    /// How a request names a mask, and what its file is.
    Mask(v1::ImageKey, StoredImage),
    /// A level of an image.
    Image(WantedImage, u32),
    /// A node.
    Node(WantedNode),
}

impl Target {
    /// What it is, for people.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Named => "an answer".to_owned(),
            Self::Mask(key, _) => format!("the mask of {}/{}", key.panorama, key.camera),
            Self::Image(image, level) => image.name(*level),
            Self::Node(wanted) => {
                format!("node {:?} of point source {}", wanted.id.key, wanted.id.source)
            }
        }
    }
}

/// Targets of all parts that are wanted.
pub(crate) type Targets = HashMap<Part, Target>;

/// What `request` wants, and what the view `ahead` that is about to come wants beside it. `held`: what
/// the receiver holds; `knows`: whether a part of the survey is known.
pub(crate) fn wishes(
    survey: &Survey,
    request: &ViewRequest,
    ahead: Option<&ViewRequest>,
    held: &Held,
    knows: &dyn Fn(&Part) -> bool,
) -> Result<(Wishes, Targets), IdError> {
    let mut list = List::of(survey, request, held, knows)?;
    if let Some(ahead) = ahead {
        let mut later = List::of(survey, ahead, held, knows)?;
        later.wishes.wants.retain(|want| !list.targets.contains_key(&want.part));
        for want in &mut later.wishes.wants {
            want.stage = Stage::Ahead;
            if let Some(target) = later.targets.remove(&want.part) {
                list.targets.insert(want.part.clone(), target);
            }
        }
        list.wishes.wants.append(&mut later.wishes.wants);
    }
    Ok((list.wishes, list.targets))
}

/// Wishes in the making.
struct List<'a> {
    survey: &'a Survey,
    request: &'a ViewRequest,
    sight: Sight,
    exact: bool,
    wishes: Wishes,
    targets: Targets,
}

impl<'a> List<'a> {
    fn of(
        survey: &'a Survey,
        request: &'a ViewRequest,
        held: &Held,
        knows: &dyn Fn(&Part) -> bool,
    ) -> Result<Self, IdError> {
        let wishes = Wishes {
            normals: request.normals,
            most: (request.limits.points, request.limits.image_pixels),
            ..Wishes::default()
        };
        let exact = request.steadiness <= 1.0;
        let sight = survey.surfaces.sight(&request.view);
        let mut list = Self { survey, request, sight, exact, wishes, targets: Targets::new() };
        let candidates = survey.candidates(request, knows);
        list.districts(&candidates);
        list.tiles(&held.tiles);
        // Before all around is known, others might be nearer.
        if candidates.missing_around.is_empty() {
            list.images(&candidates, held)?;
        } else {
            list.wishes.open = true;
        }
        list.nodes(&candidates, &held.nodes);
        Ok(list)
    }

    fn districts(&mut self, candidates: &Candidates) {
        for &district in &candidates.missing_around {
            let part = Part::Panoramas(district);
            self.want(part, Target::Named, Stage::First, PANORAMAS_BYTES, KNOWING, 0.0);
        }
        let eye = self.request.view.eye().truncate();
        let nearest_m = candidates.nearest_m(eye);
        for &district in &candidates.missing_beyond {
            let distance_m = district_bounds(district).distance(eye);
            let gain = nearest_m.map_or(KNOWING, |m| gain::of_district(distance_m, m));
            let part = Part::Panoramas(district);
            self.want(part, Target::Named, Stage::Detail, PANORAMAS_BYTES, gain, distance_m);
        }
    }

    fn tiles(&mut self, held: &BTreeSet<TileKey>) {
        for tile in choose_tiles(&self.survey.scene, self.request, held) {
            let seen = if tile.seen { 1.0 } else { UNSEEN_TILE };
            let gain = seen * gain::of_tile(tile.distance_m, &self.request.view);
            let is_first = tile.seen && tile.distance_m <= FIRST_MESH_M;
            let stage = if is_first { Stage::First } else { Stage::Detail };
            let bytes = match tile.key.layer {
                TileLayer::Footprints => BUILDINGS_BYTES,
                TileLayer::Ground => {
                    LEAST_GROUND_BYTES + GROUND_BYTES / u64::from(tile.step * tile.step)
                }
            };
            self.wishes.tiles.insert(tile.key);
            let part = Part::Mesh { key: tile.key, step: tile.step };
            self.want(part, Target::Named, stage, bytes, gain, tile.distance_m);
        }
    }

    fn images(&mut self, candidates: &Candidates, held: &Held) -> Result<(), IdError> {
        let request = self.request;
        let held: BTreeSet<&str> = held.images.keys().map(ImageId::panorama).collect();
        let favour = |panorama: &Panorama| {
            if held.contains(panorama.id.as_str()) { request.steadiness } else { 1.0 }
        };
        let (view, limits, excluded) = (&request.view, &request.limits, &*request.excluded);
        let mut images = choose_photographs(
            candidates.panoramas.clone(),
            view,
            &self.sight,
            limits,
            excluded,
            &favour,
        )?;
        images.sort_by(|a, b| b.share_anywhere.total_cmp(&a.share_anywhere));
        let (all, mut decided): (f64, f64) =
            (images.iter().map(|image| image.share_anywhere).sum(), 0.0);
        for image in images {
            let stage = if decided <= COMPLETE * all { Stage::First } else { Stage::Detail };
            decided += image.share_anywhere;
            self.image(&image, stage);
        }
        Ok(())
    }

    fn image(&mut self, image: &WantedImage, first_stage: Stage) {
        let camera = image.rig_camera();
        if let Some(mask) = &camera.mask {
            let name: Arc<str> = mask.name.as_str().into();
            if !self.survey.masks.contains_key(&name) {
                let key = image.key(0, v1::ImageLayer::Mask);
                let target = Target::Mask(key, mask.image);
                self.want(Part::Mask(name), target, first_stage, mask.image.bytes, KNOWING, 0.0);
            }
        }
        let photographs: Arc<[ImageId]> =
            image.photographs.iter().map(|(id, ..)| id.clone()).collect();
        self.wishes.images.extend(photographs.iter().cloned());
        let panorama: Arc<str> = image.panorama.id.as_str().into();
        let distance_m = image.panorama.position.distance(self.request.view.eye());
        let (mut from, mut stage) = (None, first_stage);
        for level in image.steps() {
            let Some(stored) = camera.levels.get(level as usize) else { continue };
            let gain = gain::of_image(image, from, level);
            let part =
                Part::Image { panorama: Arc::clone(&panorama), camera: image.camera as u16, level };
            let exact = self.exact && level == image.level;
            let target = Target::Image(image.clone(), level);
            if let Some(want) = self.want(part, target, stage, stored.bytes, gain, distance_m) {
                want.photographs = Arc::clone(&photographs);
                want.exact = exact;
            }
            (from, stage) = (Some(level), Stage::Detail);
        }
    }

    fn nodes(&mut self, candidates: &Candidates, held: &BTreeSet<PointNodeId>) {
        let survey = self.survey;
        let sources = &survey.scene.point_sources;
        let chosen = choose_nodes(&survey.hierarchy, sources, self.request, held);
        for page in chosen.missing {
            self.want(Part::Page(page), Target::Named, Stage::Detail, PAGE_BYTES, KNOWING, 0.0);
        }
        let baseline_m = candidates.nearest_m(self.request.view.eye().truncate());
        let (view, sight) = (&self.request.view, &self.sight);
        let gains = of_nodes(&chosen.wanted, sources, held, view, sight, baseline_m);
        for (wanted, gain) in chosen.wanted.into_iter().zip(gains) {
            let source = wanted.id.source;
            if !survey.tracks.contains_key(&source)
                && !self.targets.contains_key(&Part::Stations(source))
            {
                let part = Part::Stations(source);
                self.want(part, Target::Named, Stage::Detail, PAGE_BYTES, KNOWING, 0.0);
            }
            self.wishes.nodes.insert(wanted.id);
            let bytes = u64::from(wanted.node.byte_size);
            let (part, distance_m) = (Part::Node(wanted.id), wanted.distance_m);
            self.want(part, Target::Node(wanted), Stage::Detail, bytes, gain, distance_m);
        }
    }

    fn want(
        &mut self,
        part: Part,
        target: Target,
        stage: Stage,
        bytes: u64,
        gain: f64,
        distance_m: f64,
    ) -> Option<&mut Want> {
        if self.targets.contains_key(&part) {
            return None;
        }
        self.targets.insert(part.clone(), target);
        let (photographs, exact) = ([].into(), self.exact);
        let want = Want { part, stage, bytes, gain, distance_m, photographs, exact };
        self.wishes.wants.push(want);
        self.wishes.wants.last_mut()
    }
}
