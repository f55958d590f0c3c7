use std::collections::BTreeMap;
use std::path::Path as FilePath;

use flaneur_scene::OctreeCube;
use glam::{DVec3, IVec3};
use object_store::memory::InMemory;
use proptest::prelude::*;

use super::super::{CopcHeader, CopcSummary, CopcWriter, compress_node};
use super::*;

/// Nodes of a tree that takes several pages: four whole levels, and a chain below one corner.
pub(crate) fn deep_tree() -> Vec<NodeKey> {
    let mut keys = vec![NodeKey::ROOT];
    for first in [0, 1, 9] {
        let parents = keys[first..].to_vec();
        keys.extend(parents.iter().flat_map(NodeKey::children));
    }
    for level in 4..12 {
        keys.push(NodeKey { level, x: (1 << level) - 1, y: 0, z: 0 });
    }
    keys
}

/// Writes a COPC file whose every node holds `points` records of format 6.
pub(crate) fn write_copc(path: &FilePath, keys: &[NodeKey], points: u32) {
    let header = CopcHeader {
        file_source_id: 0,
        global_encoding: 17,
        guid: [0; 16],
        system_identifier: [0; 32],
        creation: (1, 2026),
        point_format: 6,
        extra_bytes: 0,
        scale: DVec3::splat(0.001),
        offset: DVec3::ZERO,
        cube: OctreeCube { centre: DVec3::ZERO, half_size_m: 8.0, spacing_m: 1.0 },
        vlrs: vec![],
        evlrs: vec![],
    };
    let mut writer = CopcWriter::create(path, header).expect("writable");
    for (index, key) in keys.iter().enumerate() {
        let records: Vec<[u8; 30]> = (0..points)
            .map(|point| {
                let mut record = [0; 30];
                let x = index as u32 * points + point;
                record[..4].copy_from_slice(&x.to_le_bytes());
                // Hashed, so that chunks do not shrink to nothing.
                record[4..8].copy_from_slice(&x.wrapping_mul(2_654_435_761).to_le_bytes());
                record[14] = 0x11;
                record
            })
            .collect();
        let chunk =
            compress_node(writer.laz_vlr(), records.iter().map(|r| &r[..])).expect("memory");
        writer.add_node(*key, points, &chunk).expect("writable");
    }
    let point_count = keys.len() as u64 * u64::from(points);
    let mut by_return = [0; 15];
    by_return[0] = point_count;
    let (min, max) = (IVec3::splat(-8000), IVec3::splat(8000));
    let summary = CopcSummary { point_count, by_return, min, max, gps_time: (0.0, 1.0) };
    writer.finish(&summary).expect("writable");
}

fn copc_bytes() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.copc.laz");
    write_copc(&path, &deep_tree(), 3);
    std::fs::read(path).expect("written")
}

async fn open(bytes: &[u8]) -> Result<CopcFile, LayerError> {
    let store = Arc::new(InMemory::new());
    let path = Path::from("a.copc.laz");
    store.put(&path, bytes.to_vec().into()).await.expect("memory");
    CopcFile::open(store, path, bytes.len() as u64).await
}

/// Every node that the pages list, down from the root.
async fn walk(file: &CopcFile) -> Result<(usize, BTreeMap<NodeKey, PageItem>), LayerError> {
    let (mut pages, mut nodes) = (vec![file.root()], BTreeMap::new());
    let mut next = 0;
    let mut read = 0;
    while let Some(address) = pages.get(next).copied() {
        next += 1;
        read += u64::from(address.byte_size);
        if read > file.size() {
            break;
        }
        for entry in file.page(address).await?.entries {
            match entry.item {
                PageItem::Page(page) => pages.push(page),
                node @ PageItem::Node { .. } => {
                    nodes.insert(entry.key, node);
                }
            }
        }
    }
    Ok((next, nodes))
}

#[tokio::test]
async fn every_node_that_was_written_is_found_with_its_bytes() {
    let bytes = copc_bytes();
    let file = open(&bytes).await.expect("a COPC file");
    let (pages, nodes) = walk(&file).await.expect("whole");
    assert!(pages > 1, "the tree takes more than one page");
    let mut wanted = deep_tree();
    wanted.sort();
    assert_eq!(nodes.keys().copied().collect::<Vec<_>>(), wanted);
    let root = file.page(file.root()).await.expect("whole");
    for (key, item) in nodes {
        let PageItem::Node { offset, byte_size, point_count, crc32 } = item else {
            panic!("{item:?}")
        };
        assert_eq!(point_count, 3);
        let chunk = file.get(offset..offset + u64::from(byte_size)).await.expect("there");
        let at = usize::try_from(offset).expect("small");
        assert_eq!(chunk, &bytes[at..at + byte_size as usize]);
        assert_eq!(crc32, crc32fast::hash(&chunk), "{key:?}");
        // From the root page, each node is either listed or reached through a page above it.
        let listed = root.entry(key).is_some();
        assert!(listed || root.towards(key).is_some(), "{key:?}");
    }
    assert_eq!(root.towards(NodeKey { level: 5, x: 0, y: 0, z: 0 }), None);
}

