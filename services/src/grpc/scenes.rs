//! `SceneService`.

use flaneur_proto::v1;
use prost::Message;
use tonic::{Request, Response, Status};

use super::{MAX_MESSAGE_BYTES, Services, status};
use crate::geography;
use crate::store::Scene;

#[tonic::async_trait]
impl v1::scene_service_server::SceneService for Services {
    async fn list_scenes(
        &self,
        _: Request<v1::ListScenesRequest>,
    ) -> Result<Response<v1::ListScenesResponse>, Status> {
        let scenes = self.catalog.scenes().await.map_err(|e| status::of_store(&e))?;
        let scenes = scenes.iter().map(|scene| described(scene)).collect();
        checked(v1::ListScenesResponse { scenes }, "the list of scenes")
    }

    async fn get_scene(
        &self,
        request: Request<v1::GetSceneRequest>,
    ) -> Result<Response<v1::GetSceneResponse>, Status> {
        let scene = self.scene(&request.get_ref().scene).await?;
        let scene = Some(described(&scene));
        checked(v1::GetSceneResponse { scene }, "the scene's description")
    }
}

fn described(scene: &Scene) -> v1::Scene {
    let info = &scene.manifest.scene;
    v1::Scene {
        geographic: geography::frame(info),
        crs_name: geography::crs_name(info),
        ..info.clone().into()
    }
}

fn checked<M: Message>(message: M, what: &str) -> Result<Response<M>, Status> {
    let bytes = message.encoded_len();
    if bytes > MAX_MESSAGE_BYTES {
        return Err(status::too_large(what, bytes, MAX_MESSAGE_BYTES));
    }
    Ok(Response::new(message))
}
