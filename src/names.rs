//! Photographs by name: the one to render like, those to leave out, those to evaluate.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use flaneur_scene::{ImageId, Panorama, PosedCamera, Region};
use flaneur_streamer::Client;
use futures::TryStreamExt;
use globset::{GlobBuilder, GlobMatcher};

use crate::exit::Exit;
use crate::source::stream_exit;

/// How many names an error suggests.
const SUGGESTIONS: usize = 5;

/// What a file name of a photograph ends in.
const EXTENSIONS: [&str; 6] = [".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"];

/// Every photograph of a scene.
pub(crate) struct Names {
    photographs: BTreeMap<ImageId, Photograph>,
}

/// One photograph.
#[derive(Clone, Debug)]
pub(crate) struct Photograph {
    /// Where it was taken, with the lens of level 0.
    pub(crate) camera: PosedCamera,
    /// The panorama that it belongs to.
    pub(crate) panorama: Arc<Panorama>,
}

/// A photograph, a panorama, the file of one that is a photograph of its own, or a glob over
/// any of them.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    text: String,
    /// What the name is compared with: the text, and where that is a file's name, the panorama
    /// that ingest makes of it.
    names: Vec<(String, GlobMatcher)>,
}

impl Names {
    /// Asks the service for all of them.
    pub(crate) async fn all(client: &Client) -> Result<Self, Exit> {
        let mut photographs = BTreeMap::new();
        let panoramas = client.panoramas(Region::All).await.map_err(stream_exit)?;
        let mut panoramas = std::pin::pin!(panoramas);
        while let Some(panorama) = panoramas.try_next().await.map_err(stream_exit)? {
            let panorama = Arc::new(panorama);
            photographs.extend(
                panorama.photographs()?.into_iter().map(|(id, camera)| {
                    (id, Photograph { camera, panorama: Arc::clone(&panorama) })
                }),
            );
        }
        Ok(Self { photographs })
    }

    /// All of them, in the order of their names.
    pub(crate) fn photographs(&self) -> &BTreeMap<ImageId, Photograph> {
        &self.photographs
    }

    /// The camera of the photograph `text`: its id, that of a panorama with one camera, or the
    /// name of the file that such a panorama was made of.
    pub(crate) fn camera(&self, text: &str) -> Result<PosedCamera, Exit> {
        let by_id = text.parse().ok().and_then(|id: ImageId| self.photographs.get(&id));
        if let Some(photograph) = by_id {
            return Ok(photograph.camera);
        }
        let of = |panorama: &str| {
            let all = self.photographs.iter();
            all.filter(|(id, _)| id.panorama() == panorama).collect::<Vec<_>>()
        };
        let mut of_panorama = of(text);
        if let (true, Some(panorama)) = (of_panorama.is_empty(), panorama_of_file(text)) {
            of_panorama = of(&panorama);
        }
        match of_panorama[..] {
            [(_, photograph)] => Ok(photograph.camera),
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
        self.check_among(pattern, |_| true)
    }

    /// Refuses a pattern that names none of those that `counts` holds for.
    pub(crate) fn check_among(
        &self,
        pattern: &Pattern,
        counts: impl Fn(&ImageId) -> bool,
    ) -> Result<(), Exit> {
        let mut named = self.photographs.keys().filter(|id| pattern.matches(id)).peekable();
        match (named.peek().is_some(), named.any(counts)) {
            (_, true) => Ok(()),
            (true, false) => Err(Exit::bad_input(anyhow::anyhow!(
                "{:?} names no photograph that takes part",
                pattern.text
            ))),
            (false, _) => Err(self.unknown("photograph or panorama", &pattern.text)),
        }
    }

    fn unknown(&self, what: &str, text: &str) -> Exit {
        let mut names: Vec<(f64, String)> = self
            .photographs
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
        let name = |text: String| {
            let glob = GlobBuilder::new(&text).literal_separator(true).build();
            let glob = glob.map_err(|e| e.kind().to_string())?.compile_matcher();
            Ok::<_, String>((text, glob))
        };
        let texts = std::iter::once(text.to_owned()).chain(panorama_of_file(text));
        Ok(Self { text: text.to_owned(), names: texts.map(name).collect::<Result<_, _>>()? })
    }

    /// Whether the photograph or its panorama is meant.
    pub(crate) fn matches(&self, id: &ImageId) -> bool {
        let image = id.to_string();
        self.names.iter().any(|(text, glob)| {
            // A name may hold characters that mean something else in a glob.
            [image.as_str(), id.panorama()].iter().any(|name| text == name || glob.is_match(name))
        })
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The panorama that ingest makes of a photograph's file: its name without the extension,
/// folders joined by `_`. `None` where `text` is no file's name.
fn panorama_of_file(text: &str) -> Option<String> {
    let lower = text.to_ascii_lowercase();
    let extension = EXTENSIONS.iter().find(|extension| lower.ends_with(**extension))?;
    let name = text.get(..text.len() - extension.len())?;
    Some(name.trim_start_matches("./").replace(['/', '\\'], "_"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::View;
    use glam::{DMat3, DVec3, UVec2};

    fn names(ids: &[&str]) -> Names {
        let panorama = |id: &ImageId| Panorama {
            id: id.panorama().to_owned(),
            position: DVec3::ZERO,
            world_from_rig: DMat3::IDENTITY,
            time: None,
            uncertainty_m: 0.0,
            cameras: Vec::new(),
        };
        let view = View::look(DVec3::ZERO, 0.0, 0.0, 1.0, UVec2::splat(8));
        let photographs = ids.iter().map(|id| {
            let id: ImageId = id.parse().expect("an id");
            let panorama = Arc::new(panorama(&id));
            (id, Photograph { camera: view.camera, panorama })
        });
        Names { photographs: photographs.collect() }
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

    #[test]
    fn files_of_photographs_are_names_too() {
        let names = names(&["02_000025/2", "left_0001/1", "03_000025/3", "a.jpg/1"]);
        for file in ["02_000025.png", "02_000025.JPG", "./02_000025.jpeg", "left/0001.tif"] {
            assert!(names.camera(file).is_ok(), "{file}");
        }
        assert!(names.camera("a.jpg").is_ok() && names.camera("02_000025.las").is_err());
        let matches = |pattern: &str, id: &str| {
            Pattern::parse(pattern).expect("a pattern").matches(&id.parse().expect("an id"))
        };
        assert!(matches("02_*.png", "02_000025/2") && !matches("02_*.png", "03_000025/3"));
        assert!(matches("left/*.jpg", "left_0001/1") && matches("*.jpg", "a.jpg/1"));
        let held = Pattern::parse("03_*").expect("a pattern");
        assert!(names.check_among(&held, |_| true).is_ok());
        let none = names.check_among(&held, |id| id.camera() == "2");
        assert!(fault(none.expect_err("left out")).contains("takes part"));
    }
}
