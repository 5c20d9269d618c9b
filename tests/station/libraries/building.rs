//! The toolchain: what is compiled when, and the messages on failure.

use crate::fixtures;
use linewright::diagnostics::codes;
use linewright::station::load::Library;
use linewright::station::profile::{Encoding, Profile};
use linewright::station::{Controller, Error, Package, Toolchain};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

fn manipulator() -> Package {
    let (machine, controllers) = fixtures::manipulator();
    Package::emit(&machine, &controllers)
}

/// A compiler that fails with a message.
#[cfg(unix)]
fn failing_compiler(folder: &Path) -> std::path::PathBuf {
    let path = folder.join("failing-cc");
    std::fs::write(
        &path,
        "#!/bin/sh\necho 'no compiling today' >&2\necho started >> \"$0.log\"\nexit 1\n",
    )
    .unwrap();
    make_executable(&path);
    path
}

#[cfg(unix)]
fn make_executable(path: &Path) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn emitted_c_has_no_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let compilers: Vec<&str> = ["cc", "clang"]
        .into_iter()
        .filter(|c| Command::new(c).arg("--version").output().is_ok())
        .collect();
    let mut packed = Profile::assumed();
    packed.layout.size = 12;
    packed.layout.packing = 4;
    packed.layout.value = 4;
    packed.layout.strings = Encoding::Windows1252;
    packed.layout.tag.boolean = Some(7);
    let mut wide = Profile::assumed();
    wide.layout.integer_bits = 64;
    wide.layout.strings = Encoding::Utf16;
    wide.layout.tag.bits = 64;
    wide.layout.tag.more_real = vec![8, 9];
    let mut narrow = Profile::assumed();
    narrow.layout.integer_bits = 16;
    narrow.layout.strings = Encoding::Latin1;
    narrow.layout.tag.bits = 8;
    let variants = [
        ("-O2", Profile::assumed()),
        ("-O0", packed),
        ("-O0", wide),
        ("-O1", narrow),
    ];
    for (machine, controllers) in [fixtures::manipulator(), fixtures::belt()] {
        for compiler in &compilers {
            for (variant, profile) in &variants {
                let package = Package::emit_with(&machine, &controllers, profile);
                let file = package.write_source(folder.path()).unwrap();
                let output = Command::new(compiler)
                    .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror"])
                    .arg(variant)
                    .args(["-fPIC", "-c"])
                    .arg(&file)
                    .arg("-o")
                    .arg(folder.path().join("out.o"))
                    .output()
                    .unwrap();
                let errors = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success(), "{errors}");
            }
        }
    }
}

#[test]
fn the_same_machine_gives_the_same_bytes() {
    assert_eq!(manipulator(), manipulator());
    let (machine, controllers) = fixtures::manipulator();
    let mut other = (*machine).clone();
    other.base_watts += 0.1;
    let other = Package::emit(&other, &controllers);
    assert_ne!(other.hash, manipulator().hash);
    assert_ne!(other.contract_hash, manipulator().contract_hash);
}

#[test]
fn a_small_machine_reads_well() {
    let (machine, controllers) = fixtures::belt();
    insta::assert_snapshot!("belt", Package::emit(&machine, &controllers).c_source);
}

