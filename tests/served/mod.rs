//! The built binary, run to its end, or serving until it is told to stop.

#![allow(dead_code, reason = "each test file is a crate and uses its share")]

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};

/// A server on a free port.
pub(crate) struct Served {
    process: Child,
    /// Where it answers.
    pub(crate) url: String,
}

/// Runs `flaneur` and asserts that it ends well.
pub(crate) fn flaneur<'a>(arguments: impl IntoIterator<Item = &'a OsStr>) {
    let output = Command::new(env!("CARGO_BIN_EXE_flaneur"))
        .args(arguments)
        .output()
        .expect("the binary starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

impl Served {
    /// Serves the data of stores; ready when it returns.
    pub(crate) fn start(stores: &[&Path]) -> Self {
        Self::start_at(stores, "127.0.0.1:0")
    }

    /// The same on a given address.
    pub(crate) fn start_at(stores: &[&Path], listen: &str) -> Self {
        let stores = stores.iter().map(|store| store.as_os_str());
        let rest = ["--no-render", "--listen", listen].map(OsStr::new);
        Self::run(&mut Self::command(stores.chain(rest)))
    }

    /// Serves on a free port as the arguments say.
    pub(crate) fn with<'a>(arguments: impl IntoIterator<Item = &'a OsStr>) -> Self {
        let free = ["--listen", "127.0.0.1:0"].map(OsStr::new);
        Self::run(&mut Self::command(arguments.into_iter().chain(free)))
    }

    /// `flaneur serve` with these arguments, to be changed before it is run.
    pub(crate) fn command<'a>(arguments: impl IntoIterator<Item = &'a OsStr>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_flaneur"));
        command.arg("serve").args(arguments);
        command
    }

    /// Starts a command of [`Served::command`]; ready when it returns.
    pub(crate) fn run(command: &mut Command) -> Self {
        let mut process = command.stdout(Stdio::piped()).spawn().expect("the binary starts");
        let mut line = String::new();
        let stdout = process.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut line).expect("text");
        let url = line.strip_prefix("serving ").map(|url| url.trim().to_owned());
        let Some(url) = url else {
            let _ = process.kill();
            panic!("no address but {line:?}");
        };
        Self { process, url }
    }

    /// Asks it to stop, and waits.
    pub(crate) fn stop(mut self) -> ExitStatus {
        self.signal("-TERM");
        self.process.wait().expect("it ends")
    }

    /// Waits for the end of one that was asked to stop: a second signal would not let it end well.
    pub(crate) fn ended(mut self) -> ExitStatus {
        self.process.wait().expect("it ends")
    }

    /// Kills it, whatever it is doing.
    pub(crate) fn kill(mut self) {
        self.process.kill().expect("it runs");
        self.process.wait().expect("it ends");
    }

    /// Its process.
    pub(crate) fn id(&self) -> u32 {
        self.process.id()
    }

    /// Sends it a signal, as in `-STOP`.
    pub(crate) fn signal(&self, signal: &str) {
        let told = Command::new("kill").args([signal, &self.process.id().to_string()]).status();
        assert!(told.expect("kill starts").success());
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // Already ended after a stop; else a test failed and nobody waits for a good end.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
