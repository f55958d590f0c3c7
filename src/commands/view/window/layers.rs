//! What can be shown, in the order of the keys 1 to 9: the web page's.

use flaneur_renderer::Mode;

/// All of them.
pub(super) const LAYERS: [Mode; 9] = [
    Mode::Hybrid,
    Mode::Mesh,
    Mode::Points,
    Mode::Sources,
    Mode::Uncertainty,
    Mode::PointsColour,
    Mode::Wireframe,
    Mode::Depth,
    Mode::Normals,
];

/// What people call one, and what it shows.
pub(super) fn words(mode: Mode) -> &'static str {
    match mode {
        Mode::Hybrid => "Street: mesh and points, coloured by the photographs",
        Mode::Mesh => "Mesh alone, coloured by the photographs",
        Mode::Points => "Points alone, coloured by the photographs",
        Mode::Sources => "Sources: each photograph has a colour of its own",
        Mode::Uncertainty => "Uncertainty: green 1 cm, yellow 10 cm, red 1 m; violet: inferred",
        Mode::PointsColour => "Point colours: the points in their own colours",
        Mode::Wireframe => "Wireframe: no photographs, and the edges of the mesh",
        Mode::Depth => "Depth along the line of sight: white is near",
        Mode::Normals => "Normals: which way surfaces face",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_the_web_page_s() {
        let page = include_str!("../../../../services/web/src/state/layer.ts");
        let names = page.lines().filter_map(|line| line.split_once(": Mode.")?.1.strip_suffix(','));
        let upper = |mode: Mode| mode.name().replace('-', "_").to_uppercase();
        assert!(names.eq(LAYERS.map(upper)), "the page has others, or another order");
    }
}
