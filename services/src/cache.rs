//! What was read once and may be wanted again, as much as fits.

use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lru::LruCache;
use tokio::sync::OnceCell;

/// Values by key, bounded by the bytes that they take; who was used longest ago goes first.
/// Those who ask for the same absent value share one load. The newest value stays even where
/// it alone exceeds the limit, and values in use live on outside of the cache.
pub(crate) struct ByteCache<K: Hash + Eq, V> {
    limit: usize,
    state: Mutex<State<K, V>>,
}

struct State<K: Hash + Eq, V> {
    slots: LruCache<K, Slot<V>>,
    bytes: usize,
}

struct Slot<V> {
    cell: Arc<OnceCell<Arc<V>>>,
    /// What the value was said to take; 0 while it is loaded.
    bytes: usize,
}

impl<K: Hash + Eq + Clone, V> ByteCache<K, V> {
    /// An empty cache of at most `limit` bytes.
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, state: Mutex::new(State { slots: LruCache::unbounded(), bytes: 0 }) }
    }

    /// The value of `key`; `load` gives it, with the bytes it takes, where it is absent.
    /// A failure is not kept.
    pub(crate) async fn get_or_load<E>(
        &self,
        key: &K,
        load: impl Future<Output = Result<(V, usize), E>>,
    ) -> Result<Arc<V>, E> {
        let cell = {
            let slots = &mut self.state().slots;
            let slot = slots.get_or_insert(key.clone(), || Slot { cell: Arc::default(), bytes: 0 });
            slot.cell.clone()
        };
        let mut loaded = None;
        let outcome = cell
            .get_or_try_init(|| async {
                let (value, bytes) = load.await?;
                loaded = Some(bytes);
                Ok(Arc::new(value))
            })
            .await
            .cloned();
        let mut state = self.state();
        match (&outcome, loaded) {
            (Ok(_), Some(bytes)) => state.keep(key, cell, bytes, self.limit),
            (Err(_), _) => state.forget(key, &cell),
            (Ok(_), None) => {}
        }
        drop(state);
        outcome
    }

    fn state(&self) -> MutexGuard<'_, State<K, V>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Hash + Eq + Clone, V> State<K, V> {
    fn keep(&mut self, key: &K, cell: Arc<OnceCell<Arc<V>>>, bytes: usize, limit: usize) {
        let old = self.slots.put(key.clone(), Slot { cell, bytes });
        self.bytes = self.bytes - old.map_or(0, |slot| slot.bytes) + bytes;
        while self.bytes > limit && self.slots.len() > 1 {
            if let Some((_, slot)) = self.slots.pop_lru() {
                self.bytes -= slot.bytes;
            }
        }
    }

    /// Drops a slot whose load failed, unless another load has filled it since.
    fn forget(&mut self, key: &K, cell: &Arc<OnceCell<Arc<V>>>) {
        let ours = self.slots.peek(key).is_some_and(|slot| Arc::ptr_eq(&slot.cell, cell));
        if ours && cell.get().is_none() {
            self.slots.pop(key);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    async fn get(cache: &ByteCache<u32, u32>, key: u32, loads: &AtomicUsize) -> u32 {
        let load = async {
            loads.fetch_add(1, Ordering::Relaxed);
            tokio::task::yield_now().await;
            Ok::<_, ()>((key * 10, 40))
        };
        *cache.get_or_load(&key, load).await.expect("loads")
    }

    #[tokio::test]
    async fn who_was_used_longest_ago_goes_first() {
        let (cache, loads) = (ByteCache::new(100), AtomicUsize::new(0));
        for (key, loaded) in [(1, 1), (2, 2), (1, 2), (3, 3), (1, 3), (2, 4), (1, 4), (3, 5)] {
            assert_eq!(get(&cache, key, &loads).await, key * 10);
            assert_eq!(loads.load(Ordering::Relaxed), loaded, "after {key}");
        }
        assert_eq!(cache.state().bytes, 80);
    }

    #[tokio::test]
    async fn one_load_serves_all_who_wait() {
        let (cache, loads) = (ByteCache::new(100), AtomicUsize::new(0));
        let all = futures::future::join_all((0..50).map(|_| get(&cache, 7, &loads))).await;
        assert_eq!((all, loads.into_inner()), (vec![70; 50], 1));
    }

    #[tokio::test]
    async fn a_failure_is_not_kept_and_a_giant_does_not_stay_for_long() {
        let (cache, loads) = (ByteCache::new(100), AtomicUsize::new(0));
        let failed = cache.get_or_load(&1, async { Err::<(u32, usize), _>("no") }).await;
        assert_eq!(failed, Err("no"));
        assert_eq!(cache.state().slots.len(), 0);
        assert_eq!(get(&cache, 1, &loads).await, 10);
        let giant = cache.get_or_load(&2, async { Ok::<_, ()>((20, 1000)) }).await;
        assert_eq!((giant.expect("loads"), cache.state().bytes), (Arc::new(20), 1000));
        assert_eq!((get(&cache, 1, &loads).await, cache.state().bytes), (10, 40));
    }
}
