//! The ground: a sloping street between kerbs, and the crossings at its ends.

use glam::DVec3;

use super::model::Model;
use super::{Class, FACADE_M, KERB_M};
use crate::geometry::Shape;
use crate::look::Material;

/// Metres between the stations where the slope changes.
const STATION_M: f64 = 4.0;
/// How far the ground goes on beyond the block.
const MARGIN_M: f64 = 76.0;
/// Height of the kerb, and of the paving at the facades, above the road.
const KERB_HEIGHT_M: f64 = 0.13;
const FACADE_HEIGHT_M: f64 = 0.19;
/// Width of a kerb stone.
const KERB_STONE_M: f64 = 0.18;

/// Heights of the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terrain {
    length_m: f64,
}

/// What the ground is at a station.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Section {
    /// Road between two sidewalks.
    Street,
    /// Road from side to side.
    Crossing,
    /// Paving from side to side.
    Square,
}

impl Terrain {
    /// The ground of a block of this length.
    pub(crate) fn new(length_m: f64) -> Self {
        Self { length_m }
    }

    /// Height of the road's axis at `x`, linear between stations.
    pub(crate) fn axis(&self, x: f64) -> f64 {
        let at = |s: f64| 0.011 * s + 0.45 * (s / 41.0).sin();
        let station = (x / STATION_M).floor() * STATION_M;
        let t = (x - station) / STATION_M;
        at(station) * (1.0 - t) + at(station + STATION_M) * t
    }

    /// Height of the ground at (x, y), on top of the kerb where there is one.
    pub(crate) fn height(&self, x: f64, y: f64) -> f64 {
        let across = y.abs();
        self.axis(x)
            + match self.section(x) {
                Section::Crossing => 0.0,
                Section::Square => KERB_HEIGHT_M,
                Section::Street if across < KERB_M => 0.0,
                Section::Street => {
                    let t = ((across - KERB_M) / (FACADE_M - KERB_M)).min(1.0);
                    KERB_HEIGHT_M + t * (FACADE_HEIGHT_M - KERB_HEIGHT_M)
                }
            }
    }

    fn section(&self, x: f64) -> Section {
        match x {
            x if x < -12.0 || x >= self.length_m + 12.0 => Section::Square,
            x if x < -2.0 || x >= self.length_m + 2.0 => Section::Crossing,
            _ => Section::Street,
        }
    }

    /// Adds the ground to the model.
    pub(crate) fn build(&self, model: &mut Model) {
        let road = model.surface(Class::Road, Material::Road { length_m: self.length_m });
        let paving = model.surface(Class::Sidewalk, Material::Paving);
        let kerb = model.surface(Class::Sidewalk, Material::Kerb);
        let mut stations: Vec<f64> = Vec::new();
        let first = (-MARGIN_M / STATION_M).floor() as i32;
        let last = ((self.length_m + MARGIN_M) / STATION_M).ceil() as i32;
        stations.extend((first..=last).map(|i| f64::from(i) * STATION_M));
        stations.extend([-12.0, -2.0, self.length_m + 2.0, self.length_m + 12.0]);
        stations.sort_by(f64::total_cmp);
        stations.dedup();
        let far = FACADE_M + MARGIN_M;
        for pair in stations.windows(2) {
            let (x0, x1) = (pair[0], pair[1]);
            let mut strip = |y0: f64, y1: f64, h0: f64, h1: f64, surface: u32| {
                let corner = DVec3::new(x0, y0, self.axis(x0) + h0);
                let u = DVec3::new(x1 - x0, 0.0, self.axis(x1) - self.axis(x0));
                let v = DVec3::new(0.0, y1 - y0, h1 - h0);
                model.push(Shape::Sheet { corner, u, v }, surface);
            };
            match self.section(x0.midpoint(x1)) {
                Section::Crossing => strip(-far, far, 0.0, 0.0, road),
                Section::Square => strip(-far, far, KERB_HEIGHT_M, KERB_HEIGHT_M, paving),
                Section::Street => {
                    strip(-KERB_M, KERB_M, 0.0, 0.0, road);
                    let stone = KERB_M + KERB_STONE_M;
                    let stone_height = KERB_HEIGHT_M
                        + KERB_STONE_M / (FACADE_M - KERB_M) * (FACADE_HEIGHT_M - KERB_HEIGHT_M);
                    // The left side, and its mirror image with the sides kept in order so
                    // that every normal points up.
                    strip(KERB_M, KERB_M, 0.0, KERB_HEIGHT_M, kerb);
                    strip(KERB_M, stone, KERB_HEIGHT_M, stone_height, kerb);
                    strip(stone, FACADE_M, stone_height, FACADE_HEIGHT_M, paving);
                    strip(FACADE_M, far, FACADE_HEIGHT_M, FACADE_HEIGHT_M, paving);
                    strip(-KERB_M, -KERB_M, KERB_HEIGHT_M, 0.0, kerb);
                    strip(-stone, -KERB_M, stone_height, KERB_HEIGHT_M, kerb);
                    strip(-FACADE_M, -stone, FACADE_HEIGHT_M, stone_height, paving);
                    strip(-far, -FACADE_M, FACADE_HEIGHT_M, FACADE_HEIGHT_M, paving);
                }
            }
        }
        self.risers(model, kerb, far);
    }

    /// Kerbs across the street, where the crossings begin and end.
    fn risers(&self, model: &mut Model, kerb: u32, far: f64) {
        for x in [-12.0, self.length_m + 12.0] {
            let corner = DVec3::new(x, -far, self.axis(x));
            let shape =
                Shape::Sheet { corner, u: DVec3::Y * 2.0 * far, v: DVec3::Z * KERB_HEIGHT_M };
            model.push(shape, kerb);
        }
        for x in [-2.0, self.length_m + 2.0] {
            for side in [-1.0, 1.0] {
                let point =
                    |across: f64, height: f64| DVec3::new(x, side * across, self.axis(x) + height);
                let edge = [point(KERB_M, 0.0), point(FACADE_M, 0.0)];
                let top = [point(KERB_M, KERB_HEIGHT_M), point(FACADE_M, FACADE_HEIGHT_M)];
                model.push(Shape::triangle(edge[0], edge[1], top[0]), kerb);
                model.push(Shape::triangle(edge[1], top[1], top[0]), kerb);
                let u = DVec3::Y * side * (far - FACADE_M);
                let v = DVec3::Z * FACADE_HEIGHT_M;
                model.push(Shape::Sheet { corner: edge[1], u, v }, kerb);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Bvh, Ray};

    /// What `height` says is where a plumb line meets the model.
    #[test]
    fn heights_are_those_of_the_model() {
        let terrain = Terrain::new(60.0);
        let mut model = Model::default();
        terrain.build(&mut model);
        let tree = Bvh::new(&model.primitives);
        for i in 0..400 {
            let (x, y) = (-50.0 + 0.397 * f64::from(i), -15.0 + 0.0751 * f64::from(i));
            let ray = Ray { origin: DVec3::new(x, y, 50.0), direction: DVec3::NEG_Z };
            let hit = tree.nearest(&ray, 100.0).expect("ground everywhere");
            let found = 50.0 - hit.contact.distance;
            assert!((found - terrain.height(x, y)).abs() < 1e-9, "{x} {y}: {found}");
            assert!(hit.contact.normal.z > 0.9, "{x} {y}");
        }
    }
}
