//! How costs grow with what is drawn.

use super::tally::Tally;
use crate::evaluation::speed::{
    Cost, Feed, Inputs, Linearity, OffScreen, Row, Variant, line_through,
};

/// How the points pass grows with points, the photographs pass with photographs, and the frame with
/// what it does not show.
pub(super) fn linearity(variants: &[Variant], tallies: &[Tally]) -> Linearity {
    let all = || variants.iter().zip(tallies);
    let costs = |method: &'static str, pass: &str, amount: fn(&Inputs) -> f64| -> Vec<Cost> {
        all()
            .filter(|(variant, _)| variant.method == method || variant.method == "most exact")
            .filter_map(|(variant, tally)| {
                let setting = variant.to_string();
                let amount = amount(&Inputs::mean(&tally.stats));
                Some(Cost { setting, amount, ms: tally.median_ms(pass)? })
            })
            .collect()
    };
    let points = costs("points", "points", |inputs| inputs.points_drawn);
    let textures = costs("rigs", "photographs", |inputs| inputs.images_drawn);
    let off_screen = all().filter(|(variant, _)| variant.method == "default");
    let off_screen = off_screen.filter_map(|(variant, tally)| {
        let resident = match variant.feed {
            Feed::AndBehind => "what lies behind the eye, too",
            _ => "what the view wants",
        };
        let inputs = Inputs::mean(&tally.stats);
        Some(OffScreen { resident, inputs, ms: tally.median_ms(Row::FRAME)? })
    });
    Linearity {
        points_line: line_through(&points),
        textures_line: line_through(&textures),
        off_screen: off_screen.collect(),
        points,
        textures,
    }
}
