//! A scene with one photograph, of which the service sends what a test wants.

#![allow(dead_code, reason = "each test file is a crate and uses its share")]

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::task::{Context, Poll};
use std::time::Duration;

use flaneur_proto::v1;
use flaneur_proto::v1::panorama_service_server::{PanoramaService, PanoramaServiceServer};
use flaneur_proto::v1::scene_service_server::{SceneService, SceneServiceServer};
use flaneur_scene::{
    Bounds3, CUBE_FACES, Intrinsics, Lens, Panorama, Projection, RigCamera, SceneInfo, StoredImage,
};
use futures::Stream;
use glam::{DMat3, DVec3, UVec2};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, split};
use tokio_util::sync::CancellationToken;
use tonic::transport::{Channel, Endpoint, Server};
use tonic::{Request, Response, Status};

/// What is sent for an image: its parts, or a refusal.
pub(crate) type Answer = Result<Vec<v1::ImagePart>, Status>;
pub(crate) type Parts = Arc<dyn Fn(v1::ImageKey) -> Answer + Send + Sync>;

/// What is to be sent.
#[derive(Clone)]
pub(crate) struct Liar {
    /// East coordinate of the panorama.
    pub(crate) panorama_x: f64,
    /// East end of the scene's bounds.
    pub(crate) scene_max_x: f64,
    /// How many answers about a region still break off behind what they say.
    pub(crate) broken_regions: Arc<AtomicUsize>,
    /// The answer for an image, `None` for silence.
    pub(crate) parts: Option<Parts>,
    /// What it says of an image before it is asked for it.
    pub(crate) announced: StoredImage,
    pub(crate) watch: Watch,
}

/// Sees when a silent answer begins, and when it is dropped.
#[derive(Clone, Default)]
pub(crate) struct Watch {
    begun: CancellationToken,
    ended: CancellationToken,
}

impl Watch {
    pub(crate) async fn begun(&self) {
        self.begun.cancelled().await;
    }

    pub(crate) async fn ended(&self) {
        self.ended.cancelled().await;
    }
}

impl Liar {
    /// Sends a sound picture.
    pub(crate) fn honest() -> Self {
        let picture = jpeg(16, 16);
        Self::images(move |key| vec![part(key, picture.len() as u64, 0, &picture)])
    }

    /// Answers for an image with `parts`.
    pub(crate) fn images(
        parts: impl Fn(v1::ImageKey) -> Vec<v1::ImagePart> + Send + Sync + 'static,
    ) -> Self {
        let sent = parts(v1::ImageKey::default());
        let data: Vec<u8> = sent.iter().flat_map(|part| part.data.to_vec()).collect();
        let total = sent.first().map_or(1, |part| part.total_bytes);
        Self {
            panorama_x: 0.0,
            scene_max_x: 100.0,
            broken_regions: Arc::default(),
            announced: StoredImage { bytes: total.min(1 << 20), crc32: crc32fast::hash(&data) },
            parts: Some(Arc::new(move |key| Ok(parts(key)))),
            watch: Watch::default(),
        }
    }

    /// Never answers for an image.
    pub(crate) fn silent() -> (Self, Watch) {
        let liar = Self { parts: None, ..Self::honest() };
        let watch = liar.watch.clone();
        (liar, watch)
    }
}

pub(crate) fn part(key: v1::ImageKey, total_bytes: u64, offset: u64, data: &[u8]) -> v1::ImagePart {
    v1::ImagePart {
        image: Some(key),
        media_type: "image/jpeg".into(),
        total_bytes,
        offset,
        data: data.to_vec().into(),
    }
}

/// A grey picture.
pub(crate) fn jpeg(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = image::RgbImage::from_pixel(width, height, image::Rgb([90; 3]));
    picture.write_to(&mut bytes, image::ImageFormat::Jpeg).expect("memory");
    bytes.into_inner()
}

/// A channel to `liar`, over a pipe.
pub(crate) async fn connect(liar: Liar) -> Channel {
    let (ours, theirs) = tokio::io::duplex(1 << 20);
    serve(liar, theirs);
    channel(ours).await
}

/// A channel to `liar` that carries so many bytes a second to the client.
pub(crate) async fn connect_slowly(liar: Liar, bytes_per_s: usize) -> Channel {
    let (ours, near) = tokio::io::duplex(1 << 20);
    let (far, theirs) = tokio::io::duplex(1 << 20);
    let ((mut from_us, mut to_us), (mut from_them, mut to_them)) = (split(near), split(far));
    tokio::spawn(async move { tokio::io::copy(&mut from_us, &mut to_them).await });
    tokio::spawn(async move {
        let mut bytes = vec![0; bytes_per_s / 10];
        while let Ok(count @ 1..) = from_them.read(&mut bytes).await {
            tokio::time::sleep(Duration::from_millis(100)).await;
            to_us.write_all(&bytes[..count]).await.expect("a pipe");
        }
    });
    serve(liar, theirs);
    channel(ours).await
}

