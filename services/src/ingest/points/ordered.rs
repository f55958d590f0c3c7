//! Work done in parallel whose results are used in order.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Calls `produce` for 0 to `count - 1` on all threads, and `consume` with each result, in
/// order and on one thread at a time. Stops at the first error.
///
/// At most `window` results are being made or wait to be consumed, which bounds their memory:
/// a thread that is further ahead sleeps. The one with the lowest index never sleeps, so
/// there is always progress.
pub(super) fn for_each_ordered<T: Send, E: Send>(
    count: usize,
    window: usize,
    produce: impl Fn(usize) -> Result<T, E> + Sync,
    consume: impl FnMut(T) -> Result<(), E> + Send,
) -> Result<(), E> {
    let threads = rayon::current_num_threads().min(count);
    let queue = Queue {
        state: Mutex::new(State {
            next_to_produce: 0,
            next_to_consume: 0,
            ready: BTreeMap::new(),
            consume: Some(consume),
            stopped: false,
            error: None,
        }),
        progress: Condvar::new(),
        count,
        window: window.max(1),
    };
    rayon::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|_| queue.work(&produce));
        }
    });
    let state = queue.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    state.error.map_or(Ok(()), Err)
}

/// A window that keeps all threads busy, if `memory` bytes hold that many items of
/// `item_bytes`, and fewer otherwise.
pub(super) fn window_within(memory: u64, item_bytes: u64) -> usize {
    (memory / item_bytes.max(1)).clamp(1, 4 * rayon::current_num_threads() as u64) as usize
}

struct Queue<T, E, F> {
    state: Mutex<State<T, E, F>>,
    progress: Condvar,
    count: usize,
    window: usize,
}

struct State<T, E, F> {
    next_to_produce: usize,
    next_to_consume: usize,
    ready: BTreeMap<usize, T>,
    /// Taken by the thread that is consuming.
    consume: Option<F>,
    stopped: bool,
    error: Option<E>,
}

impl<T, E, F: FnMut(T) -> Result<(), E>> Queue<T, E, F> {
    fn work(&self, produce: &(impl Fn(usize) -> Result<T, E> + Sync)) {
        let guard = StopOnPanic(self);
        while let Some(index) = self.take() {
            match produce(index) {
                Ok(item) => self.deliver(index, item),
                Err(error) => self.fail(self.lock(), error),
            }
        }
        std::mem::forget(guard);
    }

    fn take(&self) -> Option<usize> {
        let mut state = self.lock();
        let index = state.next_to_produce;
        state.next_to_produce += 1;
        while !state.stopped && index < self.count && index >= state.next_to_consume + self.window {
            state = self.progress.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        (!state.stopped && index < self.count).then_some(index)
    }

    fn deliver(&self, index: usize, item: T) {
        let mut state = self.lock();
        state.ready.insert(index, item);
        let Some(mut consume) = state.consume.take() else { return };
        while !state.stopped {
            let next = state.next_to_consume;
            let Some(item) = state.ready.remove(&next) else { break };
            drop(state);
            let result = consume(item);
            state = self.lock();
            if let Err(error) = result {
                self.fail(state, error);
                return;
            }
            state.next_to_consume += 1;
            self.progress.notify_all();
        }
        state.consume = Some(consume);
    }

    fn fail(&self, mut state: MutexGuard<'_, State<T, E, F>>, error: E) {
        state.stopped = true;
        state.error.get_or_insert(error);
        self.progress.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State<T, E, F>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Wakes the others when a thread unwinds, so that the panic is seen instead of a standstill.
struct StopOnPanic<'a, T, E, F: FnMut(T) -> Result<(), E>>(&'a Queue<T, E, F>);

impl<T, E, F: FnMut(T) -> Result<(), E>> Drop for StopOnPanic<'_, T, E, F> {
    fn drop(&mut self) {
        self.0.lock().stopped = true;
        self.0.progress.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::for_each_ordered;

    #[test]
    fn results_arrive_in_order_however_long_each_takes() {
        let mut seen = Vec::new();
        let produce = |i: usize| {
            if i.is_multiple_of(7) {
                std::thread::yield_now();
            }
            Ok::<_, ()>(i)
        };
        for_each_ordered(1000, 16, produce, |i| {
            seen.push(i);
            Ok(())
        })
        .unwrap();
        assert_eq!(seen, (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn the_first_error_stops_the_work() {
        let mut seen = 0;
        let produce = |i| if i == 100 { Err("produce") } else { Ok(i) };
        let result = for_each_ordered(1_000_000, 16, produce, |_| {
            seen += 1;
            Ok(())
        });
        assert_eq!(result, Err("produce"));
        assert!(seen <= 100, "{seen} results before item 100, which failed");

        let result =
            for_each_ordered(1_000_000, 16, Ok, |i| if i == 5 { Err("consume") } else { Ok(()) });
        assert_eq!(result, Err("consume"));
    }

    #[test]
    fn nothing_to_do_is_done() {
        for_each_ordered(0, 16, Ok::<_, ()>, |_| unreachable!()).unwrap();
    }
}
