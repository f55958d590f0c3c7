//! Models written by COLMAP itself (pycolmap 4.2.1), and models that nobody should write.

use std::fs;

use flaneur_scene::PosedCamera;
use glam::DVec2;

use super::*;
use crate::ingest::street::Root;

const FILES: [(&str, &[u8]); 4] = [
    ("cameras.txt", include_bytes!("fixtures/cameras.txt")),
    ("images.txt", include_bytes!("fixtures/images.txt")),
    ("cameras.bin", include_bytes!("fixtures/cameras.bin")),
    ("images.bin", include_bytes!("fixtures/images.bin")),
];

/// `project_point` of pycolmap for the world point (12.5, −3.25, 4) and `projection_center`.
const EXPECTED: [(&str, &str, [f64; 3], [f64; 2]); 6] = [
    (
        "a",
        "1",
        [12.505_793_937_861_44, -2.196_666_647_891_542, 5.185_518_991_674_121],
        [850.15, 243.25],
    ),
    (
        "left_b",
        "2",
        [11.976_002_197_554_457, -4.028_668_235_563_533, 1.626_373_643_145_025_3],
        [766.09, 290.175],
    ),
    (
        "c d",
        "3",
        [15.376_304_572_016_33, -2.233_313_604_781_933_7, 2.208_849_313_213_304],
        [729.830_486_180_757_9, 310.094_174_344_022_75],
    ),
    (
        "e",
        "4",
        [11.145_018_721_032_397, -7.043_186_580_937_554, 1.928_584_711_883_540_4],
        [709.940_355_446_639_4, 321.144_246_974_089_2],
    ),
    (
        "f",
        "5",
        [9.960_071_700_049_847, -7.856_042_902_265_736, 5.687_641_257_376_626],
        [698.736_925_940_513_5, 327.058_193_449_118_85],
    ),
    (
        "g",
        "9",
        [9.471_389_122_967_615, 2.507_804_893_964_608, 4.436_118_055_758_227],
        [689.888_810_987_251_9, 331.953_674_143_985_2],
    ),
];

/// Reads a model that consists of these files.
fn read_files(files: &[(&str, &[u8])]) -> Result<Vec<Draft>, String> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("written");
    }
    let root = Root::new(folder.path(), true).expect("a root");
    let images = root.folder().join("images");
    let model = root.folder().to_owned();
    let spec = ColmapSpec { root, model, images, uncertainty_m: 0.25, refine_poses: true };
    let job = Job::new(folder.path(), 1 << 24);
    read(&job, &spec).map_err(|e| e.to_string())
}

fn text(cameras: &str, images: &str) -> Result<Vec<Draft>, String> {
    read_files(&[("cameras.txt", cameras.as_bytes()), ("images.txt", images.as_bytes())])
}

const CAMERA: &str = "1 PINHOLE 1280 720 700 700 640 360";

#[test]
fn text_and_binary_are_read_as_colmap_means_them() {
    for files in [&FILES[..2], &FILES[2..]] {
        let drafts = read_files(files).expect("COLMAP wrote it");
        assert_eq!(drafts.len(), EXPECTED.len());
        for (draft, (id, camera_id, centre, pixel)) in drafts.iter().zip(EXPECTED) {
            assert_eq!((draft.id.as_str(), draft.uncertainty_m), (id, 0.25));
            let [camera] = draft.cameras.as_slice() else { panic!("{draft:?}") };
            assert_eq!(camera.id, camera_id);
            let DraftLens::Calibrated(lens) = camera.lens else { panic!("{camera:?}") };
            assert!(draft.position.distance(centre.into()) < 1e-12, "{id}: {}", draft.position);
            let posed = PosedCamera {
                centre: draft.position,
                cam_from_world: camera.cam_from_rig * draft.world_from_rig.transpose(),
                lens,
            };
            let found = posed.project(DVec3::new(12.5, -3.25, 4.0)).expect("in front").0;
            // Metres of 1e1 in f64, times a focal length of 700 px.
            assert!(found.distance(DVec2::from(pixel)) < 1e-10, "{id}: {found}");
        }
        let image = &drafts[1].cameras[0].image;
        assert!(image.ends_with("images/left/b.png"), "{}", image.display());
    }
}

#[test]
fn a_rig_looks_where_its_camera_looks() {
    let drafts = text(CAMERA, "1 1 0 0 0 0 0 0 1 a.jpg\n\n").expect("valid");
    // The identity looks along world z with y down: forward is z, up is −y.
    let rig = drafts[0].world_from_rig;
    assert!(
        (rig * DVec3::Y).distance(DVec3::Z) < 1e-15 && (rig * DVec3::Z).distance(-DVec3::Y) < 1e-15
    );
}

