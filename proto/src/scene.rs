//! Scenes at a glance.

use flaneur_scene::{Bounds3, GpsTimeKind, GroundLayout, OctreeCube, PointSource, SceneInfo};

use crate::error::{FieldError, finite, name, positive, required};
use crate::geometry::point3;
use crate::v1;

/// Most point sources of a scene: more cannot be addressed by a [`flaneur_scene::PointNodeId`].
const MAX_SOURCES: usize = u16::MAX as usize;

impl From<SceneInfo> for v1::Scene {
    fn from(info: SceneInfo) -> Self {
        let position = |[latitude_deg, longitude_deg, height_m]: [f64; 3]| v1::GeographicPosition {
            latitude_deg,
            longitude_deg,
            height_m,
        };
        Self {
            name: info.name,
            crs: info.crs,
            geographic_origin: info.geographic_origin.map(position),
            origin: Some(info.origin.into()),
            bounds: Some(info.bounds.into()),
            footprint_count: info.footprints,
            panorama_count: info.panoramas,
            image_count: info.images,
            ground: info.ground.map(v1::GroundLayout::from),
            point_sources: info.point_sources.into_iter().map(v1::PointSource::from).collect(),
            version: info.version,
            geographic: None,
            crs_name: String::new(),
        }
    }
}

impl TryFrom<v1::Scene> for SceneInfo {
    type Error = FieldError;

    fn try_from(message: v1::Scene) -> Result<Self, FieldError> {
        if message.point_sources.len() > MAX_SOURCES {
            return Err(FieldError::new(
                "point_sources",
                format!("holds {} sources, at most {MAX_SOURCES}", message.point_sources.len()),
            ));
        }
        let source = |(index, source)| {
            PointSource::try_from(source)
                .map_err(|e: FieldError| e.within(format_args!("point_sources[{index}]")))
        };
        Ok(Self {
            name: name("name", message.name)?,
            crs: message.crs,
            geographic_origin: message.geographic_origin.map(geographic).transpose()?,
            origin: point3("origin", message.origin)?,
            bounds: bounds(message.bounds)?,
            version: name("version", message.version)?,
            footprints: message.footprint_count,
            panoramas: message.panorama_count,
            images: message.image_count,
            ground: message
                .ground
                .map(GroundLayout::try_from)
                .transpose()
                .map_err(|e: FieldError| e.within("ground"))?,
            point_sources: message
                .point_sources
                .into_iter()
                .enumerate()
                .map(source)
                .collect::<Result<_, FieldError>>()?,
        })
    }
}

impl From<PointSource> for v1::PointSource {
    fn from(source: PointSource) -> Self {
        Self {
            name: source.name,
            point_count: source.point_count,
            bounds: Some(source.bounds.into()),
            cube_centre: Some(source.cube.centre.into()),
            cube_half_size_m: source.cube.half_size_m,
            spacing_m: source.cube.spacing_m,
            point_format: u32::from(source.point_format),
            record_length: u32::from(source.record_length),
            scale: Some(source.scale.into()),
            offset: Some(source.offset.into()),
            laszip_vlr: source.laszip_vlr.into(),
            extra_bytes_vlr: source.extra_bytes_vlr.into(),
            gps_time_kind: v1::GpsTimeKind::from(source.gps_time).into(),
        }
    }
}

impl TryFrom<v1::PointSource> for PointSource {
    type Error = FieldError;

    fn try_from(message: v1::PointSource) -> Result<Self, FieldError> {
        let (point_format, shortest) = match message.point_format {
            6 => (6, 30),
            7 => (7, 36),
            8 => (8, 38),
            other => {
                return Err(FieldError::new("point_format", format!("is {other}, must be 6 to 8")));
            }
        };
        let record_length = u16::try_from(message.record_length)
            .ok()
            .filter(|length| *length >= shortest)
            .ok_or_else(|| {
                let length = message.record_length;
                FieldError::new(
                    "record_length",
                    format!("is {length}, must be {shortest} to 65535"),
                )
            })?;
        let scale = point3("scale", message.scale)?;
        for (field, value) in [("scale.x", scale.x), ("scale.y", scale.y), ("scale.z", scale.z)] {
            positive(field, value)?;
        }
        let gps_time = message.gps_time_kind().into();
        Ok(Self {
            name: name("name", message.name)?,
            point_count: message.point_count,
            bounds: bounds(message.bounds)?,
            cube: OctreeCube {
                centre: point3("cube_centre", message.cube_centre)?,
                half_size_m: positive("cube_half_size_m", message.cube_half_size_m)?,
                spacing_m: positive("spacing_m", message.spacing_m)?,
            },
            point_format,
            record_length,
            scale,
            offset: point3("offset", message.offset)?,
            laszip_vlr: message.laszip_vlr.into(),
            gps_time,
            extra_bytes_vlr: message.extra_bytes_vlr.into(),
        })
    }
}

impl From<GpsTimeKind> for v1::GpsTimeKind {
    fn from(kind: GpsTimeKind) -> Self {
        match kind {
            GpsTimeKind::Unknown => Self::Unspecified,
            GpsTimeKind::Week => Self::Week,
            GpsTimeKind::Adjusted => Self::Adjusted,
        }
    }
}

impl From<v1::GpsTimeKind> for GpsTimeKind {
    fn from(kind: v1::GpsTimeKind) -> Self {
        match kind {
            v1::GpsTimeKind::Unspecified => Self::Unknown,
            v1::GpsTimeKind::Week => Self::Week,
            v1::GpsTimeKind::Adjusted => Self::Adjusted,
        }
    }
}

