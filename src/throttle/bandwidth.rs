//! Rates as people write them.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

/// Bits a second, or no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bandwidth(Option<f64>);

/// The least and the most that is taken for a limit, bits a second.
const RANGE: [f64; 2] = [1e3, 1e12];

impl Bandwidth {
    /// Bits a second; `None` where there is no limit.
    pub(crate) fn bits_per_second(self) -> Option<f64> {
        self.0
    }

    /// How long so many bytes take.
    pub(super) fn time_for(self, bytes: usize) -> Duration {
        self.0.map_or(Duration::ZERO, |bits| Duration::from_secs_f64(8.0 * bytes as f64 / bits))
    }
}

impl FromStr for Bandwidth {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "unlimited" {
            return Ok(Self(None));
        }
        let wrong = || {
            format!("{text:?} is no bandwidth; write bits a second as in 10M or 500k, or unlimited")
        };
        let (number, unit) = match text.char_indices().next_back() {
            Some((end, 'k' | 'K')) => (&text[..end], 1e3),
            Some((end, 'M')) => (&text[..end], 1e6),
            Some((end, 'G')) => (&text[..end], 1e9),
            _ => (text, 1.0),
        };
        let bits = number.parse::<f64>().map_err(|_| wrong())? * unit;
        let [least, most] = RANGE;
        if (least..=most).contains(&bits) {
            Ok(Self(Some(bits)))
        } else {
            Err(format!("the bandwidth is {text}, must be 1k to 1000G bits a second, or unlimited"))
        }
    }
}

impl fmt::Display for Bandwidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => f.write_str("unlimited"),
            Some(bits) => {
                let units = [(1e9, "Gbit/s"), (1e6, "Mbit/s"), (1e3, "kbit/s")];
                let unit = units.into_iter().find(|(size, _)| bits >= *size);
                let (size, name) = unit.unwrap_or((1.0, "bit/s"));
                write!(f, "{} {name}", bits / size)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_with_their_units() {
        let bits = |text: &str| text.parse::<Bandwidth>().map(Bandwidth::bits_per_second);
        assert_eq!(bits("10M"), Ok(Some(1e7)));
        assert_eq!(bits("1.5G"), Ok(Some(1.5e9)));
        assert_eq!((bits("64k"), bits("64000")), (Ok(Some(64e3)), Ok(Some(64e3))));
        assert_eq!(bits("unlimited"), Ok(None));
        for wrong in ["", "M", "10MB", "10m", "é", "-1M", "0", "nan", "inf", "999", "2000G"] {
            let error = bits(wrong).expect_err(wrong);
            assert!(error.contains("bits a second"), "{wrong}: {error}");
        }
        let shown = |text: &str| text.parse::<Bandwidth>().expect("a rate").to_string();
        assert_eq!(
            (shown("2500k").as_str(), shown("unlimited").as_str()),
            ("2.5 Mbit/s", "unlimited")
        );
    }

    #[test]
    fn bytes_take_their_time() {
        let rate: Bandwidth = "10M".parse().expect("a rate");
        assert_eq!(rate.time_for(1_250_000), Duration::from_secs(1));
        let none: Bandwidth = "unlimited".parse().expect("a rate");
        assert_eq!(none.time_for(usize::MAX), Duration::ZERO);
    }
}
