//! How much may be under way at once: as much as the connection carries in the time it takes to
//! hear of it, and a little more.
//!
//! Less would leave the connection idle; more would wait in buffers, and make what a new view wants
//! wait behind it. The rate is the largest that was seen of late, the delay the least: what BBR
//! (Cardwell et al., 2016) does for packets is done here for requests. A delay is only known where nothing
//! else is under way; so where the last such one is old, what is under way is let run out, and a request
//! by itself measures it anew.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;

use crate::plan::Room;

/// Before anything is known: a slow connection's half second.
const FIRST_BYTES: u64 = 96 << 10;
/// Never less, so that a rate measured low can rise.
const LEAST_BYTES: u64 = 64 << 10;
/// Never more: the server's and our own memory.
const MOST_BYTES: u64 = 16 << 20;
/// How many times what the connection carries in a delay: room for the rate to rise.
const GAIN: f64 = 2.0;
/// What decoding and deciding take beside the network's delay.
const SLACK: Duration = Duration::from_millis(50);
/// How long a measurement counts.
const MEMORY: Duration = Duration::from_secs(10);
/// What comes within this comes soon.
const SOON: Duration = Duration::from_secs(1);
/// Requests under way, whatever they weigh.
const MOST_REQUESTS: usize = 24;

/// The state of one connection.
#[derive(Debug, Default)]
pub(crate) struct Window {
    requests: usize,
    /// Bytes that are expected, of all requests.
    under_way: u64,
    delivered: u64,
    /// Bytes a second, of late: each with the time of its measurement, falling.
    rates: VecDeque<(Instant, f64)>,
    /// The least of late of the seconds to what comes first.
    delay: Option<(Instant, f64)>,
    /// Whether a request by itself is to measure the delay.
    probes: bool,
}

/// A request under way, as the window sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sent {
    at: Instant,
    delivered: u64,
    /// Bytes that are still expected.
    expected: u64,
    heard: bool,
    /// Nothing else was under way when it was sent.
    alone: bool,
}

impl Window {
    /// What one more request may ask for; `None` where none may be sent now.
    pub(crate) fn room(&self) -> Option<Room> {
        let size = self.size();
        let most = if self.probes { 1 } else { MOST_REQUESTS };
        let has_room = self.requests < most && self.under_way < size;
        let soon = self.rate().map_or(0.0, |rate| rate * SOON.as_secs_f64());
        // Small enough that several share the connection, and the next view need not wait long.
        has_room.then_some(Room { bytes: (size / 4).max(LEAST_BYTES / 4), soon: soon as u64 })
    }

    /// Takes note of a request for `bytes`.
    pub(crate) fn send(&mut self, bytes: u64, now: Instant) -> Sent {
        let alone = self.requests == 0;
        self.requests += 1;
        self.under_way += bytes;
        Sent { at: now, delivered: self.delivered, expected: bytes, heard: false, alone }
    }

    /// Takes note of `bytes` that came for a request.
    pub(crate) fn receive(&mut self, sent: &mut Sent, bytes: u64, now: Instant) {
        self.delivered += bytes;
        let done = bytes.min(sent.expected);
        sent.expected -= done;
        self.under_way = self.under_way.saturating_sub(done);
        let seconds = now.duration_since(sent.at).as_secs_f64();
        // All that came since the request was sent, whoever asked for it.
        let rate = (self.delivered - sent.delivered) as f64 / seconds.max(1e-3);
        keep(&mut self.rates, now, rate);
        if !std::mem::replace(&mut sent.heard, true) {
            self.hear(sent.alone, seconds, now);
        }
    }

    /// Takes note of a delay.
    fn hear(&mut self, alone: bool, seconds: f64, now: Instant) {
        let old = self.delay.filter(|&(at, _)| now.duration_since(at) <= MEMORY);
        if alone || self.delay.is_none_or(|(_, least)| seconds <= least) {
            self.delay = Some((now, seconds));
            self.probes = false;
        } else if old.is_none() {
            self.probes = true;
        }
    }

