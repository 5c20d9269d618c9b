//! A station library with the inferred profile passes the host suite of its layout, and no other's.

use super::mocks::{Mock, here, mocks, run};
use super::probing::{build, find};
use crate::fixtures;
use crate::support;
use linewright::station::profile::Profile;
use linewright::station::{Package, Toolchain};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

/// The manipulator with names and a rule that some encodings cannot represent.
pub fn package(profile: &Profile) -> Package {
    let (machine, controllers) = fixtures::manipulator();
    let mut machine = (*machine).clone();
    "Länge".clone_into(&mut machine.properties[0].name);
    "prüfen".clone_into(&mut machine.operations[0].name);
    let turn = &mut machine.components[1];
    let specification = Arc::make_mut(&mut turn.specification);
    "größer als 12 € → gegriffen".clone_into(&mut specification.assumptions.invariants[0].text);
    Package::emit_with(&machine, &controllers, profile)
}

/// A library of the machine; `more` are options of the compiler.
fn library(profile: &Profile, folder: &Path, more: &[&str]) -> PathBuf {
    let mut flags = vec![
        "-std=gnu99",
        "-fPIC",
        "-shared",
        "-fvisibility=hidden",
        "-g",
    ];
    flags.extend(["-Wall", "-Wextra", "-Wconversion", "-Werror"]);
    flags.extend(more);
    let toolchain = Toolchain::host().with_flags(&flags);
    let built = toolchain.build(&package(profile), folder, true);
    built
        .unwrap_or_else(|e| panic!("{}: {e}", profile.name))
        .path
}

#[test]
fn a_profile_that_was_found_passes_the_suite_of_its_layout_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let first = build(folder, None);
    let mocks: Vec<Mock> = mocks();
    let found: Vec<_> = mocks.iter().map(|m| find(m, &first, folder)).collect();
    let hosts: Vec<PathBuf> = mocks
        .iter()
        .map(|m| m.host("suite_host.c", folder, &[]))
        .collect();
    for (i, (layout, profile, _)) in found.iter().enumerate() {
        let library = library(profile, folder, &["-O1"]);
        for (j, host) in hosts.iter().enumerate() {
            let (passed, printed) = run(host, &library, &[]);
            let own = *layout == found[j].0;
            let names = (mocks[i].name, mocks[j].name);
            assert_eq!(passed, own, "library and host {names:?}: {printed}");
        }
    }
}

/// The default profile under sanitizers, and each of the mocks.
#[test]
fn sanitizers_find_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let options = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let trial = folder.join("trial.c");
    std::fs::write(&trial, "int main(void) { return 0; }\n").expect("a file");
    let works = Command::new("cc")
        .args(options)
        .arg(&trial)
        .arg("-o")
        .arg(folder.join("trial"))
        .output()
        .is_ok_and(|o| o.status.success());
    if !works
        || !Command::new(folder.join("trial"))
            .status()
            .is_ok_and(|s| s.success())
    {
        support::skip(
            "asan",
            "the C compiler has no address sanitizer that runs here",
        );
        return;
    }
    let first = build(folder, None);
    for mock in mocks() {
        let (_, profile, _) = find(&mock, &first, folder);
        let library = library(&profile, folder, &options);
        let host = mock.host("suite_host.c", folder, &options);
        let (passed, printed) = run(&host, &library, &[]);
        assert!(passed, "{}: {printed}", mock.name);
    }
}

/// With `-DUF_USE_VENDOR_HEADER` the layout is that of the vendor's header, here the mock's.
#[test]
fn the_vendors_header_is_taken_where_it_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for mock in mocks() {
        let include = format!("-I{}", here().display());
        let mut options: Vec<String> = mock.options();
        let integer = options
            .iter()
            .find_map(|o| o.strip_prefix("-DMOCK_INTEGER="));
        let encoding = options
            .iter()
            .find_map(|o| o.strip_prefix("-DMOCK_ENCODING="));
        let own = [
            "-DUF_USE_VENDOR_HEADER".to_owned(),
            format!("-DLW_UF_INTEGER={}", integer.expect("a type")),
            format!("-DLW_UF_ENCODING={}", encoding.expect("a number")),
            include,
        ];
        if let Some(boolean) = options
            .iter()
            .find_map(|o| o.strip_prefix("-DMOCK_BOOLEAN="))
        {
            let boolean = format!("-DLW_UF_TAG_BOOLEAN={boolean}");
            options.push(boolean);
        }
        let time = options
            .iter()
            .find_map(|o| o.strip_prefix("-DMOCK_TIME=").map(str::to_owned));
        if let Some(time) = time {
            options.push(format!("-DLW_UF_MORE_REAL(tag)=((tag)=={time})"));
        }
        options.extend(own);
        // The library's own files include the header, which is foreign, and so are its warnings.
        options.extend(
            ["-Wno-conversion", "-Wno-sign-compare", "-Wno-type-limits"].map(str::to_owned),
        );
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        let library = library(&Profile::assumed(), &folder.join(mock.name), &options);
        let host = mock.host("suite_host.c", folder, &[]);
        let (passed, printed) = run(&host, &library, &[]);
        assert!(passed, "{}: {printed}", mock.name);
        // Its description says so, and names no profile.
        let bytes = std::fs::read(&library).expect("a library");
        let holds = |text: &str| bytes.windows(text.len()).any(|w| w == text.as_bytes());
        assert!(
            holds("vendor header") && !holds("\"name\":\"default\""),
            "{}",
            mock.name
        );
    }
}

/// The bundled runner passes the assumed layout; a library with another one is refused, never
/// misread.
#[test]
fn the_runner_refuses_other_layouts() {
    use linewright::diagnostics::codes;
    use linewright::station::load::Library;
    let folder = tempfile::tempdir().expect("a folder");
    let mut profile = Profile::assumed();
    "renamed".clone_into(&mut profile.name);
    // A name alone changes nothing.
    Library::open(&library(&profile, folder.path(), &[])).expect("the assumed layout");
    profile.layout.tag.string = 4;
    let error = Library::open(&library(&profile, folder.path(), &[])).expect_err("another layout");
    let finding = error.to_diagnostic();
    assert_eq!(finding.code, codes::PROFILE_FOREIGN);
    assert!(
        finding.message.contains("\"renamed\""),
        "{}",
        finding.message
    );
    assert!(finding.help.is_some());
}
