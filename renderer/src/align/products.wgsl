// What each cell contributes to the normal equations of its neighbours. Needs screen.wgsl.

struct Products {
    // Of the gradient g and the difference d: gx gx, gx gy, gy gy, gx d.
    @location(0) four: vec4<f32>,
    // gy d, d d.
    @location(1) two: vec2<f32>,
}

// Differences beyond this count less and less: there one photograph shows something else.
const ALIKE: f32 = 0.1;

@group(0) @binding(0) var warped: texture_2d<f32>;

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> Products {
    let cell = vec2<i32>(at.xy);
    let here = seen(cell);
    let left = seen(cell - vec2(1, 0));
    let right = seen(cell + vec2(1, 0));
    let above = seen(cell - vec2(0, 1));
    let below = seen(cell + vec2(0, 1));
    var products: Products;
    if here.z * left.z * right.z * above.z * below.z == 1.0 {
        let g = 0.25 * vec2(
            right.x + right.y - left.x - left.y,
            below.x + below.y - above.x - above.y,
        );
        let d = here.y - here.x;
        let weight = 1.0 / (1.0 + (d / ALIKE) * (d / ALIKE));
        products.four = weight * vec4(g.x * g.x, g.x * g.y, g.y * g.y, g.x * d);
        products.two = weight * vec2(g.y * d, d * d);
    }
    return products;
}

fn seen(cell: vec2<i32>) -> vec4<f32> {
    let limit = vec2<i32>(textureDimensions(warped)) - 1;
    return textureLoad(warped, clamp(cell, vec2(0), limit), 0);
}
