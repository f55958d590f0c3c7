//! `flaneur view` as a person uses it, on a screen that nobody sees.

mod command;
mod screen;
mod served;
mod street;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use command::{flaneur, run, succeed, text};
use image::RgbImage;
use screen::Screen;
use serde_json::Value;
use served::Served;
use street::SampleStreet;

/// The sides of the window, pixels.
const SIZE: [u32; 2] = [640, 360];
/// How long anything may take.
const PATIENCE: Duration = Duration::from_secs(120);
/// Two pictures of one view differ by less than this, of 255 on average: where one stands is said to
/// the millimetre.
const ALIKE: f64 = 1.0;
/// Two of different views by more.
const DIFFERENT: f64 = 6.0;

/// A window, and what it logs.
struct Window {
    process: Child,
    lines: Receiver<Value>,
}

impl Window {
    fn open(source: &str, view: &str, screen: &Screen) -> Self {
        let mut process = flaneur()
            .args(["--log-format", "json", "view", source, "--view", view])
            .args(["--size", &format!("{}x{}", SIZE[0], SIZE[1])])
            .env("DISPLAY", &screen.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("RUST_LOG", "warn,flaneur=debug")
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary");
        let stderr = BufReader::new(process.stderr.take().expect("piped"));
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in stderr.lines().map_while(Result::ok) {
                let line = serde_json::from_str(&line).unwrap_or(Value::String(line));
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self { process, lines }
    }

    /// Where one comes to stand next, as `--view` takes it, after `what`.
    fn stands(&self, what: &str) -> String {
        self.logs("stands", what)["view"].as_str().expect("a view").to_owned()
    }

    /// What it logs next that begins with `message`, after `what`.
    fn logs(&self, message: &str, what: &str) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left);
            let line = line.unwrap_or_else(|_| panic!("nothing {message} {what}"));
            eprintln!("{line}");
            if line["message"].as_str().is_some_and(|said| said.starts_with(message)) {
                return line;
            }
        }
    }

    /// Asks it to end; its exit code, and what it says last.
    fn interrupted(mut self) -> (Option<i32>, Value) {
        let told = std::process::Command::new("kill")
            .args(["-INT", &self.process.id().to_string()])
            .status()
            .expect("kill starts");
        assert!(told.success());
        let status = self.process.wait().expect("it ends");
        (status.code(), self.lines.iter().last().expect("it says something"))
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// What renders the same views into files.
struct Darkroom {
    store: PathBuf,
}

impl Darkroom {
    /// The picture of `view`, and how much of it there is to see.
    fn picture(&self, view: &str, mode: &str) -> RgbImage {
        let out = self.store.with_file_name("expected.png");
        let size = format!("{}x{}", SIZE[0], SIZE[1]);
        let what = ["--view", view, "--mode", mode, "--size", &size, "-o", text(&out)];
        succeed(&[&["render", text(&self.store)], &what[..]].concat());
        image::open(&out).expect("written").into_rgb8()
    }
}

/// Waits until the window shows `expected`.
fn await_picture(screen: &Screen, expected: &RgbImage, what: &str) {
    let until = Instant::now() + PATIENCE;
    loop {
        let shown = window_of(&screen.picture());
        let difference = difference(&shown, expected);
        if difference < ALIKE {
            return;
        }
        if Instant::now() > until {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
            shown.save(folder.join("view-shown.png")).expect("writable");
            expected.save(folder.join("view-expected.png")).expect("writable");
            panic!("{what}: differs by {difference:.2}; see view-*.png in {}", folder.display());
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// The part of a screen that the window covers: nobody moves it from its corner.
fn window_of(screen: &RgbImage) -> RgbImage {
    image::imageops::crop_imm(screen, 0, 0, SIZE[0], SIZE[1]).to_image()
}

/// The mean difference of two pictures' bytes.
fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

/// East, north and up of a view.
fn position(view: &str) -> [f64; 3] {
    let numbers: Vec<f64> = view.split(',').map(|n| n.parse().expect("a number")).collect();
    [numbers[0], numbers[1], numbers[2]]
}

/// One window, used as a person would use it.
#[test]
fn one_walks_about_a_street() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("view"));
    let darkroom = Darkroom { store: street.store.clone() };
    let screen = Screen::start([800, 600]);
    // On the road, looking down the street and a little down, which the window is told as a scene's file.
    let start = "651487.5,6861042.9,44.2,35,-4";
    let manifest = street.store.join("sample/scene.json");
    let window = Window::open(text(&manifest), start, &screen);
    screen.focus("sample - Flaneur");
    // The hint goes with the first key.
    screen.act(&["key", "Escape"]);
    let stands = window.stands("at first");
    assert!(position(&stands) == position(start) && stands.ends_with("35.000,-4.000"), "{stands}");
    let first = darkroom.picture(&stands, "hybrid");
    assert!(is_a_street(&first), "the street itself has something to show");
    await_picture(&screen, &first, "the street");

    // A mode of its own, and back.
    screen.act(&["key", "8"]);
    let depth = darkroom.picture(&stands, "depth");
    assert!(difference(&depth, &first) > DIFFERENT);
    await_picture(&screen, &depth, "its depth");
    screen.act(&["key", "1"]);
    await_picture(&screen, &first, "the street again");

    // Figures lie over it, until they do not.
    screen.act(&["key", "o"]);
    await_change(&screen, &first);
    screen.act(&["key", "F1"]);
    await_picture(&screen, &first, "the street without figures");

    // A step ahead, to the north-east.
    screen.act(&["keydown", "w"]);
    std::thread::sleep(Duration::from_millis(400));
    screen.act(&["keyup", "w"]);
    let ahead = window.stands("after a step");
    let walked = way(&stands, &ahead);
    assert!(walked[0] > 0.2 && walked[1] > 0.2, "{walked:?}");
    assert!((walked[0].atan2(walked[1]).to_degrees() - 35.0).abs() < 0.5, "straight: {walked:?}");
    let second = darkroom.picture(&ahead, "hybrid");
    assert!(difference(&second, &first) > DIFFERENT, "the step shows");
    await_picture(&screen, &second, "the street from further on");

    // A click on the road goes there, stands on it, and looks on as before.
    screen.act(&["mousemove", "320", "300", "click", "1"]);
    let there = window.stands("where one clicked");
    let gone = way(&ahead, &there);
    let distance = gone[0].hypot(gone[1]);
    // The pixel is 25 degrees below the horizon; where it shows the road one stands with one's eyes 1.6 m
    // above it.
    let focal = 180.0 / 30f64.to_radians().tan();
    let below = |row: f64| (((row - 180.0) / focal).atan() + 4f64.to_radians()).tan();
    assert!((2.0..12.0).contains(&distance), "{gone:?}");
    assert!((gone[2] - (1.6 - distance * below(300.0))).abs() < 0.1, "{gone:?}");
    assert!(there.ends_with("35.000,-4.000"), "{there}");
    screen.act(&["key", "Escape"]);
    let from_there = darkroom.picture(&there, "hybrid");
    await_picture(&screen, &from_there, "the street where one clicked");

    // Two clicks measure across the road ahead.
    screen.act(&["key", "m", "mousemove", "240", "290", "click", "1"]);
    // A list comes up where the pointer is, and is not where the next click is.
    await_list(&screen, &from_there);
    screen.act(&["mousemove", "400", "290", "click", "1"]);
    let measured = window.logs("measured", "across the road")["distance_m"].as_f64();
    let measured = measured.expect("metres");
    // So wide at the depth where the ray meets the road, which rises by some two in a hundred and was
    // surveyed to some centimetres.
    let down = (110.0 / focal) * 4f64.to_radians().cos() + 4f64.to_radians().sin();
    let across = |height: f64, rise: f64| 160.0 / focal * height / (down + rise);
    let [least, most] = [across(1.55, 0.03), across(1.65, 0.0)];
    assert!((least..most).contains(&measured), "{measured}, not {least} to {most}");
    screen.act(&["key", "Escape"]);

    // Level, up, and level again.
    screen.act(&["key", "Home"]);
    let level = window.stands("level");
    assert!(level.ends_with("35.000,0.000") && position(&level) == position(&there), "{level}");
    screen.act(&["key", "Prior"]);
    let up = window.stands("after looking up");
    let pitch: f64 = up.rsplit(',').next().expect("a pitch").parse().expect("a number");
    assert!((2.0..40.0).contains(&pitch) && position(&up) == position(&there), "{up}");
    screen.act(&["key", "Home"]);
    assert_eq!(window.stands("level again"), level);

    // Dragging turns, by what the picture moves.
    screen.act(&["mousemove", "200", "180", "mousedown", "1"]);
    for x in ["240", "280", "320"] {
        screen.act(&["mousemove", x, "180"]);
    }
    screen.act(&["mouseup", "1"]);
    let turned = window.stands("after turning");
    assert_eq!(position(&turned), position(&there));
    // 60 degrees from the bottom to the top; from 120 pixels left of the centre to the centre.
    let expected = 35.0 - (120.0 / focal).atan().to_degrees();
    let heading: f64 = turned.split(',').nth(3).expect("a heading").parse().expect("a number");
    assert!((heading - expected).abs() < 0.1, "{heading}, not {expected}");
    let left = darkroom.picture(&turned, "hybrid");
    await_picture(&screen, &left, "the street to the left");

    // Two clicks on the road go to the photograph that was taken nearest to there.
    screen.act(&["mousemove", "320", "300", "click", "--repeat", "2", "--delay", "100", "1"]);
    let mut photograph = window.stands("after a double click");
    while off_the_way(&street, &photograph) > 1.0 {
        // One had come to where the first click led.
        photograph = window.stands("where a photograph was taken");
    }
    let (code, said) = window.interrupted();
    assert_eq!((code, said), (Some(130), Value::String("flaneur: interrupted".to_owned())));

    // A service shows the same.
    let served = Served::start(&[&street.store]);
    let window = Window::open(&served.url, &turned, &screen);
    screen.focus("sample - Flaneur");
    screen.act(&["key", "Escape"]);
    assert_eq!(window.stands("before a service"), turned);
    await_picture(&screen, &left, "the street of a service");
    // Once that is gone, one hears what cannot be done, and what can be seen stays.
    assert!(served.stop().success());
    screen.act(&["key", "g"]);
    window.logs("the nearest photograph cannot be had", "without its service");
    screen.act(&["key", "Escape"]);
    await_picture(&screen, &left, "the street of a service that is gone");
}

/// Houses are stood before, and photographs gone to that see what was clicked.
#[test]
fn one_goes_along_walls_and_to_photographs_that_see_a_place() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("view-walls"));
    let darkroom = Darkroom { store: street.store.clone() };
    let screen = Screen::start([800, 600]);
    let start = "651487.5,6861042.9,44.2,35,-4";
    let window = Window::open(text(&street.store), start, &screen);
    screen.focus("sample - Flaneur");
    screen.act(&["key", "Escape"]);
    assert_eq!(position(&window.stands("at first")), position(start));
    let first = darkroom.picture(start, "hybrid");
    await_picture(&screen, &first, "the street");

    // The road ahead is seen by photographs, a list of which comes up in the corner on the left.
    screen.act(&["key", "m", "mousemove", "320", "290", "click", "1"]);
    let placed = window.logs("placed", "where one clicked");
    let source = placed["source"].as_str().expect("the road was surveyed");
    assert!(source.starts_with("lidar"), "{placed}");
    await_list(&screen, &first);
    let copied = copied(&screen);
    let place: Vec<f64> = copied.split(", ").map(|metres| metres.parse().expect(&copied)).collect();
    let [x, y, z] = position(start);
    let away = (place[0] - x).hypot(place[1] - y);
    assert!((2.0..12.0).contains(&away) && (2.0..3.5).contains(&(z - place[2])), "{copied}");
    // Who copies with the keyboard measures nothing in the middle by that.
    for key in ["Tab", "Return", "Tab", "Return"] {
        screen.act(&["key", key]);
        std::thread::sleep(Duration::from_millis(300));
    }
    let until = Instant::now() + PATIENCE;
    while screen.clipboard() == copied {
        assert!(Instant::now() < until, "nothing else was copied");
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_secs(1));
    let also: Vec<Value> = window.lines.try_iter().collect();
    assert!(also.iter().all(|line| line["message"] != "measured"), "{also:?}");
    screen.act(&["key", "Escape"]);
    screen.act(&["mousemove", "40", "310", "click", "1"]);
    let developed = window.logs("developed", "after choosing a photograph");
    let side = |name: &str| developed[name].as_u64().expect("pixels");
    assert!((100..=512).contains(&side("width")) && side("height") <= 234, "{developed}");
    await_yellow(&screen);
    // The button below it on the left.
    let y = 180 + side("height") / 2 + 18;
    screen.act(&["mousemove", "200", &y.to_string(), "click", "1"]);
    let photograph = window.stands("where a photograph was taken");
    assert!(off_the_way(&street, &photograph) < 1.0, "{photograph}");
    assert_ne!(position(&photograph), position(start));
    // That was no click on the street: the next one is the second.
    screen.act(&["mousemove", "400", "300", "click", "1"]);
    window.logs("measured", "to where one clicked from there");
    screen.act(&["key", "Escape"]);

    // To the right, as far as one gets.
    screen.act(&["keydown", "Shift", "keydown", "d"]);
    std::thread::sleep(Duration::from_secs(4));
    screen.act(&["keyup", "d", "keyup", "Shift"]);
    let before_wall = window.stands("before a wall");
    let walked = way(&photograph, &before_wall);
    let off = off_houses(&street, &before_wall);
    assert!((0.3..2.5).contains(&off), "{off} from a house, after {walked:?}");

    // Of its mesh, which has no points, it is said of which house it is: ahead, to the right.
    screen.act(&["key", "2"]);
    await_picture(&screen, &darkroom.picture(&before_wall, "mesh"), "the mesh alone");
    screen.act(&["key", "m", "mousemove", "600", "150", "click", "1"]);
    let placed = window.logs("placed", "where one clicked on a wall");
    let house = placed["footprint"].as_str().unwrap_or_else(|| panic!("no house: {placed}"));
    assert!(houses(&street).iter().any(|known| known["id"] == house), "{placed}");
    assert_eq!(placed["source"], Value::Null);
}

