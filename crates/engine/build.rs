//! Gives the engine a hash of everything that determines its results, so that one version never
//! reuses cached results of another.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

/// Hashed paths, relative to this crate: every crate next to `cli`, the C sources of stations, and
/// the locked dependencies.
const SOURCES: [&str; 3] = ["..", "../../ffi", "../../Cargo.lock"];

fn main() {
    // `include_dir!` alone only notices changes to files that already existed.
    println!("cargo::rerun-if-changed=../../contracts");
    let mut hasher = DefaultHasher::new();
    for path in SOURCES {
        println!("cargo::rerun-if-changed={path}");
        hash(Path::new(path), &mut hasher);
    }
    let sources = hasher.finish();
    println!("cargo::rustc-env=LINEWRIGHT_SOURCES={sources:016x}");
}

/// Hashes the names and contents of all files in order; skips what cannot be read.
fn hash(path: &Path, hasher: &mut DefaultHasher) {
    if let Ok(entries) = std::fs::read_dir(path) {
        let mut inner: Vec<_> = entries.flatten().map(|e| e.path()).collect();
        inner.sort();
        for path in inner {
            path.file_name().hash(hasher);
            hash(&path, hasher);
        }
    } else if let Ok(bytes) = std::fs::read(path) {
        bytes.hash(hasher);
    }
}
