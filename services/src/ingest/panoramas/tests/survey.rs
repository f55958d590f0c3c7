//! A small synthetic survey in the layout of iTowns: two panoramas of a rig of two cameras,
//! one with a mask.

use std::fs;
use std::path::Path;

use glam::UVec2;
use image::{ImageFormat, RgbImage};
use serde_json::{Value, json};

use crate::crs::Crs;
use crate::ingest::panoramas::{StagedPanoramas, ingest_panoramas};
use crate::ingest::street::{ImagePattern, ItownsSpec, MaskColour, North, PanoramasSpec, Root};
use crate::ingest::{IngestError, Job};

pub(crate) struct Survey {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) poses: Value,
    pub(crate) calibration: Value,
}

/// Size of the photographs; the calibration is for twice that.
pub(crate) const SIZE: UVec2 = UVec2::new(300, 200);

impl Survey {
    pub(crate) fn new() -> Self {
        let camera = |id: Value| {
            json!({
                "id": id, "rotation": [1, 0, 0, 0, 0, -1, 0, 1, 0], "position": [0, 0.1, 0.9],
                "projection": [500, 0, 300, 0, 500, 200, 0, 0, 1], "size": [600, 400],
                "distortion": {"pps": [301, 199], "poly357": [-1e-7, 0, 0], "limit": 900},
            })
        };
        let mut masked = camera(json!("b"));
        masked["mask"] = json!("masks/b.jpg");
        let pose = |id: u32| {
            json!({
                "id": id, "easting": 651_000.0 + 3.0 * f64::from(id), "northing": 6_861_000.0,
                "altitude": 40.0, "heading": 90.0, "pitch": 1.0, "roll": -0.5,
                "date": "2014-06-16T12:31:34Z", "unknown": null,
            })
        };
        let survey = Self {
            folder: tempfile::tempdir().expect("a folder"),
            poses: json!([pose(1), pose(2)]),
            calibration: json!([camera(json!(7)), masked]),
        };
        for panorama in 1..=2 {
            for camera in ["7", "b"] {
                let name = format!("images/{camera}-{panorama:03}.jpg");
                survey.write(&name, &jpeg(SIZE, panorama));
            }
        }
        survey.write(
            "masks/b.jpg",
            &jpeg_of(UVec2::new(150, 100), |x, _| if x < 50 { [255; 3] } else { [0; 3] }),
        );
        survey
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        fs::write(path, bytes).expect("written");
    }

    pub(crate) fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    /// Writes the lists and gives the entry that reads them.
    pub(crate) fn spec(&self) -> ItownsSpec {
        self.write("poses.json", self.poses.to_string().as_bytes());
        self.write("calibration.json", self.calibration.to_string().as_bytes());
        let root = Root::new(self.folder.path(), true).expect("a root");
        ItownsSpec {
            poses: root.folder().join("poses.json"),
            calibration: root.folder().join("calibration.json"),
            images: ImagePattern::parse("images/{camera}-{panorama:03}.jpg").expect("a pattern"),
            masks_exclude: Some(MaskColour::White),
            heading: North::Grid,
            height_offset_m: 2.0,
            boresight_deg: [0.0; 3],
            refine_poses: true,
            uncertainty_m: 0.3,
            root,
        }
    }

    pub(crate) fn ingest(&self, job: &Job) -> Result<Option<StagedPanoramas>, IngestError> {
        let crs = Crs::parse("EPSG:2154", None).expect("a CRS");
        ingest_panoramas(job, &[PanoramasSpec::Itowns(self.spec())], &crs)
    }

    /// The message of the error, which has one line and names `file`.
    pub(crate) fn refusal(&self, file: &str) -> String {
        let work = tempfile::tempdir().expect("a folder");
        let job = Job::new(work.path(), 1 << 26);
        let message = self.ingest(&job).expect_err("refused").to_string();
        assert!(message.contains(file) && !message.contains('\n'), "{message}");
        assert!(message.contains("; "), "no remedy: {message}");
        message
    }
}

/// A photograph with detail, different for each seed.
pub(crate) fn jpeg(size: UVec2, seed: u32) -> Vec<u8> {
    jpeg_of(size, |x, y| {
        [
            (x * 255 / size.x) as u8,
            (y * 255 / size.y) as u8,
            if (x / 8 + y / 8 + seed).is_multiple_of(2) { 40 } else { 210 },
        ]
    })
}

pub(crate) fn jpeg_of(size: UVec2, pixel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let rgb: Vec<u8> = (0..size.y)
        .flat_map(|y| (0..size.x).map(move |x| (x, y)))
        .flat_map(|(x, y)| pixel(x, y))
        .collect();
    let mut bytes = Vec::new();
    jpeg_encoder::Encoder::new(&mut bytes, 90)
        .encode(&rgb, size.x as u16, size.y as u16, jpeg_encoder::ColorType::Rgb)
        .expect("encoded");
    bytes
}

/// The photograph of [`jpeg`] in another format.
pub(crate) fn encoded(size: UVec2, seed: u32, format: ImageFormat) -> Vec<u8> {
    let image = image::load_from_memory(&jpeg(size, seed)).expect("decoded");
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("encoded");
    bytes.into_inner()
}

pub(crate) fn decoded(path: &Path) -> RgbImage {
    image::open(path).expect("decodes").into_rgb8()
}
