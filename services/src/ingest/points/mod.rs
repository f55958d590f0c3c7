//! Points: LAS, LAZ and COPC files in, COPC files out, with every point and attribute.

mod chunk_table;
mod decode;
mod file;
mod las_header;
mod ordered;
mod scan;

pub use scan::{ScannedPoints, scan};
