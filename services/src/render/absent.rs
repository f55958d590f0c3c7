//! The answer of a server that was told not to render.

use flaneur_proto::v1;
use tokio_stream::Pending;
use tonic::{Request, Response, Status, Streaming};

/// The render service of a server that serves data alone: every call is answered UNIMPLEMENTED,
/// with the remedy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NotRendered;

/// A stream that is never begun.
type Never = Pending<Result<v1::Frame, Status>>;

fn refusal() -> Status {
    Status::unimplemented(
        "this server was started with --no-render and serves data alone; ask a server that renders, \
         such as `flaneur serve http://HOST:PORT` with this one's address",
    )
}

#[tonic::async_trait]
impl v1::render_service_server::RenderService for NotRendered {
    async fn render_frame(
        &self,
        _: Request<v1::RenderFrameRequest>,
    ) -> Result<Response<v1::Frame>, Status> {
        Err(refusal())
    }

    type NavigateStream = Never;

    async fn navigate(
        &self,
        _: Request<Streaming<v1::ViewUpdate>>,
    ) -> Result<Response<Never>, Status> {
        Err(refusal())
    }

    type WatchStream = Never;

    async fn watch(&self, _: Request<v1::WatchRequest>) -> Result<Response<Never>, Status> {
        Err(refusal())
    }

    async fn update_view(
        &self,
        _: Request<v1::UpdateViewRequest>,
    ) -> Result<Response<v1::UpdateViewResponse>, Status> {
        Err(refusal())
    }

    async fn pick(
        &self,
        _: Request<v1::PickRequest>,
    ) -> Result<Response<v1::PickResponse>, Status> {
        Err(refusal())
    }
}
