//! Whole `street.toml` files: what they give, and what is said about faulty ones.

use std::path::Path;

use super::*;

/// A folder that holds every file the tests name.
fn survey() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    std::fs::create_dir_all(folder.path().join("images")).expect("folder");
    for file in ["b.geojson", "a_1.laz", "a_2.laz", "poses.json", "rig.json", "list.csv"] {
        std::fs::write(folder.path().join(file), "").expect("file");
    }
    folder
}

fn open(folder: &Path, text: &str, confine: bool) -> Result<Street, String> {
    std::fs::write(folder.join("street.toml"), text).expect("street.toml");
    Street::open(folder, confine).map_err(|error| {
        error.to_string().replace(&folder.canonicalize().expect("folder").display().to_string(), "")
    })
}

const SCENE: &str = "[scene]\nname = \"s\"\ncrs = \"EPSG:2154\"\n";

#[test]
fn every_layer_is_read_with_its_defaults() {
    let folder = survey();
    let street = open(
        folder.path(),
        &format!(
            "{SCENE}[ground]\nformat = \"points\"\nclasses = [2, 8]\n\
             [[footprints]]\npath = \"b.geojson\"\nheight = \"points\"\nuncertainty_m = 1\n\
             [[panoramas]]\nformat = \"itowns\"\nposes = \"poses.json\"\ncalibration = \"rig.json\"\n\
             images = \"images/{{camera}}_{{panorama:07}}.jpg\"\nheading = \"true-north\"\n\
             [[panoramas]]\nformat = \"equirectangular\"\nlist = \"list.csv\"\n\
             [[points]]\npath = \"a_*.laz\"\n[[points]]\npath = \"a_1.laz\"\nname = \"a\"\n"
        ),
        true,
    )
    .expect("valid");
    let root = folder.path().canonicalize().expect("folder");
    assert_eq!(street.ground, Some(GroundSpec::Points { classes: Some(vec![2, 8]) }));
    assert_eq!(street.footprints[0].height, Some(HeightSource::Points));
    assert_eq!(street.footprints[0].uncertainty_m, 1.0);
    assert_eq!(street.points[0].name, "a-2", "the given name \"a\" is taken");
    assert_eq!(street.points[0].files, [root.join("a_1.laz"), root.join("a_2.laz")]);
    let PanoramasSpec::Itowns(itowns) = &street.panoramas[0] else { panic!("itowns") };
    assert_eq!(itowns.heading, North::True);
    assert_eq!(itowns.images.fill("7", "c"), "images/c_0000007.jpg");
    let PanoramasSpec::Equirectangular(list) = &street.panoramas[1] else { panic!("list") };
    assert_eq!((list.heading, list.images.as_path()), (North::Grid, root.as_path()));
}

