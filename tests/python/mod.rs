//! The Python that `make test` sets up.

use std::path::PathBuf;

/// Its program, with the packages of `tests/requirements.txt`.
pub(crate) fn python() -> PathBuf {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/target/python-venv/bin/python");
    let python = std::env::var_os("FLANEUR_TEST_PYTHON").map_or(default.into(), PathBuf::from);
    assert!(
        python.is_file(),
        "{} is absent: run `make test`, which sets it up, or set FLANEUR_TEST_PYTHON to a \
         Python with the packages of tests/requirements.txt",
        python.display()
    );
    python
}
