//! Files that are there whole, or not at all.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::exit::Exit;

/// Writes `bytes` to `path`: beside it first, then in its place in one step.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Exit> {
    let beside = beside(path);
    let written = File::create(&beside)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, path));
    written.map_err(|error| {
        // What is left of it is of no use to anyone; the first error is the one to report.
        drop(fs::remove_file(&beside));
        let what = format!("cannot write {}; check its folder and the space there", path.display());
        Exit::Failed(anyhow::Error::new(error).context(what))
    })
}

/// Refuses a path whose folder does not exist, before any work is done for it.
pub(crate) fn check_folder(path: &Path) -> Result<(), Exit> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => Err(Exit::bad_input(anyhow::anyhow!(
            "cannot write {}: its folder does not exist; make it first",
            path.display()
        ))),
        _ => Ok(()),
    }
}

fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("frame.png");
        fs::write(&path, b"old").expect("writable");
        write(&path, b"new").expect("writable");
        assert_eq!(fs::read(&path).expect("there"), b"new");
        // A folder cannot be replaced by a file.
        let taken = folder.path().join("taken");
        fs::create_dir_all(taken.join("inside")).expect("writable");
        assert!(matches!(write(&taken, b"x"), Err(Exit::Failed(_))));
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 2);
        assert!(matches!(check_folder(&folder.path().join("no/f.png")), Err(Exit::BadInput(_))));
        assert!(check_folder(Path::new("frame.png")).is_ok());
    }
}
