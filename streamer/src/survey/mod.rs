//! What is known of a scene: what there is to choose from, rather than what is shown.

mod forget;
mod gain;
mod node_gains;
mod wishes;

use std::collections::BTreeMap;
use std::sync::Arc;

use flaneur_scene::{Panorama, SceneInfo};
use glam::DVec2;

use crate::ViewRequest;
use crate::choose::{District, Hierarchy, district_bounds, districts_around, districts_in};
use crate::decode::{Mask, Track};
use crate::plan::Part;
use crate::sight::Surfaces;

pub(crate) use wishes::{Target, Targets, wishes};

/// Candidates that are looked at for each panorama that may be used: some see nothing of
/// what the view sees.
const CANDIDATES: usize = 4;

/// Everything that has been learnt.
#[derive(Debug)]
pub(crate) struct Survey {
    pub(crate) scene: Arc<SceneInfo>,
    pub(crate) hierarchy: Hierarchy,
    pub(crate) panoramas: BTreeMap<District, Vec<Arc<Panorama>>>,
    pub(crate) tracks: BTreeMap<u16, Arc<Track>>,
    pub(crate) masks: BTreeMap<Arc<str>, Arc<Mask>>,
    /// What the receiver holds of the mesh.
    pub(crate) surfaces: Surfaces,
}

/// The panoramas that a view may use.
struct Candidates {
    /// Nearest first.
    panoramas: Vec<Arc<Panorama>>,
    /// Districts around the eye of which nothing is known.
    missing_around: Vec<District>,
    /// Districts farther away that may hold some, of which nothing is known.
    missing_beyond: Vec<District>,
}

impl Survey {
    /// Nothing but what the scene says of itself.
    pub(crate) fn new(scene: Arc<SceneInfo>) -> Self {
        Self {
            scene,
            hierarchy: Hierarchy::default(),
            panoramas: BTreeMap::new(),
            tracks: BTreeMap::new(),
            masks: BTreeMap::new(),
            surfaces: Surfaces::default(),
        }
    }

    /// The nearest panoramas within the radius, as many as may matter, and the districts that must be
    /// known before it is certain that they are. `knows` says of which districts all is known.
    fn candidates(&self, request: &ViewRequest, knows: &dyn Fn(&Part) -> bool) -> Candidates {
        let mut found = Candidates {
            panoramas: Vec::new(),
            missing_around: Vec::new(),
            missing_beyond: Vec::new(),
        };
        if self.scene.panoramas == 0 {
            return found;
        }
        let eye = request.view.eye().truncate();
        let radius_m = request.limits.panorama_radius_m;
        let away = |panorama: &Panorama| panorama.position.truncate().distance(eye);
        let disc = flaneur_scene::Bounds2 { min: eye - radius_m, max: eye + radius_m };
        let mut districts: Vec<(f64, District)> = districts_in(&disc, &self.scene.bounds.plan())
            .into_iter()
            .map(|district| (district_bounds(district).distance(eye), district))
            .filter(|(distance, _)| *distance <= radius_m)
            .collect();
        districts.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let around = districts_around(eye);
        let enough = CANDIDATES * request.limits.panoramas;
        let (mut usable, mut unknown_from) = (Vec::new(), f64::INFINITY);
        for (distance, district) in districts {
            let nearer = usable.iter().filter(|&&m: &&f64| m < distance).count();
            let is_around = around.contains(&district);
            if !is_around && (nearer >= enough || distance > unknown_from) {
                break;
            }
            if !knows(&Part::Panoramas(district)) {
                if is_around {
                    found.missing_around.push(district);
                } else {
                    // What lies a district further is asked for with it, not what lies beyond.
                    unknown_from = unknown_from.min(distance + crate::choose::DISTRICT_M);
                    found.missing_beyond.push(district);
                }
            }
            for panorama in self.panoramas.get(&district).into_iter().flatten() {
                if away(panorama) <= radius_m && may_be_used(panorama, request) {
                    usable.push(away(panorama));
                    found.panoramas.push(Arc::clone(panorama));
                }
            }
        }
        found.panoramas.sort_by(|a, b| away(a).total_cmp(&away(b)).then(a.id.cmp(&b.id)));
        found.panoramas.truncate(enough);
        found
    }
}

impl Candidates {
    /// From the eye to the nearest, in the plan, metres.
    fn nearest_m(&self, eye: DVec2) -> Option<f64> {
        self.panoramas.first().map(|panorama| panorama.position.truncate().distance(eye))
    }
}

/// Whether any of its photographs is not excluded.
fn may_be_used(panorama: &Panorama, request: &ViewRequest) -> bool {
    // Names were checked when it came.
    let photographs = panorama.photographs().unwrap_or_default();
    photographs.iter().any(|(id, _)| !(request.excluded)(id))
}
