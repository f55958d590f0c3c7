//! A measurement of speed and error as a page.

use std::fmt::Write;

use super::axis::{Axis, BOTTOM, LEFT, RIGHT, SIZE, TOP, axes, colour, mark};
use super::markup::{Escaped, Figure};
use super::whole;
use crate::evaluation::speed::{Cost, Report, Row};

/// The page: frames, the plot of time against error, passes, and how costs grow.
pub(crate) fn speed_page(report: &Report) -> String {
    let described = &report.described;
    let title = format!("{} — speed against error", report.scene);
    let software = if report.software { ", a program on the processor" } else { "" };
    let body = format!(
        "<header><h1>{title}</h1>\n<p>{width}×{height} pixels, {views} views, each rendered \
         {repeats} times by every variant in turn. Adapter: {adapter}{software}; {cpus} processor \
         cores.</p></header>\n<section>\n<h2>Frames</h2>\n{legend}<div class=\"plots\">\n{plot}\
         </div>\n{frames}<p>Every variant changes one setting of the most exact one; its error is \
         the difference to the most exact frames, over all pixels of all views, the largest of the \
         three colours in 255ths; a pixel that no photograph colours where one should counts as \
         255. Held: what the renderer held on the device. Texturing leaves the alignment out: compare with \
         alignment off. Combined: several settings at once, down the way on which frame budgets choose; \
         budget: what those gave while the view moved, on views of their own. Shaded: no other is \
         both faster and nearer, by the root mean square. The line of the plot joins \
         them.</p>\n</section>\n<section>\n<h2>Passes</h2>\n{passes}<p>Median milliseconds, \
         each pass waited for before the next begins. Depth maps: those of all photographs in use, \
         drawn anew right after its settings were set. Depth: of the pixels that show a surface in both \
         frames.</p>\n</section>\n<section>\n<h2>What costs grow with</h2>\n{linearity}</section>\n\
         <footer><p>Default settings: <code>{settings}</code></p></footer>\n",
        title = Escaped(&title),
        width = described.width,
        height = described.height,
        views = described.views,
        repeats = described.repeats,
        adapter = Escaped(&report.adapter),
        cpus = report.cpus,
        legend = legend(report),
        plot = plot(report),
        frames = frames(report),
        passes = passes(report),
        linearity = linearity(report),
        settings = Escaped(&described.settings.to_string()),
    );
    whole(&title, &body)
}

/// The methods in the order of the rows.
fn methods(report: &Report) -> Vec<&'static str> {
    let mut methods: Vec<&'static str> = Vec::new();
    for row in report.frames() {
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    methods
}

fn legend(report: &Report) -> String {
    let mut html = "<ul class=\"legend\">\n".to_owned();
    for (index, method) in methods(report).into_iter().enumerate() {
        let _ = writeln!(
            html,
            "<li><svg viewBox=\"0 0 16 16\" width=\"16\" height=\"16\" aria-hidden=\"true\" \
             class=\"{}\">{}</svg>{}</li>",
            colour(index),
            mark(index, [8.0, 8.0]),
            Escaped(method)
        );
    }
    html.push_str("</ul>\n");
    html
}

