//! What a folder may hold, what may happen to it, and who else may use it.

mod child;
mod processes;

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::*;
use crate::cache::{Cache, CacheOptions, CacheStatistics};

/// A cache on disk alone.
fn open(folder: &Path, bytes: u64) -> Cache {
    let disk = DiskOptions { folder: folder.into(), bytes };
    Cache::new(&CacheOptions { memory_bytes: 0, disk: Some(disk) }).expect("a folder")
}

fn key(name: &str) -> CacheKey {
    CacheKey::new("street", "1", "node", name)
}

fn payload(seed: u32, length: usize) -> Bytes {
    // Multiplication by an odd number visits all values: no two seeds begin alike.
    let words = (0_u32..)
        .flat_map(|i| (seed.wrapping_add(i << 16)).wrapping_mul(2_654_435_761).to_le_bytes());
    words.take(length).collect()
}

/// The cache's own files, and the bytes that they take in blocks of 4 KiB.
fn files(folder: &Path) -> (Vec<PathBuf>, u64) {
    let own = folder.join("flaneur-payloads-1");
    let mut files = Vec::new();
    let mut bytes = 0;
    for file in fs::read_dir(own).into_iter().flatten().flatten() {
        // What another process removes meanwhile takes nothing.
        let Ok(metadata) = file.metadata() else { continue };
        bytes += metadata.len().div_ceil(4096) * 4096;
        if file.file_name() != "ledger" {
            files.push(file.path());
        }
    }
    (files, bytes)
}

/// A folder in which `key("a")` has a payload of 40 bytes; and its file.
async fn one_entry() -> (TempDir, PathBuf, Bytes) {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = open(folder.path(), 1 << 20);
    cache.insert(&key("a"), payload(1, 40), Rank::Detail);
    cache.flush().await;
    let (files, _) = files(folder.path());
    assert_eq!(files.len(), 1, "{files:?}");
    let bytes = fs::read(&files[0]).expect("written");
    (folder, files[0].clone(), bytes.into())
}

/// What a new cache finds for `key("a")`, and what it counts.
async fn found(folder: &Path) -> (Option<Bytes>, CacheStatistics) {
    let cache = open(folder, 1 << 20);
    let found = cache.get(&key("a"), None).await;
    (found, cache.statistics())
}

#[tokio::test]
async fn a_restart_finds_what_was_written() {
    let (folder, ..) = one_entry().await;
    assert_eq!(found(folder.path()).await.0, Some(payload(1, 40)));
    // The rank is found again, too.
    let disk =
        Disk::open(&DiskOptions { folder: folder.path().into(), bytes: 1 << 20 }, Arc::default());
    let disk = disk.expect("a folder").expect("writable");
    disk.insert(&key("b"), payload(2, 10), Rank::Upper);
    disk.flush().await;
    assert_eq!(disk.get(&key("b"), None).await, Some((payload(2, 10), Rank::Upper)));
    assert_eq!(disk.get(&key("a"), None).await, Some((payload(1, 40), Rank::Detail)));
    assert_eq!(disk.get(&key("c"), None).await, None);
}

#[tokio::test]
async fn every_flipped_bit_is_seen_and_the_entry_removed() {
    let (folder, file, sound) = one_entry().await;
    for at in 0..sound.len() {
        let mut bytes = sound.to_vec();
        bytes[at] ^= 1 << (at % 8);
        fs::write(&file, bytes).expect("written");
        let (found, counted) = found(folder.path()).await;
        assert_eq!((found, counted.damaged, counted.misses), (None, 1, 1), "byte {at}");
        assert!(!file.exists(), "byte {at}");
    }
}

#[tokio::test]
async fn every_other_length_is_seen_and_the_entry_removed() {
    let (folder, file, sound) = one_entry().await;
    for length in (0..sound.len()).chain([sound.len() + 1, sound.len() + 5000]) {
        let mut bytes = sound.to_vec();
        bytes.resize(length, 0);
        fs::write(&file, bytes).expect("written");
        let (found, counted) = found(folder.path()).await;
        assert_eq!((found, counted.damaged), (None, 1), "{length} bytes");
        assert!(!file.exists(), "{length} bytes");
    }
}

