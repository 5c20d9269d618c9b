//! Makes cargo rebuild when a template is added: `include_dir!` alone only notices changes to files
//! that already existed.

fn main() {
    println!("cargo::rerun-if-changed=templates");
}
