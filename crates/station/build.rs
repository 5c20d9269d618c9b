//! Makes cargo rebuild the crate when a template is added: `include_dir!` alone only detects
//! changes to existing files.

fn main() {
    println!("cargo::rerun-if-changed=templates");
}
