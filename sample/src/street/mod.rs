//! The street itself: what stands where, drawn from the seed.
//!
//! A block of buildings lines both sides of a sloping street, whose ends are closed by
//! buildings across the crossings. Everything is in the street frame (see [`crate::frame`]).

mod building;
mod car;
mod class;
mod facade;
mod furniture;
mod model;
mod roof;
mod storefront;
mod style;
mod terrain;
mod tree;
mod window;

pub(crate) use building::Building;
pub use class::Class;
pub(crate) use model::Surface;
pub(crate) use terrain::Terrain;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::geometry::{Bvh, Hit};
use building::raise_building;
use furniture::Furniture;
use model::{Model, Place};

/// Distance of the facades from the axis, metres.
pub(crate) const FACADE_M: f64 = 8.0;
/// Distance of the kerbs from the axis.
pub(crate) const KERB_M: f64 = 4.6;
/// Distance of trees and posts from the axis.
const VERGE_M: f64 = 5.25;
/// Distance of the facades across the crossings from the block's ends.
const END_M: f64 = 15.0;
/// How far the rows across the crossings reach to either side.
const END_REACH_M: f64 = 40.0;
const DEPTH_M: f64 = 11.0;

/// A finished street.
#[derive(Debug)]
pub(crate) struct Street {
    /// Length of the block, metres.
    pub(crate) length_m: f64,
    /// Everything that rays meet.
    pub(crate) tree: Bvh,
    /// The surfaces that primitives name.
    pub(crate) surfaces: Vec<Surface>,
    /// The buildings as a cadastre knows them.
    pub(crate) buildings: Vec<Building>,
    /// The heights of the ground.
    pub(crate) terrain: Terrain,
}

/// What a stream of random numbers is for: streams do not disturb one another, so that a
/// change of the cars leaves the houses as they were.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub(crate) enum Purpose {
    Lots = 1,
    Building = 2,
    Trees = 3,
    Cars = 4,
    Furniture = 5,
    Drive = 6,
    Truth = 7,
    Lidar = 8,
    Survey = 9,
}

/// The random numbers for one thing.
pub(crate) fn random(seed: u64, purpose: Purpose, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream((purpose as u64) << 48 | index);
    rng
}

impl Street {
    /// The street of this length that the seed determines.
    pub(crate) fn new(seed: u64, length_m: f64) -> Self {
        let terrain = Terrain::new(length_m);
        let mut model = Model::default();
        terrain.build(&mut model);
        let mut builder = Builder { seed, length_m, terrain, model, buildings: Vec::new() };
        builder.houses();
        builder.trees();
        builder.cars();
        builder.furniture();
        let Builder { model, buildings, .. } = builder;
        Self {
            length_m,
            tree: Bvh::new(&model.primitives),
            surfaces: model.surfaces,
            buildings,
            terrain,
        }
    }

    /// The surface that a hit lies on.
    pub(crate) fn surface(&self, hit: &Hit) -> &Surface {
        &self.surfaces[self.tree.primitive(hit.primitive).surface as usize]
    }
}

struct Builder {
    seed: u64,
    length_m: f64,
    terrain: Terrain,
    model: Model,
    buildings: Vec<Building>,
}

impl Builder {
    fn houses(&mut self) {
        let length_m = self.length_m;
        for (row, side) in [1.0, -1.0].into_iter().enumerate() {
            self.row(row as u64, length_m, |x| {
                Place::facing(DVec3::new(x, side * FACADE_M, 0.0), DVec3::NEG_Y * side)
            });
        }
        for (row, (x, out)) in
            [(-END_M, DVec3::X), (length_m + END_M, DVec3::NEG_X)].into_iter().enumerate()
        {
            self.row(2 + row as u64, 2.0 * END_REACH_M, |y| {
                Place::facing(DVec3::new(x, y - END_REACH_M, 0.0), out)
            });
        }
        self.crossings();
    }

    /// What is seen down the crossings: their other sides, behind the block's corners, and
    /// the houses that close them.
    fn crossings(&mut self) {
        let corner = FACADE_M + DEPTH_M + 0.5;
        let ends = [(0.0, DVec3::NEG_X), (self.length_m, DVec3::X)];
        for (index, (x, out)) in ends.into_iter().enumerate() {
            for (side, row) in [(1.0, 4 + 2 * index as u64), (-1.0, 5 + 2 * index as u64)] {
                self.row(row, END_REACH_M - corner, |t| {
                    Place::facing(DVec3::new(x, side * (corner + t), 0.0), out)
                });
                let from = if out.x < 0.0 { x - END_M } else { x };
                self.row(row + 4, END_M, |t| {
                    let foot = DVec3::new(from + t, side * END_REACH_M, 0.0);
                    Place::facing(foot, DVec3::NEG_Y * side)
                });
            }
        }
    }

