//! Photographs by name: the one to render like, and those to leave out.

use std::collections::BTreeMap;

use flaneur_scene::{ImageId, PosedCamera, Region};
use flaneur_streamer::Client;
use futures::TryStreamExt;
use globset::{GlobBuilder, GlobMatcher};

use crate::exit::Exit;
use crate::source::stream_exit;

/// How many names an error suggests.
const SUGGESTIONS: usize = 5;

/// Every photograph of a scene with its camera.
pub(crate) struct Names {
    cameras: BTreeMap<ImageId, PosedCamera>,
}

/// A photograph, a panorama, or a glob over either.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    text: String,
    glob: GlobMatcher,
}

impl Names {
    /// Asks the service for all of them.
    pub(crate) async fn all(client: &Client) -> Result<Self, Exit> {
        let mut cameras = BTreeMap::new();
        let panoramas = client.panoramas(Region::All).await.map_err(stream_exit)?;
        let mut panoramas = std::pin::pin!(panoramas);
        while let Some(panorama) = panoramas.try_next().await.map_err(stream_exit)? {
            cameras.extend(panorama.photographs()?);
        }
        Ok(Self { cameras })
    }

    /// The camera of the photograph `text`: its id, or that of a panorama with one camera.
    pub(crate) fn camera(&self, text: &str) -> Result<PosedCamera, Exit> {
        if let Some(camera) = text.parse().ok().and_then(|id: ImageId| self.cameras.get(&id)) {
            return Ok(*camera);
        }
        let of_panorama: Vec<_> =
            self.cameras.iter().filter(|(id, _)| id.panorama() == text).collect();
        match of_panorama[..] {
            [(_, camera)] => Ok(*camera),
            [] => Err(self.unknown("photograph", text)),
            _ => {
                let names: Vec<_> = of_panorama.iter().map(|(id, _)| id.to_string()).collect();
                Err(Exit::bad_input(anyhow::anyhow!(
                    "panorama {text:?} has {} cameras, name one: {}",
                    names.len(),
                    names.join(", ")
                )))
            }
        }
    }

    /// Refuses a pattern that names nothing: a slip would go unnoticed in the picture.
    pub(crate) fn check(&self, pattern: &Pattern) -> Result<(), Exit> {
        if self.cameras.keys().any(|id| pattern.matches(id)) {
            return Ok(());
        }
        Err(self.unknown("photograph or panorama", &pattern.text))
    }

    fn unknown(&self, what: &str, text: &str) -> Exit {
        let mut names: Vec<(f64, String)> = self
            .cameras
            .keys()
            .flat_map(|id| [id.to_string(), id.panorama().to_owned()])
            .map(|name| (strsim::jaro_winkler(text, &name), name))
            .collect();
        names.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        names.dedup();
        let nearest: Vec<_> = names.into_iter().take(SUGGESTIONS).map(|(_, name)| name).collect();
        Exit::bad_input(if nearest.is_empty() {
            anyhow::anyhow!("no {what} is named {text:?}; the scene has none")
        } else {
            anyhow::anyhow!("no {what} is named {text:?}; the nearest are {}", nearest.join(", "))
        })
    }
}

impl Pattern {
    /// The pattern that `text` stands for. `*` and `?` stop at the `/` between panorama and
    /// camera.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let glob = GlobBuilder::new(text).literal_separator(true).build();
        let glob = glob.map_err(|e| e.kind().to_string())?.compile_matcher();
        Ok(Self { text: text.to_owned(), glob })
    }

    /// Whether the photograph or its panorama is meant.
    pub(crate) fn matches(&self, id: &ImageId) -> bool {
        let name = id.to_string();
        // A name may hold characters that mean something else in a glob.
        self.text == name
            || self.text == id.panorama()
            || self.glob.is_match(name)
            || self.glob.is_match(id.panorama())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::{Intrinsics, Lens};
    use glam::{DMat3, DVec3, UVec2};

    fn names(ids: &[&str]) -> Names {
        let size = UVec2::splat(8);
        let camera = PosedCamera {
            centre: DVec3::ZERO,
            cam_from_world: DMat3::IDENTITY,
            lens: Lens::pinhole(size, Intrinsics::from_fov_y(1.0, size)),
        };
        let cameras = ids.iter().map(|id| (id.parse().expect("an id"), camera)).collect();
        Names { cameras }
    }

    fn fault(exit: Exit) -> String {
        match exit {
            Exit::BadInput(error) => error.to_string(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_photograph_is_found_by_its_id_or_its_lonely_panorama() {
        let names = names(&["490/300", "490/301", "000001/image_02"]);
        assert!(names.camera("490/301").is_ok());
        assert!(names.camera("000001").is_ok());
        assert!(fault(names.camera("490").expect_err("two")).contains("490/300, 490/301"));
        let unknown = fault(names.camera("491/300").expect_err("unknown"));
        assert!(unknown.contains("nearest are 490/300"), "{unknown}");
    }

    #[test]
    fn patterns_mean_ids_panoramas_and_globs() {
        let matches = |pattern: &str, id: &str| {
            Pattern::parse(pattern).expect("a pattern").matches(&id.parse().expect("an id"))
        };
        assert!(matches("490/300", "490/300") && !matches("490/300", "490/301"));
        assert!(matches("490", "490/301") && !matches("49", "490/301"));
        assert!(matches("49*", "490/301") && matches("*/300", "490/300"));
        assert!(!matches("*/300", "490/301") && matches("[x]/1", "[x]/1"));
        assert!(Pattern::parse("{a").is_err());
        let names = names(&["490/300"]);
        let check = |pattern: &str| names.check(&Pattern::parse(pattern).expect("a pattern"));
        assert!(check("490").is_ok());
        assert!(fault(check("5*").expect_err("nothing")).contains("nearest"));
    }
}
