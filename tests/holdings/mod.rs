//! What a receiver holds in the end, in a form in which all of it can be compared.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Debug, Write};
use std::hash::{DefaultHasher, Hasher};

use flaneur_scene::SceneUpdate;

/// A digest of everything in each tile, photograph and node: bit by bit, as numbers are
/// written so that they can be told apart.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Holdings(BTreeMap<String, u64>);

impl Holdings {
    pub(crate) fn apply(&mut self, update: &SceneUpdate) {
        let name = match update {
            SceneUpdate::Mesh(tile) => format!("{:?}", tile.key),
            SceneUpdate::DropMesh(key) => format!("{key:?}"),
            SceneUpdate::Image(image) => format!("{:?}", image.id),
            SceneUpdate::DropImage(id) => format!("{id:?}"),
            SceneUpdate::Points(chunk) => format!("{:?}", chunk.id),
            SceneUpdate::DropPoints(id) => format!("{id:?}"),
        };
        match update {
            SceneUpdate::Mesh(tile) => self.0.insert(name, digest(tile)),
            SceneUpdate::Image(image) => self.0.insert(name, digest(image)),
            SceneUpdate::Points(chunk) => self.0.insert(name, digest(chunk)),
            SceneUpdate::DropMesh(_) | SceneUpdate::DropImage(_) | SceneUpdate::DropPoints(_) => {
                self.0.remove(&name)
            }
        };
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// What is not the same in both: names, at most a few.
    pub(crate) fn difference(&self, other: &Self) -> Vec<String> {
        let names: BTreeSet<_> = self.0.keys().chain(other.0.keys()).collect();
        let differ = names.into_iter().filter(|name| self.0.get(*name) != other.0.get(*name));
        differ.take(5).cloned().collect()
    }
}

fn digest(value: &impl Debug) -> u64 {
    struct Digest(DefaultHasher);
    impl Write for Digest {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.write(text.as_bytes());
            Ok(())
        }
    }
    let mut digest = Digest(DefaultHasher::new());
    write!(digest, "{value:?}").expect("a digest takes anything");
    digest.0.finish()
}