#[tokio::test]
async fn an_entry_that_the_scene_has_otherwise_is_removed() {
    let (folder, file, _) = one_entry().await;
    let cache = open(folder.path(), 1 << 20);
    let sound = Checked::of(&payload(1, 40));
    assert_eq!(cache.get(&key("a"), Some(sound)).await, Some(payload(1, 40)));
    let other = Checked { crc32: !sound.crc32, ..sound };
    assert_eq!(cache.get(&key("a"), Some(other)).await, None);
    assert!(!file.exists());
}

#[tokio::test]
async fn an_entry_under_anothers_name_is_not_believed() {
    let (folder, file, _) = one_entry().await;
    let cache = open(folder.path(), 1 << 20);
    cache.insert(&key("b"), payload(2, 40), Rank::Detail);
    cache.flush().await;
    let (files, _) = files(folder.path());
    let other = files.iter().find(|path| **path != file).expect("two");
    fs::copy(other, &file).expect("copied");
    assert_eq!(cache.get(&key("a"), None).await, None);
    assert_eq!(cache.get(&key("b"), None).await, Some(payload(2, 40)));
}

#[tokio::test]
async fn names_lead_nowhere_else() {
    let outside = tempfile::tempdir().expect("a folder");
    let folder = outside.path().join("cache");
    let cache = open(&folder, 1 << 20);
    let long = "x".repeat(5000);
    let names =
        ["../../up", "/etc/absolute", "nul\0", "", "ledger", "a/b", "..", "\\\\host\\c", &long];
    for (i, name) in names.iter().enumerate() {
        cache.insert(&key(name), payload(i as u32, 10), Rank::Detail);
    }
    cache.flush().await;
    for (i, name) in names.iter().enumerate() {
        assert_eq!(cache.get(&key(name), None).await, Some(payload(i as u32, 10)), "{name:?}");
    }
    let beside: Vec<_> = fs::read_dir(outside.path()).expect("there").flatten().collect();
    let within: Vec<_> = fs::read_dir(&folder).expect("there").flatten().collect();
    assert_eq!((beside.len(), within.len()), (1, 1), "{beside:?} {within:?}");
}

#[cfg(unix)]
#[tokio::test]
async fn what_is_not_the_caches_stays_as_it_is() {
    let (folder, file, _) = one_entry().await;
    let own = file.parent().expect("a folder");
    let foreign = [folder.path().join("thesis.txt"), own.join("notes"), own.join("0.part")];
    for path in &foreign {
        fs::write(path, vec![7; 100_000]).expect("written");
    }
    // Under an entry's name: a folder, and a link to elsewhere.
    let named = |name: &str| own.join(entry::file_name(&key(name)));
    fs::create_dir(named("folder")).expect("made");
    std::os::unix::fs::symlink(&foreign[0], named("link")).expect("made");
    std::os::unix::fs::symlink(&foreign[0], named("written").with_extension("part")).expect("made");
    // So little room that everything which counts must go.
    let cache = open(folder.path(), 4 * 4096);
    for name in ["folder", "link", "written"] {
        assert_eq!(cache.get(&key(name), None).await, None);
    }
    for i in 0..10 {
        cache.insert(&key(&i.to_string()), payload(i, 3000), Rank::Detail);
    }
    cache.insert(&key("written"), payload(99, 3000), Rank::Detail);
    cache.flush().await;
    assert_eq!(cache.get(&key("written"), None).await, Some(payload(99, 3000)));
    for path in &foreign {
        assert_eq!(fs::read(path).expect("still there"), vec![7; 100_000], "{}", path.display());
    }
    assert!(named("folder").is_dir());
}

