//! Which pixels of a photograph show the scene.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec2, UVec2};

use super::feather::feathered;
use super::picture::decode_grey;
use crate::StreamError;

/// Largest mask that is taken, in pixels.
const MAX_PIXELS: u64 = 1 << 28;

/// A mask at the size at which it is stored, which may differ from its photograph's.
#[derive(Debug)]
pub(crate) struct Mask {
    size: UVec2,
    shown: Vec<bool>,
    /// What [`Mask::alpha`] gave, by size: all photographs of a camera share it.
    alphas: Mutex<HashMap<UVec2, Arc<[u8]>>>,
}

/// The mask in `bytes`: what is at least half white shows the scene.
pub(crate) fn decode_mask(what: &str, bytes: &[u8]) -> Result<Mask, StreamError> {
    let (size, grey) = decode_grey(what, bytes, MAX_PIXELS)?;
    Ok(Mask::new(size, grey.into_iter().map(|value| value >= 128).collect()))
}

impl Mask {
    fn new(size: UVec2, shown: Vec<bool>) -> Self {
        Self { size, shown, alphas: Mutex::default() }
    }

    /// The alpha of an image of `size`, rows from the top: 0 where the mask hides the scene, and
    /// elsewhere how far inside the mask the pixel lies.
    pub(super) fn alpha(&self, size: UVec2) -> Arc<[u8]> {
        let kept = || self.alphas.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(alpha) = kept().get(&size) {
            return Arc::clone(alpha);
        }
        // Without the lock: other threads want other sizes.
        let shown: Vec<bool> = self.resampled(size).collect();
        let alpha: Arc<[u8]> = feathered(size, &shown).into();
        Arc::clone(kept().entry(size).or_insert(alpha))
    }

    /// Bytes that it takes, with all that it gave.
    pub(crate) fn bytes(&self) -> usize {
        let alphas = self.alphas.lock().unwrap_or_else(PoisonError::into_inner);
        self.shown.len() + alphas.values().map(|alpha| alpha.len()).sum::<usize>()
    }

    /// The mask for an image of `size`, rows from the top: a pixel shows the scene only where
    /// all that it covers of the mask does, so that a coarse level shows no sliver of what
    /// is hidden.
    fn resampled(&self, size: UVec2) -> impl Iterator<Item = bool> + '_ {
        (0..size.y).flat_map(move |y| {
            let rows = covered(y, size.y, self.size.y);
            (0..size.x).map(move |x| {
                let columns = covered(x, size.x, self.size.x);
                rows.clone().all(|row| {
                    let start = row * self.size.x as usize;
                    self.shown[start + columns.start..start + columns.end].iter().all(|&s| s)
                })
            })
        })
    }

    /// Whether the mask shows the scene at `position`, in units of the whole image.
    pub(super) fn shows(&self, position: DVec2) -> bool {
        let pixel = (position * self.size.as_dvec2()).as_uvec2().min(self.size - 1);
        self.shown[pixel.y as usize * self.size.x as usize + pixel.x as usize]
    }
}

/// The texels, of `to` in a row, that the pixel `index` of `from` in the same row covers; at
/// least one.
fn covered(index: u32, from: u32, to: u32) -> std::ops::Range<usize> {
    let (index, from, to) = (u64::from(index), u64::from(from.max(1)), u64::from(to));
    let start = (index * to / from).min(to.saturating_sub(1));
    let end = ((index + 1) * to).div_ceil(from).clamp(start + 1, to);
    start as usize..end as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(size: UVec2, shown: &[u8]) -> Mask {
        Mask::new(size, shown.iter().map(|&s| s == 1).collect())
    }

    #[test]
    fn a_coarser_level_hides_whatever_holds_a_hidden_texel() {
        let mask = mask(UVec2::new(3, 2), &[1, 1, 1, 1, 1, 0]);
        let at = |size| mask.resampled(size).map(u8::from).collect::<Vec<_>>();
        assert_eq!(at(UVec2::new(3, 2)), [1, 1, 1, 1, 1, 0]);
        // Three texels in two columns: the middle one belongs to both.
        assert_eq!(at(UVec2::new(2, 1)), [1, 0]);
        assert_eq!(at(UVec2::new(6, 2)), [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0]);
        assert_eq!(at(UVec2::new(1, 1)), [0]);
    }

    #[test]
    fn positions_at_the_border_stay_inside() {
        let mask = mask(UVec2::new(2, 1), &[1, 0]);
        assert!(mask.shows(DVec2::ZERO) && !mask.shows(DVec2::ONE));
        assert!(mask.shows(DVec2::new(-1e-9, 0.5)));
    }
}