/// The houses of the survey.
fn houses(street: &SampleStreet) -> Vec<Value> {
    let cadastre = std::fs::read(street.survey.join("footprints.geojson")).expect("the cadastre");
    let cadastre: Value = serde_json::from_slice(&cadastre).expect("JSON");
    cadastre["features"].as_array().expect("houses").clone()
}

/// From a view to the nearest wall, metres of the plan; below 0 inside of a house.
fn off_houses(street: &SampleStreet, view: &str) -> f64 {
    let [x, y, _] = position(view);
    let number = |value: &Value| value.as_f64().expect("a number");
    let (mut nearest, mut inside) = (f64::INFINITY, false);
    for feature in houses(street) {
        let ring = feature["geometry"]["coordinates"][0].as_array().expect("a ring");
        for edge in ring.windows(2) {
            let [a, b] = [0, 1].map(|end| [number(&edge[end][0]) - x, number(&edge[end][1]) - y]);
            let along = [b[0] - a[0], b[1] - a[1]];
            let share = -(a[0] * along[0] + a[1] * along[1]) / along[0].hypot(along[1]).powi(2);
            let share = share.clamp(0.0, 1.0);
            nearest = nearest.min((a[0] + share * along[0]).hypot(a[1] + share * along[1]));
            inside ^= (a[1] > 0.0) != (b[1] > 0.0) && 0.0 < a[0] - a[1] * along[0] / along[1];
        }
    }
    if inside { -nearest } else { nearest }
}

