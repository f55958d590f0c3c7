//! The pictures of the page: small, lossy, and not of every view where there are many.

use std::collections::BTreeMap;
use std::fmt::Write;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::UVec2;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::FilterType;
use image::{ImageError, RgbImage};

use super::markup::{Escaped, Figure};
use crate::evaluation::{Compared, Score};

/// Longest side of a picture, pixels.
const SIDE: u32 = 400;
/// Quality of a picture: some 20 kB each.
const JPEG_QUALITY: u8 = 80;
/// Most pictures of a page, which bounds it to some 20 MB.
const MAX_PICTURES: usize = 600;

/// The views that are shown.
#[derive(Debug)]
pub(crate) struct Gallery {
    targets: usize,
    shown: usize,
    /// By their index.
    views: BTreeMap<usize, Shown>,
}

/// One view.
#[derive(Debug)]
struct Shown {
    id: String,
    nearest_m: f64,
    photograph: Thumbnail,
    /// By their place in the report: rendering, and difference.
    methods: BTreeMap<usize, (&'static str, Score, Thumbnail, Thumbnail)>,
}

/// A picture for the page.
#[derive(Debug)]
struct Thumbnail {
    jpeg: Vec<u8>,
    size: UVec2,
}

impl Gallery {
    /// An empty gallery for so many views and methods.
    pub(crate) fn new(targets: usize, methods: usize) -> Self {
        let shown = (MAX_PICTURES / (1 + 2 * methods)).clamp(1, targets.max(1));
        Self { targets, shown, views: BTreeMap::new() }
    }

    /// Begins the view `index`, where it is one of those shown, which are spread evenly, and not
    /// there yet.
    pub(crate) fn begin(
        &mut self,
        index: usize,
        id: &str,
        nearest_m: f64,
        photograph: &Compared,
    ) -> Result<(), ImageError> {
        if self.is_shown(index) && !self.views.contains_key(&index) {
            let photograph = Thumbnail::new(photograph.size, photograph.rgb.clone())?;
            let (id, methods) = (id.to_owned(), BTreeMap::new());
            self.views.insert(index, Shown { id, nearest_m, photograph, methods });
        }
        Ok(())
    }

