//! The `flaneur` binary as a person runs it.

#![allow(dead_code, reason = "each test file is a crate and uses its share")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// The binary, without arguments.
pub(crate) fn flaneur() -> Command {
    Command::new(env!("CARGO_BIN_EXE_flaneur"))
}

/// What came of running it.
pub(crate) fn run(arguments: &[&str]) -> Output {
    flaneur().args(arguments).output().expect("the binary")
}

/// What it printed, after checking that it ended well.
pub(crate) fn succeed(arguments: &[&str]) -> String {
    let output = run(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).expect("text")
}

/// The line on which a command gives up, after checking its exit code.
pub(crate) fn fail(code: i32, arguments: &[&str]) -> String {
    let output = run(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    let mut lines = stderr.lines().filter_map(|line| line.strip_prefix("flaneur: "));
    let line = lines.next().unwrap_or_else(|| panic!("no message in {stderr:?}")).to_owned();
    assert_eq!(lines.next(), None, "one line: {stderr}");
    line
}

/// A path of the test's own, as an argument.
pub(crate) fn text(path: &Path) -> &str {
    path.to_str().expect("text")
}

/// A JSON file that it wrote.
pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("written")).expect("JSON")
}