/// Error against time, a mark a variant.
fn plot(report: &Report) -> String {
    let rows: Vec<&Row> = report.frames().filter(|row| row.error_rms.is_finite()).collect();
    let across = Axis::new(rows.iter().map(|row| row.ms_median).chain([0.0]));
    let up = Axis::new(rows.iter().map(|row| row.error_rms).chain([0.0]));
    let place = |row: &Row| {
        [
            LEFT + across.share(row.ms_median) * (RIGHT - LEFT),
            BOTTOM - up.share(row.error_rms) * (BOTTOM - TOP),
        ]
    };
    let mut svg = format!(
        "<figure class=\"plot\"><figcaption>Root mean square error against \
         time</figcaption>\n<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"error against \
         time\">\n",
        SIZE[0], SIZE[1]
    );
    axes(&mut svg, [&across, &up], ["median of a frame, ms", "error, 1/255"]);
    let mut front: Vec<&&Row> = rows.iter().filter(|row| row.front).collect();
    front.sort_by(|a, b| a.ms_median.total_cmp(&b.ms_median));
    let points: Vec<String> =
        front.into_iter().map(|row| place(row)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(svg, "<polyline class=\"front\" points=\"{}\"/>", points.join(" "));
    for (index, method) in methods(report).into_iter().enumerate() {
        let _ = writeln!(svg, "<g class=\"{}\">", colour(index));
        for row in rows.iter().filter(|row| row.method == method) {
            let _ = writeln!(
                svg,
                "<g>{}<title>{}: {} ms, {}</title></g>",
                mark(index, place(row)),
                Escaped(&Row::label(row.method, &row.setting)),
                Figure(row.ms_median, 1),
                Figure(row.error_rms, 2)
            );
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg></figure>\n");
    svg
}

fn frames(report: &Report) -> String {
    let mut html = "<div class=\"scroll\"><table>\n<thead><tr><th>Method</th><th>Median, \
                    ms</th><th>95 %, ms</th><th>RMS error, 1/255</th><th>99 %, 1/255</th>\
                    <th>Largest, 1/255</th><th>Uncovered, %</th><th>Held, MB</th><th>Inputs</th><th>Within a fifth, \
                    %</th></tr></thead>\n<tbody>\n"
        .to_owned();
    for row in report.frames() {
        let class = if row.front { " class=\"best\"" } else { "" };
        let _ = writeln!(
            html,
            "<tr><th>{}</th><td{class}>{}</td><td>{}</td><td{class}>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            Escaped(&Row::label(row.method, &row.setting)),
            Figure(row.ms_median, 1),
            Figure(row.ms_p95, 1),
            Figure(row.error_rms, 2),
            Figure(row.error_p99, 0),
            Figure(row.error_max, 0),
            Figure(100.0 * row.uncovered, 2),
            Figure(row.bytes.map_or(f64::NAN, |bytes| bytes as f64 / 1e6), 0),
            Escaped(&row.inputs),
            row.within_fifth.map_or(String::new(), |share| Figure(100.0 * share, 0).to_string())
        );
    }
    html.push_str("</tbody></table></div>\n");
    html
}

/// A row a variant, a column a pass; then how far its geometry is off.
fn passes(report: &Report) -> String {
    let mut columns: Vec<&'static str> = Vec::new();
    for row in report.rows.iter().filter(|row| row.pass != Row::FRAME) {
        if !columns.contains(&row.pass) {
            columns.push(row.pass);
        }
    }
    let mut html = "<div class=\"scroll\"><table>\n<thead><tr><th>Method</th>".to_owned();
    for column in &columns {
        let _ = write!(html, "<th>{}</th>", Escaped(column));
    }
    html.push_str("<th>Depth, 99 %, m</th><th>Unmatched, %</th></tr></thead>\n<tbody>\n");
    for frame in report.frames() {
        let of = |pass: &str| {
            report.rows.iter().find(|row| {
                row.pass == pass && row.method == frame.method && row.setting == frame.setting
            })
        };
        let _ = write!(html, "<tr><th>{}</th>", Escaped(&Row::label(frame.method, &frame.setting)));
        for column in &columns {
            let ms = of(column).map_or(f64::NAN, |row| row.ms_median);
            let _ = write!(html, "<td>{}</td>", Figure(ms, 1));
        }
        let depth_m = of("surface").map_or(f64::NAN, |row| row.error_p99);
        let _ = writeln!(
            html,
            "<td>{}</td><td>{}</td></tr>",
            Figure(depth_m, 3),
            Figure(100.0 * frame.unmatched, 2)
        );
    }
    html.push_str("</tbody></table></div>\n");
    html
}

fn linearity(report: &Report) -> String {
    let linearity = &report.linearity;
    let mut html = String::new();
    costs(&mut html, "Points pass", "Points", &linearity.points, linearity.points_line);
    costs(
        &mut html,
        "Photographs pass",
        "Photographs",
        &linearity.textures,
        linearity.textures_line,
    );
    html.push_str(
        "<h3>More that is not on screen</h3>\n<div class=\"scroll\"><table>\n<thead><tr>\
         <th>Resident</th><th>Points</th><th>Photographs</th><th>Points drawn</th>\
         <th>Photographs drawn</th><th>Frame, ms</th></tr></thead>\n<tbody>\n",
    );
    for row in &linearity.off_screen {
        let inputs = &row.inputs;
        let _ = writeln!(
            html,
            "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            Escaped(row.resident),
            Figure(inputs.points, 0),
            Figure(inputs.images, 0),
            Figure(inputs.points_drawn, 0),
            Figure(inputs.images_drawn, 0),
            Figure(row.ms, 1)
        );
    }
    html.push_str("</tbody></table></div>\n");
    html
}

fn costs(html: &mut String, title: &str, what: &str, costs: &[Cost], line: Option<[f64; 3]>) {
    let _ = write!(
        html,
        "<h3>{title}</h3>\n<div class=\"scroll\"><table>\n<thead><tr><th>Setting</th>\
         <th>{what} drawn</th><th>Median, ms</th></tr></thead>\n<tbody>\n"
    );
    for cost in costs {
        let _ = writeln!(
            html,
            "<tr><th>{}</th><td>{}</td><td>{}</td></tr>",
            Escaped(&cost.setting),
            Figure(cost.amount, 0),
            Figure(cost.ms, 2)
        );
    }
    html.push_str("</tbody></table></div>\n");
    if let Some([at_nothing, each, explained]) = line {
        let _ = writeln!(
            html,
            "<p>A line through them: {} ms, and {} µs each; it explains {} % of the variance.</p>",
            Figure(at_nothing, 2),
            Figure(1e3 * each, 4),
            Figure(100.0 * explained, 1)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::StatedSettings;
    use crate::evaluation::page::tests::assert_elements_close;
    use crate::evaluation::speed::{Described, Inputs, Linearity, Unit};
    use crate::memory::HeldMemory;

    fn row(pass: &'static str, setting: &str, ms: f64, error: f64) -> Row {
        Row {
            pass,
            method: "rigs",
            setting: setting.to_owned(),
            ms_median: ms,
            ms_p95: 2.0 * ms,
            error_max: 2.0 * error,
            error_p99: error,
            error_rms: error,
            error_unit: Unit::Colour,
            uncovered: 0.0,
            unmatched: 0.0,
            inputs: "3 points".to_owned(),
            counts: Inputs::default(),
            bytes: Some(5_000_000),
            front: false,
            within_fifth: None,
            late: None,
        }
    }

    #[test]
    fn a_page_holds_plot_and_tables() {
        let mut rows = vec![
            row("frame", "1", 10.0, 20.0),
            row("mesh", "1", 2.0, f64::NAN),
            row("frame", "<8>", 30.0, 4.0),
            row("frame", "9", 40.0, 5.0),
        ];
        Report::mark_front(&mut rows);
        let report = Report {
            scene: "<s>".into(),
            adapter: "\"card\"".into(),
            software: true,
            cpus: 4,
            described: Described {
                width: 64,
                height: 32,
                views: 2,
                repeats: 3,
                settings: StatedSettings(flaneur_renderer::Settings::default()),
            },
            memory: HeldMemory::default(),
            front: Vec::new(),
            rows,
            linearity: Linearity::default(),
        };
        let html = speed_page(&report);
        assert_elements_close(&html);
        assert!(html.contains("<h1>&lt;s&gt; — speed against error</h1>"));
        assert!(html.contains("&quot;card&quot;, a program on the processor; 4 processor cores"));
        assert_eq!(html.matches("class=\"best\"").count(), 4, "two rows are on the front");
        assert_eq!(html.matches("</title></g>").count(), 3, "a mark a variant");
        let json = serde_json::to_value(&report).expect("JSON");
        assert_eq!(json["rows"][0]["front"], true);
        assert_eq!(json["rows"][1]["front"], false);
        assert_eq!(json["rows"][3]["front"], false);
        assert!(json["rows"][1]["error_p99"].is_null());
        assert_eq!(json["rows"][0]["error_unit"], "1/255");
        assert_eq!((&json["width"], &json["adapter"]), (&64.into(), &"\"card\"".into()));
    }
}
