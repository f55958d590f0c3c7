//! The survey as a reader finds it on disk: read without any of the crate's own code, so
//! that a mistake in what is traced cannot cancel one in what is written.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use flaneur_sample::{Class, SampleOptions, write_street};
use flaneur_scene::{CubeFace, Distortion, Intrinsics, Lens, PosedCamera, View, world_from_rig};
use glam::{DMat3, DVec2, DVec3, UVec2};
use serde_json::Value;
use tempfile::TempDir;

/// A photograph or a held-out view: how points reach its pixels, and its labels.
pub(crate) struct Photograph {
    /// Name, for messages.
    pub(crate) name: String,
    /// World position of the centre.
    pub(crate) centre: DVec3,
    /// Size in pixels.
    pub(crate) size: UVec2,
    /// Class ids.
    pub(crate) labels: Vec<u8>,
    model: Model,
}

enum Model {
    Pinhole(PosedCamera),
    Sphere(DMat3),
}

/// A lidar point.
pub(crate) struct Point {
    pub(crate) position: DVec3,
    pub(crate) class: u8,
}

/// One sample for all tests: small, but with pictures and points dense enough to judge.
pub(crate) fn sample() -> &'static Path {
    static SAMPLE: OnceLock<TempDir> = OnceLock::new();
    SAMPLE
        .get_or_init(|| {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let options = SampleOptions {
                points: 500_000,
                image_px: 256,
                sphere_px: 256,
                view_px: 240,
                ..SampleOptions::tiny(7)
            };
            write_street(folder.path(), &options, &|_| {}, &false.into()).expect("a sample");
            folder
        })
        .path()
}

impl Photograph {
    /// Pixel of a world point, and its depth: along the axis, or distance for spheres.
    pub(crate) fn project(&self, p: DVec3) -> Option<(DVec2, f64)> {
        match &self.model {
            Model::Pinhole(camera) => {
                camera.project(p).filter(|(pixel, _)| camera.lens.contains(*pixel))
            }
            Model::Sphere(world_from_rig) => {
                let d = p - self.centre;
                let pixel =
                    CubeFace::equirectangular_from_rig(world_from_rig.transpose() * d, self.size);
                Some((pixel, d.length()))
            }
        }
    }

    /// The class of a pixel.
    pub(crate) fn class_at(&self, pixel: DVec2) -> Option<Class> {
        let id = self.labels[self.index(pixel)?];
        Some(Class::from_id(id).expect("a known class"))
    }

    /// The class around a pixel, where all pixels within two of it agree.
    pub(crate) fn class_around(&self, pixel: DVec2) -> Option<Class> {
        let class = self.class_at(pixel)?;
        let steps = || (-2..=2).map(f64::from);
        let same = steps()
            .all(|y| steps().all(|x| self.class_at(pixel + DVec2::new(x, y)) == Some(class)));
        same.then_some(class)
    }

    /// Index of a pixel, where it lies in the image.
    pub(crate) fn index(&self, pixel: DVec2) -> Option<usize> {
        let inside = pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(self.size.as_dvec2()).all();
        inside.then(|| pixel.y as usize * self.size.x as usize + pixel.x as usize)
    }
}

/// The photographs of the rig, from poses and calibration.
pub(crate) fn rig_photographs() -> Vec<Photograph> {
    let description = description();
    let rig = description["panoramas"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|entry| entry["format"].as_str() == Some("itowns"))
        .expect("a rig");
    let height = rig["height_offset_m"].as_float().expect("a number");
    let boresight = rig["boresight_deg"][0].as_float().expect("a number").to_radians();
    let mut photographs = Vec::new();
    for pose in json("poses.json").as_array().expect("a list") {
        let angle = |key: &str| number(&pose[key]).to_radians();
        let world_from_rig = world_from_rig(angle("heading"), angle("pitch"), angle("roll"))
            * DMat3::from_rotation_x(boresight);
        let origin = DVec3::new(
            number(&pose["easting"]),
            number(&pose["northing"]),
            number(&pose["altitude"]) + height,
        );
        for camera in json("calibration.json").as_array().expect("a list") {
            let name = format!("{}_{:07}", camera["id"], pose["id"].as_u64().expect("a number"));
            let (size, labels) = labels(&format!("labels/{name}.png"));
            let cam_from_rig = DMat3::from_cols_array(&numbers(&camera["rotation"])).transpose();
            let position = DVec3::from_array(numbers(&camera["position"]));
            let posed = PosedCamera {
                centre: origin + world_from_rig * position,
                cam_from_world: cam_from_rig * world_from_rig.transpose(),
                lens: calibrated_lens(camera).scaled_to(size),
            };
            let centre = posed.centre;
            photographs.push(Photograph {
                name,
                centre,
                size,
                labels,
                model: Model::Pinhole(posed),
            });
        }
    }
    photographs
}