    /// A row of buildings of this length; `place` gives the facade at a distance along it.
    fn row(&mut self, row: u64, length_m: f64, place: impl Fn(f64) -> Place) {
        let mut lots = random(self.seed, Purpose::Lots, row);
        let mut from = 0.0;
        let mut index = row << 32;
        while length_m - from > 0.1 {
            let rest = length_m - from;
            let mut width = lots.random_range(6.5..14.0);
            if rest - width < 6.0 {
                width = if rest > 15.0 { 0.5 * rest } else { rest };
            }
            // Facades do not quite align.
            let step: f64 = lots.random_range(-0.18..0.18);
            let (left, right) = (place(from), place(from + width));
            let forward = (right.origin - left.origin).dot(left.along) > 0.0;
            let foot = if forward { left } else { right };
            let middle = foot.at(0.5 * width, 0.0, 0.0);
            let foot = foot.moved(0.0, step, self.terrain.height(middle.x, middle.y));
            let mut rng = random(self.seed, Purpose::Building, index);
            let building = raise_building(&mut self.model, &foot, width, DEPTH_M, &mut rng);
            self.buildings.push(building);
            from += width;
            index += 1;
        }
    }

    fn ground(&self, x: f64, y: f64) -> DVec3 {
        DVec3::new(x, y, self.terrain.height(x, y))
    }

    fn trees(&mut self) {
        let mut rng = random(self.seed, Purpose::Trees, 0);
        for side in [1.0, -1.0] {
            let mut x = rng.random_range(5.0..9.0);
            while x < self.length_m - 3.0 {
                if rng.random_bool(if side > 0.0 { 0.72 } else { 0.4 }) {
                    let foot = self.ground(x, side * VERGE_M);
                    tree::plant(&mut self.model, foot, &mut rng);
                }
                x += 9.0 + rng.random_range(-0.7..0.7);
            }
        }
    }

    fn cars(&mut self) {
        let mut rng = random(self.seed, Purpose::Cars, 0);
        for side in [1.0, -1.0] {
            let mut x = 7.0;
            while x < self.length_m - 7.0 {
                let y = side * (KERB_M - 1.12 + rng.random_range(-0.08..0.08));
                // Traffic keeps to the right.
                let along = if side > 0.0 { DVec3::NEG_X } else { DVec3::X };
                let out = DVec3::Z.cross(along);
                let place = Place { origin: self.ground(x, y), along, out };
                if rng.random_bool(0.62) {
                    car::park(&mut self.model, &place, &mut rng);
                }
                x += 5.6 + rng.random_range(-0.15..0.25);
            }
        }
    }

    fn furniture(&mut self) {
        let mut rng = random(self.seed, Purpose::Furniture, 0);
        let kit = Furniture::new(&mut self.model);
        let mut x = 4.2;
        let mut side = -1.0;
        while x < self.length_m - 2.0 {
            let place = Place::facing(self.ground(x, side * (VERGE_M - 0.3)), DVec3::NEG_Y * side);
            kit.lamp_post(&mut self.model, &place);
            x += 13.5;
            side = -side;
        }
        for (x, side, out, crossing) in [
            (1.2, -1.0, DVec3::NEG_X, true),
            (self.length_m - 1.2, 1.0, DVec3::X, true),
            (0.35 * self.length_m, -1.0, DVec3::NEG_X, false),
            (0.7 * self.length_m, 1.0, DVec3::X, false),
        ] {
            let place = Place::facing(self.ground(x, side * (KERB_M + 0.4)), out);
            kit.sign(&mut self.model, &place, crossing);
        }
        for end in [0.0, self.length_m] {
            for side in [-1.0, 1.0] {
                for step in [0.0, 1.5, 3.0] {
                    let x = end + if end > 0.0 { 1.4 - step } else { step - 1.4 };
                    let foot = self.ground(x, side * (KERB_M + 0.35));
                    kit.bollard(&mut self.model, foot);
                }
            }
        }
        for _ in 0..(self.length_m / 12.0) as u32 {
            let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let x = rng.random_range(2.0..self.length_m - 2.0);
            let foot = self.ground(x, side * (FACADE_M - 0.75));
            let place = Place::facing(foot, DVec3::NEG_Y * side);
            kit.bin(&mut self.model, &place, &mut rng);
        }
    }
}
