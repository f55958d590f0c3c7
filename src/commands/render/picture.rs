//! Which picture file a name asks for.

use std::path::Path;

use flaneur_services::picture::PictureFormat;

use crate::exit::Exit;

/// Quality at which JPEG's errors are hard to see.
const JPEG_QUALITY: u8 = 92;

/// The format that the extension of `path` names.
pub(super) fn format_of(path: &Path) -> Result<PictureFormat, Exit> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "png" => Ok(PictureFormat::Png),
        "jpg" | "jpeg" => Ok(PictureFormat::Jpeg(JPEG_QUALITY)),
        "webp" => Ok(PictureFormat::WebP),
        _ => Err(Exit::bad_input(anyhow::anyhow!(
            "a picture's name ends in .png, .jpg or .webp: {:?}",
            path.display()
        ))),
    }
}
