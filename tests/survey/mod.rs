//! A survey in a temporary folder, and the built program that ingests it.

#![allow(dead_code, reason = "each test program uses its own part")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use flaneur_sample::SampleOptions;
use serde_json::Value;
use tempfile::TempDir;

/// A folder with `street/`, `store/` and `work/`.
pub(crate) struct Survey {
    folder: TempDir,
}

/// What a run of the program gave.
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Survey {
    /// A survey without any file.
    pub(crate) fn empty() -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        std::fs::create_dir(folder.path().join("street")).expect("folder");
        Self { folder }
    }

    /// The smallest synthetic street.
    pub(crate) fn sample() -> Self {
        static SAMPLE: OnceLock<TempDir> = OnceLock::new();
        let made = SAMPLE.get_or_init(|| {
            let folder = tempfile::tempdir().expect("temporary folder");
            let options = SampleOptions { views: 0, ..SampleOptions::tiny(7) };
            let target = folder.path().join("street");
            flaneur_sample::write_street(&target, &options, &|_| {}, &AtomicBool::new(false))
                .expect("the sample");
            folder
        });
        let survey = Self::empty();
        copy(&made.path().join("street"), &survey.street());
        survey
    }

    /// One of the real surveys, in place; `None`, with a word, where it is absent.
    pub(crate) fn real(name: &str) -> Option<PathBuf> {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")).join(name);
        if path.is_dir() {
            return Some(path);
        }
        eprintln!("skipped: {} is absent", path.display());
        None
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn street(&self) -> PathBuf {
        self.path().join("street")
    }

    pub(crate) fn store(&self) -> PathBuf {
        self.path().join("store")
    }

    /// Writes a file of the street.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.street().join(name);
        std::fs::create_dir_all(path.parent().expect("below the street")).expect("folder");
        std::fs::write(path, content).expect("file");
    }

    /// `flaneur ingest` of this survey with more arguments.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = self.command_of(&self.street());
        command.args(arguments);
        command
    }

    /// `flaneur ingest` of another folder into this survey's store.
    pub(crate) fn command_of(&self, street: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_flaneur"));
        command.arg("ingest").arg(street).arg("--out").arg(self.store());
        command.arg("--work").arg(self.path().join("work"));
        command.stdin(Stdio::null());
        command
    }

    /// Runs `flaneur ingest` to its end.
    pub(crate) fn ingest(&self, arguments: &[&str]) -> Outcome {
        Outcome::of(self.command(arguments).output().expect("the program starts"))
    }

    /// The summary of an ingest that must succeed.
    pub(crate) fn ingested(&self, arguments: &[&str]) -> Value {
        self.ingest(&[arguments, &["--json"]].concat()).summary()
    }

    /// Every file and folder of the store with its content.
    pub(crate) fn stored(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        contents(&self.store())
    }

    /// What is left in the work folder.
    pub(crate) fn work_files(&self) -> usize {
        contents(&self.path().join("work")).len()
    }
}

impl Outcome {
    pub(crate) fn of(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("text"),
            stderr: String::from_utf8(output.stderr).expect("text"),
        }
    }

    /// The JSON summary of a success.
    pub(crate) fn summary(&self) -> Value {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        serde_json::from_str(&self.stdout).expect("JSON")
    }

    /// The one line that says what was wrong, without `flaneur: `.
    pub(crate) fn complaint(&self) -> &str {
        let lines: Vec<&str> =
            self.stderr.lines().filter_map(|line| line.strip_prefix("flaneur: ")).collect();
        assert_eq!(lines.len(), 1, "one complaint in\n{}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        lines[0]
    }
}

/// Every file (with content) and folder (without) below a folder.
pub(crate) fn contents(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.expect("entry").path();
            if path.is_dir() {
                folders.push(path.clone());
                found.insert(path, None);
            } else {
                let bytes = std::fs::read(&path).expect("readable");
                found.insert(path, Some(bytes));
            }
        }
    }
    found.into_iter().map(|(path, bytes)| (below(&path, folder), bytes)).collect()
}

fn below(path: &Path, folder: &Path) -> PathBuf {
    path.strip_prefix(folder).expect("below").to_owned()
}

fn copy(from: &Path, to: &Path) {
    for (path, content) in contents(from) {
        match content {
            None => std::fs::create_dir_all(to.join(path)).expect("folder"),
            Some(bytes) => {
                let target = to.join(path);
                std::fs::create_dir_all(target.parent().expect("parent")).expect("folder");
                std::fs::write(target, bytes).expect("file");
            }
        }
    }
}