#[test]
#[cfg(unix)]
fn what_is_there_is_not_compiled_again() {
    let folder = tempfile::tempdir().unwrap();
    let compiler = folder.path().join("cc-by-turns");
    let failing = failing_compiler(folder.path());
    let log = folder.path().join("failing-cc.log");
    std::fs::write(&compiler, "#!/bin/sh\nexec cc \"$@\"\n").unwrap();
    make_executable(&compiler);
    let build = folder.path().join("build");
    let first = Toolchain::with_compiler(&compiler)
        .build(&manipulator(), &build, false)
        .unwrap();
    assert!(first.compiled);
    // The same name is now another program, which must not be started.
    std::fs::remove_file(&compiler).unwrap();
    std::fs::rename(&failing, &compiler).unwrap();
    let log_of_second = folder.path().join("cc-by-turns.log");
    let second = Toolchain::with_compiler(&compiler)
        .build(&manipulator(), &build, false)
        .unwrap();
    assert!(!second.compiled);
    assert_eq!(first.path, second.path);
    assert!(
        !log.exists() && !log_of_second.exists(),
        "no compiler was started"
    );
    Library::open(&second.path).unwrap();
    // It is rebuilt on request, or when something changed.
    let rebuilt = Toolchain::with_compiler(&compiler).build(&manipulator(), &build, true);
    assert!(
        matches!(rebuilt, Err(Error::CompilerFailed { .. })),
        "{rebuilt:?}"
    );
    assert!(log_of_second.exists());
    let (machine, controllers) = fixtures::jammed();
    let other = Package::emit(&machine, &controllers);
    let other = Toolchain::with_compiler(&compiler).build(&other, &build, false);
    let error = other.unwrap_err().to_diagnostic();
    assert_eq!(error.code, codes::COMPILER_FAILED);
    assert!(
        error.message.contains("no compiling today"),
        "{}",
        error.message
    );
    // The existing library is still intact.
    Library::open(&second.path).unwrap();
    let left: Vec<_> = std::fs::read_dir(&build)
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(
        left.len(),
        2,
        "a library and its manifest, and nothing else: {left:?}"
    );
}

#[test]
fn several_libraries_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let packages: Vec<Package> = [
        fixtures::manipulator(),
        fixtures::jammed(),
        fixtures::belt(),
    ]
    .iter()
    .map(|(m, c)| Package::emit(m, c))
    .collect();
    let toolchain = Toolchain::host();
    let built: Vec<_> = toolchain.build_all(&packages, folder.path(), false);
    for (built, package) in built.iter().zip(&packages) {
        let built = built.as_ref().unwrap();
        let name = built
            .path
            .file_name()
            .unwrap()
            .to_string_lossy()
            .into_owned();
        assert!(name.starts_with(&format!("{}-", package.stem)), "{name}");
        let library = Library::open(&built.path).unwrap();
        assert_eq!(library.description()["machine"], package.name.as_str());
        assert_eq!(
            library.description()["contract_hash"],
            package.contract_hash.as_str()
        );
        assert_eq!(library.description()["profile"]["verified"], false);
    }
    assert!(
        toolchain
            .build_all(&packages, folder.path(), false)
            .iter()
            .all(|b| !b.as_ref().unwrap().compiled)
    );
}

/// As when several processes run the same line for the first time.
#[test]
fn the_same_library_built_at_the_same_time() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, controllers) = fixtures::belt();
    let package = Package::emit(&machine, &controllers);
    for _ in 0..3 {
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let built = Toolchain::host().build(&package, folder.path(), true);
                    let library = Library::open(&built.unwrap().path).unwrap();
                    library
                        .instance()
                        .unwrap()
                        .step(&[0, 0], &mut [0; 4])
                        .unwrap();
                });
            }
        });
    }
}

#[test]
fn damaged_libraries_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, controllers) = fixtures::belt();
    let package = Package::emit(&machine, &controllers);
    let build = || {
        Toolchain::host()
            .build(&package, folder.path(), false)
            .unwrap()
            .path
    };
    let path = build();
    let whole = std::fs::read(&path).unwrap();
    let manifest = path.with_extension("json");
    let manifest_text = std::fs::read(&manifest).unwrap();
    let refused = |what: &str| {
        let error = Library::open(&build()).expect_err(what).to_diagnostic();
        assert_eq!(error.code, codes::LIBRARY_DAMAGED, "{what}");
        assert!(error.help.unwrap().contains("--rebuild"));
        error.message
    };
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(refused("truncated").contains("bytes instead of"));
    let mut altered = whole.clone();
    altered[whole.len() / 2] ^= 1;
    std::fs::write(&path, &altered).unwrap();
    refused("altered");
    std::fs::write(&path, &whole).unwrap();
    std::fs::write(&manifest, &manifest_text[..20]).unwrap();
    refused("manifest truncated");
    // Without a manifest nothing is known: it is rebuilt.
    std::fs::remove_file(&manifest).unwrap();
    assert!(
        Toolchain::host()
            .build(&package, folder.path(), false)
            .unwrap()
            .compiled
    );
    Library::open(&path).unwrap();
    std::fs::write(&path, b"nonsense").unwrap();
    assert!(
        Toolchain::host()
            .build(&package, folder.path(), true)
            .unwrap()
            .compiled
    );
    Library::open(&path).unwrap();
}

