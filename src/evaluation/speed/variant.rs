//! The settings that are compared.

use flaneur_renderer::{Settings, SplatNormals, SplatRoute, Texturing};

use super::ladder::{HYPOTHESES, POINTS, RESOLUTIONS, RIGS, Rung};

/// Side of the most exact frame's depth maps, texels.
const LARGEST_MAP: u32 = 1024;

/// What a renderer is fed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Feed {
    /// Everything, at the levels that the view can show.
    Whole,
    /// The same, for a renderer whose points lie on the planes of their normals.
    OnPlanes,
    /// Photographs hold at most this share, as one part of so many, of the pixels of the whole.
    CoarserImages(u32),
    /// The whole, and what lies behind the eye.
    AndBehind,
}

/// Settings under a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variant {
    /// Which setting is traded for speed.
    pub(crate) method: &'static str,
    /// Its value.
    pub(crate) setting: String,
    /// What the renderer is fed with.
    pub(crate) feed: Feed,
    /// All settings.
    pub(crate) settings: Settings,
}

/// Settings that are the most exact in everything, from those that are used otherwise.
fn most_exact(base: Settings) -> Settings {
    Settings {
        depth_map_side: LARGEST_MAP,
        depth_test: true,
        refine_by_points: true,
        near_first: true,
        splat_route: SplatRoute::Auto,
        quads_from_px: None,
        texturing: Texturing::Deferred,
        exposure_gains: true,
        ..Rung::default().settings(base)
    }
}

/// Everything that is compared, the most exact first.
pub(crate) fn variants(base: Settings, has_atomic_64: bool) -> Vec<Variant> {
    let exact = most_exact(base);
    let variant = |method, setting: &dyn ToString, settings| Variant {
        method,
        setting: setting.to_string(),
        feed: Feed::Whole,
        settings,
    };
    let mut all = vec![
        variant("most exact", &"", exact),
        variant("default", &"", base),
        Variant { feed: Feed::AndBehind, ..variant("default", &"more behind the eye", base) },
    ];
    for &rigs in &RIGS[1..] {
        all.push(variant("rigs", &rigs, Settings { rigs, ..exact }));
    }
    for side in [512, 256, 128, 64] {
        let settings = Settings { depth_map_side: side, ..exact };
        all.push(variant("depth map side", &side, settings));
    }
    all.push(variant(
        "depth maps",
        &"of mesh alone",
        Settings { refine_by_points: false, ..exact },
    ));
    all.push(variant("depth test", &"off", Settings { depth_test: false, ..exact }));
    for &points_share in &POINTS[1..] {
        all.push(variant("points", &points_share, Settings { points_share, ..exact }));
    }
    for &resolution in &RESOLUTIONS[1..] {
        all.push(variant("resolution", &resolution, Settings { resolution, ..exact }));
    }
    for texturing in Texturing::ALL {
        if texturing != exact.texturing {
            let settings = Settings { texturing, ..exact };
            all.push(variant("texturing", &texturing.name(), settings));
        }
    }
    for inferred_hypotheses in HYPOTHESES[1..].iter().flatten().copied() {
        let settings = Settings { inferred_hypotheses, ..exact };
        all.push(variant("inferred depths", &inferred_hypotheses, settings));
    }
    all.push(variant("inferred depths", &"off", Settings { infer: false, ..exact }));
    let without_gains = Settings { exposure_gains: false, ..exact };
    all.push(variant("exposure gains", &"off", without_gains));
    all.push(variant("alignment", &"off", Settings { align: false, ..exact }));
    for (name, quads_from_px) in [("none", u32::MAX), ("all", 0)] {
        let settings = Settings { quads_from_px: Some(quads_from_px), ..exact };
        all.push(variant("quads", &name, settings));
    }
    let mut routes = vec![("32-bit atomics", SplatRoute::Atomic32)];
    if has_atomic_64 {
        routes.push(("64-bit atomics", SplatRoute::Atomic64));
    }
    for (name, splat_route) in routes {
        all.push(variant("splat route", &name, Settings { splat_route, ..exact }));
    }
    let on_planes = Settings { splat_normals: SplatNormals::Estimated, ..exact };
    all.push(Variant { feed: Feed::OnPlanes, ..variant("splat normals", &"estimated", on_planes) });
    for parts in [4, 16] {
        let images = variant("image pixels", &format!("1/{parts}"), exact);
        all.push(Variant { feed: Feed::CoarserImages(parts), ..images });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A variant that changes nothing would be reported as having no effect.
    #[test]
    fn each_variant_differs_from_all_others() {
        let all = variants(Settings::default(), true);
        for (index, a) in all.iter().enumerate() {
            for b in &all[..index] {
                assert!((a.method, &a.setting) != (b.method, &b.setting), "{a:?}");
                // The device's own choice of route is among the routes.
                let route = |v: &Variant| (v.method == "splat route").then(|| v.setting.clone());
                let same = (a.feed, a.settings) == (b.feed, b.settings);
                assert!(!same || route(a) != route(b), "{a:?} {b:?}");
            }
        }
        assert_eq!(all[0].method, "most exact");
        assert!(variants(Settings::default(), false).len() == all.len() - 1);
    }

    #[test]
    fn nothing_is_more_exact_than_the_first() {
        let all = variants(Settings::default(), false);
        let exact = all[0].settings;
        for Variant { settings, .. } in &all {
            assert!(settings.rigs <= exact.rigs && settings.resolution <= exact.resolution);
            assert!(settings.depth_map_side <= exact.depth_map_side);
            assert!(settings.points_share <= exact.points_share);
        }
    }
}
