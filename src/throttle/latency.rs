//! Delays as people write them.

use std::time::Duration;

/// The longest, milliseconds: where it begins to be of no use to anyone.
const MAX_MS: f64 = 2_000.0;

/// A delay as in `50ms`, `0.3s` or `0`.
pub(crate) fn parse_latency(text: &str) -> Result<Duration, String> {
    let wrong = || format!("{text:?} is no latency; write it as in 50ms or 0.3s");
    let (number, ms) = match (text.strip_suffix("ms"), text.strip_suffix('s')) {
        (Some(number), _) => (number, 1.0),
        (None, Some(number)) => (number, 1e3),
        (None, None) if text == "0" => (text, 1.0),
        (None, None) => return Err(wrong()),
    };
    let ms = number.parse::<f64>().map_err(|_| wrong())? * ms;
    if (0.0..=MAX_MS).contains(&ms) {
        Ok(Duration::from_secs_f64(ms / 1e3))
    } else {
        Err(format!("the latency is {text}, must be 0 to 2s"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_read_with_their_units() {
        assert_eq!(parse_latency("50ms"), Ok(Duration::from_millis(50)));
        assert_eq!(parse_latency("0.3s"), Ok(Duration::from_millis(300)));
        assert_eq!(parse_latency("0"), Ok(Duration::ZERO));
        for wrong in ["", "50", "ms", "-1ms", "nan ms", "2.1s", "5m"] {
            let error = parse_latency(wrong).expect_err(wrong);
            assert!(error.contains("latency"), "{wrong}: {error}");
        }
    }
}