fn bounds(message: Option<v1::Bounds3>) -> Result<Bounds3, FieldError> {
    Bounds3::try_from(required("bounds", message)?).map_err(|e| e.within("bounds"))
}

fn geographic(p: v1::GeographicPosition) -> Result<[f64; 3], FieldError> {
    let within = |field: &str, value: f64, limit: f64| {
        if finite(field, value)?.abs() <= limit {
            Ok(value)
        } else {
            Err(FieldError::new(field, format!("is {value:?}, must be -{limit} to {limit}")))
        }
    };
    let checked = || {
        Ok([
            within("latitude_deg", p.latitude_deg, 90.0)?,
            within("longitude_deg", p.longitude_deg, 180.0)?,
            finite("height_m", p.height_m)?,
        ])
    };
    checked().map_err(|e: FieldError| e.within("geographic_origin"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    fn example_source() -> PointSource {
        PointSource {
            name: "drive 1".into(),
            point_count: 1 << 40,
            bounds: Bounds3 { min: DVec3::new(651_000.0, 6.86e6, 30.0), max: DVec3::splat(7e6) },
            cube: OctreeCube { centre: DVec3::splat(1.5), half_size_m: 64.0, spacing_m: 1.0 },
            point_format: 7,
            record_length: 40,
            scale: DVec3::splat(0.001),
            offset: DVec3::new(651_000.0, 6.86e6, 0.0),
            laszip_vlr: vec![3, 0, 0],
            extra_bytes_vlr: vec![],
            gps_time: GpsTimeKind::Adjusted,
        }
    }

    fn layout() -> GroundLayout {
        let origin = DVec2::new(651_000.0, 6.86e6);
        GroundLayout { origin, tile_m: 64.0, columns: 7, rows: 1 }
    }

    fn scene() -> SceneInfo {
        SceneInfo {
            name: "paris".into(),
            crs: "EPSG:2154".into(),
            geographic_origin: Some([48.8, 2.3, 35.0]),
            origin: DVec3::new(651_100.0, 6.861e6, 40.0),
            bounds: Bounds3 { min: DVec3::ZERO, max: DVec3::splat(7e6) },
            footprints: 540,
            panoramas: 44,
            images: 220,
            ground: Some(layout()),
            point_sources: vec![example_source(), example_source()],
            version: "6b1f".into(),
        }
    }

    #[test]
    fn faults_are_named_with_their_path() {
        let field = |change: fn(&mut v1::Scene)| {
            let mut message = v1::Scene::from(scene());
            change(&mut message);
            SceneInfo::try_from(message).expect_err("bad scene").field
        };
        assert_eq!(field(|m| m.name = "../etc".into()), "name");
        assert_eq!(field(|m| m.bounds = None), "bounds");
        let side = |m: &mut v1::Scene| m.ground.as_mut().expect("there").tile_m = 0.0;
        assert_eq!(field(side), "ground.tile_m");
        assert_eq!(field(|m| m.version.clear()), "version");
        assert_eq!(field(|m| m.origin.as_mut().expect("there").z = f64::NAN), "origin.z");
        let latitude = |m: &mut v1::Scene| {
            m.geographic_origin.as_mut().expect("there").latitude_deg = 91.0;
        };
        assert_eq!(field(latitude), "geographic_origin.latitude_deg");
        assert_eq!(field(|m| m.point_sources[1].point_format = 3), "point_sources[1].point_format");
        let length = |m: &mut v1::Scene| m.point_sources[0].record_length = 35;
        assert_eq!(field(length), "point_sources[0].record_length");
        let scale =
            |m: &mut v1::Scene| m.point_sources[0].scale = Some(DVec3::new(1., 0., 1.).into());
        assert_eq!(field(scale), "point_sources[0].scale.y");
        let cube = |m: &mut v1::Scene| m.point_sources[0].cube_half_size_m = -1.0;
        assert_eq!(field(cube), "point_sources[0].cube_half_size_m");
        let bounds = |m: &mut v1::Scene| {
            m.point_sources[0].bounds = Some(Bounds3::EMPTY.into());
        };
        assert_eq!(field(bounds), "point_sources[0].bounds.min.x");
    }

    proptest! {
        #[test]
        fn scenes_come_back(
            counts in prop::array::uniform3(any::<u64>()),
            corner in prop::array::uniform3(-1e7..1e7f64),
            size in prop::array::uniform3(0.0..1e5f64),
            vlr in prop::collection::vec(any::<u8>(), 0..200),
            sources in 0usize..4, has_ground in any::<bool>(), placed in any::<bool>(),
            gps_time in prop::sample::select(
                vec![GpsTimeKind::Unknown, GpsTimeKind::Week, GpsTimeKind::Adjusted],
            ),
        ) {
            let min = DVec3::from_array(corner);
            let bounds = Bounds3 { min, max: min + DVec3::from_array(size) };
            let source = PointSource { bounds, gps_time, laszip_vlr: vlr, ..example_source() };
            let info = SceneInfo {
                footprints: counts[0], panoramas: counts[1], images: counts[2],
                bounds, ground: has_ground.then(layout),
                geographic_origin: placed.then_some([-33.0, 151.0, 0.0]),
                point_sources: vec![source; sources],
                ..scene()
            };
            prop_assert_eq!(SceneInfo::try_from(v1::Scene::from(info.clone())), Ok(info));
        }
    }
}
