//! `fmt`: which files are written or left, and the exit codes.

use super::session::Session;
use std::io::Write as _;
use std::process::Stdio;

const ROUGH: &str = "contract A{input a:bool // one\n}";
const SMOOTH: &str = "contract A {\n    input a: bool // one\n}\n";

fn read(session: &Session, name: &str) -> String {
    std::fs::read_to_string(session.path(name)).expect("a text")
}

/// A folder with an unformatted file below it and a formatted one.
fn session() -> Session {
    let session = Session::new();
    std::fs::create_dir_all(session.path("plant/deep")).expect("a folder");
    std::fs::write(session.path("plant/deep/rough.lw"), ROUGH).expect("a file");
    std::fs::write(session.path("plant/smooth.lw"), SMOOTH).expect("a file");
    std::fs::write(session.path("plant/other.txt"), ROUGH).expect("a file");
    session
}

#[test]
fn check_writes_nothing_and_says_what_would_change() {
    let session = session();
    let printed = session.run("fmt --check plant");
    assert_eq!(printed.code, 1);
    assert_eq!(
        printed.out,
        "plant/deep/rough.lw is not formatted\n    1 - contract A{input a:bool // one\n    1 + contract A {\n    2 +     input a: bool // one\n"
    );
    assert_eq!(read(&session, "plant/deep/rough.lw"), ROUGH);
    assert_eq!(session.run("fmt --check plant/smooth.lw").code, 0);
}

#[test]
fn only_what_changes_is_written() {
    let session = session();
    let before = std::fs::metadata(session.path("plant/smooth.lw")).and_then(|m| m.modified());
    let printed = session.run("fmt plant plant/deep/rough.lw");
    assert_eq!(
        (printed.code, printed.out.as_str()),
        (0, "formatted plant/deep/rough.lw\n")
    );
    assert_eq!(read(&session, "plant/deep/rough.lw"), SMOOTH);
    assert_eq!(read(&session, "plant/other.txt"), ROUGH);
    let after = std::fs::metadata(session.path("plant/smooth.lw")).and_then(|m| m.modified());
    assert_eq!(before.expect("a time"), after.expect("a time"));
    let again = session.run("fmt plant");
    assert_eq!((again.code, again.out.as_str()), (0, ""));
    assert_eq!(session.run("fmt --check plant").code, 0);
}

#[test]
fn what_does_not_parse_is_left_as_it_is() {
    let session = session();
    let before = read(&session, "syntax.lw");
    for line in ["fmt syntax.lw plant", "fmt --check syntax.lw plant"] {
        let printed = session.run(line);
        assert_eq!(printed.code, 2, "{line}");
        assert!(printed.err.contains("LW002"), "{}", printed.err);
    }
    assert_eq!(read(&session, "syntax.lw"), before);
    // The other files are formatted nevertheless.
    assert_eq!(read(&session, "plant/deep/rough.lw"), SMOOTH);
    let missing = session.run("fmt missing.lw");
    assert_eq!(missing.code, 2);
    assert!(missing.err.contains("LW001"), "{}", missing.err);
}

#[test]
fn a_time_limit_leaves_the_files_that_come_after_it() {
    let session = session();
    let printed = session.run("fmt plant --timeout 0");
    assert_eq!(printed.code, 3, "{}", printed.err);
    let wanted =
        "plant/deep/rough.lw and the files after it were not formatted: the time limit was reached";
    assert!(printed.err.contains(wanted), "{}", printed.err);
    assert_eq!(read(&session, "plant/deep/rough.lw"), ROUGH);
}

#[test]
fn standard_input_goes_to_standard_output() {
    let session = session();
    for (line, text, code, wanted) in [
        ("fmt -", ROUGH, 0, SMOOTH),
        ("fmt - --check", SMOOTH, 0, ""),
        ("fmt -", "contract {", 2, ""),
    ] {
        let mut child = session
            .command(line)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let mut input = child.stdin.take().expect("a pipe");
        input.write_all(text.as_bytes()).expect("it reads");
        drop(input);
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(code), "{line}");
        assert_eq!(String::from_utf8_lossy(&output.stdout), wanted, "{line}");
    }
    assert_eq!(session.run("fmt - plant").code, 2);
}

#[test]
fn in_json_every_file_has_an_entry() {
    let session = session();
    let printed = session.run("fmt --check plant --format json");
    assert_eq!(printed.code, 1);
    let document: serde_json::Value = serde_json::from_str(&printed.out).expect("JSON");
    assert_eq!(document["schema"], "linewright/fmt/1");
    assert_eq!(document["files"][0]["file"], "plant/deep/rough.lw");
    assert_eq!(document["files"][0]["changed"], true);
    assert_eq!(document["files"][1]["changed"], false);
}
