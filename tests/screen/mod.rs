//! A screen that nobody sees: Xvfb, what is on it, and hands to use it.
//!
//! `make test` installs what it takes.

#![allow(dead_code, reason = "each test file is a crate and uses its share")]

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use image::RgbImage;
use tempfile::TempDir;

/// Where the server keeps the picture of its first screen.
const FRAME: &str = "Xvfb_screen0";

/// An X server on a display of its own. It ends with the value.
pub(crate) struct Screen {
    server: Child,
    frames: TempDir,
    /// `:NUMBER`, for the variable `DISPLAY`.
    pub(crate) display: String,
}

impl Screen {
    /// One of `size` pixels, 24 bits each.
    pub(crate) fn start(size: [u32; 2]) -> Self {
        let frames = tempfile::tempdir().expect("a folder");
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("{}x{}x24", size[0], size[1]))
            .arg("-fbdir")
            .arg(frames.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts: run `make test`, which installs it");
        let mut number = String::new();
        let stdout = server.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut number).expect("text");
        let display = format!(":{}", number.trim());
        assert!(display.len() > 1, "Xvfb says which display it is");
        Self { server, frames, display }
    }

    /// What is on it now.
    pub(crate) fn picture(&self) -> RgbImage {
        let file = std::fs::read(self.frames.path().join(FRAME)).expect("Xvfb keeps it");
        decoded(&file)
    }

    /// Does something as a person would; `xdotool` says what there is.
    pub(crate) fn act(&self, what: &[&str]) -> String {
        let done = Command::new("xdotool")
            .args(what)
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool starts: run `make test`, which installs it");
        assert!(done.status.success(), "{what:?}: {}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).expect("text")
    }

    /// What was copied last; nothing where nothing was.
    pub(crate) fn clipboard(&self) -> String {
        let pasted = Command::new("xclip")
            .args(["-out", "-selection", "clipboard"])
            .env("DISPLAY", &self.display)
            .output()
            .expect("xclip starts: run `make test`, which installs it");
        String::from_utf8(pasted.stdout).expect("text")
    }

    /// Waits for a window with `title` in its title, and has it take what is typed.
    pub(crate) fn focus(&self, title: &str) {
        let found = self.act(&["search", "--sync", "--onlyvisible", "--name", title]);
        let window = found.lines().next().expect("a window").to_owned();
        self.act(&["windowfocus", "--sync", &window]);
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        drop(self.server.kill());
        drop(self.server.wait());
    }
}

/// The picture of an XWD file of 32 bits a pixel: words of four bytes, the highest first, then a
/// table of colours, then rows of blue, green, red and nothing.
fn decoded(file: &[u8]) -> RgbImage {
    let word = |index: usize| {
        let bytes = file[4 * index..4 * index + 4].try_into().expect("four bytes");
        u32::from_be_bytes(bytes) as usize
    };
    let (header, width, height) = (word(0), word(4), word(5));
    let (bits, stride, colours) = (word(11), word(12), word(19));
    assert_eq!(bits, 32, "bits a pixel");
    let pixels = &file[header + 12 * colours..];
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let at = y as usize * stride + 4 * x as usize;
        image::Rgb([pixels[at + 2], pixels[at + 1], pixels[at]])
    })
}
