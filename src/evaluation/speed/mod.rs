//! How long a frame takes against how far it is from the most exact one. Nothing here knows of a
//! network or a command line.
//!
//! The most exact frame of a run has every setting at its most exact. Each variant changes one of
//! them, or several that are traded together; its error is the difference of its frames to the
//! most exact ones of the same views.

mod difference;
mod front;
pub(crate) mod ladder;
mod linearity;
mod report;
mod statistics;
mod variant;

pub(crate) use difference::Difference;
pub(crate) use front::mark_front;
pub(crate) use linearity::{Cost, OffScreen, line_through};
pub(crate) use report::{Described, FrontRung, Inputs, Linearity, Report, Row, Unit};
pub(crate) use statistics::{median, percentile};
pub(crate) use variant::{Feed, Variant, variants};
