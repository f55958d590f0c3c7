//! The sample as a whole: what is written, in which order, under which names.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::UVec2;
use rayon::prelude::*;
use serde_json::Value;

use crate::camera::{Picture, Survey, Viewpoint, choose_viewpoints, take, there_and_back};
use crate::description::description;
use crate::files::Folder;
use crate::look::{Light, Shader};
use crate::street::{Class, Street};
use crate::{Progress, SampleError, SampleOptions, Stage, Summary, cadastre, lidar};

/// Writes a street into the folder `target`, which must be empty or absent.
///
/// The work is done in a folder beside it, which takes its place when all is complete; after
/// an error or when `cancel` turns true nothing is left. `progress` is called from any
/// thread. The layout is described in the crate's documentation.
pub fn write_street(
    target: &Path,
    options: &SampleOptions,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Summary, SampleError> {
    options.check()?;
    let failed = |source| SampleError::Write { source, path: target.to_owned() };
    match fs::read_dir(target).map(|mut entries| entries.next().is_some()) {
        Ok(true) => return Err(SampleError::NotEmpty { path: target.to_owned() }),
        Ok(false) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
        Err(source) => return Err(failed(source)),
    }
    let parent = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(failed)?;
    let unfinished =
        tempfile::Builder::new().prefix(".flaneur-sample-").tempdir_in(parent).map_err(failed)?;
    let job = Job { options, folder: Folder::new(unfinished.path()), progress, cancel };
    let summary = job.write()?;
    // An empty target gives way; some systems do not rename onto it.
    if target.exists() {
        fs::remove_dir(target).map_err(failed)?;
    }
    let finished = unfinished.keep();
    allow_reading(&finished).and_then(|()| fs::rename(&finished, target)).map_err(failed)?;
    Ok(summary)
}

/// Temporary folders are private; a sample is for whoever may read its parent.
fn allow_reading(path: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(path, fs::Permissions::from_mode(0o755))?;
    }
    let _ = path;
    Ok(())
}

struct Job<'a> {
    options: &'a SampleOptions,
    folder: Folder,
    progress: &'a (dyn Fn(Progress) + Sync),
    cancel: &'a AtomicBool,
}

