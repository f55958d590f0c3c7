//! What thousands of clients at once do to one server: what it remembers of them, how long a small
//! call waits meanwhile, whom it refuses, and whether it forgets them once they are gone:
//!
//! ```text
//! cargo bench -p flaneur-services --bench load -- STORE SCENE [CLIENTS [CONNECTIONS]]
//! ```
//!
//! The server is a process of its own. Every client first opens a stream of photographs and holds
//! it, so that as many calls are under way as there are clients. Then three fifths of the
//! connections walk: they ask, now and then, for what a few steps need. The rest read slowly, read
//! nothing, or vanish and come back. At last all are gone.

mod clients;
mod server;

use std::sync::Arc;
use std::time::{Duration, Instant};

use flaneur_proto::v1;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tonic::transport::Endpoint;

use clients::{Counts, Group, Target};
use server::ServerProcess;
use v1::scene_service_client::SceneServiceClient;

/// How long clients hold their streams, then walk.
const HOLD: Duration = Duration::from_secs(10);
const WALK: Duration = Duration::from_secs(30);

/// Calls beyond one a client that the server may take: the probe's, and the first of those that are
/// refused.
const SPARE_CALLS: usize = 100;

/// Calls that come while the server has all it may take.
const MORE_CALLS: usize = 500;

/// Pause between two calls of the probe.
const PROBE_PAUSE: Duration = Duration::from_millis(20);

/// How long the server has to forget everybody.
const FORGET: Duration = Duration::from_secs(20);

/// What clients are told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Open a stream and hold it.
    Hold,
    /// Do as your kind does.
    Walk,
    /// Go away.
    Leave,
}

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let (store, scene, clients, connections) = match arguments.as_slice() {
        [serve, store, calls] if serve == server::SERVE => {
            return server::serve(store, calls.parse()?).await;
        }
        [store, scene] => (store, scene, 10_000, 2_000),
        [store, scene, clients] => (store, scene, clients.parse()?, clients.parse::<usize>()? / 5),
        [store, scene, clients, connections] => {
            (store, scene, clients.parse()?, connections.parse()?)
        }
        _ => {
            println!(
                "usage: cargo bench -p flaneur-services --bench load -- STORE SCENE [CLIENTS [CONNECTIONS]]"
            );
            return Ok(());
        }
    };
    let connections: usize = connections.clamp(1, clients);
    let server = ServerProcess::start(store, clients + SPARE_CALLS).await?;
    let target = Arc::new(Target::explore(server.url(), scene).await?);
    println!("{clients} clients on {connections} connections, scene {scene:?} of {store}");
    println!("server before: {} MiB", server.resident_mib());

    let (phases, phase) = watch::channel(Phase::Hold);
    let counts = Arc::new(Counts::default());
    let mut groups = JoinSet::new();
    for number in 0..connections {
        let members = clients / connections + usize::from(number < clients % connections);
        let group = Group::new(number, members, target.clone(), counts.clone(), phase.clone());
        groups.spawn(group.run());
    }
    let started = Instant::now();
    let mut more = (0, started);
    while counts.holding() < clients && more.1.elapsed() < HOLD {
        if counts.holding() > more.0 {
            more = (counts.holding(), Instant::now());
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    let seconds = started.elapsed().as_secs_f64();
    println!("{} hold a stream after {seconds:.1} s; {counts}", counts.holding());

    report("all hold a stream", &server, &counts, HOLD).await?;
    refusals(&server, &target).await?;
    phases.send(Phase::Walk)?;
    report("walk, dawdle, vanish", &server, &counts, WALK).await?;
    phases.send(Phase::Leave)?;
    let left = Instant::now();
    while groups.join_next().await.is_some() {}
    println!("clients gone after {:.1} s; {counts}", left.elapsed().as_secs_f64());
    let gone = Instant::now();
    while server.calls().await? > 0 {
        anyhow::ensure!(gone.elapsed() < FORGET, "{} calls are still there", server.calls().await?);
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    println!("no call left {:.2} s later", gone.elapsed().as_secs_f64());
    report("nobody there", &server, &counts, HOLD).await
}

/// Waits, probes, and prints what was found.
async fn report(
    what: &str,
    server: &ServerProcess,
    counts: &Counts,
    time: Duration,
) -> anyhow::Result<()> {
    let endpoint = Endpoint::new(server.url())?;
    let mut probe = SceneServiceClient::new(endpoint.connect().await?);
    let (started, bytes, calls) = (Instant::now(), counts.bytes(), counts.calls());
    let (mut latencies, mut failures, mut most_mib, mut most_calls) = (Vec::new(), 0, 0, 0);
    let mut looked = Instant::now();
    while started.elapsed() < time {
        let asked = Instant::now();
        match probe.list_scenes(v1::ListScenesRequest {}).await {
            Ok(_) => latencies.push(asked.elapsed()),
            Err(_) => failures += 1,
        }
        if looked.elapsed() > Duration::from_millis(500) {
            looked = Instant::now();
            most_mib = most_mib.max(server.resident_mib());
            most_calls = most_calls.max(server.calls().await?);
        }
        tokio::time::sleep(PROBE_PAUSE).await;
    }
    latencies.sort();
    let quantile = |share: f64| {
        let index = (latencies.len() as f64 * share) as usize;
        latencies
            .get(index.min(latencies.len().saturating_sub(1)))
            .map_or(f64::NAN, |latency| 1e3 * latency.as_secs_f64())
    };
    let seconds = started.elapsed().as_secs_f64();
    println!(
        "{what:<22} {most_calls:>6} calls  {most_mib:>5} MiB (now {})  {:>6.0} calls/s {:>6.1} MiB/s  \
         probe p50 {:.1} p99 {:.1} most {:.1} ms, {} of {} failed",
        server.resident_mib(),
        (counts.calls() - calls) as f64 / seconds,
        (counts.bytes() - bytes) as f64 / seconds / f64::from(1 << 20),
        quantile(0.5),
        quantile(0.99),
        quantile(1.0),
        failures,
        latencies.len() + failures,
    );
    Ok(())
}

/// Opens more streams than the server may take, and counts how it refuses them.
async fn refusals(server: &ServerProcess, target: &Arc<Target>) -> anyhow::Result<()> {
    let endpoint = Endpoint::new(server.url())?;
    let mut channels = Vec::new();
    for _ in 0..10 {
        channels.push(endpoint.connect().await?);
    }
    let (mut taken, mut refused, mut hinted) = (Vec::new(), 0, 0);
    for call in 0..MORE_CALLS {
        let opened = target.photographs(channels[call % channels.len()].clone()).await;
        match opened {
            Ok(stream) => taken.push(stream),
            Err(status) => {
                refused += 1;
                hinted += usize::from(clients::is_hinted(&status));
            }
        }
    }
    println!(
        "of {MORE_CALLS} calls more: {} taken, {refused} refused, {hinted} with a hint when to try again",
        taken.len()
    );
    Ok(())
}
