//! Points to COPC: rate and peak memory, beside `copc_converter` where it is installed.
//!
//! ```text
//! cargo bench -p flaneur-services --bench points -- [--points N] [--memory-mib M] [FILE.laz …]
//! ```
//!
//! Without files, a simulated drive of `--points` points (20 million) is made once, in the
//! folder for temporary files. `COPC_CONVERTER` names the peer's program, by default
//! `copc_converter` on the path. Ours runs twice: with the same limit as the peer, and with
//! what the peer then took as its limit, which sorts on disk. Each program runs in a process of its own, whose peak
//! resident memory is read from `/proc`; both results are read back and must hold every
//! point.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use flaneur_services::ingest::Job;
use flaneur_services::ingest::points::{PointsInput, ingest_points};
use las::point::Format;
use las::{Builder, Color, Point, Transform, Vector, Writer};

struct Settings {
    points: u64,
    memory_mib: u64,
    files: Vec<PathBuf>,
    /// Where a child process puts its result.
    child: Option<PathBuf>,
}

fn main() -> Result<()> {
    let mut settings = settings()?;
    if let Some(work) = &settings.child {
        let input = PointsInput { name: "points".into(), files: settings.files };
        let job = Job::new(work, settings.memory_mib << 20);
        ingest_points(&job, &[input])?;
        return Ok(());
    }
    let folder = std::env::temp_dir().join("flaneur-bench-points");
    fs::create_dir_all(&folder)?;
    if settings.files.is_empty() {
        settings.files.push(drive(&folder, settings.points)?);
    }
    let points = settings.files.iter().map(|file| count(file)).sum::<Result<u64>>()?;
    println!(
        "{:<20} {:>10} {:>8} {:>12} {:>10} {:>10}",
        "program, limit MiB", "points", "s", "points/s", "peak MiB", "file MB"
    );

    let ours = |memory_mib: u64| -> Result<u64> {
        let work = folder.join("ours");
        let _ = fs::remove_dir_all(&work);
        fs::create_dir_all(&work)?;
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("--child").arg(&work).arg("--memory-mib").arg(memory_mib.to_string());
        command.args(&settings.files);
        let name = format!("flaneur {memory_mib}");
        measure(&name, command, points, &work.join("points.copc.laz"))
    };
    ours(settings.memory_mib)?;

    let peer = std::env::var_os("COPC_CONVERTER").unwrap_or_else(|| "copc_converter".into());
    let input = match settings.files.as_slice() {
        [file] => file.clone(),
        files => common(files)?,
    };
    let output = folder.join("peer.copc.laz");
    let mut command = Command::new(&peer);
    command.arg(input).arg(&output).args(["--progress", "plain"]);
    command.arg("--memory-limit").arg(format!("{}Mi", settings.memory_mib));
    let name = format!("copc_converter {}", settings.memory_mib);
    match measure(&name, command, points, &output) {
        Err(error) if error.is::<NotInstalled>() => println!("copc_converter is not installed"),
        // Once more, allowed no more than the peer took.
        peak_mib => {
            ours(peak_mib?)?;
        }
    }
    Ok(())
}

fn settings() -> Result<Settings> {
    let mut settings =
        Settings { points: 20_000_000, memory_mib: 2048, files: Vec::new(), child: None };
    let mut arguments = std::env::args_os().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || -> Result<OsString> {
            arguments.next().with_context(|| format!("no value after {argument:?}"))
        };
        let number = |value: OsString| -> Result<u64> {
            value.to_str().and_then(|text| text.parse().ok()).context("not a number")
        };
        match argument.to_str() {
            Some("--points") => settings.points = number(value()?)?,
            Some("--memory-mib") => settings.memory_mib = number(value()?)?,
            Some("--child") => settings.child = Some(value()?.into()),
            // What `cargo bench` passes to every bench.
            Some("--bench") => {}
            _ => settings.files.push(argument.into()),
        }
    }
    Ok(settings)
}

#[derive(Debug, thiserror::Error)]
#[error("the program is not installed")]
struct NotInstalled;