    /// Adds a method's rendering of the view `index`, which was begun; methods may come in any
    /// order, each with its place among them.
    pub(crate) fn add(
        &mut self,
        index: usize,
        (place, method): (usize, &'static str),
        score: &Score,
        photograph: &Compared,
        rendering: &Compared,
    ) -> Result<(), ImageError> {
        if let Some(view) = self.views.get_mut(&index) {
            let pairs = photograph.rgb.iter().zip(&rendering.rgb);
            let difference = pairs.map(|(a, b)| a.abs_diff(*b)).collect();
            let rendering_of = Thumbnail::new(rendering.size, rendering.rgb.clone())?;
            let difference = Thumbnail::new(rendering.size, difference)?;
            view.methods.insert(place, (method, *score, rendering_of, difference));
        }
        Ok(())
    }

    fn is_shown(&self, index: usize) -> bool {
        index * self.shown / self.targets < (index + 1) * self.shown / self.targets
    }

    /// The section of the page.
    pub(super) fn html(&self) -> String {
        let mut html = format!(
            "<section>\n<h2>Pictures</h2>\n<p>{} of {} views, spread evenly. The pictures here are \
             reduced to at most {SIDE} pixels a side and are lossy JPEGs; the figures are of the \
             full ones. The difference is the absolute difference of each channel: black where \
             rendering and photograph agree.</p>\n",
            self.views.len(),
            self.targets
        );
        for (index, view) in self.views.values().enumerate() {
            view.write(&mut html, index == 0);
        }
        html.push_str("</section>\n");
        html
    }
}

impl Shown {
    fn write(&self, html: &mut String, open: bool) {
        let (id, size) = (Escaped(&self.id), self.photograph.size);
        let open = if open { " open" } else { "" };
        // The photograph is there once for all the methods that it stands beside.
        let _ = write!(
            html,
            "<details{open}>\n<summary>{id} <small>nearest source {} m</small></summary>\n<div \
             class=\"view\" style=\"--photograph:url({});--ratio:{}/{}\">\n",
            Figure(self.nearest_m, 2),
            self.photograph.uri(),
            size.x,
            size.y
        );
        for (method, score, rendering, difference) in self.methods.values() {
            let picture = |thumbnail: &Thumbnail, what: &str| {
                format!(
                    "<figure><img loading=\"lazy\" width=\"{}\" height=\"{}\" alt=\"{id}: {what}, \
                     {method}\" src=\"{}\"><figcaption>{what}</figcaption></figure>",
                    thumbnail.size.x,
                    thumbnail.size.y,
                    thumbnail.uri()
                )
            };
            let _ = writeln!(
                html,
                "<h3>{method} <small>{} dB, SSIM {}, unseen {} %</small></h3>\n<div \
                 class=\"triple\"><figure><div class=\"photograph\" role=\"img\" aria-label=\"{id}: \
                 photograph\"></div><figcaption>photograph</figcaption></figure>\n{}\n{}</div>",
                Figure(score.psnr_db, 2),
                Figure(score.ssim, 3),
                Figure(100.0 * score.unseen, 1),
                picture(rendering, "rendering"),
                picture(difference, "difference"),
            );
        }
        html.push_str("</div>\n</details>\n");
    }
}

impl Thumbnail {
    /// The picture of three bytes a pixel, reduced where it is larger than the page shows.
    fn new(size: UVec2, rgb: Vec<u8>) -> Result<Self, ImageError> {
        let mut picture = RgbImage::from_raw(size.x, size.y, rgb).unwrap_or_default();
        let longest = size.max_element();
        if longest > SIDE {
            let side = |side: u32| {
                let reduced = u64::from(side) * u64::from(SIDE) / u64::from(longest);
                u32::try_from(reduced).unwrap_or(SIDE).max(1)
            };
            picture =
                image::imageops::resize(&picture, side(size.x), side(size.y), FilterType::Triangle);
        }
        let mut jpeg = Vec::new();
        picture.write_with_encoder(JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY))?;
        Ok(Self { jpeg, size: UVec2::new(picture.width(), picture.height()) })
    }

    fn uri(&self) -> String {
        format!("data:image/jpeg;base64,{}", STANDARD.encode(&self.jpeg))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: UVec2) -> Compared {
        Compared::whole(RgbImage::from_pixel(size.x, size.y, image::Rgb([120; 3])))
    }

    #[test]
    fn many_views_are_thinned_evenly() {
        let gallery = Gallery::new(1000, 7);
        let shown: Vec<usize> = (0..1000).filter(|&index| gallery.is_shown(index)).collect();
        assert_eq!(shown.len(), 600 / 15);
        assert!(shown.windows(2).all(|pair| pair[1] - pair[0] == 25), "{shown:?}");
        let few = Gallery::new(3, 7);
        assert!((0..3).all(|index| few.is_shown(index)));
        assert!(Gallery::new(2, 1000).is_shown(1));
    }

    #[test]
    fn pictures_are_reduced_and_embedded() {
        let photograph = grey(UVec2::new(1200, 300));
        let score = Score::new(&photograph, &photograph).expect("of one size");
        let mut gallery = Gallery::new(1, 1);
        gallery.begin(0, "<a>/\"b\"", 1.25, &photograph).expect("encodable");
        // Methods come as they are rendered, and stand as they are reported.
        for (place, method) in [(1, "hybrid"), (0, "nearest")] {
            gallery.begin(0, "again", 1.0, &photograph).expect("encodable");
            gallery.add(0, (place, method), &score, &photograph, &photograph).expect("encodable");
        }
        let html = gallery.html();
        assert!(html.contains("&lt;a&gt;/&quot;b&quot;") && !html.contains("<a>"), "{html}");
        assert!(html.contains("width=\"400\" height=\"100\"") && html.contains("∞ dB"));
        assert_eq!(html.matches("data:image/jpeg;base64,").count(), 5);
        assert!(html.find("<h3>nearest") < html.find("<h3>hybrid") && !html.contains("again"));
        assert!(html.contains("1 of 1 views"));
    }
}
