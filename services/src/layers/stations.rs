//! `points/{source}.{version}.stations.json`: where a point source was taken from, a list of
//! [`Station`]s.

use flaneur_proto::{FieldError, v1};
use flaneur_scene::Station;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};

use super::LayerError;

/// Largest file that is read: as many stations as can be sent, at a hundred bytes and more each.
const MAX_BYTES: u64 = 8 << 20;

/// The file's content.
///
/// # Errors
///
/// Where the stations cannot be sent: they do not ascend in time, or lie nowhere.
pub fn encode(stations: &[Station]) -> Result<Vec<u8>, String> {
    v1::Stations::try_from(stations).map_err(|error| error.to_string())?;
    serde_json::to_vec(stations).map_err(|error| error.to_string())
}

/// What [`encode`] wrote.
///
/// # Errors
///
/// Where the bytes are no such file.
pub fn decode(bytes: &[u8]) -> Result<Vec<Station>, serde_json::Error> {
    serde_json::from_slice(bytes)
}

/// The stations in the file of `size` bytes at `path`, as they are sent.
///
/// # Errors
///
/// Where the store fails, or the file is damaged.
pub async fn read(
    store: &dyn ObjectStore,
    path: &Path,
    size: u64,
) -> Result<v1::Stations, LayerError> {
    let damaged = |problem: String| LayerError::damaged(path, "stations", problem);
    if !(1..=MAX_BYTES).contains(&size) {
        return Err(damaged(format!("{size} bytes, must be 1 to {MAX_BYTES}")));
    }
    let bytes = store.get_range(path, 0..size).await?;
    let stations = decode(&bytes).map_err(|error| damaged(error.to_string()))?;
    let message = v1::Stations::try_from(&stations[..]);
    message.map_err(|error: FieldError| damaged(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use object_store::memory::InMemory;

    #[tokio::test]
    async fn what_was_written_comes_back_and_damage_is_named() {
        let stations: Vec<Station> = (0..100)
            .map(|i| Station {
                time_s: f64::from(i),
                position: DVec3::splat(f64::from(i)),
                correction: flaneur_scene::StationCorrection::default(),
            })
            .collect();
        let (store, path) = (InMemory::new(), Path::from("a.stations.json"));
        let bytes = encode(&stations).expect("ascending");
        store.put(&path, bytes.clone().into()).await.expect("memory");
        let size = bytes.len() as u64;
        let back = read(&store, &path, size).await.expect("sound");
        assert_eq!(Vec::try_from(back), Ok(stations));
        for (size, says) in [(size - 1, "EOF"), (0, "must be"), (u64::MAX, "must be")] {
            let error = read(&store, &path, size).await.expect_err(says).to_string();
            assert!(error.contains(says), "{error}");
        }
        let backwards = br#"[{"time_s":1,"position":[0,0,0]},{"time_s":0,"position":[0,0,0]}]"#;
        store.put(&path, backwards.to_vec().into()).await.expect("memory");
        let error = read(&store, &path, backwards.len() as u64).await.expect_err("backwards");
        assert!(error.to_string().contains("stations[1]"), "{error}");
    }
}
