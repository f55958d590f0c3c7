//! Counts, rates and durations as people read them.

use std::time::Duration;

use flaneur_services::ingest::Unit;

/// `n` with its unit, as in `1.2 M points` or `3.4 MB`.
pub(super) fn amount(n: f64, unit: Unit) -> String {
    match unit {
        Unit::Points => format!("{} points", scaled(n)),
        Unit::Images => format!("{} images", scaled(n)),
        Unit::Bytes => format!("{}B", scaled(n)),
        Unit::Items => scaled(n).trim_end().to_owned(),
    }
}

/// A duration in its two largest parts, as in `1 h 02 min`, `3 min 20 s` or `4 s`.
pub(super) fn duration(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
    }
}

/// Three significant digits and a metric prefix; small whole numbers stay whole.
fn scaled(n: f64) -> String {
    let (value, prefix) = match n {
        n if n >= 1e9 => (n / 1e9, " G"),
        n if n >= 1e6 => (n / 1e6, " M"),
        n if n >= 1e4 => (n / 1e3, " k"),
        n => {
            return if n >= 100.0 || n.fract() == 0.0 {
                format!("{n:.0}")
            } else {
                format!("{n:.1}")
            };
        }
    };
    let digits = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$}{prefix}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_read_well() {
        assert_eq!(amount(0.0, Unit::Items), "0");
        assert_eq!(amount(950.0, Unit::Points), "950 points");
        assert_eq!(amount(12_345.0, Unit::Images), "12.3 k images");
        assert_eq!(amount(2_670_000.0, Unit::Points), "2.67 M points");
        assert_eq!(amount(41_000_000_000.0, Unit::Bytes), "41.0 GB");
    }

    #[test]
    fn durations_read_well() {
        assert_eq!(duration(Duration::from_millis(4900)), "4 s");
        assert_eq!(duration(Duration::from_secs(200)), "3 min 20 s");
        assert_eq!(duration(Duration::from_secs(3725)), "1 h 02 min");
    }
}
