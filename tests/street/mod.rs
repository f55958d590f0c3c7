//! A small synthetic street, ingested into a store of the test's own.

#![allow(dead_code, reason = "each test file is a crate and uses its share")]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use flaneur_sample::{SampleOptions, write_street};
use flaneur_services::ingest::street::Street;
use flaneur_services::ingest::{IngestOptions, Job, ingest};
use flaneur_services::store::Store;

/// Where the street was written and where its scene, `sample`, was published. Both lie in
/// the build folder, one pair for each test that asks, and are made anew every time.
pub(crate) struct SampleStreet {
    pub(crate) survey: PathBuf,
    pub(crate) store: PathBuf,
}

impl SampleStreet {
    pub(crate) async fn ingested(name: &str) -> Self {
        Self::of(name, SampleOptions::tiny(7)).await
    }

    /// The same street with so many points that they make a tree of several levels.
    pub(crate) async fn dense(name: &str) -> Self {
        Self::of(name, SampleOptions { points: 600_000, ..SampleOptions::tiny(7) }).await
    }

    async fn of(name: &str, options: SampleOptions) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).expect("the test's own folder");
        }
        std::fs::create_dir_all(&folder).expect("the build folder is writable");
        let street = Self { survey: folder.join("survey"), store: folder.join("store") };
        write_street(&street.survey, &options, &|_| {}, &AtomicBool::new(false)).expect("a street");
        let survey = Street::open(&street.survey, false).expect("the sample's own format");
        let store = Store::open(street.store.to_str().expect("text")).expect("a folder");
        let job = Arc::new(Job::new(folder.join("work"), 1 << 30));
        ingest(survey, store, IngestOptions::default(), job).await.expect("a sound survey");
        street
    }
}
