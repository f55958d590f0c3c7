// Which sprites cover the pixels that show points: one for each point and plane on which it is
// shown. Needs camera.wgsl and place.wgsl.
//
// A point's home is the first of its pixels, by rows. Its sprite has the plane that is shown
// there and reaches over all its pixels that show the same one; a pixel that shows the point on
// another plane has a sprite of its own.

// Mirrors `View` in forward/mod.rs.
struct View {
    camera: Camera,
    // Words between the indices of two pixels.
    index_stride: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

// A sprite of its home's pixel alone; the other bits are the pixel's number, by rows.
const ALONE: u32 = 0x80000000u;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var positions: texture_2d<u32>;
@group(0) @binding(2) var orientations: texture_2d<u32>;
// Index of the point that each pixel shows, among those drawn.
@group(0) @binding(3) var<storage, read> indices: array<u32>;
// The home of each point that was drawn, all bits inverted: zeros where it is not seen.
@group(0) @binding(4) var<storage, read_write> homes: array<atomic<u32>>;
// How many pixels to the left, to the right and down the sprite of a home reaches.
@group(0) @binding(5) var<storage, read_write> reaches: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> sprites: array<u32>;
// Arguments of an indirect draw: vertices, instances, and the first of each.
@group(0) @binding(7) var<storage, read_write> arguments: array<atomic<u32>>;

@compute @workgroup_size(16, 16)
fn claim(@builtin(global_invocation_id) id: vec3<u32>) {
    if shows_point(id.xy) {
        let pixel = number(id.xy);
        atomicMax(&homes[indices[pixel * view.index_stride]], ~pixel);
    }
}

@compute @workgroup_size(16, 16)
fn gather(@builtin(global_invocation_id) id: vec3<u32>) {
    if !shows_point(id.xy) {
        return;
    }
    let pixel = number(id.xy);
    let home = ~atomicLoad(&homes[indices[pixel * view.index_stride]]);
    let home_cell = vec2(home % view.camera.size.x, home / view.camera.size.x);
    if any(orientation(home_cell) != orientation(id.xy)) {
        append(pixel | ALONE);
        return;
    }
    if home == pixel {
        append(pixel);
    }
    let reach = vec2<i32>(id.xy) - vec2<i32>(home_cell);
    raise(3u * home, -reach.x);
    raise(3u * home + 1u, reach.x);
    raise(3u * home + 2u, reach.y);
}

fn shows_point(cell: vec2<u32>) -> bool {
    return all(cell < view.camera.size)
        && (textureLoad(positions, cell, 0).w & KIND_BITS) == SHOWS_POINT;
}

fn number(cell: vec2<u32>) -> u32 {
    return cell.y * view.camera.size.x + cell.x;
}

fn orientation(cell: vec2<u32>) -> vec2<u32> {
    return textureLoad(orientations, cell, 0).xy;
}

fn append(sprite: u32) {
    sprites[atomicAdd(&arguments[1], 1u)] = sprite;
}

fn raise(word: u32, reach: i32) {
    if reach > 0 {
        atomicMax(&reaches[word], u32(reach));
    }
}
