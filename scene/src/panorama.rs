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
    /// Number of stored levels: 0 is the original, each further one half the size.
    pub levels: u32,
    /// Name of the mask that says which pixels are scene, where there is one.
    pub mask: Option<String>,
    /// Version of the stored image: part of its path, changes with its bytes.
    pub version: String,
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
