//! Tells cargo to build again when a file is added to an embedded folder: `include_dir!` itself only sees changes of
//! files that were there before.

fn main() {
    for folder in ["contracts", "src/diagnostics/explanations"] {
        println!("cargo::rerun-if-changed={folder}");
    }
}
