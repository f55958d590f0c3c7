//! Views as arguments and files of them give them.

use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use flaneur_scene::{PosedCamera, View};
use glam::{DVec3, UVec2};
use serde::Deserialize;

use crate::exit::Exit;

/// Largest picture, in pixels: what a renderer takes.
const MAX_PIXELS: u64 = 1 << 25;

/// `x,y,z,heading,pitch`, world CRS and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Viewpoint {
    eye: DVec3,
    heading_deg: f64,
    pitch_deg: f64,
    fov_deg: Option<f64>,
    size: Option<Size>,
}

/// How much a picture shows from its bottom to its top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Height {
    /// A field of view, in perspective.
    Degrees(f64),
    /// A length, without perspective.
    Metres(f64),
}

/// `WIDTHxHEIGHT` in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub(crate) UVec2);

/// One entry of a file of views.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Listed {
    /// Where to stand and look.
    pub(crate) viewpoint: Viewpoint,
    /// The picture of what is to be seen there, as held-out views have one.
    pub(crate) file: Option<String>,
    /// When a walk is there, seconds.
    pub(crate) time_s: Option<f64>,
}

/// The same as it is written. It may say more, as what else there is to know of it.
#[derive(Deserialize)]
struct Entry {
    position: [f64; 3],
    heading_deg: f64,
    pitch_deg: f64,
    fov_deg: Option<f64>,
    width: Option<u32>,
    height: Option<u32>,
    file: Option<String>,
    time_s: Option<f64>,
}

impl Viewpoint {
    /// Where it stands, world, metres.
    pub(crate) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Its heading, clockwise from grid north, and its pitch, up, radians.
    pub(crate) fn angles(&self) -> (f64, f64) {
        (self.heading_deg.to_radians(), self.pitch_deg.to_radians())
    }

    /// The view from here, as high as `height` says unless it has a field of view of its own,
    /// and of the size `asked`, else of its own, else of `default`.
    pub(crate) fn view(&self, height: Height, asked: Option<Size>, default: Size) -> View {
        let Size(size) = asked.or(self.size).unwrap_or(default);
        let (heading, pitch) = (self.heading_deg.to_radians(), self.pitch_deg.to_radians());
        match (self.fov_deg.map_or(height, Height::Degrees), self.eye) {
            (Height::Degrees(fov), eye) => View::look(eye, heading, pitch, fov.to_radians(), size),
            (Height::Metres(height), eye) => View::orthographic(eye, heading, pitch, height, size),
        }
    }

    /// The same with a vertical field of view of its own, degrees, unless it has one.
    pub(crate) fn or_fov(self, fov_deg: f64) -> Self {
        Self { fov_deg: self.fov_deg.or(Some(fov_deg)), ..self }
    }

    /// The distance to `other`, metres, and the larger of the turns to its heading and to its pitch,
    /// degrees, from 0 to 180.
    pub(crate) fn way_to(&self, other: &Self) -> (f64, f64) {
        let turn = short_way(self.heading_deg, other.heading_deg).abs();
        (self.eye.distance(other.eye), turn.max((other.pitch_deg - self.pitch_deg).abs()))
    }

    /// What lies at `share`, 0 to 1, of the way to `other`: positions on a line, headings the short
    /// way round.
    pub(crate) fn towards(&self, other: &Self, share: f64) -> Self {
        let between = |a: f64, b: f64| a + share * (b - a);
        let heading = self.heading_deg + share * short_way(self.heading_deg, other.heading_deg);
        Self {
            // Not `lerp`, which wavers by an ulp between equal ends: who stands would move.
            eye: self.eye + share * (other.eye - self.eye),
            heading_deg: heading.rem_euclid(360.0),
            pitch_deg: between(self.pitch_deg, other.pitch_deg),
            fov_deg: self.fov_deg.zip(other.fov_deg).map(|(a, b)| between(a, b)),
            size: self.size,
        }
    }

    fn new(numbers: [f64; 5], fov_deg: Option<f64>) -> Result<Self, String> {
        let [x, y, z, heading_deg, pitch_deg] = numbers;
        if let Some(number) = numbers.iter().find(|n| !n.is_finite() || n.abs() > 1e9) {
            return Err(format!("{number} is out of range"));
        }
        if pitch_deg.abs() > 90.0 {
            return Err(format!("the pitch is {pitch_deg}, must be -90 to 90 degrees"));
        }
        let fov_deg = fov_deg.map(check_fov).transpose()?;
        Ok(Self { eye: DVec3::new(x, y, z), heading_deg, pitch_deg, fov_deg, size: None })
    }
}

