//! Where scenes are read from: a store, opened in this process, or a server.

use std::time::Duration;

use flaneur_renderer::Applied;
use flaneur_scene::SceneInfo;
use flaneur_services::store::{Catalog, Store, StoreError};
use flaneur_streamer::{Client, Events, StreamError, Streamer};
use tonic::transport::{Channel, Endpoint};
use url::Url;

use crate::exit::Exit;

/// How long a server may take to accept a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);

/// Tells the streamer what a renderer did by itself to make room.
pub(crate) fn note(events: &mut Events<'_>, applied: &Applied) {
    applied.evicted.iter().for_each(|dropped| events.note(dropped));
    applied.coarser.iter().for_each(|(id, level)| events.note_level(id, *level));
}

/// A connection to scenes. A store is reached through the same services as a server, in
/// process, so that nothing downstream can tell them apart.
pub(crate) struct Source {
    text: String,
    channel: Channel,
    scene: Option<String>,
}

impl Source {
    /// Opens `http://host:port[/scene]`, or a store: a folder or a URL such as
    /// `s3://bucket/prefix`, with or without a scene's name at its end.
    pub(crate) async fn open(text: &str) -> Result<Self, Exit> {
        let (channel, scene) = if text.starts_with("http://") || text.starts_with("https://") {
            connect(text).await?
        } else {
            let store = Store::open_existing(text).map_err(store_exit)?;
            let catalog = Catalog::open([store]).await.map_err(store_exit)?;
            (flaneur_services::grpc::in_process(catalog).await?, None)
        };
        Ok(Self { text: text.to_owned(), channel, scene })
    }

    /// The scenes that the source names: one, or all that it holds, by name.
    pub(crate) async fn scenes(&self) -> Result<Vec<SceneInfo>, Exit> {
        let scenes = match &self.scene {
            Some(scene) => {
                vec![self.client_of(scene).scene().await.map_err(stream_exit)?]
            }
            None => Client::list_scenes(self.channel.clone()).await.map_err(stream_exit)?,
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
        Client::new(self.channel.clone(), name)
    }

    /// A streamer of one scene: the one that was named, or the only one.
    pub(crate) async fn streamer(&self) -> Result<Streamer, Exit> {
        let scene = self.scene_name().await?;
        Streamer::connect(self.channel.clone(), &scene).await.map_err(stream_exit)
    }

    async fn scene_name(&self) -> Result<String, Exit> {
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

async fn connect(text: &str) -> Result<(Channel, Option<String>), Exit> {
    let bad = |problem: &str| {
        Exit::bad_input(anyhow::anyhow!("{problem}; a server is http://host:port/scene: {text:?}"))
    };
    let url = Url::parse(text).map_err(|e| bad(&e.to_string()))?;
    if url.scheme() != "http" {
        return Err(bad("https is not spoken here"));
    }
    let authority = match (url.host_str(), url.port()) {
        (Some(host), Some(port)) => format!("http://{host}:{port}"),
        (Some(host), None) => format!("http://{host}"),
        (None, _) => return Err(bad("it names no host")),
    };
    let path = url.path().trim_matches('/');
    if path.contains('/') {
        return Err(bad("a scene's name holds no '/'"));
    }
    let path = percent_decoded(path).ok_or_else(|| bad("its path is not text"))?;
    let endpoint = Endpoint::from_shared(authority).map_err(|e| bad(&e.to_string()))?;
    let channel = endpoint.connect_timeout(CONNECT_TIMEOUT).connect().await.map_err(|error| {
        let what = format!("cannot connect; is the server running? {text:?}");
        Exit::Failed(anyhow::Error::new(error).context(what))
    })?;
    Ok((channel, Some(path).filter(|path| !path.is_empty())))
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
    fn escapes_in_a_url_stand_for_their_characters() {
        assert_eq!(percent_decoded("rue%20d%27Ulm").as_deref(), Some("rue d'Ulm"));
        assert_eq!(percent_decoded("100%").as_deref(), Some("100%"));
        assert_eq!(percent_decoded("%c3%A9t%C3%A9").as_deref(), Some("été"));
        assert_eq!(percent_decoded("%ff"), None);
    }
}
