//! How far inside a mask the pixels of a photograph lie.

use glam::UVec2;

/// Share of a picture's shorter side over which a photograph fades towards its mask.
const FEATHER: f64 = 0.05;
/// A step to a pixel beside and to one across the corner, whose ratio is nearly √2: distances are
/// off by at most 8 %.
const BESIDE: u32 = 3;
const ACROSS: u32 = 4;

/// The alpha of a picture of `size`, rows from the top, of which the mask shows `shown`: 0 where
/// it hides the scene, then rising with the distance from there to 255. The picture's own border
/// is no edge of the mask.
pub(super) fn feathered(size: UVec2, shown: &[bool]) -> Vec<u8> {
    let reach = (FEATHER * f64::from(size.min_element()) * f64::from(BESIDE)).max(1.0);
    if shown.iter().all(|&shown| shown) {
        return vec![255; shown.len()];
    }
    let distances = distances(size.x as usize, shown);
    distances.into_iter().map(|distance| alpha(distance, reach)).collect()
}

fn alpha(distance: u32, reach: f64) -> u8 {
    if distance == 0 {
        return 0;
    }
    // The nearest shown pixel has some say, even in the largest picture.
    (255.0 * f64::from(distance) / reach).round().clamp(1.0, 255.0) as u8
}

/// The chamfer distance of each pixel from the nearest that is not shown, in thirds of a pixel:
/// one pass over the rows from the top, which knows what lies above and to the left, and one back.
fn distances(width: usize, shown: &[bool]) -> Vec<u32> {
    let far = u32::MAX - ACROSS;
    let mut distances: Vec<u32> = shown.iter().map(|&shown| if shown { far } else { 0 }).collect();
    pass(width, &mut distances);
    distances.reverse();
    pass(width, &mut distances);
    distances.reverse();
    distances
}

fn pass(width: usize, distances: &mut [u32]) {
    let mut above: &mut [u32] = &mut [];
    for row in distances.chunks_mut(width.max(1)) {
        for x in 0..row.len() {
            let before = x.checked_sub(1);
            let near = [
                (before.and_then(|x| row.get(x)), BESIDE),
                (before.and_then(|x| above.get(x)), ACROSS),
                (above.get(x), BESIDE),
                (above.get(x + 1), ACROSS),
            ];
            let steps = near.into_iter().filter_map(|(distance, step)| Some(distance? + step));
            row[x] = steps.fold(row[x], u32::min);
        }
        above = row;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_nearly_euclidean() {
        let (width, height) = (70, 50);
        let hidden = [(10, 10), (11, 10), (60, 45)];
        let at = |i: usize| (i % width, i / width);
        let shown: Vec<bool> = (0..width * height).map(|i| !hidden.contains(&at(i))).collect();
        for (i, distance) in distances(width, &shown).into_iter().enumerate() {
            let (x, y) = at(i);
            let exact = hidden
                .iter()
                .map(|&(u, v)| (x.abs_diff(u) as f64).hypot(y.abs_diff(v) as f64))
                .fold(f64::INFINITY, f64::min);
            let found = f64::from(distance) / f64::from(BESIDE);
            assert!((found - exact).abs() <= 0.08 * exact, "{x} {y}: {found} for {exact}");
        }
    }

    #[test]
    fn alpha_rises_from_the_mask_inwards() {
        // The mask hides the left column of 200 by 100 pixels; 5 pixels are the feather.
        let size = UVec2::new(200, 100);
        let shown: Vec<bool> = (0..200 * 100).map(|i| i % 200 > 0).collect();
        let alpha = feathered(size, &shown);
        for row in alpha.chunks(200) {
            assert_eq!(row[..7], [0, 51, 102, 153, 204, 255, 255]);
            assert_eq!(row[199], 255, "the border of the picture is no mask");
        }
    }

    #[test]
    fn alpha_is_zero_only_where_the_scene_is_hidden() {
        assert_eq!(feathered(UVec2::new(2, 2), &[true; 4]), [255; 4]);
        assert_eq!(feathered(UVec2::new(2, 2), &[false; 4]), [0; 4]);
        assert_eq!(feathered(UVec2::new(3, 1), &[true, false, true]), [255, 0, 255]);
        assert!(feathered(UVec2::ZERO, &[]).is_empty());
        assert_eq!((alpha(0, 3e4), alpha(BESIDE, 3e4)), (0, 1), "faint is not hidden");
    }
}
