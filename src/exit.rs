//! How a command ends, and what a person reads when it fails.

use std::process::ExitCode;

use crate::progress::Console;

/// Why a command did not end well. Codes: 0 success, 2 bad input or usage, 1 any other
/// failure, 130 interrupted.
#[derive(Debug)]
pub(crate) enum Exit {
    /// What the user gave is at fault: exit code 2.
    BadInput(anyhow::Error),
    /// Anything else: exit code 1.
    Failed(anyhow::Error),
    /// Ctrl-C: exit code 130.
    Interrupted,
}

impl Exit {
    /// Bad input, from an error or (through [`anyhow::anyhow!`]) a message.
    pub(crate) fn bad_input(error: impl Into<anyhow::Error>) -> Self {
        Self::BadInput(error.into())
    }

    /// A failure, from an error or (through [`anyhow::anyhow!`]) a message.
    pub(crate) fn failed(error: impl Into<anyhow::Error>) -> Self {
        Self::Failed(error.into())
    }

    /// What went wrong, on one line.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::BadInput(error) | Self::Failed(error) => one_line(error),
            Self::Interrupted => "interrupted".to_owned(),
        }
    }

    /// Prints the one line `flaneur: …` on stderr and gives the exit code.
    pub(crate) fn report(&self, console: &Console) -> ExitCode {
        let code = match self {
            Self::BadInput(_) => 2,
            Self::Failed(_) => 1,
            Self::Interrupted => 130,
        };
        console.line(&format!("flaneur: {}", self.message()));
        ExitCode::from(code)
    }
}

/// `?` on an error that says nothing else is a failure.
impl<E: std::error::Error + Send + Sync + 'static> From<E> for Exit {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}

/// The error and its causes on one line. A cause that its effect already quotes is left out.
fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain() {
        let text = cause.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        if line.is_empty() {
            line = text;
        } else if !line.contains(&text) {
            line.push_str(": ");
            line.push_str(&text);
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_follow_on_one_line_and_none_is_said_twice() {
        let error = anyhow::anyhow!("no such\n  file").context("cannot open \"a\"");
        assert_eq!(one_line(&error), "cannot open \"a\": no such file");
        let quoted = anyhow::anyhow!("denied").context("cannot write: denied; free some space");
        assert_eq!(one_line(&quoted), "cannot write: denied; free some space");
    }
}
