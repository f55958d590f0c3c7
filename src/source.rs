//! Where scenes are read from: a store, opened in this process, or a server.

use std::time::Duration;

use flaneur_renderer::Applied;
use flaneur_scene::SceneInfo;
use flaneur_services::store::{Catalog, Store, StoreError};
use flaneur_streamer::{Client, Events, Servers, StreamError, StreamOptions, Streamer};
use tonic::transport::{Channel, Endpoint};
use url::Url;

use crate::exit::Exit;

/// How long a server may take to accept a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// How often a server that owes an answer is asked whether it lives, and how long it may take to say
/// so: on a slow connection what it sent before comes first.
const ALIVE_INTERVAL: Duration = Duration::from_secs(5);
const ALIVE_TIMEOUT: Duration = Duration::from_secs(20);

/// Tells the streamer what a renderer did by itself to make room.
pub(crate) fn note(events: &mut Events<'_>, applied: &Applied) {
    applied.evicted.iter().for_each(|dropped| events.note(dropped));
    applied.coarser.iter().for_each(|(id, level)| events.note_level(id, *level));
}

/// The same of a streamer that is not followed through its events.
pub(crate) fn tell(streamer: &Streamer, applied: &Applied) {
    applied.evicted.iter().for_each(|dropped| streamer.note(dropped));
    applied.coarser.iter().for_each(|(id, level)| streamer.note_level(id, *level));
}

/// Where a server listens, and the scene that is meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ServerAddress {
    /// `host:port`.
    pub(crate) authority: String,
    pub(crate) scene: Option<String>,
}

/// A connection to scenes. A store is reached through the same services as a server, in
/// process, so that nothing downstream can tell them apart.
pub(crate) struct Source {
    text: String,
    servers: Servers,
    scene: Option<String>,
}

impl Source {
    /// Opens `http://host:port[/scene]`, several of those with commas between them, or a store: a
    /// folder or a URL such as `s3://bucket/prefix`, with or without a scene's name at its end.
    pub(crate) async fn open(text: &str) -> Result<Self, Exit> {
        let (servers, scene) = if is_server(text) {
            replicas(text).await?
        } else {
            let catalog = open_store(text).await?;
            (flaneur_services::grpc::in_process(catalog).await?.into(), None)
        };
        Ok(Self { text: text.to_owned(), servers, scene })
    }

    /// Connects to the server at `authority`, `host:port`, for its scene `scene`.
    pub(crate) async fn of_scene(authority: &str, scene: &str) -> Result<Self, Exit> {
        let scene = Some(scene.to_owned());
        let address = ServerAddress { authority: authority.to_owned(), scene };
        let servers = address.connect(authority).await?.into();
        Ok(Self { text: authority.to_owned(), servers, scene: address.scene })
    }

    /// The scenes that the source names: one, or all that it holds, by name.
    pub(crate) async fn scenes(&self) -> Result<Vec<SceneInfo>, Exit> {
        let scenes = match &self.scene {
            Some(scene) => {
                vec![self.client_of(scene).scene().await.map_err(stream_exit)?]
            }
            None => Client::list_scenes(self.servers.clone()).await.map_err(stream_exit)?,
        };
        if scenes.is_empty() {
            return Err(Exit::bad_input(anyhow::anyhow!(
                "no scene is published here; make one with `flaneur ingest STREET --out STORE`: {:?}",
                self.text
            )));
        }
        Ok(scenes)
    }

    /// A client of the scene `name`.
    pub(crate) fn client_of(&self, name: &str) -> Client {
        Client::new(self.servers.clone(), name)
    }

    /// A streamer of one scene: the one that was named, or the only one.
    pub(crate) async fn streamer(&self) -> Result<Streamer, Exit> {
        self.streamer_with(StreamOptions::default()).await
    }

    /// The same with other than the default options.
    pub(crate) async fn streamer_with(&self, options: StreamOptions) -> Result<Streamer, Exit> {
        let scene = self.scene_name().await?;
        Streamer::connect_with(self.servers.clone(), &scene, options).await.map_err(stream_exit)
    }

    /// The name of the scene that was named, or of the only one.
    pub(crate) async fn scene_name(&self) -> Result<String, Exit> {
        if let Some(scene) = &self.scene {
            return Ok(scene.clone());
        }
        let mut scenes = self.scenes().await?;
        match (scenes.pop(), scenes.is_empty()) {
            (Some(scene), true) => Ok(scene.name),
            (last, _) => {
                let names: Vec<_> = scenes.into_iter().chain(last).map(|s| s.name).collect();
                Err(Exit::bad_input(anyhow::anyhow!(
                    "it holds {} scenes, add the name of one to it ({}): {:?}",
                    names.len(),
                    names.join(", "),
                    self.text
                )))
            }
        }
    }
}

/// Servers that hold the same, and the scene that the first of them is asked for. Those that do not
/// answer now are asked again when others fail; one must answer.
async fn replicas(text: &str) -> Result<(Servers, Option<String>), Exit> {
    let (mut channels, mut scene, mut failure) = (Vec::new(), None, None);
    let mut waiting = Vec::new();
    for (index, one) in text.split(',').enumerate() {
        let address = ServerAddress::parse(one)?;
        if index == 0 {
            scene.clone_from(&address.scene);
        } else if address.scene != scene {
            let problem = "all servers must be asked for the same scene";
            return Err(ServerAddress::bad(problem, text));
        }
        match address.connect(one).await {
            Ok(channel) => channels.push(channel),
            Err(error) => {
                waiting.push(address.endpoint(one)?.connect_lazy());
                failure = Some(error);
            }
        }
    }
    match failure {
        Some(error) if channels.is_empty() => return Err(error),
        Some(_) => tracing::warn!("of the servers {} do not answer: {text:?}", waiting.len()),
        None => {}
    }
    channels.append(&mut waiting);
    Ok((channels.into(), scene))
}

