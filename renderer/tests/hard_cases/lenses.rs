//! Lenses at their limits and beyond, and pictures of next to no pixels.

use super::*;

/// A lens of each model that folds back within its own picture.
fn folding_lenses(size: UVec2) -> Vec<Lens> {
    let half = size.as_dvec2() / 2.0;
    let focal = half.y;
    let intrinsics = Intrinsics { fx: focal, fy: 0.97 * focal, cx: half.x + 3.0, cy: half.y - 2.0 };
    let centre = half + DVec2::new(-2.0, 4.0);
    let k = [-0.4 / focal.powi(2), 0.0, 0.0];
    [
        Distortion::RadialPixels { centre, k, limit_px: f64::INFINITY },
        // Says itself that it ends before it would fold.
        Distortion::RadialPixels { centre, k, limit_px: 0.6 * focal },
        Distortion::Brown { k: [-0.4, 0.0, 0.0], p: [0.004, -0.003] },
        Distortion::Fisheye { k: [-0.35, 0.0, 0.0, 0.0] },
    ]
    .map(|distortion| Lens { size, intrinsics, distortion })
    .into()
}

/// Beyond the limit of its lens a photograph shows nothing, in particular not its own mirror
/// image.
#[test]
fn photographs_whose_lens_folds_back() {
    let street = Street::with_pole(DVec3::ZERO);
    let wide = camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 3.0, 100.0, SIZE);
    let truth = street.picture(&wide);
    for lens in folding_lenses(PHOTO) {
        let camera = with_lens(photo_camera([-1.0, 0.0, 2.0], 85.0), lens);
        let updates = street_and(&[("a/x", camera)]);
        let frame = assert_alike(&updates, wide, 14_000, "folding photograph");
        let (mut beyond, mut within) = (0, 0);
        for (i, seen) in truth.iter().enumerate() {
            let Some((hit, _)) = seen.filter(|_| is_interior(&truth, SIZE, i, 1)) else { continue };
            let c = camera.cam_from_world(hit.position);
            // Just within the limit either answer is right.
            let seen = |scale: f64| lens.project(c * DVec3::new(scale, scale, 1.0)).is_some();
            if !seen(0.999) {
                beyond += 1;
                assert!(!frame.surfaces[i].is_coloured(), "{lens:?} pixel {i}");
            } else if seen(1.001) {
                within += usize::from(frame.surfaces[i].is_coloured());
            }
        }
        assert!(beyond > 2000 && within > 2000, "{lens:?}: {beyond} beyond, {within} within");
    }
}

/// The pixels of a view that its lens does not reach are background, whether or not depths are inferred, and the
/// others show the street, except for up to 8 pixels before the limit.
#[test]
fn views_whose_lens_folds_back() {
    let street = Street::with_pole(DVec3::ZERO);
    let photo = photo_camera([-1.0, 0.0, 2.0], 85.0);
    let upwards = camera(DVec3::ZERO, [-1.0, 0.0, 2.0], 85.0, 40.0, 90.0, PHOTO);
    let ahead = (view(), false, street_and(&[("a/x", photo)]));
    let up = camera(DVec3::ZERO, [-0.8, 0.5, 1.8], 88.0, 45.0, 60.0, SIZE);
    let up = (up, true, street_and(&[("a/x", photo), ("b/x", upwards)]));
    let lenses = folding_lenses(SIZE).into_iter();
    for (lens, (view, infer, updates)) in lenses.flat_map(|lens| [(lens, &ahead), (lens, &up)]) {
        let camera = with_lens(*view, lens);
        let settings = Settings { infer: *infer, ..settings() };
        let frame = renderer(settings, updates.clone()).render(&camera.into()).expect("a frame");
        keep(&frame, "folding view");
        let inferred = count(&frame, |surface| surface == Surface::Inferred);
        assert_eq!(inferred > 300, *infer, "{lens:?}: {inferred}");
        let truth = street.picture(&camera);
        let reached: Vec<bool> = pixels(SIZE).map(|p| lens.unproject(p).is_some()).collect();
        let (mut beyond, mut within) = (0, 0);
        for (i, pixel) in pixels(SIZE).enumerate() {
            let around = |reach: i32| {
                (-reach..=reach).all(|dy| {
                    (-reach..=reach).all(|dx| {
                        let p = pixel + DVec2::new(dx.into(), dy.into());
                        lens.unproject(p).is_some()
                    })
                })
            };
            if !reached[i] {
                beyond += 1;
                assert_eq!(frame.surfaces[i], Surface::Background, "{lens:?} at {pixel}");
            } else if is_interior(&truth, SIZE, i, 2) && around(8) {
                within += 1;
                assert_eq!(frame.surfaces[i].is_geometry(), truth[i].is_some(), "{pixel}");
            }
        }
        assert!(beyond > 2000 && within > 500, "{lens:?}: {beyond} beyond, {within} within");
    }
}

