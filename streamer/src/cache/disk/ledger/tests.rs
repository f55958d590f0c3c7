use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::SeqCst;

use super::*;

#[test]
fn one_writer_at_a_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ledger");
    let (writers, turns) = (AtomicU32::new(0), AtomicU32::new(0));
    thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let ledger = Ledger::open(&path).expect("a file");
                for _ in 0..20 {
                    let turn = ledger.turn().expect("it comes");
                    assert_eq!(writers.fetch_add(1, SeqCst), 0);
                    thread::yield_now();
                    turns.fetch_add(1, SeqCst);
                    assert_eq!(writers.fetch_sub(1, SeqCst), 1);
                    drop(turn);
                }
            });
        }
    });
    assert_eq!(turns.into_inner(), 80);
}

#[test]
fn who_comes_after_another_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let open = || Ledger::open(&folder.path().join("ledger")).expect("a file");
    let claim = |ledger: &Ledger| ledger.turn().expect("free").claim().expect("writable");
    let (one, other) = (open(), open());
    assert!(!claim(&one), "nobody has looked yet");
    assert!(claim(&one) && claim(&one));
    assert!(!claim(&other));
    assert!(claim(&other));
    assert!(!claim(&one));
}
