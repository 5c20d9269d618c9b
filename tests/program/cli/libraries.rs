//! Missing compilers, unwritable folders, damaged libraries.

use super::session::{Session, assert_shown};
use crate::support::sandbox;

#[test]
fn no_compiler_on_the_path() {
    let session = Session::new();
    let printed = session.run_with("run lamp.lw", &[("PATH", "nowhere")]);
    assert_eq!(printed.code, 2);
    assert_shown!("compiler_missing", printed);
    let named = session.run_with("build lamp.lw", &[("CC", "no-such-compiler")]);
    assert_eq!(named.code, 2);
    assert_shown!("compiler_named", named);
    // The sources need none.
    let sources = "build lamp.lw --target source --out sources";
    assert_eq!(session.run_with(sources, &[("PATH", "nowhere")]).code, 0);
    assert!(session.path("sources/lamp.c").is_file());
}

/// Without a compiler for Windows, the message names the two ways to get one; no other compiler is
/// used.
#[test]
fn no_compiler_for_windows() {
    let session = Session::new();
    let windows = session.run_with("build lamp.lw --target windows", &[("PATH", "nowhere")]);
    assert_eq!(windows.code, 2);
    assert_shown!("windows_missing", windows);
    // The compilers of this computer are not suitable.
    if cfg!(not(windows)) {
        let msvc = session.run("build lamp.lw --target msvc");
        assert_eq!(msvc.code, 2);
        assert_shown!("msvc_missing", msvc);
    }
    assert!(!session.path(".linewright").exists(), "nothing was built");
    // A named compiler that does not exist is not silently ignored.
    let named = [
        ("PATH", "nowhere"),
        ("CC_x86_64_pc_windows_gnu", "no-such-compiler"),
    ];
    assert_eq!(
        session
            .run_with("build lamp.lw --target windows", &named)
            .code,
        2
    );
}

#[test]
fn a_compiler_that_fails() {
    let session = Session::new();
    let path = session.failing_compiler();
    let mut printed = session.run_with("build lamp.lw", &[("PATH", &path)]);
    assert_eq!(printed.code, 2);
    assert!(session.compiler_was_started());
    printed = session.run_with("build lamp.lw", &[("PATH", &path), ("CC", "cc")]);
    assert!(printed.err.starts_with("error[LW502]"), "{}", printed.err);
    assert!(
        printed.err.contains("no compiling today"),
        "{}",
        printed.err
    );
    assert!(printed.err.contains("= help: "), "{}", printed.err);
}

/// A file in place of a folder: this also applies to root, who may write everywhere.
#[test]
fn folders_that_cannot_be_written() {
    let session = Session::new();
    std::fs::write(session.path("taken"), "mine").expect("a file");
    for (name, line) in [
        ("unwritable_run", "run lamp.lw --out taken"),
        ("unwritable_below", "build lamp.lw --out taken/below"),
        (
            "unwritable_sources",
            "build lamp.lw --target source --out taken",
        ),
        ("unwritable_synth", "synth lamp.lw::Light --out taken"),
    ] {
        let printed = session.run(line);
        assert_eq!(printed.code, 2, "{line}");
        assert_shown!(name, printed);
    }
    assert_eq!(
        std::fs::read(session.path("taken")).expect("a file"),
        b"mine"
    );
    // And the usual place.
    std::fs::write(session.path(".linewright"), "mine too").expect("a file");
    let printed = session.run("run lamp.lw");
    assert_eq!(printed.code, 2);
    assert_shown!("unwritable_default", printed);
}

/// A place without write permission; root may write, and then there is nothing to test.
#[test]
#[cfg(unix)]
fn a_folder_without_permission() {
    use std::os::unix::fs::PermissionsExt;
    let session = Session::new();
    let folder = session.path("closed");
    std::fs::create_dir(&folder).expect("a folder");
    let permit = |mode| std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(mode));
    permit(0o555).expect("permissions");
    let writable = std::fs::write(folder.join("probe"), "").is_ok();
    let printed = session.run("run lamp.lw --out closed");
    permit(0o755).expect("permissions");
    if writable {
        return assert_eq!(printed.code, 0);
    }
    assert_eq!(printed.code, 2);
    assert!(printed.err.starts_with("error[LW504]"), "{}", printed.err);
}

