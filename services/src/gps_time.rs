//! When a GPS time was, in UTC.

use flaneur_scene::GpsTimeKind;
use prost_types::Timestamp;

/// Adjusted times are so many seconds less than those since the GPS epoch.
const ADJUSTMENT_S: f64 = 1e9;
/// The GPS epoch, 6 January 1980 0:00 UTC, seconds since 1970.
const EPOCH_S: f64 = 315_964_800.0;
/// Nothing was surveyed after the year 2100, seconds since 1970.
const LATEST_S: f64 = 4_102_444_800.0;

/// The midnights before which a second was put in since the GPS epoch, seconds since 1970: 1 July 1981 to 1 January
/// 2017 (IERS Bulletin C). GPS time has none of them.
const LEAPS_S: [f64; 18] = [
    362_793_600.0,
    394_329_600.0,
    425_865_600.0,
    489_024_000.0,
    567_993_600.0,
    631_152_000.0,
    662_688_000.0,
    709_948_800.0,
    741_484_800.0,
    773_020_800.0,
    820_454_400.0,
    867_715_200.0,
    915_148_800.0,
    1_136_073_600.0,
    1_230_768_000.0,
    1_341_100_800.0,
    1_435_708_800.0,
    1_483_228_800.0,
];

/// The GPS time `seconds` as RFC 3339 in UTC, to a millisecond; `None` where `kind` does not say on
/// which day it was, where there is no time (0), and outside of 1980 to 2100.
pub fn utc(kind: GpsTimeKind, seconds: f64) -> Option<String> {
    if kind != GpsTimeKind::Adjusted || seconds == 0.0 {
        return None;
    }
    let gps_s = seconds + ADJUSTMENT_S;
    if !(gps_s >= 0.0 && gps_s + EPOCH_S < LATEST_S) {
        return None;
    }
    // Before the nth leap second GPS is n - 1 seconds ahead.
    let before = (1u8..).zip(LEAPS_S);
    let ahead_s = before
        .take_while(|(count, midnight)| gps_s + EPOCH_S - f64::from(*count) >= *midnight)
        .map(|(count, _)| f64::from(count))
        .last()
        .unwrap_or(0.0);
    // Stored as doubles, times have some tenths of a microsecond.
    let milliseconds = ((gps_s + EPOCH_S - ahead_s) * 1e3).round();
    let (whole, rest) = ((milliseconds / 1e3).floor(), milliseconds.rem_euclid(1e3));
    Some(Timestamp { seconds: whole as i64, nanos: rest as i32 * 1_000_000 }.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adjusted(gps_s: f64) -> Option<String> {
        utc(GpsTimeKind::Adjusted, gps_s - ADJUSTMENT_S)
    }

    #[test]
    fn adjusted_times_have_a_date() {
        // 14 September 2011 was the billionth second, less its fifteen leap seconds.
        let zero = utc(GpsTimeKind::Adjusted, 1e-9);
        assert_eq!(zero.as_deref(), Some("2011-09-14T01:46:25Z"));
        assert_eq!(adjusted(0.0).as_deref(), Some("1980-01-06T00:00:00Z"));
        let sample = utc(GpsTimeKind::Adjusted, 399_712_818.125_25);
        assert_eq!(sample.as_deref(), Some("2024-05-14T09:06:40.125Z"));
    }

    #[test]
    fn leap_seconds_are_put_in_where_they_were() {
        // GPS seconds of 1 January 2017 0:00:00 UTC: 13510 days and eighteen leap seconds.
        let gps_s = 13_510.0 * 86_400.0 + 18.0;
        assert_eq!(adjusted(gps_s).as_deref(), Some("2017-01-01T00:00:00Z"));
        assert_eq!(adjusted(gps_s - 2.0).as_deref(), Some("2016-12-31T23:59:59Z"));
        assert_eq!(adjusted(gps_s + 1.5).as_deref(), Some("2017-01-01T00:00:01.500Z"));
        // The first: 1 July 1981, 542 days after the epoch.
        let gps_s = 542.0 * 86_400.0 + 1.0;
        assert_eq!(adjusted(gps_s).as_deref(), Some("1981-07-01T00:00:00Z"));
        assert_eq!(adjusted(gps_s - 2.0).as_deref(), Some("1981-06-30T23:59:59Z"));
    }

    #[test]
    fn what_has_no_date_gets_none() {
        assert_eq!(utc(GpsTimeKind::Week, 228_671.75), None);
        assert_eq!(utc(GpsTimeKind::Unknown, 399_712_818.0), None);
        assert_eq!(utc(GpsTimeKind::Adjusted, 0.0), None);
        for seconds in [-1e9 - 1.0, 1e10, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(utc(GpsTimeKind::Adjusted, seconds), None, "{seconds}");
        }
    }
}