/// Servers whose scenes, all of them, are meant: `http://host:port`, several with commas between
/// them.
pub(crate) async fn servers(text: &str) -> Result<Servers, Exit> {
    match replicas(text).await? {
        (servers, None) => Ok(servers),
        (_, Some(_)) => Err(ServerAddress::bad("leave the scene's name out: all are meant", text)),
    }
}

/// Whether a source is a server rather than a store.
pub(crate) fn is_server(text: &str) -> bool {
    text.starts_with("http://") || text.starts_with("https://")
}

/// The scenes of a store: a folder or a URL.
pub(crate) async fn open_store(text: &str) -> Result<Catalog, Exit> {
    let store = Store::open_existing(text).map_err(store_exit)?;
    Catalog::open([store]).await.map_err(store_exit)
}

/// What a failure of the services means for the command.
pub(crate) fn stream_exit(error: StreamError) -> Exit {
    match error {
        StreamError::Cancelled => Exit::Interrupted,
        error if error.is_bad_request() => Exit::bad_input(error),
        error => Exit::failed(error),
    }
}

fn store_exit(error: StoreError) -> Exit {
    match error {
        StoreError::BadUrl { .. }
        | StoreError::NoFolder { .. }
        | StoreError::BadSceneName { .. }
        | StoreError::NoScene { .. }
        | StoreError::SceneTwice { .. }
        | StoreError::BadManifest { .. } => Exit::bad_input(error),
        error => Exit::failed(error),
    }
}

impl ServerAddress {
    /// Reads `http://host:port/scene`.
    pub(crate) fn parse(text: &str) -> Result<Self, Exit> {
        let bad = |problem: &str| Self::bad(problem, text);
        let url = Url::parse(text).map_err(|e| bad(&e.to_string()))?;
        if url.scheme() != "http" {
            return Err(bad("https is not spoken here"));
        }
        let host = url.host_str().ok_or_else(|| bad("it names no host"))?;
        let authority = format!("{host}:{}", url.port().unwrap_or(80));
        let path = url.path().trim_matches('/');
        if path.contains('/') {
            return Err(bad("a scene's name holds no '/'"));
        }
        let path = percent_decoded(path).ok_or_else(|| bad("its path is not text"))?;
        Ok(Self { authority, scene: Some(path).filter(|path| !path.is_empty()) })
    }

    /// Connects; `text` is what the person gave.
    async fn connect(&self, text: &str) -> Result<Channel, Exit> {
        self.endpoint(text)?.connect().await.map_err(|error| {
            let what = format!("cannot connect; is the server running? {text:?}");
            Exit::Failed(anyhow::Error::new(error).context(what))
        })
    }

    fn endpoint(&self, text: &str) -> Result<Endpoint, Exit> {
        let endpoint = Endpoint::from_shared(format!("http://{}", self.authority));
        let endpoint = endpoint.map_err(|e| Self::bad(&e.to_string(), text))?;
        Ok(endpoint
            .connect_timeout(CONNECT_TIMEOUT)
            .http2_keep_alive_interval(ALIVE_INTERVAL)
            .keep_alive_timeout(ALIVE_TIMEOUT))
    }

    fn bad(problem: &str, text: &str) -> Exit {
        Exit::bad_input(anyhow::anyhow!("{problem}; a server is http://host:port/scene: {text:?}"))
    }
}

/// The text that a URL's path stands for, `None` where it is no UTF-8.
fn percent_decoded(path: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped = (*first == b'%').then(|| tail.get(..2)).flatten();
        let escaped = escaped.and_then(|hex| std::str::from_utf8(hex).ok());
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_is_named_by_a_url() {
        let parse = |text: &str| ServerAddress::parse(text).map(|a| (a.authority, a.scene));
        let good = |text: &str| parse(text).expect("good");
        assert_eq!(good("http://h:7878/a%20b/"), ("h:7878".to_owned(), Some("a b".to_owned())));
        assert_eq!(good("http://[::1]"), ("[::1]:80".to_owned(), None));
        for wrong in ["http://", "https://h/a", "http://h/a/b", "http://h/%ff"] {
            assert!(matches!(parse(wrong), Err(Exit::BadInput(_))), "{wrong}");
        }
    }

    #[tokio::test]
    async fn replicas_hold_the_same_scene() {
        let different = replicas("http://127.0.0.1:1/a,http://127.0.0.1:2/b").await;
        let Err(Exit::BadInput(error)) = different else { panic!("two scenes") };
        assert!(error.to_string().contains("same scene"), "{error}");
        let dead = replicas("http://127.0.0.1:1/a,http://127.0.0.1:1/a").await;
        assert!(matches!(dead, Err(Exit::Failed(_))), "nobody answers");
    }

    #[test]
    fn escapes_in_a_url_stand_for_their_characters() {
        assert_eq!(percent_decoded("rue%20d%27Ulm").as_deref(), Some("rue d'Ulm"));
        assert_eq!(percent_decoded("100%").as_deref(), Some("100%"));
        assert_eq!(percent_decoded("%c3%A9t%C3%A9").as_deref(), Some("été"));
        assert_eq!(percent_decoded("%ff"), None);
    }
}