impl Size {
    fn new(width: u32, height: u32) -> Result<Self, String> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > MAX_PIXELS || width.max(height) > 16_384 {
            return Err(format!(
                "{width}x{height} pixels, must be at least 1x1, at most 16384 a side and \
                 {MAX_PIXELS} in all"
            ));
        }
        Ok(Self(UVec2::new(width, height)))
    }
}

/// The viewpoints of a JSON file.
pub(crate) fn read_path(path: &Path) -> Result<Vec<Listed>, Exit> {
    let bad = |problem: String| {
        Exit::bad_input(anyhow::anyhow!(
            "{}: {problem}; it must be a list of {{\"position\": [x, y, z], \"heading_deg\": …, \
             \"pitch_deg\": …}}, with \"fov_deg\", \"width\" and \"height\" where they differ",
            path.display()
        ))
    };
    let text = std::fs::read_to_string(path).map_err(|e| bad(e.to_string()))?;
    let entries: Vec<Entry> = serde_json::from_str(&text).map_err(|e| bad(e.to_string()))?;
    if entries.is_empty() {
        return Err(bad("it holds no view".to_owned()));
    }
    let viewpoint = |(index, entry): (usize, Entry)| {
        let bad = |problem: String| bad(format!("view {}: {problem}", index + 1));
        let [x, y, z] = entry.position;
        let angles = [entry.heading_deg, entry.pitch_deg];
        let viewpoint = Viewpoint::new([x, y, z, angles[0], angles[1]], entry.fov_deg);
        let size = match (entry.width, entry.height) {
            (None, None) => None,
            (Some(width), Some(height)) => Some(Size::new(width, height).map_err(bad)?),
            _ => return Err(bad("width and height go together".to_owned())),
        };
        let viewpoint = Viewpoint { size, ..viewpoint.map_err(bad)? };
        Ok(Listed { viewpoint, file: entry.file, time_s: entry.time_s })
    };
    entries.into_iter().enumerate().map(viewpoint).collect()
}

/// The view of a photograph's own camera, at another size where one is given.
pub(crate) fn view_like(camera: PosedCamera, size: Option<Size>) -> View {
    let lens = size.map_or(camera.lens, |Size(size)| camera.lens.scaled_to(size));
    PosedCamera { lens, ..camera }.into()
}

/// A vertical field of view in degrees.
pub(crate) fn parse_fov(text: &str) -> Result<f64, String> {
    check_fov(text.parse().map_err(|_| format!("{text:?} is no number"))?)
}

/// The height of an orthographic picture in metres.
pub(crate) fn parse_height(text: &str) -> Result<f64, String> {
    let height_m: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if (0.01..=100_000.0).contains(&height_m) {
        Ok(height_m)
    } else {
        Err(format!("the height is {height_m}, must be 0.01 to 100000 metres"))
    }
}

/// A time that a frame may take, milliseconds.
pub(crate) fn parse_budget(text: &str) -> Result<Duration, String> {
    let ms: f64 = text.parse().map_err(|_| format!("{text:?} is no number of milliseconds"))?;
    if (1.0..=60_000.0).contains(&ms) {
        Ok(Duration::from_secs_f64(ms / 1e3))
    } else {
        Err(format!("the budget is {ms} ms, must be 1 to 60000"))
    }
}

/// The turn from one heading to another, -180 to 180 degrees.
fn short_way(from_deg: f64, to_deg: f64) -> f64 {
    (to_deg - from_deg + 180.0).rem_euclid(360.0) - 180.0
}

fn check_fov(fov_deg: f64) -> Result<f64, String> {
    if (1.0..=170.0).contains(&fov_deg) {
        Ok(fov_deg)
    } else {
        Err(format!("the field of view is {fov_deg}, must be 1 to 170 degrees"))
    }
}