impl Job<'_> {
    fn write(&self) -> Result<Summary, SampleError> {
        let options = self.options;
        self.report(Stage::Street, 0, 2);
        let street = Street::new(options.seed, options.length_m);
        self.report(Stage::Street, 1, 2);
        self.go_on()?;
        self.folder.write_json("footprints.geojson", &cadastre::footprints(&street))?;
        self.folder.create("truth")?;
        self.folder.write_json("truth/buildings.json", &cadastre::footprint_truth(&street))?;
        self.folder.write_json("truth/walk.json", &there_and_back(&street))?;
        let spots = cadastre::spot_heights(&street, options.seed);
        self.folder.write_json("ground.json", &spots)?;
        let survey = Survey::new(&street, options.seed, options.exposures, options.spheres);
        let (photographs, views) = self.pictures(&street, &survey)?;
        self.report(Stage::Points, 0, options.points);
        let (points, point_files) = lidar::scan(
            &street,
            options.seed,
            options.points,
            self.folder.path(),
            &|done| self.report(Stage::Points, done, options.points.max(done)),
            self.cancel,
        )?;
        self.folder.write("street.toml", description(options).as_bytes())?;
        Ok(Summary {
            buildings: street.buildings.len() as u64,
            photographs,
            views,
            points,
            point_files: u64::from(point_files),
        })
    }

    /// Writes photographs, labels, masks, poses and held-out views; gives the numbers of
    /// photographs and of views.
    fn pictures(&self, street: &Street, survey: &Survey) -> Result<(u64, u64), SampleError> {
        if survey.drive.is_empty() && survey.walk.is_empty() {
            return Ok((0, 0));
        }
        let light = Light::gather(street);
        self.report(Stage::Street, 2, 2);
        let shader = Shader { street, light: &light };
        for folder in ["images", "labels", "masks"] {
            self.folder.create(folder)?;
        }
        let classes: serde_json::Map<String, Value> = Class::ALL
            .iter()
            .map(|class| (class.id().to_string(), Value::from(class.name())))
            .collect();
        self.folder.write_json("labels/classes.json", &Value::Object(classes))?;
        let photographs = self.photographs(&shader, survey)?;
        let views = self.views(&shader, survey)?;
        Ok((photographs, views))
    }

    fn photographs(&self, shader: &Shader<'_>, survey: &Survey) -> Result<u64, SampleError> {
        let options = self.options;
        if !survey.drive.is_empty() {
            self.rig_files(survey)?;
        }
        if !survey.walk.is_empty() {
            let mut list = crate::camera::SpherePose::COLUMNS.to_owned();
            for pose in &survey.walk {
                list.push('\n');
                list.push_str(&pose.row(&format!("images/{}.jpg", pose.id)));
            }
            list.push('\n');
            self.folder.write("equirectangular.csv", list.as_bytes())?;
        }
        let cameras = &survey.rig.cameras;
        let of_rig = survey.drive.len() * cameras.len();
        let total = (of_rig + survey.walk.len()) as u64;
        let counter = AtomicU64::new(0);
        self.report(Stage::Photographs, 0, total);
        (0..of_rig + survey.walk.len()).into_par_iter().try_for_each(|index| {
            self.go_on()?;
            let (name, picture) = if index < of_rig {
                let pose = &survey.drive[index / cameras.len()];
                let camera = &cameras[index % cameras.len()];
                let size = UVec2::splat(options.image_px);
                let spread = 1.0 / camera.lens.scaled_to(size).intrinsics.fx;
                let sight = camera.sight(pose, size, shader.light);
                (format!("{}_{:07}", camera.id, pose.id), take(shader, size, spread, sight))
            } else {
                let pose = &survey.walk[index - of_rig];
                let size = UVec2::new(2, 1) * options.sphere_px;
                let spread = std::f64::consts::PI / f64::from(size.y);
                (pose.id.clone(), take(shader, size, spread, pose.sight(size)))
            };
            let Picture { size, rgb, labels, .. } = picture;
            self.folder.write_jpeg(&format!("images/{name}.jpg"), size, &rgb)?;
            self.folder.write_png(&format!("labels/{name}.png"), size, &labels)?;
            self.report(Stage::Photographs, counter.fetch_add(1, Ordering::Relaxed) + 1, total);
            Ok(())
        })?;
        Ok(total)
    }

    /// Poses, calibration and masks of the rig.
    fn rig_files(&self, survey: &Survey) -> Result<(), SampleError> {
        let mut masked = Vec::new();
        for camera in &survey.rig.cameras {
            if let Some(mask) = camera.mask() {
                let name = format!("masks/{}.png", camera.id);
                self.folder.write_png(&name, camera.mask_size(), &mask)?;
                masked.push((camera.id, name));
            }
        }
        let calibration = survey.rig.calibration(|id| {
            masked.iter().find(|(masked, _)| *masked == id).map(|(_, name)| name.clone())
        });
        self.folder.write_json("calibration.json", &calibration)?;
        let poses = survey.drive.iter().map(|pose| pose.entry()).collect();
        self.folder.write_json("poses.json", &Value::Array(poses))
    }

    fn views(&self, shader: &Shader<'_>, survey: &Survey) -> Result<u64, SampleError> {
        let options = self.options;
        let size = UVec2::new(options.view_px * 4 / 3, options.view_px);
        let views = choose_viewpoints(shader.street, survey, options.seed, options.views, size);
        let total = views.len() as u64;
        let counter = AtomicU64::new(0);
        self.report(Stage::Views, 0, total);
        let name = |index: usize| format!("view_{:03}", index + 1);
        views.par_iter().enumerate().try_for_each(|(index, view)| {
            self.go_on()?;
            self.view(shader, view, &format!("truth/{}", name(index)))?;
            self.report(Stage::Views, counter.fetch_add(1, Ordering::Relaxed) + 1, total);
            Ok::<_, SampleError>(())
        })?;
        let entries = views.iter().enumerate().map(|(i, view)| view.entry(&name(i))).collect();
        self.folder.write_json("truth/views.json", &Value::Array(entries))?;
        Ok(total)
    }

    fn view(&self, shader: &Shader<'_>, view: &Viewpoint, name: &str) -> Result<(), SampleError> {
        let spread = view.fov_deg.to_radians() / f64::from(view.size.y);
        let picture = take(shader, view.size, spread, view.sight());
        self.folder.write_png(&format!("{name}.png"), view.size, &picture.rgb)?;
        self.folder.write_png(&format!("{name}_labels.png"), view.size, &picture.labels)?;
        self.folder.write_depths(&format!("{name}_depth.npy"), view.size, &picture.depths)
    }

    fn report(&self, stage: Stage, done: u64, total: u64) {
        (self.progress)(Progress { stage, done, total });
    }

    fn go_on(&self) -> Result<(), SampleError> {
        if self.cancel.load(Ordering::Relaxed) { Err(SampleError::Cancelled) } else { Ok(()) }
    }
}
