//! Constants that stand in a shader and on the host have one value.
//!
//! The host's is their home, with its reason: that of the reference, where there is one.

use flaneur_scene::SurfaceClass;

use crate::Surface;
use crate::mesh::reference::NO_MESH_M;
use crate::shader_tests::sources;
use crate::{
    align, depth_map, depths, diffuse, gains, infer, pick, pinhole, points, rest, shade, splat,
    surface, tiles,
};

/// The name in shaders, its value on the host, and in which shader where the name means another
/// thing in others.
fn homes() -> Vec<(&'static str, f64, Option<&'static str>)> {
    let depth_test = [
        ("POINT_NOISE_M", depth_map::reference::POINT_NOISE_M),
        ("POINT_M", depth_map::reference::POINT_NOISE_M),
        ("LEAST_SLOPE", depth_map::reference::LEAST_SLOPE),
        ("UNDECIDED_M", depth_map::reference::UNDECIDED_M),
        ("UNDECIDED", depth_map::reference::UNDECIDED),
    ];
    let surfaces = [
        ("SAME_SURFACE_M", surface::reference::SAME_SURFACE_M),
        ("RELIEF_M", surface::reference::RELIEF_M),
        ("NOTHING_M", NO_MESH_M),
        ("HAS_RELIEF", pick::HAS_RELIEF.into()),
        ("KIND_BITS", depths::KIND_BITS.into()),
        ("SHOWS_MESH", depths::SHOWS_MESH.into()),
        ("SHOWS_POINT", depths::SHOWS_POINT.into()),
        // Without colour it has the code of its kind.
        ("SHOWS_INFERRED", f64::from(Surface::Completed as u8)),
        ("GROUND", f64::from(SurfaceClass::Ground as u32)),
        ("LEAST_COSINE", splat::reference::LEAST_COSINE),
        ("BLOCK_POINTS", points::BLOCK_POINTS as f64),
    ];
    let photographs = [
        ("NEAREST_DEPTH_M", shade::reference::NEAREST_DEPTH_M),
        ("MAX_TANGENT", pinhole::MAX_TANGENT),
        ("OPAQUE", shade::reference::OPAQUE),
        ("NEAREST_M", shade::reference::NEAREST_M),
        ("SEEN_COSINE", shade::reference::SEEN_COSINE),
        ("FEATHER", shade::reference::FEATHER),
        ("INFERRED_OFF", shade::reference::INFERRED_OFF),
        ("TILE", tiles::TILE.into()),
        ("BLOCK", tiles::BLOCK.into()),
        ("UNHEARD", rest::reference::UNHEARD),
        ("MAX_RIGS", rest::MAX_RIGS as f64),
        ("AT_ONCE", rest::AT_ONCE as f64),
    ];
    let exposure = [
        // How far two measures of one surface may be apart.
        ("AGREES_M", surface::reference::SAME_SURFACE_M),
        ("AGREES_SHARE", gains::reference::AGREES_SHARE),
        ("SAME_SURFACE_SHARE", gains::reference::SAME_SURFACE_SHARE),
        ("FOOTPRINT", gains::reference::FOOTPRINT),
        ("LEAST_TEXELS", gains::reference::LEAST_TEXELS),
    ];
    let inference = [
        ("SAMPLES", infer::reference::SAMPLES.into()),
        ("WORST", infer::reference::WORST),
        ("UNSEEN", infer::reference::UNSEEN),
        ("PRIOR", infer::reference::PRIOR),
        ("KEPT", infer::reference::KEPT),
        ("COARSER", infer::reference::COARSER),
        ("CELLS", diffuse::FEW_CELLS.into()),
    ];
    let in_one = [
        ("REACH", infer::reference::REACH.into(), "window"),
        ("REACH", align::reference::AROUND.into(), "pair"),
        ("REACH", align::reference::AROUND.into(), "pattern"),
        ("REACH", align::reference::WINDOW.into(), "along"),
        ("REACH", align::reference::WINDOW.into(), "solve"),
        ("ALIKE", align::reference::OTHER, "along"),
        ("ALIKE", align::reference::ALIKE, "solve"),
        ("NOISE", align::reference::NOISE, "solve"),
        ("LONGEST", align::reference::LONGEST, "solve"),
    ];
    let everywhere = [&depth_test[..], &surfaces, &photographs, &exposure, &inference].concat();
    let everywhere = everywhere.into_iter().map(|(name, value)| (name, value, None));
    everywhere.chain(in_one.map(|(name, value, shader)| (name, value, Some(shader)))).collect()
}

#[test]
fn constants_of_shaders_are_those_of_the_host() {
    let shaders: Vec<_> = sources()
        .into_iter()
        .map(|(label, source)| {
            (label, naga::front::wgsl::parse_str(&source).expect("every_shader_is_valid"))
        })
        .collect();
    for (name, home, only) in homes() {
        let mut found = 0;
        for (label, module) in &shaders {
            if only.is_some_and(|only| only != *label) {
                continue;
            }
            let of_name = module.constants.iter().filter(|(_, c)| c.name.as_deref() == Some(name));
            for (_, constant) in of_name {
                let value = match module.global_expressions[constant.init] {
                    naga::Expression::Literal(naga::Literal::F32(value)) => f64::from(value),
                    naga::Expression::Literal(naga::Literal::I32(value)) => value.into(),
                    naga::Expression::Literal(naga::Literal::U32(value)) => value.into(),
                    ref other => panic!("{name} of {label} is {other:?}"),
                };
                // As near as f32 holds it.
                assert_eq!(value as f32, home as f32, "{name} of {label}");
                found += 1;
            }
        }
        assert!(found > 0, "no shader has {name}");
    }
}
