//! Reads a ground grid by ranges.
//!
//! Only what [`super::write()`] writes is understood: a little-endian TIFF of tiles of 32-bit
//! floats. The `tiff` crate reads whole files through `Read + Seek`; here the directory is read
//! once, from the end of the object, and then the tiles that a region needs.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use flaneur_scene::{Bounds2, GroundTile, Region};
use glam::DVec2;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};
use tiff::tags::Tag;

use super::thin::thinned;
use super::{CELLS, FILE_TILE, GDAL_METADATA, GroundGrid, MAX_NODES, MAX_SIDE, UNCERTAINTY};
use crate::layers::LayerError;

/// The tiles of a selection, one after the other, rows from the south, west to east.
#[derive(Debug)]
pub struct GroundCursor {
    file: GroundFile,
    region: Region,
    /// Nodes from one that is given to the next.
    step: u32,
    /// Number of the next tile, row by row.
    next: u32,
}

#[derive(Debug)]
struct GroundFile {
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    origin: DVec2,
    spacing_m: f64,
    columns: u32,
    rows: u32,
    uncertainty_m: f64,
    /// Where each tile of the file begins, rows from the north.
    offsets: Vec<u64>,
}

/// Bytes of a tile of the file.
const TILE_BYTES: u64 = FILE_TILE as u64 * FILE_TILE as u64 * 4;

/// Bytes at the end of the object among which the directory is looked for.
const TAIL_BYTES: u64 = 256 << 10;

/// Opens the ground of `size` bytes at `path`; the cursor gives the tiles that meet
/// `region`, of each every `step`-th node: 1, or a divisor of a tile's cells.
///
/// # Errors
///
/// Where the object is not such a layer, or states sizes that it cannot hold.
pub async fn open(
    store: Arc<dyn ObjectStore>,
    path: Path,
    size: u64,
    region: Region,
    step: u32,
) -> Result<GroundCursor, LayerError> {
    let file = GroundFile::open(store, path, size).await?;
    Ok(GroundCursor { file, region, step, next: 0 })
}

/// The whole ground of a local file. Blocks; not to be called from an async task.
///
/// # Errors
///
/// As [`open`].
pub fn load(path: &std::path::Path) -> Result<GroundGrid, LayerError> {
    futures::executor::block_on(async {
        let place = Path::from_absolute_path(path).map_err(object_store::Error::from)?;
        let store: Arc<dyn ObjectStore> = Arc::new(LocalFileSystem::new());
        let size = store.head(&place).await?.size;
        let mut cursor = open(store, place, size, Region::All, 1).await?;
        let GroundFile { origin, spacing_m, columns, rows, uncertainty_m, .. } = cursor.file;
        let mut heights = vec![f32::NAN; columns as usize * rows as usize];
        while let Some(tile) = cursor.next().await? {
            let (first_column, first_row) =
                (tile.index.0 as u32 * CELLS, tile.index.1 as u32 * CELLS);
            for (i, line) in tile.heights.chunks_exact(tile.columns as usize).enumerate() {
                let at = (first_row as usize + i) * columns as usize + first_column as usize;
                heights[at..at + line.len()].copy_from_slice(line);
            }
        }
        Ok(GroundGrid { origin, spacing_m, columns, rows, heights, uncertainty_m })
    })
}

impl GroundCursor {
    /// The next tile, or `None` after the last. Tiles without a known height are left out.
    ///
    /// # Errors
    ///
    /// Where the store fails or the layer is damaged.
    pub async fn next(&mut self) -> Result<Option<GroundTile>, LayerError> {
        let across = (self.file.columns - 1).div_ceil(CELLS);
        let down = (self.file.rows - 1).div_ceil(CELLS);
        while self.next < across * down {
            let (x, y) = (self.next % across, self.next / across);
            self.next += 1;
            let (columns, rows) = self.file.nodes(x, y);
            if !self.region.meets(&self.file.bounds(&columns, &rows)) {
                continue;
            }
            let heights = self.file.heights(&columns, &rows).await?;
            let tile = GroundTile {
                index: (x as i32, y as i32),
                origin: self.file.bounds(&columns, &rows).min,
                spacing_m: self.file.spacing_m,
                columns: columns.end - columns.start,
                heights,
                uncertainty_m: self.file.uncertainty_m,
            };
            let tile = thinned(tile, self.step);
            if tile.heights.iter().any(|height| height.is_finite()) {
                return Ok(Some(tile));
            }
        }
        Ok(None)
    }
}

