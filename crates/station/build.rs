//! Tells cargo to build again when a template is added: `include_dir!` itself only sees changes of
//! files that were there before.

fn main() {
    println!("cargo::rerun-if-changed=templates");
}
