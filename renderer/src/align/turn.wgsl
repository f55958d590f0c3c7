// Displacements in pixels as offsets of the world, metres a metre of depth along the view's axis.
// Needs screen.wgsl.

// Mirrors `gpu_data::Axes` in align/mod.rs.
struct Axes {
    // Of the view, over its focal length in pixels.
    right: vec3<f32>,
    padding_0: u32,
    down: vec3<f32>,
    padding_1: u32,
}

@group(0) @binding(0) var<uniform> axes: Axes;
@group(0) @binding(1) var displacements: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let displacement = textureLoad(displacements, vec2<i32>(at.xy), 0).xy;
    return vec4(axes.right * displacement.x + axes.down * displacement.y, 0.0);
}