impl GroundFile {
    async fn open(store: Arc<dyn ObjectStore>, path: Path, size: u64) -> Result<Self, LayerError> {
        let damaged = |place: &str, problem: String| LayerError::damaged(&path, place, problem);
        if size < 8 {
            return Err(damaged("header", format!("{size} bytes are no TIFF")));
        }
        let header = store.get_range(&path, 0..8).await?;
        if header.get(..4) != Some(b"II\x2a\0") {
            return Err(damaged("header", "it does not begin as a little-endian TIFF".to_owned()));
        }
        let tail_start = size.saturating_sub(TAIL_BYTES);
        let tail =
            Tail { start: tail_start, bytes: store.get_range(&path, tail_start..size).await? };
        let directory = header.get(4..8).and_then(|at| at.first_chunk()).copied();
        let directory = u64::from(directory.map_or(0, u32::from_le_bytes));
        let tags = tail.directory(directory).ok_or_else(|| {
            damaged("header", format!("no directory at byte {directory} of {size}"))
        })?;

        let number = |tag: Tag| {
            let value = tags.get(&tag.to_u16()).and_then(Entry::numbers).unwrap_or_default();
            value.first().copied().ok_or_else(|| damaged("directory", format!("it lacks {tag:?}")))
        };
        let doubles = |tag: Tag, count: usize| {
            let value = tags.get(&tag.to_u16()).and_then(Entry::doubles).unwrap_or_default();
            if value.len() == count && value.iter().all(|v| v.is_finite()) {
                Ok(value)
            } else {
                Err(damaged("directory", format!("{tag:?} is {value:?}")))
            }
        };
        let expected = [
            (Tag::BitsPerSample, 32),
            (Tag::SampleFormat, 3),
            (Tag::Compression, 1),
            (Tag::SamplesPerPixel, 1),
            (Tag::TileWidth, u64::from(FILE_TILE)),
            (Tag::TileLength, u64::from(FILE_TILE)),
        ];
        for (tag, expected) in expected {
            let found = number(tag)?;
            if found != expected {
                return Err(damaged("directory", format!("{tag:?} is {found}, not {expected}")));
            }
        }
        let (columns, rows) = (number(Tag::ImageWidth)?, number(Tag::ImageLength)?);
        let side = 2..=u64::from(MAX_SIDE);
        if !(side.contains(&columns) && side.contains(&rows) && columns * rows <= MAX_NODES) {
            return Err(damaged("directory", format!("a grid of {columns} × {rows} nodes")));
        }
        let tiles = columns.div_ceil(u64::from(FILE_TILE)) * rows.div_ceil(u64::from(FILE_TILE));
        let offsets = tags.get(&Tag::TileOffsets.to_u16()).and_then(Entry::numbers);
        let offsets = offsets.unwrap_or_default();
        if offsets.len() as u64 != tiles || offsets.iter().any(|&at| at + TILE_BYTES > size) {
            let problem = format!(
                "{} tiles where {columns} × {rows} nodes need {tiles}, or one beyond byte {size}",
                offsets.len()
            );
            return Err(damaged("directory", problem));
        }
        let scale = doubles(Tag::ModelPixelScaleTag, 3)?;
        let tie = doubles(Tag::ModelTiepointTag, 6)?;
        let spacing_m = scale[0];
        if !(spacing_m > 0.0 && scale[1] == spacing_m && tie[0] == 0.0 && tie[1] == 0.0) {
            return Err(damaged("directory", format!("pixel scale {scale:?}, tie point {tie:?}")));
        }
        let origin = DVec2::new(tie[3], tie[4] - (rows - 1) as f64 * spacing_m);
        let uncertainty_m = tags
            .get(&GDAL_METADATA)
            .and_then(|entry| uncertainty(&entry.value))
            .ok_or_else(|| damaged("directory", format!("it lacks the item {UNCERTAINTY:?}")))?;
        let (columns, rows) = (columns as u32, rows as u32);
        Ok(Self { store, path, size, origin, spacing_m, columns, rows, uncertainty_m, offsets })
    }

    /// Columns and rows (from the south) of the nodes of a tile.
    fn nodes(&self, x: u32, y: u32) -> (Range<u32>, Range<u32>) {
        let range = |i: u32, count: u32| i * CELLS..count.min((i + 1) * CELLS + 1);
        (range(x, self.columns), range(y, self.rows))
    }

    fn bounds(&self, columns: &Range<u32>, rows: &Range<u32>) -> Bounds2 {
        let node =
            |c: u32, r: u32| self.origin + DVec2::new(f64::from(c), f64::from(r)) * self.spacing_m;
        Bounds2 { min: node(columns.start, rows.start), max: node(columns.end - 1, rows.end - 1) }
    }

