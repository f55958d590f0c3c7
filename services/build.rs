//! Has the page embedded anew when it has changed.

fn main() {
    println!("cargo::rerun-if-changed=web/dist");
}
