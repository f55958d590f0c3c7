//! The renderer's settings as reports give them.

use flaneur_renderer::{Settings, SplatRoute};
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

/// Every setting by its name. No limit is `null`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatedSettings(pub(crate) Settings);

impl StatedSettings {
    fn value(self) -> Value {
        // All by name, so that none is forgotten.
        let Settings {
            rigs,
            points_share,
            resolution,
            depth_map_side,
            depth_test,
            refine_by_points,
            near_first,
            texturing,
            exposure_gains,
            splat_scale,
            max_splat_radius_m,
            splat_normals,
            splat_route,
            quads_from_px,
            gpu_memory_bytes,
            align,
            infer,
            inferred_hypotheses,
            background,
        } = self.0;
        json!({
            "rigs": rigs,
            "points_share": points_share,
            "resolution": resolution,
            "depth_map_side": depth_map_side,
            "depth_test": depth_test,
            "refine_by_points": refine_by_points,
            "near_first": near_first,
            "texturing": texturing.name(),
            "exposure_gains": exposure_gains,
            "splat_scale": splat_scale,
            "max_splat_radius_m": max_splat_radius_m,
            "splat_normals": splat_normals.name(),
            "splat_route": match splat_route {
                SplatRoute::Auto => "auto",
                SplatRoute::Atomic64 => "64-bit atomics",
                SplatRoute::Atomic32 => "32-bit atomics",
            },
            "quads_from_px": quads_from_px,
            "gpu_memory_bytes": gpu_memory_bytes,
            "align": align,
            "infer": infer,
            "inferred_hypotheses": inferred_hypotheses,
            "background": background,
        })
    }
}

impl Serialize for StatedSettings {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.value().serialize(to)
    }
}

impl std::fmt::Display for StatedSettings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.value().fmt(f)
    }
}
