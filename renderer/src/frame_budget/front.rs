//! placeholder until the first measurement
use super::{Rung, rung};

pub(super) const FRONT: &[Rung] = &[
    rung(16, u64::MAX, Some(31), true, 1.0, 700.0),
    rung(14, u64::MAX, Some(23), true, 1.0, 651.0),
    rung(12, u64::MAX, Some(15), true, 1.0, 602.0),
    rung(10, u64::MAX, Some(11), true, 1.0, 553.0),
    rung(8, u64::MAX, Some(7), true, 1.0, 497.0),
    rung(7, 4000000, Some(7), true, 1.0, 455.0),
    rung(6, 3000000, Some(5), true, 1.0, 413.0),
    rung(5, 2000000, Some(5), true, 1.0, 371.0),
    rung(4, 2000000, Some(3), true, 1.0, 329.0),
    rung(4, 1400000, Some(3), true, 0.95, 301.0),
    rung(3, 1400000, Some(3), true, 0.95, 273.0),
    rung(3, 1000000, Some(3), true, 0.9, 245.0),
];
