//! The command line from outside: exit codes, streams, and the fields that other programs rely on.

use crate::support;
use serde_json::Value;
use std::io::Read as _;
use std::path::Path;
use std::process::{Command, Stdio};

const GOOD: &str = "contract Good { input a: bool output b: bool guarantee g: always (b <-> a) }\n";
const UNREALIZABLE: &str = "contract Lost { input a: bool output b: bool guarantee x: always not b guarantee y: always (a -> b) }\n";
const TYPES: &str =
    "contract Types { input a: bool output b: 0..3 guarantee g: always (a -> b) }\n";
const SYNTAX: &str = "contract Broken { input a: bool output b: bool guarantee g: always (a -> }\n";
const WARNING: &str = "contract Over { input a: bool output n: 0..9\n\
    assume low: always (n >= 8 -> not next a)\n\
    guarantee start: n = 0\n\
    guarantee counts: always (a -> next n = n + 1)\n\
    guarantee keeps: always (not a -> next n = n) }\n";
const MACHINE: &str = "machine Table { signal a: bool = true action act: Good }\n";

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

/// The exit code, standard output and standard error of a command.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = support::linewright(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let code = output.status.code().expect("no signal ended it");
    (code, text(&output.stdout), text(&output.stderr))
}

#[test]
fn check_has_the_promised_exit_codes_and_verdicts() {
    for (text, code, verdict) in [
        (GOOD, 0, "realizable"),
        (UNREALIZABLE, 1, "unrealizable"),
        (TYPES, 1, "invalid"),
        (SYNTAX, 2, "invalid"),
        ("contrct X {}", 2, "invalid"),
    ] {
        let folder = folder(&[("a.lw", text)]);
        let (got, out, _) = run(folder.path(), &["check", "a.lw", "--format", "json"]);
        let document: Value = serde_json::from_str(&out).expect("a document");
        assert_eq!(got, code, "{text}");
        assert_eq!(document["schema"], "linewright/check/1");
        assert_eq!(document["contracts"][0]["verdict"], verdict, "{text}");
        assert_eq!(document["contracts"][0]["file"], "a.lw");
        assert_eq!(document["summary"][verdict], 1, "{text}");
    }
}

/// With `--verdict-only`, there is neither a reason nor a finding about weak formulas.
#[test]
fn a_verdict_can_be_all_that_is_given() {
    let idle =
        "contract Idle { input a: bool output b: bool guarantee g: always eventually not b }";
    let folder = folder(&[("lost.lw", UNREALIZABLE), ("idle.lw", idle)]);
    let files = ["check", "lost.lw", "idle.lw", "--format", "json"];
    let (code, out, _) = run(folder.path(), &files);
    let whole: Value = serde_json::from_str(&out).expect("a document");
    assert_eq!(code, 1);
    assert_eq!(
        whole["contracts"][0]["core"].as_array().map(Vec::len),
        Some(2)
    );
    assert!(out.contains("LW219"), "{out}");

    let (code, out, _) = run(folder.path(), &[&files[..], &["--verdict-only"]].concat());
    let quick: Value = serde_json::from_str(&out).expect("a document");
    assert_eq!(code, 1);
    for contract in [0, 1] {
        let verdict = |document: &Value| document["contracts"][contract]["verdict"].clone();
        assert_eq!(verdict(&quick), verdict(&whole));
    }
    assert_eq!(
        quick["contracts"][0]["core"].as_array().map(Vec::len),
        Some(0)
    );
    assert!(out.contains("LW203"), "{out}");
    assert!(!out.contains("play") && !out.contains("LW219"), "{out}");
}

/// Formulas that demand less than they seem to are also found in other tools' files; suggestions
/// are in the notation of the file.
#[test]
fn weak_formulas_of_other_tools_are_found() {
    let spectra = "spec Feeder
        env boolean part;
        env boolean request;
        sys boolean gate;
        sys {HERE, THERE} place;
        asm alwEv part;
        asm keeps: alw request & !gate -> next(request);
        gar only_parts: alw gate -> part;
        gar moves: alw part -> next(place) = THERE;
        gar idle: alw (part & !part) -> gate;
        gar begins: place = HERE;
    ";
    let folder = folder(&[("feeder.spectra", spectra)]);
    let (code, out, _) = run(folder.path(), &["check", "feeder.spectra"]);
    assert_eq!(code, 0, "{out}");
    for text in [
        "warning[LW212]: the machine cannot break `idle`",
        "add `gar completes: GF (!request | gate);`",
        "warning[LW216]: in some situations nothing restricts the next value of `place`",
        "let it keep its value: `gar frame: G (!part -> next(place) = place);`",
    ] {
        assert!(out.contains(text), "{text}\n{out}");
    }
    let (_, out, _) = run(folder.path(), &["import", "feeder.spectra"]);
    std::fs::write(folder.path().join("feeder.lw"), out).expect("a file");
    let (_, out, _) = run(folder.path(), &["check", "feeder.lw"]);
    let text = "let it keep its value: `guarantee frame: always (not part -> next place = place)`";
    assert!(out.contains(text), "{out}");
}

