//! Missing or wrong files, unknown names, and lines that stand still.

use super::session::{Session, assert_shown};
use crate::support::root;

/// Runs every command, compares its output with its snapshot, and checks its exit code.
fn check(cases: &[(&str, &str, i32)]) {
    let session = Session::new();
    for (name, line, code) in cases {
        let printed = session.run(line);
        assert_eq!(printed.code, *code, "{line}\n{}", printed.err);
        assert_shown!(*name, printed);
    }
}

#[test]
fn missing_files() {
    check(&[
        ("missing_check", "check missing.lw --no-timing", 2),
        ("missing_run", "run missing.lw --parts 1", 2),
        (
            "missing_json",
            "check missing.lw --format json --no-timing",
            2,
        ),
        ("missing_synth", "synth missing.lw", 2),
        ("missing_build", "build missing.lw", 2),
    ]);
}

#[test]
fn what_is_no_text() {
    let session = Session::new();
    for (bytes, wanted) in [
        (&b"type\0"[..], "it is not a text file: byte 4 is zero"),
        (&b"type \xff"[..], "it is not a UTF-8 text file"),
    ] {
        std::fs::write(session.path("data.lw"), bytes).expect("a file");
        for line in ["check data.lw", "fmt --check data.lw"] {
            let printed = session.run(line);
            let shown = format!("{}{}", printed.out, printed.err);
            assert_eq!(printed.code, 2, "{line}: {shown}");
            assert!(shown.contains(wanted), "{line}: {shown}");
        }
    }
}

#[test]
fn what_does_not_parse() {
    check(&[
        ("syntax_check", "check syntax.lw --no-timing", 2),
        ("syntax_synth", "synth syntax.lw", 2),
    ]);
}

#[test]
fn what_does_not_fit() {
    check(&[
        ("type_check", "check type.lw --no-timing", 1),
        ("type_synth", "synth type.lw", 1),
        ("unbound_check", "check unbound.lw --no-timing", 1),
        ("unbound_build", "build unbound.lw", 1),
        ("unrealizable_check", "check unrealizable.lw --no-timing", 1),
        ("unrealizable_synth", "synth unrealizable.lw", 1),
    ]);
}

#[test]
fn names_that_are_not_there() {
    check(&[
        ("unknown_machine", "build lamp.lw::Ghost", 2),
        ("unknown_contract", "synth lamp.lw::Ghost", 2),
        ("unknown_line", "run lamp.lw::Ghost", 2),
        ("no_line", "run type.lw", 1),
        ("no_machine", "build unrealizable.lw", 2),
    ]);
}

#[test]
fn imports() {
    check(&[
        ("import_circular", "check circle_a.lw --no-timing", 1),
        ("import_missing", "check import_missing.lw --no-timing", 2),
        ("double", "check double.lw --no-timing", 1),
    ]);
}

#[test]
fn bad_arguments() {
    check(&[
        ("argument_parts", "run lamp.lw --parts none", 2),
        ("argument_until", "run lamp.lw --until tomorrow", 2),
        ("argument_timeout", "check lamp.lw --timeout soon", 2),
    ]);
}

#[test]
fn a_line_that_blocks_itself() {
    let session = Session::new();
    let printed = session.run("run blocked.lw");
    assert_eq!(printed.code, 1);
    // Every place of the ring waits for the next, and the last for the first.
    for wait in [
        "belt_in waits for first",
        "first waits for room on belt_out",
        "belt_out waits for second",
        "second waits for room on belt_in",
    ] {
        assert!(printed.err.contains(wait), "{wait}: {}", printed.err);
    }
    assert!(
        printed
            .err
            .starts_with("error[LW403]: the line can no longer advance")
    );
    assert_shown!("blocked", printed);
    let document = session.run("run blocked.lw --format json --no-timing");
    assert_eq!(document.code, 1);
    assert_eq!(document.err, "");
    let document: serde_json::Value = serde_json::from_str(&document.out).expect("a document");
    assert_eq!(document["products"], 0);
    assert_eq!(document["findings"][0]["code"], "LW403", "{document}");
}

#[test]
fn a_line_without_an_end() {
    let session = Session::new();
    session.edit("lamp.lw", "    limit 5 products\n", "");
    let printed = session.run("run lamp.lw");
    assert_eq!(printed.code, 2);
    assert_shown!("endless", printed);
    assert_eq!(session.run("run lamp.lw --parts 2").code, 0);
    assert_eq!(session.run("run lamp.lw --until 10").code, 0);
}

#[test]
fn a_line_whose_every_part_is_refused() {
    let session = Session::new();
    // No operation ever ends: `check` reports it, and nothing is run.
    let checked = session.run("check starved.lw");
    let printed = session.run("run starved.lw");
    assert_eq!((checked.code, printed.code), (1, 1));
    for code in ["LW304", "LW309"] {
        assert!(
            checked.err.contains(code) || checked.out.contains(code),
            "{}",
            checked.err
        );
        assert!(printed.err.contains(code), "{}", printed.err);
    }
    assert!(printed.out.is_empty(), "{}", printed.out);
    // The clamp closes, and now the operation writes 11 into a property of 0..10.
    session.edit(
        "starved.lw",
        "clamped: bool = false",
        "clamped: bool = true",
    );
    let printed = session.run("run starved.lw --until 60");
    assert_eq!(printed.code, 1);
    assert!(
        printed
            .err
            .contains("property `width` would get a value outside its range"),
        "{}",
        printed.err
    );
    session.edit("starved.lw", "width = width + 1", "width = width - 1");
    assert_eq!(session.run("run starved.lw --parts 3").code, 0);
}

#[test]
fn mistakes_elsewhere_in_the_file_do_not_matter_to_synth() {
    let session = Session::new();
    let other = "contract Broken { output x: bool guarantee: always y }\n";
    session.edit("lamp.lw", "/// Lights up", &format!("{other}/// Lights up"));
    assert_eq!(session.run("synth lamp.lw::Light").code, 0);
    assert_eq!(session.run("synth lamp.lw::Broken").code, 1);
}

/// A share is read exactly, not as a product of two rounded numbers.
#[test]
fn percentages_are_read_as_they_are_written() {
    let text = std::fs::read_to_string(root().join("tests/cases/line/sound.lw")).expect("a line");
    for percent in 0..=100 {
        let line = "    requirement share: busy(table) >= ".to_owned()
            + &percent.to_string()
            + " %\n    limit";
        let text = text.replacen("    limit", &line, 1);
        assert!(text.contains("share"));
        let (library, findings) =
            linewright::contract::load(&[("line/sound.lw".to_owned(), text)], &|wanted, _| {
                let path = root().join("tests/cases/line").join(wanted);
                let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
                Ok((wanted.to_owned(), text))
            });
        let line = library
            .lines
            .first()
            .unwrap_or_else(|| panic!("{findings:?}"));
        let share = line.requirements.iter().find(|r| r.name == "share");
        let wanted: f64 = format!("{percent}e-2").parse().expect("a number");
        assert_eq!(
            share.expect("it is there").bound.to_bits(),
            wanted.to_bits(),
            "{percent}"
        );
    }
}
