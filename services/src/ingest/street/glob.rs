//! Files that a pattern names.

use std::io;
use std::path::{Path, PathBuf};

use globset::{Glob, GlobMatcher};

/// Most files that one pattern may name.
pub(super) const MAX_FILES: usize = 1_000_000;

/// The files that `pattern` (relative to `base`, or absolute) matches, sorted.
///
/// `*`, `?`, `[…]` and `{…}` match within a segment, `**` any number of folders. A path that
/// exists as it is written stands for itself. Symbolic links to folders are not followed by
/// `**`, so that loops end.
pub(in crate::ingest) fn expand(base: &Path, pattern: &str) -> io::Result<Vec<PathBuf>> {
    let literal = base.join(pattern);
    if literal.is_file() {
        return Ok(vec![literal]);
    }
    let mut folders = vec![base.to_owned()];
    let mut rest = pattern;
    if let Some(absolute) = pattern.strip_prefix('/') {
        folders = vec![PathBuf::from("/")];
        rest = absolute;
    }
    let mut segments = rest.split('/').filter(|segment| !segment.is_empty()).peekable();
    while let Some(segment) = segments.next() {
        let last = segments.peek().is_none();
        let mut next = Vec::new();
        if segment == "**" {
            for folder in &folders {
                descend(folder, last, &mut next)?;
            }
        } else if segment.contains(['*', '?', '[', '{', '\\']) {
            let matcher = matcher(segment)?;
            for folder in &folders {
                list(folder, &matcher, last, &mut next)?;
            }
        } else {
            next.extend(
                folders
                    .iter()
                    .map(|folder| folder.join(segment))
                    .filter(|path| if last { path.is_file() } else { path.is_dir() }),
            );
        }
        folders = next;
    }
    folders.sort();
    folders.dedup();
    Ok(folders)
}

fn matcher(segment: &str) -> io::Result<GlobMatcher> {
    Glob::new(segment)
        .map(|glob| glob.compile_matcher())
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))
}

/// Adds the entries of `folder` that match: files where the segment is the last, else folders.
fn list(
    folder: &Path,
    matcher: &GlobMatcher,
    files: bool,
    found: &mut Vec<PathBuf>,
) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        let fits = matcher.is_match(Path::new(&entry.file_name()));
        if fits && if files { path.is_file() } else { path.is_dir() } {
            push(found, path)?;
        }
    }
    Ok(())
}

/// Adds `folder` and all folders below it, or all files below it.
fn descend(folder: &Path, files: bool, found: &mut Vec<PathBuf>) -> io::Result<()> {
    if !files {
        push(found, folder.to_owned())?;
    }
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            descend(&entry.path(), files, found)?;
        } else if files && entry.path().is_file() {
            push(found, entry.path())?;
        }
    }
    Ok(())
}

fn push(found: &mut Vec<PathBuf>, path: PathBuf) -> io::Result<()> {
    if found.len() >= MAX_FILES {
        return Err(io::Error::other(format!("more than {MAX_FILES} files")));
    }
    found.push(path);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_name_files_in_order() {
        let folder = tempfile::tempdir().expect("temporary folder");
        for file in ["b.laz", "a.laz", "a.txt", "x/1/c.laz", "x/d.laz", "x[1].las"] {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().expect("parent")).expect("folder");
            std::fs::write(path, "").expect("file");
        }
        let names = |pattern: &str| -> Vec<String> {
            let files = expand(folder.path(), pattern).expect(pattern);
            files
                .iter()
                .map(|path| {
                    let path = path.strip_prefix(folder.path()).expect("inside");
                    path.display().to_string()
                })
                .collect()
        };
        assert_eq!(names("*.laz"), ["a.laz", "b.laz"]);
        assert_eq!(names("**/*.laz"), ["a.laz", "b.laz", "x/1/c.laz", "x/d.laz"]);
        assert_eq!(names("x/*/c.la?"), ["x/1/c.laz"]);
        assert_eq!(names("x[1].las"), ["x[1].las"]);
        assert_eq!(names("[ab].{laz,txt}"), ["a.laz", "a.txt", "b.laz"]);
        assert_eq!(names("nothing/*.laz"), Vec::<String>::new());
        assert!(expand(folder.path(), "[a").is_err());
    }
}
