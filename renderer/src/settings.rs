//! What a renderer may be told to do differently.

use crate::depth_map::DepthMaps;
use crate::memory::Shares;

/// Fewer depth maps than this are not enough for a view.
const FEW_MAPS: usize = 16;

/// Bytes without which there is no room for a list, a depth map and a small picture.
const LEAST_MEMORY: u64 = 16 << 20;

/// Choices that trade quality, speed and memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How many rigs (panoramas), nearest to the eye, may colour a pixel.
    pub rigs: usize,
    /// Share of the points that a view meets, 0 to 1, that are drawn. Below 1 runs of points are left
    /// out, first those that lie closest together in the picture, and coarser ones stand in for them.
    pub points_share: f32,
    /// Share of the picture's sides at which it is computed, 0.1 to 1, and then enlarged.
    pub resolution: f32,
    /// Longest side of a photograph's depth map, texels, 64 to 2048, a multiple of 64.
    pub depth_map_side: u32,
    /// Whether a photograph colours only what its depth map says that it sees. Without, it goes
    /// through everything.
    pub depth_test: bool,
    /// Whether points refine depth maps. Without, those are of the mesh alone.
    pub refine_by_points: bool,
    /// Whether points that were taken near the eye, or near a photograph, go before those of other
    /// places; only of surveys whose points have times.
    pub near_first: bool,
    /// How points are textured.
    pub texturing: Texturing,
    /// Whether the brightness of photographs is adjusted so that they agree where they overlap.
    pub exposure_gains: bool,
    /// Radius of a splat as a share of the distance between points. A square grid closes
    /// up from 0.71.
    pub splat_scale: f32,
    /// Largest radius of a splat, metres: coarse levels stay points rather than become walls. Where points are
    /// so far apart that not even such splats touch, none closes a surface, and each hides what is
    /// behind it: there they are smaller, by the square of the distance.
    pub max_splat_radius_m: f32,
    /// Which way splats face.
    pub splat_normals: SplatNormals,
    /// How the nearest splat of a pixel is found; the picture is the same.
    pub splat_route: SplatRoute,
    /// Splats of more pixels than this are drawn as quads instead of by compute; none: as
    /// suits the device. The picture is the same.
    pub quads_from_px: Option<u32>,
    /// Bytes of the device's memory that are held at most, see [`MemoryReport`](crate::MemoryReport),
    /// and at least 16 MiB. Three eighths are for photographs, three sixteenths for points, an eighth
    /// for depth maps, a sixteenth for meshes, and the rest, with what those leave, for pictures. Where an update does
    /// not fit, what is less useful is evicted; while textures of photographs grow, both the old
    /// and the new one exist for a moment.
    pub gpu_memory_bytes: u64,
    /// Whether the two nearest photographs are made to agree, by a few pixels, before they are
    /// blended. Only where texturing is deferred.
    pub align: bool,
    /// Whether pixels without geometry show what the photographs agree is there, marked as
    /// inferred.
    pub infer: bool,
    /// How many depths between the backdrop and the depth diffused from the neighbours such
    /// pixels try, at most 64.
    pub inferred_hypotheses: u32,
    /// Colour where there is no geometry, sRGB.
    pub background: [u8; 3],
}

/// Which way splats face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplatNormals {
    /// The eye.
    #[default]
    Eye,
    /// Along the normals that points come with; the eye where they have none. Takes four bytes
    /// more a point.
    Estimated,
}

impl SplatNormals {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Eye, Self::Estimated];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eye => "eye",
            Self::Estimated => "estimated",
        }
    }
}

impl std::str::FromStr for SplatNormals {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|way| way.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("splats cannot face {text:?}; they face one of {names}")
        })
    }
}

/// How the nearest splat of a pixel is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplatRoute {
    /// The faster of those that the device has.
    #[default]
    Auto,
    /// By atomics of 64 bits, in one phase. As [`SplatRoute::Atomic32`] where the device has
    /// none, or the picture exceeds what it can bind.
    Atomic64,
    /// By atomics of 32 bits, in two phases.
    Atomic32,
}

/// How the photographs' pixels are found for the points that a picture shows. The pictures are
/// the same; time and memory are not.
///
/// The two forward ways hold for views without distortion that are not orthographic; other views
/// are textured by the deferred way, as are meshes always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Texturing {
    /// The position of every pixel is projected.
    #[default]
    Deferred,
    /// A homography for each point and photograph, from the vertex stage, takes every pixel of
    /// the point's sprite to the photograph.
    Homography,
    /// The corners of each point's sprite are projected, and their homogeneous coordinates
    /// interpolated.
    Barycentric,
}

/// What of a scene a picture shows, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Mode {
    /// Mesh and points, coloured by the photographs.
    #[default]
    Hybrid = 0,
    /// The mesh alone, coloured by the photographs.
    Mesh = 1,
    /// The points alone, coloured by the photographs.
    Points = 2,
    /// The points alone, in their own colours, or in those of their classes.
    PointsColour = 3,
    /// The mesh in neutral shades with its edges, and the points in their own colours.
    Wireframe = 4,
    /// Depth along the view's axis: white at the eye, grey at 10 m, black at infinity.
    Depth = 5,
    /// World normals, each axis from -1 to 1 as a channel from 0 to 1.
    Normals = 6,
    /// Which photographs colour a pixel: each has a colour of its own, blended as they are.
    Sources = 7,
    /// How far the shown surface may be off: green a centimetre, yellow a decimetre, red a metre
    /// and more; dark where no photograph sees it; magenta where it was inferred,
    /// and dark magenta where it has but the colours around.
    Uncertainty = 8,
}

