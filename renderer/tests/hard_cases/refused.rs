//! What is no number, at the door.

use super::*;

/// Cameras with something that is no number are refused, by name, as views and as photographs.
#[test]
fn cameras_that_are_no_cameras() {
    let street = Street::with_pole(DVec3::ZERO);
    let mut renderer = renderer(settings(), street_and(&[]));
    type Spoil = fn(&mut PosedCamera, f64);
    let spoilt: [(&str, Spoil); 9] = [
        ("centre is not finite", |camera, bad| camera.centre.y = bad),
        ("orientation is no rotation", |camera, bad| camera.cam_from_world.x_axis.z = bad),
        ("focal lengths must be positive", |camera, bad| camera.lens.intrinsics.fx = bad),
        ("focal lengths must be positive", |camera, bad| camera.lens.intrinsics.fy = bad),
        ("principal point finite", |camera, bad| camera.lens.intrinsics.cx = bad),
        ("distortion is not finite", |camera, bad| {
            camera.lens.distortion = Distortion::Brown { k: [0.0, bad, 0.0], p: [0.0; 2] };
        }),
        ("distortion is not finite", |camera, bad| {
            camera.lens.distortion = Distortion::Brown { k: [0.0; 3], p: [bad, 0.0] };
        }),
        ("distortion is not finite", |camera, bad| {
            camera.lens.distortion = Distortion::Fisheye { k: [0.0, 0.0, bad, 0.0] };
        }),
        ("distortion is not finite", |camera, bad| {
            let centre = DVec2::new(bad, 0.0);
            camera.lens.distortion =
                Distortion::RadialPixels { centre, k: [0.0; 3], limit_px: 100.0 };
        }),
    ];
    let good = street.photograph("a/x", photo_camera([-1.0, -0.5, 2.0], 85.0));
    for (what, spoil) in spoilt {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut camera = view();
            spoil(&mut camera, bad);
            let error = renderer.render(&camera.into()).expect_err("no camera");
            assert!(matches!(error, RenderError::ViewCamera { .. }), "{error}");
            assert!(error.to_string().contains(what), "{bad}: {error}");
            let mut image = good.clone();
            spoil(&mut image.camera, bad);
            let error = renderer.apply(image_update(image)).expect_err("no camera").to_string();
            assert!(error.starts_with("image a/x: ") && error.contains(what), "{bad}: {error}");
        }
    }
}

/// Triangles with a corner that is no number are left out and counted; the others are drawn.
#[test]
fn meshes_with_corners_that_are_no_numbers() {
    let street = Street::with_pole(DVec3::ZERO);
    let good = street.mesh(&[0], 0.1);
    let view = View::from(view());
    let expected =
        renderer(settings(), vec![mesh_update(good.clone())]).render(&view).expect("a frame");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut tile = good.clone();
        for axis in 0..3 {
            let first = tile.vertices.len() as u32;
            let mut corners = [tile.vertices[0], tile.vertices[1], tile.vertices[2]];
            corners[axis].position[axis] = bad;
            tile.vertices.extend(corners);
            tile.indices.extend([first, first + 1, first + 2]);
        }
        let frame = renderer(settings(), vec![mesh_update(tile)]).render(&view).expect("a frame");
        assert_eq!(frame.stats.triangles_refused, 3);
        assert!(frame.rgba == expected.rgba && frame.surfaces == expected.surfaces, "{bad}");
        // Certainty and normal that are no numbers: exact, and facing up.
        let mut tile = good.clone();
        for vertex in &mut tile.vertices {
            vertex.uncertainty_m = bad;
            vertex.normal[1] = bad;
        }
        let frame = renderer(settings(), vec![mesh_update(tile)]).render(&view).expect("a frame");
        assert!(frame.stats.geometry_pixels > 1000, "{bad}");
        // A tile that is nowhere.
        let mut tile = good.clone();
        tile.origin.z = f64::from(bad);
        let frame = renderer(settings(), vec![mesh_update(tile)]).render(&view).expect("a frame");
        assert_eq!(frame.stats.geometry_pixels, 0);
        assert_eq!(frame.stats.triangles_refused as usize, good.indices.len() / 3);
    }
}
