//! Files and connections that the system lets a process have open at a time.

/// Files that a server opens beside its connections: of its stores one for each read, of drivers some.
const FILES: u64 = 640;

/// Has the system grant as many as it may, and returns how many of the `wanted` connections it has room for:
/// more would be left hanging, and files could not be read any more.
pub(crate) fn connections(wanted: usize) -> usize {
    let Some(granted) = granted() else { return wanted };
    let room = room(granted, wanted);
    if room < wanted {
        tracing::warn!(
            granted,
            connections = room,
            "the system grants few open files; more with `ulimit -n`, or LimitNOFILE= of systemd"
        );
    }
    room
}

fn room(granted: u64, wanted: usize) -> usize {
    let room = granted.saturating_sub(FILES).max(granted / 2);
    usize::try_from(room).unwrap_or(usize::MAX).min(wanted)
}

/// The most files there may be, once the soft limit is as high as the hard one; `None` without limit.
#[cfg(unix)]
fn granted() -> Option<u64> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if current == maximum {
        return current;
    }
    match setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum }) {
        Ok(()) => maximum,
        Err(error) => {
            tracing::debug!(%error, "the number of open files stays as it is");
            current
        }
    }
}

#[cfg(not(unix))]
fn granted() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_leave_room_for_files() {
        assert_eq!(room(1 << 20, 10_000), 10_000);
        assert_eq!(room(4096, 10_000), 4096 - 640);
        assert_eq!(room(1024, 10_000), 512);
        assert_eq!(room(1024, 100), 100);
    }
}
