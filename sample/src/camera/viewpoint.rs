//! Held-out views: where nobody took a photograph, at known distances from who did.

use flaneur_scene::View;
use glam::{DVec3, UVec2};
use rand::RngExt;
use serde_json::{Value, json};

use super::picture::Sighting;
use super::{Station, Survey, rounded};
use crate::frame::StreetFrame;
use crate::geometry::Ray;
use crate::street::{FACADE_M, Purpose, Street, random};

/// Distances from the nearest photograph, metres.
const DISTANCES_M: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// Nothing may be nearer to the eye than this.
const CLEARANCE_M: f64 = 0.6;
/// Nor anything nearer than this in the middle of the view.
const AHEAD_M: f64 = 4.5;
const ATTEMPTS: u32 = 4000;

/// A held-out view, with the very numbers that the list holds.
#[derive(Clone, Debug)]
pub(crate) struct Viewpoint {
    /// World position of the eye.
    pub(crate) position: DVec3,
    /// Clockwise from grid north.
    pub(crate) heading_deg: f64,
    /// Up.
    pub(crate) pitch_deg: f64,
    /// Vertical field of view.
    pub(crate) fov_deg: f64,
    /// Size of the picture.
    pub(crate) size: UVec2,
    /// Distance to the nearest photograph, metres.
    pub(crate) nearest_m: f64,
}

/// Chooses `count` views, their distances in turn. Fewer come back where a street leaves
/// no room for more.
pub(crate) fn choose_viewpoints(
    street: &Street,
    survey: &Survey,
    seed: u64,
    count: u32,
    size: UVec2,
) -> Vec<Viewpoint> {
    let centres = survey.centres();
    if centres.is_empty() {
        return Vec::new();
    }
    let found = (0..count).map(|index| {
        let distance = DISTANCES_M[index as usize % DISTANCES_M.len()];
        choose(street, &centres, seed, index, distance, size)
    });
    found.flatten().collect()
}

fn choose(
    street: &Street,
    centres: &[DVec3],
    seed: u64,
    index: u32,
    distance: f64,
    size: UVec2,
) -> Option<Viewpoint> {
    let mut rng = random(seed, Purpose::Truth, u64::from(index));
    let frame = StreetFrame::PLACE;
    for _ in 0..ATTEMPTS {
        // Out from a photograph, by the distance that is wanted, where no other is nearer.
        let from = frame.point_from_world(centres[rng.random_range(0..centres.len())]);
        let flat = rng.random_range(0.0..std::f64::consts::TAU);
        let rise: f64 = rng.random_range(-0.35..0.75);
        let direction = DVec3::new(flat.cos(), flat.sin(), rise).normalize();
        let eye = from + direction * distance;
        let position = frame.world_from_point(eye).map(|x| rounded(x, 4));
        let nearest_m =
            centres.iter().map(|centre| centre.distance(position)).fold(f64::INFINITY, f64::min);
        let inside = eye.y.abs() < FACADE_M - 0.8 && eye.x > 1.0 && eye.x < street.length_m - 1.0;
        let above = eye.z - street.terrain.height(eye.x, eye.y);
        if (nearest_m - distance).abs() > 1e-3 || !inside || above < 1.2 || !is_free(street, eye) {
            continue;
        }
        // Along the street or towards a facade, level or a little up.
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let turn = side * rng.random_range(12.0..95.0);
        let back = if rng.random_bool(0.35) { 180.0 } else { 0.0 };
        let heading_deg: f64 = frame.heading().to_degrees() + turn + back;
        let view = Viewpoint {
            position,
            heading_deg: rounded(heading_deg.rem_euclid(360.0), 3),
            // From high up, down towards the street.
            pitch_deg: rounded(rng.random_range(-4.0..14.0) - 3.0 * above.max(3.0) + 9.0, 3),
            fov_deg: 60.0,
            size,
            nearest_m,
        };
        let ahead = view.sight()(0.5 * size.as_dvec2())?.ray;
        if street.tree.is_blocked(&ahead, AHEAD_M) {
            continue;
        }
        return Some(view);
    }
    None
}

/// Whether the eye stands clear of everything, and not inside of anything.
fn is_free(street: &Street, eye: DVec3) -> bool {
    (0..26).all(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 26.0;
        let angle = f64::from(i) * 2.399_963;
        let across = (1.0 - z * z).sqrt();
        let direction = DVec3::new(across * angle.cos(), across * angle.sin(), z);
        street
            .tree
            .nearest(&Ray { origin: eye, direction }, 30.0)
            .is_none_or(|hit| hit.contact.distance > CLEARANCE_M)
    })
}

impl Viewpoint {
    /// The view as the renderer is asked for it.
    pub(crate) fn view(&self) -> View {
        View::look(
            self.position,
            self.heading_deg.to_radians(),
            self.pitch_deg.to_radians(),
            self.fov_deg.to_radians(),
            self.size,
        )
    }

    /// The lines of sight.
    pub(crate) fn sight(&self) -> impl Fn(glam::DVec2) -> Option<Sighting> + Sync {
        let camera = self.view().camera;
        let station = Station::new(camera.centre, camera.cam_from_world.transpose());
        move |pixel| {
            let direction = camera.lens.unproject(pixel)?;
            let ray = station.ray(direction);
            Some(Sighting { ray, depth_per_metre: 1.0 / direction.length(), vehicle: None })
        }
    }

    /// The entry of the list of views; `name` is that of its files.
    pub(crate) fn entry(&self, name: &str) -> Value {
        json!({
            "position": self.position.to_array(),
            "heading_deg": self.heading_deg,
            "pitch_deg": self.pitch_deg,
            "fov_deg": self.fov_deg,
            "width": self.size.x,
            "height": self.size.y,
            "nearest_m": self.nearest_m,
            "file": format!("{name}.png"),
            "labels": format!("{name}_labels.png"),
            "depth": format!("{name}_depth.npy"),
        })
    }
}
