//! Structured logs on stderr.

use std::io::{self, IsTerminal, Write};

use clap::{ArgAction, Args, ValueEnum};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

use crate::progress::Console;

/// In helps these come after what a command has of its own.
const LAST: usize = 900;

/// What is logged, and how.
#[derive(Args)]
pub(crate) struct LoggingArguments {
    /// Log more: warnings, then info, debug, trace with each further -v (RUST_LOG overrides)
    #[arg(short, long, global = true, action = ArgAction::Count, display_order = LAST)]
    verbose: u8,
    /// Form of the log lines on stderr
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Compact,
        display_order = LAST)]
    log_format: LogFormat,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LogFormat {
    /// One short line an event
    Compact,
    /// Several lines an event, for reading
    Pretty,
    /// One JSON object an event, for machines
    Json,
}

/// Installs the process's log subscriber. `level` is what is logged without `-v`.
pub(crate) fn set_up(arguments: &LoggingArguments, level: LevelFilter, console: &Console) {
    let steps = [LevelFilter::WARN, LevelFilter::INFO, LevelFilter::DEBUG, LevelFilter::TRACE];
    let start = steps.iter().position(|&step| step == level).unwrap_or(0);
    let wanted = steps[(start + usize::from(arguments.verbose)).min(steps.len() - 1)];
    let set = std::env::var(EnvFilter::DEFAULT_ENV).ok();
    let builder = tracing_subscriber::fmt()
        .with_env_filter(filter(wanted, set.as_deref()))
        .with_ansi(io::stderr().is_terminal())
        .with_writer(ConsoleWriter(console.clone()));
    match arguments.log_format {
        LogFormat::Compact => builder.compact().init(),
        LogFormat::Pretty => builder.pretty().init(),
        LogFormat::Json => builder.json().flatten_event(true).init(),
    }
}

/// What is `wanted` of Flaneur's own crates, and warnings of all others: some of them log every line that they
/// compile. The clipboard is not heard: its thread complains of a display that has ended, which that says itself, and
/// what cannot be copied its callers log. What is `set` goes before.
fn filter(wanted: LevelFilter, set: Option<&str>) -> EnvFilter {
    match set.filter(|set| !set.trim().is_empty()) {
        Some(set) => EnvFilter::builder().parse_lossy(set),
        None => EnvFilter::new(format!("{},arboard=off,flaneur={wanted}", LevelFilter::WARN)),
    }
}

/// Writes each event above the progress bars instead of through them.
#[derive(Clone)]
struct ConsoleWriter(Console);

impl Write for ConsoleWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.suspend(|| io::stderr().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

impl MakeWriter<'_> for ConsoleWriter {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}

#[cfg(test)]
mod tests {
    use tracing::{Level, enabled, subscriber};

    use super::*;

    #[test]
    fn other_crates_say_no_more_than_warnings_unless_they_are_asked() {
        let within = |set, check: fn()| {
            let filter = filter(LevelFilter::TRACE, set);
            let quiet = tracing_subscriber::fmt().with_env_filter(filter).with_writer(io::sink);
            subscriber::with_default(quiet.finish(), check);
        };
        within(None, || {
            assert!(enabled!(target: "flaneur::commands", Level::TRACE));
            assert!(enabled!(target: "flaneur_streamer::load", Level::TRACE));
            assert!(enabled!(target: "naga::front", Level::WARN));
            assert!(!enabled!(target: "naga::front", Level::INFO));
            assert!(!enabled!(target: "arboard::platform::linux", Level::ERROR));
            assert!(enabled!(target: "egui_winit::clipboard", Level::ERROR));
        });
        within(Some("naga=debug"), || {
            assert!(enabled!(target: "naga::back", Level::DEBUG));
            assert!(!enabled!(target: "flaneur::commands", Level::TRACE));
        });
        within(Some("warn"), || {
            assert!(enabled!(target: "arboard::platform::linux", Level::ERROR));
        });
    }
}
