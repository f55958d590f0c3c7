//! How fast point chunks come over gRPC, beside a plain HTTP download of the same file, both over
//! loopback, in turns, in one run:
//!
//! ```text
//! cargo bench -p flaneur-services --bench chunks -- STORE SCENE
//! ```
//!
//! The bytes that come are compared with those of the store before anything is timed.

use std::collections::HashMap;
use std::net::SocketAddr;
use std::time::Instant;

use axum::Router;
use axum::body::Body;
use axum::routing::get;
use bytes::Bytes;
use flaneur_proto::v1;
use flaneur_proto::v1::point_service_client::PointServiceClient;
use flaneur_services::grpc::{Limits, Server};
use flaneur_services::store::{Catalog, Scene, Store};
use object_store::ObjectStoreExt;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tonic::transport::{Channel, Endpoint};

/// Rounds of each method; the best of them counts, the others show the spread.
const ROUNDS: usize = 5;

/// Nodes of a request.
const REQUEST_NODES: usize = 256;

/// Bytes by which a chunk is recognised.
const HEAD_BYTES: usize = 36;

/// What a streaming client would set, see [`Server`].
const WINDOW_BYTES: u32 = 8 << 20;

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let [store, scene] = arguments.as_slice() else {
        println!("usage: cargo bench -p flaneur-services --bench chunks -- STORE SCENE");
        return Ok(());
    };
    let catalog = Catalog::open([Store::open_existing(store)?]).await?;
    let scene = catalog.scene(scene).await?;
    let layer = scene.manifest.points.first().ok_or_else(|| anyhow::anyhow!("no points"))?;
    let server = Server::bind(catalog, ([127, 0, 0, 1], 0).into(), Limits::default()).await?;
    let endpoint = Endpoint::new(format!("http://{}", server.address()))?
        .initial_stream_window_size(WINDOW_BYTES)
        .initial_connection_window_size(4 * WINDOW_BYTES);
    tokio::spawn(server.serve(std::future::pending()));
    let mut client = PointServiceClient::new(endpoint.connect().await?);
    let plain = plain_server(&scene, &layer.file.path).await?;

    let nodes = nodes(&mut client, &scene, &layer.source).await?;
    check(&mut client, &scene, &layer.source, &layer.file.path, &nodes).await?;

    let (mut over_grpc, mut over_http) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let started = Instant::now();
        let bytes = stream_chunks(&mut client, &scene, &layer.source, &nodes, |_| ()).await?;
        over_grpc.push(rate(bytes, started));
        let started = Instant::now();
        let bytes = download(plain).await?;
        over_http.push(rate(bytes, started));
    }
    println!("method                     MiB/s best   worst   inputs");
    let inputs = format!("{} nodes, {} bytes of LAZ, loopback", nodes.len(), layer.file.bytes);
    for (method, mut rates) in
        [("StreamChunks over gRPC", over_grpc), ("plain HTTP download", over_http)]
    {
        rates.sort_by(f64::total_cmp);
        println!("{method:<25} {:>11.0} {:>7.0}   {inputs}", rates[ROUNDS - 1], rates[0]);
    }
    Ok(())
}

fn rate(bytes: u64, started: Instant) -> f64 {
    bytes as f64 / f64::from(1 << 20) / started.elapsed().as_secs_f64()
}

async fn nodes(
    client: &mut PointServiceClient<Channel>,
    scene: &Scene,
    source: &str,
) -> anyhow::Result<Vec<v1::NodeKey>> {
    let (scene, source) = (scene.folder.name().to_owned(), source.to_owned());
    let request = v1::GetHierarchyRequest { scene, source, page: None };
    let mut pages = client.get_hierarchy(request).await?.into_inner();
    let mut nodes = Vec::new();
    while let Some(page) = pages.message().await? {
        let with_points = page.entries.iter().filter(|entry| entry.point_count > 0);
        nodes.extend(with_points.filter_map(|entry| entry.key));
    }
    Ok(nodes)
}

