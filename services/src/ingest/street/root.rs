//! Where a survey's paths start, and how far they may lead.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::ingest::{BadInput, IngestError};

/// The folder of a `street.toml`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Root {
    /// The folder, absolute and without symbolic links.
    folder: PathBuf,
    /// Whether paths must stay in it.
    confine: bool,
}

impl Root {
    /// The root at `folder`, which must exist.
    pub fn new(folder: &Path, confine: bool) -> std::io::Result<Self> {
        Ok(Self { folder: folder.canonicalize()?, confine })
    }

    /// The folder, absolute and without symbolic links.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// `path` as written in `file` at `place`, relative to `base`. It need not exist.
    ///
    /// With `--confine`, a path that leads out of the folder (by `..`, by being absolute, or
    /// through a symbolic link) is an error.
    pub fn resolve(
        &self,
        base: &Path,
        path: &str,
        file: &Path,
        place: &str,
    ) -> Result<PathBuf, IngestError> {
        if path.contains('\0') {
            return Err(BadInput::error(
                file,
                place,
                format!("the path {path:?} holds a NUL"),
                "remove it",
            ));
        }
        let joined = base.join(path);
        if self.confine && !self.holds(&joined) {
            return Err(BadInput::error(
                file,
                place,
                format!("the path {path:?} leaves the folder of the street"),
                "move the file into that folder, or ingest without --confine",
            ));
        }
        Ok(joined)
    }

    /// Whether `path` (absolute) lies in the folder once its `..` and symbolic links are
    /// followed. What does not exist yet is judged by its deepest existing ancestor.
    fn holds(&self, path: &Path) -> bool {
        let mut reached = PathBuf::new();
        let mut exists = true;
        for component in path.components() {
            match component {
                Component::ParentDir => {
                    reached.pop();
                    exists = true;
                }
                Component::CurDir => {}
                _ => reached.push(component),
            }
            if exists {
                match reached.canonicalize() {
                    Ok(real) => reached = real,
                    Err(_) => exists = false,
                }
            }
        }
        reached.starts_with(&self.folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confined_paths_stay_inside() {
        let outer = tempfile::tempdir().expect("temporary folder");
        let folder = outer.path().join("street");
        std::fs::create_dir_all(folder.join("images")).expect("folder");
        std::fs::write(outer.path().join("secret"), "s").expect("file");
        std::os::unix::fs::symlink(outer.path(), folder.join("link")).expect("link");
        let confined = Root::new(&folder, true).expect("root");
        let free = Root::new(&folder, false).expect("root");
        let toml = folder.join("street.toml");
        let try_path = |root: &Root, path: &str| {
            root.resolve(root.folder(), path, &toml, "line 1").map_err(|error| error.to_string())
        };
        for inside in ["images/a.jpg", "images/../b", "./c", "none/../../street/d", "link/street/e"]
        {
            assert!(try_path(&confined, inside).is_ok(), "{inside}");
        }
        for outside in
            ["../secret", "link/secret", "/etc/passwd", "images/../../street2", "none/../../x"]
        {
            let error = try_path(&confined, outside).expect_err(outside);
            assert!(error.contains("leaves the folder"), "{error}");
            assert!(try_path(&free, outside).is_ok(), "{outside}");
        }
        assert!(try_path(&free, "a\0b").is_err());
    }
}
