//! Analytic shapes and their intersection with rays.

use flaneur_scene::Bounds3;
use glam::{DVec2, DVec3};

use super::{Contact, Ray};

/// Contacts nearer than this are the surface that the ray starts on.
const NEAREST_M: f64 = 1e-6;

/// A piece of geometry.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    /// A solid box along the axes.
    Block { min: DVec3, max: DVec3 },
    /// A parallelogram with corner `corner` and sides `u` and `v`; its normal is u × v.
    Sheet { corner: DVec3, u: DVec3, v: DVec3 },
    /// A triangle; its normal is ab × ac.
    Triangle { a: DVec3, ab: DVec3, ac: DVec3 },
    /// A solid ellipsoid along the axes.
    Ellipsoid { centre: DVec3, radii: DVec3 },
    /// The mantle of a cone frustum from `base` along `axis`; discs close its ends.
    Tube { base: DVec3, axis: DVec3, base_radius: f64, top_radius: f64 },
    /// A disc.
    Disc { centre: DVec3, normal: DVec3, radius: f64 },
}

impl Shape {
    /// The triangle with corners a, b, c.
    pub(crate) fn triangle(a: DVec3, b: DVec3, c: DVec3) -> Self {
        Self::Triangle { a, ab: b - a, ac: c - a }
    }

    /// The box around it.
    pub(crate) fn bounds(&self) -> Bounds3 {
        match *self {
            Self::Block { min, max } => Bounds3 { min, max },
            Self::Sheet { corner, u, v } => {
                around(&[corner, corner + u, corner + v, corner + u + v])
            }
            Self::Triangle { a, ab, ac } => around(&[a, a + ab, a + ac]),
            Self::Ellipsoid { centre, radii } => {
                Bounds3 { min: centre - radii, max: centre + radii }
            }
            Self::Tube { base, axis, base_radius, top_radius } => {
                let low = disc_bounds(base, axis.normalize_or(DVec3::Z), base_radius);
                low.union(&disc_bounds(base + axis, axis.normalize_or(DVec3::Z), top_radius))
            }
            Self::Disc { centre, normal, radius } => disc_bounds(centre, normal, radius),
        }
    }

    /// Position of a point of the shape in the shape's own metres: along `u` and `v` for
    /// sheets, from the lowest corner for boxes, (arc, height) on tubes, in the plane of discs.
    pub(crate) fn local(&self, p: DVec3) -> DVec3 {
        match *self {
            Self::Block { min, .. } => p - min,
            Self::Sheet { corner, u, v } => {
                let d = p - corner;
                DVec3::new(d.dot(u.normalize_or_zero()), d.dot(v.normalize_or_zero()), 0.0)
            }
            Self::Triangle { a, .. } => p - a,
            Self::Ellipsoid { centre, .. } => p - centre,
            Self::Tube { base, axis, base_radius, .. } => {
                let axis = axis.normalize_or(DVec3::Z);
                let (e1, e2) = axis.any_orthonormal_pair();
                let d = p - base;
                DVec3::new(d.dot(e2).atan2(d.dot(e1)) * base_radius, d.dot(axis), 0.0)
            }
            Self::Disc { centre, normal, .. } => {
                let (e1, e2) = normal.any_orthonormal_pair();
                DVec2::new((p - centre).dot(e1), (p - centre).dot(e2)).extend(0.0)
            }
        }
    }

