//! Round trips, folds, and agreement with OpenCV and COLMAP.

use proptest::prelude::*;

use super::*;
use crate::{Intrinsics, Lens};
use glam::{DVec3, UVec2};

const PARIS: Distortion = Distortion::RadialPixels {
    centre: DVec2::new(1042.178, 1027.565),
    k: [-1.337_915_876_037_518e-7, 3.475_409_773_283_144e-14, -4.441_039_859_188_881e-21],
    limit_px: 2079.0,
};

fn lens(fx: f64, fy: f64, cx: f64, cy: f64, distortion: Distortion) -> Lens {
    Lens { size: UVec2::new(1280, 720), intrinsics: Intrinsics { fx, fy, cx, cy }, distortion }
}

/// Points of the camera frame and the pixels at which another library sees them.
fn agrees(name: &str, lens: &Lens, points: &[([f64; 3], [f64; 2])]) {
    for (point, pixel) in points {
        let (point, expected) = (DVec3::from(*point), DVec2::from(*pixel));
        let found = lens.project(point).expect("in front, inside the limit");
        // Both sides are f64 and take a few dozen operations on numbers up to 1e3.
        assert!(found.distance(expected) < 1e-9, "{name} {point}: {found}, not {expected}");
        let back = lens.unproject(found).expect("a pixel of the lens");
        let direction = point / point.z;
        // 1e-12 of the tangent, more where the fisheye's pixels hold less of it.
        let tolerance = 1e-12 * (1.0 + direction.length_squared());
        assert!(back.distance(direction) < tolerance, "{name} {point}: back at {back}");
    }
}

/// `cv::projectPoints` and `cv::fisheye::projectPoints` of OpenCV 5.0.0.
#[test]
fn opencv_agrees() {
    let at = |distortion| lens(701.25, 698.75, 640.5, 355.25, distortion);
    let brown = Distortion::Brown { k: [-0.28, 0.09, -0.011], p: [0.0012, -0.0007] };
    agrees(
        "brown",
        &at(brown),
        &[
            ([0.1, -0.2, 1.0], [709.590_910_453_125, 217.553_818_406_249_97]),
            ([0.9, 0.5, 1.5], [1_013.420_906_535_901_2, 562.212_722_477_951_5]),
            ([-1.2, 0.3, 2.0], [258.838_420_167_972_7, 450.599_186_794_024_4]),
            ([0.45, 0.55, 1.0], [918.207_632_146_570_4, 694.185_725_567_664_1]),
            ([-0.3, -0.62, 1.1], [467.719_323_746_250_84, 0.168_019_187_344_953_02]),
        ],
    );
    let fisheye = Distortion::Fisheye { k: [-0.021, 0.0093, -0.0041, 0.0006] };
    agrees(
        "fisheye",
        &at(fisheye),
        &[
            ([0.1, -0.2, 1.0], [709.421_464_017_085_7, 217.898_490_604_096_57]),
            ([0.9, 0.5, 0.5], [1_313.730_520_903_318, 727.933_562_274_663]),
            ([-3.0, 0.3, 0.4], [-334.425_124_312_287_95, 452.394_945_541_990_86]),
            ([0.45, 0.55, 1.0], [912.964_521_601_121_6, 687.074_983_823_588_2]),
            ([0.0, -5.0, 1.0], [640.5, -579.037_829_199_857_9]),
        ],
    );
}

/// `Camera.img_from_cam` of pycolmap 4.2.1.
#[test]
fn colmap_agrees() {
    let brown = |k, p| Distortion::Brown { k, p };
    let points = [[0.1, -0.2, 1.0], [0.45, 0.55, 1.0], [-0.62, 0.3, 1.0]];
    let cases = [
        (
            "SIMPLE_RADIAL",
            lens(700.5, 700.5, 640.0, 360.0, brown([-0.12, 0.0, 0.0], [0.0; 2])),
            [[709.6297, 220.7406], [936.122_365, 721.927_335], [230.414_399_68, 558.186_580_8]],
        ),
        (
            "RADIAL",
            lens(700.5, 700.5, 640.0, 360.0, brown([-0.12, 0.03, 0.0], [0.0; 2])),
            [
                [709.634_953_75, 220.730_092_5],
                [938.534_072_668_75, 724.874_977_706_250_1],
                [227.482_085_877_952, 559.605_442_317_119_2],
            ],
        ),
        (
            "OPENCV",
            lens(700.5, 698.25, 641.5, 358.75, brown([-0.12, 0.03, 0.0], [0.0011, -0.0007])),
            [
                [711.069_807_25, 220.046_827],
                [939.969_276_418_75, 723.063_622_028_125_1],
                [228.085_838_157_951_97, 558.398_763_926_079_9],
            ],
        ),
        (
            "OPENCV_FISHEYE",
            lens(
                700.5,
                698.25,
                641.5,
                358.75,
                Distortion::Fisheye { k: [-0.021, 0.0093, -0.0041, 0.0006] },
            ),
            [
                [710.347_751_221_345_6, 221.496_774_331_750_17],
                [913.673_115_695_666, 690.337_541_974_698_3],
                [263.687_024_657_193_5, 540.975_537_081_656_9],
            ],
        ),
    ];
    for (name, lens, pixels) in cases {
        let pairs: Vec<_> = points.into_iter().zip(pixels).collect();
        agrees(name, &lens, &pairs);
    }
}