/// Every prefix of the binary files is refused, with the file and a byte, but for none at all.
#[test]
fn binary_models_cut_short_are_refused_with_their_place() {
    let [_, _, cameras, images] = FILES;
    for (name, whole, other) in
        [("cameras.bin", cameras.1, images), ("images.bin", images.1, cameras)]
    {
        for length in 0..whole.len() {
            let error = read_files(&[(name, &whole[..length]), other]).expect_err("cut short");
            assert!(error.contains(&format!("{name}, byte ")), "{length}: {error}");
        }
        let longer = [whole, &[0; 3]].concat();
        let error = read_files(&[(name, &longer), other]).expect_err("too long");
        assert!(error.contains("3 bytes follow"), "{error}");
    }
}

#[test]
fn counts_are_checked_before_memory_is_taken() {
    let [_, _, cameras, images] = FILES;
    for count in [u64::MAX, 1 << 60, 7] {
        let mut hostile = cameras.1.to_vec();
        hostile[..8].copy_from_slice(&count.to_le_bytes());
        let error = read_files(&[("cameras.bin", &hostile), images]).expect_err("hostile");
        assert!(error.contains("byte "), "{count}: {error}");
        let mut hostile = images.1.to_vec();
        hostile[..8].copy_from_slice(&count.to_le_bytes());
        let error = read_files(&[cameras, ("images.bin", &hostile)]).expect_err("hostile");
        assert!(error.contains("byte "), "{count}: {error}");
    }
    // The number of points of the first image, after its name "a.jpg".
    let mut hostile = images.1.to_vec();
    let at = 8 + 4 + 56 + 4 + 6;
    hostile[at..at + 8].copy_from_slice(&(u64::MAX / 24).to_le_bytes());
    let error = read_files(&[cameras, ("images.bin", &hostile)]).expect_err("hostile");
    assert!(error.contains("byte 78") && error.contains("do not fit"), "{error}");
}

#[test]
fn faults_are_named_with_file_place_and_remedy() {
    let pose = |q: &str| format!("1 {q} 0 0 0 1 a.jpg\n\n");
    let cases = [
        (
            CAMERA,
            pose("2 0 0 0"),
            "images.txt, line 1, image 1, image \"a.jpg\": its quaternion has norm 2",
        ),
        (CAMERA, pose("nan 0 0 0"), "norm NaN"),
        (CAMERA, "1 1 0 0 0 1e300 0 0 1 a.jpg\n\n".into(), "its camera is at"),
        (CAMERA, "1 1 0 0 0 0 0 0 8 a.jpg\n\n".into(), "its camera 8 is not in"),
        (
            CAMERA,
            "1 1 0 0 0 0 0 0 1 a.jpg\n\n2 1 0 0 0 0 0 0 1 a.png\n\n".into(),
            "named \"a\", as \"a.jpg\" is",
        ),
        (
            CAMERA,
            "1 1 0 0 0 0 0 0 1 a.jpg\n2 1 0 0 0 0 0 0 1 b.jpg\n".into(),
            "line 2: 10 words where the points",
        ),
        (CAMERA, "1 1 0 0 x 0 0 0 1 a.jpg\n\n".into(), "a number of the pose is \"x\""),
        (CAMERA, "1 1 0 0 0\n".into(), "too few words"),
        (CAMERA, "1 1 0 0 0 0 0 0 1 ../a.jpg\n\n".into(), "leading '.'"),
        (CAMERA, "1 1 0 0 0 0 0 0 1 x/../../../a.jpg\n\n".into(), "leaves the folder"),
        ("1 FOV 10 10 1 1 1 1 1", pose("1 0 0 0"), "its model \"FOV\" is not supported"),
        ("1 PINHOLE 10 10 1 1 1", pose("1 0 0 0"), "it has 3 parameters, not 4"),
        ("1 PINHOLE 10 10 1 -1 1 1", pose("1 0 0 0"), "its focal lengths are 1 and -1"),
        ("1 OPENCV 10 10 1 1 1 1 inf 0 0 0", pose("1 0 0 0"), "a parameter is inf"),
        ("1 PINHOLE 0 10 1 1 1 1", pose("1 0 0 0"), "its size is [0, 10]"),
        ("1 PINHOLE 10 5000000000 1 1 1 1", pose("1 0 0 0"), "its size is"),
    ];
    for (cameras, images, expected) in cases {
        let error = text(cameras, &images).expect_err(expected);
        assert!(error.contains(expected) && error.contains("; "), "{error}, not {expected}");
        assert!(!error.contains('\n'), "{error}");
    }
    let error = read_files(&FILES[..1]).expect_err("no images");
    assert!(error.contains("neither images.bin nor images.txt"), "{error}");
    let long = "a".repeat(70_000);
    assert!(text(&long, "").expect_err("long").contains("longer than"));
}

#[test]
fn names_of_folders_join_the_panoramas_name() {
    for (image, name) in [
        ("a.jpg", "a"),
        ("./cam0/00.01.jpg", "cam0_00.01"),
        ("a\\b.png", "a_b"),
        ("noext", "noext"),
        ("x.d/noext", "x.d_noext"),
        ("é/ü.jpeg", "é_ü"),
    ] {
        assert_eq!(panorama_name(image), name);
    }
}
