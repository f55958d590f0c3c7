//! Axes and marks of plots.

use std::fmt::Write;

use super::markup::Escaped;

/// Size of a plot, and of the area inside its axes, beside which half of a label has room; units that
/// become pixels on a narrow screen.
pub(super) const SIZE: [f64; 2] = [434.0, 300.0];
pub(super) const LEFT: f64 = 58.0;
pub(super) const RIGHT: f64 = 410.0;
pub(super) const TOP: f64 = 12.0;
pub(super) const BOTTOM: f64 = 252.0;
/// About so many lines cross an axis.
const TICKS: f64 = 6.0;
/// Colours of the page's style.
const COLOURS: usize = 8;

/// A range of values with round ends and a round step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

/// Draws both axes with their grid and names.
pub(super) fn axes(svg: &mut String, [across, up]: [&Axis; 2], names: [&str; 2]) {
    for tick in across.ticks() {
        let x = LEFT + across.share(tick) * (RIGHT - LEFT);
        let label = across.label(tick);
        let _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{x:.1} {TOP}V{BOTTOM}\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{label}</text>",
            BOTTOM + 16.0
        );
    }
    for tick in up.ticks() {
        let y = BOTTOM - up.share(tick) * (BOTTOM - TOP);
        let label = up.label(tick);
        let _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{RIGHT}\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">{label}</text>",
            LEFT - 6.0,
            y + 4.0
        );
    }
    let (middle, height) = (0.5 * (LEFT + RIGHT), 0.5 * (TOP + BOTTOM));
    let _ = writeln!(
        svg,
        "<path class=\"axis\" d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\"/><text x=\"{middle:.1}\" \
         y=\"{:.1}\" text-anchor=\"middle\">{}</text><text \
         transform=\"translate(14 {height:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        SIZE[1] - 10.0,
        Escaped(names[0]),
        Escaped(names[1])
    );
}

impl Axis {
    /// The narrowest axis that holds all values; from 0 to 1 where there are none.
    pub(super) fn new(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        if low > high {
            return Self { low: 0.0, high: 1.0, step: 0.2 };
        }
        // One value alone still needs a range.
        let rough = ((high - low) / TICKS).max(1e-3 * high.abs()).max(1e-3);
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * power).into_iter().find(|&step| step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        Self { low, high: if high > low { high } else { low + step }, step }
    }

    /// Where `value` lies between the ends, 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    pub(super) fn ticks(self) -> impl Iterator<Item = f64> {
        let count = ((self.high - self.low) / self.step).round() as u32;
        (0..=count).map(move |index| self.low + f64::from(index) * self.step)
    }

    pub(super) fn label(&self, tick: f64) -> String {
        let digits = (-self.step.log10().floor()).clamp(0.0, 9.0) as usize;
        // No minus before a zero that is one by rounding only.
        format!("{:.digits$}", if tick.abs() < 0.5 * self.step { 0.0 } else { tick })
    }
}

/// The colour of a series.
pub(super) fn colour(index: usize) -> String {
    format!("series c{}", index % COLOURS)
}

/// The mark of a method: shapes differ, too, for those who cannot tell the colours.
pub(super) fn mark(index: usize, [x, y]: [f64; 2]) -> String {
    match (index + index / COLOURS) % 4 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\"/>"),
        1 => format!("<path d=\"M{:.1} {:.1}h6v6h-6z\"/>", x - 3.0, y - 3.0),
        2 => format!("<path d=\"M{x:.1} {:.1}l4 7h-8z\"/>", y - 4.5),
        _ => format!("<path d=\"M{x:.1} {:.1}l4.5 4.5l-4.5 4.5l-4.5 -4.5z\"/>", y - 4.5),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_round_and_hold_their_values() {
        let axis = Axis::new([11.3, 17.9, 14.0].into_iter());
        assert_eq!(axis, Axis { low: 10.0, high: 18.0, step: 2.0 });
        assert_eq!(axis.ticks().collect::<Vec<_>>(), [10.0, 12.0, 14.0, 16.0, 18.0]);
        assert_eq!((axis.share(10.0), axis.share(18.0)), (0.0, 1.0));
        assert_eq!(axis.label(12.0), "12");
        let small = Axis::new([-0.013, 0.042].into_iter());
        assert_eq!(small.label(small.low), "-0.02");
        assert!(small.ticks().any(|tick| small.label(tick) == "0.00"));
    }

    #[test]
    fn an_axis_needs_neither_two_values_nor_one() {
        for values in [vec![], vec![0.0], vec![12.5, 12.5], vec![1e9], vec![-3.0]] {
            let axis = Axis::new(values.iter().copied());
            assert!(axis.high > axis.low && axis.ticks().count() < 12, "{values:?}: {axis:?}");
            assert!(values.iter().all(|&v| (0.0..=1.0).contains(&axis.share(v))), "{axis:?}");
        }
    }
}
