//! An evaluation as one HTML page that needs no other file and no network.

mod axis;
mod gallery;
mod markup;
mod plot;
mod speed;
mod table;
mod walk;

use super::Report;
pub(crate) use gallery::Gallery;
use markup::{Escaped, Figure};
use plot::Plot;
pub(crate) use speed::speed_page;
pub(crate) use walk::walk_page;

const STYLE: &str = include_str!("page.css");

const PLOTS: [Plot; 2] = [
    Plot { title: "PSNR", axis: "PSNR, dB", figure: |row| row.score.psnr_db, digits: 2 },
    Plot { title: "SSIM", axis: "SSIM", figure: |row| row.score.ssim, digits: 3 },
];

/// The page: means, plots against distance, and the pictures of `gallery`.
pub(crate) fn page(report: &Report, gallery: &Gallery) -> String {
    let settings = &report.settings;
    let title = format!("{} — evaluation", report.scene);
    let adapter = report.adapter.as_deref().unwrap_or("none needed");
    let mut protocol = settings.held_out.clone();
    if !settings.only.is_empty() {
        protocol += &format!(" --only {}", settings.only.join(" "));
    }
    let masked = report.mean.first().map_or(f64::NAN, |(_, score)| 100.0 * score.masked);
    let plots: String = PLOTS.iter().map(|plot| plot.svg(report)).collect();
    let body = format!(
        "<header><h1>{title}</h1>\n<p>{targets} \
         views rendered from {sources} photographs: <code>{protocol}</code>. Adapter: \
         {adapter}.</p></header>\n<section>\n<h2>Means over all views</h2>\n{means}<p>sRGB in 0 to 1, \
         the whole frame, a figure a view and then the mean. SSIM in windows of 7×7 pixels of equal \
         weight with sample covariance. Coverage: the share of the pixels showing geometry that a \
         source colours; none for a source shown unwarped. Inferred: the share of all pixels that \
         sources colour at an inferred depth, where there is no geometry. Unseen: the share of all \
         pixels that no source colours, on geometry or at an inferred depth. Unmasked: over what \
         the photograph’s mask shows (it hides {masked} % of the pixels). Covered: over what of that \
         is not unseen.</p>\n</section>\n<section>\n<h2>By distance to \
         the nearest source</h2>\n{bins}{legend}<div class=\"plots\">\n{plots}</div>\n<p>A mark is a \
         view; lines join the means of the bins that do not overlap. Views without a value \
         are left out.</p>\n</section>\n{gallery}<footer><p>Renderer: <code>{renderer}</code></p></footer>\n",
        title = Escaped(&title),
        targets = settings.targets,
        sources = settings.sources,
        protocol = Escaped(&protocol),
        adapter = Escaped(adapter),
        means = table::means(report),
        masked = Figure(masked, 1),
        bins = table::bins(report),
        legend = plot::legend(report),
        gallery = gallery.html(),
        renderer = Escaped(&settings.renderer.to_string()),
    );
    whole(&title, &body)
}

/// A page of that title, which is text, and of that body, which is markup.
fn whole(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
         name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n",
        title = Escaped(title),
    )
}

#[cfg(test)]
mod tests;
