//! The front of frames, from the most exact to the cheapest. Written by
//! `flaneur bench SCENE --front FILE`; not by hand.
//!
//! Measured on the scene "sample", 2 views of 1024x512 pixels, on
//! llvmpipe (LLVM 15.0.6, 256 bits), 4 processor cores. Above each rung: the root mean
//! square of the difference to the most exact frames, 255ths.

use super::{Rung, rung};

pub(super) const FRONT: &[Rung] = &[
    // 4.61
    rung(16, 1.0, Some(31), true, 1.0, 292.8),
    // 4.89
    rung(16, 1.0, Some(7), true, 1.0, 272.0),
    // 5.70
    rung(12, 1.0, Some(3), true, 1.0, 223.1),
    // 7.65
    rung(12, 1.0, Some(3), true, 0.9, 214.1),
    // 7.79
    rung(12, 1.0, Some(3), true, 0.8, 176.0),
    // 8.61
    rung(12, 1.0, Some(3), true, 0.7, 151.2),
    // 8.93
    rung(12, 1.0, Some(3), true, 0.6, 140.0),
    // 9.68
    rung(12, 1.0, Some(3), true, 0.5, 112.3),
    // 11.22
    rung(12, 1.0, Some(3), true, 0.42, 92.8),
    // 11.31
    rung(12, 0.75, Some(3), true, 0.42, 86.4),
    // 11.69
    rung(8, 0.75, Some(3), true, 0.42, 81.5),
    // 11.69
    rung(8, 0.75, Some(3), false, 0.42, 70.6),
    // 13.02
    rung(6, 0.75, Some(3), false, 0.42, 68.4),
    // 17.55
    rung(4, 0.75, Some(3), false, 0.42, 63.1),
    // 20.74
    rung(3, 0.75, Some(1), false, 0.42, 60.8),
    // 21.98
    rung(3, 0.75, Some(0), false, 0.42, 58.5),
    // 27.23
    rung(3, 0.25, Some(0), false, 0.42, 54.7),
];
