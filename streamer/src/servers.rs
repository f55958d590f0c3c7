//! Several servers of the same scenes: which of them is asked, and when one that failed is asked
//! again.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rand::RngExt as _;
use tokio::time::Instant;
use tonic::transport::Channel;

/// Before a server that failed once is asked again.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// However often it failed.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// Where scenes are had from: one server, or several that hold the same. Clones share what is known
/// of them.
#[derive(Clone, Debug)]
pub struct Servers(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    channels: Vec<Channel>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// The one that is asked.
    current: usize,
    records: Vec<Record>,
    failovers: u64,
}

#[derive(Clone, Debug, Default)]
struct Record {
    /// In a row.
    failures: u32,
    /// The first of them.
    failing_since: Option<Instant>,
    failed_at: Option<Instant>,
    /// Not to be asked before.
    retry_at: Option<Instant>,
}

/// A server to be asked, since when.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    server: usize,
    since: Instant,
}

impl From<Channel> for Servers {
    fn from(channel: Channel) -> Self {
        Self::from(vec![channel])
    }
}

impl From<Vec<Channel>> for Servers {
    /// The first is asked as long as it answers.
    fn from(channels: Vec<Channel>) -> Self {
        let records = vec![Record::default(); channels.len()];
        let state = State { current: 0, records, failovers: 0 };
        Self(Arc::new(Inner { channels, state: Mutex::new(state) }))
    }
}

impl Servers {
    /// The server to ask, once one may be asked. `None` where there is none at all.
    pub(crate) async fn turn(&self) -> Option<(Turn, Channel)> {
        loop {
            let now = Instant::now();
            let wait = match self.with(|state| state.pick(now))? {
                Ok(server) => {
                    let channel = self.0.channels.get(server)?.clone();
                    return Some((Turn { server, since: now }, channel));
                }
                Err(until) => until,
            };
            tokio::time::sleep_until(wait).await;
        }
    }

    /// A server answered.
    pub(crate) fn works(&self, turn: Turn) {
        self.with(|state| {
            if let Some(record) = state.records.get_mut(turn.server)
                && record.failed_at.is_none_or(|at| at < turn.since)
            {
                *record = Record::default();
            }
        });
    }

    /// A server failed: another one is asked from now on, if there is one, and this one after a
    /// pause that doubles with each failure in a row, shortened by chance so that many clients do
    /// not come back at once. Calls that were under way together count once.
    pub(crate) fn fails(&self, turn: Turn) {
        let now = Instant::now();
        let chance = rand::rng().random_range(0.5..1.0);
        self.with(|state| state.fail(turn, now, chance));
    }

    /// Since when no server has given a whole answer; `None` where one may, as far as is known.
    pub(crate) fn failing_since(&self) -> Option<Instant> {
        self.with(|state| state.failing_since())
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.0.channels.len()
    }

    /// How often another server took over.
    pub(crate) fn failovers(&self) -> u64 {
        self.with(|state| state.failovers)
    }

    fn with<T>(&self, act: impl FnOnce(&mut State) -> T) -> T {
        act(&mut self.0.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl State {
    /// The current server if it may be asked, else any that may, else when the first may. `None`
    /// without servers.
    fn pick(&mut self, now: Instant) -> Option<Result<usize, Instant>> {
        let ready = |record: &Record| record.retry_at.is_none_or(|at| at <= now);
        if self.records.get(self.current).is_some_and(ready) {
            return Some(Ok(self.current));
        }
        if let Some(server) = self.records.iter().position(ready) {
            self.failovers += 1;
            self.current = server;
            return Some(Ok(server));
        }
        self.records.iter().filter_map(|record| record.retry_at).min().map(Err)
    }

    /// When the last of them began to fail, where none works.
    fn failing_since(&self) -> Option<Instant> {
        // Where one has not failed, that makes none of all.
        let since: Option<Vec<_>> =
            self.records.iter().map(|record| record.failing_since).collect();
        since?.into_iter().max()
    }

    fn fail(&mut self, turn: Turn, now: Instant, chance: f64) {
        let Some(record) = self.records.get_mut(turn.server) else { return };
        if record.failed_at.is_some_and(|at| at > turn.since) {
            return;
        }
        record.failures = record.failures.saturating_add(1);
        record.failing_since.get_or_insert(now);
        let doubled = FIRST_PAUSE.saturating_mul(1 << (record.failures - 1).min(16));
        record.failed_at = Some(now);
        record.retry_at = Some(now + doubled.min(LONGEST_PAUSE).mul_f64(chance));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(servers: usize) -> State {
        State { current: 0, records: vec![Record::default(); servers], failovers: 0 }
    }

    #[test]
    fn pauses_double_and_calls_that_fail_together_count_once() {
        let (mut state, start) = (state(1), Instant::now());
        let turn = Turn { server: 0, since: start };
        let mut now = start;
        for failures in 1..12u32 {
            let turn = Turn { since: now, ..turn };
            now += Duration::from_millis(1);
            state.fail(turn, now, 1.0);
            state.fail(turn, now + Duration::from_millis(1), 1.0);
            assert_eq!(state.records[0].failures, failures);
            let pause = FIRST_PAUSE.saturating_mul(1 << (failures - 1)).min(LONGEST_PAUSE);
            assert_eq!(state.pick(now), Some(Err(now + pause)));
            now += pause;
            assert_eq!(state.pick(now), Some(Ok(0)));
        }
    }

    #[test]
    fn all_fail_from_when_the_last_began_to() {
        let (mut state, start) = (state(2), Instant::now());
        let after = |seconds| start + Duration::from_secs(seconds);
        assert_eq!(state.failing_since(), None);
        state.fail(Turn { server: 0, since: start }, after(1), 1.0);
        assert_eq!(state.failing_since(), None, "nobody knows of the other");
        state.fail(Turn { server: 1, since: after(1) }, after(2), 1.0);
        state.fail(Turn { server: 0, since: after(2) }, after(3), 1.0);
        assert_eq!(state.failing_since(), Some(after(2)));
        state.records[0] = Record::default();
        assert_eq!(state.failing_since(), None, "it works again");
        assert_eq!(self::state(0).failing_since(), None);
    }

    #[test]
    fn another_server_takes_over_and_keeps_the_work() {
        let (mut state, now) = (state(2), Instant::now());
        assert_eq!(state.pick(now), Some(Ok(0)));
        state.fail(Turn { server: 0, since: now }, now, 1.0);
        assert_eq!(state.pick(now), Some(Ok(1)));
        let later = now + LONGEST_PAUSE;
        assert_eq!(state.pick(later), Some(Ok(1)), "it is not left without need");
        assert_eq!(state.failovers, 1);
        assert_eq!(self::state(0).pick(now), None);
    }
}
