//! Districts: squares of the plan, of each of which one panorama stands for all. After Park et al.,
//! section 3.1.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use flaneur_scene::{Bounds2, Panorama};
use glam::{DVec2, IVec2};

/// Length of a district's side, metres.
pub(crate) const DISTRICT_M: f64 = 50.0;

/// Column and row of a district, aligned with the world.
pub(crate) type District = (i32, i32);

/// The district that holds `p`; `None` where no projected CRS reaches.
pub(crate) fn district_of(p: DVec2) -> Option<District> {
    // Far beyond any CRS, far within i32 once divided by the side.
    let reachable = p.is_finite() && p.abs().max_element() < 1e10;
    let cell: IVec2 = (p / DISTRICT_M).floor().as_ivec2();
    reachable.then_some((cell.x, cell.y))
}

/// The square of a district.
pub(crate) fn district_bounds((x, y): District) -> Bounds2 {
    let min = DVec2::new(f64::from(x), f64::from(y)) * DISTRICT_M;
    Bounds2 { min, max: min + DISTRICT_M }
}

/// The district of `p` and its neighbours.
pub(crate) fn districts_around(p: DVec2) -> Vec<District> {
    let Some((x, y)) = district_of(p) else { return Vec::new() };
    (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y))).collect()
}

/// The districts that `region` meets and `scene`, too.
pub(crate) fn districts_in(region: &Bounds2, scene: &Bounds2) -> Vec<District> {
    let low = district_of(region.min.max(scene.min));
    let high = district_of(region.max.min(scene.max));
    let (Some(low), Some(high)) = (low, high) else { return Vec::new() };
    (low.1..=high.1).flat_map(|y| (low.0..=high.0).map(move |x| (x, y))).collect()
}

/// The panoramas that stand for the districts around `eye`, by name: of each the nearest to its
/// centre. Those that `favour` makes more of than 1 stay so many times farther away.
pub(super) fn representatives(
    panoramas: &[Arc<Panorama>],
    eye: DVec2,
    favour: &dyn Fn(&Panorama) -> f64,
) -> BTreeSet<String> {
    let around: BTreeSet<District> = districts_around(eye).into_iter().collect();
    let mut nearest: BTreeMap<District, (f64, &str)> = BTreeMap::new();
    for panorama in panoramas {
        let at = panorama.position.truncate();
        let Some(district) = district_of(at) else { continue };
        let bounds = district_bounds(district);
        let favour = favour(panorama);
        let stays = favour > 1.0 && bounds.distance(eye) <= favour * DISTRICT_M;
        if !stays && !around.contains(&district) {
            continue;
        }
        let candidate = (at.distance(bounds.min.midpoint(bounds.max)), panorama.id.as_str());
        let best = nearest.entry(district).or_insert(candidate);
        if candidate.0.total_cmp(&best.0).then(candidate.1.cmp(best.1)).is_lt() {
            *best = candidate;
        }
    }
    nearest.into_values().map(|(_, id)| id.to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::world_from_rig;
    use glam::DVec3;

    fn panorama(id: &str, at: DVec2) -> Arc<Panorama> {
        Arc::new(Panorama {
            id: id.into(),
            position: DVec3::new(at.x, at.y, 42.0),
            world_from_rig: world_from_rig(0.0, 0.0, 0.0),
            time: None,
            uncertainty_m: 0.1,
            cameras: Vec::new(),
        })
    }

    #[test]
    fn of_each_district_around_the_nearest_to_its_centre_stands_for_it() {
        let at = |x: f64, y: f64| DVec2::new(651_000.0 + x, 6_861_000.0 + y);
        let all = [
            panorama("here, off centre", at(5.0, 5.0)),
            panorama("here, at its centre", at(24.0, 26.0)),
            panorama("next", at(-1.0, 10.0)),
            panorama("two on", at(110.0, 10.0)),
        ];
        let chosen = representatives(&all, at(10.0, 10.0), &|_| 1.0);
        assert_eq!(chosen.iter().collect::<Vec<_>>(), ["here, at its centre", "next"]);
        let held = |panorama: &Panorama| if panorama.id == "two on" { 1.25 } else { 1.0 };
        assert_eq!(representatives(&all, at(39.0, 10.0), &held).len(), 3, "it stays for 61 m");
        assert_eq!(representatives(&all, at(37.0, 10.0), &held).len(), 2);
        assert!(representatives(&all, DVec2::NAN, &|_| 1.0).is_empty());
    }

    #[test]
    fn districts_cover_a_region_within_the_scene() {
        let scene = Bounds2 { min: DVec2::ZERO, max: DVec2::splat(149.0) };
        let around = Bounds2 { min: DVec2::splat(-1e6), max: DVec2::splat(1e6) };
        assert_eq!(districts_in(&around, &scene).len(), 9);
        let one = Bounds2 { min: DVec2::splat(60.0), max: DVec2::splat(61.0) };
        assert_eq!(districts_in(&one, &scene), [(1, 1)]);
        assert!(district_bounds((1, 1)).min == DVec2::splat(50.0));
        assert!(districts_in(&Bounds2::EMPTY, &scene).is_empty());
    }
}