impl Settings {
    /// The nearest settings that can be used.
    pub(crate) fn in_range(mut self) -> Self {
        self.gpu_memory_bytes = self.gpu_memory_bytes.max(LEAST_MEMORY);
        // Rows that can be copied.
        let mut depth_map_side = self.depth_map_side.clamp(64, 2048).next_multiple_of(64);
        // Coarse maps of all photographs rather than fine ones of a few.
        while depth_map_side > 64
            && DepthMaps::most_maps(depth_map_side, self.shares().depth_maps) < FEW_MAPS
        {
            depth_map_side = (depth_map_side / 2).next_multiple_of(64);
        }
        let inferred_hypotheses = self.inferred_hypotheses.min(64);
        // Written so that NaN is 1.
        let resolution = if self.resolution < 1.0 { self.resolution.max(0.1) } else { 1.0 };
        let points_share = if self.points_share < 1.0 { self.points_share.max(0.0) } else { 1.0 };
        Self { depth_map_side, inferred_hypotheses, resolution, points_share, ..self }
    }
}

impl Settings {
    /// Whether a renderer can go from these settings to `other` between two frames: whether they
    /// differ only in what is decided anew for each frame, and not in what is kept.
    pub fn differ_by_frame_only(&self, other: &Self) -> bool {
        let Self {
            rigs,
            points_share,
            resolution,
            depth_test,
            exposure_gains,
            texturing,
            align,
            infer,
            inferred_hypotheses,
            background,
            ..
        } = *other;
        let decided = Self {
            rigs,
            points_share,
            resolution,
            depth_test,
            exposure_gains,
            texturing,
            align,
            infer,
            inferred_hypotheses,
            background,
            ..*self
        };
        decided == *other
    }

    /// Radius of a splat, metres, by the distance between points.
    pub(crate) fn splat_radius_m(&self, spacing_m: f32) -> f32 {
        let most_m = self.max_splat_radius_m;
        let touching_m = 2.0 * most_m;
        // What is no number has the largest.
        let closeness = touching_m / spacing_m.max(touching_m);
        (spacing_m * self.splat_scale).min(most_m) * closeness * closeness
    }

    /// How the memory is divided.
    pub(crate) fn shares(&self) -> Shares {
        Shares::of(self.gpu_memory_bytes)
    }

    /// Whether photographs' depth maps are those that `other` asks for.
    pub(crate) fn keep_maps(&self, other: &Self) -> bool {
        let of_maps = |s: &Self| (s.depth_map_side, s.refine_by_points, s.near_first);
        of_maps(self) == of_maps(other)
    }

    /// Whether what is resident has the radii, the normals and the room that `other` asks for.
    pub(crate) fn keep_points(&self, other: &Self) -> bool {
        let of_points =
            |s: &Self| (s.splat_scale, s.max_splat_radius_m, s.splat_normals, s.gpu_memory_bytes);
        of_points(self) == of_points(other)
    }
}

impl Texturing {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Deferred, Self::Homography, Self::Barycentric];

    /// The name by which people and programs ask for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deferred => "deferred",
            Self::Homography => "homography",
            Self::Barycentric => "barycentric",
        }
    }
}

impl std::str::FromStr for Texturing {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|way| way.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no way of texturing {text:?}; the ways are {names}")
        })
    }
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Hybrid,
        Self::Mesh,
        Self::Points,
        Self::PointsColour,
        Self::Wireframe,
        Self::Depth,
        Self::Normals,
        Self::Sources,
        Self::Uncertainty,
    ];

    /// The name by which people and programs ask for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Mesh => "mesh",
            Self::Points => "points",
            Self::PointsColour => "points-colour",
            Self::Wireframe => "wireframe",
            Self::Depth => "depth",
            Self::Normals => "normals",
            Self::Sources => "sources",
            Self::Uncertainty => "uncertainty",
        }
    }
}

impl std::str::FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|mode| mode.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no mode {text:?}; the modes are {names}")
        })
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rigs: 8,
            points_share: 1.0,
            resolution: 1.0,
            depth_map_side: 512,
            depth_test: true,
            refine_by_points: true,
            near_first: true,
            texturing: Texturing::Deferred,
            exposure_gains: true,
            splat_scale: 0.75,
            max_splat_radius_m: 0.25,
            splat_normals: SplatNormals::Eye,
            splat_route: SplatRoute::Auto,
            quads_from_px: None,
            gpu_memory_bytes: 8 << 30,
            align: true,
            infer: true,
            inferred_hypotheses: 7,
            background: [178, 190, 202],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splats_grow_with_the_spacing_until_they_cannot_touch() {
        let settings =
            Settings { splat_scale: 0.75, max_splat_radius_m: 0.25, ..Settings::default() };
        let radii = [0.1, 0.3, 0.4, 0.5, 1.0, 2.0, f32::NAN].map(|m| settings.splat_radius_m(m));
        for (radius, expected) in
            radii.into_iter().zip([0.075, 0.225, 0.25, 0.25, 0.0625, 0.015625, 0.25])
        {
            assert!((radius - expected).abs() < 1e-6f32, "{radii:?}");
        }
        assert!(settings.splat_radius_m(0.501) > 0.248, "without a jump");
        assert_eq!(settings.splat_radius_m(f32::INFINITY), 0.0);
    }
}
