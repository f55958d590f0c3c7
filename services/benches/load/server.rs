//! The server, in a process of its own.

use std::process::Stdio;

use anyhow::Context;
use flaneur_services::grpc::{Limits, Server};
use flaneur_services::store::{Catalog, Store};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;
use tokio::process::{Child, Command};

/// What tells this program to be the server.
pub(crate) const SERVE: &str = "--serve";

/// A running server; it ends with this.
pub(crate) struct ServerProcess {
    child: Child,
    address: String,
}

/// Serves the scenes of a store, and says where.
pub(crate) async fn serve(store: &str, calls: usize) -> anyhow::Result<()> {
    let catalog = Catalog::open([Store::open_existing(store)?]).await?;
    let limits = Limits { calls, ..Limits::default() };
    let server = Server::bind(catalog, ([127, 0, 0, 1], 0).into(), limits).await?;
    println!("{}", server.address());
    Ok(server.serve(std::future::pending()).await?)
}

impl ServerProcess {
    pub(crate) async fn start(store: &str, calls: usize) -> anyhow::Result<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            // As deployed: what is free goes back to the system.
            .env("MALLOC_MMAP_THRESHOLD_", "32768")
            .args([SERVE, store, &calls.to_string()])
            .stdout(Stdio::piped())
            .kill_on_drop(true)
            .spawn()?;
        let output = child.stdout.take().context("the server has no output")?;
        let address = BufReader::new(output).lines().next_line().await?;
        Ok(Self { child, address: address.context("the server said nothing")? })
    }

    pub(crate) fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    /// Memory that it has, MiB; 0 where the system does not say.
    pub(crate) fn resident_mib(&self) -> u64 {
        let status =
            self.child.id().map(|id| std::fs::read_to_string(format!("/proc/{id}/status")));
        let status = status.and_then(Result::ok).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        kib.unwrap_or(0) / 1024
    }

    /// Calls that it counts as under way.
    pub(crate) async fn calls(&self) -> anyhow::Result<u64> {
        let mut socket = TcpStream::connect(&self.address).await?;
        socket.write_all(b"GET /metrics HTTP/1.0\r\n\r\n").await?;
        let mut answer = String::new();
        socket.read_to_string(&mut answer).await?;
        let line = answer.lines().find_map(|l| l.strip_prefix("flaneur_requests_in_flight "));
        Ok(line.context("the metrics say nothing of calls under way")?.parse::<f64>()? as u64)
    }
}
