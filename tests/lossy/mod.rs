//! A network that delays and loses packets, in a namespace of its own.

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Where a server listens.
pub(crate) const SERVER: &str = "10.99.0.1";
/// Where it is reached, over the network.
pub(crate) const CLIENT: &str = "10.99.0.2";

/// Says to this binary that it runs within the namespace.
const WITHIN: &str = "FLANEUR_TEST_NETWORK";

/// Runs `test`, whose name is `name`, within a network namespace, or prints why it cannot.
pub(crate) fn in_a_network_of_its_own(name: &str, test: impl FnOnce()) {
    if within() {
        return test();
    }
    // Interfaces may be made by whoever is root, be it only in a namespace of users.
    let ways: [&[&str]; 2] = [&["--net"], &["--net", "--map-root-user"]];
    let may = |how: &[&str]| {
        let try_it = "ip link set lo up && ip tuntap add dev try mode tun && python3 --version";
        let tried = Command::new("unshare").args(how).args(["sh", "-c", try_it]).output();
        tried.is_ok_and(|output| output.status.success())
    };
    let Some(how) = ways.into_iter().find(|how| may(how)) else {
        println!("skipped: this needs `unshare --net`, `ip tuntap` and python3");
        return;
    };
    let status = Command::new("unshare")
        .args(how)
        .args(["sh", "-c", "ip link set lo up && exec \"$@\"", "sh"])
        .arg(std::env::current_exe().expect("this binary"))
        .args(["--exact", name, "--nocapture"])
        .env(WITHIN, "1")
        .status()
        .expect("it starts");
    assert!(status.success(), "{status}");
}

/// Whether this process runs within such a namespace.
pub(crate) fn within() -> bool {
    std::env::var_os(WITHIN).is_some()
}

/// The network. It is gone when this is dropped.
pub(crate) struct Lossy {
    process: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

impl Lossy {
    /// One that delays each packet and loses some, each way. Which, is always the same.
    pub(crate) fn start(delay_ms: u32, loss_percent: u32) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/lossy/link.py");
        let mut process = Command::new("python3")
            .arg(script)
            .args(["lossy".to_owned(), delay_ms.to_string(), loss_percent.to_string()])
            .arg("7")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let input = process.stdin.take();
        let output = BufReader::new(process.stdout.take().expect("piped"));
        let mut this = Self { process, input, output };
        assert_eq!(this.line(), "ready");
        this
    }

    /// Ends it; how many packets it has lost.
    pub(crate) fn stop(mut self) -> u64 {
        drop(self.input.take());
        let line = self.line();
        println!("{line}");
        line.split_whitespace().last().and_then(|word| word.parse().ok()).expect("a number")
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("text");
        line.trim().to_owned()
    }
}

impl Drop for Lossy {
    fn drop(&mut self) {
        // It has ended with its input, unless a test has failed.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
