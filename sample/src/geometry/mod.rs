//! What rays meet: shapes, and the tree that finds the nearest of them.
//!
//! Everything here is in the street frame (see [`crate::frame`]), metres, f64.

mod bvh;
mod cutout;
mod shape;

pub(crate) use bvh::Bvh;
pub(crate) use cutout::Cutout;
pub(crate) use shape::Shape;

use glam::DVec3;

/// A half line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// Where it starts.
    pub(crate) origin: DVec3,
    /// Where it goes; unit length.
    pub(crate) direction: DVec3,
}

/// Where a ray meets a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Distance along the ray, metres.
    pub(crate) distance: f64,
    /// Unit normal of the surface, outward for solids; may face away from the ray on sheets.
    pub(crate) normal: DVec3,
}

/// A shape, the surface that covers it, and the holes in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Primitive {
    /// The geometry.
    pub(crate) shape: Shape,
    /// Index of the surface in [`crate::street::Street::surfaces`].
    pub(crate) surface: u32,
    /// Which parts of it are absent.
    pub(crate) cutout: Cutout,
}

/// The nearest contact among all primitives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Where.
    pub(crate) contact: Contact,
    /// Which primitive.
    pub(crate) primitive: u32,
}

impl Ray {
    /// The point at `distance`.
    pub(crate) fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
}

impl Primitive {
    /// Where the ray first meets what is there of the primitive, nearer than `limit`.
    pub(crate) fn intersect(&self, ray: &Ray, limit: f64) -> Option<Contact> {
        let contact = self.shape.intersect(ray, limit)?;
        let present = self.cutout.is_none()
            || self.cutout.is_present(self.shape.local(ray.at(contact.distance)));
        present.then_some(contact)
    }
}
