//! Results on stdout.

use std::io::{self, Write};

use serde::Serialize;

use crate::exit::Exit;

/// Prints text as it is. A reader who has gone away is a normal end.
pub(crate) fn print(text: &str) -> Result<(), Exit> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Prints a value as one indented JSON document.
pub(crate) fn print_json(value: &impl Serialize) -> Result<(), Exit> {
    print(&format!("{}\n", serde_json::to_string_pretty(value)?))
}
