//! Tells cargo to build again when a file is added to an embedded folder: `include_dir!` itself only sees changes of
//! files that were there before. And gives the program a hash of its own sources, so that it never takes what another
//! version of it has remembered for its own.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

fn main() {
    for folder in ["contracts", "src", "Cargo.lock", "build.rs"] {
        println!("cargo::rerun-if-changed={folder}");
    }
    let mut hasher = DefaultHasher::new();
    hash(Path::new("src"), &mut hasher);
    hash(Path::new("Cargo.lock"), &mut hasher);
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
