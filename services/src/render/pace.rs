//! How many frames are under way to a client, and how large they may be.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;

/// How long a frame may be on its way while the view moves: longer ones become smaller.
const AIM: Duration = Duration::from_millis(80);
/// On connections that take longer than this for a frame there is one under way …
const SLOW: Duration = Duration::from_millis(40);
/// … and on faster ones so many, so that the way there and back is not waited for.
const WINDOW: usize = 2;
/// A client that has acknowledged nothing so long after its first frame does not acknowledge: it has
/// as many frames as its connection takes.
const SILENCE: Duration = Duration::from_secs(1);
/// Qualities of JPEG between which the connection decides, where it begins, and by how much it goes.
const QUALITIES: (u8, u8) = (30, 85);
const FIRST_QUALITY: u8 = 75;
const STEP: u8 = 6;

/// What is known of a client's connection from when it acknowledged what.
#[derive(Debug)]
pub(super) struct Pace {
    under_way: VecDeque<Sent>,
    /// When the first frame went out.
    first: Option<Instant>,
    acknowledges: bool,
    /// The shortest that a frame ever took there and back: what is not the connection's width.
    least: Option<Duration>,
    /// How long the last acknowledged frame took, beyond that.
    transfer: Duration,
    quality: u8,
}

#[derive(Clone, Copy, Debug)]
struct Sent {
    number: u64,
    at: Instant,
}

impl Pace {
    pub(super) fn new() -> Self {
        Self {
            under_way: VecDeque::new(),
            first: None,
            acknowledges: false,
            least: None,
            transfer: Duration::ZERO,
            quality: FIRST_QUALITY,
        }
    }

    /// A frame goes out.
    pub(super) fn sent(&mut self, number: u64, now: Instant) {
        self.first.get_or_insert(now);
        // Who never acknowledges must not have a list that grows.
        if !self.acknowledges && self.under_way.len() > WINDOW {
            self.under_way.pop_front();
        }
        self.under_way.push_back(Sent { number, at: now });
    }

    /// The client has every frame up to `number`; 0 says nothing.
    pub(super) fn received(&mut self, number: u64, now: Instant) {
        while let Some(sent) = self.under_way.pop_front_if(|sent| sent.number <= number) {
            self.acknowledges = true;
            let took = now.saturating_duration_since(sent.at);
            let least = self.least.map_or(took, |least| least.min(took));
            self.least = Some(least);
            self.transfer = took.saturating_sub(least);
            if self.transfer > AIM {
                self.quality = self.quality.saturating_sub(STEP).max(QUALITIES.0);
            } else if self.transfer < AIM / 2 {
                self.quality = (self.quality + STEP / 3).min(QUALITIES.1);
            }
        }
    }

    /// When the next frame may go; now where `None`. An acknowledgement may make it earlier.
    pub(super) fn wait(&self, now: Instant) -> Option<Until> {
        let window = if self.transfer > SLOW { 1 } else { WINDOW };
        if self.under_way.len() < window {
            return None;
        }
        if self.acknowledges {
            return Some(Until::Acknowledged);
        }
        let known = self.first? + SILENCE;
        (known > now).then_some(Until::At(known))
    }

    /// Quality of JPEG while the view moves.
    pub(super) fn quality(&self) -> u8 {
        self.quality
    }
}

/// What is waited for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Until {
    /// That the client acknowledges a frame.
    Acknowledged,
    /// A moment.
    At(Instant),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_fast_client_has_two_frames_under_way_and_a_slow_one_has_one() {
        let (mut pace, start) = (Pace::new(), Instant::now());
        pace.sent(1, start);
        assert_eq!(pace.wait(start), None);
        pace.sent(2, start + ms(5));
        assert_eq!(pace.wait(start + ms(5)), Some(Until::At(start + ms(1000))));
        pace.received(1, start + ms(50));
        assert_eq!(pace.wait(start + ms(50)), None, "one under way");
        pace.sent(3, start + ms(50));
        assert_eq!(pace.wait(start + ms(50)), Some(Until::Acknowledged));
        // Two at once, the later of which took long.
        pace.received(3, start + ms(300));
        pace.sent(4, start + ms(300));
        assert_eq!(pace.wait(start + ms(300)), Some(Until::Acknowledged), "slow: one");
    }

    #[test]
    fn a_client_that_never_acknowledges_is_not_waited_for() {
        let (mut pace, start) = (Pace::new(), Instant::now());
        pace.sent(1, start);
        pace.sent(2, start + ms(10));
        assert_eq!(pace.wait(start + ms(20)), Some(Until::At(start + ms(1000))));
        // From then on as fast as the connection takes them.
        for number in 3..60 {
            let now = start + ms(1000 + number);
            assert_eq!(pace.wait(now), None, "{number}");
            pace.sent(number, now);
        }
        assert!(pace.under_way.len() <= WINDOW + 1);
    }

    #[test]
    fn quality_follows_the_connection() {
        let (mut pace, mut now) = (Pace::new(), Instant::now());
        let mut send = |pace: &mut Pace, number, took: u64| {
            pace.sent(number, now);
            now += ms(took);
            pace.received(number, now);
        };
        send(&mut pace, 1, 20);
        for number in 2..30 {
            send(&mut pace, number, 220);
        }
        assert_eq!(pace.quality(), QUALITIES.0);
        for number in 30..90 {
            send(&mut pace, number, 30);
        }
        assert_eq!(pace.quality(), QUALITIES.1);
        let before = pace.quality();
        send(&mut pace, 90, 20 + 60);
        assert_eq!(pace.quality(), before, "between, nothing changes");
    }
}
