//! The cache as the loader sees it.

use super::*;

fn key(name: &str) -> CacheKey {
    CacheKey::new("street", "1", "image", name)
}

fn memory_of(bytes: u64) -> Cache {
    Cache::new(&CacheOptions { memory_bytes: bytes, disk: None }).expect("needs nothing")
}

#[tokio::test]
async fn what_was_inserted_is_found_and_counted() {
    let cache = memory_of(10_000);
    assert_eq!(cache.get(&key("a"), None).await, None);
    cache.insert(&key("a"), Bytes::from_static(b"payload"), Rank::Detail);
    let expected = Checked::of(b"payload");
    assert_eq!(cache.get(&key("a"), None).await, Some(Bytes::from_static(b"payload")));
    assert_eq!(cache.get(&key("a"), Some(expected)).await, Some(Bytes::from_static(b"payload")));
    assert_eq!(cache.get(&key("b"), Some(expected)).await, None);
    let counted = cache.statistics();
    assert_eq!((counted.memory_hits, counted.disk_hits, counted.misses), (2, 0, 2));
    assert_eq!(counted.hit_rate(), 0.5);
    assert!(counted.memory_bytes > 7 && counted.disk_bytes == 0);
}

#[tokio::test]
async fn what_is_not_expected_is_removed() {
    let expected = Checked::of(b"payload");
    let others = [
        Checked { length: expected.length + 1, ..expected },
        Checked { crc32: expected.crc32 ^ 1, ..expected },
    ];
    for other in others {
        let cache = memory_of(10_000);
        cache.insert(&key("a"), Bytes::from_static(b"payload"), Rank::Upper);
        assert_eq!(cache.get(&key("a"), Some(other)).await, None);
        assert_eq!(cache.get(&key("a"), Some(expected)).await, None, "it is gone");
        let counted = cache.statistics();
        assert_eq!((counted.damaged, counted.misses, counted.memory_bytes), (1, 2, 0));
    }
}

#[tokio::test]
async fn memory_stays_within_its_bytes_even_of_tiny_payloads() {
    let cache = memory_of(20_000);
    for i in 0..1000 {
        cache.insert(&key(&i.to_string()), Bytes::new(), Rank::Detail);
        assert!(cache.statistics().memory_bytes <= 20_000);
    }
    let counted = cache.statistics();
    assert!(counted.evicted >= 800, "{counted:?}");
    // None at all is a cache, too.
    let none = memory_of(0);
    none.insert(&key("a"), Bytes::from_static(b"x"), Rank::Upper);
    assert_eq!(none.get(&key("a"), None).await, None);
}

/// What one asks for who looks at much stays, though another who shares the cache stands still.
#[tokio::test]
async fn of_several_who_share_a_cache_the_one_who_asks_for_most_counts() {
    let payload = || Bytes::from(vec![1; 1000]);
    let kept = |busy: bool| async move {
        let cache = memory_of(10_000);
        let (mut one, mut other) = (cache.working_set(), cache.working_set());
        one.set(if busy { 9000 } else { 0 });
        other.set(10);
        drop(other);
        cache.working_set().set(0);
        // Used twice, and so protected, before seven that are new.
        for _ in 0..2 {
            for name in ["a", "b", "c", "d", "e", "f"] {
                if cache.get(&key(name), None).await.is_none() {
                    cache.insert(&key(name), payload(), Rank::Detail);
                }
            }
        }
        let new = ["1", "2", "3", "4", "5", "6", "7"];
        new.iter().for_each(|name| cache.insert(&key(name), payload(), Rank::Detail));
        let mut found = 0;
        for name in new {
            found += usize::from(cache.get(&key(name), None).await.is_some());
        }
        found
    };
    assert_eq!(kept(true).await, 7);
    assert!(kept(false).await < 7);
}

#[tokio::test]
async fn what_falls_out_of_memory_is_found_on_disk_and_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let disk = DiskOptions { folder: folder.path().into(), bytes: 1 << 20 };
    // Memory for one of the two.
    let options = CacheOptions { memory_bytes: 1500, disk: Some(disk) };
    let cache = Cache::new(&options).expect("a folder");
    let mut place = cache.working_set();
    place.set(1500);
    let payload = |byte: u8| Bytes::from(vec![byte; 1000]);
    cache.insert(&key("a"), payload(1), Rank::Detail);
    cache.insert(&key("b"), payload(2), Rank::Detail);
    cache.flush().await;
    for _ in 0..2 {
        assert_eq!(cache.get(&key("a"), Some(Checked::of(&payload(1)))).await, Some(payload(1)));
    }
    assert_eq!(cache.get(&key("b"), None).await, Some(payload(2)));
    let counted = cache.statistics();
    assert_eq!((counted.memory_hits, counted.disk_hits, counted.misses), (1, 2, 0));
    assert!(counted.disk_bytes >= 2 * 4096, "{counted:?}");

    cache.remove(&key("a"));
    cache.flush().await;
    assert_eq!(cache.get(&key("a"), None).await, None);
}

#[test]
fn a_file_in_the_folders_place_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("taken");
    std::fs::write(&file, "mine").expect("written");
    let disk = DiskOptions { folder: file.clone(), bytes: 1 << 20 };
    let error =
        Cache::new(&CacheOptions { memory_bytes: 0, disk: Some(disk) }).expect_err("a file");
    assert!(error.to_string().ends_with("taken"), "{error}");
    assert_eq!(std::fs::read(&file).expect("still there"), b"mine");
}
