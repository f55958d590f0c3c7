//! Materials: from a place on a surface to its albedo, relief and gloss.

use glam::{DVec2, DVec3};

use super::noise::{fade, fractal};
use super::{ground, pane, wall};

/// A kind of surface. Colours are linear albedos, sizes metres.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Material {
    /// Roadway, with the markings of a block of this length.
    Road { length_m: f64 },
    /// Slabs of the sidewalk.
    Paving,
    /// Granite kerb stones.
    Kerb,
    /// Rendered wall.
    Plaster { colour: DVec3, seed: u32 },
    /// Bricks in stretcher bond.
    Brick { colour: DVec3, seed: u32 },
    /// Ashlar.
    Stone { colour: DVec3, seed: u32 },
    /// Mouldings, sills and slabs.
    Trim { colour: DVec3, seed: u32 },
    /// Painted wood or metal.
    Paintwork { colour: DVec3 },
    /// Louvred shutters.
    Louvres { colour: DVec3 },
    /// A window pane with a room behind it.
    Pane { size: DVec2, seed: u32 },
    /// A shop window with goods behind it.
    Display { size: DVec2, seed: u32 },
    /// A panelled door.
    Door { colour: DVec3, size: DVec2 },
    /// Lettering over a shop.
    Sign { colour: DVec3, size: DVec2, seed: u32 },
    /// Cloth over a shop window.
    Awning { colour: DVec3, stripes: bool },
    /// Clay roof tiles.
    Tiles { seed: u32 },
    /// Standing-seam zinc.
    Zinc { seed: u32 },
    /// Bark.
    Bark { seed: u32 },
    /// Leaves, which let light through.
    Leaf { colour: DVec3 },
    /// Glossy car paint.
    CarPaint { colour: DVec3 },
    /// Tinted car windows.
    CarGlass,
    /// Tyres and bumpers.
    Rubber,
}

/// Where on a surface a ray arrived.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// Position in the street frame.
    pub(crate) position: DVec3,
    /// Position on the shape (see [`crate::geometry::Shape::local`]).
    pub(crate) local: DVec3,
    /// Unit normal, towards the viewer.
    pub(crate) normal: DVec3,
    /// Direction of view.
    pub(crate) direction: DVec3,
    /// Width of a pixel there: finer detail averages out.
    pub(crate) footprint_m: f64,
}

/// What the surface is like there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Appearance {
    /// Diffuse reflectance.
    pub(crate) albedo: DVec3,
    /// Reflectance of the mirror-like coat at normal incidence, 0 for none.
    pub(crate) gloss: f64,
    /// Share of the light from behind that comes through.
    pub(crate) translucency: f64,
    /// How far the normal leans, in the directions of the plan of the surface.
    pub(crate) tilt: DVec2,
}

impl Appearance {
    /// A matt surface.
    pub(crate) fn matt(albedo: DVec3) -> Self {
        Self { albedo, gloss: 0.0, translucency: 0.0, tilt: DVec2::ZERO }
    }

    /// The same with a glossy coat.
    pub(crate) fn coated(self, gloss: f64) -> Self {
        Self { gloss, ..self }
    }
}

impl Spot {
    /// Position in the plane that the surface mostly lies in: (along the wall, up) on
    /// walls, the plan on ground and roofs.
    pub(crate) fn plan(&self) -> DVec2 {
        let n = self.normal.abs();
        let p = self.position;
        match () {
            () if n.z > 0.8 => p.truncate(),
            () if n.y > n.x => DVec2::new(p.x, p.z),
            () => DVec2::new(p.y, p.z),
        }
    }
}

impl Material {
    /// What the material is like at a spot.
    pub(crate) fn appearance(&self, spot: &Spot) -> Appearance {
        let f = spot.footprint_m;
        let plan = spot.plan();
        match *self {
            Self::Road { length_m } => ground::road(spot, length_m),
            Self::Paving => ground::paving(spot),
            Self::Kerb => ground::kerb(spot),
            Self::Plaster { colour, seed } => wall::plaster(plan, colour, f, seed),
            Self::Brick { colour, seed } => wall::brick(plan, colour, f, seed),
            Self::Stone { colour, seed } => wall::stone(plan, colour, f, seed),
            Self::Trim { colour, seed } => {
                let grain = fractal(plan, 0.5, 5, f, seed);
                Appearance::matt(colour * (1.0 + 0.22 * grain))
            }
            Self::Paintwork { colour } => Appearance::matt(colour).coated(0.015),
            Self::Louvres { colour } => {
                let slat = (spot.local.z / 0.055).rem_euclid(1.0);
                let dark = 1.0 - 0.55 * f64::from(slat < 0.35);
                let seen = fade(0.05, f);
                Appearance::matt(colour * (0.8 + seen * (dark - 0.8)))
            }
            Self::Pane { size, seed } => pane::window(spot, size, seed),
            Self::Display { size, seed } => pane::display(spot, size, seed),
            Self::Door { colour, size } => wall::door(spot, colour, size),
            Self::Sign { colour, size, seed } => wall::sign(spot, colour, size, seed),
            Self::Awning { colour, stripes } => {
                let light = stripes && (spot.local.x / 0.3).rem_euclid(2.0) < 1.0;
                let cloth = if light { DVec3::new(0.68, 0.66, 0.60) } else { colour * 1.3 + 0.02 };
                Appearance { translucency: 0.3, ..Appearance::matt(cloth) }
            }
            Self::Tiles { seed } => wall::tiles(spot, f, seed),
            Self::Zinc { seed } => wall::zinc(spot, f, seed),
            Self::Bark { seed } => {
                let ridges = fractal(DVec2::new(spot.local.x * 5.0, spot.local.y), 0.3, 5, f, seed);
                Appearance::matt(DVec3::new(0.15, 0.115, 0.085) * (1.0 + 1.1 * ridges).max(0.2))
            }
            Self::Leaf { colour } => {
                let vary = fractal(spot.local.truncate() + spot.position.truncate(), 0.25, 3, f, 5);
                let albedo = colour * (1.0 + 0.7 * vary).max(0.3);
                Appearance { translucency: 0.55, ..Appearance::matt(albedo).coated(0.008) }
            }
            Self::CarPaint { colour } => Appearance::matt(colour).coated(0.05),
            Self::CarGlass => Appearance::matt(DVec3::splat(0.03)).coated(0.07),
            Self::Rubber => Appearance::matt(DVec3::splat(0.022)),
        }
    }
}
