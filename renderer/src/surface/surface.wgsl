// Which surface each pixel of the picture shows. Needs ray.wgsl, octahedral.wgsl,
// place.wgsl and plane.wgsl.

struct Shown {
    @location(0) position: vec4<u32>,
    @location(1) orientation: vec2<u32>,
    // 0 where the lens sees something and nothing is known of it, 1 elsewhere.
    @builtin(frag_depth) mark: f32,
}

const NOTHING_M: f32 = 1e30;
// Marks a surface of the G-buffer that lies on the edge of a triangle.
const EDGE_BIT: u32 = 0x80000000u;
// Points this near to a mesh are its surface however certain the mesh is, metres: waves and
// kerbs that a grid of terrain does not follow.
const SAME_SURFACE_M: f32 = 0.15;

@group(0) @binding(2) var planes: texture_2d<f32>;
@group(0) @binding(3) var surfaces: texture_2d<u32>;
@group(0) @binding(4) var winners: texture_2d<u32>;
@group(0) @binding(5) var winning_normals: texture_2d<u32>;

// Whether points have normals.
override WITH_NORMALS: bool = true;

@fragment
fn fs(corner: Corner) -> Shown {
    take(corner);
    let at = corner.position;
    var shown: Shown;
    shown.mark = 1.0;
    let m = direction(at.xy, corner.lens);
    if m.z > 0.0 {
        let cell = vec2<i32>(floor(camera.focal * m.xy + camera.centre));
        if all(cell >= vec2(0)) && all(cell < vec2<i32>(camera.size)) {
            let surface = textureLoad(surfaces, cell, 0).x;
            let place = place_on(m.xy, cell, surface);
            let on_edge = place.kind == SHOWS_MESH && (surface & EDGE_BIT) != 0u;
            shown.position = packed_position(place, on_edge);
            shown.orientation = packed_orientation(place);
            shown.mark = select(1.0, 0.0, place.kind == SHOWS_NOTHING);
        }
    }
    return shown;
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
