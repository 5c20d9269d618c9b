//! Gives the engine a hash of all that decides its results, so that it never takes what another
//! version of it has remembered for its own.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

/// Relative to this crate: every crate below `cli`, the C that stations are made of, and the
/// packages that they are built with.
const SOURCES: [&str; 3] = ["..", "../../ffi", "../../Cargo.lock"];

fn main() {
    // `include_dir!` itself only sees changes of files that were there before.
    println!("cargo::rerun-if-changed=../../contracts");
    let mut hasher = DefaultHasher::new();
    for path in SOURCES {
        println!("cargo::rerun-if-changed={path}");
        hash(Path::new(path), &mut hasher);
    }
    let sources = hasher.finish();
    println!("cargo::rustc-env=LINEWRIGHT_SOURCES={sources:016x}");
}

/// The names and contents of all files, in order; what cannot be read counts as nothing.
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
