//! What a store that is a folder keeps after removals and kills: empty folders, and the
//! beginnings of objects.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of a scene, and of its store, where the store is a folder.
pub(super) struct Leftovers {
    scene: Option<PathBuf>,
    /// Folders above the scene's that did not exist before, deepest first.
    made: Vec<PathBuf>,
}

impl Leftovers {
    /// Notes which folders exist before anything is written.
    pub(super) fn new(store: Option<&Path>, scene: &str) -> Self {
        let absent = |folder: &&Path| !folder.exists();
        let made = store.into_iter().flat_map(Path::ancestors).take_while(absent);
        Self {
            scene: store.map(|store| store.join(scene)),
            made: made.map(Path::to_owned).collect(),
        }
    }

    /// Removes the beginnings of objects below the scene, then empty folders, as far as
    /// possible: what stays costs next to nothing.
    pub(super) fn tidy(&self) {
        let Some(scene) = &self.scene else { return };
        let outcome = tidy_below(scene);
        if let Err(error) = outcome.and_then(|()| remove_empty(scene)) {
            tracing::debug!(%error, folder = %scene.display(), "cannot tidy up");
        }
        for folder in &self.made {
            if remove_empty(folder).is_err() {
                return;
            }
        }
    }
}

fn tidy_below(folder: &Path) -> io::Result<()> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        other => other?,
    };
    for entry in entries {
        let entry = entry?;
        let path = entry.path();
        if entry.file_type()?.is_dir() {
            tidy_below(&path)?;
            remove_empty(&path)?;
        } else if is_beginning(&entry.file_name().to_string_lossy()) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

/// Whether `object_store` gave the name to an object that was not yet whole: `name#12`.
fn is_beginning(name: &str) -> bool {
    name.rsplit_once('#').is_some_and(|(before, number)| {
        !before.is_empty() && !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
    })
}

/// Removes a folder that is empty; others stay.
fn remove_empty(folder: &Path) -> io::Result<()> {
    match fs::remove_dir(folder) {
        Err(error)
            if !matches!(
                error.kind(),
                io::ErrorKind::DirectoryNotEmpty | io::ErrorKind::NotFound
            ) =>
        {
            Err(error)
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beginnings_and_empty_folders_go_and_objects_stay() {
        let base = tempfile::tempdir().expect("dir");
        let store = base.path().join("a/store");
        let leftovers = Leftovers::new(Some(&store), "s");
        fs::create_dir_all(store.join("s/p/q")).expect("folders");
        fs::write(store.join("s/p/q/1.jpg#2"), "half").expect("file");
        leftovers.tidy();
        assert!(!base.path().join("a").exists(), "all of it was made and is empty");
        assert!(base.path().exists());

        fs::create_dir_all(store.join("s/p/q")).expect("folders");
        for name in ["s/p/1.jpg", "s/p/1.jpg#1", "s/a#b", "s/#1"] {
            fs::write(store.join(name), "x").expect("file");
        }
        leftovers.tidy();
        let left = |name: &str| store.join(name).exists();
        assert_eq!(
            ["s/p/1.jpg", "s/p/1.jpg#1", "s/a#b", "s/#1", "s/p/q"].map(left),
            [true, false, true, true, false]
        );
    }
}
