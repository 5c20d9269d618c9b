//! Tells cargo to build again when a file is added to the embedded library: `include_dir!` itself only sees changes of files that
//! were there before.

fn main() {
    println!("cargo::rerun-if-changed=contracts");
}
