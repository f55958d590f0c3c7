//! Which layers a street has, and what each is made from.

use super::fingerprint::{self, Fingerprint, Inputs};
use super::street::{GroundSpec, HeightSource, Street};
use super::{BadInput, IngestError, Job, inputs};

/// The layers of a street with their fingerprints.
pub(super) struct Plan {
    /// In the order of [`Street::points`].
    pub(super) points: Vec<LayerPlan>,
    /// The panoramas, where the street has any.
    pub(super) panoramas: Option<LayerPlan>,
    /// The terrain, where the street has any.
    pub(super) ground: Option<LayerPlan>,
    /// The footprints, where the street has any.
    pub(super) footprints: Option<LayerPlan>,
    /// Fingerprint of the whole scene.
    pub(super) fingerprint: String,
    /// The files that went into the fingerprints.
    pub(super) inputs: Inputs,
}

/// A layer to be made.
pub(super) struct LayerPlan {
    /// Name of its folder: `points-ahn3`, `ground`.
    pub(super) name: String,
    /// What it is made from.
    pub(super) fingerprint: String,
}

impl Plan {
    /// Reads every input file of the street once.
    pub(super) fn new(street: &Street, job: &Job) -> Result<Self, IngestError> {
        let footprint_files = inputs::of_footprints(&street.footprints);
        let mut ground_files = Vec::new();
        if let Some(spec) = &street.ground {
            ground_files = inputs::of_ground(spec);
            // The terrain reaches as far as the scene does.
            ground_files.extend(footprint_files.iter().cloned());
        }
        let panorama_files = inputs::of_panoramas(&street.panoramas).map_err(|error| {
            let problem = format!("the photographs cannot be listed: {error}");
            BadInput::error(&street.file, "[[panoramas]]", problem, "check its paths")
        })?;
        let point_files = street.points.iter().map(|spec| Inputs::bytes(&spec.files)).sum::<u64>();
        let other_files = [&ground_files, &footprint_files, &panorama_files];
        let total = point_files + other_files.map(|files| Inputs::bytes(files)).iter().sum::<u64>();

        let stage = fingerprint::stage(job, total);
        let folder = street.root.folder();
        let mut inputs = Inputs::default();
        let mut make = |name: &str, settings: &dyn Fn(&mut Fingerprint), files: &[_]| {
            let mut fingerprint = Fingerprint::new(name);
            fingerprint.settings(&job.skip_damaged, folder);
            settings(&mut fingerprint);
            fingerprint.files(files, folder, job, &*stage, &mut inputs)?;
            Ok::<_, IngestError>(LayerPlan {
                name: name.to_owned(),
                fingerprint: fingerprint.finish(),
            })
        };

        let mut points = Vec::new();
        for spec in &street.points {
            let settings = |fingerprint: &mut Fingerprint| fingerprint.settings(spec, folder);
            points.push(make(&format!("points-{}", spec.name), &settings, &spec.files)?);
        }
        let frame = (&street.scene.crs, street.scene.geographic_origin);
        let all_points: String = points.iter().map(|layer| layer.fingerprint.as_str()).collect();

        let mut panoramas = None;
        if !street.panoramas.is_empty() {
            let settings = |fingerprint: &mut Fingerprint| {
                fingerprint.settings(&frame, folder);
                fingerprint.settings(&street.panoramas, folder);
            };
            panoramas = Some(make("panoramas", &settings, &panorama_files)?);
        }
        let mut ground = None;
        if let Some(spec) = &street.ground {
            let settings = |fingerprint: &mut Fingerprint| {
                fingerprint.settings(&frame, folder);
                fingerprint.settings(spec, folder);
                fingerprint.text(&all_points);
                fingerprint.text(panoramas.as_ref().map_or("", |layer| &layer.fingerprint));
                fingerprint.settings(&street.footprints, folder);
            };
            ground = Some(make("ground", &settings, &ground_files)?);
        }
        let mut footprints = None;
        if !street.footprints.is_empty() {
            let from_points =
                street.footprints.iter().any(|spec| spec.height == Some(HeightSource::Points))
                    || matches!(street.ground, Some(GroundSpec::Points { .. }));
            let settings = |fingerprint: &mut Fingerprint| {
                fingerprint.settings(&frame, folder);
                fingerprint.settings(&street.footprints, folder);
                fingerprint.text(ground.as_ref().map_or("", |layer| &layer.fingerprint));
                fingerprint.text(if from_points { &all_points } else { "" });
            };
            footprints = Some(make("footprints", &settings, &footprint_files)?);
        }

        let mut scene = Fingerprint::new("scene");
        scene.settings(&street.scene, folder);
        for layer in points.iter().chain(&panoramas).chain(&ground).chain(&footprints) {
            scene.text(&layer.name);
            scene.text(&layer.fingerprint);
        }
        let fingerprint = scene.finish();
        Ok(Self { points, panoramas, ground, footprints, fingerprint, inputs })
    }

    /// Names and fingerprints of all layers.
    pub(super) fn layers(&self) -> Vec<(&str, &str)> {
        let rest = [&self.panoramas, &self.ground, &self.footprints].into_iter().flatten();
        let all = self.points.iter().chain(rest);
        all.map(|layer| (layer.name.as_str(), layer.fingerprint.as_str())).collect()
    }
}
