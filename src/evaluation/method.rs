//! The ways to make a picture that are compared: one line each.

use flaneur_renderer::{Settings, SplatNormals};
use flaneur_scene::SceneUpdate;

/// A way to make the picture that a held-out photograph would show.
#[derive(Debug)]
pub(crate) struct Method {
    /// Its name, in reports and arguments.
    pub(crate) name: &'static str,
    /// What it does, in a line.
    pub(crate) about: &'static str,
    /// How it is done.
    pub(crate) making: Making,
}

/// How a method makes its picture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Making {
    /// The nearest source as it is, stretched to the size of the target.
    Nearest,
    /// The renderer.
    Rendered {
        /// Whether it is given buildings and terrain.
        mesh: bool,
        /// Whether it is given points.
        points: bool,
        /// Its settings, from those of the whole renderer.
        settings: fn(Settings) -> Settings,
    },
}

/// Every method; after the whole renderer, that with one setting changed at a time.
pub(crate) static METHODS: &[Method] = &[
    Method { name: "nearest", about: "The nearest source, unwarped", making: Making::Nearest },
    Method {
        name: "mesh",
        about: "Rendered without points",
        making: Making::Rendered { mesh: true, points: false, settings: |whole| whole },
    },
    Method {
        name: "points",
        about: "Rendered without buildings and terrain",
        making: Making::Rendered { mesh: false, points: true, settings: |whole| whole },
    },
    Method {
        name: "hybrid",
        about: "The whole renderer",
        making: Making::Rendered { mesh: true, points: true, settings: |whole| whole },
    },
    changed(
        "hybrid-with-normals",
        "Points lie on the planes of their neighbours instead of facing the eye",
        |whole| Settings { splat_normals: SplatNormals::Estimated, ..whole },
    ),
    changed("hybrid-without-depth-test", "Photographs go through everything", |whole| Settings {
        depth_test: false,
        ..whole
    }),
    changed("hybrid-without-refinement", "Depth maps are of the mesh alone", |whole| Settings {
        refine_by_points: false,
        ..whole
    }),
    changed("hybrid-without-near-first", "Points are alike, wherever they were taken", |whole| {
        Settings { near_first: false, ..whole }
    }),
    changed("hybrid-without-alignment", "Photographs stay a few pixels apart", |whole| Settings {
        align: false,
        ..whole
    }),
    changed("hybrid-without-inference", "No depths are inferred", |whole| Settings {
        infer: false,
        ..whole
    }),
    changed("hybrid-without-gains", "Photographs keep their own exposure", |whole| Settings {
        exposure_gains: false,
        ..whole
    }),
];

/// The whole renderer with one of its settings changed.
const fn changed(
    name: &'static str,
    about: &'static str,
    settings: fn(Settings) -> Settings,
) -> Method {
    Method { name, about, making: Making::Rendered { mesh: true, points: true, settings } }
}

impl Method {
    /// The method of that name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        METHODS.iter().find(|method| method.name == name)
    }
}

impl Making {
    /// The settings of its renderer, from those of the whole renderer; `None` where it has none.
    pub(crate) fn settings(&self, whole: Settings) -> Option<Settings> {
        match self {
            Self::Nearest => None,
            Self::Rendered { settings, .. } => Some(settings(whole)),
        }
    }

    /// Whether both give a renderer the same geometry.
    pub(crate) fn takes_as(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Nearest, Self::Nearest) => true,
            (
                Self::Rendered { mesh: a, points: c, .. },
                Self::Rendered { mesh: b, points: d, .. },
            ) => (a, c) == (b, d),
            _ => false,
        }
    }

    /// Whether `update` is for this method's renderer.
    pub(crate) fn takes(&self, update: &SceneUpdate) -> bool {
        match (self, update) {
            (Self::Nearest, _) => false,
            (Self::Rendered { mesh, .. }, SceneUpdate::Mesh(_) | SceneUpdate::DropMesh(_)) => *mesh,
            (
                Self::Rendered { points, .. },
                SceneUpdate::Points(_) | SceneUpdate::DropPoints(_),
            ) => *points,
            (Self::Rendered { .. }, SceneUpdate::Image(_) | SceneUpdate::DropImage(_)) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::{NodeKey, PointNodeId};

    #[test]
    fn names_are_unique_and_found() {
        for (index, method) in METHODS.iter().enumerate() {
            let found = Method::named(method.name).expect("in the table");
            assert!(std::ptr::eq(found, method), "{index}: {} is there twice", method.name);
        }
        assert!(Method::named("x").is_none());
    }

    /// A change of nothing would be reported as having no effect.
    #[test]
    fn what_is_changed_differs_from_the_whole() {
        let whole = Settings::default();
        for method in METHODS {
            if let Making::Rendered { settings, .. } = method.making {
                let is_changed = method.name.starts_with("hybrid-with");
                assert_eq!(settings(whole) != whole, is_changed, "{}", method.name);
            }
        }
    }

    #[test]
    fn a_method_takes_only_its_own_geometry() {
        let takes = |name: &str, update: &SceneUpdate| {
            Method::named(name).expect("in the table").making.takes(update)
        };
        let points = SceneUpdate::DropPoints(PointNodeId { source: 0, key: NodeKey::ROOT });
        let image = SceneUpdate::DropImage("a/b".parse().expect("an id"));
        assert!(takes("points", &points) && takes("hybrid", &points) && !takes("mesh", &points));
        assert!(takes("mesh", &image) && takes("points", &image) && !takes("nearest", &image));
    }
}
