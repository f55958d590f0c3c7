//! Has the page embedded anew when it has changed, and says so where it was changed but not built.

use std::path::Path;
use std::time::SystemTime;

fn main() {
    for place in ["web/dist", "web/src", "web/index.html"] {
        println!("cargo::rerun-if-changed={place}");
    }
    let built = modified(Path::new("web/dist/index.html"));
    let changed = newest(Path::new("web/src")).max(modified(Path::new("web/index.html")));
    if built.is_some() && changed > built {
        println!(
            "cargo::warning=the web page was changed since it was built: run `make web` first"
        );
    }
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|data| data.modified()).ok()
}

/// When the youngest file of a folder was changed; what is generated does not count.
fn newest(folder: &Path) -> Option<SystemTime> {
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let of_entry = |entry: std::fs::DirEntry| {
        let path = entry.path();
        if path.ends_with("gen") {
            return None;
        }
        if path.is_dir() { newest(&path) } else { modified(&path) }
    };
    entries.filter_map(of_entry).max()
}
