// Unit vectors in 32 bits. The Rust side is octahedral.rs.

// A unit vector on the octahedron |x| + |y| + |z| = 1, its lower half folded outwards: within
// 8e-5 rad.
fn octahedral(n: vec3<f32>) -> u32 {
    let scale = 1.0 / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-12);
    let p = n.xy * scale;
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return pack2x16snorm(select(p, folded, n.z < 0.0));
}

fn from_octahedral(code: u32) -> vec3<f32> {
    let p = unpack2x16snorm(code);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let fold = max(-z, 0.0);
    return normalize(vec3(p - select(vec2(-fold), vec2(fold), p >= vec2(0.0)), z));
}
