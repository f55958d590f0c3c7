//! The work for one receiver: what it looks at goes in, updates come out.

mod driver;
mod motion;
mod statistics;
mod surveyed;
mod understand;

pub(crate) use driver::{Command, Driver};
pub(crate) use statistics::Counts;
pub use statistics::Statistics;
pub(crate) use surveyed::point_at;

use std::sync::Arc;

use flaneur_proto::FieldError;
use flaneur_scene::{IdError, ImageId, ImageUpdate, Panorama, SceneUpdate};
use tokio::sync::mpsc;

use crate::StreamError;
use crate::choose::WantedImage;
use crate::decode::{Picture, decode_picture, decoded};
use crate::load::{Landed, Loader};
use crate::plan::{BatchId, Part};
use crate::survey::Target;
use understand::{Context, Understood, understand};

/// The photograph `id` of `panorama` as it is stored, at its finest level; `None` where the
/// panorama has none of that name.
pub(crate) async fn photograph(
    loader: &Arc<Loader>,
    panorama: &Arc<Panorama>,
    id: &ImageId,
) -> Result<Option<Arc<ImageUpdate>>, StreamError> {
    let Some(image) = WantedImage::finest(panorama, id).map_err(|e| bad_id(&e))? else {
        return Ok(None);
    };
    let mut context =
        Context { scene: Arc::clone(loader.scene()), mask: None, track: None, normals: false };
    if let Some(mask) = &image.rig_camera().mask {
        let key = image.key(0, flaneur_proto::v1::ImageLayer::Mask);
        let part = Part::Mask(mask.name.as_str().into());
        let target = Target::Mask(key, mask.image);
        if let Understood::Mask(mask) = one(loader, part, target, context.clone()).await? {
            context.mask = Some(mask);
        }
    }
    let camera = image.camera as u16;
    let part = Part::Image { panorama: panorama.id.as_str().into(), camera, level: 0 };
    let understood = one(loader, part, Target::Image(image, 0), context).await?;
    let Understood::Shown(updates) = understood else { return Ok(None) };
    Ok(updates.into_iter().find_map(|update| match update {
        SceneUpdate::Image(image) => Some(image),
        _ => None,
    }))
}

/// The picture of a camera of `panorama`, by its index, whole as it is stored at a level; `None` where
/// there is no such camera.
pub(crate) async fn picture(
    loader: &Arc<Loader>,
    panorama: &Arc<Panorama>,
    camera: usize,
    level: u32,
) -> Result<Option<Picture>, StreamError> {
    let Some(image) = WantedImage::of_camera(panorama, camera).map_err(|e| bad_id(&e))? else {
        return Ok(None);
    };
    let (what, size) = (image.name(level), image.rig_camera().projection.level_size(level));
    let part = Part::Image { panorama: panorama.id.as_str().into(), camera: camera as u16, level };
    let decode = move |file: &[u8]| decode_picture(&what, file, size);
    fetched(loader, part, Target::Image(image, level), decode).await.map(Some)
}

/// One part by itself, and what it means.
async fn one(
    loader: &Arc<Loader>,
    part: Part,
    target: Target,
    context: Context,
) -> Result<Understood, StreamError> {
    let of = (part.clone(), target.clone());
    fetched(loader, part, target, move |payload| understand(&of.0, &of.1, payload, &context)).await
}

/// What `decode` makes of the bytes of one part. Where a server fails, or what it sends is not what there
/// is, the next one is asked, as often as there are servers and once more.
async fn fetched<T: Send + 'static>(
    loader: &Arc<Loader>,
    part: Part,
    target: Target,
    decode: impl Fn(&[u8]) -> Result<T, StreamError> + Send + Sync + 'static,
) -> Result<T, StreamError> {
    let (what, decode, mut tries) = (target.name(), Arc::new(decode), 0);
    loop {
        let (sink, mut landed) = mpsc::unbounded_channel();
        let wanted = vec![(part.clone(), target.clone())];
        let _interest = loader.load(BatchId::default(), wanted, 0, sink);
        let Landed { payload, origin, .. } = landed.recv().await.ok_or(StreamError::Cancelled)?;
        let outcome = match payload {
            Ok(payload) => {
                let decode = Arc::clone(&decode);
                let outcome = decoded(&what, move || decode(&payload)).await;
                outcome.inspect_err(|_| loader.reject(&part, origin))
            }
            Err(error) => Err(error),
        };
        match outcome {
            Err(error)
                if error.is_server_at_fault() && tries < loader.client().servers().count() =>
            {
                tries += 1;
            }
            outcome => return outcome,
        }
    }
}

/// What a panorama's name that cannot be one means.
fn bad_id(error: &IdError) -> StreamError {
    StreamError::field("StreamPanoramas")(FieldError::new("id", error.to_string()))
}
