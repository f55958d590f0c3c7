//! What a view wants, and in which order. Nothing here touches the network: the same inputs
//! give the same choice, so that a picture does not depend on how its scene was reached.

mod cone;
mod nodes;
mod photographs;
mod tiles;

pub(crate) use nodes::{Hierarchy, WantedNode, choose_nodes};
pub(crate) use photographs::{WantedImage, choose_photographs};
pub(crate) use tiles::{FootprintGrid, wanted_tiles};
