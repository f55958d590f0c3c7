// The last frame as it would look from where one looks now: turned, not moved.

struct Screen {
    // Columns of frame_from_screen: pixels of the window to pixels of the frame, homogeneous.
    columns: array<vec4<f32>, 3>,
    // Of the frame, pixels.
    size: vec2<f32>,
    padding: vec2<f32>,
}

// How dark it gets beside the frame, and over how much of its width.
const BESIDE: f32 = 0.45;
const FADING: f32 = 0.02;

@group(0) @binding(0) var<uniform> screen: Screen;
@group(0) @binding(1) var frame: texture_2d<f32>;
@group(0) @binding(2) var linearly: sampler;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let p = screen.columns[0] * position.x + screen.columns[1] * position.y + screen.columns[2];
    let uv = p.xy / max(p.z, 1e-6) / screen.size;
    let shown = clamp(uv, vec2<f32>(0.0), vec2<f32>(1.0));
    let colour = textureSampleLevel(frame, linearly, shown, 0.0).rgb;
    let off = length(uv - shown);
    let beside = select(clamp(off / FADING, 0.0, 1.0), 1.0, p.z <= 0.0);
    return vec4<f32>(colour * mix(1.0, BESIDE, beside), 1.0);
}
