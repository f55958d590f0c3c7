//! From what a person types to a store.

use std::path::{Component, Path as FilePath, PathBuf};
use std::sync::Arc;

use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreScheme};
use url::Url;

use super::{Store, StoreError};

/// Prefixes of the settings that cloud stores take from the environment.
const SETTINGS: [&str; 4] = ["AWS_", "GOOGLE_", "AZURE_", "OBJECT_STORE_"];

impl Store {
    /// The store at a folder path or a URL (`file://`, `memory://`, `s3://`, `gs://`, `az://`).
    /// A folder need not exist yet: it is made by the first write. Cloud stores take their
    /// settings from environment variables such as `AWS_REGION` and `AWS_ENDPOINT`.
    ///
    /// Each `memory://` is a store of its own, shared by its clones.
    pub fn open(url: &str) -> Result<Self, StoreError> {
        let settings = std::env::vars_os().filter_map(|(name, value)| {
            let name = name.into_string().ok()?;
            let wanted = SETTINGS.iter().any(|prefix| name.starts_with(prefix));
            Some((name, value.into_string().ok()?)).filter(|_| wanted)
        });
        Self::open_with(url, settings)
    }

    /// Like [`Store::open`] for a store that is to be read: a folder must exist.
    pub fn open_existing(url: &str) -> Result<Self, StoreError> {
        let store = Self::open(url)?;
        match store.folder {
            Some(ref folder) if !folder.is_dir() => {
                Err(StoreError::NoFolder { folder: url.to_owned() })
            }
            _ => Ok(store),
        }
    }

    /// Like [`Store::open`], with the settings given instead of taken from the environment.
    pub fn open_with(
        url: &str,
        settings: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Self, StoreError> {
        let bad = |problem: String| StoreError::BadUrl { problem, url: url.to_owned() };
        if !url.contains("://") {
            return Self::open_folder(url, PathBuf::from(url));
        }
        let parsed = Url::parse(url).map_err(|e| bad(e.to_string()))?;
        if parsed.scheme() == "file" {
            let folder = parsed.to_file_path().map_err(|()| bad("not a local path".to_owned()))?;
            return Self::open_folder(url, folder);
        }
        if !parsed.username().is_empty() || parsed.password().is_some() {
            return Err(bad("credentials belong in the environment, not in the URL".to_owned()));
        }
        match ObjectStoreScheme::parse(&parsed) {
            Ok((ObjectStoreScheme::Http, _)) | Err(_) => {
                return Err(bad(format!("{:?} is no kind of store", parsed.scheme())));
            }
            Ok(_) => {}
        }
        let (store, prefix) =
            object_store::parse_url_opts(&parsed, settings).map_err(|e| bad(e.to_string()))?;
        Ok(Self::new(url.trim_end_matches('/'), Arc::from(store), prefix))
    }

    /// The part of an object store below `prefix`, called `name` in messages.
    pub fn new(name: impl Into<String>, store: Arc<dyn ObjectStore>, prefix: Path) -> Self {
        Self { name: name.into(), store, prefix, folder: None }
    }

    fn open_folder(url: &str, folder: PathBuf) -> Result<Self, StoreError> {
        let bad = |problem: String| StoreError::BadUrl { problem, url: url.to_owned() };
        if url.is_empty() {
            return Err(bad("it is empty".to_owned()));
        }
        let folder = std::path::absolute(folder).map_err(|e| bad(e.to_string()))?;
        let folder = resolve(&folder).map_err(|e| bad(e.to_string()))?;
        if folder.exists() && !folder.is_dir() {
            return Err(bad("it is a file".to_owned()));
        }
        let prefix = Path::from_absolute_path(&folder).map_err(|e| bad(e.to_string()))?;
        // Rooted at the file system's root, so that the folder may come later.
        let store = Arc::new(LocalFileSystem::new());
        Ok(Self { folder: Some(folder), ..Self::new(url, store, prefix) })
    }
}

/// The folder with links and `..` resolved as far as it exists.
fn resolve(folder: &FilePath) -> std::io::Result<PathBuf> {
    let mut missing = Vec::new();
    let mut existing = folder;
    loop {
        match existing.canonicalize() {
            Ok(mut resolved) => {
                // One by one: joining nothing would append a slash, which no file has.
                resolved.extend(missing.iter().rev());
                return Ok(resolved);
            }
            Err(error) => match (existing.components().next_back(), existing.parent()) {
                (Some(Component::Normal(name)), Some(parent)) => {
                    missing.push(name);
                    existing = parent;
                }
                _ => return Err(error),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_names_no_store_is_refused_with_a_reason() {
        let problem = |url: &str| match Store::open_with(url, []) {
            Err(StoreError::BadUrl { problem, .. }) => problem,
            other => panic!("{url}: {other:?}"),
        };
        assert!(problem("ftp://host/scenes").contains("ftp"));
        assert!(problem("http://host/scenes").contains("http"));
        assert!(problem("s3://user:secret@bucket/x").contains("environment"));
        assert!(problem("").contains("empty"));
        assert!(problem(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")).contains("file"));
    }

    #[test]
    fn a_folder_may_come_later_but_not_when_it_is_to_be_read() {
        let temporary = tempfile::tempdir().expect("a folder");
        let later = temporary.path().join("a/../b/scenes");
        let url = later.to_str().expect("text");
        assert!(matches!(Store::open_with(url, []), Err(StoreError::BadUrl { .. })), "a is absent");
        let later = temporary.path().join("b/scenes");
        let url = later.to_str().expect("text");
        Store::open_with(url, []).expect("may come later");
        assert!(matches!(Store::open_existing(url), Err(StoreError::NoFolder { .. })));
        assert!(!later.exists(), "opening makes nothing");
        std::fs::create_dir_all(&later).expect("writable");
        Store::open_existing(url).expect("is there");
        Store::open_existing(Url::from_file_path(&later).expect("absolute").as_str())
            .expect("as a URL");
    }
}
