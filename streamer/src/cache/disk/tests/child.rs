//! This test's binary once more, as another process that uses a folder.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};

use super::*;

/// Says what the process is to do: `TASK FOLDER BYTES`.
const TASK: &str = "FLANEUR_CACHE_CHILD";
/// Payloads that one process writes.
pub(super) const WRITES: u32 = 300;

/// Another process at work. It is killed when dropped.
pub(super) struct Other {
    child: Child,
    lines: BufReader<std::process::ChildStdout>,
}

impl Other {
    /// Starts a process that inserts [`WRITES`] payloads and says so after each.
    pub(super) fn writing(folder: &Path, bytes: u64) -> Self {
        Self::start(&mut this_binary(folder, bytes))
    }

    pub(super) fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let lines = BufReader::new(child.stdout.take().expect("piped"));
        Self { child, lines }
    }

    /// Waits until it has written once more; false once it has ended.
    pub(super) fn has_written(&mut self) -> bool {
        let mut line = String::new();
        while self.lines.read_line(&mut line).expect("text") > 0 {
            if line.contains("inserted ") {
                return true;
            }
            line.clear();
        }
        false
    }

    /// Kills it, whatever it is doing.
    pub(super) fn kill(mut self) {
        self.child.kill().expect("it runs");
        self.child.wait().expect("it ends");
    }

    pub(super) fn ended(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().expect("ours")
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        // It has ended, or a test has failed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The command that runs [`the_other_process`].
pub(super) fn this_binary(folder: &Path, bytes: u64) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("this binary"));
    let name = module_path!().split_once("::").expect("below the crate").1;
    command.args(["--exact", &format!("{name}::the_other_process"), "--nocapture"]);
    command.env(TASK, format!("{bytes} {}", folder.display()));
    command
}

/// The payload that writers insert under a number: 0 to 20 kB.
pub(super) fn numbered(i: u32) -> (CacheKey, Bytes) {
    (key(&i.to_string()), payload(i, (i as usize * 7919) % 20_000))
}

/// What the other process does. Run among the tests it has nothing to do.
#[tokio::test]
async fn the_other_process() {
    let Ok(task) = std::env::var(TASK) else { return };
    tracing_subscriber::fmt().with_writer(std::io::stderr).with_ansi(false).init();
    let (bytes, folder) = task.split_once(' ').expect("two words");
    let disk = DiskOptions { folder: folder.into(), bytes: bytes.parse().expect("a number") };
    let options = CacheOptions { memory_bytes: 64 << 20, disk: Some(disk) };
    let cache = Cache::new(&options).expect("a folder");
    // From another place each, so that processes write the same and different ones.
    let start = std::process::id() % 50;
    for i in start..start + WRITES {
        let (key, payload) = numbered(i);
        cache.insert(&key, payload.clone(), Rank::Detail);
        // Every few, so that several wait while one is written.
        if i % 8 == 0 {
            cache.flush().await;
        }
        assert_eq!(cache.get(&key, None).await, Some(payload));
        println!("inserted {i}");
    }
    cache.flush().await;
    println!("counted {:?}", cache.statistics());
}
