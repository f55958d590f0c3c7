//! Views by their distance to the nearest source.

use serde::Serialize;

/// Where one bin ends and the next begins, metres.
const EDGES_M: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 24.0];

/// What is near as a whole; finer bins divide it.
const NEAR: Bin = Bin { from_m: 0.0, to_m: Some(8.0) };

/// A range of distances to the nearest source: the lower end belongs to it, the upper not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Bin {
    /// Lower end, metres.
    pub(crate) from_m: f64,
    /// Upper end, metres; `None` for all that lies beyond.
    pub(crate) to_m: Option<f64>,
}

impl Bin {
    /// All bins from near to far: those of [`Bin::disjoint`], and before the first that is farther
    /// [0 m, 8 m) as a whole.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let below = |bin: &Self| bin.to_m.is_some_and(|to_m| Some(to_m) <= NEAR.to_m);
        let near = Self::disjoint().filter(below);
        let far = Self::disjoint().filter(move |bin| !below(bin));
        near.chain(std::iter::once(NEAR)).chain(far)
    }

    /// Bins from near to far, each distance in one.
    pub(crate) fn disjoint() -> impl Iterator<Item = Self> {
        let lower = std::iter::once(0.0).chain(EDGES_M);
        let upper = EDGES_M.into_iter().map(Some).chain(std::iter::once(None));
        lower.zip(upper).map(|(from_m, to_m)| Self { from_m, to_m })
    }

    /// Whether `distance_m` lies in it.
    pub(crate) fn holds(&self, distance_m: f64) -> bool {
        distance_m >= self.from_m && self.to_m.is_none_or(|to_m| distance_m < to_m)
    }

    /// As people read it: `2–4 m`, `24 m or more`.
    pub(crate) fn label(&self) -> String {
        match self.to_m {
            Some(to_m) => format!("{}–{to_m} m", self.from_m),
            None => format!("{} m or more", self.from_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_distance_lies_in_one_disjoint_bin() {
        let bin = |distance_m| {
            let bins: Vec<_> = Bin::disjoint().filter(|bin| bin.holds(distance_m)).collect();
            let [bin] = bins[..] else { panic!("{distance_m}: {bins:?}") };
            bin.label()
        };
        for (distance_m, label) in [
            (0.0, "0–2 m"),
            (1.999, "0–2 m"),
            (2.0, "2–4 m"),
            (7.5, "4–8 m"),
            (8.0, "8–16 m"),
            (23.9, "16–24 m"),
            (24.0, "24 m or more"),
            (1e6, "24 m or more"),
        ] {
            assert_eq!(bin(distance_m), label, "{distance_m}");
        }
    }

    #[test]
    fn what_is_near_is_there_as_a_whole_too() {
        let labels: Vec<_> = Bin::all().map(|bin| bin.label()).collect();
        let expected = ["0–2 m", "2–4 m", "4–8 m", "0–8 m", "8–16 m", "16–24 m", "24 m or more"];
        assert_eq!(labels, expected);
        for (distance_m, bins) in [(0.0, 2), (5.0, 2), (7.999, 2), (8.0, 1), (30.0, 1)] {
            let holding = Bin::all().filter(|bin| bin.holds(distance_m));
            assert_eq!(holding.count(), bins, "{distance_m}");
        }
    }
}
