//! Panoramas: what one exposure of a rig saw, and from where.

use glam::{DMat3, DVec3, UVec2};
use serde::{Deserialize, Serialize};

use crate::{CUBE_FACES, CubeFace, IdError, ImageId, Lens, PosedCamera};

/// One exposure of a rig of cameras that share, nearly, a centre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Panorama {
    /// Name, unique in the scene.
    pub id: String,
    /// Position of the rig's origin, world frame, metres.
    pub position: DVec3,
    /// Rotation of the rig (x right, y forward, z up).
    pub world_from_rig: DMat3,
    /// When it was taken, RFC 3339, where known.
    pub time: Option<String>,
    /// How far the position may be off, metres (one standard deviation), 0 where unknown.
    pub uncertainty_m: f64,
    /// Its cameras. Never empty.
    pub cameras: Vec<RigCamera>,
}

/// One camera of a rig.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigCamera {
    /// Name, unique in the rig.
    pub id: String,
    /// Centre of projection in the rig frame, metres.
    pub position_in_rig: DVec3,
    /// Rotation: `p_cam = cam_from_rig (p_rig − position_in_rig)`.
    pub cam_from_rig: DMat3,
    /// How directions become pixels of level 0.
    pub projection: Projection,
    /// The stored file of each level: the first is the original, each further one half the
    /// size in pixels. Never empty.
    pub levels: Vec<StoredImage>,
    /// The mask that says which pixels are scene, where there is one.
    pub mask: Option<Mask>,
    /// Version of the stored image: part of its path, changes with its bytes.
    pub version: String,
}

/// A stored image file, as it is known before it is fetched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct StoredImage {
    /// Bytes of the file, > 0.
    pub bytes: u64,
    /// CRC-32 of the file.
    pub crc32: u32,
}

/// A mask of the pixels that show the scene; cameras of several panoramas may share one.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mask {
    /// Name, unique in the scene.
    pub name: String,
    /// Its file.
    pub image: StoredImage,
}

/// How directions become pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// A pinhole with distortion; its size is that of level 0.
    Pinhole(Lens),
    /// A full sphere; see [`CubeFace::equirectangular_from_rig`].
    Equirectangular {
        /// Size of level 0 in pixels.
        size: UVec2,
    },
}

impl RigCamera {
    /// Number of stored levels.
    pub fn level_count(&self) -> u32 {
        u32::try_from(self.levels.len()).unwrap_or(u32::MAX)
    }
}

impl Projection {
    /// Size of level 0 in pixels.
    pub fn size(&self) -> UVec2 {
        match self {
            Self::Pinhole(lens) => lens.size,
            Self::Equirectangular { size } => *size,
        }
    }

    /// Size of a level in pixels: halved and rounded up once a level, at least 1.
    pub fn level_size(&self, level: u32) -> UVec2 {
        (0..level).fold(self.size(), |size, _| size.map(|side| side.div_ceil(2).max(1)))
    }
}

impl Panorama {
    /// The pinhole photographs that this panorama gives a renderer, with full-resolution
    /// lenses: each pinhole camera as it is, each sphere as six cube faces named
    /// [`CUBE_FACES`], a face a quarter of the sphere's width.
    pub fn photographs(&self) -> Result<Vec<(ImageId, PosedCamera)>, IdError> {
        let mut photographs = Vec::new();
        for camera in &self.cameras {
            match camera.projection {
                Projection::Pinhole(lens) => photographs.push((
                    ImageId::new(&self.id, &camera.id)?,
                    self.pose(camera, camera.cam_from_rig, lens),
                )),
                Projection::Equirectangular { size } => {
                    let lens = CubeFace::lens((size.x / 4).max(1));
                    for face in &CUBE_FACES {
                        let rotation = face.cam_from_rig() * camera.cam_from_rig;
                        photographs.push((
                            ImageId::new(&self.id, face.name)?,
                            self.pose(camera, rotation, lens),
                        ));
                    }
                }
            }
        }
        Ok(photographs)
    }

