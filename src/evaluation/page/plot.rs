//! Figures against the distance to the nearest source, as inline SVG.

use std::fmt::Write;

use super::axis::{Axis, BOTTOM, LEFT, RIGHT, SIZE, TOP, axes, colour, mark};
use super::markup::{Escaped, Figure};
use crate::evaluation::{Bin, Report, Row};

/// What is plotted.
pub(super) struct Plot {
    /// What stands above it.
    pub(super) title: &'static str,
    /// What stands beside its vertical axis, with its unit.
    pub(super) axis: &'static str,
    /// The figure.
    pub(super) figure: fn(&Row) -> f64,
    /// Digits after the point.
    pub(super) digits: usize,
}

/// The methods with their marks.
pub(super) fn legend(report: &Report) -> String {
    let mut html = "<ul class=\"legend\">\n".to_owned();
    for (index, (method, _)) in report.mean.iter().enumerate() {
        let mark = mark(index, [8.0, 8.0]);
        let _ = writeln!(
            html,
            "<li><svg viewBox=\"0 0 16 16\" width=\"16\" height=\"16\" aria-hidden=\"true\" \
             class=\"{}\">{mark}</svg>{}</li>",
            colour(index),
            Escaped(method)
        );
    }
    html.push_str("</ul>\n");
    html
}

impl Plot {
    /// The figure element; a mark a view and method, and for each method a line through the means
    /// of the disjoint bins where there are several.
    pub(super) fn svg(&self, report: &Report) -> String {
        let known = |row: &&Row| (self.figure)(row).is_finite();
        let rows: Vec<&Row> = report.views.iter().filter(known).collect();
        let across = Axis::new(rows.iter().map(|row| row.nearest_m));
        let up = Axis::new(rows.iter().map(|row| (self.figure)(row)));
        let place = |distance_m: f64, value: f64| {
            [
                LEFT + across.share(distance_m) * (RIGHT - LEFT),
                BOTTOM - up.share(value) * (BOTTOM - TOP),
            ]
        };
        let mut svg = format!(
            "<figure class=\"plot\"><figcaption>{}</figcaption>\n<svg viewBox=\"0 0 {} {}\" \
             role=\"img\" aria-label=\"{} against distance to the nearest source\">\n",
            self.title, SIZE[0], SIZE[1], self.title
        );
        axes(&mut svg, [&across, &up], ["distance to the nearest source, m", self.axis]);
        for (index, (method, _)) in report.mean.iter().enumerate() {
            let _ = writeln!(svg, "<g class=\"{}\">", colour(index));
            let of_method: Vec<&Row> =
                rows.iter().copied().filter(|row| row.method == *method).collect();
            let line: Vec<[f64; 2]> = Bin::disjoint()
                .filter_map(|bin| {
                    let inside = of_method.iter().filter(|row| bin.holds(row.nearest_m));
                    let count = inside.clone().count() as f64;
                    let mean = |of: &dyn Fn(&Row) -> f64| {
                        inside.clone().map(|row| of(row)).sum::<f64>() / count
                    };
                    (count > 0.0).then(|| place(mean(&|row| row.nearest_m), mean(&self.figure)))
                })
                .collect();
            if line.len() > 1 {
                let points: Vec<_> = line.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
                let _ = writeln!(svg, "<polyline points=\"{}\"/>", points.join(" "));
            }
            for row in of_method {
                let value = (self.figure)(row);
                let _ = writeln!(
                    svg,
                    "<g>{}<title>{}, {method}: {} at {} m</title></g>",
                    mark(index, place(row.nearest_m, value)),
                    Escaped(&row.id),
                    Figure(value, self.digits),
                    Figure(row.nearest_m, 2)
                );
            }
            svg.push_str("</g>\n");
        }
        svg.push_str("</svg></figure>\n");
        svg
    }
}