#[test]
fn a_missing_compiler_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Toolchain::with_compiler("no-such-compiler-anywhere");
    let error = missing
        .build(&manipulator(), folder.path(), false)
        .unwrap_err();
    assert!(matches!(error, Error::CompilerMissing { .. }), "{error:?}");
    let finding = error.to_diagnostic();
    assert_eq!(finding.code, codes::COMPILER_MISSING);
    assert!(
        finding.message.contains("no-such-compiler-anywhere"),
        "{}",
        finding.message
    );
    assert!(finding.help.unwrap().contains("CC"));
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is left behind"
    );
}

#[test]
fn an_unwritable_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    for place in [file.join("below"), file] {
        let error = Toolchain::host()
            .build(&manipulator(), &place, false)
            .unwrap_err();
        assert!(matches!(error, Error::Unwritable { .. }), "{error:?}");
        assert_eq!(error.to_diagnostic().code, codes::OUTPUT_UNWRITABLE);
        assert!(manipulator().write_source(&place).is_err());
    }
}

/// A handle saved with a model must not match an instance of the next process.
#[test]
fn processes_begin_with_handles_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let package = manipulator();
    package.write_source(folder.path()).unwrap();
    let main = format!(
        "#include \"{}.c\"\n#include <stdio.h>\nint main(void)\n{{\n    printf(\"%d\", (int)lw_create());\n    return 0;\n}}\n",
        package.stem
    );
    std::fs::write(folder.path().join("first_handle.c"), main).unwrap();
    let output = Command::new("cc")
        .args([
            "-std=gnu99",
            "first_handle.c",
            "-o",
            "first_handle",
            "-pthread",
            "-lm",
        ])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let first = || {
        let output = Command::new(folder.path().join("first_handle")).output();
        let handle = String::from_utf8(output.unwrap().stdout).unwrap();
        handle.parse::<i32>().unwrap()
    };
    // Including processes that start in the same second.
    let handles: BTreeSet<i32> = (0..6).map(|_| first()).collect();
    assert!(handles.iter().all(|h| *h > 0));
    assert_eq!(handles.len(), 6, "{handles:?}");
}

#[test]
fn a_plain_c_host_runs_an_operation() {
    let folder = tempfile::tempdir().unwrap();
    let built = Toolchain::host()
        .build(&manipulator(), folder.path(), false)
        .unwrap();
    let ffi = Path::new(env!("CARGO_MANIFEST_DIR")).join("ffi");
    let host = folder.path().join("host");
    let output = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror"])
        .arg(ffi.join("host.c"))
        .arg("-o")
        .arg(&host)
        .arg("-ldl")
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let run = |arguments: &[&str]| {
        let output = Command::new(&host)
            .arg(&built.path)
            .args(arguments)
            .output()
            .unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        (
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr),
        )
    };
    let (code, out, _) = run(&["0", "180", "1", "0.25"]);
    assert_eq!(code, Some(0));
    assert!(out.trim_end().ends_with("HOST PASSED"), "{out}");
    // The same from Rust.
    let mut instance = Library::open(&built.path).unwrap().instance().unwrap();
    let mut values = [180.0, 1.0, 0.25];
    let service = instance.simulate(0, &mut values).unwrap();
    let line = format!(
        "{:.3} s, {:.3} J, {} steps",
        service.seconds, service.joules, service.steps
    );
    assert!(out.contains(&line), "{out} / {line}");
    let (code, _, err) = run(&["0", "45", "1", "0.25"]);
    assert_eq!(code, Some(1));
    assert!(
        err.contains("code -3: property `angle`: plant input `cell` would be 0.5"),
        "{err}"
    );
}