    fn pose(&self, camera: &RigCamera, cam_from_rig: DMat3, lens: Lens) -> PosedCamera {
        PosedCamera {
            centre: self.position + self.world_from_rig * camera.position_in_rig,
            cam_from_world: cam_from_rig * self.world_from_rig.transpose(),
            lens,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Intrinsics, world_from_rig};
    use glam::DVec2;

    fn rig(projection: Projection) -> Panorama {
        Panorama {
            id: "490".into(),
            position: DVec3::new(651_186.0, 6_861_355.0, 42.0),
            world_from_rig: world_from_rig(0.7, 0.02, -0.01),
            time: None,
            uncertainty_m: 0.0,
            cameras: vec![RigCamera {
                id: "cam".into(),
                position_in_rig: DVec3::new(0.1, -0.2, 0.9),
                cam_from_rig: DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
                projection,
                levels: vec![StoredImage { bytes: 100, crc32: 0 }; 5],
                mask: None,
                version: "0".into(),
            }],
        }
    }

    #[test]
    fn a_pinhole_camera_is_one_photograph_at_its_place() {
        let size = UVec2::new(640, 480);
        let intrinsics = Intrinsics { fx: 500.0, fy: 510.0, cx: 330.0, cy: 235.0 };
        let panorama = rig(Projection::Pinhole(Lens::pinhole(size, intrinsics)));
        let photographs = panorama.photographs().expect("valid names");
        let [(id, camera)] = photographs.as_slice() else { panic!("{photographs:?}") };
        assert_eq!(id.to_string(), "490/cam");
        // A point two metres ahead of the camera, stated in the rig.
        let p_rig = DVec3::new(0.1, 1.8, 0.9);
        let p_world = panorama.position + panorama.world_from_rig * p_rig;
        let (pixel, depth) = camera.project(p_world).expect("in front");
        assert!(pixel.distance(DVec2::new(330.0, 235.0)) < 1e-6, "{pixel}");
        assert!((depth - 2.0).abs() < 1e-9, "{depth}");
    }

    /// A world point has the same direction in the sphere and in the face that sees it.
    #[test]
    fn a_sphere_is_six_faces_of_the_same_directions() {
        let size = UVec2::new(4096, 2048);
        let mut panorama = rig(Projection::Equirectangular { size });
        panorama.cameras[0].cam_from_rig = DMat3::IDENTITY;
        let photographs = panorama.photographs().expect("valid names");
        let names: Vec<String> = photographs.iter().map(|(id, _)| id.to_string()).collect();
        assert_eq!(
            names,
            ["front", "right", "back", "left", "up", "down"].map(|n| format!("490/{n}"))
        );
        let centre =
            panorama.position + panorama.world_from_rig * panorama.cameras[0].position_in_rig;
        for (face, (id, camera)) in CUBE_FACES.iter().zip(&photographs) {
            assert_eq!(camera.lens.size, UVec2::splat(1024), "{id}");
            assert!(camera.centre.distance(centre) < 1e-9);
            let world =
                centre + camera.cam_from_world.transpose() * DVec3::new(0.3, -0.4, 1.0) * 20.0;
            let (pixel, _) = camera.project(world).expect("in front");
            assert!(pixel.distance(DVec2::new(512.0 * 1.3, 512.0 * 0.6)) < 1e-6, "{id}: {pixel}");
            let d_rig = panorama.world_from_rig.transpose() * (world - centre);
            let through_face = face.cam_from_rig().transpose() * DVec3::new(0.3, -0.4, 1.0);
            let at = |d| CubeFace::equirectangular_from_rig(d, size);
            assert!(at(d_rig).distance(at(through_face)) < 1e-4, "{id}");
        }
    }

    #[test]
    fn levels_halve_and_round_up() {
        let projection = Projection::Equirectangular { size: UVec2::new(1242, 375) };
        let sizes: Vec<[u32; 2]> = (0..5).map(|l| projection.level_size(l).to_array()).collect();
        assert_eq!(sizes, [[1242, 375], [621, 188], [311, 94], [156, 47], [78, 24]]);
        assert_eq!(projection.level_size(40), UVec2::ONE);
    }

    #[test]
    fn names_that_are_no_path_segment_are_refused() {
        let mut panorama = rig(Projection::Equirectangular { size: UVec2::new(4, 2) });
        panorama.id = "../490".into();
        assert!(panorama.photographs().is_err());
    }
}
