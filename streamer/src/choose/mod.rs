//! What a view wants. Nothing here touches the network: the same inputs give the same choice, so
//! that a picture does not depend on how its scene was reached.

mod cone;
mod districts;
mod gaze;
mod hierarchy;
mod nodes;
mod photographs;
mod samples;
mod tiles;

pub(crate) use districts::{
    DISTRICT_M, District, district_bounds, district_of, districts_around, districts_in,
};
pub use hierarchy::Hierarchy;
pub use nodes::{ChosenNodes, WantedNode, choose_nodes};
pub(crate) use photographs::{WantedImage, choose_photographs};
pub(crate) use tiles::{FootprintGrid, choose_tiles};
