// How bright one photograph shows the cells of a level, each by what the pixel at its centre shows.
// Needs colour.wgsl and alignment.wgsl.

struct Sight {
    // Ranks the cameras of a rig.
    @builtin(frag_depth) rank: f32,
    // Brightness; 1 where the photograph sees the place.
    @location(0) seen: vec2<f32>,
}

@group(0) @binding(2) var orientations: texture_2d<u32>;
@group(0) @binding(6) var<uniform> alignment: Alignment;

// Tiles are the picture's.
@vertex
fn tile(@builtin(vertex_index) index: u32, @location(0) tile: u32) -> Corner {
    return corner_of(tile, index, alignment.step * vec2<f32>(alignment.cells));
}

@fragment
fn fs(corner: Corner) -> Sight {
    take(corner);
    let at = corner.position.xy - vec2<f32>(alignment.origin);
    var sight: Sight;
    let pixel = min(vec2<i32>(at * alignment.step), vec2<i32>(frame.size) - 1);
    let orientation = textureLoad(orientations, pixel, 0).xy;
    let place = unpacked(textureLoad(positions, pixel, 0), orientation);
    if place.kind == SHOWS_NOTHING {
        return sight;
    }
    let found = projected(place.position);
    let depth = view_depth_of(place.position);
    let texels = texels_per_pixel(found.position.z, depth) * alignment.step;
    let texel = look_up(found.pixel, texels);
    let visible = visible_share(place, turned(place.normal), found) > 0.5;
    sight.seen = vec2(brightness(texel.rgb), select(0.0, 1.0, visible && texel.a >= OPAQUE));
    sight.rank = rig_score(found.border, photograph.closeness);
    return sight;
}
