//! nginx, configured by `deploy/nginx.conf`.

use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

const CONFIGURATION: &str = include_str!("../../deploy/nginx.conf");

/// A gateway on free ports. It ends with the value.
pub(crate) struct Gateway {
    process: Child,
    _folder: TempDir,
    /// Where the page and gRPC-Web are.
    pub(crate) web: String,
    /// Where gRPC is.
    pub(crate) grpc: String,
}

impl Gateway {
    /// Before a data server and two render replicas, given as `http://host:port`; ready when it returns.
    pub(crate) fn start(data: &str, render: [&str; 2]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let [web, grpc] = free_ports().map(|port| format!("127.0.0.1:{port}"));
        let authority = |url: &str| url.trim_start_matches("http://").to_owned();
        let configuration = with(
            CONFIGURATION,
            &[
                ("/tmp/", format!("{}/", folder.path().display())),
                ("data:7878 resolve", authority(data)),
                ("render-1:7878 resolve", authority(render[0])),
                ("render-2:7878 resolve", authority(render[1])),
                ("listen 8080;", format!("listen {web};")),
                ("listen 8081 http2;", format!("listen {grpc} http2;")),
            ],
        );
        let file = folder.path().join("nginx.conf");
        std::fs::write(&file, configuration).expect("writable");
        let process = Command::new(nginx())
            .args(["-g", "daemon off;", "-p"])
            .arg(folder.path())
            .arg("-c")
            .arg(&file)
            .stdin(Stdio::null())
            .spawn()
            .expect("nginx starts: run `make test`, which installs it");
        let [web, grpc] = [web, grpc].map(|address| {
            await_listener(&address);
            format!("http://{address}")
        });
        Self { process, _folder: folder, web, grpc }
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        // Its workers end with it only where it is asked, not where it is killed.
        let told = Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status();
        if told.is_ok_and(|status| status.success()) {
            drop(self.process.wait());
        }
    }
}

/// Debian puts it where only the administrator's shell looks.
fn nginx() -> &'static str {
    if Path::new("/usr/sbin/nginx").exists() { "/usr/sbin/nginx" } else { "nginx" }
}

/// The text with every `from` replaced; each must be there.
fn with(text: &str, replacements: &[(&str, String)]) -> String {
    replacements.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "deploy/nginx.conf says {from:?}");
        text.replace(from, to)
    })
}

fn free_ports() -> [u16; 2] {
    let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").expect("a free port"));
    listeners.map(|listener| listener.local_addr().expect("bound").port())
}

fn await_listener(address: &str) {
    let until = Instant::now() + Duration::from_secs(20);
    while std::net::TcpStream::connect(address).is_err() {
        assert!(Instant::now() < until, "nginx does not listen at {address}");
        std::thread::sleep(Duration::from_millis(20));
    }
}
