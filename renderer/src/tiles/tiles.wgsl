// Which tiles of the picture a photograph can see something of: the box around the places that a
// tile shows, in coordinates in which it is tight, and then each photograph's pyramid against it.
// Equations in tiles/reference.rs. Mirrors `gpu_data` in tiles/mod.rs.

struct Frame {
    size: vec2<u32>,
    // Of tiles.
    columns: u32,
    rows: u32,
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
// Tiles a side of a block, within which they are listed together: what is drawn over few large squares is
// quicker than over many small ones, whose diagonals software devices draw twice.
const BLOCK: u32 = 4u;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var positions: texture_2d<u32>;
// Of each tile.
@group(0) @binding(2) var<storage, read_write> boxes: array<Box>;
@group(0) @binding(3) var<storage, read> pyramids: array<Pyramid>;
@group(0) @binding(4) var<storage, read_write> draws: array<Draw>;
// Two a photograph: of the tiles that it shares with others of its rig, and of those that it has
// to itself. For each draw there is room for all tiles in `lists`: squares of tiles, each with the column of
// its first in the low 14 bits of a word, the doublings of a tile's side in two, the row in the high half.
@group(0) @binding(5) var<storage, read_write> lists: array<u32>;
// Which rigs are asked about each tile: a bit each, the lowest the nearest to the eye, the highest all that
// have none.
@group(0) @binding(6) var<storage, read> asked: array<u32>;
// Of each photograph the tiles that it is listed for: a word a block, a bit a tile, see `cell_of`.
@group(0) @binding(7) var<storage, read_write> met: array<u32>;

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

// One thread a block and photograph: which tiles of the block that is asked about.
@compute @workgroup_size(32)
fn meet(@builtin(global_invocation_id) id: vec3<u32>) {
    let blocks = blocks_of_picture();
    if id.x >= blocks.x * blocks.y {
        return;
    }
    let corner = BLOCK * vec2(id.x % blocks.x, id.x / blocks.x);
    let rig = min(pyramids[id.y].rig, 31u);
    var tiles = 0u;
    for (var t = 0u; t < BLOCK * BLOCK; t++) {
        let cell = corner + cell_of(t);
        if cell.x < frame.columns && cell.y < frame.rows {
            let index = cell.y * frame.columns + cell.x;
            let box = boxes[index];
            let is_asked = ((asked[index] >> rig) & 1u) == 1u && box.low.x <= box.high.x;
            tiles |= select(0u, 1u << t, is_asked && meets(id.y, box.low, box.high));
        }
    }
    met[id.y * blocks.x * blocks.y + id.x] = tiles;
}

// One thread a block and photograph.
@compute @workgroup_size(32)
fn list(@builtin(global_invocation_id) id: vec3<u32>) {
    let blocks = blocks_of_picture();
    let count = blocks.x * blocks.y;
    if id.x >= count {
        return;
    }
    let photographs = arrayLength(&pyramids);
    let rig = pyramids[id.y].rig;
    var others = 0u;
    for (var other = id.y; other > 0u && pyramids[other - 1u].rig == rig; other--) {
        others |= met[(other - 1u) * count + id.x];
    }
    for (var other = id.y + 1u; other < photographs && pyramids[other].rig == rig; other++) {
        others |= met[other * count + id.x];
    }
    let tiles = met[id.y * count + id.x];
    let alone = select(0u, tiles & ~others, frame.apart == 1u);
    let corner = BLOCK * vec2(id.x % blocks.x, id.x / blocks.x);
    add(2u * id.y, tiles & ~alone, corner);
    add(2u * id.y + 1u, alone, corner);
}

// Adds tiles of a block to the list of a draw, in the largest squares that are all there.
fn add(draw: u32, tiles: u32, corner: vec2<u32>) {
    if tiles == 0xffffu {
        put(draw, corner, 2u);
        return;
    }
    for (var first = 0u; first < BLOCK * BLOCK; first += 4u) {
        let four = (tiles >> first) & 0xfu;
        if four == 0xfu {
            put(draw, corner + cell_of(first), 1u);
            continue;
        }
        for (var t = 0u; t < 4u; t++) {
            if ((four >> t) & 1u) == 1u {
                put(draw, corner + cell_of(first + t), 0u);
            }
        }
    }
}

// doublings: of a tile's side, which is the square's.
fn put(draw: u32, corner: vec2<u32>, doublings: u32) {
    let at = atomicAdd(&draws[draw].instance_count, 1u);
    let room = frame.columns * frame.rows;
    lists[draw * room + at] = corner.x | (doublings << 14u) | (corner.y << 16u);
}

fn blocks_of_picture() -> vec2<u32> {
    return (vec2(frame.columns, frame.rows) + BLOCK - 1u) / BLOCK;
}

// Of the tiles of a block, of which each four in turn are a square.
fn cell_of(t: u32) -> vec2<u32> {
    return vec2((t & 1u) | ((t >> 1u) & 2u), ((t >> 1u) & 1u) | ((t >> 2u) & 2u));
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