/// Runs a program that makes `result`, and prints a line about it. Returns its peak memory in
/// MiB.
fn measure(name: &str, mut command: Command, points: u64, result: &Path) -> Result<u64> {
    let start = Instant::now();
    let mut child = match command.stdout(Stdio::null()).stderr(Stdio::null()).spawn() {
        Ok(child) => child,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => bail!(NotInstalled),
        Err(error) => return Err(error.into()),
    };
    let mut peak_kib = 0;
    let status = loop {
        peak_kib = peak_memory_kib(&child).unwrap_or(peak_kib);
        match child.try_wait()? {
            Some(status) => break status,
            None => sleep(Duration::from_millis(10)),
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    if !status.success() {
        bail!("{name} failed: {status}");
    }
    let kept = count(result)?;
    if kept != points {
        bail!("{name} kept {kept} of {points} points");
    }
    println!(
        "{name:<20} {points:>10} {seconds:>8.2} {:>12.0} {:>10} {:>10.1}",
        points as f64 / seconds,
        peak_kib / 1024,
        fs::metadata(result)?.len() as f64 / 1e6,
    );
    Ok(peak_kib / 1024)
}

/// The most memory that the child has had resident so far; `None` once it has ended.
fn peak_memory_kib(child: &Child) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

fn count(path: &Path) -> Result<u64> {
    Ok(las::Reader::from_path(path)?.header().number_of_points())
}

fn common(files: &[PathBuf]) -> Result<PathBuf> {
    let folder = files[0].parent().context("no folder")?;
    if files.iter().any(|file| file.parent() != Some(folder)) {
        bail!("the peer reads one file or one folder: put the files in a folder of their own");
    }
    Ok(folder.to_owned())
}

/// A drive down a street of 1 km, as a scanner on a car records it: lines across the street
/// over ground, facades and trees, in order of time, point format 3.
fn drive(folder: &Path, points: u64) -> Result<PathBuf> {
    let path = folder.join(format!("drive-{points}.laz"));
    if path.exists() {
        return Ok(path);
    }
    let mut builder = Builder::from((1, 2));
    builder.point_format = Format::new(3)?;
    builder.point_format.is_compressed = true;
    let transform = |offset| Transform { scale: 0.001, offset };
    builder.transforms =
        Vector { x: transform(651_000.0), y: transform(6_861_000.0), z: transform(0.0) };
    let part = folder.join("drive.part");
    let mut writer =
        Writer::new(std::io::BufWriter::new(fs::File::create(&part)?), builder.into_header()?)?;
    let mut state = 1u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    for i in 0..points {
        let time = i as f64 / points as f64;
        let along = 1000.0 * time;
        let angle = std::f64::consts::TAU * (i % 1000) as f64 / 1000.0;
        let (sin, cos) = angle.sin_cos();
        // From 2 m above the ground between facades 8 m to either side, or into a tree.
        let to_ground = if sin < 0.0 { -2.0 / sin } else { f64::INFINITY };
        let to_facade = 8.0 / cos.abs().max(1e-9);
        let tree = (along % 12.0) < 4.0 && sin > 0.3 && random() < 0.4;
        let reach = to_ground.min(to_facade).min(30.0);
        let range = if tree { reach * random() } else { reach } + 0.01 * (random() - 0.5);
        let grey = (40_000.0 + 20_000.0 * random()) as u16;
        writer.write_point(Point {
            x: 651_000.0 + along,
            y: 6_861_000.0 + range * cos,
            z: 32.0 + range * sin,
            intensity: (65_535.0 * random()) as u16,
            return_number: 1,
            number_of_returns: 1,
            scan_angle: (angle.to_degrees() - 180.0).clamp(-90.0, 90.0) as f32,
            gps_time: Some(3e5 + 200.0 * time),
            color: Some(Color::new(grey, grey, (grey / 256 + i as u16 % 7) * 200)),
            ..Default::default()
        })?;
    }
    writer.close()?;
    drop(writer);
    fs::rename(part, &path)?;
    Ok(path)
}
