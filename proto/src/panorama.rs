//! Panoramas, their cameras, and the names of their images.

use flaneur_scene::{
    Distortion, ImageId, Intrinsics, Lens, Mask, Panorama, Projection, RigCamera, StoredImage,
};
use glam::UVec2;

use crate::error::{FieldError, finite, finite_array, name, not_negative, positive, required};
use crate::geometry::{point2, point3, rotation};
use crate::v1;
use v1::camera::Projection as WireProjection;
use v1::pinhole::Distortion as WireDistortion;

/// Longest side of an image in pixels: what a JPEG can hold.
const MAX_SIDE: u32 = 65_535;

/// Most levels of an image: the halvings that bring [`MAX_SIDE`] to one pixel, and the original.
const MAX_LEVELS: usize = 17;

/// Most cameras of a rig.
const MAX_CAMERAS: usize = 256;

impl From<Panorama> for v1::Panorama {
    fn from(panorama: Panorama) -> Self {
        Self {
            id: panorama.id,
            position: Some(panorama.position.into()),
            world_from_rig: Some(panorama.world_from_rig.into()),
            time: panorama.time.unwrap_or_default(),
            uncertainty_m: panorama.uncertainty_m,
            cameras: panorama.cameras.into_iter().map(v1::Camera::from).collect(),
        }
    }
}

impl TryFrom<v1::Panorama> for Panorama {
    type Error = FieldError;

    fn try_from(message: v1::Panorama) -> Result<Self, FieldError> {
        let count = message.cameras.len();
        if count == 0 || count > MAX_CAMERAS {
            return Err(FieldError::new(
                "cameras",
                format!("holds {count} cameras, must hold 1 to {MAX_CAMERAS}"),
            ));
        }
        let mut cameras: Vec<RigCamera> = Vec::with_capacity(count);
        for (index, camera) in message.cameras.into_iter().enumerate() {
            let camera = RigCamera::try_from(camera)
                .map_err(|e| e.within(format_args!("cameras[{index}]")))?;
            if cameras.iter().any(|other| other.id == camera.id) {
                return Err(FieldError::new(
                    format!("cameras[{index}].id"),
                    format!("is {:?}, which an earlier camera has", camera.id),
                ));
            }
            cameras.push(camera);
        }
        Ok(Self {
            id: name("id", message.id)?,
            position: point3("position", message.position)?,
            world_from_rig: rotation("world_from_rig", message.world_from_rig)?,
            time: Some(message.time).filter(|time| !time.is_empty()),
            uncertainty_m: not_negative("uncertainty_m", message.uncertainty_m)?,
            cameras,
        })
    }
}

impl From<RigCamera> for v1::Camera {
    fn from(camera: RigCamera) -> Self {
        let size = camera.projection.size();
        let projection = match camera.projection {
            Projection::Pinhole(lens) => WireProjection::Pinhole(lens.into()),
            Projection::Equirectangular { .. } => {
                WireProjection::Equirectangular(v1::Equirectangular {})
            }
        };
        Self {
            id: camera.id,
            position_in_rig: Some(camera.position_in_rig.into()),
            cam_from_rig: Some(camera.cam_from_rig.into()),
            width: size.x,
            height: size.y,
            projection: Some(projection),
            levels: camera.levels.into_iter().map(v1::StoredImage::from).collect(),
            mask: camera.mask.map(v1::Mask::from),
            version: camera.version,
        }
    }
}

impl TryFrom<v1::Camera> for RigCamera {
    type Error = FieldError;

    fn try_from(message: v1::Camera) -> Result<Self, FieldError> {
        let size = UVec2::new(side("width", message.width)?, side("height", message.height)?);
        let projection = match required("projection", message.projection)? {
            WireProjection::Pinhole(pinhole) => {
                Projection::Pinhole(lens(size, &pinhole).map_err(|e| e.within("pinhole"))?)
            }
            WireProjection::Equirectangular(_) => Projection::Equirectangular { size },
        };
        let count = message.levels.len();
        if !(1..=MAX_LEVELS).contains(&count) {
            let problem = format!("holds {count} levels, must hold 1 to {MAX_LEVELS}");
            return Err(FieldError::new("levels", problem));
        }
        let level = |(index, level)| {
            StoredImage::try_from(level)
                .map_err(|e: FieldError| e.within(format_args!("levels[{index}]")))
        };
        let levels = message.levels.into_iter().enumerate().map(level);
        let mask = message.mask.map(|mask| Mask::try_from(mask).map_err(|e| e.within("mask")));
        Ok(Self {
            id: name("id", message.id)?,
            position_in_rig: point3("position_in_rig", message.position_in_rig)?,
            cam_from_rig: rotation("cam_from_rig", message.cam_from_rig)?,
            projection,
            levels: levels.collect::<Result<_, FieldError>>()?,
            mask: mask.transpose()?,
            version: name("version", message.version)?,
        })
    }
}

