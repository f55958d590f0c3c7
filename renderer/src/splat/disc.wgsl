// The picture of a disc. Equations in splat/reference.rs. Needs camera.wgsl and plane.wgsl.

// For d, pixels from the picture of the centre: the depth is
// (depth + lift · d) / (1 + slope · d), and the disc is where d · conic · d <= 1 + 2 slope · d.
struct Disc {
    // Picture of the centre, pixels.
    middle: vec2<f32>,
    slope: vec2<f32>,
    lift: vec2<f32>,
    // Of the centre, metres.
    depth: f32,
    // xx, xy and yy of a symmetric matrix.
    conic: vec3<f32>,
}

// Of a box, pixels; whole numbers, both within.
struct Extent {
    low: vec2<f32>,
    high: vec2<f32>,
}

// p: camera frame, before the eye; n: its normal, as for `disc_normal`; radius: metres, for a
// pinhole at most half of p.z.
fn disc_around(camera: Camera, p: vec3<f32>, n: vec3<f32>, radius: f32) -> Disc {
    var disc: Disc;
    disc.depth = p.z;
    var diagonal: vec2<f32>;
    var off: f32;
    var scale: vec2<f32>;
    // Of the point, too, so that it is no branch on a uniform: see shade/colour.wgsl.
    if (camera.orthographic == 1u) & (p.z > 0.0) {
        let tilted = disc_normal(vec3(0.0, 0.0, 1.0), n);
        let g = -tilted.xy;
        scale = 1.0 / (camera.focal * radius);
        disc.middle = camera.focal * p.xy + camera.centre;
        disc.lift = g / camera.focal;
        diagonal = 1.0 + g * g;
        off = g.x * g.y;
    } else {
        let m = p.xy / p.z;
        let square = 1.0 + dot(m, m);
        let inverse_length = inverseSqrt(square);
        let rho = radius / p.z;
        let g = disc_normal(vec3(m, 1.0) * inverse_length, n).xy * inverse_length;
        let rest = square - rho * rho;
        scale = 1.0 / (camera.focal * rho);
        disc.middle = camera.focal * m + camera.centre;
        disc.slope = g / camera.focal;
        diagonal = 1.0 - 2.0 * g * m + rest * g * g;
        off = rest * g.x * g.y - g.x * m.y - g.y * m.x;
    }
    diagonal *= scale * scale;
    disc.conic = vec3(diagonal.x, off * scale.x * scale.y, diagonal.y);
    return disc;
}

// The pixels whose centres lie in the box around the disc's picture; none where low exceeds
// high. `size`: of the target.
fn extent_of(disc: Disc, size: vec2<u32>) -> Extent {
    let q = disc.conic;
    let inverse = vec3(q.z, -q.y, q.x) / (q.x * q.z - q.y * q.y);
    let centre = vec2(dot(inverse.xy, disc.slope), dot(inverse.yz, disc.slope));
    let half = sqrt((1.0 + dot(disc.slope, centre)) * inverse.xz);
    let middle = disc.middle + centre - 0.5;
    // Compared as floats: positions far outside do not fit an integer.
    return Extent(
        max(ceil(middle - half), vec2(0.0)),
        min(floor(middle + half), vec2<f32>(size) - 1.0),
    );
}

// Depth of the disc at a pixel, counted from 0; negative off the disc.
fn depth_at(disc: Disc, pixel: vec2<f32>) -> f32 {
    let d = pixel + 0.5 - disc.middle;
    let s = dot(disc.slope, d);
    let q = d.x * (disc.conic.x * d.x + 2.0 * disc.conic.y * d.y) + disc.conic.z * d.y * d.y;
    let z = (disc.depth + dot(disc.lift, d)) / (1.0 + s);
    return select(-1.0, z, q <= 1.0 + 2.0 * s);
}