    /// The largest of late, bytes a second.
    fn rate(&self) -> Option<f64> {
        self.rates.front().map(|&(_, rate)| rate)
    }

    /// So many bytes of a request need not come.
    pub(crate) fn forgo(&mut self, sent: &mut Sent, bytes: u64) {
        let done = bytes.min(sent.expected);
        sent.expected -= done;
        self.under_way = self.under_way.saturating_sub(done);
    }

    /// A request has ended, one way or another.
    pub(crate) fn end(&mut self, sent: &Sent) {
        self.requests = self.requests.saturating_sub(1);
        self.under_way = self.under_way.saturating_sub(sent.expected);
    }

    /// Bytes that may be under way.
    fn size(&self) -> u64 {
        let (Some(rate), Some((_, delay))) = (self.rate(), self.delay) else { return FIRST_BYTES };
        let bytes = GAIN * rate * (delay + SLACK.as_secs_f64());
        (bytes as u64).clamp(LEAST_BYTES, MOST_BYTES)
    }
}

/// Adds a rate to those that count: the largest of the last while at the front, behind it what is largest
/// once that is too old.
fn keep(rates: &mut VecDeque<(Instant, f64)>, now: Instant, rate: f64) {
    while rates.back().is_some_and(|&(_, old)| old <= rate) {
        rates.pop_back();
    }
    rates.push_back((now, rate));
    while rates.front().is_some_and(|&(at, _)| now.duration_since(at) > MEMORY) {
        rates.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Requests over a connection of `rate` bytes a second and a delay of `delay` seconds, one step
    /// every 5 ms: bytes a second in the last half of `seconds`, and most bytes under way then.
    fn run(rate: f64, delay: f64, seconds: f64) -> (f64, u64) {
        let start = Instant::now();
        let mut window = Window::default();
        // Arrival of the request, bytes left.
        let mut queue: VecDeque<(f64, f64, Sent)> = VecDeque::new();
        let (mut time, mut delivered, mut most) = (0.0, 0.0, 0);
        while time < seconds {
            let now = start + Duration::from_secs_f64(time);
            while let Some(Room { bytes, .. }) = window.room() {
                let sent = window.send(bytes, now);
                queue.push_back((time + delay, bytes as f64, sent));
            }
            let mut carried = rate * 0.005;
            while let Some((from, left, sent)) = queue.front_mut() {
                if *from > time || carried <= 0.0 {
                    break;
                }
                let bytes = carried.min(*left);
                carried -= bytes;
                *left -= bytes;
                window.receive(sent, bytes as u64, now);
                if time >= 0.5 * seconds {
                    delivered += bytes;
                }
                if *left < 1.0 {
                    window.end(sent);
                    queue.pop_front();
                }
            }
            if time >= 0.5 * seconds {
                most = most.max(window.under_way);
            }
            time += 0.005;
        }
        (delivered / (0.5 * seconds), most)
    }

    #[test]
    fn the_connection_is_full_and_its_queue_short() {
        for (rate, delay) in [(1.25e6, 0.1), (125e3, 0.05), (12.5e6, 0.3), (50e6, 0.001)] {
            // Before the delay is measured anew, and after that was done many times.
            for seconds in [8.0, 120.0] {
                let (reached, under_way) = run(rate, delay, seconds);
                assert!(reached > 0.9 * rate, "{reached} of {rate} at {delay} in {seconds} s");
                let carried = rate * (delay + SLACK.as_secs_f64());
                let most = (4.0 * carried).max(2.0 * LEAST_BYTES as f64);
                assert!((under_way as f64) < most, "{under_way} under way at {rate}, {delay}");
            }
        }
    }

    #[test]
    fn what_ends_makes_room_however_it_ends() {
        let now = Instant::now();
        let mut window = Window::default();
        let mut sent = Vec::new();
        while let Some(Room { bytes, .. }) = window.room() {
            sent.push(window.send(bytes, now));
        }
        assert!(window.under_way >= FIRST_BYTES);
        sent.iter().for_each(|sent| window.end(sent));
        assert_eq!((window.requests, window.under_way), (0, 0));
    }
}
