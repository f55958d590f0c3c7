//! Places of a photograph that can be found again in another one: corners, each with a small
//! patch of its surroundings.

use glam::{DVec2, UVec2};

/// Samples along each side of a patch, and the pixels between two of them.
const SIDE: usize = 8;
const STEP: usize = 2;
/// Samples of a patch.
pub(super) const SAMPLES: usize = SIDE * SIDE;
/// What a sample of a patch of unit length is multiplied by to be stored in eight bits.
const UNIT: f32 = 254.0;
/// Pixels from the border in which there is no corner: the patch, its blur, and the fit.
const BORDER: usize = SIDE * STEP / 2 + 3;
/// Pixels around a corner in which there is no other.
const ALONE: usize = 3;
/// Side of the cells that have as many corners each, pixels.
const CELL: usize = 96;
/// Half the side of the window over which gradients are summed.
const WINDOW: usize = 2;
/// Of the gradients around a corner the mean square along any direction is at least this,
/// (255ths a pixel)²: noise stays below.
const LEAST_RESPONSE: f32 = 6.0;
/// A patch whose samples differ by less than this (255ths, standard deviation) says nothing.
const LEAST_CONTRAST: f32 = 3.0;
/// Larger pictures are halved until they have at most so many pixels: corners of coarser pictures
/// last over longer ways.
const MOST_PIXELS: usize = 1 << 21;

/// A corner.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Corner {
    /// Where it is in the photograph as it was taken; the middle of its first pixel is (½, ½).
    pub(super) pixel: DVec2,
    /// Its surroundings, without their mean, of length 1 (times [`UNIT`]).
    patch: [i8; SAMPLES],
}

impl Corner {
    /// The correlation of two patches, −1 to 1.
    pub(super) fn likeness(&self, other: &Self) -> f32 {
        let sum: i32 =
            self.patch.iter().zip(&other.patch).map(|(a, b)| i32::from(*a) * i32::from(*b)).sum();
        sum as f32 / (UNIT * UNIT)
    }
}

/// Brightness of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grey {
    width: usize,
    height: usize,
    /// 0 to 255, row by row.
    values: Vec<f32>,
    /// Pixels of the photograph in one of these.
    scale: f64,
    /// Of the photograph.
    size: UVec2,
}

