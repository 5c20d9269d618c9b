//! The same on Windows, under Wine: the probe's guarded reading, the dump beside the DLL, and
//! libraries with the inferred profiles.

use super::mocks::{Mock, here, mocks};
use super::probing::{as_c, doctor};
use super::suite::package;
use crate::support;
use crate::support::wine::{Wine, windows_path, wine};
use linewright::station::Toolchain;
use linewright::station::toolchain::{Compiler, CrossCompiler};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_mins(2);

/// A Windows program with a mock's layout.
fn host(mock: &Mock, compiler: &Compiler, source: &str, folder: &Path) -> PathBuf {
    let program = folder.join(format!(
        "{}-{}.exe",
        source.trim_end_matches(".c"),
        mock.name
    ));
    let output = compiler
        .command()
        .args(["-std=gnu11", "-O1", "-Wno-unused-function"])
        .args(mock.options())
        .arg("-I")
        .arg(folder)
        .arg("-I")
        .arg(here())
        .arg(here().join(source))
        .arg("-o")
        .arg(&program)
        .output()
        .expect("a C compiler");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {said}", mock.name);
    program
}

/// Runs a host on a library.
fn run(wine: &Wine, host: &Path, library: &Path) -> (bool, String) {
    let finished = wine.run(host, &[windows_path(library)], PATIENCE);
    let text = finished.output.replace('\r', "");
    (text.trim_end().ends_with("HOST PASSED"), text)
}

/// Builds the probe for Windows and runs it in a mock; returns the mock's output, and the dump.
fn probe(
    mock: &Mock,
    compiler: &Compiler,
    wine: &Wine,
    folder: &Path,
    profile: Option<&str>,
) -> (String, PathBuf) {
    let out = format!("{}-{}", mock.name, profile.map_or("first", |_| "second"));
    let mut arguments = vec!["build", "--probe", "--target", "windows", "--out", &out];
    arguments.extend(profile.iter().flat_map(|p| ["--profile", p]));
    let output = support::linewright(folder, &arguments);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let printed = String::from_utf8(output.stdout).expect("paths");
    let find = |ending: &str| {
        let line = printed
            .lines()
            .find(|l| l.ends_with(ending))
            .expect("a file");
        folder.join(line)
    };
    let text = std::fs::read_to_string(find(".simtalk.txt")).expect("a text");
    std::fs::write(folder.join("calls.inc"), as_c(&text)).expect("a file");
    let host = host(mock, compiler, "probe_host.c", folder);
    let library = find(".dll");
    let (passed, printed) = run(wine, &host, &library);
    assert!(passed, "{}: {printed}", mock.name);
    (
        printed,
        PathBuf::from(format!("{}.dump.txt", library.display())),
    )
}

#[test]
fn layouts_are_recovered_and_confirmed_on_windows() {
    let (_, compiler) = match Compiler::windows() {
        Ok(found) => found,
        Err(error) => return support::skip("mingw", &error.to_string()),
    };
    let wine = match wine() {
        Ok(wine) => wine,
        Err(why) => return support::skip("wine", &why),
    };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let chosen = ["assumed", "packed_1", "value_first", "wide"];
    for mock in mocks().iter().filter(|m| chosen.contains(&m.name)) {
        let (printed, dump) = probe(mock, &compiler, wine, folder, None);
        let out = format!("{}.toml", mock.name);
        let (said, profile) = doctor(folder, &dump, &out);
        assert_eq!(
            profile.layout,
            mock.layout(&printed),
            "{}: {said}",
            mock.name
        );
        let (_, dump) = probe(mock, &compiler, wine, folder, Some(&out));
        let (said, verified) = doctor(folder, &dump, &format!("{}-verified.toml", mock.name));
        assert!(verified.is_verified(), "{said}");
        let toolchain = Toolchain::windows().expect("a compiler");
        let built = toolchain
            .build(&package(&verified), folder, false)
            .expect("a library");
        let host = host(mock, &compiler, "suite_host.c", folder);
        let (passed, printed) = run(wine, &host, &built.path);
        assert!(passed, "{}: {printed}", mock.name);
    }
}

/// The command on the page of the sources makes, byte for byte, the library that `--target windows`
/// makes; its source is beside that, too.
#[test]
fn the_command_of_the_page_makes_the_same_library() {
    match Compiler::windows() {
        Ok((CrossCompiler::MinGw, _)) => {}
        Ok((other, _)) => return support::skip("mingw", &format!("{} is taken", other.name())),
        Err(error) => return support::skip("mingw", &error.to_string()),
    }
    let sandbox = support::sandbox();
    let build = |target: &str| {
        let file = "examples/ice-lab/printer.lw";
        let output = support::linewright(
            sandbox.path(),
            &["build", file, "--target", target, "--out", target],
        );
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        String::from_utf8(output.stdout).expect("paths")
    };
    let printed = build("windows");
    let [library, source, _, page] = printed.lines().collect::<Vec<_>>()[..] else {
        panic!("a library, its source, methods and a page: {printed}");
    };
    let read = |path: &str| std::fs::read(sandbox.path().join(path)).expect(path);
    assert!(String::from_utf8_lossy(&read(page)).contains(&source["windows/".len()..]));
    build("source");
    assert_eq!(read(source), read("source/printer.c"));
    let page = String::from_utf8(read("source/printer.import.md")).expect("a text");
    let commands: Vec<&str> = page
        .lines()
        .filter_map(|l| l.strip_prefix("    "))
        .collect();
    assert!(commands[1].starts_with("cl "), "{commands:?}");
    for folder in ["source", source.trim_end_matches("/printer.c")] {
        let mut words = commands[0].split_whitespace();
        let status = Command::new(words.next().expect("a compiler"))
            .args(words)
            .current_dir(sandbox.path().join(folder))
            .status();
        assert!(status.expect("a compiler").success(), "{folder}");
        assert_eq!(
            read(&format!("{folder}/printer.dll")),
            read(library),
            "{folder}"
        );
    }
}
