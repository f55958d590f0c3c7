// Points with normals, as octahedral codes beside their records; 0 where a point has none.
// Needs octahedral.wgsl.

@group(0) @binding(5) var<storage, read> normals: array<u32>;

fn normal_of(place: u32) -> vec3<f32> {
    let code = normals[place];
    return select(from_octahedral(code), vec3(0.0), code == 0u);
}
