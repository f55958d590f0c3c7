//! Every shader parses and validates, and every Rust mirror of a WGSL struct has its layout,
//! checked without a graphics driver.

use std::mem::offset_of;

use crate::settings::SplatNormals;
use crate::splat::Route;
use crate::{
    Texturing, align, camera, complete, depth_map, diffuse, forward, gains, infer, lens, mesh,
    photographs, points, rest, shade, splat, surface, tiles,
};

pub(crate) fn sources() -> Vec<(&'static str, String)> {
    vec![
        ("mesh", mesh::wgsl()),
        ("splat", splat::wgsl(Route::Atomic32, SplatNormals::Eye)),
        ("splat with normals", splat::wgsl(Route::Atomic32, SplatNormals::Estimated)),
        ("large discs", splat::quads_wgsl(Route::Atomic32)),
        ("resolve", splat::resolve_wgsl(SplatNormals::Eye)),
        ("resolve with normals", splat::resolve_wgsl(SplatNormals::Estimated)),
        ("fill", splat::FILL_WGSL.to_owned()),
        ("halve", photographs::atlas::halve_wgsl()),
        ("surface", surface::wgsl()),
        ("tiles", tiles::WGSL.to_owned()),
        ("choose", shade::choose_wgsl()),
        ("deferred", shade::deferred_wgsl()),
        ("compose", shade::compose_wgsl()),
        ("limit", rest::limit_wgsl()),
        ("gather", forward::gather_wgsl()),
        ("homography", sprites_wgsl(Texturing::Homography)),
        ("barycentric", sprites_wgsl(Texturing::Barycentric)),
        ("gather colours", complete::gather_wgsl()),
        ("lens", lens::WGSL.to_owned()),
        ("depth_map", depth_map::WGSL.to_owned()),
        ("spread", gains::measure::spread_wgsl()),
        ("measure", gains::measure::measure_wgsl()),
        ("blend", shade::BLEND_WGSL.to_owned()),
    ]
    .into_iter()
    .chain(diffuse::sources("rgba32float"))
    .chain(infer::sources())
    .chain(align::sources())
    .collect()
}

fn sprites_wgsl(texturing: Texturing) -> String {
    forward::sprites_wgsl(texturing).expect("a forward way")
}

#[test]
fn every_shader_is_valid() {
    use naga::valid::Capabilities;
    // No capability beyond WebGPU's own, which has pack2x16float: the shaders are to run on
    // lavapipe and in browsers.
    let webgpu = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    for (name, source) in sources() {
        validate(name, &source, webgpu);
    }
    for normals in [SplatNormals::Eye, SplatNormals::Estimated] {
        let atomics = Capabilities::SHADER_INT64 | Capabilities::SHADER_INT64_ATOMIC_MIN_MAX;
        validate("splat by 64 bits", &splat::wgsl(Route::Atomic64, normals), webgpu | atomics);
        let quads = splat::quads_wgsl(Route::Atomic64);
        validate("large discs by 64 bits", &quads, webgpu | atomics);
    }
}

fn validate(name: &str, source: &str, capabilities: naga::valid::Capabilities) {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
}

/// Asserts that the members of a WGSL struct lie where those of its Rust mirror do.
macro_rules! assert_mirrors {
    ($source:expr, $name:literal, $mirror:ty, [$($field:ident),* $(,)?]) => {
        let expected = vec![$((stringify!($field), offset_of!($mirror, $field))),*];
        assert_layout(&$source, $name, &expected, size_of::<$mirror>());
    };
}

