//! `flaneur ingest` from the files of a survey to a published scene, with the built program.

mod survey;

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use survey::{Outcome, Survey};

/// The manifest of the only scene of a survey's store.
fn manifest(survey: &Survey) -> Value {
    let stored = survey.stored();
    let mut manifests = stored.iter().filter(|(path, _)| path.ends_with("scene.json"));
    let (_, bytes) = manifests.next().expect("a manifest");
    assert!(manifests.next().is_none(), "one scene");
    serde_json::from_slice(bytes.as_ref().expect("a file")).expect("JSON")
}

fn names(value: &Value) -> Vec<&str> {
    value.as_array().expect("a list").iter().map(|name| name.as_str().expect("a name")).collect()
}

#[test]
fn a_street_becomes_a_scene_and_a_second_run_does_nothing() {
    let survey = Survey::sample();
    let summary = survey.ingested(&[]);
    assert_eq!(summary["unchanged"], false);
    let points = summary["points"].as_u64().expect("points");
    assert!((20_000..200_000).contains(&points), "{points}");
    for layer in ["footprints", "panoramas", "images", "bytes"] {
        assert!(summary[layer].as_u64().is_some_and(|count| count > 0), "{layer}: {summary}");
    }
    assert_eq!(survey.work_files(), 0, "nothing is left in the work folder");
    let stored = survey.stored();
    let scene = manifest(&survey);
    assert_eq!(scene["scene"]["ground"]["tile_m"], 64.0);
    assert!(scene.to_string().find(&*survey.path().to_string_lossy()).is_none(), "{scene}");

    let again = survey.ingested(&[]);
    assert_eq!(again["unchanged"], true);
    for same in ["points", "footprints", "panoramas", "images", "bytes", "warnings"] {
        assert_eq!(again[same], summary[same], "{same}");
    }
    let words = survey.ingest(&[]);
    assert!(words.stdout.starts_with("unchanged: "), "{}", words.stdout);
    assert!(survey.stored() == stored, "the store is as it was");

    assert_eq!(survey.ingested(&["--force"])["unchanged"], false);
    assert!(survey.stored() == stored, "the same inputs give the same bytes");
}

#[test]
fn a_layer_that_failed_is_made_again_and_the_others_are_not() {
    let survey = Survey::sample();
    let toml = std::fs::read_to_string(survey.street().join("street.toml")).expect("street.toml");
    let broken = format!("{toml}\n[[footprints]]\npath = \"more.geojson\"\nheight = 3.0\n");
    survey.write("more.geojson", "{");
    survey.write("street.toml", &broken);
    let failed = survey.ingest(&[]);
    assert_eq!(failed.code, Some(2), "{}", failed.stderr);
    assert!(failed.complaint().contains("more.geojson"), "{}", failed.stderr);
    assert!(!survey.store().exists(), "nothing was published");

    survey.write("street.toml", &toml);
    let summary = survey.ingested(&[]);
    let reused = names(&summary["layers_reused"]);
    assert!(reused.contains(&"panoramas"), "{summary}");
    assert!(reused.iter().any(|layer| layer.starts_with("points-")), "{summary}");
    assert!(!reused.contains(&"footprints"), "{summary}");
}

#[test]
fn a_changed_survey_replaces_the_scene_and_old_objects_go_one_ingest_later() {
    let survey = Survey::sample();
    survey.ingested(&[]);
    let first = survey.stored();
    let toml = std::fs::read_to_string(survey.street().join("street.toml")).expect("street.toml");
    for uncertainty in ["0.25", "0.75"] {
        let lines: Vec<String> = toml
            .lines()
            .filter(|line| !line.starts_with("uncertainty_m"))
            .map(|line| match line {
                "[[footprints]]" => format!("{line}\nuncertainty_m = {uncertainty}"),
                line => line.to_owned(),
            })
            .collect();
        survey.write("street.toml", lines.join("\n"));
        assert_eq!(survey.ingested(&[])["unchanged"], false);
        let fgb = survey.stored();
        let tables = fgb.keys().filter(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("footprints."))
        });
        assert_eq!(tables.count(), 2, "the new one, and that of readers of the last scene");
        for (path, content) in &first {
            let is_old = path.to_string_lossy().contains("footprints.");
            let is_manifest = path.ends_with("scene.json");
            assert!(is_old || is_manifest || fgb.get(path) == Some(content), "{}", path.display());
        }
    }
}

#[test]
fn a_killed_ingest_continues_and_ends_the_same() {
    let whole = Survey::sample();
    whole.ingested(&[]);
    let survey = Survey::sample();
    let mut kills = 0;
    // Killed after ever more of its stages, a few milliseconds into the next one.
    for attempt in 0..12_u64 {
        let mut child = survey
            .command(&[])
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("starts");
        let mut stderr = BufReader::new(child.stderr.take().expect("stderr")).lines();
        for _ in 0..attempt / 2 {
            stderr.next();
        }
        std::thread::sleep(Duration::from_millis(3 + (attempt * 17) % 40));
        child.kill().expect("killed");
        let status = child.wait().expect("ended");
        kills += u32::from(status.code().is_none());
        let published = survey.stored().keys().any(|path| path.ends_with("scene.json"));
        assert!(!published || survey.ingested(&[])["unchanged"] == true, "a manifest is a scene");
    }
    assert!(kills >= 3, "only {kills} runs were killed");
    survey.ingested(&[]);
    assert_eq!(
        survey.stored().keys().collect::<Vec<_>>(),
        whole.stored().keys().collect::<Vec<_>>()
    );
    assert!(survey.stored() == whole.stored(), "the same bytes as without a kill");
    assert_eq!(survey.work_files(), 0);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_it_cleanly() {
    let survey = Survey::sample();
    survey.ingested(&[]);
    let before = survey.stored();
    // `--force` makes everything anew, whatever is there.
    let mut child = survey
        .command(&["--force"])
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut stderr = BufReader::new(child.stderr.take().expect("stderr"));
    let mut text = String::new();
    stderr.read_line(&mut text).expect("the first stage's line");
    assert!(text.starts_with("compare inputs"), "{text}");
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
    stderr.read_to_string(&mut text).expect("text");
    assert_eq!(child.wait().expect("ended").code(), Some(130), "{text}");
    assert!(text.ends_with("flaneur: interrupted\n"), "{text}");
    assert!(survey.stored() == before, "the store is as it was");
}

#[test]
fn the_real_surveys_ingest() {
    let cases = [
        ("paris", [239_491, 540, 44, 220], Some(("absent-image", 30))),
        ("karlsruhe", [2_665_762, 0, 102, 102], None),
        ("delft", [848_942, 160, 0, 0], None),
    ];
    for (name, counts, warning) in cases {
        let Some(street) = Survey::real(name) else { continue };
        let survey = Survey::empty();
        let output = survey.command_of(&street).arg("--json").output().expect("starts");
        let summary = Outcome::of(output).summary();
        let layers = ["points", "footprints", "panoramas", "images"];
        let found = layers.map(|layer| summary[layer].as_u64().expect("a count"));
        assert_eq!(found, counts, "{name}: {layers:?}");
        if let Some((kind, count)) = warning {
            assert_eq!(summary["warnings"][kind], count, "{name}");
            let messages = names(&summary["warning_messages"]);
            let of_kind = messages.iter().filter(|message| message.starts_with(kind));
            assert_eq!(of_kind.count(), count, "{name}: each is named");
        }
        assert!(manifest(&survey)["scene"]["ground"].is_object(), "{name}");
    }
}