impl Grey {
    /// Of RGB samples, row by row.
    pub(super) fn of_rgb(size: UVec2, rgb: &[u8]) -> Self {
        let values = rgb
            .as_chunks::<3>()
            .0
            .iter()
            .map(|&[r, g, b]| 0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b))
            .collect();
        let mut grey =
            Self { width: size.x as usize, height: size.y as usize, values, scale: 1.0, size };
        while grey.values.len() > MOST_PIXELS {
            grey = grey.halved();
        }
        grey
    }

    fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let row = |y: usize| &self.values[y * self.width..][..2 * width];
        let values = (0..height)
            .flat_map(|y| {
                let pairs = |y| row(y).as_chunks::<2>().0.iter();
                let sums = pairs(2 * y).zip(pairs(2 * y + 1));
                sums.map(|(a, b)| 0.25 * (a[0] + a[1] + b[0] + b[1])).collect::<Vec<_>>()
            })
            .collect();
        Self { width, height, values, scale: 2.0 * self.scale, size: self.size }
    }

    /// Filtered along both sides by weights 1 4 6 4 1; borders repeat.
    fn blurred(&self) -> Self {
        let at =
            |index: usize, offset: usize, last: usize| (index + offset).saturating_sub(2).min(last);
        const WEIGHTS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
        let mut across = vec![0.0; self.values.len()];
        for (out, row) in across.chunks_mut(self.width).zip(self.values.chunks(self.width)) {
            for (x, out) in out.iter_mut().enumerate() {
                *out = (0..5).map(|k| WEIGHTS[k] * row[at(x, k, self.width - 1)]).sum();
            }
        }
        let mut values = vec![0.0; across.len()];
        for (y, out) in values.chunks_mut(self.width).enumerate() {
            for (k, weight) in WEIGHTS.iter().enumerate() {
                let row = &across[at(y, k, self.height - 1) * self.width..][..self.width];
                out.iter_mut().zip(row).for_each(|(out, value)| *out += weight * value);
            }
        }
        Self { values, ..*self }
    }

    /// Size of the photograph, pixels.
    pub(super) fn size(&self) -> UVec2 {
        self.size
    }

    /// The value at a share of width and height.
    pub(super) fn value(&self, share: DVec2) -> f32 {
        let index = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        self.at(index(share.x, self.width), index(share.y, self.height))
    }

    fn at(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.width + x]
    }

    /// Between the middles of four pixels; `x` and `y` are at least one pixel inside.
    fn between(&self, x: f32, y: f32) -> f32 {
        let (left, top) = (x.floor(), y.floor());
        let (u, v) = (x - left, y - top);
        let (left, top) = (left as usize, top as usize);
        let row = |y| (1.0 - u) * self.at(left, y) + u * self.at(left + 1, y);
        (1.0 - v) * row(top) + v * row(top + 1)
    }

    /// The corners where `is_shown` (a pixel of the photograph), at most about `most`, spread
    /// over the picture: the strongest of each cell of a grid, so that no tree takes all.
    pub(super) fn corners(&self, most: usize, is_shown: impl Fn(DVec2) -> bool) -> Vec<Corner> {
        if self.width <= 2 * BORDER || self.height <= 2 * BORDER || most == 0 {
            return Vec::new();
        }
        let smooth = self.blurred();
        let response = smooth.responses();
        let blurred = smooth.blurred();
        let mut found = Vec::new();
        let across = (self.width - 2 * BORDER).div_ceil(CELL);
        let down = (self.height - 2 * BORDER).div_ceil(CELL);
        let each = most.div_ceil(across * down);
        for top in (BORDER..self.height - BORDER).step_by(CELL) {
            for left in (BORDER..self.width - BORDER).step_by(CELL) {
                let rows = top..(top + CELL).min(self.height - BORDER);
                let columns = left..(left + CELL).min(self.width - BORDER);
                let places = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                let mut summits: Vec<(f32, usize, usize)> = places
                    .map(|(x, y)| (response[y * self.width + x], x, y))
                    .filter(|&(strength, x, y)| {
                        strength >= LEAST_RESPONSE && is_summit(&response, self.width, x, y)
                    })
                    .collect();
                summits.sort_by(|a, b| b.0.total_cmp(&a.0));
                for (_, x, y) in summits.into_iter().take(each) {
                    let place = summit(&response, self.width, x, y);
                    let pixel = (place.as_dvec2() + 0.5) * self.scale;
                    if !is_shown(pixel) {
                        continue;
                    }
                    if let Some(patch) = patch(&blurred, place) {
                        found.push(Corner { pixel, patch });
                    }
                }
            }
        }
        found
    }

    /// At each pixel the lesser eigenvalue of the mean of the gradients' outer products around.
    fn responses(&self) -> Vec<f32> {
        let (width, height) = (self.width, self.height);
        let mut products = vec![[0.0f32; 3]; self.values.len()];
        for y in 1..height - 1 {
            for x in 1..width - 1 {
                let dx = 0.5 * (self.at(x + 1, y) - self.at(x - 1, y));
                let dy = 0.5 * (self.at(x, y + 1) - self.at(x, y - 1));
                products[y * width + x] = [dx * dx, dx * dy, dy * dy];
            }
        }
        let count = ((2 * WINDOW + 1) * (2 * WINDOW + 1)) as f32;
        let mut rows = vec![[0.0f32; 3]; products.len()];
        for y in 0..height {
            for x in WINDOW..width - WINDOW {
                let window = &products[y * width + x - WINDOW..][..2 * WINDOW + 1];
                rows[y * width + x] = sum(window.iter());
            }
        }
        let mut responses = vec![0.0; products.len()];
        for y in WINDOW..height - WINDOW {
            for x in WINDOW..width - WINDOW {
                let column = (y - WINDOW..=y + WINDOW).map(|y| &rows[y * width + x]);
                let [xx, xy, yy] = sum(column).map(|value| value / count);
                let middle = 0.5 * (xx + yy);
                let half = 0.5 * (xx - yy);
                responses[y * width + x] = middle - (half * half + xy * xy).sqrt();
            }
        }
        responses
    }
}

fn sum<'a>(all: impl Iterator<Item = &'a [f32; 3]>) -> [f32; 3] {
    all.fold([0.0; 3], |s, p| [s[0] + p[0], s[1] + p[1], s[2] + p[2]])
}

/// Whether no place within [`ALONE`] pixels has a higher response; of equal ones the first wins.
fn is_summit(response: &[f32], width: usize, x: usize, y: usize) -> bool {
    let index = y * width + x;
    (y - ALONE..=y + ALONE).all(|v| {
        (v * width + x - ALONE..=v * width + x + ALONE).all(|other| {
            response[other] < response[index]
                || (response[other] == response[index] && other >= index)
        })
    })
}

/// Where the parabolas through the neighbours of a summit have theirs.
fn summit(response: &[f32], width: usize, x: usize, y: usize) -> glam::Vec2 {
    let at = |x: usize, y: usize| response[y * width + x];
    let here = at(x, y);
    let offset = |before: f32, after: f32| {
        let bend = before - 2.0 * here + after;
        if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 }
    };
    let across = offset(at(x - 1, y), at(x + 1, y));
    let down = offset(at(x, y - 1), at(x, y + 1));
    glam::Vec2::new(x as f32 + across, y as f32 + down)
}

/// The patch around a place (pixels' middles are whole), `None` where it is flat.
fn patch(blurred: &Grey, place: glam::Vec2) -> Option<[i8; SAMPLES]> {
    let first = -0.5 * ((SIDE - 1) * STEP) as f32;
    let mut samples = [0.0f32; SAMPLES];
    for (index, sample) in samples.iter_mut().enumerate() {
        let [x, y] = [index % SIDE, index / SIDE].map(|k| first + (k * STEP) as f32);
        *sample = blurred.between(place.x + x, place.y + y);
    }
    let mean = samples.iter().sum::<f32>() / SAMPLES as f32;
    samples.iter_mut().for_each(|sample| *sample -= mean);
    let length = samples.iter().map(|sample| sample * sample).sum::<f32>().sqrt();
    if length < LEAST_CONTRAST * (SAMPLES as f32).sqrt() {
        return None;
    }
    Some(samples.map(|sample| (UNIT * sample / length).round().clamp(-127.0, 127.0) as i8))
}
