// Winners with their normals, as octahedral codes.

struct Winner {
    @location(0) point: vec4<u32>,
    @location(1) normal: u32,
}

@group(0) @binding(4) var<storage, read> normals: array<u32>;

fn winner(point: vec4<u32>, place: u32) -> Winner {
    return Winner(point, normals[place]);
}
