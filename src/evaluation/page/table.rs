//! Means as tables.

use std::fmt::Write;

use super::markup::{Escaped, Figure};
use crate::evaluation::{Report, Score};

/// A column: its heading, its figure, digits after the point, and whether more of it is better.
type Column = (&'static str, fn(&Score) -> f64, usize, bool);

const COLUMNS: [Column; 10] = [
    ("PSNR, dB", |s| s.psnr_db, 2, true),
    ("SSIM", |s| s.ssim, 3, true),
    ("RMSE", |s| s.rmse, 4, false),
    ("Coverage, %", |s| 100.0 * s.coverage, 1, true),
    ("Inferred, %", |s| 100.0 * s.inferred, 1, false),
    ("Unseen, %", |s| 100.0 * s.unseen, 1, false),
    ("PSNR unmasked, dB", |s| s.psnr_db_unmasked, 2, true),
    ("SSIM unmasked", |s| s.ssim_unmasked, 3, true),
    ("PSNR covered, dB", |s| s.psnr_db_covered, 2, true),
    ("SSIM covered", |s| s.ssim_covered, 3, true),
];

/// The means of all views: a row a method.
pub(super) fn means(report: &Report) -> String {
    let mut html = "<div class=\"scroll\"><table>\n<thead><tr><th>Method</th>".to_owned();
    for (heading, ..) in COLUMNS {
        let _ = write!(html, "<th>{heading}</th>");
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for (method, score) in &report.mean {
        let _ = write!(html, "<tr><th>{}</th>", Escaped(method));
        for (_, figure, digits, more_is_better) in COLUMNS {
            let sign = if more_is_better { 1.0 } else { -1.0 };
            let best = report.mean.iter().map(|(_, s)| sign * figure(s)).fold(f64::NAN, f64::max);
            cell(&mut html, figure(score), digits, sign * figure(score) >= best);
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n");
    html
}

/// The means of each bin: a row a method, PSNR and SSIM of each bin side by side.
pub(super) fn bins(report: &Report) -> String {
    let mut html =
        "<div class=\"scroll\"><table>\n<thead><tr><th rowspan=\"2\">Method</th>".to_owned();
    for bin in &report.bins {
        let views = if bin.views == 1 { "view" } else { "views" };
        let label = bin.bin.label();
        let _ =
            write!(html, "<th colspan=\"2\">{label}<br><small>{} {views}</small></th>", bin.views);
    }
    html.push_str("</tr>\n<tr>");
    for _ in &report.bins {
        html.push_str("<th>PSNR, dB</th><th>SSIM</th>");
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for (method, _) in &report.mean {
        let _ = write!(html, "<tr><th>{}</th>", Escaped(method));
        for bin in &report.bins {
            let scores = || bin.mean.iter().map(|(_, score)| score);
            let score = bin.mean.iter().find(|(name, _)| name == method).map(|(_, score)| score);
            for (_, figure, digits, _) in &COLUMNS[..2] {
                let best = scores().map(figure).fold(f64::NAN, f64::max);
                let value = score.map_or(f64::NAN, figure);
                cell(&mut html, value, *digits, value >= best);
            }
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n");
    html
}

fn cell(html: &mut String, value: f64, digits: usize, best: bool) {
    let class = if best { " class=\"best\"" } else { "" };
    let _ = write!(html, "<td{class}>{}</td>", Figure(value, digits));
}