fn serve(liar: Liar, pipe: DuplexStream) {
    let server = Server::builder()
        .add_service(SceneServiceServer::new(liar.clone()))
        .add_service(PanoramaServiceServer::new(liar))
        .serve_with_incoming(futures::stream::once(async { Ok::<_, std::io::Error>(pipe) }));
    tokio::spawn(server);
}

async fn channel(pipe: DuplexStream) -> Channel {
    let mut pipe = Some(pipe);
    let connector = tower::service_fn(move |_| {
        let pipe = pipe.take().map(TokioIo::new);
        async move { pipe.ok_or(std::io::Error::other("only one connection")) }
    });
    let endpoint = Endpoint::from_static("http://liar");
    endpoint.connect_with_connector(connector).await.expect("a pipe")
}

#[tonic::async_trait]
impl SceneService for Liar {
    async fn list_scenes(
        &self,
        _: Request<v1::ListScenesRequest>,
    ) -> Result<Response<v1::ListScenesResponse>, Status> {
        Err(Status::unimplemented("nobody asks"))
    }

    async fn get_scene(
        &self,
        request: Request<v1::GetSceneRequest>,
    ) -> Result<Response<v1::GetSceneResponse>, Status> {
        let info = SceneInfo {
            name: request.into_inner().scene,
            crs: "local".into(),
            geographic_origin: None,
            origin: DVec3::ZERO,
            bounds: Bounds3 { min: DVec3::splat(-100.0), max: DVec3::splat(100.0) },
            footprints: 0,
            panoramas: 1,
            images: 1,
            ground: None,
            point_sources: Vec::new(),
            version: "1".into(),
        };
        let mut scene = v1::Scene::from(info);
        if let Some(max) = scene.bounds.as_mut().and_then(|bounds| bounds.max.as_mut()) {
            max.x = self.scene_max_x;
        }
        Ok(Response::new(v1::GetSceneResponse { scene: Some(scene) }))
    }
}

#[tonic::async_trait]
impl PanoramaService for Liar {
    type StreamPanoramasStream =
        Pin<Box<dyn Stream<Item = Result<v1::Panorama, Status>> + Send + 'static>>;
    type StreamImagesStream =
        Pin<Box<dyn Stream<Item = Result<v1::ImagePart, Status>> + Send + 'static>>;

    async fn stream_panoramas(
        &self,
        _: Request<v1::StreamPanoramasRequest>,
    ) -> Result<Response<Self::StreamPanoramasStream>, Status> {
        let size = UVec2::splat(16);
        let camera = RigCamera {
            id: "c".into(),
            position_in_rig: DVec3::ZERO,
            cam_from_rig: CUBE_FACES[0].cam_from_rig(),
            projection: Projection::Pinhole(Lens::pinhole(size, Intrinsics::from_fov_y(1.0, size))),
            levels: vec![self.announced],
            mask: None,
            version: "1".into(),
        };
        let mut panorama = v1::Panorama::from(Panorama {
            id: "p".into(),
            position: DVec3::ZERO,
            world_from_rig: DMat3::IDENTITY,
            time: None,
            uncertainty_m: 0.0,
            cameras: vec![camera],
        });
        if let Some(position) = &mut panorama.position {
            position.x = self.panorama_x;
        }
        let broken = &self.broken_regions;
        let breaks = broken.try_update(Relaxed, Relaxed, |left| left.checked_sub(1)).is_ok();
        let end = breaks.then(|| Err(Status::unavailable("it breaks off")));
        let sent = std::iter::once(Ok(panorama)).chain(end);
        Ok(Response::new(Box::pin(futures::stream::iter(sent))))
    }

    async fn stream_images(
        &self,
        request: Request<v1::StreamImagesRequest>,
    ) -> Result<Response<Self::StreamImagesStream>, Status> {
        let Some(parts) = &self.parts else {
            self.watch.begun.cancel();
            return Ok(Response::new(Box::pin(Silence(self.watch.ended.clone()))));
        };
        let images = request.into_inner().images.into_iter();

        let sent: Vec<Result<_, Status>> = images
            .flat_map(|key| match parts(key) {
                Ok(parts) => parts.into_iter().map(Ok).collect(),
                Err(refusal) => vec![Err(refusal)],
            })
            .collect();
        Ok(Response::new(Box::pin(futures::stream::iter(sent))))
    }
}

/// A stream that never yields, and says when it is dropped.
struct Silence(CancellationToken);

impl Stream for Silence {
    type Item = Result<v1::ImagePart, Status>;

    fn poll_next(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        Poll::Pending
    }
}

impl Drop for Silence {
    fn drop(&mut self) {
        self.0.cancel();
    }
}