    /// Heights of a rectangle of nodes, rows from the south.
    async fn heights(
        &self,
        columns: &Range<u32>,
        rows: &Range<u32>,
    ) -> Result<Vec<f32>, LayerError> {
        let across = self.columns.div_ceil(FILE_TILE);
        // Rows of the file run from the north.
        let (north, south) = (self.rows - rows.end, self.rows - 1 - rows.start);
        let (west, east) = (columns.start / FILE_TILE, (columns.end - 1) / FILE_TILE);
        let mut tiles = Vec::new();
        for row in north / FILE_TILE..=south / FILE_TILE {
            tiles.extend((west..=east).map(|column| row * across + column));
        }
        let ranges: Vec<Range<u64>> = tiles
            .iter()
            .filter_map(|&tile| self.offsets.get(tile as usize))
            .map(|&at| at..at + TILE_BYTES)
            .collect();
        let pieces = self.store.get_ranges(&self.path, &ranges).await?;
        if pieces.len() != tiles.len() || pieces.iter().any(|p| p.len() as u64 != TILE_BYTES) {
            let problem = format!("the store gave less than the {} bytes listed", self.size);
            return Err(LayerError::damaged(&self.path, "tiles", problem));
        }
        let pieces: HashMap<u32, Bytes> = tiles.into_iter().zip(pieces).collect();
        let height = |column: u32, row: u32| {
            let from_north = self.rows - 1 - row;
            let tile = (from_north / FILE_TILE) * across + column / FILE_TILE;
            let at = (from_north % FILE_TILE) * FILE_TILE + column % FILE_TILE;
            let value =
                pieces.get(&tile).and_then(|piece| piece.as_chunks::<4>().0.get(at as usize));
            value.map_or(f32::NAN, |value| f32::from_le_bytes(*value))
        };
        Ok(rows
            .clone()
            .flat_map(|r| columns.clone().map(move |c| (c, r)))
            .map(|(c, r)| height(c, r))
            .collect())
    }
}

/// The last bytes of an object.
struct Tail {
    start: u64,
    bytes: Bytes,
}

/// The value of a tag.
struct Entry {
    kind: u16,
    value: Bytes,
}

impl Tail {
    /// The tags of the directory at byte `at`, by their numbers. Those whose value is not among
    /// these bytes, or of a type that is not needed here, are left out.
    fn directory(&self, at: u64) -> Option<HashMap<u16, Entry>> {
        let count = self.slice(at, 2)?;
        let count = u64::from(u16::from_le_bytes(*count.first_chunk()?));
        // After the entries comes the place of a next directory, which is not needed.
        let entries = self.slice(at + 2, count * 12 + 4)?;
        let mut tags = HashMap::new();
        for (i, entry) in entries.as_chunks::<12>().0.iter().enumerate() {
            let [t0, t1, k0, k1, count @ .., o0, o1, o2, o3] = *entry;
            let kind = u16::from_le_bytes([k0, k1]);
            let unit = match kind {
                1 | 2 => 1,
                3 => 2,
                4 => 4,
                12 => 8,
                _ => continue,
            };
            let length = u64::from(u32::from_le_bytes(count)) * unit;
            let place = if length <= 4 {
                at + 2 + i as u64 * 12 + 8
            } else {
                u64::from(u32::from_le_bytes([o0, o1, o2, o3]))
            };
            if let Some(value) = self.slice(place, length) {
                tags.insert(u16::from_le_bytes([t0, t1]), Entry { kind, value });
            }
        }
        Some(tags)
    }

    fn slice(&self, at: u64, length: u64) -> Option<Bytes> {
        let start = usize::try_from(at.checked_sub(self.start)?).ok()?;
        let end = start.checked_add(usize::try_from(length).ok()?)?;
        (end <= self.bytes.len()).then(|| self.bytes.slice(start..end))
    }
}

impl Entry {
    fn numbers(&self) -> Option<Vec<u64>> {
        match self.kind {
            3 => Some(
                self.value
                    .as_chunks()
                    .0
                    .iter()
                    .map(|v| u64::from(u16::from_le_bytes(*v)))
                    .collect(),
            ),
            4 => Some(
                self.value
                    .as_chunks()
                    .0
                    .iter()
                    .map(|v| u64::from(u32::from_le_bytes(*v)))
                    .collect(),
            ),
            _ => None,
        }
    }

    fn doubles(&self) -> Option<Vec<f64>> {
        let values = self.value.as_chunks().0.iter();
        (self.kind == 12).then(|| values.map(|v| f64::from_le_bytes(*v)).collect())
    }
}

fn uncertainty(metadata: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(metadata).ok()?;
    let (_, rest) = text.split_once(&format!("name=\"{UNCERTAINTY}\">"))?;
    let (value, _) = rest.split_once('<')?;
    value.parse().ok().filter(|value: &f64| *value >= 0.0)
}
