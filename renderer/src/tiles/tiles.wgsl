// Which tiles of the picture a photograph can see something of: the box around the places that a
// tile shows, in coordinates in which it is tight, and then each photograph's pyramid against it.
// Equations in tiles/reference.rs. Mirrors `gpu_data` in tiles/mod.rs.

struct Frame {
    size: vec2<u32>,
    columns: u32,
    tile_count: u32,
    // The axes of the picture's camera, in the world.
    right: vec3<f32>,
    // 1: a tile that one photograph of a rig alone can see is listed apart.
    apart: u32,
    down: vec3<f32>,
    // 1: rays are parallel.
    orthographic: u32,
    forward: vec3<f32>,
    padding: u32,
}

// The pyramid of a photograph: a place with coordinates q is inside where
// dot(plane.xyz, q) + plane.w >= 0 for all.
struct Pyramid {
    planes: array<vec4<f32>, 5>,
    // Photographs of one rig follow each other.
    rig: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

// Around what a tile shows, see `coordinates`.
struct Box {
    low: vec3<f32>,
    padding_0: u32,
    high: vec3<f32>,
    padding_1: u32,
}

// Arguments of an indirect draw.
struct Draw {
    vertex_count: u32,
    instance_count: atomic<u32>,
    first_vertex: u32,
    first_instance: u32,
}

const TILE: u32 = 32u;
const NOTHING: f32 = 1e30;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var positions: texture_2d<u32>;
// Of each tile.
@group(0) @binding(2) var<storage, read_write> boxes: array<Box>;
@group(0) @binding(3) var<storage, read> pyramids: array<Pyramid>;
@group(0) @binding(4) var<storage, read_write> draws: array<Draw>;
// Two a photograph: of the tiles that it shares with others of its rig, and of those that it has
// to itself. For each draw there is room for all tiles in `lists`: column in the low half of a
// word, row in the high.
@group(0) @binding(5) var<storage, read_write> lists: array<u32>;
// Which rigs are asked about each tile: a bit each, the lowest the nearest to the eye, the highest all that
// have none.
@group(0) @binding(6) var<storage, read> asked: array<u32>;

var<workgroup> lows: array<vec3<f32>, 32>;
var<workgroup> highs: array<vec3<f32>, 32>;

// One workgroup a tile, one thread a column of it.
@compute @workgroup_size(32)
fn bound(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) column: u32,
) {
    var low = vec3(NOTHING);
    var high = vec3(-NOTHING);
    let x = tile.x * TILE + column;
    let rows = min(TILE, frame.size.y - tile.y * TILE);
    for (var row = 0u; row < rows; row++) {
        // Beyond the right border this reads zeros: nothing.
        let record = textureLoad(positions, vec2(x, tile.y * TILE + row), 0);
        if record.w != 0u && x < frame.size.x {
            let q = coordinates(bitcast<vec3<f32>>(record.xyz));
            low = min(low, q);
            high = max(high, q);
        }
    }
    lows[column] = low;
    highs[column] = high;
    workgroupBarrier();
    if column == 0u {
        for (var other = 1u; other < TILE; other++) {
            low = min(low, lows[other]);
            high = max(high, highs[other]);
        }
        let index = tile.y * frame.columns + tile.x;
        boxes[index] = Box(low, 0u, high, 0u);
    }
}

// Of a place relative to the eye: (x, y, 1) / z before the camera, or, where rays are parallel, (x, y, z).
fn coordinates(p: vec3<f32>) -> vec3<f32> {
    let aside = vec2(dot(frame.right, p), dot(frame.down, p));
    let depth = dot(frame.forward, p);
    let parallel = frame.orthographic == 1u;
    let scale = select(1.0 / max(depth, 1e-6), 1.0, parallel);
    return vec3(aside * scale, select(scale, depth, parallel));
}

// One thread a tile.
@compute @workgroup_size(64)
fn list(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.tile_count {
        return;
    }
    let low = boxes[id.x].low;
    let high = boxes[id.x].high;
    let bits = asked[id.x];
    let photographs = arrayLength(&pyramids);
    let tile = (id.x % frame.columns) | ((id.x / frame.columns) << 16u);
    var first = 0u;
    while first < photographs && low.x <= high.x {
        let is_asked = (bits >> min(pyramids[first].rig, 31u) & 1u) == 1u;
        var end = first;
        var seeing = 0u;
        while end < photographs && pyramids[end].rig == pyramids[first].rig {
            seeing += select(0u, 1u, is_asked && meets(end, low, high));
            end++;
        }
        let alone = select(0u, frame.apart, seeing == 1u);
        for (; first < end; first++) {
            if is_asked && meets(first, low, high) {
                let draw = 2u * first + alone;
                let at = atomicAdd(&draws[draw].instance_count, 1u);
                lists[draw * frame.tile_count + at] = tile;
            }
        }
    }
}

fn meets(photograph: u32, low: vec3<f32>, high: vec3<f32>) -> bool {
    var inside = true;
    for (var i = 0u; i < 5u; i++) {
        let plane = pyramids[photograph].planes[i];
        let farthest = select(low, high, plane.xyz > vec3(0.0));
        inside = inside && dot(plane.xyz, farthest) + plane.w >= 0.0;
    }
    return inside;
}