/// From a view to the nearest place where a photograph was taken, metres of the plan. The cameras of a
/// rig stand within decimetres of its place.
fn off_the_way(street: &SampleStreet, view: &str) -> f64 {
    let [x, y, _] = position(view);
    let poses = std::fs::read(street.survey.join("poses.json")).expect("the survey's poses");
    let poses: Vec<Value> = serde_json::from_slice(&poses).expect("JSON");
    let spheres = std::fs::read_to_string(street.survey.join("equirectangular.csv"));
    let spheres = spheres.expect("the survey's spheres");
    let number = |value: &Value| value.as_f64().expect("a number");
    let of_poses = poses.iter().map(|pose| [number(&pose["easting"]), number(&pose["northing"])]);
    let of_spheres = spheres.lines().skip(1).map(|line| {
        let mut fields = line.split(',').skip(1).map(|field| field.parse().expect("a number"));
        [fields.next().expect("x"), fields.next().expect("y")]
    });
    let distances = of_poses.chain(of_spheres).map(|place| (place[0] - x).hypot(place[1] - y));
    distances.fold(f64::INFINITY, f64::min)
}

/// Who sees nothing of the street is led back to where a visit begins; who looks at the sky over it is not.
#[test]
fn who_sees_nothing_of_the_street_is_led_back() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("view-astray"));
    let darkroom = Darkroom { store: street.store.clone() };
    let screen = Screen::start([800, 600]);
    let away = "651487.5,6861042.9,4044.2,35,0";
    let window = Window::open(text(&street.store), away, &screen);
    screen.focus("sample - Flaneur");
    screen.act(&["key", "Escape"]);
    assert_eq!(position(&window.stands("at first")), position(away));
    // Words and a button in the middle, before a background of one colour.
    let nothing = darkroom.picture(away, "hybrid");
    let until = Instant::now() + PATIENCE;
    while difference(&middle(&window_of(&screen.picture())), &middle(&nothing)) < DIFFERENT {
        assert!(Instant::now() < until, "nobody says so");
        std::thread::sleep(Duration::from_millis(50));
    }
    screen.act(&["mousemove", "320", "195", "click", "1"]);
    let back = window.stands("when led back");
    assert!(off_the_way(&street, &back) < 1.0, "{back}");
    await_picture(&screen, &darkroom.picture(&back, "hybrid"), "the street");
    screen.act(&["keydown", "Prior"]);
    std::thread::sleep(Duration::from_secs(2));
    screen.act(&["keyup", "Prior"]);
    let sky = window.stands("with one's head in the neck");
    assert!(sky.ends_with(",90.000"), "{sky}");
    await_picture(&screen, &darkroom.picture(&sky, "hybrid"), "the sky");
}