    /// The first contact in front of the ray's start and nearer than `limit`.
    pub(crate) fn intersect(&self, ray: &Ray, limit: f64) -> Option<Contact> {
        let contact = match *self {
            Self::Block { min, max } => block(ray, min, max),
            Self::Sheet { corner, u, v } => {
                let (distance, a, b, normal) = plane_coordinates(ray, corner, u, v)?;
                ((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b))
                    .then_some(Contact { distance, normal })
            }
            Self::Triangle { a, ab, ac } => {
                let (distance, s, t, normal) = plane_coordinates(ray, a, ab, ac)?;
                (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some(Contact { distance, normal })
            }
            Self::Ellipsoid { centre, radii } => ellipsoid(ray, centre, radii),
            Self::Tube { base, axis, base_radius, top_radius } => {
                tube(ray, base, axis, base_radius, top_radius)
            }
            Self::Disc { centre, normal, radius } => disc(ray, centre, normal, radius),
        }?;
        (contact.distance > NEAREST_M && contact.distance < limit).then_some(contact)
    }
}

fn around(points: &[DVec3]) -> Bounds3 {
    let mut bounds = Bounds3::EMPTY;
    points.iter().for_each(|&p| bounds.include(p));
    bounds
}

fn disc_bounds(centre: DVec3, normal: DVec3, radius: f64) -> Bounds3 {
    let reach = (DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt) * radius;
    Bounds3 { min: centre - reach, max: centre + reach }
}

/// Slabs (Kay and Kajiya 1986): the entry, or the exit where the ray starts inside.
fn block(ray: &Ray, min: DVec3, max: DVec3) -> Option<Contact> {
    let inverse = ray.direction.recip();
    let (a, b) = ((min - ray.origin) * inverse, (max - ray.origin) * inverse);
    let (near, far) = (a.min(b), a.max(b));
    let (enter, exit) = (near.max_element(), far.min_element());
    if !(enter <= exit) || exit <= NEAREST_M {
        return None;
    }
    let inside = enter <= NEAREST_M;
    let (distance, slabs) = if inside { (exit, far) } else { (enter, near) };
    let mut normal = DVec3::ZERO;
    let axis = (0..3).find(|&i| slabs[i] == distance)?;
    // Outward where the ray enters it is against the ray; where it leaves, along it.
    let along = ray.direction[axis].signum();
    normal[axis] = if inside { along } else { -along };
    Some(Contact { distance, normal })
}

/// Distance to the plane through `corner` along `u` and `v`, and the coordinates there.
fn plane_coordinates(
    ray: &Ray,
    corner: DVec3,
    u: DVec3,
    v: DVec3,
) -> Option<(f64, f64, f64, DVec3)> {
    // Möller and Trumbore 1997.
    let p = ray.direction.cross(v);
    let determinant = u.dot(p);
    if determinant.abs() < 1e-14 {
        return None;
    }
    let to_origin = ray.origin - corner;
    let q = to_origin.cross(u);
    let distance = v.dot(q) / determinant;
    let coordinates = (to_origin.dot(p) / determinant, ray.direction.dot(q) / determinant);
    Some((distance, coordinates.0, coordinates.1, u.cross(v).try_normalize()?))
}

fn ellipsoid(ray: &Ray, centre: DVec3, radii: DVec3) -> Option<Contact> {
    let (o, d) = ((ray.origin - centre) / radii, ray.direction / radii);
    let distance = first_root(d.length_squared(), o.dot(d), o.length_squared() - 1.0)?;
    let normal = ((ray.at(distance) - centre) / (radii * radii)).try_normalize()?;
    Some(Contact { distance, normal })
}

fn disc(ray: &Ray, centre: DVec3, normal: DVec3, radius: f64) -> Option<Contact> {
    let facing = ray.direction.dot(normal);
    if facing.abs() < 1e-12 {
        return None;
    }
    let distance = (centre - ray.origin).dot(normal) / facing;
    let near = ray.at(distance).distance_squared(centre) <= radius * radius;
    near.then_some(Contact { distance, normal })
}

/// The mantle, or one of the discs at its ends, whichever comes first.
fn tube(ray: &Ray, base: DVec3, axis: DVec3, base_radius: f64, top_radius: f64) -> Option<Contact> {
    let length = axis.length();
    let unit = axis / length;
    let slope = (top_radius - base_radius) / length;
    let o = ray.origin - base;
    let (o_along, d_along) = (o.dot(unit), ray.direction.dot(unit));
    // |x − (x·a)a|² = (r₀ + k x·a)², quadratic in the distance.
    let radius = base_radius + slope * o_along;
    let a = 1.0 - d_along * d_along * (1.0 + slope * slope);
    let b = o.dot(ray.direction) - o_along * d_along - radius * slope * d_along;
    let c = o.length_squared() - o_along * o_along - radius * radius;
    let discriminant = b * b - a * c;
    let mut nearest: Option<Contact> = None;
    let mut consider = |contact: Contact| {
        if contact.distance > NEAREST_M && nearest.is_none_or(|n| contact.distance < n.distance) {
            nearest = Some(contact);
        }
    };
    if discriminant >= 0.0 && a.abs() > 1e-14 {
        let root = discriminant.sqrt();
        for distance in [(-b - root) / a, (-b + root) / a] {
            let along = o_along + distance * d_along;
            if (0.0..=length).contains(&along) {
                let radial = o + ray.direction * distance - unit * along;
                if let Some(outward) = radial.try_normalize() {
                    let normal = (outward - unit * slope).normalize();
                    consider(Contact { distance, normal });
                }
            }
        }
    }
    for (centre, normal, radius) in [(base, -unit, base_radius), (base + axis, unit, top_radius)] {
        if let Some(contact) = disc(ray, centre, normal, radius) {
            consider(contact);
        }
    }
    nearest
}

/// The smaller root of a t² + 2 b t + c beyond the start, a > 0.
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    [(-b - root) / a, (-b + root) / a].into_iter().find(|&t| t > NEAREST_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every shape is met from every side at a point that lies on it, with a normal that
    /// agrees with the side it was met from.
    #[test]
    fn solids_are_met_on_their_surface_from_outside() {
        let solids = [
            Shape::Block { min: DVec3::new(-1.0, -0.5, -0.7), max: DVec3::new(1.0, 0.6, 0.8) },
            Shape::Ellipsoid { centre: DVec3::ZERO, radii: DVec3::new(1.0, 0.5, 0.8) },
            Shape::Tube {
                base: DVec3::new(0.1, 0.0, -0.8),
                axis: DVec3::new(-0.2, 0.1, 1.6),
                base_radius: 0.6,
                top_radius: 0.3,
            },
        ];
        for shape in solids {
            for index in 0..500u32 {
                let angle = f64::from(index) * 2.399_963;
                let z = 1.0 - (f64::from(index) + 0.5) / 250.0;
                let from =
                    DVec2::from_angle(angle).extend(0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
                let origin = from * 9.0 + DVec3::new(0.02, -0.03, 0.04);
                let ray = Ray { origin, direction: (-from).normalize() };
                let contact = shape.intersect(&ray, f64::INFINITY).expect("aimed at the middle");
                assert!(contact.normal.dot(ray.direction) < 0.0, "{shape:?} {from}");
                assert!((contact.normal.length() - 1.0).abs() < 1e-12);
                // From just behind the contact the shape surrounds: the exit is met.
                let inside =
                    Ray { origin: ray.at(contact.distance + 1e-3), direction: ray.direction };
                let exit = shape.intersect(&inside, f64::INFINITY).expect("inside a solid");
                assert!(exit.normal.dot(ray.direction) > 0.0, "{shape:?} {from}");
                let p = ray.at(contact.distance);
                let bounds = shape.bounds();
                assert!(bounds.distance(p) < 1e-9, "{shape:?} contact outside bounds at {p}");
            }
        }
    }

    #[test]
    fn sheets_end_at_their_sides() {
        let sheet =
            Shape::Sheet { corner: DVec3::ZERO, u: DVec3::X * 2.0, v: DVec3::new(0.5, 1.0, 0.0) };
        let down = |x, y| Ray { origin: DVec3::new(x, y, 5.0), direction: DVec3::NEG_Z };
        assert!(sheet.intersect(&down(0.6, 0.99), 9.0).is_some());
        assert!(sheet.intersect(&down(0.4, 0.99), 9.0).is_none());
        assert!(sheet.intersect(&down(1.0, 0.5), 4.9).is_none(), "beyond the limit");
        assert!((sheet.local(DVec3::new(1.5, 0.0, 0.0)).x - 1.5).abs() < 1e-12);
    }
}