impl From<StoredImage> for v1::StoredImage {
    fn from(image: StoredImage) -> Self {
        Self { byte_size: image.bytes, crc32: image.crc32 }
    }
}

impl TryFrom<v1::StoredImage> for StoredImage {
    type Error = FieldError;

    fn try_from(message: v1::StoredImage) -> Result<Self, FieldError> {
        if message.byte_size == 0 {
            return Err(FieldError::new("byte_size", "is 0, but no image is empty"));
        }
        Ok(Self { bytes: message.byte_size, crc32: message.crc32 })
    }
}

impl From<Mask> for v1::Mask {
    fn from(mask: Mask) -> Self {
        Self { name: mask.name, image: Some(mask.image.into()) }
    }
}

impl TryFrom<v1::Mask> for Mask {
    type Error = FieldError;

    fn try_from(message: v1::Mask) -> Result<Self, FieldError> {
        let image = required("image", message.image)?;
        Ok(Self {
            name: name("name", message.name)?,
            image: image.try_into().map_err(|e: FieldError| e.within("image"))?,
        })
    }
}

impl From<Lens> for v1::Pinhole {
    fn from(lens: Lens) -> Self {
        let Intrinsics { fx, fy, cx, cy } = lens.intrinsics;
        let distortion = match lens.distortion {
            Distortion::None => None,
            Distortion::RadialPixels { centre, k, limit_px } => {
                Some(WireDistortion::RadialPixels(v1::RadialPixels {
                    centre: Some(centre.into()),
                    k: k.to_vec(),
                    limit_px,
                }))
            }
            Distortion::Brown { k, p } => {
                Some(WireDistortion::Brown(v1::Brown { k: k.to_vec(), p: p.to_vec() }))
            }
            Distortion::Fisheye { k } => {
                Some(WireDistortion::Fisheye(v1::Fisheye { k: k.to_vec() }))
            }
        };
        Self { fx, fy, cx, cy, distortion }
    }
}

impl v1::ImageKey {
    /// The key of a level of a photograph.
    pub fn colour(id: &ImageId, level: u32) -> Self {
        Self {
            panorama: id.panorama().to_owned(),
            camera: id.camera().to_owned(),
            level,
            layer: v1::ImageLayer::Colour.into(),
        }
    }

    /// The key of a photograph's mask.
    pub fn mask(id: &ImageId) -> Self {
        Self { layer: v1::ImageLayer::Mask.into(), ..Self::colour(id, 0) }
    }

    /// Which photograph is meant; an error names the part that cannot be a name.
    pub fn image_id(&self) -> Result<ImageId, FieldError> {
        let bad = |field, error: flaneur_scene::IdError| FieldError::new(field, error.to_string());
        ImageId::check_part(&self.panorama).map_err(|e| bad("panorama", e))?;
        ImageId::new(&self.panorama, &self.camera).map_err(|e| bad("camera", e))
    }
}

fn side(field: &str, pixels: u32) -> Result<u32, FieldError> {
    if (1..=MAX_SIDE).contains(&pixels) {
        Ok(pixels)
    } else {
        Err(FieldError::new(field, format!("is {pixels}, must be 1 to {MAX_SIDE}")))
    }
}

fn lens(size: UVec2, message: &v1::Pinhole) -> Result<Lens, FieldError> {
    Ok(Lens {
        size,
        intrinsics: Intrinsics {
            fx: positive("fx", message.fx)?,
            fy: positive("fy", message.fy)?,
            cx: finite("cx", message.cx)?,
            cy: finite("cy", message.cy)?,
        },
        distortion: match &message.distortion {
            None => Distortion::None,
            Some(WireDistortion::RadialPixels(model)) => {
                radial_pixels(model).map_err(|e| e.within("radial_pixels"))?
            }
            Some(WireDistortion::Brown(model)) => brown(model).map_err(|e| e.within("brown"))?,
            Some(WireDistortion::Fisheye(model)) => Distortion::Fisheye {
                k: finite_array("k", &model.k).map_err(|e| e.within("fisheye"))?,
            },
        },
    })
}

