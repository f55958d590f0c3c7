//! The whole way from a `street.toml` to a published scene.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::assemble::{Assembled, assemble};
use super::build::{Built, build};
use super::plan::Plan;
use super::publish::Destination;
use super::street::Street;
use super::summary::{Summary, peak_memory_bytes};
use super::workspace::Workspace;
use super::{BadInput, IngestError, Job, Warnings};
use crate::crs::Crs;
use crate::store::{Manifest, Store};

/// What an ingest is to do besides the obvious.
#[derive(Clone, Copy, Debug, Default)]
pub struct IngestOptions {
    /// Make and publish everything anew, whatever has been made before.
    pub force: bool,
}

/// Publishes `street` as a scene of `store`. Intermediate files go to a folder of the scene's
/// own below `job.work`, which is removed at the end; after a failure or a kill it stays, and
/// what is finished in it is used by the next call.
///
/// Where the store holds a scene made from the same inputs with the same settings, nothing is
/// done.
///
/// # Errors
///
/// The store is then as it was.
pub async fn ingest(
    street: Street,
    store: Store,
    options: IngestOptions,
    job: Arc<Job>,
) -> Result<Summary, IngestError> {
    let started = Instant::now();
    check_places(&street, &store, &job)?;
    let crs = Crs::parse(&street.scene.crs, street.scene.geographic_origin);
    let crs = crs.map_err(|error| {
        BadInput::error(&street.file, "[scene], crs", error.to_string(), "correct it")
    })?;
    let street = Arc::new(street);
    let mut destination = Destination::open(&store, &street.scene.name, &job).await?;
    let plan = blocking(&street, &job, Plan::new).await?;
    if !options.force
        && destination.is_published(&plan.fingerprint)
        && let Some(manifest) = &destination.previous
    {
        if let Some(left) = Workspace::left_over(&job.work, store.name(), &street.scene.name) {
            destination.tidy();
            remove(left);
        }
        return Ok(unchanged(manifest, &store, destination.bytes(), started));
    }
    destination.check_writable(&job).await?;

    let force = options.force;
    let made = blocking(&street, &job, move |street, job| {
        let workspace = Workspace::open(&job.work, store.name(), &street.scene.name)?;
        if force {
            workspace.keep_only(&[])?;
        }
        let built = build(street, &crs, &plan, &workspace, job)?;
        let assembled = assemble(street, &plan, &built, job)?;
        plan.inputs.check_unaltered()?;
        Ok((workspace, built, assembled, store))
    });
    let (workspace, built, assembled, store) = made.await?;
    destination.publish(&assembled.objects, &assembled.manifest, force, &job).await?;
    remove(workspace);
    Ok(made_summary(&built, &assembled, &store, started))
}

/// The work folder must not be what readers of the store list.
fn check_places(street: &Street, store: &Store, job: &Job) -> Result<(), IngestError> {
    let Some(folder) = store.folder() else { return Ok(()) };
    let inside = |path: &PathBuf| {
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.clone());
        absolute.canonicalize().unwrap_or(absolute).starts_with(folder)
    };
    if inside(&job.work) {
        return Err(BadInput::error(
            &job.work,
            "",
            "the work folder lies in the store",
            "choose a work folder elsewhere with --work",
        ));
    }
    let scene = folder.join(&street.scene.name);
    if street.root.folder().starts_with(&scene) {
        return Err(BadInput::error(
            &street.file,
            "",
            format!("the street lies in {}, where its scene would be", scene.display()),
            "choose another store with --out",
        ));
    }
    Ok(())
}

/// Removes the work folder. What stays of it costs space only.
fn remove(workspace: Workspace) {
    if let Err(error) = workspace.remove() {
        tracing::warn!(%error, "the work folder could not be removed");
    }
}

fn unchanged(manifest: &Manifest, store: &Store, bytes: u64, started: Instant) -> Summary {
    let scene = &manifest.scene;
    Summary {
        scene: scene.name.clone(),
        store: store.name().to_owned(),
        unchanged: true,
        points: scene.point_sources.iter().map(|source| source.point_count).sum(),
        footprints: scene.footprints,
        panoramas: scene.panoramas,
        images: scene.images,
        warnings: Warnings::from_lines(&manifest.warnings).counts(),
        warning_messages: manifest.warnings.clone(),
        bytes,
        seconds: started.elapsed().as_secs_f64(),
        points_per_second: 0.0,
        peak_memory_bytes: peak_memory_bytes(),
        layers_reused: Vec::new(),
    }
}

fn made_summary(built: &Built, assembled: &Assembled, store: &Store, started: Instant) -> Summary {
    let (points, seconds) = built.points_made;
    #[expect(clippy::cast_precision_loss, reason = "a rate for people")]
    let points_per_second = if seconds > 0.0 { points as f64 / seconds } else { 0.0 };
    Summary {
        unchanged: false,
        warnings: built.warnings.counts(),
        points_per_second,
        layers_reused: built.reused.clone(),
        ..unchanged(&assembled.manifest, store, assembled.bytes, started)
    }
}

/// Runs `work` where it may block.
async fn blocking<T: Send + 'static>(
    street: &Arc<Street>,
    job: &Arc<Job>,
    work: impl FnOnce(&Street, &Job) -> Result<T, IngestError> + Send + 'static,
) -> Result<T, IngestError> {
    let (street, job) = (Arc::clone(street), Arc::clone(job));
    match tokio::task::spawn_blocking(move || work(&street, &job)).await {
        Ok(outcome) => outcome,
        // A bug, not an input: nobody can go on from it.
        Err(error) => match error.try_into_panic() {
            Ok(panic) => std::panic::resume_unwind(panic),
            Err(_) => Err(IngestError::Cancelled),
        },
    }
}
