//! Tells cargo to build again when a page is added to the explanations: `include_dir!` itself only
//! sees changes of files that were there before.

fn main() {
    println!("cargo::rerun-if-changed=src/diagnostics/explanations");
}