/// Who is at a server that goes is told so instead of being promised anything, and goes on once it is back.
#[test]
fn a_server_that_has_gone_is_said_to_have_and_found_again() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("view-cut-off"));
    let darkroom = Darkroom { store: street.store.clone() };
    let screen = Screen::start([800, 600]);
    let server = Served::start(&[&street.store]);
    let url = server.url.clone();
    let start = "651487.5,6861042.9,44.2,35,90";
    let window = Window::open(&format!("{url}/sample"), start, &screen);
    screen.focus("sample - Flaneur");
    screen.act(&["key", "Escape"]);
    let sky = window.stands("at first");
    await_picture(&screen, &darkroom.picture(&sky, "hybrid"), "the sky");
    server.kill();
    // Of the street itself there is nothing yet.
    screen.act(&["key", "Home"]);
    let level = window.stands("level");
    window.logs("the server cannot be reached", "of a server that has gone");
    let _server = Served::start_at(&[&street.store], url.trim_start_matches("http://"));
    window.logs("the server answers again", "of a server that is back");
    await_picture(&screen, &darkroom.picture(&level, "hybrid"), "the street");
}

/// Where words are that stand in the middle.
fn middle(picture: &RgbImage) -> RgbImage {
    image::imageops::crop_imm(picture, 200, 150, 240, 60).to_image()
}

