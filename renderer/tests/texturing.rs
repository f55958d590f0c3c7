//! The ways to texture points give the same picture.

mod common;

use common::*;
use flaneur_renderer::{Frame, Mode, Settings, SplatNormals, SplatRoute, Surface, Texturing};
use flaneur_scene::{
    Distortion, Intrinsics, Lens, PointChunk, SceneUpdate, View, linear_from_srgb,
};
use glam::{DVec3, UVec2};
use tolerances::{HOMOGRAPHY_PX, TEXTURING_255, TEXTURING_WRONG_SHARE};

const SIZE: UVec2 = UVec2::new(320, 240);
const PHOTO: UVec2 = UVec2::new(640, 480);

fn view(origin: DVec3) -> View {
    View::from(camera(origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 60.0, SIZE))
}

/// Points on everything; the mesh is the wall, which gives the points on it its plane.
fn scene(street: &Street) -> Vec<SceneUpdate> {
    let lens = Lens {
        size: PHOTO,
        intrinsics: Intrinsics { fx: 400.0, fy: 410.0, cx: 311.0, cy: 250.0 },
        distortion: Distortion::Brown { k: [0.05, 0.01, 0.0], p: [0.001, -0.002] },
    };
    let at = |place, heading| camera(street.origin, place, heading, 5.0, 70.0, PHOTO);
    vec![
        image_update(street.photograph("a/east", at([-1.0, -3.0, 2.0], 80.0))),
        image_update(street.photograph("b/east", with_lens(at([-0.5, 4.0, 2.2], 100.0), lens))),
        image_update(street.photograph("b/north", at([-0.5, 4.0, 2.2], 20.0))),
        mesh_update(street.mesh(&[0], 0.1)),
        points_update(with_normals(street.points(&[0, 1, 2, 3], 0.07))),
    ]
}

/// On a small square of ground: what is near enough to be seen.
fn street() -> Street {
    let street = Street::with_pole(DVec3::new(651_187.0, 6_861_353.0, 42.0));
    Street { ground_m: 14.0, ..street }
}

fn is_point(surface: Surface) -> bool {
    matches!(surface, Surface::PointColoured | Surface::PointUncoloured)
}

/// Share of the pixels that show points whose colour differs.
fn wrong_share(a: &Frame, b: &Frame) -> (usize, f64) {
    let (mut points, mut wrong) = (0, 0);
    for (i, (a_surface, b_surface)) in a.surfaces.iter().zip(&b.surfaces).enumerate() {
        let off = (pixel(a, i) - pixel(b, i)).abs().max_element();
        if is_point(*a_surface) {
            points += 1;
            wrong += usize::from(off > TEXTURING_255 || a_surface != b_surface);
        } else if a_surface.is_geometry() {
            assert_eq!(off, 0.0, "pixel {i} shows mesh");
        }
    }
    (points, wrong as f64 / points as f64)
}

fn pixel(frame: &Frame, index: usize) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|c| f64::from(frame.rgba[4 * index + c])))
}

/// Normals that are some degrees off the surface, a tenth of them none.
fn with_normals(chunk: PointChunk) -> PointChunk {
    let normals = chunk
        .positions
        .iter()
        .zip(0u32..)
        .map(|(&[x, y, z], i)| {
            let wave = DVec3::new(f64::from(i).sin(), f64::from(i).cos(), 0.3) * 0.1;
            let flat =
                if z == 0.0 { DVec3::Z } else { DVec3::new(f64::from(x), f64::from(y), 0.0) };
            let n = (flat.normalize_or(DVec3::X) + wave).normalize();
            (if i % 10 == 0 { DVec3::ZERO } else { n }).as_vec3().to_array()
        })
        .collect();
    PointChunk { normals, ..chunk }
}

#[test]
fn all_ways_give_the_same_picture() {
    let street = street();
    let view = view(street.origin);
    for splat_normals in [SplatNormals::Eye, SplatNormals::Estimated] {
        let settings = Settings { align: false, splat_normals, ..Settings::default() };
        let mut renderer = renderer(settings, scene(&street));
        for mode in [Mode::Hybrid, Mode::Points, Mode::Sources] {
            let [deferred, forward @ ..] = Texturing::ALL.map(|texturing| {
                assert!(renderer.set_settings(Settings { texturing, ..settings }));
                let frame = renderer.render_as(&view, mode).expect("a frame");
                keep(&frame, &format!("{splat_normals:?}-{mode:?}-{}", texturing.name()));
                frame
            });
            for forward in forward {
                let (points, wrong) = wrong_share(&deferred, &forward);
                println!("{splat_normals:?}, {mode:?}: {wrong:.6} of {points} pixels differ");
                assert!(points > 40_000 && wrong < TEXTURING_WRONG_SHARE, "{points} {wrong}");
            }
        }
    }
}

