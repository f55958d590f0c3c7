//! Places on surfaces, as a picture shows them.

use flaneur_scene::View;
use glam::{DMat3, DVec2, DVec3, IVec2, UVec2};

/// Surfaces that lean less than this from the horizontal are ground to stand on: the cosine.
const LEVEL: f64 = 0.7;
/// Pixels to either side by which a surface's plane is found …
const REACH: i32 = 4;
/// … where they are no farther from the middle one than this share of its depth.
const ALIKE: f64 = 0.05;

/// A place on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// World, metres.
    pub(super) position: DVec3,
    /// Of the surface, towards the eye, a unit vector.
    pub(super) normal: DVec3,
}

/// How far away each pixel of a picture is, along its axis, metres; rows from the top.
pub(super) struct Depths<'a> {
    pub(super) size: UVec2,
    pub(super) depths: &'a [Option<f32>],
}

impl Place {
    /// On level ground.
    #[cfg(test)]
    pub(super) fn at(position: DVec3) -> Self {
        Self { position, normal: DVec3::Z }
    }

    /// Whether one can stand there.
    pub(super) fn is_level(&self) -> bool {
        self.normal.z > LEVEL
    }

    /// What `view` shows at a pixel of its picture; `None` where that is no surface. The depths may
    /// be of a smaller picture of the same view.
    pub(super) fn shown(view: &View, pixel: DVec2, depths: &Depths<'_>) -> Option<Self> {
        let pixel = pixel * depths.size.as_dvec2() / view.size().as_dvec2();
        let lens = view.camera.lens.scaled_to(depths.size);
        let depth = depths.at(pixel.floor().as_ivec2())?;
        // On a plane n·p = 1 of the camera frame, the inverse depth of the pixel that sees
        // (u, v, 1) is n·(u, v, 1): a regression gives n.
        let (mut products, mut sums) = (DMat3::ZERO, DVec3::ZERO);
        for offset in window() {
            let at = pixel.floor().as_ivec2() + offset;
            let Some(other) = depths.at(at) else { continue };
            if (other - depth).abs() > ALIKE * depth {
                continue;
            }
            let Some(way) = lens.unproject(at.as_dvec2() + 0.5) else { continue };
            products += DMat3::from_cols(way * way.x, way * way.y, way * way.z);
            sums += way / other;
        }
        let way = lens.unproject(pixel.floor() + 0.5)?;
        let found = products.determinant().abs() > 1e-18;
        let plane = if found { products.inverse() * sums } else { way };
        let normal = -plane.try_normalize()?;
        let world_from_cam = view.camera.cam_from_world.transpose();
        Some(Self {
            position: view.eye() + world_from_cam * (way * depth),
            normal: world_from_cam * normal,
        })
    }
}

impl Depths<'_> {
    fn at(&self, pixel: IVec2) -> Option<f64> {
        let inside = pixel.cmpge(IVec2::ZERO).all() && pixel.cmplt(self.size.as_ivec2()).all();
        let pixel = pixel.as_uvec2();
        let index = pixel.y as usize * self.size.x as usize + pixel.x as usize;
        let depth = self.depths.get(index).copied().flatten().filter(|_| inside)?;
        (depth.is_finite() && depth > 0.0).then_some(f64::from(depth))
    }
}

/// The pixels around one, itself included.
fn window() -> impl Iterator<Item = IVec2> {
    (-REACH..=REACH).flat_map(|y| (-REACH..=REACH).map(move |x| IVec2::new(x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const EYE: DVec3 = DVec3::new(651_000.0, 6_861_000.0, 42.0);

    /// The depths at which `view` sees the plane through `through` with the given normal, in a
    /// picture of half its size.
    fn plane(view: &View, through: DVec3, normal: DVec3) -> (UVec2, Vec<Option<f32>>) {
        let size = view.size() / 2;
        let mut half = *view;
        half.camera.lens = half.camera.lens.scaled_to(size);
        let depth = |x: u32, y: u32| {
            let ray = half.ray(UVec2::new(x, y).as_dvec2() + 0.5)?;
            let depth = (through - ray.origin).dot(normal) / ray.direction.dot(normal);
            (depth > 0.0).then_some(depth as f32)
        };
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
        (size, pixels.map(|(x, y)| depth(x, y)).collect())
    }

    #[test]
    fn a_pixel_shows_a_place_on_a_plane() {
        let view = View::look(EYE, 0.3, -0.1, 1.0, UVec2::new(400, 300));
        let foot = EYE - DVec3::Z * 1.7;
        let (size, depths) = plane(&view, foot, DVec3::Z);
        let depths = Depths { size, depths: &depths };
        let pixel = DVec2::new(181.0, 233.0);
        let place = Place::shown(&view, pixel, &depths).expect("ground");
        let (seen, _) = view.camera.project(place.position).expect("ahead");
        assert!(seen.distance(pixel) < 1.5, "within the pixel of the smaller picture: {seen}");
        assert!((place.position.z - foot.z).abs() < 1e-4, "{place:?}");
        assert!(place.normal.distance(DVec3::Z) < 1e-3 && place.is_level(), "{place:?}");
        assert_eq!(Place::shown(&view, DVec2::new(200.0, 1.0), &depths), None, "the sky");
        for beside in [DVec2::NAN, DVec2::new(-3.0, 233.0), DVec2::new(1e9, 233.0)] {
            assert_eq!(Place::shown(&view, beside, &depths), None, "{beside}");
        }
    }

    #[test]
    fn a_wall_is_not_level_whatever_stands_beside_it() {
        let view = View::look(EYE, 0.0, 0.0, 1.0, UVec2::new(400, 300));
        let normal = DVec3::new(0.6, -0.8, 0.0);
        let (size, mut depths) = plane(&view, EYE + DVec3::Y * 10.0, normal);
        // A tree hides the left half, metres before the wall.
        for (index, depth) in depths.iter_mut().enumerate() {
            if index % (size.x as usize) < 100 {
                *depth = Some(4.0);
            }
        }
        let depths = Depths { size, depths: &depths };
        let wall = Place::shown(&view, DVec2::new(203.0, 150.0), &depths).expect("a wall");
        assert!(wall.normal.distance(normal) < 1e-3 && !wall.is_level(), "{wall:?}");
    }

    #[test]
    fn a_single_pixel_faces_the_eye() {
        let view = View::look(EYE, 0.0, 0.0, 1.0, UVec2::new(3, 3));
        let mut depths = [None; 9];
        depths[4] = Some(5.0);
        let depths = Depths { size: UVec2::new(3, 3), depths: &depths };
        let place = Place::shown(&view, DVec2::splat(1.5), &depths).expect("a point");
        assert!(place.position.distance(EYE + DVec3::Y * 5.0) < 1e-6);
        assert!(place.normal.distance(DVec3::NEG_Y) < 1e-6, "{place:?}");
    }
}
