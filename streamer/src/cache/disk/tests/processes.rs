//! Processes that share a folder, are killed, or find the disk full.

use std::process::{Command, Stdio};

use super::child::{Other, WRITES, numbered, this_binary};
use super::*;

/// Every payload that a folder has is sound; gives how many there are.
async fn sound_entries(folder: &Path, bytes: u64) -> usize {
    let cache = open(folder, bytes);
    cache.flush().await;
    let mut sound = 0;
    for i in 0..WRITES + 50 {
        let (key, payload) = numbered(i);
        if let Some(found) = cache.get(&key, None).await {
            assert_eq!(found, payload, "{i}");
            sound += 1;
        }
    }
    assert_eq!(cache.statistics().damaged, 0);
    let (files, _) = files(folder);
    assert_eq!(files.len(), sound, "nothing else is left: {files:?}");
    sound
}

#[tokio::test]
async fn a_process_that_is_killed_while_it_writes_leaves_whole_entries() {
    let folder = tempfile::tempdir().expect("a folder");
    let limit = 100 * 4096;
    let mut most = 0;
    for round in 0..12 {
        let mut other = Other::writing(folder.path(), limit);
        // At another point each time, while its thread writes what it has just inserted.
        for _ in 0..1 + 11 * round {
            assert!(other.has_written());
        }
        other.kill();
        assert!(files(folder.path()).1 <= limit);
        most = most.max(sound_entries(folder.path(), limit).await);
    }
    assert!(most > 10, "at most {most} were written");
}

#[tokio::test]
async fn processes_that_write_at_once_stay_within_the_bytes_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let limit = 60 * 4096;
    let mut others = [(); 3].map(|()| Other::writing(folder.path(), limit));
    let mut most = 0;
    while others.iter_mut().any(|other| other.ended().is_none()) {
        let (_, bytes) = files(folder.path());
        assert!(bytes <= limit, "{bytes}");
        most = most.max(bytes);
    }
    for other in &mut others {
        assert!(other.ended().expect("it has").success());
    }
    assert!(most > limit / 2, "at most {most} bytes were seen");
    assert!(sound_entries(folder.path(), limit).await > 10);
}

/// A file system of 256 KiB, where one may be mounted: writing stops with one warning, and
/// memory goes on.
#[test]
fn a_full_disk_is_warned_of_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let child = this_binary(folder.path(), 1 << 30);
    let mount = "mount -t tmpfs -o size=256k none \"$0\"";
    let may = Command::new("unshare").args(["-m", "sh", "-c", mount]).arg(folder.path()).output();
    if !may.is_ok_and(|output| output.status.success()) {
        println!("skipped: no file system can be mounted here");
        return;
    }
    let mut full = Command::new("unshare");
    full.args(["-m", "sh", "-c", &format!("{mount} && exec \"$@\"")]).arg(folder.path());
    full.arg(child.get_program()).args(child.get_args());
    full.envs(child.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let output = full.stderr(Stdio::piped()).output().expect("it starts");
    let stdout = String::from_utf8_lossy(&output.stdout);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stdout}{stderr}");
    let warnings: Vec<_> = stderr.lines().filter(|line| line.contains("WARN")).collect();
    assert_eq!(warnings.len(), 1, "{stderr}");
    assert!(warnings[0].contains("cannot be written"), "{stderr}");
    let counted = stdout.lines().find(|line| line.starts_with("counted")).expect("said");
    assert!(!counted.contains("not_written: 0"), "{counted}");
}
