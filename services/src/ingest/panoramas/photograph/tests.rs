//! What is read, and what is refused before and while it is decoded.

use image::ImageFormat;

use super::*;
use crate::ingest::panoramas::tests::survey::{encoded, jpeg};

const SIZE: UVec2 = UVec2::new(120, 80);

fn inspect(bytes: &[u8]) -> (tempfile::NamedTempFile, Result<Photograph, String>) {
    let file = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(file.path(), bytes).expect("written");
    let photograph = Photograph::inspect(file.path()).map_err(|e| e.to_string());
    (file, photograph)
}

fn decode(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let (_file, photograph) = inspect(bytes);
    let photograph = photograph?;
    photograph.decode(&photograph.read().expect("read")).map_err(|e| e.to_string())
}

fn progressive() -> Vec<u8> {
    jpeg_with(|encoder| encoder.set_progressive(true))
}

fn grey() -> Vec<u8> {
    let mut bytes = Vec::new();
    let luma: Vec<u8> = (0..SIZE.x * SIZE.y).map(|i| (i % 251) as u8).collect();
    jpeg_encoder::Encoder::new(&mut bytes, 90)
        .encode(&luma, SIZE.x as u16, SIZE.y as u16, jpeg_encoder::ColorType::Luma)
        .expect("encoded");
    bytes
}

/// A JPEG as `jpeg_encoder` writes it with these settings.
fn jpeg_with(set: impl Fn(&mut jpeg_encoder::Encoder<&mut Vec<u8>>)) -> Vec<u8> {
    let rgb = decode(&jpeg(SIZE, 1)).expect("decodes");
    let mut bytes = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, 90);
    set(&mut encoder);
    encoder
        .encode(&rgb, SIZE.x as u16, SIZE.y as u16, jpeg_encoder::ColorType::Rgb)
        .expect("encoded");
    bytes
}

/// Where the frame header of a JPEG keeps height and width.
fn frame_size(jpeg: &[u8]) -> usize {
    let marker = jpeg.windows(2).position(|w| matches!(w, [0xff, 0xc0 | 0xc2])).expect("a frame");
    marker + 5
}

#[test]
fn formats_are_known_by_content_and_give_rgb() {
    let expected = decode(&jpeg(SIZE, 1)).expect("decodes");
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP] {
        let rgb = decode(&encoded(SIZE, 1, format)).expect("decodes");
        assert_eq!(rgb, expected, "{format:?} is lossless");
    }
    let rgb = decode(&progressive()).expect("decodes");
    let worst = rgb.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst < Some(40), "recompressed: {worst:?}");
    let rgb = decode(&grey()).expect("decodes");
    assert!(rgb.as_chunks::<3>().0.iter().all(|[r, g, b]| r == g && g == b));
}

/// The kinds of JPEG that cameras and tools write come out alike; the one that the decoder
/// gets wrong is refused.
#[test]
fn subsampled_jpegs_are_decoded_or_refused() {
    use jpeg_encoder::SamplingFactor::{F_1_1, F_2_1, F_2_2};
    let expected = decode(&jpeg(SIZE, 1)).expect("decodes");
    for sampling in [F_1_1, F_2_1, F_2_2] {
        for (progressive, optimized) in [(false, false), (true, false), (true, true), (false, true)]
        {
            let bytes = jpeg_with(|encoder| {
                encoder.set_sampling_factor(sampling);
                encoder.set_progressive(progressive);
                encoder.set_optimized_huffman_tables(optimized);
            });
            let result = decode(&bytes);
            // This encoder separates the scans of what it optimises.
            if sampling != F_1_1 && optimized && !progressive {
                assert!(result.expect_err("refused").contains("separate scans"));
                continue;
            }
            let rgb = result.expect("decodes");
            let differences = rgb.iter().zip(&expected).map(|(a, b)| u64::from(a.abs_diff(*b)));
            let mean = differences.sum::<u64>() as f64 / rgb.len() as f64;
            // Blurred colours cost some levels at the picture's edges, wrong ones a hundred.
            assert!(mean < 20.0, "{sampling:?} {progressive} {optimized}: {mean}");
        }
    }
}

#[test]
fn what_is_no_image_is_refused_by_its_first_bytes() {
    for (bytes, expected) in [
        (&b""[..], "it is empty"),
        (b"<html>not found</html>", "it begins with [3c, 68, 74"),
        (b"GIF89a..........", "no JPEG, PNG, TIFF or WebP"),
        (&[0xff, 0xd8, 0xff], "its header is damaged"),
        (&[0xff; 64], "it begins with [ff, ff"),
    ] {
        let (file, result) = inspect(bytes);
        let message = result.expect_err(expected);
        assert!(message.contains(expected), "{message}");
        assert!(message.contains(&file.path().display().to_string()), "{message}");
    }
}

/// The header of an image bomb is refused before its pixels are asked for.
#[test]
fn sizes_are_refused_by_the_header() {
    for (width, height) in [(60_000_u16, 60_000_u16), (u16::MAX, u16::MAX), (0, 80)] {
        let mut bytes = jpeg(SIZE, 1);
        let at = frame_size(&bytes);
        bytes[at..at + 2].copy_from_slice(&height.to_be_bytes());
        bytes[at + 2..at + 4].copy_from_slice(&width.to_be_bytes());
        let message = inspect(&bytes).1.expect_err("too large");
        assert!(message.contains(&format!("{width}×{height}")) || width == 0, "{message}");
    }
    let mut png = encoded(SIZE, 1, ImageFormat::Png);
    // Width in the IHDR; its checksum is then wrong too, which may be found first.
    png[16..20].copy_from_slice(&0x7fff_ffff_u32.to_be_bytes());
    inspect(&png).1.expect_err("too large or damaged");
}

/// A file that lacks its tail never decodes to a picture with a grey area.
#[test]
fn images_cut_short_are_refused() {
    for whole in [jpeg(SIZE, 1), progressive(), grey(), encoded(SIZE, 1, ImageFormat::Png)] {
        decode(&whole).expect("whole");
        for share in [0.02, 0.3, 0.5, 0.7, 0.9, 0.97] {
            let cut = &whole[..(whole.len() as f64 * share) as usize];
            let message = decode(cut).expect_err("cut short");
            assert!(message.contains("damaged"), "{share}: {message}");
        }
    }
}

/// Damage never panics, whatever it does to the picture.
#[test]
fn zeroed_blocks_do_not_panic() {
    for whole in [
        jpeg(SIZE, 1),
        progressive(),
        encoded(SIZE, 1, ImageFormat::Tiff),
        encoded(SIZE, 1, ImageFormat::WebP),
    ] {
        for start in (0..whole.len()).step_by(37) {
            let mut damaged = whole.clone();
            let end = damaged.len().min(start + 24);
            damaged[start..end].fill(0);
            let _ = decode(&damaged);
        }
    }
}

#[test]
fn memory_counts_pixels_and_coefficients() {
    let memory = |bytes: &[u8]| inspect(bytes).1.expect("valid").memory - bytes.len() as u64;
    let pixels = u64::from(SIZE.x * SIZE.y);
    assert_eq!(memory(&jpeg(SIZE, 1)), pixels * HALVING);
    assert_eq!(memory(&progressive()), pixels * (HALVING + COEFFICIENTS));
    assert_eq!(memory(&encoded(SIZE, 1, ImageFormat::Png)), pixels * (HALVING + 3));
}
