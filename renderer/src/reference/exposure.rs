//! The factors on which photographs agree, as a frame shows them that follows no other.

use glam::{DVec2, DVec3, UVec2};

use super::photograph::Photograph;
use crate::gains::reference::{overlap, solved};
use crate::gains::{NEAR_M, measure};

/// A photograph, and how its rig stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exposed<'a, 'b> {
    pub(super) photograph: &'a Photograph<'b>,
    /// Squared distance from the eye to the nearest camera of the rig, metres.
    pub(super) nearest_2: f64,
    /// Share of its weight that the rig's place among the nearest leaves it.
    pub(super) rig_weight: f64,
}

/// The factors of the linear colours of each photograph. The weighted mean of their logarithms is
/// 0: the picture is as bright as the photographs near the eye.
pub(super) fn gains(photographs: &[Exposed<'_, '_>]) -> Vec<DVec3> {
    let logs = logs(photographs);
    let weights: Vec<f64> =
        photographs.iter().map(|p| p.rig_weight / (p.nearest_2 + NEAR_M * NEAR_M)).collect();
    let all: f64 = weights.iter().sum();
    let sum: DVec3 = logs.iter().zip(&weights).map(|(log, weight)| *log * *weight).sum();
    let level = if all > 0.0 { sum / all } else { DVec3::ZERO };
    logs.into_iter().map(|log| (log - level).map(f64::exp)).collect()
}

fn logs(photographs: &[Exposed<'_, '_>]) -> Vec<DVec3> {
    if photographs.len() < 2 {
        return vec![DVec3::ZERO; photographs.len()];
    }
    let [columns, rows] = measure::places(photographs.len());
    let shares = (0..rows * columns).map(|i| {
        let at = UVec2::new(i % columns, i / columns).as_dvec2() + 0.5;
        at / DVec2::new(columns.into(), rows.into())
    });
    let places: Vec<Vec<(DVec3, f64)>> = photographs
        .iter()
        .map(|by| shares.clone().filter_map(|share| by.photograph.lends(share)).collect())
        .collect();
    let mut overlaps = Vec::new();
    for b in 1..photographs.len() {
        for a in 0..b {
            let of_both = places[a].iter().chain(&places[b]).filter_map(|&(place, width_m)| {
                let shown = |i: usize| photographs[i].photograph.shows(place, width_m);
                Some([shown(a)?.to_array(), shown(b)?.to_array()])
            });
            overlaps.extend(overlap(a, b, &of_both.collect::<Vec<_>>()));
        }
    }
    solved(photographs.len(), &overlaps).into_iter().map(DVec3::from_array).collect()
}
