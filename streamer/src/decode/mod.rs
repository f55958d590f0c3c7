//! From the bytes of the store to what a renderer takes, on threads that may block.

mod colour;
mod cube;
mod feather;
mod laz;
mod mask;
mod normals;
mod order;
mod picture;
mod points;
mod spacing;
mod stations;
mod surveyed;
mod workers;

pub(crate) use cube::cube_face;
pub(crate) use mask::{Mask, decode_mask};
pub use picture::Picture;
pub(crate) use picture::decode_picture;
pub(crate) use points::decode_points;
pub(crate) use stations::Track;
pub use surveyed::SurveyedPoint;
pub(crate) use surveyed::nearest_point;
pub(crate) use workers::decoded;

use crate::StreamError;

pub(crate) fn damaged(what: impl Into<String>, problem: impl Into<String>) -> StreamError {
    StreamError::Damaged { what: what.into(), problem: problem.into() }
}
