//! The street side of a building: walls with openings, storey by storey.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Class;
use super::model::{Model, Place};
use super::storefront::{dwelling_front, shop_front};
use super::style::{Balconies, GroundFloor, Style};
use super::window::{balcony, window};
use crate::look::Material;

/// Thickness of the front wall.
pub(crate) const WALL_M: f64 = 0.42;

/// The surfaces that all parts of a building share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Skin {
    pub(crate) wall: u32,
    pub(crate) party_wall: u32,
    pub(crate) trim: u32,
    pub(crate) joinery: u32,
    pub(crate) shutter: Option<u32>,
    pub(crate) iron: u32,
    pub(crate) tiles: u32,
    pub(crate) zinc: u32,
}

/// A hole in a wall, in metres from the storey's left foot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opening {
    pub(crate) left: f64,
    pub(crate) bottom: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Skin {
    /// Registers the surfaces of a style.
    pub(crate) fn new(model: &mut Model, style: &Style) -> Self {
        let seed = style.seed;
        let mut of = |class, material| model.surface(class, material);
        Self {
            wall: of(Class::Building, style.wall),
            party_wall: of(
                Class::Building,
                Material::Plaster { colour: style.trim * 0.75, seed: seed ^ 7 },
            ),
            trim: of(Class::Building, Material::Trim { colour: style.trim, seed }),
            joinery: of(Class::Building, Material::Paintwork { colour: style.joinery }),
            shutter: style.shutters.map(|colour| of(Class::Building, Material::Louvres { colour })),
            iron: of(
                Class::Building,
                Material::Paintwork { colour: glam::DVec3::new(0.035, 0.04, 0.045) },
            ),
            tiles: of(Class::Roof, Material::Tiles { seed }),
            zinc: of(Class::Roof, Material::Zinc { seed }),
        }
    }
}

/// Builds the front wall, its windows and everything that projects from it.
pub(crate) fn raise_facade(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    // The wall below street level, for slopes.
    model.push(place.block([0.0, -WALL_M, -2.0], [width_m, 0.0, 0.0]), skin.wall);
    match style.ground_floor {
        GroundFloor::Shop => shop_front(model, place, width_m, style, skin, rng),
        GroundFloor::Dwelling => dwelling_front(model, place, width_m, style, skin, rng),
    }
    let bays = bays(width_m, style);
    for floor in 1..style.floors {
        let foot = style.ground_floor_m + f64::from(floor - 1) * style.floor_m;
        let storey = place.moved(0.0, 0.0, foot);
        let openings: Vec<Opening> = bays.iter().map(|&middle| opening(middle, style)).collect();
        wall(model, &storey, width_m, style.floor_m, &openings, skin.wall);
        let running = style.balconies == Balconies::Running
            && (floor == 1 || floor + 1 == style.floors)
            && width_m > 4.0;
        for hole in &openings {
            window(model, &storey, hole, style, skin, rng);
            if style.balconies == Balconies::Single && style.sill_m < 0.3 {
                let (left, width) = (hole.left - 0.22, hole.width + 0.44);
                balcony(model, &storey.moved(left, 0.0, 0.0), width, 0.42, skin);
            }
        }
        if running {
            balcony(model, &storey.moved(0.25, 0.0, 0.0), width_m - 0.5, 0.85, skin);
        } else {
            // A string course marks the floor.
            model.push(storey.block([0.0, 0.0, -0.11], [width_m, 0.05, 0.05]), skin.trim);
        }
    }
    cornice(model, place, width_m, style, skin);
    downpipe(model, place, width_m, style, skin, rng);
}

/// Fills a storey with wall around its openings, which are in order and do not overlap.
pub(crate) fn wall(
    model: &mut Model,
    storey: &Place,
    width_m: f64,
    height_m: f64,
    openings: &[Opening],
    surface: u32,
) {
    let mut push = |left: f64, right: f64, low: f64, high: f64| {
        if right - left > 1e-6 && high - low > 1e-6 {
            model.push(storey.block([left, -WALL_M, low], [right, 0.0, high]), surface);
        }
    };
    let mut from = 0.0;
    for hole in openings {
        let right = hole.left + hole.width;
        push(from, hole.left, 0.0, height_m);
        push(hole.left, right, 0.0, hole.bottom);
        push(hole.left, right, hole.bottom + hole.height, height_m);
        from = right;
    }
    push(from, width_m, 0.0, height_m);
}

/// Middles of the window bays, evenly spread.
pub(crate) fn bays(width_m: f64, style: &Style) -> Vec<f64> {
    let count = ((width_m - 0.5) / style.bay_m).floor().max(1.0);
    let pitch = width_m / count;
    (0..count as u32).map(|i| (f64::from(i) + 0.5) * pitch).collect()
}

/// The opening of an upper window in the bay around `middle`.
fn opening(middle: f64, style: &Style) -> Opening {
    Opening {
        left: middle - 0.5 * style.window_m,
        bottom: style.sill_m,
        width: style.window_m,
        height: style.window_height_m.min(style.floor_m - style.sill_m - 0.3),
    }
}

/// The last stretch of wall and the cornice that ends it.
fn cornice(model: &mut Model, place: &Place, width_m: f64, style: &Style, skin: &Skin) {
    let eaves = style.eaves_m();
    let top = eaves - 0.45;
    model.push(place.block([0.0, -WALL_M, top], [width_m, 0.0, eaves]), skin.wall);
    model.push(place.block([0.0, 0.0, top + 0.05], [width_m, 0.12, top + 0.22]), skin.trim);
    model.push(place.block([0.0, 0.0, top + 0.22], [width_m, 0.3, eaves]), skin.trim);
    let dentils = (width_m / 0.34).floor() as u32;
    for i in 0..dentils {
        let left = (f64::from(i) + 0.25) * width_m / f64::from(dentils);
        model.push(
            place.block([left, 0.12, top + 0.09], [left + 0.15, 0.24, top + 0.22]),
            skin.trim,
        );
    }
}

fn downpipe(
    model: &mut Model,
    place: &Place,
    width_m: f64,
    style: &Style,
    skin: &Skin,
    rng: &mut ChaCha8Rng,
) {
    let along = if rng.random_bool(0.5) { 0.14 } else { width_m - 0.14 };
    model.post(place.at(along, 0.09, 0.0), style.eaves_m() - 0.25, 0.055, skin.joinery);
}