#[test]
fn without_a_display_it_says_so_after_what_is_wrong_with_the_source() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let street = runtime.block_on(SampleStreet::ingested("view-nowhere"));
    let view = |source: &str| {
        let mut command = flaneur();
        command.args(["view", source]).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        let output = command.env_remove("WAYLAND_SOCKET").output().expect("the binary");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = view("nowhere");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("nowhere") && !said.contains("display"), "{said}");
    let (code, said) = view(text(&street.store));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("no display") && said.contains("flaneur render"), "{said}");
    assert_eq!(run(&["view", "nowhere", "--budget-ms", "0"]).status.code(), Some(2));
}

/// Whether a picture has light, dark and colours of its own.
fn is_a_street(picture: &RgbImage) -> bool {
    let mut shades = std::collections::BTreeSet::new();
    picture.pixels().for_each(|pixel| {
        shades.insert(pixel.0.map(|channel| channel / 16));
    });
    shades.len() > 100
}

/// Waits until the window shows something else than `before`.
fn await_change(screen: &Screen, before: &RgbImage) {
    let until = Instant::now() + PATIENCE;
    while difference(&window_of(&screen.picture()), before) < DIFFERENT {
        assert!(Instant::now() < until, "nothing happens");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Waits until a place is marked in a photograph.
fn await_yellow(screen: &Screen) {
    let until = Instant::now() + PATIENCE;
    while !screen.picture().pixels().any(|pixel| pixel.0 == [255, 216, 74]) {
        assert!(Instant::now() < until, "no mark");
        std::thread::sleep(Duration::from_millis(50));
    }
    screen
        .picture()
        .save(Path::new(env!("CARGO_TARGET_TMPDIR")).join("view-photograph.png"))
        .expect("writable");
}

/// Copies the coordinates on top of the tape, in the corner on the right; what the desktop has then.
fn copied(screen: &Screen) -> String {
    // The button is behind figures whose width the font decides.
    for x in (360..620).step_by(10) {
        screen.act(&["mousemove", &x.to_string(), "26", "click", "1"]);
        std::thread::sleep(Duration::from_millis(200));
        let text = screen.clipboard();
        if !text.is_empty() {
            return text;
        }
    }
    panic!("nothing was copied");
}

/// Waits until photographs are listed in the corner on the left of `street`.
fn await_list(screen: &Screen, street: &RgbImage) {
    let corner =
        |picture: &RgbImage| image::imageops::crop_imm(picture, 10, 250, 60, 90).to_image();
    let until = Instant::now() + PATIENCE;
    while difference(&corner(&screen.picture()), &corner(street)) < DIFFERENT {
        assert!(Instant::now() < until, "no list");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// From one view to another, metres.
fn way(from: &str, to: &str) -> [f64; 3] {
    let (from, to) = (position(from), position(to));
    [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
}
