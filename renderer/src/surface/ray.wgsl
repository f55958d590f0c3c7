// The ray of each pixel of a picture. Needs camera.wgsl, lens.wgsl and viewport.wgsl.

// Mirrors `View` in surface/mod.rs.
struct View {
    // The pinhole of the G-buffer; positions are relative to its centre, the eye.
    camera: Camera,
    // The lens of the picture. Model 0: the pinhole itself.
    lens: Lens,
    // Nodes a row of `grid`, pixels between them.
    grid_columns: u32,
    grid_step: f32,
    padding: vec2<u32>,
}

const NOWHERE: f32 = 1e29;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> grid: array<vec2<f32>>;

// The model of the picture's lens: software devices run every branch.
override LENS_MODEL: u32 = 0u;

// The pinhole, and what of the lens a picture without distortion needs, come with the corners: software
// devices read every word of a uniform once for each pixel.
struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) right: vec4<f32>,
    @location(1) @interpolate(flat) down: vec4<f32>,
    @location(2) @interpolate(flat) forward: vec4<f32>,
    @location(3) @interpolate(flat) pinhole: vec4<f32>,
    @location(4) @interpolate(flat) lens: vec4<f32>,
}

var<private> camera: Camera;

@vertex
fn vs(@builtin(vertex_index) index: u32) -> Corner {
    let c = view.camera;
    var corner: Corner;
    corner.position = corner_of_viewport(index);
    corner.right = vec4(c.right, f32(c.orthographic));
    corner.down = vec4(c.down, f32(c.size.x));
    corner.forward = vec4(c.forward, f32(c.size.y));
    corner.pinhole = vec4(c.focal, c.centre);
    corner.lens = vec4(view.lens.focal, view.lens.centre);
    return corner;
}

fn take(corner: Corner) {
    camera.right = corner.right.xyz;
    camera.orthographic = u32(corner.right.w);
    camera.down = corner.down.xyz;
    camera.forward = corner.forward.xyz;
    camera.size = vec2<u32>(vec2(corner.down.w, corner.forward.w));
    camera.focal = corner.pinhole.xy;
    camera.centre = corner.pinhole.zw;
}

// Normalised direction that a raw pixel position sees; z is 0 where it sees none. scale: focal lengths
// and principal point of the picture's lens.
fn direction(pixel: vec2<f32>, scale: vec4<f32>) -> vec3<f32> {
    if LENS_MODEL == 0u {
        return vec3((pixel - scale.zw) / scale.xy, 1.0);
    }
    var lens = view.lens;
    lens.model = LENS_MODEL;
    let at = pixel / view.grid_step;
    let node = floor(at);
    let t = at - node;
    let first = u32(node.y) * view.grid_columns + u32(node.x);
    let nw = grid[first];
    let ne = grid[first + 1u];
    let sw = grid[first + view.grid_columns];
    let se = grid[first + view.grid_columns + 1u];
    if max(max(nw.x, ne.x), max(sw.x, se.x)) > NOWHERE {
        return vec3(0.0);
    }
    var m = mix(mix(nw, ne, t.x), mix(sw, se, t.x), t.y);
    // Broyden's method, from the slope of the interpolation: just before a lens folds back, where that
    // is far off, two steps leave a tenth of a pixel and four a thousandth.
    var slope = mat2x2(
        mix(ne - nw, se - sw, t.y) / view.grid_step,
        mix(sw - nw, se - ne, t.x) / view.grid_step,
    );
    var missed = pixel - lens_pixel(lens, m).xy;
    for (var step = 0u; step < 5u; step++) {
        let went = slope * missed;
        m += went;
        let before = missed;
        missed = pixel - lens_pixel(lens, m).xy;
        // What the slope says of the pixels by which that came nearer, and says after this.
        let said = slope * (before - missed);
        let along = dot(went, said);
        // Hundredths of a pixel are too near to rounding to learn from.
        let tells = dot(before, before) > 1e-4 && along > 0.0;
        let learnt = (went - said) / select(1.0, along, tells);
        let weights = select(vec2(0.0), went * slope, tells);
        slope += mat2x2(learnt * weights.x, learnt * weights.y);
    }
    return vec3(m, 1.0);
}
