//! Classes of lidar points in words, as on the web page.

/// Names of ASPRS LAS 1.4-R15, table 17, from 0 on.
const NAMES: [&str; 23] = [
    "never classified",
    "unclassified",
    "ground",
    "low vegetation",
    "medium vegetation",
    "high vegetation",
    "building",
    "low point (noise)",
    "model key point (reserved since LAS 1.4)",
    "water",
    "rail",
    "road surface",
    "overlap (reserved since LAS 1.4)",
    "wire, guard (shield)",
    "wire, conductor (phase)",
    "transmission tower",
    "wire-structure connector (insulator)",
    "bridge deck",
    "high noise",
    "overhead structure",
    "ignored ground",
    "snow",
    "temporal exclusion",
];
/// From here on a class means what its user says.
const USERS: u8 = 64;

/// What a class of LAS is, in words, and its number.
pub(super) fn las_class(code: u8) -> String {
    let others = if code < USERS { "reserved by LAS" } else { "defined by the survey" };
    let name = NAMES.get(usize::from(code)).unwrap_or(&others);
    format!("{name}, class {code}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_the_web_page_s_names() {
        let page = include_str!("../../../../../services/web/src/measure/las_class.ts");
        let names = page.lines().filter_map(|line| {
            let (code, name) = line.trim().split_once(": \"")?;
            Some((code.parse().ok()?, name.strip_suffix("\",")?))
        });
        assert!(names.eq((0..).zip(NAMES)), "the page has others");
        assert_eq!(las_class(2), "ground, class 2");
        assert_eq!(las_class(23), "reserved by LAS, class 23");
        assert_eq!(las_class(64), "defined by the survey, class 64");
    }
}