#[tokio::test]
async fn damage_is_named_with_its_place() {
    let good = copc_bytes();
    let file = open(&good).await.expect("a COPC file");
    let root = file.root();
    let at = usize::try_from(root.offset).expect("small");
    let sub_page = (at..).step_by(32).find(|at| good[at + 28..at + 32] == [0xff; 4]);
    let sub_page = sub_page.expect("a page leads on");
    // What is overwritten, where, and a word of the complaint.
    let evlr = |start: usize| start - Evlr::HEADER_LENGTH as usize;
    let checksums = usize::try_from(file.layout.header().start).expect("small");
    let cases: [(usize, &[u8], &str); 19] = [
        (0, b"LASX", "no LAS 1.4"),
        (24, &[1, 2], "no LAS 1.4"),
        (377, b"cope", "not COPC"),
        (469, &u64::MAX.to_le_bytes(), "whole entries"),
        (477, &u64::MAX.to_le_bytes(), "root page"),
        (477, &33u64.to_le_bytes(), "whole entries"),
        (477, &0u64.to_le_bytes(), "whole entries"),
        (235, &u64::MAX.to_le_bytes(), "no records"),
        (235, &0u64.to_le_bytes(), "not COPC's hierarchy"),
        (evlr(at) + 20, &u64::MAX.to_le_bytes(), "do not fit"),
        (evlr(at) + 20, &64u64.to_le_bytes(), "ingest the survey again"),
        (checksums + 2, b"someone", "ingest the survey again"),
        (checksums + 20, &[9], "ingest the survey again"),
        (469, &(root.offset + 8).to_le_bytes(), "outside of the hierarchy"),
        (at, &(-1i32).to_le_bytes(), "no node below"),
        (at + 4, &9u32.to_le_bytes(), "no node below"),
        (at + 16, &(u64::MAX - 5).to_le_bytes(), "points in"),
        (at + 28, &(-2i32).to_le_bytes(), "has -2 points"),
        (at + 32, &[0; 16], "twice"),
    ];
    for (place, overwrite, says) in cases {
        let mut bytes = good.clone();
        bytes[place..place + overwrite.len()].copy_from_slice(overwrite);
        let error = match open(&bytes).await {
            Ok(file) => file.page(file.root()).await.expect_err(says),
            Err(error) => error,
        };
        assert!(error.to_string().contains(says), "{says}: {error}");
    }
    // A page that leads to itself under its own key.
    let mut endless = good.clone();
    endless[at..at + 16].fill(0);
    endless[at + 16..at + 24].copy_from_slice(&root.offset.to_le_bytes());
    endless[at + 24..at + 28].copy_from_slice(&root.byte_size.to_le_bytes());
    endless[at + 28..at + 32].copy_from_slice(&(-1i32).to_le_bytes());
    let file = open(&endless).await.expect("the header is whole");
    let error = file.page(file.root()).await.expect_err("endless").to_string();
    assert!(error.contains("back to itself"), "{error}");
    // A page under a deeper key that is the root page again: it lists keys outside of itself.
    let mut crossed = good.clone();
    crossed[sub_page + 16..sub_page + 24].copy_from_slice(&root.offset.to_le_bytes());
    crossed[sub_page + 24..sub_page + 28].copy_from_slice(&root.byte_size.to_le_bytes());
    let error = walk(&open(&crossed).await.expect("whole")).await.expect_err("crossed").to_string();
    assert!(error.contains("no node below"), "{error}");
    for length in [0, 100, 588] {
        let error = open(&good[..length]).await.expect_err("cut short").to_string();
        assert!(error.contains("no COPC file"), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn no_byte_can_make_the_reader_panic_or_run_on(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        in_pages in any::<bool>(),
    ) {
        static GOOD: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(copc_bytes);
        let mut bytes = GOOD.clone();
        // Most bytes of the file are points, which the reader never looks into.
        let pages = bytes.len() - 600 * 32;
        for (index, value) in flips {
            let place = if in_pages { pages + index.index(600 * 32) } else { index.index(600) };
            bytes[place] = value;
        }
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        runtime.block_on(async {
            if let Ok(file) = open(&bytes).await {
                let _ = walk(&file).await;
            }
        });
    }
}
