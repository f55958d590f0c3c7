//! Everything that is answered on the port.

use std::time::Duration;

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::middleware;
use axum::routing::get;
use flaneur_proto::v1;
use tonic::server::NamedService;
use tonic::service::Routes;
use tonic_health::ServingStatus;
use tonic_health::server::HealthReporter;
use tonic_web::GrpcWebLayer;

use v1::footprint_service_server::FootprintServiceServer;
use v1::ground_service_server::GroundServiceServer;
use v1::panorama_service_server::PanoramaServiceServer;
use v1::point_service_server::PointServiceServer;
use v1::render_service_server::RenderServiceServer;
use v1::scene_service_server::SceneServiceServer;

use super::Services;
use super::call::{self, Calls};
use super::metrics::Metrics;
use super::not_found;
use super::origins::Origin;
use super::server::ServeError;
use crate::page;
use crate::render::{NotRendered, Rendering};
use crate::store::Catalog;

/// How much a server takes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Calls in flight, over all connections; more are refused with RESOURCE_EXHAUSTED. One whose
    /// client takes nothing holds a quarter of a MiB.
    pub calls: usize,
    /// Calls in flight on one connection; more wait.
    pub calls_per_connection: u32,
    /// Connections; more are closed at once.
    pub connections: usize,
    /// How long a client may take nothing of an answer that has more to give; then its connection
    /// is closed.
    pub patience: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            calls: 4096,
            calls_per_connection: 256,
            connections: 10_000,
            patience: Duration::from_secs(120),
        }
    }
}

/// What a server answers.
#[derive(Clone, Default)]
pub struct Offer {
    /// The scenes of its data services; none: it has no data services.
    pub data: Option<Catalog>,
    /// What renders; none: it has no render service.
    pub rendering: Option<Rendering>,
    /// Whose pages may call, beside its own.
    pub origins: Vec<Origin>,
}

impl From<Catalog> for Offer {
    /// The data services alone.
    fn from(catalog: Catalog) -> Self {
        Self { data: Some(catalog), ..Self::default() }
    }
}

/// The services, and what is said about them.
pub(super) struct Answers {
    pub(super) routes: Routes,
    pub(super) metrics: Metrics,
    health: HealthReporter,
    rendering: Option<Rendering>,
    /// Names of the services, as health checks know them; the empty one is the server.
    names: Vec<&'static str>,
}

/// Names of the data services.
const DATA: [&str; 5] = [
    SceneServiceServer::<Services>::NAME,
    FootprintServiceServer::<Services>::NAME,
    GroundServiceServer::<Services>::NAME,
    PanoramaServiceServer::<Services>::NAME,
    PointServiceServer::<Services>::NAME,
];

/// What `/` says to a person who comes with a browser.
const GREETING: &str = "\
Flaneur serves surveyed streets here, over gRPC and gRPC-Web (package flaneur.v1).

  List the services:  grpcurl -plaintext HOST:PORT list
  List the scenes:    grpcurl -plaintext HOST:PORT flaneur.v1.SceneService/ListScenes
  Metrics:            /metrics
  Health:             /healthz, and grpc.health.v1.Health
";

/// And where there are no pictures.
const DATA_ALONE: &str = "
It serves data alone. Pictures and the web page come from a server that renders, such as
flaneur serve http://HOST:PORT with this one's address.
";

impl Answers {
    /// What is on offer, with health, reflection and metrics; and the page, where pictures are.
    pub(super) async fn new(offer: Offer, limits: &Limits) -> Result<Self, ServeError> {
        let metrics = Metrics::new().map_err(|e| ServeError::SetUp(e.to_string()))?;
        let reflection = || {
            tonic_reflection::server::Builder::configure()
                .register_encoded_file_descriptor_set(flaneur_proto::FILE_DESCRIPTOR_SET)
                .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
        };
        let failed = |e: tonic_reflection::server::Error| ServeError::SetUp(e.to_string());
        let (health, health_service) = tonic_health::server::health_reporter();
        let mut grpc = Routes::new(health_service)
            .add_service(reflection().build_v1().map_err(failed)?)
            .add_service(reflection().build_v1alpha().map_err(failed)?);
        let mut names = vec![""];
        if let Some(catalog) = offer.data {
            let services = Services::new(catalog);
            grpc = grpc
                .add_service(SceneServiceServer::new(services.clone()))
                .add_service(FootprintServiceServer::new(services.clone()))
                .add_service(GroundServiceServer::new(services.clone()))
                .add_service(PanoramaServiceServer::new(services.clone()))
                .add_service(PointServiceServer::new(services));
            names.extend(DATA);
        }
        let rendering = offer.rendering;
        let more = rendering.as_ref().map_or(DATA_ALONE, |_| "");
        let has_page = rendering.is_some() && page::is_there();
        if let Some(rendering) = rendering.clone() {
            grpc = grpc.add_service(RenderServiceServer::new(rendering));
            names.push(RenderServiceServer::<Rendering>::NAME);
        } else {
            grpc = grpc.add_service(RenderServiceServer::new(NotRendered));
        }
        let calls = Calls::new(metrics.clone(), limits);
        let router = grpc
            .into_axum_router()
            .layer(middleware::from_fn_with_state(calls, call::around))
            // Refuses HTTP/1 that is not gRPC-Web, so the pages stay outside of it.
            .layer(GrpcWebLayer::new())
            .layer(middleware::from_fn(not_found::around))
            .merge(pages(&metrics, has_page, more));
        let routes = Routes::from(router).prepare();
        let answers = Self { routes, metrics, health, rendering, names };
        answers.set_health(ServingStatus::Serving).await;
        Ok(answers)
    }

    /// New calls are not welcome, and those end that would go on for ever.
    pub(super) async fn stop(&self) {
        self.set_health(ServingStatus::NotServing).await;
        if let Some(rendering) = &self.rendering {
            rendering.stop();
        }
    }

    /// Tells health checks whether new calls are welcome.
    async fn set_health(&self, status: ServingStatus) {
        for &name in &self.names {
            self.health.set_service_status(name, status).await;
        }
    }
}

/// The pages that are plain HTTP. Where there is none for people `/` says what to call, and `more`.
fn pages(metrics: &Metrics, has_page: bool, more: &'static str) -> Router {
    let metrics = metrics.clone();
    let plain = Router::new().route("/healthz", get(async || "ok\n")).route(
        "/metrics",
        get(async move || ([(CONTENT_TYPE, "text/plain; version=0.0.4")], metrics.render())),
    );
    if has_page {
        plain.merge(page::routes())
    } else {
        plain.route("/", get(async move || [GREETING, more].concat()))
    }
}