#[test]
fn the_first_of_2_3_1_wins_over_several_files() {
    let folder = folder(&[("1.lw", UNREALIZABLE), ("2.lw", SYNTAX), ("3.lw", GOOD)]);
    let check = |arguments: &[&str]| run(folder.path(), &[&["check"], arguments].concat()).0;
    assert_eq!(check(&["."]), 2);
    assert_eq!(check(&["1.lw", "3.lw"]), 1);
    assert_eq!(check(&["3.lw", "missing.lw"]), 2);
    assert_eq!(check(&["3.lw", "--timeout", "0"]), 3);
    assert_eq!(check(&["2.lw", "3.lw", "--timeout", "0"]), 2);
}

#[test]
fn warnings_are_errors_on_demand() {
    let folder = folder(&[("a.lw", WARNING)]);
    let (code, out, _) = run(folder.path(), &["check", "a.lw", "--format", "short"]);
    assert!(out.contains("warning[LW208]"), "{out}");
    assert_eq!(code, 0);
    assert_eq!(
        run(folder.path(), &["check", "a.lw", "--deny", "warnings"]).0,
        1
    );
}

#[test]
fn what_cannot_run_says_so_on_standard_error() {
    let both = format!("{GOOD}{MACHINE}");
    let folder = folder(&[("a.lw", &both), ("taken", "a file, no folder")]);
    for (arguments, words) in [
        (&["frob"][..], "unrecognized"),
        (&["synth", "a.lw::Nobody"], "has no contract `Nobody`"),
        (&["build", "a.lw::Nobody"], "has no machine `Nobody`"),
        (&["run", "a.lw"], "declares no line"),
        (&["synth", "a.lw", "--out", "taken/x"], "LW504"),
        (&["synth", "missing.lw"], "LW001"),
        (&["explain", "LW999"], "LW999"),
        (&["din", "show", "vdi:Dreehn"], "vdi:Drehen"),
        (&["run", "a.lw", "--until", "soon"], "90m"),
        (&["check", "a.lw", "--timeout", "-1"], "a number of seconds"),
    ] {
        let (code, out, err) = run(folder.path(), arguments);
        assert_eq!(code, 2, "{arguments:?}: {err}");
        assert_eq!(out, "", "{arguments:?}");
        assert!(err.contains(words), "{arguments:?}: {err}");
        assert!(!err.contains("panicked"), "{arguments:?}: {err}");
    }
}

#[test]
fn a_missing_compiler_is_a_finding() {
    let both = format!("{GOOD}{MACHINE}");
    let folder = folder(&[("a.lw", &both)]);
    let output = Command::new(support::PROGRAM)
        .args(["build", "a.lw", "--format", "short"])
        .current_dir(folder.path())
        .env("CC", "/no/such/compiler")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("error[LW501]"));
}

#[test]
fn without_timing_the_same_input_gives_the_same_bytes() {
    let folder = folder(&[("a.lw", GOOD), ("b.lw", UNREALIZABLE), ("c.lw", WARNING)]);
    let document = || {
        run(
            folder.path(),
            &["check", ".", "--format", "json", "--no-timing"],
        )
        .1
    };
    let first = document();
    assert!(!first.contains("seconds") && !first.contains("peak_nodes"));
    for _ in 0..5 {
        assert_eq!(document(), first);
    }
}

#[test]
fn sarif_and_json_are_whole_documents_even_in_failure() {
    let folder = folder(&[("a.lw", SYNTAX)]);
    for command in [
        &["check", "a.lw"][..],
        &["synth", "a.lw"],
        &["build", "a.lw"],
        &["run", "a.lw"],
    ] {
        for format in ["json", "sarif"] {
            let (code, out, _) = run(folder.path(), &[command, &["--format", format]].concat());
            assert_eq!(code, 2, "{command:?}");
            let document: Value = serde_json::from_str(&out).expect("a document");
            let text = document.to_string();
            assert!(text.contains("LW002"), "{command:?} {format}: {text}");
        }
    }
}

/// The reader closes the pipe after the first byte; much more output would follow.
#[test]
fn a_closed_pipe_ends_quietly() {
    let mut child = Command::new(support::PROGRAM)
        .args(["din", "tree", "--format", "json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stdout = child.stdout.take().expect("a pipe");
    stdout.read_exact(&mut [0]).expect("a byte");
    drop(stdout);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn files_are_found_in_folders_and_in_the_library() {
    let folder = folder(&[
        ("b.lw", GOOD),
        ("a.lw", UNREALIZABLE),
        ("c.txt", "no contract"),
    ]);
    let (_, out, _) = run(folder.path(), &["check", ".", "--format", "short"]);
    let verdicts: Vec<&str> = out.lines().filter(|l| l.contains(": contract ")).collect();
    assert_eq!(
        verdicts,
        [
            "a.lw: contract Lost: unrealizable",
            "b.lw: contract Good: realizable"
        ]
    );
    std::fs::write(folder.path().join("d.lw"), "import std.own\n").expect("a file");
    std::fs::create_dir(folder.path().join("lib")).expect("a folder");
    std::fs::write(folder.path().join("lib/own.lw"), GOOD).expect("a file");
    let (code, out, _) = run(
        folder.path(),
        &["check", "d.lw", "--library", "lib", "--format", "short"],
    );
    assert_eq!(
        (code, out.as_str()),
        (0, "std/own.lw: contract Good: realizable\n")
    );
}
