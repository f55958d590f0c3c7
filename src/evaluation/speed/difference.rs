//! How far frames are from others.

use flaneur_renderer::Frame;

use crate::evaluation::compared::is_covered;

/// Differences of many pixels, of several frames together, as a histogram: what it takes does not
/// grow with them.
#[derive(Clone, Debug)]
pub(crate) struct Difference {
    /// Pixels for each difference of a colour, 255ths.
    colours: Vec<u64>,
    /// Pixels that photographs colour in the exact frame alone.
    uncovered: u64,
    /// Pixels for each step of a difference of depth.
    depths: Vec<u64>,
    max_m: f64,
    /// Pixels that show a surface in one frame alone.
    unmatched: u64,
}

/// Steps of depth an octave: a percentile is off by less than 5 %.
const STEPS: f64 = 16.0;
/// Differences below this are none, metres.
const LEAST_M: f64 = 1e-6;
/// Octaves from there: up to 70 km.
const OCTAVES: f64 = 36.0;

impl Default for Difference {
    fn default() -> Self {
        let steps = (STEPS * OCTAVES) as usize + 2;
        Self {
            colours: vec![0; 256],
            uncovered: 0,
            depths: vec![0; steps],
            max_m: 0.0,
            unmatched: 0,
        }
    }
}

impl Difference {
    /// Adds the pixels of two pictures of one size: the largest difference among the three colours
    /// of each. A pixel that no photograph colours where one should is as wrong as can be.
    pub(crate) fn add_colours(&mut self, frame: &Frame, exact: &Frame) {
        let colours = frame.rgba.chunks_exact(4).zip(exact.rgba.chunks_exact(4));
        for ((a, b), surfaces) in colours.zip(frame.surfaces.iter().zip(&exact.surfaces)) {
            let uncovered = !is_covered(*surfaces.0) && is_covered(*surfaces.1);
            self.uncovered += u64::from(uncovered);
            let difference = a.iter().zip(b).take(3).map(|(a, b)| a.abs_diff(*b)).max();
            let difference = if uncovered { 255 } else { difference.unwrap_or(0) };
            if let Some(count) = self.colours.get_mut(usize::from(difference)) {
                *count += 1;
            }
        }
    }

    /// The mean of the squared differences of colours, 255ths squared; `None` without pixels.
    pub(crate) fn mean_squared_255(&self) -> Option<f64> {
        let pixels: u64 = self.colours.iter().sum();
        let squares = self.colours.iter().zip(0u64..).map(|(count, d)| count * d * d);
        (pixels > 0).then(|| squares.sum::<u64>() as f64 / pixels as f64)
    }

    /// Share of all pixels that photographs colour in the exact frame alone.
    pub(crate) fn uncovered_share(&self) -> f64 {
        let pixels: u64 = self.colours.iter().sum();
        self.uncovered as f64 / pixels.max(1) as f64
    }

    /// Adds the depths of two frames, metres.
    pub(crate) fn add_depths(&mut self, depths: &[Option<f32>], exact: &[Option<f32>]) {
        for pair in depths.iter().zip(exact) {
            match pair {
                (Some(a), Some(b)) => {
                    let off_m = f64::from((a - b).abs());
                    self.max_m = self.max_m.max(off_m);
                    let step = (1.0 + STEPS * (off_m / LEAST_M).log2()).max(0.0) as usize;
                    let last = self.depths.len() - 1;
                    if let Some(count) = self.depths.get_mut(step.min(last)) {
                        *count += 1;
                    }
                }
                (None, None) => {}
                _ => self.unmatched += 1,
            }
        }
    }

    /// The largest difference of a colour, and the one that 99 % of the pixels do not exceed,
    /// 255ths; `None` where there are no pixels.
    pub(crate) fn colours_255(&self) -> Option<[f64; 2]> {
        let max = self.colours.iter().rposition(|&count| count > 0)?;
        Some([max as f64, rank_99(&self.colours) as f64])
    }

