//! A real S3 server in this process, on a port of its own.

use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto::Builder;
use s3s::auth::SimpleAuth;
use s3s::service::S3ServiceBuilder;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

use crate::store::Store;

const KEY: &str = "test-key";
const SECRET: &str = "test-secret";

/// Serves until it is dropped.
pub(crate) struct S3Server {
    endpoint: String,
    task: JoinHandle<()>,
    _objects: tempfile::TempDir,
}

impl S3Server {
    /// A server with one empty bucket.
    pub(crate) async fn start(bucket: &str) -> Self {
        let objects = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(objects.path().join(bucket)).expect("writable");
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
                    let connection = http.serve_connection(TokioIo::new(socket), service);
                    // A client that hangs up is no concern of the server's.
                    let _ = connection.await;
                });
            }
        });
        Self { endpoint, task, _objects: objects }
    }

    /// What a client must know to use the server.
    pub(crate) fn settings(&self) -> Vec<(String, String)> {
        [
            ("aws_endpoint", self.endpoint.as_str()),
            ("aws_region", "us-east-1"),
            ("aws_access_key_id", KEY),
            ("aws_secret_access_key", SECRET),
            ("aws_allow_http", "true"),
            ("aws_virtual_hosted_style_request", "false"),
            ("aws_conditional_put", "disabled"),
        ]
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .into()
    }

    /// The store at a URL of this server.
    pub(crate) fn store(&self, url: &str) -> Store {
        Store::open_with(url, self.settings()).expect("valid settings")
    }
}

impl Drop for S3Server {
    fn drop(&mut self) {
        self.task.abort();
    }
}
