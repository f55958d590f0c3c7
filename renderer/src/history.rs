//! What goes smoothly from frame to frame, for each who looks: several may have turns.

use crate::{gains, infer};

/// Most who are remembered beside the one who looks now.
const MOST: usize = 64;

/// What the frames of one who looks leave for their next.
#[derive(Debug, Default)]
pub(crate) struct History {
    pub(crate) gains: gains::Past,
    pub(crate) inferred: Option<infer::Past>,
}

/// Who looks now, and what those left who looked before.
#[derive(Debug, Default)]
pub(crate) struct Histories {
    viewer: u64,
    /// The one who looked last is the last.
    others: Vec<(u64, History)>,
}

impl Histories {
    /// Whether the next frame is of another than the last.
    pub(crate) fn is_other(&self, viewer: u64) -> bool {
        self.viewer != viewer
    }

    /// What `viewer` left, who looks from now on; `left` is of the one who looked until now.
    pub(crate) fn turn(&mut self, viewer: u64, left: History) -> History {
        self.others.push((std::mem::replace(&mut self.viewer, viewer), left));
        let own = self.take(viewer).unwrap_or_default();
        if self.others.len() > MOST {
            self.others.remove(0);
        }
        own
    }

    /// Forgets one who does not look now.
    pub(crate) fn forget(&mut self, viewer: u64) {
        drop(self.take(viewer));
    }

    /// Forgets all who do not look now.
    pub(crate) fn clear(&mut self) {
        self.others.clear();
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        let inferred = self.others.iter().filter_map(|(_, history)| history.inferred.as_ref());
        inferred.map(infer::Past::bytes).sum()
    }

    fn take(&mut self, viewer: u64) -> Option<History> {
        let at = self.others.iter().position(|(id, _)| *id == viewer)?;
        Some(self.others.remove(at).1)
    }
}