    /// The same of depth, metres, where both frames show a surface; the second within 5 %.
    pub(crate) fn depths_m(&self) -> Option<[f64; 2]> {
        self.depths.iter().rposition(|&count| count > 0)?;
        let p99 = match rank_99(&self.depths) {
            0 => 0.0,
            step => LEAST_M * ((step as f64) / STEPS).exp2(),
        };
        Some([self.max_m, p99.min(self.max_m)])
    }

    /// Share of the pixels that show a surface in one of the frames alone, of those that do in
    /// either.
    pub(crate) fn unmatched_share(&self) -> f64 {
        let matched: u64 = self.depths.iter().sum();
        let all = matched + self.unmatched;
        if all == 0 { 0.0 } else { self.unmatched as f64 / all as f64 }
    }
}

/// The first index at which the counts reach 99 % of their sum.
fn rank_99(counts: &[u64]) -> usize {
    let all: u64 = counts.iter().sum();
    let wanted = (all * 99).div_ceil(100);
    let mut sum = 0;
    counts
        .iter()
        .position(|count| {
            sum += count;
            sum >= wanted
        })
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_renderer::Surface;

    #[test]
    fn colours_are_compared_channel_by_channel() {
        let mut difference = Difference::default();
        assert_eq!(difference.colours_255(), None);
        let exact = frame([100u8, 100, 100, 255].repeat(1000));
        let mut other = exact.clone();
        for pixel in 0..9 {
            other.rgba[4 * pixel + 1] = 90;
        }
        other.rgba[4 * 500] = 3;
        other.rgba[4 * 600 + 3] = 0;
        difference.add_colours(&other, &exact);
        assert_eq!(difference.colours_255(), Some([97.0, 0.0]), "10 of 1000 are within 1 %");
        let squares = f64::from(9 * 10 * 10 + 97 * 97);
        assert!((difference.mean_squared_255().expect("pixels") - squares / 1e3).abs() < 1e-9);
        other.rgba[4 * 20 + 2] = 105;
        difference.add_colours(&other, &exact);
        assert_eq!(difference.colours_255(), Some([97.0, 5.0]));
    }

    #[test]
    fn what_is_not_covered_is_as_wrong_as_can_be() {
        let exact = frame([100u8, 100, 100, 255].repeat(100));
        let mut other = exact.clone();
        other.surfaces[3] = Surface::PointUncoloured;
        other.surfaces[4] = Surface::Background;
        other.surfaces[5] = Surface::Inferred;
        let mut difference = Difference::default();
        difference.add_colours(&other, &exact);
        assert_eq!(difference.uncovered_share(), 0.02);
        assert_eq!(difference.colours_255(), Some([255.0, 255.0]));
        let mut reverse = Difference::default();
        reverse.add_colours(&exact, &other);
        assert_eq!(reverse.uncovered_share(), 0.0, "more than the exact frame shows is no fault");
    }

    fn frame(rgba: Vec<u8>) -> Frame {
        let pixels = rgba.len() / 4;
        Frame {
            size: glam::UVec2::new(pixels as u32, 1),
            rgba,
            surfaces: vec![Surface::MeshColoured; pixels],
            stats: flaneur_renderer::FrameStats::default(),
        }
    }

    #[test]
    fn depths_are_compared_where_there_are_two() {
        let mut difference = Difference::default();
        assert_eq!((difference.depths_m(), difference.unmatched_share()), (None, 0.0));
        let exact = vec![Some(20.0f32); 200];
        let mut depths = exact.clone();
        depths[0] = None;
        depths[1] = Some(25.0);
        for depth in depths.iter_mut().skip(100).take(50) {
            *depth = Some(20.25);
        }
        difference.add_depths(&depths, &exact);
        let [max, p99] = difference.depths_m().expect("pixels");
        assert_eq!(max, 5.0);
        assert!((p99 / 0.25 - 1.0).abs() < 0.05, "{p99}");
        assert_eq!(difference.unmatched_share(), 0.005);
        let mut same = Difference::default();
        same.add_depths(&exact, &exact);
        assert_eq!(same.depths_m(), Some([0.0, 0.0]));
        let mut far = Difference::default();
        far.add_depths(&[Some(f32::MAX)], &[Some(1.0)]);
        assert!(far.depths_m().is_some_and(|[max, _]| max > 1e30));
    }
}
