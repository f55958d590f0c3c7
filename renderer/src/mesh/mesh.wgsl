// Triangles into a G-buffer, or into a photograph's depth map. Needs camera.wgsl.

@group(0) @binding(0) var<uniform> camera: Camera;

// How far an orthographic view reaches: a 32-bit depth tells half a millimetre apart.
const FAR_M: f32 = 1e4;
// How far lines stand before their surfaces: a share of depth, and metres without perspective.
const EDGE_OFFSET: f32 = 1e-3;
const EDGE_OFFSET_M: f32 = 0.02;
// As in surface.wgsl.
const EDGE_BIT: u32 = 0x80000000u;

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uncertainty: f32,
    @location(3) surface_class: u32,
    // Tile origin minus the camera's centre, taken in f64: one instance a tile.
    @location(4) origin: vec3<f32>,
}

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) @interpolate(flat) normal: vec3<f32>,
    @location(2) uncertainty: f32,
    @location(3) @interpolate(flat) surface_class: u32,
}

struct GBuffer {
    // The tangent plane n . p = d relative to the eye, n towards the eye.
    @location(0) plane: vec4<f32>,
    // Low half: uncertainty in metres as f16. High half: class + 1, and EDGE_BIT.
    @location(1) surface: u32,
}

@vertex
fn vs(vertex: Vertex) -> Corner {
    return corner_of(vertex);
}

fn corner_of(vertex: Vertex) -> Corner {
    let p = vertex.origin + vertex.position;
    let c = cam_from_world(camera, p);
    let size = vec2<f32>(camera.size);
    // Pixel u = f x/z + c as clip coordinates; y up there, down here. Depth is near / z, or
    // without perspective linear.
    let ndc_scale = 2.0 * camera.focal / size;
    let ndc_offset = 2.0 * camera.centre / size - 1.0;
    var corner: Corner;
    let parallel = camera.orthographic == 1u;
    let w = select(c.z, 1.0, parallel);
    let xy = ndc_scale * c.xy + ndc_offset * w;
    corner.clip = vec4(xy.x, -xy.y, select(camera.near, 1.0 - c.z / FAR_M, parallel), w);
    corner.position = p;
    corner.normal = vertex.normal;
    corner.uncertainty = vertex.uncertainty;
    corner.surface_class = vertex.surface_class;
    return corner;
}

// The same a little nearer to the eye, for lines on the surfaces that they bound.
@vertex
fn vs_edges(vertex: Vertex) -> Corner {
    var corner = corner_of(vertex);
    let offset = select(EDGE_OFFSET * corner.clip.z, EDGE_OFFSET_M / FAR_M, camera.orthographic == 1u);
    corner.clip.z += offset;
    return corner;
}

// Marks what is shown there as lying on an edge.
@fragment
fn fs_edges(corner: Corner) -> @location(1) u32 {
    return surface_of(corner) | EDGE_BIT;
}

fn surface_of(corner: Corner) -> u32 {
    return (pack2x16float(vec2(corner.uncertainty, 0.0)) & 0xffffu)
        | ((corner.surface_class + 1u) << 16u);
}

@fragment
fn fs_gbuffer(corner: Corner) -> GBuffer {
    var n = corner.normal;
    if dot(n, facing(camera, corner.position)) < 0.0 {
        n = -n;
    }
    var out: GBuffer;
    out.plane = vec4(n, dot(n, corner.position));
    out.surface = surface_of(corner);
    return out;
}

struct Texel {
    // Along the axis, metres.
    @location(0) depth: f32,
    // The same by the mesh's uncertainty behind it: points as far as that are still the mesh.
    @location(1) behind: f32,
}

@fragment
fn fs_depth(corner: Corner) -> Texel {
    let depth = dot(camera.forward, corner.position);
    return Texel(depth, depth + corner.uncertainty);
}