/// A view of 179°, and one in which a pixel is a tenth of a millimetre; photographs likewise.
#[test]
fn focal_lengths_of_one_and_of_a_hundred_thousand_pixels() {
    let with_focal = |camera: PosedCamera, focal: f64| {
        let mut lens = camera.lens;
        (lens.intrinsics.fx, lens.intrinsics.fy) = (focal, focal);
        with_lens(camera, lens)
    };
    let normal = photo_camera([-1.0, -0.5, 2.0], 85.0);
    let other = photo_camera([-0.5, 4.0, 2.2], 100.0);
    // A photograph of 1 px a tangent shows 160° in eleven pixels.
    for (focal, coloured) in [(1.0, 20), (1e5, 10_000)] {
        let extreme = with_focal(normal, focal);
        let updates = street_and(&[("a/x", extreme), ("b/x", other)]);
        assert_alike(&updates, view(), 15_000, &format!("photograph {focal}"));
        let updates = street_and(&[("a/x", normal), ("b/x", other)]);
        let eye = with_focal(view(), focal);
        assert_alike(&updates, eye, 12_000, &format!("view {focal}"));
        // Both: the photograph's pixels are the view's.
        let updates = street_and(&[("a/x", extreme)]);
        let turned = PosedCamera { lens: eye.lens, ..extreme };
        let frame = assert_alike(&updates, turned, 12_000, &format!("both {focal}"));
        assert!(
            count(&frame, Surface::is_coloured) > coloured,
            "{focal}: {}",
            count(&frame, Surface::is_coloured)
        );
    }
}

/// Pictures one pixel wide or high, as photographs and as views.
#[test]
fn images_of_one_column_or_row() {
    let street = Street::with_pole(DVec3::ZERO);
    for size in [UVec2::new(1, 90), UVec2::new(90, 1), UVec2::ONE] {
        let lens = |focal: f64| {
            let half = size.as_dvec2() / 2.0;
            Lens::pinhole(size, Intrinsics { fx: focal, fy: focal, cx: half.x, cy: half.y })
        };
        // Wide enough that the one pixel covers something.
        let narrow = with_lens(photo_camera([-1.0, -0.5, 2.0], 85.0), lens(20.0));
        let (frame, difference) = compared(&street_and(&[("a/x", narrow)]), view());
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{size}: {difference:?}");
        let coloured = count(&frame, Surface::is_coloured);
        assert!(coloured > 5, "{size}: {coloured} pixels");
        let updates = street_and(&[("a/x", photo_camera([-1.0, -0.5, 2.0], 85.0))]);
        let eye = with_lens(view(), lens(70.0));
        let (frame, difference) = compared(&updates, eye);
        assert!(difference.max_255 <= FRAME_MINIFIED_255, "{size}: {difference:?}");
        // So coarse that its full level alone is looked up.
        let taken = photo_camera([-1.0, -0.5, 2.0], 85.0);
        let coarse = with_lens(taken, taken.lens.scaled_to(UVec2::new(56, 42)));
        let (_, difference) = compared(&street_and(&[("a/x", coarse)]), eye);
        assert!(difference.alike >= FRAME_ALIKE_SHARE, "{size}: {difference:?}");
        for (i, seen) in street.picture(&eye).iter().enumerate() {
            assert_eq!(frame.surfaces[i].is_geometry(), seen.is_some(), "{size} pixel {i}");
        }
        // Refined photographs and levels of detail of such pictures.
        let distortion = Distortion::Brown { k: [-0.1, 0.0, 0.0], p: [0.0; 2] };
        let bent = Lens { distortion, ..lens(20.0) };
        let (frame, _) = compared(&street_and(&[("a/x", with_lens(narrow, bent))]), view());
        assert!(count(&frame, Surface::is_coloured) > 5, "{size}, distorted");
    }
}
