//! What is learnt of a survey stays, so that who comes back finds it, but not without bound: a survey
//! may be that of a country, and each photograph may have a mask of its own.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use super::{Survey, Target, Targets};
use crate::ViewRequest;
use crate::choose::district_bounds;
use crate::plan::Part;

/// Panoramas that are remembered wherever they are. Each takes some kilobytes.
const PANORAMAS: usize = 20_000;
/// Beyond that, those within so many times the radius in which a view uses them.
const REACH: f64 = 2.0;
/// Bytes of masks that are remembered whoever wants them.
const MASK_BYTES: usize = 128 << 20;

impl Survey {
    /// Forgets what neither `request` nor the `targets` that it came to need, where too much is known.
    /// The parts that are not known any more.
    pub(crate) fn forget(&mut self, request: &ViewRequest, targets: &Targets) -> Vec<Part> {
        let mut forgotten = self.forget_panoramas(request, PANORAMAS);
        forgotten.extend(self.forget_masks(targets, MASK_BYTES));
        forgotten
    }

    fn forget_panoramas(&mut self, request: &ViewRequest, most: usize) -> Vec<Part> {
        if self.panoramas.values().map(|district| 1 + district.len()).sum::<usize>() <= most {
            return Vec::new();
        }
        let eye = request.view.eye().truncate();
        let reach_m = REACH * request.limits.panorama_radius_m * request.steadiness;
        let far = |district| district_bounds(district).distance(eye) > reach_m;
        let forgotten = self.panoramas.extract_if(.., |&district, _| far(district));
        forgotten.map(|(district, _)| Part::Panoramas(district)).collect()
    }

    fn forget_masks(&mut self, targets: &Targets, most: usize) -> Vec<Part> {
        if self.masks.values().map(|mask| mask.bytes()).sum::<usize>() <= most {
            return Vec::new();
        }
        let used: BTreeSet<&str> = targets
            .values()
            .filter_map(|target| match target {
                Target::Image(image, _) => image.rig_camera().mask.as_ref(),
                _ => None,
            })
            .map(|mask| mask.name.as_str())
            .collect();
        let forgotten = self.masks.extract_if(.., |name, _| !used.contains(&**name));
        forgotten.map(|(name, _)| Part::Mask(name)).collect()
    }
}
