//! What is rendered, and the picture that the rendering is compared with.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use flaneur_scene::{ImageId, Panorama, PosedCamera};
use flaneur_streamer::Streamer;
use glam::UVec2;

use crate::evaluation::Compared;
use crate::exit::Exit;
use crate::names::{Names, Photograph};
use crate::source::stream_exit;
use crate::viewpoints::{Height, Listed, Size, read_path};

/// Vertical field of view where a file of views gives none, degrees.
const DEFAULT_FOV_DEG: f64 = 60.0;

/// One view.
pub(super) struct Target {
    /// Its name.
    pub(super) id: String,
    /// The camera, with the size of the picture.
    pub(super) camera: PosedCamera,
    truth: Truth,
}

/// Where the picture is.
enum Truth {
    /// In the scene.
    Photograph(ImageId, Arc<Panorama>),
    /// In a file.
    File(PathBuf),
}

impl Target {
    /// The view of a photograph that is held out.
    pub(super) fn held_out(id: &ImageId, photograph: &Photograph) -> Self {
        let truth = Truth::Photograph(id.clone(), Arc::clone(&photograph.panorama));
        Self { id: id.to_string(), camera: photograph.camera, truth }
    }

    /// The picture that a perfect rendering would be.
    pub(super) async fn photograph(&self, streamer: &Streamer) -> Result<Compared, Exit> {
        match &self.truth {
            Truth::Photograph(id, panorama) => fetched(id, panorama, streamer).await,
            Truth::File(path) => tokio::task::block_in_place(|| read(path, self.camera.lens.size)),
        }
    }
}

/// The views of a file, or of the `views.json` of a folder, each with the picture that it names
/// beside the file.
pub(super) fn truth(path: &Path) -> Result<Vec<Target>, Exit> {
    let path = if path.is_dir() { path.join("views.json") } else { path.to_owned() };
    let bad = |index: usize, problem: &str| {
        Exit::bad_input(anyhow::anyhow!("{}: view {}: {problem}", path.display(), index + 1))
    };
    let target = |(index, listed): (usize, Listed)| {
        let file = listed.file.ok_or_else(|| {
            bad(index, "it names no picture to compare with; add \"file\": \"….png\"")
        })?;
        let stays = Path::new(&file).components().all(|part| matches!(part, Component::Normal(_)));
        if !stays || file.is_empty() {
            return Err(bad(index, &format!("its file must be in the same folder: {file:?}")));
        }
        let picture = path.with_file_name(&file);
        let (width, height) = image::image_dimensions(&picture)
            .map_err(|e| bad(index, &format!("cannot read its picture {file:?}: {e}")))?;
        let size = UVec2::new(width, height);
        let view = listed.viewpoint.view(Height::Degrees(DEFAULT_FOV_DEG), None, Size(size));
        if view.size() != size {
            let problem = format!("it is {} pixels, its picture {size}: {file:?}", view.size());
            return Err(bad(index, &problem));
        }
        Ok(Target { id: file, camera: view.camera, truth: Truth::File(picture) })
    };
    read_path(&path)?.into_iter().enumerate().map(target).collect()
}

/// A photograph of the scene as it is stored.
pub(super) async fn stored(
    id: &ImageId,
    names: &Names,
    streamer: &Streamer,
) -> Result<Compared, Exit> {
    let photograph = names.photographs().get(id).ok_or_else(|| gone(id))?;
    fetched(id, &photograph.panorama, streamer).await
}

async fn fetched(
    id: &ImageId,
    panorama: &Arc<Panorama>,
    streamer: &Streamer,
) -> Result<Compared, Exit> {
    let photograph = streamer.photograph(panorama, id).await.map_err(stream_exit)?;
    let photograph = photograph.ok_or_else(|| gone(id))?;
    Ok(tokio::task::block_in_place(|| Compared::from(&*photograph)))
}

fn gone(id: &ImageId) -> Exit {
    Exit::failed(anyhow::anyhow!("photograph {id} is not in the scene any more; run again"))
}

/// The picture in a file, which must still be of `size`.
fn read(path: &Path, size: UVec2) -> Result<Compared, Exit> {
    let bad = |problem: String| {
        Exit::bad_input(anyhow::anyhow!("cannot read a picture: {problem}: {}", path.display()))
    };
    let mut reader = image::ImageReader::open(path).map_err(|e| bad(e.to_string()))?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(size.x), Some(size.y));
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| bad(e.to_string()))?.into_rgb8();
    Ok(Compared::whole(picture))
}
