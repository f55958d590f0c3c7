//! The photograph that stands nearest.

use flaneur_scene::{ImageId, PosedCamera};

/// The source to show unwarped in place of what `camera` sees, and the distance in metres from
/// its centre to that of the nearest source; `None` where there are no sources.
///
/// The source is of the panorama whose centre is nearest, and among that panorama's the one that
/// looks most nearly where `camera` looks. Equals go to the first name.
pub(crate) fn nearest_source<'a>(
    camera: &PosedCamera,
    sources: impl Iterator<Item = (&'a ImageId, &'a PosedCamera)> + Clone,
) -> Option<(&'a ImageId, f64)> {
    let distance_m = |source: &PosedCamera| source.centre.distance(camera.centre);
    let (nearest, at) = sources
        .clone()
        .min_by(|a, b| distance_m(a.1).total_cmp(&distance_m(b.1)).then_with(|| a.0.cmp(b.0)))?;
    let alike = |source: &PosedCamera| source.forward().dot(camera.forward());
    let (source, _) = sources
        .filter(|(id, _)| id.panorama() == nearest.panorama())
        .max_by(|a, b| alike(a.1).total_cmp(&alike(b.1)).then_with(|| b.0.cmp(a.0)))?;
    Some((source, distance_m(at)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::View;
    use glam::{DVec3, UVec2};

    fn camera(east: f64, heading_deg: f64) -> PosedCamera {
        let eye = DVec3::new(651_000.0 + east, 6_861_000.0, 40.0);
        View::look(eye, heading_deg.to_radians(), 0.0, 1.0, UVec2::splat(8)).camera
    }

    #[test]
    fn the_nearest_panorama_and_there_the_nearest_direction() {
        let sources: Vec<(ImageId, PosedCamera)> = [
            ("a/north", camera(0.0, 0.0)),
            ("a/south", camera(0.3, 180.0)),
            ("b/north", camera(5.0, 0.0)),
            ("b/east", camera(5.0, 90.0)),
            ("b/east2", camera(5.0, 90.0)),
        ]
        .map(|(id, camera)| (id.parse().expect("an id"), camera))
        .into();
        let found = |camera| {
            let (id, distance_m) =
                nearest_source(&camera, sources.iter().map(|(id, camera)| (id, camera)))
                    .expect("there are some");
            (id.to_string(), distance_m)
        };
        let (id, distance_m) = found(camera(1.0, 10.0));
        // The nearest centre is that of the other camera of the rig.
        assert_eq!(id, "a/north");
        assert!((distance_m - 0.7).abs() < 1e-9, "{distance_m}");
        assert_eq!(found(camera(4.0, 100.0)).0, "b/east");
        assert_eq!(nearest_source(&camera(0.0, 0.0), std::iter::empty()), None);
    }
}
