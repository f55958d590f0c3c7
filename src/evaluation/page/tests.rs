//! The page of a small evaluation.

use super::*;
use crate::evaluation::{Compared, Described, Method, Row, Score, StatedSettings};
use crate::memory::HeldMemory;

fn grey(value: u8) -> Compared {
    Compared::whole(image::RgbImage::from_pixel(8, 8, image::Rgb([value; 3])))
}

/// Two views with names that are no markup, one method.
fn report() -> (Report, Gallery) {
    let method = Method::named("hybrid").expect("in the table");
    let mut gallery = Gallery::new(2, 1);
    let mut rows = Vec::new();
    for (index, (id, nearest_m, value)) in
        [("a<b>&'\"/1", 1.5, 110), ("c/1", 9.0, 100)].into_iter().enumerate()
    {
        let (photograph, rendering) = (grey(100), grey(value));
        let score = Score::new(&photograph, &rendering).expect("of one size");
        gallery.begin(index, id, nearest_m, &photograph).expect("encodable");
        gallery.add(index, (0, "hybrid"), &score, &photograph, &rendering).expect("encodable");
        rows.push(Row { id: id.to_owned(), nearest_m, method: "hybrid", score });
    }
    let settings = Described {
        held_out: "--hold-out <i>".into(),
        only: vec!["a*".into()],
        sources: 3,
        targets: 2,
        methods: vec!["hybrid"],
        renderer: StatedSettings(flaneur_renderer::Settings::default()),
    };
    let (adapter, memory) = (Some("\"card\"".into()), HeldMemory::default());
    let report = Report::new("<s>".into(), adapter, memory, settings, &[method], rows);
    (report, gallery)
}

#[test]
fn a_page_holds_tables_plots_and_pictures() {
    let (report, gallery) = report();
    let html = page(&report, &gallery);
    assert!(html.contains("<h1>&lt;s&gt; — evaluation</h1>") && html.contains("&quot;card&quot;"));
    for bin in ["0–2 m", "0–8 m", "8–16 m"] {
        assert!(html.contains(&format!("{bin}<br>")), "{bin} is in use");
    }
    assert_eq!(html.matches("<svg viewBox=\"0 0 434 300\"").count(), 2);
    // Equal pictures: in the tables, but not a mark that the PSNR's plot could hold.
    assert!(html.contains("∞"));
    assert_eq!(html.matches("<title>").count(), 1 + 1 + 2, "{html}");
    assert_eq!(html.matches("data:image/jpeg;base64,").count(), 6);
}

/// Whatever a name holds, the page has the same elements, all closed in their order, and asks
/// nothing of a network.
#[test]
fn names_leave_the_markup_whole() {
    let (report, gallery) = report();
    let html = page(&report, &gallery);
    assert!(!html.contains("<b>") && !html.contains("<i>") && !html.contains("<s>"));
    assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("<script"));
    assert_elements_close(&html);
}

/// All elements of a page's body are closed in their order.
pub(super) fn assert_elements_close(html: &str) {
    let body = html.split_once("</style>").expect("a style").1;
    let mut open: Vec<&str> = vec!["html", "head"];
    for tag in body.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a tag is closed");
        let name = tag.split([' ', '\n']).next().unwrap_or_default();
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "in {tag}"),
            None if tag.ends_with('/') || ["img", "br", "meta"].contains(&name) => {}
            None => open.push(name),
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}
