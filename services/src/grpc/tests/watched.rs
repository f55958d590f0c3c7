//! A store that sees what is read from it, and lets nothing through while it is closed.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use futures::stream::BoxStream;
use object_store::path::Path;
use object_store::{
    CopyOptions, Error, GetOptions, GetResult, ListResult, MultipartUpload, ObjectMeta,
    ObjectStore, PutMultipartOptions, PutOptions, PutPayload, PutResult, Result,
};

/// The store.
#[derive(Debug)]
pub(super) struct Watched {
    inner: Arc<dyn ObjectStore>,
    reads: Arc<Reads>,
}

/// What was read.
#[derive(Debug, Default)]
pub(super) struct Reads {
    begun: AtomicUsize,
    under_way: AtomicUsize,
    closed: AtomicBool,
    broken: AtomicBool,
}

impl Watched {
    pub(super) fn over(inner: Arc<dyn ObjectStore>) -> (Arc<dyn ObjectStore>, Arc<Reads>) {
        let reads = Arc::<Reads>::default();
        (Arc::new(Self { inner, reads: reads.clone() }), reads)
    }
}

impl Reads {
    /// Reads so far.
    pub(super) fn begun(&self) -> usize {
        self.begun.load(Ordering::SeqCst)
    }

    /// Reads for which someone waits.
    pub(super) fn under_way(&self) -> usize {
        self.under_way.load(Ordering::SeqCst)
    }

    /// From now on no read ends.
    pub(super) fn close(&self) {
        self.closed.store(true, Ordering::SeqCst);
    }

    /// From now on every read fails.
    pub(super) fn break_down(&self) {
        self.broken.store(true, Ordering::SeqCst);
    }

    /// Waits until reads have not begun for a while, and gives their number.
    pub(super) async fn settled(&self) -> usize {
        let mut last = self.begun();
        let mut quiet = 0;
        while quiet < 10 {
            tokio::time::sleep(Duration::from_millis(20)).await;
            let now = self.begun();
            quiet = if now == last { quiet + 1 } else { 0 };
            last = now;
        }
        last
    }
}

/// A read under way, until it is dropped.
struct UnderWay<'a>(&'a Reads);

impl<'a> UnderWay<'a> {
    fn begin(reads: &'a Reads) -> Self {
        reads.begun.fetch_add(1, Ordering::SeqCst);
        reads.under_way.fetch_add(1, Ordering::SeqCst);
        Self(reads)
    }
}

impl Drop for UnderWay<'_> {
    fn drop(&mut self) {
        self.0.under_way.fetch_sub(1, Ordering::SeqCst);
    }
}

impl fmt::Display for Watched {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "watched {}", self.inner)
    }
}

#[tonic::async_trait]
impl ObjectStore for Watched {
    async fn get_opts(&self, path: &Path, options: GetOptions) -> Result<GetResult> {
        let _under_way = UnderWay::begin(&self.reads);
        if self.reads.closed.load(Ordering::SeqCst) {
            std::future::pending::<()>().await;
        }
        if self.reads.broken.load(Ordering::SeqCst) {
            return Err(Error::Generic { store: "watched", source: "it is broken".into() });
        }
        self.inner.get_opts(path, options).await
    }

    async fn put_opts(&self, path: &Path, payload: PutPayload, o: PutOptions) -> Result<PutResult> {
        self.inner.put_opts(path, payload, o).await
    }

    async fn put_multipart_opts(
        &self,
        path: &Path,
        options: PutMultipartOptions,
    ) -> Result<Box<dyn MultipartUpload>> {
        self.inner.put_multipart_opts(path, options).await
    }

    fn delete_stream(
        &self,
        paths: BoxStream<'static, Result<Path>>,
    ) -> BoxStream<'static, Result<Path>> {
        self.inner.delete_stream(paths)
    }

    fn list(&self, prefix: Option<&Path>) -> BoxStream<'static, Result<ObjectMeta>> {
        self.inner.list(prefix)
    }

    async fn list_with_delimiter(&self, prefix: Option<&Path>) -> Result<ListResult> {
        self.inner.list_with_delimiter(prefix).await
    }

    async fn copy_opts(&self, from: &Path, to: &Path, options: CopyOptions) -> Result<()> {
        self.inner.copy_opts(from, to, options).await
    }
}
