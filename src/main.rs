//! The `flaneur` command: parses the arguments, wires the libraries, starts.
//!
//! Results go to stdout, everything else to stderr. Exit codes: see [`exit::Exit`].

mod atomic_file;
mod commands;
mod descriptors;
mod evaluation;
mod exit;
mod interrupt;
mod logging;
mod memory;
mod names;
mod output;
mod payload_cache;
mod progress;
mod source;
mod throttle;
mod viewpoints;

use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;

use commands::Context;

/// How long blocking work may take to notice that it is not wanted any more.
const GRACE: Duration = Duration::from_secs(3);

/// Ingest, serve and render a surveyed street.
#[derive(Parser)]
#[command(name = "flaneur", version, propagate_version = true)]
struct Arguments {
    #[command(flatten)]
    logging: logging::LoggingArguments,
    #[command(subcommand)]
    command: commands::Command,
}

#[expect(unsafe_code, reason = "setting a variable of the process")]
fn main() -> ExitCode {
    // Mesa's layer for choosing among devices looks for a display and complains where there is
    // none; the renderer chooses by itself.
    // SAFETY: no other thread runs yet.
    unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    let arguments = Arguments::parse();
    let console = progress::Console::new();
    logging::set_up(&arguments.logging, arguments.command.default_log_level(), &console);
    let runtime = match tokio::runtime::Runtime::new() {
        Ok(runtime) => runtime,
        Err(error) => return exit::Exit::from(error).report(&console),
    };
    let outcome = runtime.block_on(async {
        let context = Context { cancel: interrupt::on_ctrl_c(), console: console.clone() };
        arguments.command.run(&context).await
    });
    // Blocking work that was cancelled ends at its next check. A graphics driver that is still
    // being opened must not be torn down by the end of the process: it crashes.
    runtime.shutdown_timeout(GRACE);
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(exit) => exit.report(&console),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::Arguments;

    /// Columns of the narrowest terminal that helps are written for.
    const NARROW: usize = 80;

    #[test]
    fn helps_keep_their_lines() {
        Arguments::command().debug_assert();
        let mut examples = 0;
        for command in Arguments::command().get_subcommands() {
            let name = command.get_name();
            let Some(text) = command.get_after_help().map(ToString::to_string) else {
                assert_eq!(name, "help", "{name} has no examples");
                continue;
            };
            // What is indented stays as it is, so it must fit; all else is wrapped where it is
            // shown, so a paragraph is one line.
            for paragraph in text.split("\n\n") {
                let wide = paragraph.lines().filter(|line| line.starts_with(' '));
                for line in wide.clone() {
                    assert!(line.chars().count() <= NARROW, "{name}: {line}");
                }
                let prose = paragraph.lines().filter(|line| !line.starts_with(' ')).count();
                assert!(prose <= 1, "{name} breaks its own lines: {paragraph}");
                examples += wide.count();
            }
        }
        assert!(examples > 20, "{examples}");
    }
}
