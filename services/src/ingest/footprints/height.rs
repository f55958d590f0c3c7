//! How high each footprint is.

use flaneur_scene::Polygon;
use glam::DVec2;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::{Placed, roofs};
use crate::ingest::street::{FootprintsSpec, HeightSource};
use crate::ingest::{BadInput, IngestError, Job};

/// The highest building, metres: beyond it, a height is in another unit or no height.
const HIGHEST_M: f64 = 2000.0;

/// A footprint without a height takes the median of so many others around it.
const NEIGHBOURS: usize = 8;

/// Gives every footprint a height, from where `spec` says. Those that have none there take the
/// median of their neighbours, with a warning.
///
/// # Errors
///
/// Where none of them has a height.
pub(super) fn settle(
    job: &Job,
    spec: &FootprintsSpec,
    footprints: &mut [Placed],
    points: &[std::path::PathBuf],
) -> Result<(), IngestError> {
    if footprints.is_empty() {
        return Ok(());
    }
    let (kind, lacking, remedy) = match &spec.height {
        Some(HeightSource::Constant(height_m)) => {
            footprints.iter_mut().for_each(|footprint| footprint.height_m = Some(*height_m));
            return Ok(());
        }
        Some(HeightSource::Property(name)) => {
            for footprint in footprints.iter_mut() {
                footprint.height_m = property(footprint, name);
            }
            let mut names: Vec<&str> = footprints
                .iter()
                .flat_map(|f| f.survey.attributes.keys())
                .map(|k| k.as_str())
                .collect();
            names.sort_unstable();
            names.dedup();
            names.truncate(40);
            let remedy = format!("choose height_property among {names:?}");
            ("absent-height", format!("have no number of metres in the property {name:?}"), remedy)
        }
        Some(HeightSource::Points) => {
            roofs::measure(job, footprints, points)?;
            let remedy = "give height_property, or a height in metres".to_owned();
            ("no-points-inside", "have no points of a roof inside".to_owned(), remedy)
        }
        None => {
            for footprint in footprints.iter_mut() {
                let top_m = footprint.survey.top_m;
                footprint.height_m =
                    top_m.map(|top| top - footprint.base_m).filter(|height| *height > 0.0);
            }
            let remedy =
                "give height_property, height = \"points\", or a height in metres".to_owned();
            ("absent-height", "have a geometry without height".to_owned(), remedy)
        }
    };
    let without: Vec<usize> =
        (0..footprints.len()).filter(|i| footprints[*i].height_m.is_none()).collect();
    if without.is_empty() {
        return Ok(());
    }
    if without.len() == footprints.len() {
        let problem = format!("all {} footprints {lacking}", footprints.len());
        return Err(BadInput::error(&spec.path, "", problem, remedy));
    }
    let some: Vec<&str> =
        without.iter().take(5).map(|i| footprints[*i].survey.id.as_str()).collect();
    job.warn(
        kind,
        format!(
            "{}: {} of {} footprints {lacking} and take the median of their neighbours: {some:?}{}",
            spec.path.display(),
            without.len(),
            footprints.len(),
            if without.len() > some.len() { ", …" } else { "" },
        ),
    );
    borrow(footprints, &without);
    Ok(())
}

/// A property as a height: a number of metres, or a text that is one.
fn property(footprint: &Placed, name: &str) -> Option<f64> {
    let value = footprint.survey.attributes.get(name)?;
    let height = value.as_f64().or_else(|| value.as_str()?.trim().parse().ok())?;
    (0.0..=HIGHEST_M).contains(&height).then_some(height)
}

/// Gives the footprints of `without` the median height of the nearest others.
fn borrow(footprints: &mut [Placed], without: &[usize]) {
    let known = footprints.iter().filter_map(|footprint| {
        Some(GeomWithData::new(corner(&footprint.survey.polygons)?.to_array(), footprint.height_m?))
    });
    let known = RTree::bulk_load(known.collect());
    for &index in without {
        let Some(at) = corner(&footprints[index].survey.polygons) else { continue };
        let mut heights: Vec<f64> = known
            .nearest_neighbor_iter(&at.to_array())
            .take(NEIGHBOURS)
            .map(|neighbour| neighbour.data)
            .collect();
        heights.sort_by(f64::total_cmp);
        footprints[index].height_m = heights.get(heights.len() / 2).copied();
    }
}

/// A vertex that stands for the place of a building.
fn corner(polygons: &[Polygon]) -> Option<DVec2> {
    polygons.first()?.rings.first()?.first().copied()
}
