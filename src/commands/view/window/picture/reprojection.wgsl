// Where a pixel of the window lies in a frame.

struct Screen {
    // Columns of frame_from_screen: pixels of the window to pixels of the frame, homogeneous.
    columns: array<vec4<f32>, 3>,
    // Of the frame, pixels.
    size: vec2<f32>,
    // Of the window, pixels.
    window: vec2<f32>,
}

@group(0) @binding(0) var<uniform> screen: Screen;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var linearly: sampler;

// From 0 to 1 across the frame, and above 0 where it is ahead of the frame's camera.
fn in_frame(position: vec2<f32>) -> vec3<f32> {
    let p = screen.columns[0] * position.x + screen.columns[1] * position.y + screen.columns[2];
    return vec3<f32>(p.xy / max(p.z, 1e-6) / screen.size, p.z);
}
