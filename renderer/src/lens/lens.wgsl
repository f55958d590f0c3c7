// From directions to the pixels of a lens. Mirrors `gpu_data::Lens` in lens/mod.rs;
// equations as in `flaneur_scene::Distortion`.

struct Lens {
    focal: vec2<f32>,             // pixels
    centre: vec2<f32>,            // principal point, pixels
    distortion_centre: vec2<f32>, // pixels, model 1 only
    limit: f32,                   // ideal radius where the model stops holding
    model: u32,                   // 0 none, 1 radial in pixels, 2 Brown, 3 fisheye
    k: vec4<f32>,
    tangential: vec2<f32>,
    size: vec2<f32>,              // of the picture, pixels
}

// The raw pixel (xy) of the normalised position m = (x/z, y/z); z is 1 where the model
// holds and 0 at and beyond its limit.
fn lens_pixel(lens: Lens, m: vec2<f32>) -> vec3<f32> {
    switch lens.model {
        case 1u: {
            let v = lens.focal * m + lens.centre - lens.distortion_centre;
            let r2 = dot(v, v);
            let scale = 1.0 + r2 * (lens.k.x + r2 * (lens.k.y + r2 * lens.k.z));
            return vec3(lens.distortion_centre + v * scale, holds(lens, r2));
        }
        case 2u: {
            let r2 = dot(m, m);
            let scale = 1.0 + r2 * (lens.k.x + r2 * (lens.k.y + r2 * lens.k.z));
            let p = lens.tangential;
            let t = vec2(
                2.0 * p.x * m.x * m.y + p.y * (r2 + 2.0 * m.x * m.x),
                p.x * (r2 + 2.0 * m.y * m.y) + 2.0 * p.y * m.x * m.y,
            );
            return vec3(lens.focal * (m * scale + t) + lens.centre, holds(lens, r2));
        }
        case 3u: {
            let r2 = dot(m, m);
            let r = sqrt(r2);
            let theta = atan(r);
            let t2 = theta * theta;
            let poly = 1.0 + t2 * (lens.k.x + t2 * (lens.k.y + t2 * (lens.k.z + t2 * lens.k.w)));
            // On the axis theta / r tends to 1.
            let scale = select(poly * theta / max(r, 1e-12), 1.0, r < 1e-6);
            return vec3(lens.focal * m * scale + lens.centre, holds(lens, r2));
        }
        default: {
            return vec3(lens.focal * m + lens.centre, 1.0);
        }
    }
}

fn holds(lens: Lens, r2: f32) -> f32 {
    return select(0.0, 1.0, r2 < lens.limit * lens.limit);
}