fn radial_pixels(model: &v1::RadialPixels) -> Result<Distortion, FieldError> {
    // Infinity says that the model holds everywhere.
    if !(model.limit_px > 0.0) {
        return Err(FieldError::new(
            "limit_px",
            format!("is {:?}, must be more than 0", model.limit_px),
        ));
    }
    Ok(Distortion::RadialPixels {
        centre: point2("centre", model.centre)?,
        k: finite_array("k", &model.k)?,
        limit_px: model.limit_px,
    })
}

fn brown(model: &v1::Brown) -> Result<Distortion, FieldError> {
    Ok(Distortion::Brown { k: finite_array("k", &model.k)?, p: finite_array("p", &model.p)? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec2, DVec3};
    use proptest::prelude::*;

    fn camera(id: &str, projection: Projection) -> RigCamera {
        RigCamera {
            id: id.into(),
            position_in_rig: DVec3::new(0.1, 0.2, -0.3),
            cam_from_rig: DMat3::from_rotation_x(0.7),
            projection,
            levels: vec![StoredImage { bytes: 7, crc32: u32::MAX }; 5],
            mask: None,
            version: "9c1f".into(),
        }
    }

    fn pinhole(distortion: Distortion) -> Projection {
        let intrinsics = Intrinsics { fx: 900.5, fy: 901.0, cx: 512.2, cy: 380.9 };
        Projection::Pinhole(Lens { size: UVec2::new(1024, 768), intrinsics, distortion })
    }

    fn panorama(cameras: Vec<RigCamera>) -> Panorama {
        Panorama {
            id: "490".into(),
            position: DVec3::new(651_187.76, 6_861_379.13, 39.39),
            world_from_rig: DMat3::from_rotation_z(-1.2),
            time: Some("2008-05-02T10:00:00Z".into()),
            uncertainty_m: 0.2,
            cameras,
        }
    }

    fn rig() -> Panorama {
        panorama(vec![
            camera("300", pinhole(Distortion::None)),
            camera("301", Projection::Equirectangular { size: UVec2::new(2048, 1024) }),
            camera("302", pinhole(Distortion::Brown { k: [0.1, 0.0, -0.2], p: [0.01, 0.02] })),
        ])
    }

    #[test]
    fn faults_are_named_with_their_path() {
        let field = |change: fn(&mut v1::Panorama)| {
            let mut message = v1::Panorama::from(rig());
            change(&mut message);
            Panorama::try_from(message).expect_err("bad panorama").field
        };
        let brown = |m: &mut v1::Panorama, change: fn(&mut v1::Pinhole)| {
            if let Some(WireProjection::Pinhole(pinhole)) = &mut m.cameras[2].projection {
                change(pinhole);
            }
        };
        assert_eq!(field(|m| m.id = "a/b".into()), "id");
        assert_eq!(field(|m| m.cameras.clear()), "cameras");
        assert_eq!(field(|m| m.cameras = vec![m.cameras[0].clone(); 257]), "cameras");
        assert_eq!(field(|m| m.cameras[1].id = "300".into()), "cameras[1].id");
        fn mask(name: &str, byte_size: u64) -> Option<v1::Mask> {
            let image = Some(v1::StoredImage { byte_size, crc32: 0 });
            Some(v1::Mask { name: name.into(), image })
        }
        assert_eq!(field(|m| m.cameras[1].mask = mask("..", 1)), "cameras[1].mask.name");
        assert_eq!(field(|m| m.cameras[1].mask = mask("a", 0)), "cameras[1].mask.image.byte_size");
        let unstated = |m: &mut v1::Panorama| {
            m.cameras[1].mask = Some(v1::Mask { name: "a".into(), image: None });
        };
        assert_eq!(field(unstated), "cameras[1].mask.image");
        assert_eq!(field(|m| m.cameras[1].version.clear()), "cameras[1].version");
        assert_eq!(field(|m| m.cameras[0].width = 0), "cameras[0].width");
        assert_eq!(field(|m| m.cameras[0].height = 1 << 16), "cameras[0].height");
        assert_eq!(field(|m| m.cameras[0].levels.clear()), "cameras[0].levels");
        let many = |m: &mut v1::Panorama| m.cameras[0].levels = vec![m.cameras[0].levels[0]; 18];
        assert_eq!(field(many), "cameras[0].levels");
        let empty = |m: &mut v1::Panorama| m.cameras[0].levels[3].byte_size = 0;
        assert_eq!(field(empty), "cameras[0].levels[3].byte_size");
        assert_eq!(field(|m| m.cameras[0].projection = None), "cameras[0].projection");
        assert_eq!(field(|m| m.world_from_rig = None), "world_from_rig");
        assert_eq!(
            field(|m| m.cameras[1].cam_from_rig = Some((DMat3::IDENTITY * 2.0).into())),
            "cameras[1].cam_from_rig.rows"
        );
        let with = |change| {
            let mut message = v1::Panorama::from(rig());
            brown(&mut message, change);
            Panorama::try_from(message).expect_err("bad lens").field
        };
        assert_eq!(with(|p| p.fx = f64::NAN), "cameras[2].pinhole.fx");
        assert_eq!(with(|p| p.fy = -1.0), "cameras[2].pinhole.fy");
        assert_eq!(
            with(|p| p.distortion = Some(WireDistortion::Fisheye(v1::Fisheye { k: vec![0.0; 3] }))),
            "cameras[2].pinhole.fisheye.k"
        );
        let limit = |p: &mut v1::Pinhole| {
            let centre = Some(DVec2::ZERO.into());
            let model = v1::RadialPixels { centre, k: vec![0.0; 3], limit_px: f64::NAN };
            p.distortion = Some(WireDistortion::RadialPixels(model));
        };
        assert_eq!(with(limit), "cameras[2].pinhole.radial_pixels.limit_px");
    }

    #[test]
    fn image_keys_name_the_bad_part() {
        let id = ImageId::new("490", "300").expect("valid");
        assert_eq!(v1::ImageKey::mask(&id).image_id(), Ok(id.clone()));
        let mut key = v1::ImageKey::colour(&id, 3);
        key.camera = "..".into();
        assert_eq!(key.image_id().expect_err("leaves its folder").field, "camera");
        key.panorama = String::new();
        assert_eq!(key.image_id().expect_err("empty").field, "panorama");
    }

    fn any_projection() -> impl Strategy<Value = Projection> {
        let number = -1.0..1.0f64;
        let k3 = prop::array::uniform3(number.clone());
        let distortion = prop_oneof![
            Just(Distortion::None),
            (k3.clone(), prop::array::uniform2(number.clone()))
                .prop_map(|(k, p)| Distortion::Brown { k, p }),
            (k3, prop_oneof![1.0..4096.0, Just(f64::INFINITY)]).prop_map(|(k, limit_px)| {
                Distortion::RadialPixels { centre: DVec2::new(1.5, -2.5), k, limit_px }
            }),
            prop::array::uniform4(number).prop_map(|k| Distortion::Fisheye { k }),
        ];
        prop_oneof![
            distortion.prop_map(pinhole),
            (1..=MAX_SIDE, 1..=MAX_SIDE)
                .prop_map(|(x, y)| Projection::Equirectangular { size: UVec2::new(x, y) }),
        ]
    }

    proptest! {
        #[test]
        fn panoramas_come_back(
            projections in prop::collection::vec(any_projection(), 1..5),
            mask in prop::option::of("[a-z0-9]{1,8}"), time in prop::option::of("[0-9]{4}"),
            levels in prop::collection::vec((1..=u64::MAX, any::<u32>()), 1..=MAX_LEVELS),
        ) {
            let levels: Vec<StoredImage> =
                levels.into_iter().map(|(bytes, crc32)| StoredImage { bytes, crc32 }).collect();
            let mask = mask.map(|name| Mask { name, image: levels[0] });
            let cameras = projections.into_iter().enumerate().map(|(index, projection)| {
                let base = camera(&format!("c{index}"), projection);
                RigCamera { mask: mask.clone(), levels: levels.clone(), ..base }
            });
            let sent = Panorama { time, ..panorama(cameras.collect()) };
            prop_assert_eq!(Panorama::try_from(v1::Panorama::from(sent.clone())), Ok(sent));
        }
    }
}
