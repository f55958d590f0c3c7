//! A photograph as the shading passes see it.

use flaneur_scene::ImageId;
use glam::DVec3;

use crate::depth_map::MapPlace;
use crate::lens::gpu_data::Lens;
use crate::photographs::Photograph;

pub(crate) mod gpu_data {
    use crate::lens::gpu_data::Lens;

    /// Mirrors `Photograph` in photograph.wgsl.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
    pub(crate) struct Photograph {
        pub(crate) lens: Lens,
        pub(crate) right: [f32; 3],
        pub(crate) layer: u32,
        pub(crate) down: [f32; 3],
        pub(crate) map_layer: u32,
        pub(crate) forward: [f32; 3],
        pub(crate) eye_distance_2: f32,
        pub(crate) centre: [f32; 3],
        pub(crate) pose_m: f32,
        pub(crate) map_focal: [f32; 2],
        pub(crate) map_centre: [f32; 2],
        pub(crate) map_size: [u32; 2],
        pub(crate) corner: [f32; 2],
        pub(crate) gain: [f32; 3],
        pub(crate) max_texels: f32,
        pub(crate) mark: [f32; 3],
        pub(crate) rig_weight: f32,
        pub(crate) closeness: f32,
        pub(crate) rig_floor: f32,
        pub(crate) rig_step: f32,
        pub(crate) shift: f32,
        pub(crate) texel: [f32; 2],
        pub(crate) shift_step: f32,
        pub(crate) map_texel: f32,
    }
}

/// What is constant of a photograph in the pipelines that look it up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Kind {
    lens_model: u32,
    masked: bool,
}

impl Kind {
    /// For the constants of photograph.wgsl and texel.wgsl.
    pub(crate) fn constants(self) -> [(&'static str, f64); 2] {
        let masked = f64::from(u8::from(self.masked));
        [("LENS_MODEL", f64::from(self.lens_model)), ("MASKED", masked)]
    }
}

/// One photograph of a frame, and where it is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn {
    pub(crate) kind: Kind,
    pub(crate) data: gpu_data::Photograph,
    /// Which of the atlas's arrays holds it.
    pub(crate) atlas: usize,
    /// Which rig, in the order of drawing.
    pub(crate) rig: usize,
    /// From the eye to the nearest camera of the rig.
    pub(crate) rig_distance_m: f64,
}

/// How a photograph's rig stands among those of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    pub(crate) rig: usize,
    /// How many there are.
    pub(crate) rigs: usize,
    /// Squared distance from the eye to the nearest camera of the rig, metres.
    pub(crate) nearest_2: f64,
    /// See [`rig_weight`].
    pub(crate) weight: f64,
}

/// Share of its weight that a rig at `distance_m` from the eye keeps where the nearest rig that
/// is left out is `left_out_m` away: 1 at the eye, and nothing where the two change places, so
/// that nothing jumps when they do.
pub(crate) fn rig_weight(distance_m: f64, left_out_m: f64) -> f64 {
    // Infinity over infinity is a rig that nobody contests.
    let share = distance_m / left_out_m;
    if share < 1.0 { (1.0 - share * share).powi(2) } else { f64::from(u8::from(share.is_nan())) }
}

/// How near the eye is to a camera compared with the nearest of its rig, 0 to 1, of squared
/// distances in metres.
pub(crate) fn closeness(distance_2: f64, nearest_2: f64) -> f64 {
    const NEAREST_2: f64 = 0.05 * 0.05;
    (nearest_2 + NEAREST_2) / (distance_2 + NEAREST_2)
}

/// The colour that stands for a photograph, linear: the same in every frame.
pub(crate) fn mark(id: &ImageId) -> [f32; 3] {
    // FNV-1a, as a hue.
    let hash = id
        .to_string()
        .bytes()
        .fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    let turns = f64::from(hash) / f64::from(u32::MAX);
    [0.0, 1.0, 2.0].map(|channel| {
        let wave = (std::f64::consts::TAU * (turns + channel / 3.0)).cos();
        (0.5 + 0.5 * wave).powi(2) as f32
    })
}

impl Drawn {
    /// `photograph` as seen from `eye`.
    pub(crate) fn new(
        photograph: &Photograph,
        eye: DVec3,
        standing: Standing,
        map: MapPlace,
        gain: [f32; 3],
        mark: [f32; 3],
    ) -> Self {
        let axes = photograph.camera.cam_from_world.transpose();
        let centre = photograph.camera.centre - eye;
        let place = photograph.place;
        let lens: Lens = photograph.lens;
        let data = gpu_data::Photograph {
            lens,
            right: axes.x_axis.as_vec3().to_array(),
            layer: place.layer,
            down: axes.y_axis.as_vec3().to_array(),
            map_layer: map.layer,
            map_texel: 1.0 / map.side as f32,
            forward: axes.z_axis.as_vec3().to_array(),
            eye_distance_2: standing.nearest_2 as f32,
            centre: centre.as_vec3().to_array(),
            texel: (1.0 / place.layer_size.as_vec2()).to_array(),
            map_focal: photograph.map.focal.as_vec2().to_array(),
            map_centre: photograph.map.centre.as_vec2().to_array(),
            map_size: photograph.map.size.to_array(),
            corner: place.corner.as_vec2().to_array(),
            gain,
            max_texels: (1u32 << place.coarsest()) as f32,
            mark,
            rig_weight: standing.weight as f32,
            pose_m: photograph.uncertainty_m,
            rig_floor: (standing.rigs - 1 - standing.rig) as f32 / standing.rigs as f32,
            rig_step: 1.0 / standing.rigs as f32,
            closeness: closeness(centre.length_squared(), standing.nearest_2) as f32,
            ..Default::default()
        };
        let rig_distance_m = standing.nearest_2.sqrt();
        let kind = Kind { lens_model: lens.model, masked: photograph.masked };
        Self { kind, data, atlas: place.array, rig: standing.rig, rig_distance_m }
    }

    /// A photograph of which only `data` and the rig matter.
    #[cfg(test)]
    pub(crate) fn of_rig(data: gpu_data::Photograph, rig: usize) -> Self {
        let kind = Kind { lens_model: 0, masked: false };
        Self { kind, data, atlas: 0, rig, rig_distance_m: f64::from(data.eye_distance_2).sqrt() }
    }
}