/// Streams all nodes, request by request; gives the bytes that came.
async fn stream_chunks(
    client: &mut PointServiceClient<Channel>,
    scene: &Scene,
    source: &str,
    nodes: &[v1::NodeKey],
    mut see: impl FnMut(v1::PointChunk),
) -> anyhow::Result<u64> {
    let mut bytes = 0;
    for nodes in nodes.chunks(REQUEST_NODES) {
        let request = v1::StreamChunksRequest {
            scene: scene.folder.name().to_owned(),
            source: source.to_owned(),
            nodes: nodes.to_vec(),
        };
        let mut chunks = client.stream_chunks(request).await?.into_inner();
        while let Some(chunk) = chunks.message().await? {
            bytes += chunk.data.len() as u64;
            see(chunk);
        }
    }
    Ok(bytes)
}

/// The chunks that come, in the order of their place, must be the file's points byte for byte:
/// the nodes of a COPC file follow each other without a gap behind its header.
async fn check(
    client: &mut PointServiceClient<Channel>,
    scene: &Scene,
    source: &str,
    path: &str,
    nodes: &[v1::NodeKey],
) -> anyhow::Result<()> {
    let path = scene.folder.path(path)?;
    let file = scene.folder.object_store().get(&path).await?.bytes().await?;
    let mut chunks: HashMap<[u32; 4], Vec<u8>> = HashMap::new();
    stream_chunks(client, scene, source, nodes, |part| {
        let key = part.key.unwrap_or_default();
        chunks.entry([key.level, key.x, key.y, key.z]).or_default().extend(&part.data);
    })
    .await?;
    // Chunks by their first bytes: a LAZ chunk begins with a whole point, so these differ.
    let mut by_head: HashMap<&[u8], &[u8]> = HashMap::new();
    for chunk in chunks.values() {
        by_head.insert(chunk.get(..HEAD_BYTES).unwrap_or(chunk), chunk);
    }
    let start = u32::from_le_bytes(file[96..100].try_into()?) as usize + 8;
    let mut at = start;
    for _ in 0..nodes.len() {
        let head = file.get(at..at + HEAD_BYTES).unwrap_or_default();
        let chunk = by_head.remove(head);
        let chunk = chunk.ok_or_else(|| anyhow::anyhow!("byte {at} begins no chunk that came"))?;
        anyhow::ensure!(file.get(at..at + chunk.len()) == Some(chunk), "a chunk differs at {at}");
        at += chunk.len();
    }
    println!("checked: {} chunks are the file's bytes {start} to {at}", nodes.len());
    Ok(())
}

/// Serves the object as a file server would; gives its address.
async fn plain_server(scene: &Scene, path: &str) -> anyhow::Result<SocketAddr> {
    let (store, path) = (scene.folder.object_store(), scene.folder.path(path)?);
    let handler = async move || {
        let size = store.head(&path).await.map_or(0, |meta| meta.size);
        let (store, path) = (store.clone(), path.clone());
        Body::from_stream(futures::stream::try_unfold(0, move |from| {
            let (store, path) = (store.clone(), path.clone());
            async move {
                if from >= size {
                    return Ok::<_, object_store::Error>(None);
                }
                let end = size.min(from + (8 << 20));
                let piece: Bytes = store.get_range(&path, from..end).await?;
                Ok(Some((piece, end)))
            }
        }))
    };
    let listener = TcpListener::bind(("127.0.0.1", 0)).await?;
    let address = listener.local_addr()?;
    let routes = Router::new().route("/", get(handler));
    tokio::spawn(async move { axum::serve(listener, routes).await });
    Ok(address)
}

/// Downloads what the plain server has; gives the bytes that came, head included.
async fn download(address: SocketAddr) -> anyhow::Result<u64> {
    let mut socket = TcpStream::connect(address).await?;
    socket.write_all(b"GET / HTTP/1.0\r\n\r\n").await?;
    let mut buffer = vec![0; 1 << 20];
    let mut bytes = 0;
    loop {
        match socket.read(&mut buffer).await? {
            0 => return Ok(bytes),
            read => bytes += read as u64,
        }
    }
}
