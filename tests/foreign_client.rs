//! A client in another language, driven by reflection alone, reads what `flaneur ingest` made of
//! a survey and `flaneur serve` serves, and decodes the points to the survey's own integers.
//!
//! `make test` sets up its Python.

mod python;
mod served;

use std::process::Command;

use python::python;
use served::{Served, flaneur};

#[test]
fn a_python_client_reads_a_whole_street_by_reflection() {
    let work = tempfile::tempdir().expect("a folder");
    let folder = |name: &str| work.path().join(name);
    let street = folder("street");
    flaneur(["sample".as_ref(), street.as_os_str(), "--scale".as_ref(), "0.2".as_ref()]);
    let (store, scratch) = (folder("store"), folder("work"));
    flaneur([
        "ingest".as_ref(),
        street.as_os_str(),
        "--out".as_ref(),
        store.as_os_str(),
        "--work".as_ref(),
        scratch.as_os_str(),
    ]);
    let served = Served::start(&[&store]);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/foreign_client.py");
    let output = Command::new(python())
        .arg(script)
        .arg(served.url.trim_start_matches("http://"))
        .arg(&street)
        .output()
        .expect("python starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{complaint}");
    assert!(text.contains("panoramas"), "{text}");
    assert!(served.stop().success(), "SIGTERM is a good end");
}