#[test]
fn faults_name_line_value_and_remedy() {
    let points = "[[points]]\npath = \"a_1.laz\"\n";
    let cases = [
        (
            format!("{SCENE}{points}[grund]\n"),
            "line 6: unknown key `grund` in the file; did you mean `ground`?",
        ),
        (
            format!("{SCENE}[[points]]\npth = \"a\"\n"),
            "line 5: unknown key `pth` in [[points]]; did you mean `path`? the keys are path, name",
        ),
        (
            format!("{SCENE}[[points]]\npath = 3\n"),
            "line 5: `path` of [[points]] is 3: expected a text; write path = \"...\", in quotes",
        ),
        (
            format!("{SCENE}[[points]]\npath = \"c_*.laz\"\n"),
            "line 5: `path` of [[points]] is \"c_*.laz\": no file matches; paths start at",
        ),
        (
            format!("{SCENE}[points]\npath = \"a_1.laz\"\n"),
            "line 4: `points` is not a list of tables; write [[points]]",
        ),
        (
            format!("{SCENE}{points}[ground]\nformat = \"pionts\"\n"),
            "line 7: `format` of [ground] is \"pionts\": there is no such choice; did you mean `points`? the choices are constant, points-json, points",
        ),
        (
            format!("{SCENE}{points}[ground]\nformat = \"constant\"\nheight_m = nan\n"),
            "line 8: `height_m` of [ground] is nan: expected a finite number",
        ),
        (
            format!("{SCENE}{points}[ground]\nformat = \"constant\"\n"),
            "line 6: [ground] has no `height_m`; add height_m = 0.0",
        ),
        (
            format!("{SCENE}{points}[ground]\nformat = \"points\"\nclasses = [256]\n"),
            "line 8: `classes` of [ground] is [256]: expected a list of LAS classes",
        ),
        (
            format!("{SCENE}[[footprints]]\npath = \"b.geojson\"\nheight = \"points\"\n"),
            "line 6: `height` of [[footprints]] is \"points\": there are no [[points]]",
        ),
        (
            format!(
                "{SCENE}[[footprints]]\npath = \"b.geojson\"\nheight = 3\nheight_property = \"h\"\n"
            ),
            "line 6: `height` of [[footprints]] is 3: `height_property` is given too",
        ),
        (
            format!("{SCENE}[[footprints]]\npath = \"b.geojson\"\nuncertainty_m = -1\n"),
            "line 6: `uncertainty_m` of [[footprints]] is -1: expected zero or more",
        ),
        (
            format!(
                "{SCENE}[[panoramas]]\nformat = \"colmap\"\nmodel = \"none\"\nimages = \"images\"\n"
            ),
            "line 6: `model` of [[panoramas]] is \"none\": there is no such folder",
        ),
        (
            format!(
                "{SCENE}[[panoramas]]\nformat = \"colmap\"\nmodel = \"images\"\nimages = \"images\"\nheading = \"true-north\"\n"
            ),
            "line 8: unknown key `heading` in [[panoramas]]",
        ),
        (
            format!(
                "{SCENE}[[panoramas]]\nformat = \"itowns\"\nposes = \"poses.json\"\ncalibration = \"rig.json\"\nimages = \"a.jpg\"\n"
            ),
            "line 8: `images` of [[panoramas]] is \"a.jpg\": no {panorama} in it",
        ),
        (
            format!("{SCENE}[[points]]\npath = \"../x.laz\"\n"),
            "line 5, path: the path \"../x.laz\" leaves the folder of the street; move the file",
        ),
        (
            "[scene]\nname = \"a b\"\ncrs = \"local\"\n".to_owned(),
            "line 2: `name` of [scene] is \"a b\": this cannot be a name",
        ),
        (
            "[scene]\nname = \"s\"\ncrs = \"lambert\"\n".to_owned(),
            "line 3: `crs` of [scene] is \"lambert\": this is no known way",
        ),
        (
            "[scene]\nname = \"s\"\ncrs = \"local\"\ngeographic_origin = [99, 0, 0]\n".to_owned(),
            "line 4: `geographic_origin` of [scene] is [99, 0, 0]: there is no such place",
        ),
        ("[scene]\nname = \"s\"\ncrs = \"local\"\n".to_owned(), "line 1: the street is empty"),
        ("[scene\n".to_owned(), "line 1: this is no TOML"),
        (String::new(), "line 1: there is no [scene]"),
    ];
    let folder = survey();
    for (text, expected) in cases {
        let error = open(folder.path(), &text, true).expect_err(&text);
        assert!(
            error.starts_with(&format!("/street.toml, {expected}")),
            "for\n{text}\nexpected {expected}\ngot      {error}"
        );
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn links_that_leave_the_folder_are_refused_when_confined() {
    let (outer, folder) = (survey(), survey());
    std::os::unix::fs::symlink(outer.path().join("a_1.laz"), folder.path().join("l.laz"))
        .expect("link");
    let text = format!("{SCENE}[[points]]\npath = \"l*.laz\"\n");
    assert!(open(folder.path(), &text, false).is_ok());
    let error = open(folder.path(), &text, true).expect_err("a link out");
    assert!(error.contains("leaves the folder"), "{error}");
}

#[test]
fn a_folder_without_a_street_is_named() {
    let error = Street::open(Path::new("/nowhere"), false).expect_err("nothing there").to_string();
    assert!(error.starts_with("/nowhere: cannot read it:"), "{error}");
}
