//! A library as a file and in memory: its exports, its size, and that it allocates nothing.

use super::images::{exports, symbols};
use super::machines::{named, shipped};
use super::programs::{Host, Prepared, cc};
use crate::support::programs::run;
use crate::support::{root, skip};
use linewright::station::toolchain::CrossCompiler;
use linewright::station::{Package, Toolchain};
use std::collections::BTreeSet;
use std::process::Command;
use std::time::Duration;

/// Maximum number of bytes of an instance.
const INSTANCE: usize = 1024;

/// Allocation functions on any system.
const ALLOCATORS: [&str; 10] = [
    "malloc",
    "calloc",
    "realloc",
    "free",
    "aligned_alloc",
    "posix_memalign",
    "mmap",
    "sbrk",
    "strdup",
    "alloca",
];

/// The functions documented in the headers of `ffi/` and the adapter's file.
fn documented() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for file in ["station.h", "plant_simulation.c"] {
        let text = std::fs::read_to_string(root().join("ffi").join(file)).expect("the file");
        for line in text.lines().filter(|l| l.starts_with("LW_EXPORT ")) {
            let before = line.split('(').next().unwrap_or_default();
            let name = before.rsplit([' ', '*']).next().unwrap_or_default();
            names.insert(name.to_owned());
        }
    }
    names
}

#[test]
fn a_library_exports_what_is_documented_and_needs_no_memory() {
    let documented = documented();
    assert!(documented.len() >= 20, "{documented:?}");
    for subject in shipped() {
        let prepared = Prepared::new(subject);
        let library = prepared.library(&Toolchain::shipping());
        assert_eq!(
            symbols(&library, "--defined-only"),
            documented,
            "{}",
            subject.name()
        );
        let needed = symbols(&library, "--undefined-only");
        assert!(needed.contains("pthread_mutex_lock"), "{needed:?}");
        let mut allocators = ALLOCATORS.into_iter();
        let allocates = allocators.find(|a| needed.contains(*a));
        assert_eq!(allocates, None, "{}", subject.name());
        if let Some(host) = Host::windows() {
            let library = prepared.library(&host.toolchain);
            let image = std::fs::read(library).expect("the library");
            assert_eq!(exports(&image), documented, "{}", subject.name());
        }
    }
}

/// Zig makes a library equivalent to MinGW's, with the same bytes each time.
#[test]
fn zig_makes_libraries_for_windows() {
    let kinds = [CrossCompiler::Zig, CrossCompiler::PythonZig];
    let found = kinds
        .into_iter()
        .find_map(|kind| Some((kind, kind.find()?)));
    let Some((kind, compiler)) = found else {
        skip("zig", "neither zig nor Python's ziglang is on the PATH");
        return;
    };
    let toolchain = Toolchain::cross(kind, compiler);
    let subject = named("Belt");
    let image = || {
        let prepared = Prepared::new(&subject);
        std::fs::read(prepared.library(&toolchain)).expect("the library")
    };
    let first = image();
    assert_eq!(exports(&first), documented());
    assert!(first == image(), "the same bytes twice");
}

/// The memory of a thousand instances beyond the tables that they share.
#[test]
fn an_instance_takes_less_than_a_kibibyte() {
    let folder = tempfile::tempdir().expect("a folder");
    for subject in shipped() {
        let package = Package::emit(&subject.machine, &subject.controllers);
        let source = package.write_source(folder.path()).expect("the C");
        let main = folder.path().join("size.c");
        let text = format!(
            "#include \"{}.c\"\n#include <stdio.h>\n\
             int main(void) {{ printf(\"%lu\\n\", (unsigned long)(sizeof lw_slots[0] + sizeof lw_shown[0])); return 0; }}\n",
            package.stem
        );
        std::fs::write(&main, text).expect("a file");
        let program = source.with_extension("size");
        let output = cc()
            .arg(&main)
            .arg("-o")
            .arg(&program)
            .args(["-pthread", "-lm"])
            .output();
        let output = output.expect("the compiler starts");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let finished = run(&mut Command::new(&program), Duration::from_secs(10));
        let size: usize = finished.last_line().parse().expect("a size");
        println!("{}: {size} bytes an instance", subject.name());
        assert!(
            size > 8 && size < INSTANCE,
            "{}: {size} bytes",
            subject.name()
        );
    }
}

/// The same package and the same compiler give the same bytes, in any folder.
#[test]
fn builds_are_reproducible() {
    let subject = named("AssemblyCell");
    let package = Package::emit(&subject.machine, &subject.controllers);
    let mut toolchains = vec![Toolchain::host(), Toolchain::shipping()];
    match Toolchain::windows() {
        Ok(windows) => toolchains.push(windows),
        Err(error) => skip("mingw", &error.to_string()),
    }
    for toolchain in toolchains {
        let platform = toolchain.platform();
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        let deeper = folders[1].path().join("with a longer/name");
        let build = |folder: &std::path::Path| {
            let built = toolchain
                .build(&package, folder, true)
                .expect("the library is built");
            let name = built.path.file_name().map(ToOwned::to_owned);
            (name, std::fs::read(built.path).expect("the library"))
        };
        let first = build(folders[0].path());
        // The second one is built a second later, in case a time is recorded.
        std::thread::sleep(Duration::from_millis(1100));
        assert!(first == build(&deeper), "{platform:?}");
    }
}