#[test]
fn mirrors_have_the_layout_of_their_shaders() {
    assert_mirrors!(
        mesh::wgsl(),
        "Camera",
        camera::gpu_data::Camera,
        [right, near, down, orthographic, forward, padding_1, focal, centre, size, padding_2]
    );
    assert_mirrors!(
        lens::WGSL,
        "Lens",
        lens::gpu_data::Lens,
        [focal, centre, distortion_centre, limit, model, k, tangential, size]
    );
    assert_mirrors!(
        splat::wgsl(Route::Atomic32, SplatNormals::Eye),
        "Job",
        splat::gpu_data::Job,
        [
            camera,
            phase,
            first_block,
            end_block,
            stride,
            min_radius_px,
            max_radius_px,
            push,
            push_on_plane,
            most_pixels,
            padding_0,
            padding_1,
            padding_2,
        ]
    );
    assert_mirrors!(
        splat::resolve_wgsl(SplatNormals::Eye),
        "Drawn",
        points::Drawn,
        [placement, block_behind, padding]
    );
    assert_mirrors!(
        splat::quads_wgsl(Route::Atomic32),
        "Large",
        splat::quads::gpu_data::Large,
        [middle_slope, lift_depth_behind, low_high, conic_index]
    );
    assert_mirrors!(
        splat::resolve_wgsl(SplatNormals::Eye),
        "Page",
        splat::resolve_data::Page,
        [width, stride, first_block, end_block]
    );
    assert_mirrors!(
        photographs::atlas::halve_wgsl(),
        "Halve",
        photographs::atlas::gpu_data::Halve,
        [source_corner, source_size]
    );
    let infer = |name| infer::sources().into_iter().find(|(label, _)| *label == name);
    let (_, choose) = infer("choose").expect("a shader");
    assert_mirrors!(
        choose,
        "Inference",
        infer::gpu_data::Inference,
        [size, cells, step, hypotheses, diffused_index, rigs, backdrop, has_before, padding]
    );
    assert_mirrors!(
        choose,
        "Before",
        infer::gpu_data::Before,
        [lens, right, step, down, padding_0, forward, padding_1, eye, padding_2]
    );
    let align = |name| align::sources().into_iter().find(|(label, _)| *label == name);
    let (_, solve) = align("solve").expect("a shader");
    assert_mirrors!(
        solve,
        "Alignment",
        align::gpu_data::Alignment,
        [cells, origin, step, coarser_step, share, across]
    );
    let (_, turn) = align("turn").expect("a shader");
    assert_mirrors!(turn, "Axes", align::gpu_data::Axes, [right, padding_0, down, padding_1]);
    assert_mirrors!(
        surface::wgsl(),
        "View",
        surface::gpu_data::View,
        [camera, lens, grid_columns, grid_step, padding]
    );
    for source in [forward::gather_wgsl(), sprites_wgsl(Texturing::Homography)] {
        assert_mirrors!(
            source,
            "View",
            forward::gpu_data::View,
            [camera, index_stride, padding_0, padding_1, padding_2]
        );
    }
    assert_mirrors!(
        tiles::WGSL,
        "Frame",
        tiles::gpu_data::Frame,
        [size, columns, rows, right, apart, down, orthographic, forward, padding]
    );
    assert_mirrors!(
        tiles::WGSL,
        "Pyramid",
        tiles::gpu_data::Pyramid,
        [planes, rig, padding_0, padding_1, padding_2]
    );
    assert_mirrors!(
        tiles::WGSL,
        "Draw",
        tiles::gpu_data::Draw,
        [vertex_count, instance_count, first_vertex, first_instance]
    );
    for source in [shade::deferred_wgsl(), shade::compose_wgsl()] {
        assert_mirrors!(
            source,
            "Frame",
            shade::gpu_data::Frame,
            [forward, focal, background, orthographic, size, mode, depth_test]
        );
    }
    let [.., (_, coarse)] = diffuse::sources("rgba16float");
    assert_mirrors!(coarse, "Coarse", diffuse::gpu_data::Coarse, [otherwise, first_left]);
    assert_mirrors!(
        rest::limit_wgsl(),
        "Rig",
        rest::gpu_data::Rig,
        [centre, reach, weight, floor, index, padding]
    );
    assert_mirrors!(
        shade::deferred_wgsl(),
        "Photograph",
        shade::photograph::gpu_data::Photograph,
        [
            lens,
            right,
            layer,
            down,
            map_layer,
            forward,
            eye_distance_2,
            centre,
            pose_m,
            map_focal,
            map_centre,
            map_size,
            corner,
            gain,
            max_texels,
            mark,
            rig_weight,
            closeness,
            rig_floor,
            rig_step,
            shift,
            texel,
            shift_step,
            map_texel
        ]
    );
}

fn assert_layout(source: &str, name: &str, expected: &[(&str, usize)], expected_size: usize) {
    let module = naga::front::wgsl::parse_str(source).expect("every_shader_is_valid");
    let (members, span) = module
        .types
        .iter()
        .find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span, .. } if ty.name.as_deref() == Some(name) => {
                Some((members, *span))
            }
            _ => None,
        })
        .unwrap_or_else(|| panic!("no struct {name}"));
    let found: Vec<(&str, usize)> = members
        .iter()
        .map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize))
        .collect();
    assert_eq!(found, expected, "{name}");
    assert_eq!(span as usize, expected_size, "size of {name}");
}