impl FromStr for Viewpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text
            .split(',')
            .map(|n| n.trim().parse().map_err(|_| format!("{n:?} is no number")))
            .collect::<Result<_, _>>()?;
        let numbers = <[f64; 5]>::try_from(numbers)
            .map_err(|n| format!("{} numbers, must be x,y,z,heading,pitch", n.len()))?;
        Self::new(numbers, None)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is not WIDTHxHEIGHT, as in 1024x512");
        let (width, height) = text.split_once('x').ok_or_else(wrong)?;
        let side = |side: &str| side.parse::<u32>().map_err(|_| wrong());
        Self::new(side(width)?, side(height)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_five_numbers_in_range() {
        let viewpoint: Viewpoint = "651000.5, 6861000,-2.25,90,-10".parse().expect("a view");
        assert_eq!(viewpoint.eye, DVec3::new(651_000.5, 6_861_000.0, -2.25));
        assert_eq!((viewpoint.heading_deg, viewpoint.pitch_deg), (90.0, -10.0));
        for wrong in ["", "1,2,3,4", "1,2,3,4,5,6", "1,2,3,4,x", "1,2,nan,4,5", "1,2,3,4,91"] {
            assert!(wrong.parse::<Viewpoint>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_way_between_views_is_the_short_one() {
        let view = |heading: f64, pitch: f64| {
            Viewpoint::new([0.0, 0.0, 2.0, heading, pitch], None).expect("good").or_fov(60.0)
        };
        let (a, b) =
            (view(350.0, 0.0), Viewpoint { eye: DVec3::new(3.0, 4.0, 2.0), ..view(30.0, -10.0) });
        assert_eq!(a.way_to(&b), (5.0, 40.0));
        let far: Viewpoint = "651486.525,6861042.002,42.982,34.95,3".parse().expect("a view");
        for share in (0..1000).map(|share| f64::from(share) / 1000.0) {
            assert_eq!(far.towards(&far, share), far, "who stands stands");
        }
        let quarter = a.towards(&b, 0.25);
        assert_eq!((quarter.eye, quarter.heading_deg), (DVec3::new(0.75, 1.0, 2.0), 0.0));
        assert_eq!((quarter.pitch_deg, quarter.fov_deg), (-2.5, Some(60.0)));
        assert_eq!(b.towards(&a, 1.0).heading_deg, 350.0);
        assert_eq!(view(-720.0, 0.0).way_to(&view(180.0, 0.0)).1, 180.0);
    }

    #[test]
    fn sizes_have_two_sides_within_limits() {
        assert_eq!("1024x512".parse(), Ok(Size(UVec2::new(1024, 512))));
        for wrong in ["", "1024", "0x5", "-1x5", "1024x512x3", "20000x10", "10000x10000"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
        assert!(parse_fov("0").is_err() && parse_fov("60").is_ok() && parse_fov("nan").is_err());
    }

    #[test]
    fn a_file_of_views_says_where_it_is_wrong() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("views.json");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("writable");
            read_path(&path).map_err(|exit| match exit {
                Exit::BadInput(error) => error.to_string(),
                other => panic!("{other:?}"),
            })
        };
        let good = r#"{"position":[1,2,3],"heading_deg":4,"pitch_deg":5,"fov_deg":70}"#;
        let views = read(&format!("[{good}]")).expect("good");
        let viewpoint = Viewpoint::new([1.0, 2.0, 3.0, 4.0, 5.0], Some(70.0)).expect("good");
        assert_eq!(views, [Listed { viewpoint, file: None, time_s: None }]);
        let fault = |text: &str| read(text).expect_err("bad");
        let truth = good.replace("}", r#","width":768,"height":576,"file":"view_001.png"}"#);
        let listed = read(&format!("[{truth}]")).expect("good").remove(0);
        assert_eq!(listed.file.as_deref(), Some("view_001.png"));
        let view = listed.viewpoint.view(Height::Degrees(60.0), None, Size(UVec2::ONE));
        assert_eq!(view.size(), UVec2::new(768, 576));
        assert!(fault(&format!("[{}]", truth.replace("768", "0"))).contains("0x576"));
        assert!(fault("[]").contains("no view"));
        assert!(fault(r#"[{"position":[1,2,3],"heading":4}]"#).contains("heading"));
        let steep = good.replace("\"pitch_deg\":5", "\"pitch_deg\":95");
        assert!(fault(&format!("[{good},{steep}]")).contains("view 2"));
    }
}
