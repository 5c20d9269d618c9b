//! Makes cargo rebuild when a page is added to the explanations: `include_dir!` itself only notices
//! changes to existing files.

fn main() {
    println!("cargo::rerun-if-changed=src/diagnostics/explanations");
}