fn calibrated_lens(camera: &Value) -> Lens {
    let [fx, _, cx, _, fy, cy, ..]: [f64; 9] = numbers(&camera["projection"]);
    let [width, height]: [f64; 2] = numbers(&camera["size"]);
    let distortion = &camera["distortion"];
    Lens {
        size: UVec2::new(width as u32, height as u32),
        intrinsics: Intrinsics { fx, fy, cx, cy },
        distortion: Distortion::RadialPixels {
            centre: DVec2::from_array(numbers(&distortion["pps"])),
            k: numbers(&distortion["poly357"]),
            limit_px: number(&distortion["limit"]),
        },
    }
}

/// The spheres, from their list.
pub(crate) fn spheres() -> Vec<Photograph> {
    let list = fs::read_to_string(path("equirectangular.csv")).expect("a list");
    let mut lines = list.lines();
    let header = "id,x,y,z,heading_deg,pitch_deg,roll_deg,image,time";
    assert_eq!(lines.next(), Some(header));
    let of = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let value = |i: usize| fields[i].parse::<f64>().expect("a number");
        let angle = |i: usize| value(i).to_radians();
        let (size, labels) = labels(&format!("labels/{}.png", fields[0]));
        let image = image::image_dimensions(path(fields[7])).expect("an image");
        assert_eq!(image, (size.x, size.y), "labels and image are of one size");
        Photograph {
            name: fields[0].to_owned(),
            centre: DVec3::new(value(1), value(2), value(3)),
            size,
            labels,
            model: Model::Sphere(world_from_rig(angle(4), angle(5), angle(6))),
        }
    };
    lines.map(of).collect()
}

/// The held-out views with their entries in the list.
pub(crate) fn views() -> Vec<(Photograph, Value)> {
    let list = json("truth/views.json");
    let of = |entry: &Value| {
        let file = |key: &str| format!("truth/{}", entry[key].as_str().expect("a name"));
        let (size, labels) = labels(&file("labels"));
        let angle = |key: &str| number(&entry[key]).to_radians();
        let eye = DVec3::from_array(numbers(&entry["position"]));
        let view =
            View::look(eye, angle("heading_deg"), angle("pitch_deg"), angle("fov_deg"), size);
        let model = Model::Pinhole(view.camera);
        (Photograph { name: file("file"), centre: eye, size, labels, model }, entry.clone())
    };
    list.as_array().expect("a list").iter().map(of).collect()
}

/// Every lidar point.
pub(crate) fn points() -> Vec<Point> {
    let mut points = Vec::new();
    for entry in fs::read_dir(sample()).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "laz") {
            let mut reader = las::Reader::from_path(&path).expect("a LAZ file");
            let data = reader.read_all().expect("points");
            let positions = data.x().zip(data.y()).zip(data.z());
            points.extend(
                positions
                    .zip(data.classification())
                    .map(|(((x, y), z), class)| Point { position: DVec3::new(x, y, z), class }),
            );
        }
    }
    points
}

/// A file of the sample.
pub(crate) fn path(name: &str) -> PathBuf {
    sample().join(name)
}

/// A JSON file of the sample.
pub(crate) fn json(name: &str) -> Value {
    let text = fs::read_to_string(path(name)).expect("a file");
    serde_json::from_str(&text).expect("JSON")
}

/// The sample's `street.toml`.
pub(crate) fn description() -> toml::Table {
    fs::read_to_string(path("street.toml")).expect("a file").parse().expect("TOML")
}

/// A one-channel image of the sample.
pub(crate) fn labels(name: &str) -> (UVec2, Vec<u8>) {
    let image = image::open(path(name)).expect("an image");
    let image = image.as_luma8().expect("one byte a pixel");
    (UVec2::new(image.width(), image.height()), image.as_raw().clone())
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

pub(crate) fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list: Vec<f64> = value.as_array().expect("a list").iter().map(number).collect();
    list.try_into().expect("so many numbers")
}
