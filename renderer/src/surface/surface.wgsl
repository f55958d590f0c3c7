// Which surface each pixel of the picture shows. Needs camera.wgsl, lens.wgsl,
// octahedral.wgsl, place.wgsl, plane.wgsl and viewport.wgsl.

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

struct Shown {
    @location(0) position: vec4<u32>,
    @location(1) orientation: vec2<u32>,
}

const NOWHERE: f32 = 1e29;
const NOTHING_M: f32 = 1e30;
// Marks a surface of the G-buffer that lies on the edge of a triangle.
const EDGE_BIT: u32 = 0x80000000u;
// Points this near to a mesh are its surface however certain the mesh is, metres: waves and
// kerbs that a grid of terrain does not follow.
const SAME_SURFACE_M: f32 = 0.15;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var planes: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<u32>;
@group(0) @binding(3) var winners: texture_2d<u32>;
@group(0) @binding(4) var winning_normals: texture_2d<u32>;
@group(0) @binding(5) var<storage, read> grid: array<vec2<f32>>;

// The model of the picture's lens: software devices run every branch.
override LENS_MODEL: u32 = 0u;

// Whether points have normals.
override WITH_NORMALS: bool = true;

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

@fragment
fn fs(corner: Corner) -> Shown {
    take(corner);
    let at = corner.position;
    var shown: Shown;
    let m = direction(at.xy, corner.lens);
    if m.z > 0.0 {
        let cell = vec2<i32>(floor(camera.focal * m.xy + camera.centre));
        if all(cell >= vec2(0)) && all(cell < vec2<i32>(camera.size)) {
            let surface = textureLoad(surfaces, cell, 0).x;
            let place = place_on(m.xy, cell, surface);
            let on_edge = place.kind == SHOWS_MESH && (surface & EDGE_BIT) != 0u;
            shown.position = packed_position(place, on_edge);
            shown.orientation = packed_orientation(place);
        }
    }
    return shown;
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

// The surface that the ray through the normalised position m meets, by the hybrid rule: the
// mesh occludes from its far surface, delta behind it; within delta a point replaces it.
fn place_on(m: vec2<f32>, cell: vec2<i32>, surface: u32) -> Place {
    var place: Place;
    let ray = ray_through(camera, m);
    let cell_ray =
        ray_through(camera, normalised(camera, vec2<f32>(cell) + 0.5));
    var depth = NOTHING_M;
    var mesh_depth = NOTHING_M;
    if surface != 0u {
        let plane = textureLoad(planes, cell, 0);
        let at_centre = plane_depth(plane, cell_ray);
        let exact = plane_depth(plane, ray);
        // Seen nearly edge-on, the plane may run away within a pixel.
        mesh_depth = select(at_centre, exact, exact > 0.5 * at_centre && exact < 2.0 * at_centre);
        depth = mesh_depth;
        place.kind = SHOWS_MESH;
        place.normal = plane.xyz;
        place.delta = unpack2x16float(surface).x;
        place.relief_m = max(place.delta, RELIEF_M);
        place.code = ((surface & ~EDGE_BIT) >> 16u) - 1u;
    }
    let winner = textureLoad(winners, cell, 0);
    if winner.w != 0u {
        let p = bitcast<vec3<f32>>(winner.xyz);
        var normal_code = 0u;
        if WITH_NORMALS {
            normal_code = textureLoad(winning_normals, cell, 0).x;
        }
        let towards = facing(camera, p);
        var normal = towards;
        if normal_code != 0u {
            normal = normalize(disc_normal(towards, from_octahedral(normal_code)));
        }
        let disc = vec4(normal, dot(normal, p));
        if place.kind == SHOWS_NOTHING || plane_depth(disc, cell_ray) <= mesh_depth + place.delta {
            let mesh = place;
            place = Place();
            place.kind = SHOWS_POINT;
            place.normal = normal;
            place.relief_m = select(RELIEF_M, 0.0, normal_code == 0u);
            place.code = winner.w;
            depth = plane_depth(disc, ray);
            // A point near the mesh is that surface, better known: it has its orientation.
            if mesh.kind == SHOWS_MESH {
                let through = vec4(mesh.normal, dot(mesh.normal, p));
                let off_plane = through.w - dot(mesh.normal, on_ray(ray, mesh_depth));
                let inclined = plane_depth(through, ray);
                let near_disc = inclined > 0.8 * depth && inclined < 1.25 * depth;
                if abs(off_plane) <= max(mesh.delta, SAME_SURFACE_M) && near_disc {
                    depth = inclined;
                    place.normal = mesh.normal;
                    place.relief_m = RELIEF_M;
                }
            }
        }
    }
    if place.kind == SHOWS_NOTHING {
        place.position = normalize(ray.direction);
        // Of what may be inferred there.
        place.normal = -place.position;
        return place;
    }
    place.position = on_ray(ray, depth);
    return place;
}
