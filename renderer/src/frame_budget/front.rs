//! The front of frames, from the most exact to the cheapest. Written by
//! `flaneur bench SCENE --front FILE`; not by hand.
//!
//! Measured on the scene "sample", 2 views of 1024x512 pixels, on
//! llvmpipe (LLVM 15.0.6, 256 bits), 4 processor cores. Above each rung: the root mean
//! square of the difference to the most exact frames, 255ths.

use super::{Rung, rung};

pub(super) const FRONT: &[Rung] = &[
    // 4.45
    rung(16, 1.0, Some(31), true, 1.0, 1210.4),
    // 4.87
    rung(16, 1.0, Some(3), true, 1.0, 1012.2),
    // 7.11
    rung(16, 1.0, Some(3), true, 0.9, 921.9),
    // 7.32
    rung(16, 1.0, Some(3), true, 0.8, 715.3),
    // 8.34
    rung(16, 1.0, Some(3), true, 0.7, 571.6),
    // 8.62
    rung(16, 1.0, Some(3), true, 0.6, 463.9),
    // 9.40
    rung(16, 1.0, Some(3), true, 0.5, 325.9),
    // 10.96
    rung(16, 1.0, Some(3), true, 0.42, 270.6),
    // 11.87
    rung(16, 1.0, Some(3), true, 0.35, 204.0),
    // 12.35
    rung(8, 1.0, Some(3), false, 0.35, 173.5),
    // 14.01
    rung(6, 1.0, Some(3), false, 0.35, 147.2),
    // 19.82
    rung(4, 1.0, Some(3), false, 0.35, 131.8),
];
