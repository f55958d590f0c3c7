//! An object store that speaks S3, in this process and on a port of its own.

use std::ffi::OsStr;
use std::process::Command;

use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto::Builder;
use s3s::auth::SimpleAuth;
use s3s::service::S3ServiceBuilder;
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

const KEY: &str = "flaneur";
const SECRET: &str = "flaneur-secret";
const BUCKET: &str = "streets";

/// A store with one empty bucket. It ends with the value.
pub(crate) struct ObjectStore {
    endpoint: String,
    task: JoinHandle<()>,
    _objects: TempDir,
}

impl ObjectStore {
    pub(crate) async fn start() -> Self {
        let objects = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(objects.path().join(BUCKET)).expect("writable");
        let files = s3s_fs::FileSystem::new(objects.path()).expect("a folder");
        let mut builder = S3ServiceBuilder::new(files);
        builder.set_auth(SimpleAuth::from_single(KEY, SECRET));
        let service = builder.build();
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a free port");
        let endpoint = format!("http://{}", listener.local_addr().expect("bound"));
        let task = tokio::spawn(async move {
            while let Ok((socket, _)) = listener.accept().await {
                let service = service.clone();
                tokio::spawn(async move {
                    let http = Builder::new(TokioExecutor::new());
                    // A client that hangs up is no concern of the server's.
                    drop(http.serve_connection(TokioIo::new(socket), service).await);
                });
            }
        });
        Self { endpoint, task, _objects: objects }
    }

    /// Its bucket.
    pub(crate) fn url(&self) -> String {
        format!("s3://{BUCKET}")
    }

    /// The same command, told what compose.yaml tells its services of the store.
    pub(crate) fn told<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        command.envs(
            [
                ("AWS_ENDPOINT", self.endpoint.as_str()),
                ("AWS_ALLOW_HTTP", "true"),
                ("AWS_REGION", "us-east-1"),
                ("AWS_ACCESS_KEY_ID", KEY),
                ("AWS_SECRET_ACCESS_KEY", SECRET),
            ]
            .map(|(name, value)| (OsStr::new(name), OsStr::new(value))),
        )
    }
}

impl Drop for ObjectStore {
    fn drop(&mut self) {
        self.task.abort();
    }
}
