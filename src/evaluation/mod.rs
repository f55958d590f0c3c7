//! How good a rendering is: what is held out, how it is rendered, and how far the picture is from
//! the photograph. Nothing here knows of a network or a command line.
//!
//! Definitions, so that figures compare with those of others: RGB in [0, 1] as it is stored
//! (sRGB), the whole frame unless a name says otherwise, a figure a view, then averaged over the
//! views.

mod bins;
mod compared;
mod hold_out;
mod method;
mod nearest;
mod page;
mod report;
mod score;
pub(crate) mod speed;
mod squared_error;
mod ssim;
mod stated;
pub(crate) mod walk;

pub(crate) use bins::Bin;
pub(crate) use compared::Compared;
pub(crate) use hold_out::{Choice, Split};
pub(crate) use method::{METHODS, Making, Method};
pub(crate) use nearest::nearest_source;
pub(crate) use page::{Gallery, page, speed_page, walk_page};
pub(crate) use report::{Described, Report, Row};
pub(crate) use score::Score;
pub(crate) use stated::StatedSettings;