#[tokio::test]
async fn parts_of_a_writer_that_was_killed_are_seen_by_nobody_and_removed() {
    let (folder, file, sound) = one_entry().await;
    let part = PathBuf::from(format!("{}.part", file.display()));
    fs::rename(&file, &part).expect("renamed");
    fs::write(&part, &sound[..sound.len() / 2]).expect("written");
    let (found, counted) = found(folder.path()).await;
    assert_eq!((found, counted.damaged), (None, 0));
    let cache = open(folder.path(), 1 << 20);
    cache.flush().await;
    let (left, _) = files(folder.path());
    assert!(left.is_empty(), "{left:?}");
}

#[tokio::test]
async fn the_folder_stays_within_its_bytes_and_keeps_what_was_used_last() {
    let folder = tempfile::tempdir().expect("a folder");
    let limit = 40 * 4096;
    {
        let cache = open(folder.path(), limit);
        for i in 0..200_u32 {
            cache.insert(&key(&i.to_string()), payload(i, 50 * i as usize), Rank::Detail);
            cache.flush().await;
            let (_, bytes) = files(folder.path());
            assert!(bytes <= limit && bytes <= cache.statistics().disk_bytes, "{bytes} after {i}");
            // Used again and again, it outlives what came long after it.
            if i > 0 {
                assert_eq!(cache.get(&key("1"), None).await, Some(payload(1, 50)), "after {i}");
            }
        }
        // Larger than everything together: not taken, and nothing makes room for it.
        let (before, _) = files(folder.path());
        cache.insert(&key("giant"), payload(0, limit as usize), Rank::Upper);
        cache.flush().await;
        assert_eq!(files(folder.path()).0.len(), before.len());
    }
    // What was used last is known after a restart; and a smaller limit holds at once.
    let limit = 6 * 4096;
    let cache = open(folder.path(), limit);
    cache.flush().await;
    assert!(files(folder.path()).1 <= limit);
    assert_eq!(cache.get(&key("1"), None).await, Some(payload(1, 50)));
    assert_eq!(cache.get(&key("100"), None).await, None);
}

#[tokio::test]
async fn two_caches_share_a_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let limit = 20 * 4096;
    let (one, other) = (open(folder.path(), limit), open(folder.path(), limit));
    for i in 0..60_u32 {
        let (writer, reader) = if i % 3 == 0 { (&one, &other) } else { (&other, &one) };
        writer.insert(&key(&i.to_string()), payload(i, 3000), Rank::Detail);
        writer.flush().await;
        assert_eq!(reader.get(&key(&i.to_string()), None).await, Some(payload(i, 3000)));
        assert!(files(folder.path()).1 <= limit, "after {i}");
    }
    assert_eq!(files(folder.path()).0.len(), 19, "no less is kept than fits");
}

#[tokio::test]
async fn a_folder_that_can_only_be_read_is_read() {
    let (folder, file, _) = one_entry().await;
    let ledger = file.with_file_name("ledger");
    fs::remove_file(&ledger).expect("removed");
    fs::create_dir(&ledger).expect("in its place");
    let cache = open(folder.path(), 1 << 20);
    assert_eq!(cache.get(&key("a"), None).await, Some(payload(1, 40)));
    cache.insert(&key("b"), payload(2, 40), Rank::Detail);
    cache.flush().await;
    assert_eq!(cache.get(&key("b"), None).await, None);
}

#[tokio::test]
async fn where_no_folder_can_be_made_memory_remains() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("written");
    let disk = DiskOptions { folder: file.join("below"), bytes: 1 << 20 };
    let options = CacheOptions { memory_bytes: 10_000, disk: Some(disk) };
    let cache = Cache::new(&options).expect("a warning is enough");
    cache.insert(&key("a"), payload(1, 40), Rank::Detail);
    cache.flush().await;
    assert_eq!(cache.get(&key("a"), None).await, Some(payload(1, 40)));
}
