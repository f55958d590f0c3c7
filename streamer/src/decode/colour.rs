//! Point colours: 16 bits a channel in LAS, 8 on a screen.

/// Colours at 8 bits a channel; empty where every colour is black, which is how surveys
/// without colours fill the field.
///
/// LAS asks for the full 16 bits, but many writers store 8-bit values as they are. Where no
/// channel of a whole node exceeds 255 it is taken to be one of theirs: as 16-bit values
/// they would all be black.
pub(super) fn eight_bit_colours(colours: &[[u16; 3]]) -> Vec<[u8; 3]> {
    let highest = colours.iter().flatten().copied().max().unwrap_or(0);
    match highest {
        0 => Vec::new(),
        1..256 => colours.iter().map(|c| c.map(|channel| channel as u8)).collect(),
        _ => colours.iter().map(|c| c.map(rounded)).collect(),
    }
}

/// The nearest of the 256 levels at which 255 stands for 65535.
fn rounded(channel: u16) -> u8 {
    ((u32::from(channel) * 255 + 32_767) / 65_535) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_habits_of_writers_give_the_same_colours() {
        let eight: Vec<[u16; 3]> = vec![[0, 128, 255], [1, 2, 3]];
        let sixteen: Vec<[u16; 3]> = eight.iter().map(|c| c.map(|v| v * 257)).collect();
        let shifted: Vec<[u16; 3]> = eight.iter().map(|c| c.map(|v| v << 8)).collect();
        let expected = vec![[0, 128, 255], [1, 2, 3]];
        assert_eq!(eight_bit_colours(&eight), expected);
        assert_eq!(eight_bit_colours(&sixteen), expected);
        // v · 256 is within half a level of v · 257 below 128, and at most one level beyond.
        for (got, want) in eight_bit_colours(&shifted).iter().flatten().zip(expected.as_flattened())
        {
            assert!(got.abs_diff(*want) <= 1, "{got} {want}");
        }
    }

    #[test]
    fn a_survey_without_colours_has_none() {
        assert!(eight_bit_colours(&[[0; 3]; 4]).is_empty());
        assert!(eight_bit_colours(&[]).is_empty());
    }
}
