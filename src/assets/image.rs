//! Pictures for textures.

use super::{AssetError, guard};
use crate::description::builtin;
use crate::workers;
use image::{DynamicImage, ImageError, ImageReader, Limits};
use std::io::{BufRead, Cursor, Seek};
use std::num::NonZeroUsize;
use std::path::Path;

/// A picture: 8-bit sRGB codes, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` texels, row by row.
    pub texels: Vec<[u8; 3]>,
}

/// Largest width or height, texels.
const MAX_SIDE: u32 = 16_384;
/// Most memory for decoding, bytes.
const MAX_ALLOC: u64 = 1 << 30;

/// [`load_image`] of each file.
pub fn load_images(files: &[&Path], threads: NonZeroUsize) -> Vec<Result<Image, AssetError>> {
    workers::map(threads, files.to_vec(), load_image)
}

/// Reads a PNG, JPEG, BMP or TGA picture, told by its content, else (TGA has no mark) by its name. Greys are expanded,
/// 16-bit samples rounded, alpha is dropped. What is larger than 16,384 texels a side or takes more than 1 GiB to
/// decode is refused before memory is taken for it.
pub fn load_image(file: &Path) -> Result<Image, AssetError> {
    let refuse = |reason: String| AssetError::new(file, None, reason);
    let decoded = match builtin(file) {
        Some(content) => guard(|| decode(ImageReader::new(Cursor::new(content)))),
        None => {
            super::check_file(file, MAX_ALLOC)?;
            guard(|| decode(ImageReader::open(file)?))
        }
    };
    let picture = match decoded {
        Some(Ok(picture)) => picture.into_rgb8(),
        Some(Err(error)) => return Err(refuse(explain(error))),
        None => return Err(refuse("cannot be decoded; save it anew as PNG".to_owned())),
    };
    let (width, height) = picture.dimensions();
    if width == 0 || height == 0 {
        return Err(refuse("has no pixels".to_owned()));
    }
    let texels = picture.into_raw().as_chunks().0.to_vec();
    Ok(Image { width, height, texels })
}

fn decode(reader: ImageReader<impl BufRead + Seek>) -> Result<DynamicImage, ImageError> {
    let mut reader = reader.with_guessed_format()?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_ALLOC);
    reader.limits(limits);
    reader.decode()
}

fn explain(error: ImageError) -> String {
    match error {
        ImageError::Unsupported(_) => format!("is not a picture of a known kind (PNG, JPEG, BMP or TGA): {error}"),
        ImageError::Limits(_) => {
            format!("is too large: at most {MAX_SIDE} x {MAX_SIDE} and 1 GiB to decode; scale it down ({error})")
        }
        ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => "ends too early".to_owned(),
        ImageError::IoError(error) => format!("cannot be read: {error}"),
        _ => format!("cannot be decoded: {error}"),
    }
}
