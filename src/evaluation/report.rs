//! All scores of an evaluation, and their means.

use serde::{Serialize, Serializer};

use super::{Bin, Method, Score, StatedSettings};
use crate::memory::HeldMemory;

/// An evaluation.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// The scene's name.
    pub(crate) scene: String,
    /// Name of the graphics adapter, where one was needed.
    pub(crate) adapter: Option<String>,
    /// Bytes that a renderer held on the device, at most; they follow each other.
    pub(crate) memory: HeldMemory,
    /// What was evaluated.
    pub(crate) settings: Described,
    /// A row a view and method: views in the order of their names, methods in that of
    /// [`Described::methods`].
    pub(crate) views: Vec<Row>,
    /// The mean over all views for each method.
    #[serde(serialize_with = "as_map")]
    pub(crate) mean: Vec<(&'static str, Score)>,
    /// The same over the views at each distance, where there are any; see [`Bin::all`].
    pub(crate) bins: Vec<BinMeans>,
}

/// What was evaluated, and how.
#[derive(Debug, Serialize)]
pub(crate) struct Described {
    /// What was held out, as the argument said.
    pub(crate) held_out: String,
    /// The patterns of the photographs that took part; empty for all.
    pub(crate) only: Vec<String>,
    /// How many photographs were sources.
    pub(crate) sources: usize,
    /// How many views were rendered by each method.
    pub(crate) targets: usize,
    /// The methods.
    pub(crate) methods: Vec<&'static str>,
    /// The settings of the whole renderer.
    pub(crate) renderer: StatedSettings,
}

/// One view rendered by one method.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    /// The photograph.
    pub(crate) id: String,
    /// From its centre to that of the nearest source, metres.
    pub(crate) nearest_m: f64,
    /// The method.
    pub(crate) method: &'static str,
    /// Its score.
    #[serde(flatten)]
    pub(crate) score: Score,
}

/// The means over the views of a bin.
#[derive(Debug, Serialize)]
pub(crate) struct BinMeans {
    /// The bin.
    #[serde(flatten)]
    pub(crate) bin: Bin,
    /// How many views it holds.
    pub(crate) views: usize,
    /// The mean for each method.
    #[serde(serialize_with = "as_map")]
    pub(crate) mean: Vec<(&'static str, Score)>,
}

impl Report {
    /// The report of `rows`.
    pub(crate) fn new(
        scene: String,
        adapter: Option<String>,
        memory: HeldMemory,
        settings: Described,
        methods: &[&'static Method],
        views: Vec<Row>,
    ) -> Self {
        let mean = means(methods, &views, |_| true);
        let bins = Bin::all().filter_map(|bin| {
            let inside = |row: &Row| bin.holds(row.nearest_m);
            let count = views.iter().filter(|row| inside(row)).count() / methods.len().max(1);
            (count > 0).then(|| BinMeans {
                bin,
                views: count,
                mean: means(methods, &views, inside),
            })
        });
        let bins = bins.collect();
        Self { scene, adapter, memory, settings, views, mean, bins }
    }
}

/// The means of the rows that `counts` holds for.
fn means(
    methods: &[&'static Method],
    rows: &[Row],
    counts: impl Fn(&Row) -> bool,
) -> Vec<(&'static str, Score)> {
    let mean = |method: &&'static Method| {
        let of_method = rows.iter().filter(|row| row.method == method.name && counts(row));
        let scores: Vec<Score> = of_method.map(|row| row.score).collect();
        (method.name, Score::mean(&scores))
    };
    methods.iter().map(mean).collect()
}

fn as_map<S: Serializer>(means: &[(&'static str, Score)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(means.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::Compared;
    use glam::UVec2;

    fn row(method: &'static str, nearest_m: f64, error: u8) -> Row {
        let grey = |value| Compared {
            size: UVec2::splat(8),
            rgb: vec![value; 192],
            counts: vec![true; 64],
            coverage: None,
            inferred: 0.0,
        };
        let score = Score::new(&grey(0), &grey(error)).expect("of one size");
        Row { id: format!("{nearest_m}/1"), nearest_m, method, score }
    }

    #[test]
    fn means_are_over_views_and_bins() {
        let methods: Vec<&Method> =
            ["nearest", "hybrid"].map(|name| Method::named(name).expect("in the table")).into();
        let mut rows = Vec::new();
        for (nearest_m, errors) in [(1.0, [51, 51]), (3.0, [102, 0]), (3.5, [0, 51])] {
            rows.push(row("nearest", nearest_m, errors[0]));
            rows.push(row("hybrid", nearest_m, errors[1]));
        }
        let settings = Described {
            held_out: "every:2".into(),
            only: Vec::new(),
            sources: 1,
            targets: 3,
            methods: vec!["nearest", "hybrid"],
            renderer: StatedSettings(flaneur_renderer::Settings::default()),
        };
        let report =
            Report::new("street".into(), None, HeldMemory::default(), settings, &methods, rows);
        let json = serde_json::to_value(&report).expect("JSON");
        let rmse = |value: &serde_json::Value| value["rmse"].as_f64().expect("a number");
        assert!((rmse(&json["mean"]["nearest"]) - 0.2).abs() < 1e-12, "{json}");
        // 0 to 2 m, 2 to 4 m, and all below 8 m.
        assert_eq!(json["bins"].as_array().map(Vec::len), Some(3));
        assert_eq!(
            (&json["bins"][0]["from_m"], &json["bins"][0]["to_m"]),
            (&0.0.into(), &2.0.into())
        );
        assert_eq!(json["bins"][1]["views"], 2);
        assert!((rmse(&json["bins"][1]["mean"]["hybrid"]) - 0.1).abs() < 1e-12);
        assert_eq!((&json["bins"][2]["to_m"], &json["bins"][2]["views"]), (&8.0.into(), &3.into()));
        assert!((rmse(&json["bins"][2]["mean"]["nearest"]) - 0.2).abs() < 1e-12);
        assert_eq!(json["views"][0]["method"], "nearest");
        assert!((rmse(&json["views"][0]) - 0.2).abs() < 1e-12);
        // Equal pictures have no ratio that JSON could hold.
        assert!(json["views"][3]["psnr_db"].is_null() && json["views"][3]["rmse"] == 0.0);
    }
}