#[test]
fn folding_is_refused_not_mirrored() {
    // 1 − r²: grows until r = 1/√3, then folds.
    let lens = Distortion::Brown { k: [-1.0, 0.0, 0.0], p: [0.0; 2] };
    let limit = lens.limit();
    assert!((limit - 1.0 / 3f64.sqrt()).abs() < 1e-12, "{limit}");
    assert!(lens.distort(DVec2::new(limit * 0.999, 0.0)).is_some());
    assert!(lens.distort(DVec2::new(limit * 1.001, 0.0)).is_none());
    assert!(lens.undistort(DVec2::new(0.5, 0.0)).is_none());
}

/// Each model ends at its limit and not before, whatever ends it.
#[test]
fn the_limit_is_where_distort_ends() {
    let centre = DVec2::new(1000.0, 900.0);
    let k = [-1.3e-7, 0.0, 0.0];
    let fold = (1.0 / (3.0 * 1.3e-7_f64)).sqrt();
    let cases = [
        ("stated", Distortion::RadialPixels { centre, k, limit_px: 1200.0 }, 1200.0),
        ("folded", Distortion::RadialPixels { centre, k, limit_px: 1e9 }, fold),
        ("brown", Distortion::Brown { k: [-0.3, 0.0, 0.0], p: [0.0; 2] }, (1.0 / 0.9_f64).sqrt()),
        // θ (1 − 0.3 θ²) folds at 1/√0.9 rad, 60.4°.
        ("fisheye", Distortion::Fisheye { k: [-0.3, 0.0, 0.0, 0.0] }, (1.0 / 0.9_f64).sqrt().tan()),
    ];
    for (name, distortion, limit) in cases {
        assert!(
            (distortion.limit() - limit).abs() < 1e-9 * limit,
            "{name}: {}",
            distortion.limit()
        );
        let origin = if matches!(distortion, Distortion::RadialPixels { .. }) {
            centre
        } else {
            DVec2::ZERO
        };
        let at = |r: f64| distortion.distort(origin + DVec2::from_angle(2.1) * r);
        assert!(at(limit * (1.0 - 1e-9)).is_some(), "{name}");
        assert!(at(limit * (1.0 + 1e-9)).is_none(), "{name}");
        // What is hidden beyond the limit is seen by no pixel.
        assert!(distortion.undistort(at(limit * (1.0 - 1e-9)).expect("inside") * 3.0).is_none());
    }
    assert_eq!(Distortion::None.limit(), f64::INFINITY);
    assert_eq!(Distortion::Fisheye { k: [0.1, 0.0, 0.0, 0.0] }.limit(), f64::INFINITY);
}

#[test]
fn poison_is_refused() {
    let models = [
        Distortion::None,
        PARIS,
        Distortion::Brown { k: [0.1, 0.0, 0.0], p: [0.01, 0.0] },
        Distortion::Brown { k: [f64::NAN, 0.0, 0.0], p: [0.0; 2] },
        Distortion::Fisheye { k: [0.1, 0.0, 0.0, 0.0] },
    ];
    for model in models {
        for bad in [DVec2::NAN, DVec2::new(f64::INFINITY, 0.0), DVec2::new(0.0, f64::NAN)] {
            assert!(model.distort(bad).is_none(), "{model:?} {bad}");
            assert!(model.undistort(bad).is_none(), "{model:?} {bad}");
        }
    }
    assert!(models[3].distort(DVec2::splat(0.1)).is_none());
}

#[test]
fn the_centre_stays_where_it_is() {
    for model in [
        Distortion::Brown { k: [0.1, -0.2, 0.3], p: [0.01, 0.02] },
        Distortion::Fisheye { k: [0.1, 0.2, 0.3, 0.4] },
    ] {
        assert_eq!(model.distort(DVec2::ZERO), Some(DVec2::ZERO));
        assert_eq!(model.undistort(DVec2::ZERO), Some(DVec2::ZERO));
        // Subnormal radii, where θ/r is 0/0 in all but name.
        let tiny = DVec2::new(1e-310, -3e-310);
        assert!(model.distort(tiny).expect("inside").distance(tiny) < 1e-309);
    }
}

proptest! {
    #[test]
    fn radial_pixels_round_trip(x in 0.0..2048.0, y in 0.0..2048.0) {
        let q = DVec2::new(x, y);
        let p = PARIS.undistort(q).expect("inside the image");
        let back = PARIS.distort(p).expect("inside the limit");
        prop_assert!(back.distance(q) < 1e-9, "{q} {p} {back}");
    }

    #[test]
    fn brown_round_trip(
        x in -0.8..0.8, y in -0.8..0.8,
        k1 in -0.2..0.2, k2 in -0.05..0.05, p1 in -0.01..0.01, p2 in -0.01..0.01,
    ) {
        let lens = Distortion::Brown { k: [k1, k2, 0.0], p: [p1, p2] };
        let p = DVec2::new(x, y);
        if p.length() < 0.8 * lens.limit() {
            let q = lens.distort(p).expect("inside the limit");
            let back = lens.undistort(q).expect("in range");
            prop_assert!(back.distance(p) < 1e-8, "{p} {q} {back}");
        }
    }

    #[test]
    fn fisheye_round_trip(
        theta in 0.0..1.5, phi in 0.0..6.3, k1 in -0.05..0.05, k2 in -0.01..0.01,
    ) {
        let lens = Distortion::Fisheye { k: [k1, k2, 0.0, 0.0] };
        let p = DVec2::from_angle(phi) * f64::tan(theta);
        if p.length() < 0.99 * lens.limit() {
            let q = lens.distort(p).expect("inside the limit");
            let back = lens.undistort(q).expect("in range");
            prop_assert!(back.distance(p) < 1e-7 * (1.0 + p.length_squared()), "{p} {back}");
        }
    }
}
