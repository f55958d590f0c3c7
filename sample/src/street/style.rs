//! What one building looks like: drawn once, then followed by every part of it.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::look::Material;

/// The roofs that buildings have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RoofKind {
    /// A steep lower slope of zinc with dormers, a nearly flat one above.
    Mansard,
    /// Two slopes of tiles, the eaves along the street.
    Gable,
    /// A parapet, and a storey set back behind it.
    Terrace,
}

/// Where balconies are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Balconies {
    /// Nowhere.
    None,
    /// In front of single windows.
    Single,
    /// Along the whole facade, on the second floor and the last.
    Running,
}

/// What is at street level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GroundFloor {
    /// Windows and a door.
    Dwelling,
    /// A shop front.
    Shop,
}

/// A building's style. Lengths in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Style {
    pub(crate) wall: Material,
    pub(crate) trim: DVec3,
    pub(crate) joinery: DVec3,
    pub(crate) shutters: Option<DVec3>,
    pub(crate) roof: RoofKind,
    pub(crate) balconies: Balconies,
    pub(crate) ground_floor: GroundFloor,
    pub(crate) floors: u32,
    pub(crate) ground_floor_m: f64,
    pub(crate) floor_m: f64,
    pub(crate) bay_m: f64,
    pub(crate) window_m: f64,
    pub(crate) window_height_m: f64,
    pub(crate) sill_m: f64,
    pub(crate) surrounds: bool,
    pub(crate) awning: bool,
    pub(crate) seed: u32,
}

impl Style {
    /// A style at random.
    pub(crate) fn draw(rng: &mut ChaCha8Rng) -> Self {
        let seed = rng.random::<u32>();
        let wall = draw_wall(rng, seed);
        let tall = rng.random_bool(0.5);
        let sill_m = if tall { 0.12 } else { rng.random_range(0.75..0.95) };
        let roof = match rng.random_range(0..10) {
            0..5 => RoofKind::Mansard,
            5..8 => RoofKind::Gable,
            _ => RoofKind::Terrace,
        };
        let balconies = match rng.random_range(0..10) {
            0..3 => Balconies::None,
            3..7 => Balconies::Single,
            _ => Balconies::Running,
        };
        let shop = rng.random_bool(0.55);
        Self {
            wall,
            trim: pick(rng, &[[0.66, 0.63, 0.56], [0.74, 0.72, 0.68], [0.52, 0.49, 0.44]]),
            joinery: pick(
                rng,
                &[[0.78, 0.77, 0.74], [0.80, 0.80, 0.80], [0.22, 0.12, 0.07], [0.10, 0.13, 0.15]],
            ),
            shutters: rng.random_bool(0.45).then(|| {
                pick(
                    rng,
                    &[
                        [0.70, 0.70, 0.67],
                        [0.13, 0.22, 0.24],
                        [0.16, 0.24, 0.12],
                        [0.25, 0.09, 0.06],
                        [0.28, 0.36, 0.42],
                    ],
                )
            }),
            roof,
            balconies,
            ground_floor: if shop { GroundFloor::Shop } else { GroundFloor::Dwelling },
            floors: rng.random_range(3..=5),
            ground_floor_m: if shop {
                rng.random_range(3.7..4.3)
            } else {
                rng.random_range(3.2..3.7)
            },
            floor_m: rng.random_range(2.9..3.3),
            bay_m: rng.random_range(2.1..2.9),
            window_m: rng.random_range(1.0..1.3),
            window_height_m: if tall {
                rng.random_range(2.15..2.4)
            } else {
                rng.random_range(1.45..1.75)
            },
            sill_m,
            surrounds: rng.random_bool(0.6),
            awning: rng.random_bool(0.5),
            seed,
        }
    }

    /// Height of the eaves above the foot.
    pub(crate) fn eaves_m(&self) -> f64 {
        self.ground_floor_m + f64::from(self.floors - 1) * self.floor_m + 0.45
    }
}

fn draw_wall(rng: &mut ChaCha8Rng, seed: u32) -> Material {
    match rng.random_range(0..10) {
        0..4 => Material::Plaster {
            colour: pick(
                rng,
                &[
                    [0.66, 0.58, 0.44],
                    [0.72, 0.68, 0.60],
                    [0.62, 0.44, 0.30],
                    [0.55, 0.57, 0.56],
                    [0.70, 0.60, 0.50],
                ],
            ),
            seed,
        },
        4..7 => Material::Brick {
            colour: pick(rng, &[[0.42, 0.17, 0.10], [0.50, 0.28, 0.17], [0.36, 0.20, 0.15]]),
            seed,
        },
        _ => Material::Stone {
            colour: pick(rng, &[[0.62, 0.55, 0.43], [0.67, 0.62, 0.53], [0.55, 0.51, 0.45]]),
            seed,
        },
    }
}

/// One of the colours (linear albedo), a little varied.
pub(crate) fn pick(rng: &mut ChaCha8Rng, colours: &[[f64; 3]]) -> DVec3 {
    let colour = DVec3::from_array(colours[rng.random_range(0..colours.len())]);
    colour * rng.random_range(0.9..1.08)
}