#[test]
fn damaged_libraries() {
    let session = Session::new();
    assert_eq!(session.run("run lamp.lw").code, 0);
    let library = session.library(".linewright");
    let whole = std::fs::read(&library).expect("a library");
    let mut altered = whole.clone();
    let middle = altered.len() / 2;
    altered[middle] ^= 1;
    for (name, bytes) in [
        ("library_truncated", &whole[..1000]),
        ("library_altered", &altered),
        ("library_empty", &[]),
    ] {
        std::fs::write(&library, bytes).expect("a file");
        let printed = session.run("run lamp.lw");
        assert_eq!(printed.code, 2, "{name}");
        assert_shown!(name, printed);
        assert_eq!(
            std::fs::read(&library).expect("a file"),
            bytes,
            "left alone"
        );
    }
    // Both remedies in the message work.
    assert_eq!(session.run("run lamp.lw --rebuild").code, 0);
    assert_eq!(session.run("run lamp.lw").code, 0);
    std::fs::write(&library, b"").expect("a file");
    std::fs::remove_file(&library).expect("it is there");
    assert_eq!(session.run("run lamp.lw").code, 0);
    assert_eq!(session.library(".linewright"), library);
    let manifest = library.with_extension("json");
    std::fs::write(&manifest, "{").expect("a file");
    let printed = session.run("run lamp.lw");
    assert_eq!(printed.code, 2);
    assert_shown!("manifest_damaged", printed);
}

/// The whole line: a second run starts no compiler, but a run after a contract was changed does.
#[test]
fn what_is_built_is_not_built_again() {
    let session = Session::new();
    let folder = sandbox();
    let at = folder.path().display();
    let line = format!(
        "run {at}/examples/ice-lab/line.lw --parts 50 --library {at}/contracts --no-timing"
    );
    // The solver's time is not under test here.
    let cache = session.path("cache").display().to_string();
    let cached = ("LINEWRIGHT_CACHE", cache.as_str());
    let first = session.run_with(&line, &[cached]);
    assert_eq!(first.code, 0, "{}", first.err);
    let path = session.failing_compiler();
    let again = || session.run_with(&line, &[cached, ("PATH", &path)]);
    let second = again();
    assert_eq!((second.code, second.err.as_str()), (0, ""));
    assert_eq!(first.out, second.out);
    assert!(!session.compiler_was_started());

    let contract = folder.path().join("contracts/handling/inspect.lw");
    let text = std::fs::read_to_string(&contract).expect("a contract");
    // A comment does not change the machine's behavior.
    std::fs::write(&contract, format!("{text}\n// a remark\n")).expect("a file");
    assert_eq!(again().code, 0);
    assert!(!session.compiler_was_started());

    let guarantee = "    guarantee start:";
    let more = format!("    guarantee cells_only: always (position <= cells)\n{guarantee}");
    assert!(text.contains(guarantee));
    std::fs::write(&contract, text.replace(guarantee, &more)).expect("a file");
    let changed = again();
    assert_eq!(changed.code, 2, "{}", changed.out);
    assert!(session.compiler_was_started());
    let code = changed.err.starts_with("error[LW502]") || changed.err.starts_with("error[LW501]");
    assert!(code && changed.err.contains("= help: "), "{}", changed.err);
    // With a working compiler, everything is fine again.
    assert_eq!(session.run_with(&line, &[cached]).code, 0);
}

/// For a file with machines and a line: builds what the line needs, as `run` would, and what no
/// line uses, with its default sizes.
#[test]
fn a_file_with_machines_and_a_line_builds_what_the_line_needs() {
    let session = Session::new();
    let text = std::fs::read_to_string(session.path("lamp.lw")).expect("a text");
    let line = text.find("line Lamps").expect("a line");
    let machine = text[..line].replace("machine Lamp {", "machine Lamp(steps: 1..3 = 1) {");
    let machine = machine.replace("time 1 s", "time steps * 1 s");
    let idle = machine[machine.find("machine Lamp").expect("a machine")..]
        .replace("machine Lamp", "machine Idle");
    let mixed = format!(
        "{machine}{idle}line Lamps {{\n part Bulb\n product Bulb\n source shelf: Bulb on order\n sink out\n\
         station one: Lamp(steps = 2) {{ perform shine on Bulb }}\n\
         station two: Lamp(steps = 3) {{ perform shine on Bulb }}\n\
         route Bulb: shelf -> one -> two -> out\n limit 5 products\n}}\n"
    );
    std::fs::write(session.path("mixed.lw"), mixed).expect("a file");
    let built = session.run("build mixed.lw --target source --out c --format json");
    assert_eq!(built.code, 0, "{}{}", built.out, built.err);
    let document: serde_json::Value = serde_json::from_str(&built.out).expect("a document");
    let names: Vec<&str> = document["libraries"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|l| l["machine"].as_str().expect("a name"))
        .collect();
    assert_eq!(names, ["Lamp", "Lamp_2", "Idle"]);
    let finding = &document["findings"][0];
    assert_eq!(finding["code"], "LW547", "{finding}");
    assert!(
        finding["help"]
            .as_str()
            .expect("a help")
            .contains("mixed.lw::Lamp")
    );
    // Selected by name, it has its own sizes.
    let alone = session.run("build mixed.lw::Lamp --target source --out d --format json");
    let document: serde_json::Value = serde_json::from_str(&alone.out).expect("a document");
    assert_eq!(document["libraries"].as_array().map(Vec::len), Some(1));
    assert_eq!(document["findings"].as_array().map(Vec::len), Some(0));
}
