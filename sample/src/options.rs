//! What the sample is to hold.

use crate::SampleError;

/// Sizes of a synthetic street. Everything else follows from them and the seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleOptions {
    /// Equal seeds and sizes give equal files, byte for byte, on any number of threads.
    pub seed: u64,
    /// Length of the block of houses, 20 to 4000 metres.
    pub length_m: f64,
    /// Lidar points, about: some more or fewer come back. 0 for none.
    pub points: u64,
    /// Exposures of the five-camera rig, 0 for none.
    pub exposures: u32,
    /// Side of the rig's square images, 32 to 4096 pixels.
    pub image_px: u32,
    /// Equirectangular panoramas, 0 for none.
    pub spheres: u32,
    /// Height of the equirectangular images, half their width, 32 to 4096 pixels.
    pub sphere_px: u32,
    /// Held-out views, 0 for none; none either where no photograph is taken.
    pub views: u32,
    /// Height of the held-out views, three quarters of their width, 24 to 2304 pixels.
    pub view_px: u32,
}

impl SampleOptions {
    /// The street that `flaneur sample` makes: 120 m at scale 1, with 20 exposures of the
    /// rig, 6 spheres, 1.5 million points and 10 held-out views. `scale` multiplies the
    /// street's length, its photographs and its points.
    pub fn scaled(seed: u64, scale: f64) -> Result<Self, SampleError> {
        if !(0.2..=30.0).contains(&scale) {
            return Err(SampleError::Option { name: "scale", value: scale, range: "0.2 to 30" });
        }
        Ok(Self {
            seed,
            length_m: 120.0 * scale,
            points: (1_500_000.0 * scale) as u64,
            exposures: (20.0 * scale).round() as u32,
            image_px: 576,
            spheres: (6.0 * scale).round() as u32,
            sphere_px: 768,
            views: 10,
            view_px: 576,
        })
    }

    /// A street that is ready in a second or two, for tests.
    pub fn tiny(seed: u64) -> Self {
        Self {
            seed,
            length_m: 30.0,
            points: 50_000,
            exposures: 3,
            image_px: 128,
            spheres: 2,
            sphere_px: 96,
            views: 5,
            view_px: 96,
        }
    }

    /// The same street without a single photograph, for load tests of the points.
    pub fn without_photographs(self) -> Self {
        Self { exposures: 0, spheres: 0, views: 0, ..self }
    }

    /// Refuses what no street can be made of.
    pub(crate) fn check(&self) -> Result<(), SampleError> {
        let refuse = |name, value, range| Err(SampleError::Option { name, value, range });
        if !(self.length_m >= 20.0 && self.length_m <= 4000.0) {
            return refuse("length_m", self.length_m, "20 to 4000");
        }
        for (name, value, range) in [
            ("image_px", self.image_px, 32..=4096),
            ("sphere_px", self.sphere_px, 32..=4096),
            ("view_px", self.view_px, 24..=2304),
        ] {
            if !range.contains(&value) {
                return refuse(name, f64::from(value), "32 to 4096, or 24 to 2304 for views");
            }
        }
        if self.points > 4_000_000_000 {
            return refuse("points", self.points as f64, "0 to 4000000000");
        }
        if self.exposures > 100_000 || self.spheres > 100_000 || self.views > 10_000 {
            let most = self.exposures.max(self.spheres).max(self.views);
            return refuse("photographs", f64::from(most), "0 to 100000, 0 to 10000 views");
        }
        Ok(())
    }
}
