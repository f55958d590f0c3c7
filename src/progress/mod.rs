//! What a person sees of work under way: bars on a terminal, plain lines elsewhere, always
//! on stderr.

mod amount;
mod bars;
mod lines;

use std::io::{self, IsTerminal, Write};

use flaneur_services::ingest::{Progress, Stage, Unit};
use indicatif::MultiProgress;

/// The process's stderr: bars, and lines that do not tear them.
#[derive(Clone)]
pub(crate) struct Console {
    bars: MultiProgress,
    is_terminal: bool,
}

impl Console {
    /// The process's stderr as it is.
    pub(crate) fn new() -> Self {
        Self { bars: MultiProgress::new(), is_terminal: io::stderr().is_terminal() }
    }

    /// Prints one line above the bars.
    pub(crate) fn line(&self, text: &str) {
        // Where stderr is closed there is nobody to tell.
        self.suspend(|| drop(writeln!(io::stderr(), "{text}")));
    }

    /// Runs `write`, which may write to stderr, while no bar is drawn.
    pub(crate) fn suspend<R>(&self, write: impl FnOnce() -> R) -> R {
        self.bars.suspend(write)
    }
}

impl Progress for Console {
    fn stage(&self, name: &str, total: u64, unit: Unit) -> Box<dyn Stage> {
        if self.is_terminal {
            Box::new(bars::BarStage::new(&self.bars, name, total, unit))
        } else {
            Box::new(lines::LineStage::new(self.clone(), name, total, unit))
        }
    }
}
