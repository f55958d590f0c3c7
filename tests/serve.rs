//! What `flaneur serve` says to a person who asks for something it cannot do.

use std::path::Path;
use std::process::Command;

/// Exit code and message of `flaneur serve` with these arguments, which must refuse at once.
fn refusal(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_flaneur"))
        .arg("serve")
        .args(arguments)
        .output()
        .expect("the binary starts");
    assert!(output.stdout.is_empty(), "nothing is served");
    (output.status.code(), String::from_utf8(output.stderr).expect("text"))
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a temporary folder has a plain name")
}

#[test]
fn what_cannot_be_served_is_one_line_with_a_remedy_and_code_2() {
    let work = tempfile::tempdir().expect("a folder");
    let absent = work.path().join("absent");
    let (code, message) = refusal(&[text(&absent)]);
    assert_eq!((code, message.lines().count()), (Some(2), 1), "{message}");
    assert!(message.contains("absent") && message.contains("flaneur ingest"), "{message}");
    assert!(!absent.exists(), "nothing is made");

    let (code, message) = refusal(&["ftp://host/scenes"]);
    assert_eq!((code, message.lines().count()), (Some(2), 1), "{message}");
    assert!(message.contains("ftp") && message.contains("s3://"), "{message}");

    let file = work.path().join("file");
    std::fs::write(&file, b"x").expect("writable");
    let (code, message) = refusal(&[text(&file)]);
    assert_eq!((code, message.lines().count()), (Some(2), 1), "{message}");

    let (code, message) = refusal(&[text(work.path()), "--allow-origin", "maps.example.org"]);
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("https://host"), "{message}");

    let (code, message) = refusal(&[]);
    assert_eq!(code, Some(2), "{message}");
    let (code, message) = refusal(&[text(work.path()), "--listen", "nowhere"]);
    assert_eq!(code, Some(2), "{message}");
}

#[test]
fn a_port_in_use_is_named() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = taken.local_addr().expect("bound").to_string();
    let work = tempfile::tempdir().expect("a folder");
    let (code, message) = refusal(&[text(work.path()), "--listen", &address]);
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains(&address) && message.contains("--listen"), "{message}");
}

#[test]
fn the_same_scene_in_two_stores_names_both() {
    let work = tempfile::tempdir().expect("a folder");
    let stores = ["one", "two"].map(|name| work.path().join(name));
    for store in &stores {
        std::fs::create_dir_all(store.join("street")).expect("writable");
        std::fs::write(store.join("street/scene.json"), b"{}").expect("writable");
    }
    let (code, message) = refusal(&stores.each_ref().map(|store| text(store)));
    assert_eq!((code, message.lines().count()), (Some(2), 1), "{message}");
    for name in ["street", text(&stores[0]), text(&stores[1])] {
        assert!(message.contains(name), "{message}");
    }
}
