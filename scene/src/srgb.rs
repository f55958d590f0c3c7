//! The curve that photographs' bytes follow.

/// The curve of IEC 61966-2-1, of one channel from 0 to 1.
pub fn srgb_from_linear(c: f64) -> f64 {
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// Its inverse.
pub fn linear_from_srgb(c: f64) -> f64 {
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for byte in 0..=255u32 {
            let c = f64::from(byte) / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(c)) - c).abs() < 1e-7, "{byte}");
        }
        // Middle grey, as every table of the curve has it.
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
    }
}
