//! Unit vectors in 32 bits.

use glam::{Vec2, Vec2Swizzles as _, Vec3};

/// The WGSL side, to be put before the shaders that use it.
pub(crate) const WGSL: &str = include_str!("octahedral.wgsl");

/// The code of a unit vector or its opposite, which are the same plane: within 8e-5 rad. Never
/// 0, which says that there is no normal, except for what is no unit vector.
pub(crate) fn plane_code(n: Vec3) -> u32 {
    if !((n.length_squared() - 1.0).abs() < 1e-3) {
        return 0;
    }
    match code(n) {
        0 => code(-n),
        code => code,
    }
}

/// The unit vector that a code stands for.
pub(crate) fn vector(code: u32) -> Vec3 {
    let p = Vec2::from_array(
        [code as u16, (code >> 16) as u16].map(|half| (f32::from(half as i16) / 32767.0).max(-1.0)),
    );
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = (-z).max(0.0);
    (p - fold * Vec2::ONE.copysign(p)).extend(z).normalize()
}

/// On the octahedron |x| + |y| + |z| = 1, its lower half folded outwards.
fn code(n: Vec3) -> u32 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = Vec2::ONE.copysign(p);
    let folded = if n.z < 0.0 { (1.0 - p.yx().abs()) * sign } else { p };
    let [x, y] = folded.to_array().map(|v| (v.clamp(-1.0, 1.0) * 32767.0).round() as i16);
    u32::from(x as u16) | u32::from(y as u16) << 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel_tests::run;
    use crate::tolerances::UNIT_VECTOR_RAD;

    const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> codes: array<u32>;
@group(0) @binding(1) var<storage, read_write> vectors: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&codes) {
        let n = from_octahedral(codes[id.x]);
        vectors[id.x] = vec4(n, bitcast<f32>(octahedral(n)));
    }
}";

    #[test]
    fn planes_come_back_from_the_device() {
        let mut vectors = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
        for i in 0..2000u32 {
            let sequence = |step: f32| 2.0 * ((i as f32 + 0.5) * step).fract() - 1.0;
            vectors.extend(
                Vec3::new(sequence(0.754_878), sequence(0.569_84), sequence(0.618_034))
                    .try_normalize(),
            );
        }
        let codes: Vec<u32> = vectors.iter().map(|&n| plane_code(n)).collect();
        assert!(codes.iter().all(|&code| code != 0));
        let count = codes.len();
        let source = [WGSL, KERNEL].concat();
        let found: Vec<[f32; 4]> = run(&source, &[bytemuck::cast_slice(&codes)], count, count);
        for ((n, code), [x, y, z, again]) in vectors.into_iter().zip(codes).zip(found) {
            let on_host = vector(code);
            assert!(on_host.distance(Vec3::new(x, y, z)) < 1e-6, "{code:x}: {on_host}");
            let sine = n.as_dvec3().cross(Vec3::new(x, y, z).as_dvec3()).length();
            assert!(sine < UNIT_VECTOR_RAD, "{n} became {x} {y} {z}");
            // The four corners of the square are one direction.
            assert!(again.to_bits() == code || z < -0.9999, "{n}: {code:x} {:x}", again.to_bits());
        }
    }

    #[test]
    fn what_is_no_direction_has_no_code() {
        for n in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(0.1)] {
            assert_eq!(plane_code(n), 0, "{n}");
        }
    }
}
