//! Erosion and dilation of heights over square windows.

/// The smallest height within `radius` nodes along rows and columns; NaN is no height.
pub(super) fn erode(heights: &[f32], columns: usize, radius: usize) -> Vec<f32> {
    window(heights, columns, radius, f32::min)
}

/// The largest height within `radius` nodes along rows and columns; NaN is no height.
pub(super) fn dilate(heights: &[f32], columns: usize, radius: usize) -> Vec<f32> {
    window(heights, columns, radius, f32::max)
}

/// Rows, then columns. `pick` gives the other value where one is NaN, as `f32::min` does.
fn window(heights: &[f32], columns: usize, radius: usize, pick: fn(f32, f32) -> f32) -> Vec<f32> {
    let mut result = heights.to_vec();
    let mut line = Vec::new();
    for row in result.chunks_exact_mut(columns) {
        slide(row.iter().copied(), radius, pick, &mut line);
        row.copy_from_slice(&line);
    }
    for column in 0..columns {
        slide(result[column..].iter().step_by(columns).copied(), radius, pick, &mut line);
        result[column..].iter_mut().step_by(columns).zip(&line).for_each(|(h, v)| *h = *v);
    }
    result
}

/// Van Herk's sliding window: three picks a value, whatever the radius.
fn slide(
    values: impl Iterator<Item = f32>,
    radius: usize,
    pick: fn(f32, f32) -> f32,
    result: &mut Vec<f32>,
) {
    let width = 2 * radius + 1;
    let mut padded = vec![f32::NAN; radius];
    padded.extend(values);
    let length = padded.len() - radius;
    padded.resize(padded.len() + radius, f32::NAN);
    let (mut forward, mut backward) = (padded.clone(), padded);
    for block in forward.chunks_mut(width) {
        (1..block.len()).for_each(|i| block[i] = pick(block[i], block[i - 1]));
    }
    for block in backward.chunks_mut(width) {
        (1..block.len()).rev().for_each(|i| block[i - 1] = pick(block[i - 1], block[i]));
    }
    result.clear();
    result.extend((0..length).map(|i| pick(backward[i], forward[i + width - 1])));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_those_of_the_definition() {
        let (columns, rows) = (13usize, 9usize);
        let heights: Vec<f32> = (0..columns * rows)
            .map(|i| if i % 7 == 3 { f32::NAN } else { ((i * 7919) % 101) as f32 })
            .collect();
        for radius in [1, 2, 5, 20] {
            let (low, high) = (erode(&heights, columns, radius), dilate(&heights, columns, radius));
            for (i, (low, high)) in low.iter().zip(&high).enumerate() {
                let (r, c) = (i / columns, i % columns);
                let inside = |j: &usize| {
                    (j / columns).abs_diff(r) <= radius && (j % columns).abs_diff(c) <= radius
                };
                let near = || (0..heights.len()).filter(inside).map(|j| heights[j]);
                assert_eq!(*low, near().fold(f32::NAN, f32::min), "node {i}, radius {radius}");
                assert_eq!(*high, near().fold(f32::NAN, f32::max), "node {i}, radius {radius}");
            }
        }
    }
}
