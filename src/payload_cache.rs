//! Where what was fetched is kept for the next time.

use std::path::PathBuf;

use clap::Args;
use flaneur_streamer::{CacheOptions, DiskOptions, StreamOptions};

use crate::memory::MemorySize;

/// A folder for what was fetched.
#[derive(Args, Clone, Debug)]
pub(crate) struct PayloadCache {
    /// Keep what was fetched in this folder, and take it from there the next time
    #[arg(long, value_name = "FOLDER")]
    cache: Option<PathBuf>,
    /// The cache's files together take at most so much; what was used longest ago is given up first
    #[arg(long, value_name = "SIZE", default_value = "4GiB", requires = "cache")]
    cache_size: MemorySize,
}

impl PayloadCache {
    /// The default options, with this cache.
    pub(crate) fn options(&self) -> StreamOptions {
        let options = StreamOptions::default();
        let bytes = self.cache_size.bytes();
        let disk = self.cache.clone().map(|folder| DiskOptions { folder, bytes });
        StreamOptions { cache: CacheOptions { disk, ..options.cache }, ..options }
    }
}
