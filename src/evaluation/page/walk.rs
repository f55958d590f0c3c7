//! A walk as a page.

use std::fmt::Write;

use super::axis::{Axis, BOTTOM, LEFT, RIGHT, SIZE, TOP, axes, colour, mark};
use super::markup::{Escaped, Figure};
use super::whole;
use crate::evaluation::walk::{Report, Sample};

/// What is plotted: its name with its unit, and the figure.
type Measure = (&'static str, fn(&Sample) -> f64, usize);

const ACROSS: [Measure; 2] = [
    ("megabytes received", |sample| sample.bytes as f64 / 1e6, 3),
    ("seconds since connecting began", |sample| sample.ms / 1e3, 2),
];
const UP: [Measure; 2] =
    [("SSIM", |sample| sample.ssim, 3), ("PSNR, dB", |sample| sample.psnr_db, 1)];

/// The page: quality against bytes and against time, and the figures.
pub(crate) fn walk_page(report: &Report) -> String {
    let asked = &report.settings;
    let title = format!("{} — walk", asked.scene);
    let plots: String = UP
        .iter()
        .enumerate()
        .flat_map(|(index, up)| ACROSS.map(|across| plot(&report.samples, index, across, *up)))
        .collect();
    let software = if report.machine.software { ", a program on the processor" } else { "" };
    let body = format!(
        "<header><h1>{title}</h1>\n<p>{width}×{height} pixels, a walk of {walk_s} s, {bandwidth}, \
         {latency} ms each way. Adapter: {adapter}{software}; {cpus} processor cores, which server, \
         streamer and renderer share.</p></header>\n<section>\n<h2>Figures</h2>\n{figures}\
         <p>Times since connecting began. Bytes of all messages received, without what HTTP/2 and TCP \
         add.</p>\n</section>\n<section>\n<h2>Quality</h2>\n<div class=\"plots\">\n{plots}</div>\n\
         <p>A mark is a frame that was on screen, compared with the same view fully loaded. A PSNR of \
         120 dB stands for equal pictures.</p>\n</section>\n<footer><p>Renderer: \
         <code>{renderer}</code></p></footer>\n",
        title = Escaped(&title),
        width = asked.width,
        height = asked.height,
        walk_s = Figure(asked.walk_s, 1),
        bandwidth = asked
            .bandwidth_bits_per_s
            .map_or("no limit of bandwidth".to_owned(), |bits| format!("{} Mbit/s", bits / 1e6)),
        latency = asked.latency_ms,
        adapter = Escaped(&report.machine.adapter),
        cpus = report.machine.cpus,
        figures = figures(report),
        renderer = Escaped(&asked.renderer.to_string()),
    );
    whole(&title, &body)
}

fn figures(report: &Report) -> String {
    let seconds = |ms: Option<f64>| Figure(ms.unwrap_or(f64::NAN) / 1e3, 2).to_string();
    let kilobytes = |bytes: Option<u64>| {
        Figure(bytes.map_or(f64::NAN, |bytes| bytes as f64 / 1e3), 0).to_string()
    };
    let rows = [
        ("First complete picture, s", seconds(report.first_picture_ms)),
        ("… for kB", kilobytes(report.first_picture_bytes)),
        ("SSIM of 0.90, s", seconds(report.ms_to_ssim_090)),
        ("SSIM of 0.95, s", seconds(report.ms_to_ssim_095)),
        ("Received in all, kB", kilobytes(Some(report.bytes))),
        ("… and wasted, kB", kilobytes(Some(report.bytes_wasted))),
        ("Found in caches, %", Figure(100.0 * report.cache_hit_rate, 1).to_string()),
        ("Requests", report.requests.to_string()),
        ("… and cancelled", report.cancelled.to_string()),
        ("Longest frame, s", seconds(report.longest_frame_ms)),
    ];
    let mut html = "<div class=\"scroll\"><table>\n<tbody>\n".to_owned();
    for (name, value) in rows {
        let _ = writeln!(html, "<tr><th>{name}</th><td>{value}</td></tr>");
    }
    html.push_str("</tbody></table></div>\n");
    html
}

/// One measure against another, a mark a sample.
fn plot(samples: &[Sample], index: usize, across: Measure, up: Measure) -> String {
    let ((x_name, x_of, x_digits), (y_name, y_of, y_digits)) = (across, up);
    let (x_axis, y_axis) =
        (Axis::new(samples.iter().map(x_of).chain([0.0])), Axis::new(samples.iter().map(y_of)));
    let place = |sample: &Sample| {
        [
            LEFT + x_axis.share(x_of(sample)) * (RIGHT - LEFT),
            BOTTOM - y_axis.share(y_of(sample)) * (BOTTOM - TOP),
        ]
    };
    let mut svg = format!(
        "<figure class=\"plot\"><figcaption>{y_name} against {x_name}</figcaption>\n<svg \
         viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{y_name} against {x_name}\">\n",
        SIZE[0], SIZE[1]
    );
    axes(&mut svg, [&x_axis, &y_axis], [x_name, y_name]);
    let points: Vec<String> =
        samples.iter().map(place).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<g class=\"{}\">\n<polyline points=\"{}\"/>",
        colour(index),
        points.join(" ")
    );
    for sample in samples {
        let _ = writeln!(
            svg,
            "<g>{}<title>{} {y_name} at {} {x_name}</title></g>",
            mark(index, place(sample)),
            Figure(y_of(sample), y_digits),
            Figure(x_of(sample), x_digits)
        );
    }
    svg.push_str("</g>\n</svg></figure>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::StatedSettings;
    use crate::evaluation::page::tests::assert_elements_close;
    use crate::evaluation::walk::{Asked, Machine, Profile};

    fn report(samples: Vec<Sample>) -> Report {
        Report {
            first_picture_ms: Some(640.0),
            first_picture_bytes: Some(123_456),
            ms_to_ssim_090: None,
            ms_to_ssim_095: None,
            bytes: 7_000_000,
            bytes_wasted: 350_000,
            cache_hit_rate: 0.25,
            requests: 12,
            cancelled: 3,
            longest_frame_ms: Some(250.0),
            samples,
            settings: Asked {
                scene: "<s>".to_owned(),
                bandwidth_bits_per_s: Some(1e7),
                latency_ms: 50.0,
                walk_s: 12.0,
                width: 64,
                height: 32,
                renderer: StatedSettings(flaneur_renderer::Settings::default()),
            },
            machine: Machine { adapter: "\"card\"".to_owned(), software: true, cpus: 4 },
            profile: Profile::default(),
        }
    }

    #[test]
    fn a_page_holds_figures_and_plots() {
        let sample = |ms: f64, ssim: f64| Sample { ms, bytes: 1000, ssim, psnr_db: 20.0 };
        let html = walk_page(&report(vec![sample(640.0, 0.5), sample(800.0, 0.75)]));
        assert_elements_close(&html);
        assert!(html.contains("<h1>&lt;s&gt; — walk</h1>") && html.contains("10 Mbit/s, 50 ms"));
        assert_eq!(html.matches("<figure").count(), 4, "each quality against bytes and time");
        assert_eq!(html.matches("</title></g>").count(), 8, "a mark a sample");
        assert!(html.contains("<th>First complete picture, s</th><td>0.64</td>"), "{html}");
        assert!(html.contains("<th>SSIM of 0.90, s</th><td>–</td>"));
        assert!(html.contains("<th>… and wasted, kB</th><td>350</td>"));
    }

    #[test]
    fn a_walk_without_a_picture_has_a_page_too() {
        assert_elements_close(&walk_page(&report(Vec::new())));
    }

    #[test]
    fn a_report_has_its_figures_at_the_top() {
        let json = serde_json::to_value(report(Vec::new())).expect("JSON");
        let keys: Vec<&String> = json.as_object().expect("an object").keys().collect();
        let figures = "first_picture_ms first_picture_bytes ms_to_ssim_090 ms_to_ssim_095 bytes \
                       bytes_wasted cache_hit_rate requests cancelled longest_frame_ms samples";
        let expected: Vec<&str> =
            figures.split_whitespace().chain(["settings", "machine", "profile"]).collect();
        assert_eq!(keys, expected);
    }
}
