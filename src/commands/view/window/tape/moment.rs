//! When a lidar point was measured, as far as its survey says: as on the web page.

use flaneur_scene::GpsTimeKind;
use flaneur_services::gps_time;
use flaneur_streamer::SurveyedPoint;

const DAY_S: f64 = 86_400.0;
const DAYS: [&str; 7] =
    ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"];

/// The time to read, and what it was made from; the second is empty where there is nothing to say.
pub(super) fn moment(point: &SurveyedPoint) -> [String; 2] {
    let (kind, seconds) = (point.gps_time_kind, point.gps_time_s);
    let stored = format!("{seconds:.6} s");
    if seconds == 0.0 {
        return ["the survey has no times".to_owned(), String::new()];
    }
    match kind {
        GpsTimeKind::Adjusted => match gps_time::utc(kind, seconds) {
            Some(time) => [in_utc(&time), format!("adjusted standard GPS time {stored}")],
            None => {
                let remark = "declared as adjusted standard GPS time, of which no date follows";
                [stored, remark.to_owned()]
            }
        },
        GpsTimeKind::Week => match of_week(seconds) {
            Some(time) => [
                time,
                format!(
                    "declared as GPS week time {stored}; the survey does not say of which week, so \
                     there is no date"
                ),
            ],
            None => {
                let remark = "declared as GPS week time, which it is not; no date follows";
                [stored, remark.to_owned()]
            }
        },
        GpsTimeKind::Unknown => {
            let remark = "of an older store, which does not say what it counts from: ingest the survey again";
            [stored, remark.to_owned()]
        }
    }
}

/// An RFC 3339 time in UTC, to be read.
fn in_utc(time: &str) -> String {
    format!("{} UTC", time.trim_end_matches('Z').replacen('T', " ", 1))
}

/// A second of a week that begins on Sunday, as its day and the time of that day: a date is not said.
fn of_week(second: f64) -> Option<String> {
    let day = DAYS.get((second / DAY_S).floor().max(0.0) as usize).filter(|_| second > 0.0)?;
    let milliseconds = (second % DAY_S * 1e3).floor() as u64;
    let (seconds, rest) = (milliseconds / 1000, milliseconds % 1000);
    let [hour, minute, second] = [seconds / 3600, seconds / 60 % 60, seconds % 60];
    Some(format!("{day} {hour:02}:{minute:02}:{second:02}.{rest:03} GPS time"))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// What is said of a time.
    fn said(gps_time_kind: GpsTimeKind, gps_time_s: f64) -> [String; 2] {
        let (source, position) = ("lidar".to_owned(), DVec3::ZERO);
        let (class, intensity) = (2, 0);
        moment(&SurveyedPoint { source, position, class, intensity, gps_time_s, gps_time_kind })
    }

    #[test]
    fn a_time_is_a_date_where_the_survey_counts_from_one() {
        let [time, remark] = said(GpsTimeKind::Adjusted, 399_712_818.125);
        assert_eq!(time, "2024-05-14 09:06:40.125 UTC");
        assert_eq!(remark, "adjusted standard GPS time 399712818.125000 s");
        let [time, remark] = said(GpsTimeKind::Adjusted, -2e9);
        assert!(time == "-2000000000.000000 s" && remark.contains("no date"), "{remark}");
        assert_eq!(said(GpsTimeKind::Adjusted, 0.0)[0], "the survey has no times");
    }

    #[test]
    fn a_time_is_a_day_of_the_week_where_it_says_no_more() {
        let [time, remark] = said(GpsTimeKind::Week, 228_671.75);
        assert_eq!(time, "Tuesday 15:31:11.750 GPS time");
        assert!(remark.contains("228671.750000 s") && remark.contains("no date"), "{remark}");
        for seconds in [-1.0, 7.0 * DAY_S, 1e300, f64::NAN] {
            assert!(said(GpsTimeKind::Week, seconds)[1].contains("which it is not"), "{seconds}");
        }
        let [time, remark] = said(GpsTimeKind::Unknown, 1.5);
        assert!(time == "1.500000 s" && remark.contains("older store"), "{remark}");
    }

    #[test]
    fn the_words_are_the_web_page_s() {
        let page = include_str!("../../../../../services/web/src/strings.ts");
        for (kind, seconds) in [
            (GpsTimeKind::Adjusted, 1e9),
            (GpsTimeKind::Adjusted, -2e9),
            (GpsTimeKind::Week, 1.0),
            (GpsTimeKind::Week, -1.0),
            (GpsTimeKind::Unknown, 1.0),
        ] {
            let stored = format!("{seconds:.6} s");
            let remark = said(kind, seconds)[1].replace(&stored, "${stored}");
            assert!(page.contains(&remark), "the page does not say: {remark}");
        }
        assert!(page.contains(&said(GpsTimeKind::Week, 0.0)[0]));
        assert!(page.contains(&DAYS.map(|day| format!("{day:?}")).join(", ")));
    }
}
