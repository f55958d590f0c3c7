//! The name of a payload.

use std::fmt;
use std::sync::Arc;

/// Names a payload: equal keys name equal bytes.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct CacheKey(Arc<str>);

impl CacheKey {
    /// The payload `name` among those of `kind`, in the given version of a scene. The texts may hold
    /// anything: each is preceded by its length, so that no two sets of texts give one key.
    pub(crate) fn new(scene: &str, version: &str, kind: &str, name: &str) -> Self {
        let length = |text: &str| text.len();
        let (a, b, c, d) = (length(scene), length(version), length(kind), length(name));
        Self(format!("{a}:{scene},{b}:{version},{c}:{kind},{d}:{name}").into())
    }

    /// The key as one text.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for CacheKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_texts_give_other_keys() {
        let keys = [
            CacheKey::new("street", "1", "image", "a"),
            CacheKey::new("street", "1", "imag", "ea"),
            CacheKey::new("street1", "", "image", "a"),
            CacheKey::new("street,1:1", "", "image", "a"),
            CacheKey::new("street", "1,5:image", "", "a"),
            CacheKey::new("", "", "", "street1imagea"),
        ];
        for (i, one) in keys.iter().enumerate() {
            assert!(keys.iter().skip(i + 1).all(|other| one != other), "{one:?}");
        }
        assert_eq!(keys[0], CacheKey::new("street", "1", "image", "a"));
    }
}
