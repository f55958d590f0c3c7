//! Writes a ground grid.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use tiff::TiffError;
use tiff::encoder::TiffEncoder;
use tiff::tags::Tag;

use super::{FILE_TILE, GDAL_METADATA, GroundGrid, UNCERTAINTY};
use crate::crs::Crs;

/// Writes `grid` in `crs` to `path`.
///
/// # Errors
///
/// Where the file cannot be written.
///
/// # Panics
///
/// Where `grid` has not as many heights as columns × rows: a mistake of the caller.
pub fn write(path: &Path, grid: &GroundGrid, crs: &Crs) -> std::io::Result<()> {
    assert_eq!(
        grid.heights.len(),
        grid.columns as usize * grid.rows as usize,
        "a grid has a height for each node"
    );
    let mut file = BufWriter::new(File::create(path)?);
    encode(&mut file, grid, crs).map_err(|error| match error {
        TiffError::IoError(error) => error,
        other => std::io::Error::other(other),
    })?;
    file.flush()?;
    file.get_ref().sync_all()
}

fn encode(file: &mut BufWriter<File>, grid: &GroundGrid, crs: &Crs) -> Result<(), TiffError> {
    let mut encoder = TiffEncoder::new(file)?;
    let mut image = encoder.image_directory()?;
    let (mut offsets, mut sizes) = (Vec::new(), Vec::new());
    let mut tile = vec![f32::NAN; (FILE_TILE * FILE_TILE) as usize];
    for tile_row in 0..grid.rows.div_ceil(FILE_TILE) {
        for tile_column in 0..grid.columns.div_ceil(FILE_TILE) {
            tile.fill(f32::NAN);
            for (i, line) in tile.chunks_exact_mut(FILE_TILE as usize).enumerate() {
                let from_north = tile_row * FILE_TILE + i as u32;
                let Some(row) = (grid.rows - 1).checked_sub(from_north) else { break };
                let start = tile_column * FILE_TILE;
                let length = FILE_TILE.min(grid.columns - start) as usize;
                let at = row as usize * grid.columns as usize + start as usize;
                line[..length].copy_from_slice(&grid.heights[at..at + length]);
            }
            let offset = image.write_data(tile.as_slice())?;
            offsets.push(u32::try_from(offset).map_err(|_| too_large())?);
            sizes.push(FILE_TILE * FILE_TILE * 4);
        }
    }
    image.write_tag(Tag::ImageWidth, grid.columns)?;
    image.write_tag(Tag::ImageLength, grid.rows)?;
    image.write_tag(Tag::BitsPerSample, 32u16)?;
    image.write_tag(Tag::Compression, 1u16)?;
    image.write_tag(Tag::PhotometricInterpretation, 1u16)?;
    image.write_tag(Tag::SamplesPerPixel, 1u16)?;
    image.write_tag(Tag::PlanarConfiguration, 1u16)?;
    image.write_tag(Tag::SampleFormat, 3u16)?;
    image.write_tag(Tag::TileWidth, FILE_TILE)?;
    image.write_tag(Tag::TileLength, FILE_TILE)?;
    image.write_tag(Tag::TileOffsets, offsets.as_slice())?;
    image.write_tag(Tag::TileByteCounts, sizes.as_slice())?;

    let north = grid.origin.y + f64::from(grid.rows - 1) * grid.spacing_m;
    let scale = [grid.spacing_m, grid.spacing_m, 0.0];
    image.write_tag(Tag::ModelPixelScaleTag, &scale[..])?;
    let tie = [0.0, 0.0, 0.0, grid.origin.x, north, 0.0];
    image.write_tag(Tag::ModelTiepointTag, &tie[..])?;
    image.write_tag(Tag::GeoKeyDirectoryTag, geo_keys(crs).as_slice())?;
    image.write_tag(Tag::GeoAsciiParamsTag, LOCAL)?;
    let metadata = format!(
        "<GDALMetadata><Item name=\"{UNCERTAINTY}\">{}</Item></GDALMetadata>",
        grid.uncertainty_m
    );
    image.write_tag(Tag::Unknown(GDAL_METADATA), metadata.as_str())?;
    image.write_tag(Tag::GdalNodata, "nan")?;
    image.finish()
}

/// What a local frame is called.
const LOCAL: &str = "local metres|";

/// Four numbers a key: which, where its value is, how long it is, the value or its index.
fn geo_keys(crs: &Crs) -> Vec<u16> {
    const MODEL_TYPE: u16 = 1024;
    const RASTER_TYPE: u16 = 1025;
    const CITATION: u16 = 1026;
    const PROJECTED_CRS: u16 = 3072;
    const LINEAR_UNITS: u16 = 3076;
    const PIXEL_IS_POINT: u16 = 2;
    const USER_DEFINED: u16 = 32_767;
    const METRE: u16 = 9001;
    const IN_ASCII: u16 = 34_737;
    match crs.epsg() {
        Some(code) => vec![
            1,
            1,
            0,
            3, //
            MODEL_TYPE,
            0,
            1,
            1, //
            RASTER_TYPE,
            0,
            1,
            PIXEL_IS_POINT, //
            PROJECTED_CRS,
            0,
            1,
            code,
        ],
        None => vec![
            1,
            1,
            0,
            4, //
            MODEL_TYPE,
            0,
            1,
            USER_DEFINED, //
            RASTER_TYPE,
            0,
            1,
            PIXEL_IS_POINT, //
            CITATION,
            IN_ASCII,
            LOCAL.len() as u16,
            0, //
            LINEAR_UNITS,
            0,
            1,
            METRE,
        ],
    }
}

fn too_large() -> TiffError {
    TiffError::IoError(std::io::Error::other("the ground does not fit into the 4 GiB of a TIFF"))
}