/// The two ways to find a pixel's point keep its index in different places.
#[test]
fn the_route_of_the_splats_does_not_matter() {
    let street = street();
    let frames = [SplatRoute::Atomic32, SplatRoute::Atomic64].map(|splat_route| {
        let settings =
            Settings { splat_route, texturing: Texturing::Homography, ..Settings::default() };
        renderer(settings, scene(&street)).render(&view(street.origin)).expect("a frame").rgba
    });
    assert!(frames[0] == frames[1], "the routes differ");
}

/// Views that no homography holds for, and scenes without points, are textured all the same.
#[test]
fn what_is_no_homography_is_deferred() {
    let street = street();
    let intrinsics = Intrinsics { fx: 180.0, fy: 175.0, cx: 164.0, cy: 117.0 };
    let distortion = Distortion::Brown { k: [0.2, 0.1, 0.0], p: [0.01, -0.008] };
    let pinhole = view(street.origin);
    let distorted = with_lens(pinhole.camera, Lens { size: SIZE, intrinsics, distortion });
    let eye = street.origin + DVec3::new(-3.0, 0.0, 4.5);
    let orthographic = View::orthographic(eye, 90f64.to_radians(), 0.0, 9.0, SIZE);
    let everything = scene(&street);
    let no_points = everything[..4].to_vec();
    for (view, updates) in
        [(View::from(distorted), &everything), (orthographic, &everything), (pinhole, &no_points)]
    {
        // A renderer each: depths that are inferred change from frame to frame.
        let [deferred, forward @ ..] = Texturing::ALL.map(|texturing| {
            let settings = Settings { align: false, texturing, ..Settings::default() };
            renderer(settings, updates.clone()).render(&view).expect("a frame")
        });
        assert!(deferred.stats.coloured_pixels > 1000, "{:?}", deferred.stats);
        for forward in forward {
            assert!(forward.rgba == deferred.rgba && forward.surfaces == deferred.surfaces);
        }
    }
}

/// Columns of the photograph alternate in red and rows in green, so that between two centres of
/// texels linear colour is a ruler: it tells the pixel that was looked up.
#[test]
fn pixels_of_a_photograph_are_found_within_a_hundredth() {
    let street = street();
    let photo_camera = camera(street.origin, [-1.0, -3.0, 2.0], 80.0, 5.0, 70.0, PHOTO);
    let mut ruler = street.photograph("a/east", photo_camera);
    ruler.rgba = (0..PHOTO.y)
        .flat_map(|y| (0..PHOTO.x).flat_map(move |x| [255 * (x % 2), 255 * (y % 2), 0, 255]))
        .map(|byte| byte as u8)
        .collect();
    // So narrow that its pixels are smaller than the photograph's, which keeps level 0.
    let view = View::from(camera(street.origin, [-0.8, 0.5, 1.8], 88.0, 3.0, 28.0, SIZE));
    let mut renderer = renderer(
        Settings::default(),
        vec![
            image_update(ruler),
            mesh_update(street.mesh(&[0], 0.1)),
            points_update(street.points(&[0, 1, 2, 3], 0.07)),
        ],
    );
    let frames = Texturing::ALL.map(|texturing| {
        assert!(renderer.set_settings(Settings { align: false, texturing, ..Settings::default() }));
        renderer.render(&view).expect("a frame")
    });
    let [deferred, forward @ ..] = &frames;
    for frame in forward {
        let (mut compared, mut worst, mut wrong) = (0, 0.0f64, 0);
        for i in 0..deferred.surfaces.len() {
            if deferred.surfaces[i] != Surface::PointColoured {
                continue;
            }
            let [expected, found] = [deferred, frame].map(|frame| pixel(frame, i) / 255.0);
            for channel in 0..2 {
                // Where a byte of the picture is at most 0.0024 pixels of the photograph.
                let at = linear_from_srgb(expected[channel]);
                if (0.002..0.1).contains(&at) {
                    let off = (linear_from_srgb(found[channel]) - at).abs();
                    compared += 1;
                    worst = worst.max(off);
                    wrong += usize::from(off > HOMOGRAPHY_PX);
                }
            }
        }
        println!("{compared} compared, worst {worst:.5} px, {wrong} beyond");
        assert!(compared > 5000 && wrong == 0, "{wrong} of {compared}, worst {worst} px");
    }
}
