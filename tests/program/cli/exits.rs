//! Exit codes over several files, limits, formats, and readers that go away.

use super::session::{Session, assert_shown};
use serde_json::Value;
use std::process::Stdio;

#[test]
fn the_first_of_2_3_1_wins() {
    let session = Session::new();
    for (line, code) in [
        ("check lamp.lw", 0),
        ("check lamp.lw unrealizable.lw", 1),
        ("check type.lw unrealizable.lw", 1),
        ("check unrealizable.lw syntax.lw", 2),
        ("check syntax.lw unrealizable.lw type.lw lamp.lw", 2),
        ("check lamp.lw missing.lw", 2),
        ("check lamp.lw --timeout 0.000001", 3),
        ("check type.lw lamp.lw --timeout 0.000001", 3),
        ("check type.lw syntax.lw lamp.lw --timeout 0.000001", 2),
    ] {
        let printed = session.run(line);
        assert_eq!(printed.code, code, "{line}\n{}", printed.out);
    }
    // All findings are printed, whichever determines the exit code.
    let printed = session.run("check unrealizable.lw syntax.lw type.lw missing.lw --no-timing");
    for code in ["LW203", "LW002", "LW103", "LW001"] {
        assert!(printed.out.contains(code), "{code}: {}", printed.out);
    }
}

#[test]
fn a_time_limit() {
    let session = Session::new();
    for (name, line) in [
        (
            "timeout_check",
            "check lamp.lw --timeout 0.000001 --no-timing",
        ),
        ("timeout_synth", "synth lamp.lw --timeout 0.000001"),
        ("timeout_run", "run lamp.lw --timeout 0.000001"),
    ] {
        let printed = session.run(line);
        assert_eq!(printed.code, 3, "{line}");
        assert_shown!(name, printed);
    }
    assert_eq!(session.run("check lamp.lw --timeout 60").code, 0);
}

#[test]
fn warnings_count_where_they_are_denied() {
    let session = Session::new();
    let warned = session.run("check warning.lw --no-timing");
    assert_shown!("warning", warned);
    let denied = session.run("check warning.lw --no-timing --deny warnings");
    assert_eq!(warned.out, denied.out);
    assert_eq!((warned.code, denied.code), (0, 1));
}

#[test]
fn formats() {
    let session = Session::new();
    let files = "lamp.lw unrealizable.lw type.lw";
    for format in ["short", "json", "sarif"] {
        let printed = session.run(&format!("check {files} --no-timing --format {format}"));
        assert_eq!(printed.code, 1);
        assert_eq!(printed.err, "", "results go to standard output");
        if format != "short" {
            let _: Value = serde_json::from_str(&printed.out).expect("a document");
        }
        assert_shown!(format!("format_{format}"), printed);
    }
}

/// If the reader has closed the pipe, the program ends silently; the exit code remains the
/// verdict's.
#[test]
fn a_closed_pipe_is_quiet() {
    let session = Session::new();
    for (line, code) in [
        ("din tree", 0),
        ("check lamp.lw", 0),
        ("check unrealizable.lw --format json", 1),
        ("explain LW203", 0),
        ("completions bash", 0),
        ("--help", 0),
        ("run lamp.lw", 0),
    ] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let child = session
            .command(line)
            .stdout(Stdio::from(writer))
            .stderr(Stdio::piped())
            .spawn();
        let output = child.and_then(std::process::Child::wait_with_output);
        let output = output.expect("the program starts");
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{line}: {words}");
        // Findings are not part of the result of `run`, and are still printed.
        assert_eq!(words, "", "{line}");
    }
}
