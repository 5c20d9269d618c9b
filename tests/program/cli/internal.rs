//! Internal errors: the variable `LINEWRIGHT_PANIC` makes the program panic where the activity
//! contains these words.

use super::session::{Printed, Session};
use serde_json::Value;

fn run(session: &Session, line: &str, at: &str) -> Printed {
    session.run_with(line, &[("LINEWRIGHT_PANIC", at), ("RUST_BACKTRACE", "0")])
}

fn verdict<'a>(document: &'a Value, list: &str, name: &str) -> &'a str {
    let entries = document[list].as_array().expect("a list");
    let entry = entries.iter().find(|e| e["name"] == name);
    let entry = entry.unwrap_or_else(|| panic!("{name} in {document}"));
    entry["verdict"].as_str().expect("a verdict")
}

/// The place of the failure, and the outcome for the contract, the machine and the line of the
/// file: everything else is judged as always.
#[test]
fn what_it_fails_at_has_no_verdict_and_all_else_has_one() {
    const FAILED: &str = "internal_error";
    let session = Session::new();
    for (at, light, machine, line) in [
        ("checking the contract `Light`", FAILED, FAILED, FAILED),
        ("solving the game", FAILED, FAILED, FAILED),
        ("extracting its controller", FAILED, FAILED, FAILED),
        ("examining its plant", FAILED, FAILED, FAILED),
        (
            "explaining the contract `Light`",
            FAILED,
            "realizable",
            "valid",
        ),
        ("the machine `Lamp`", "realizable", FAILED, FAILED),
        (
            "putting its controllers together",
            "realizable",
            FAILED,
            FAILED,
        ),
        (
            "proving the line `Lamps`",
            "realizable",
            "realizable",
            FAILED,
        ),
    ] {
        let files = "check unrealizable.lw lamp.lw syntax.lw";
        let printed = run(&session, &format!("{files} --format json"), at);
        assert_eq!(printed.code, 4, "{at}: {}", printed.err);
        let document: Value = serde_json::from_str(&printed.out).expect("a document");
        assert_eq!(verdict(&document, "contracts", "Light"), light, "{at}");
        assert_eq!(verdict(&document, "machines", "Lamp"), machine, "{at}");
        assert_eq!(verdict(&document, "lines", "Lamps"), line, "{at}");
        if line == FAILED {
            assert_eq!(document["lines"][0]["proof"], Value::Null, "{at}");
        }
        // Results from before and after are present.
        if !["solving", "extracting", "examining"]
            .iter()
            .any(|w| at.starts_with(w))
        {
            let lost = verdict(&document, "contracts", "Foresight");
            assert_eq!(lost, "unrealizable", "{at}");
        }
        assert!(printed.out.contains("LW002"), "{at}");
        let said = printed.out.contains("LW007") && printed.out.contains(at);
        assert!(said, "{at}: {}", printed.out);
        assert!(!printed.err.contains("panicked"), "{at}: {}", printed.err);
        let human = run(&session, &format!("{files} --no-timing"), at);
        assert_eq!(human.code, 4);
        assert!(human.out.contains("internal error"), "{}", human.out);
    }
}

#[test]
fn a_command_that_fails_as_a_whole_leaves_a_document() {
    let session = Session::new();
    for (command, line) in [
        ("check", "check lamp.lw"),
        ("build", "build lamp.lw --target source"),
        ("run", "run lamp.lw"),
        ("synth", "synth lamp.lw::Light"),
        ("fmt", "fmt --check lamp.lw"),
    ] {
        let at = format!("running `{command}`");
        let printed = run(&session, &format!("{line} --format json"), &at);
        assert_eq!(printed.code, 4, "{line}: {}", printed.err);
        let document: Value = serde_json::from_str(&printed.out).expect("a document");
        assert_eq!(document["findings"][0]["code"], "LW007", "{line}");
        let message = document["findings"][0]["message"].as_str().expect("a text");
        assert!(message.contains(&at), "{message}");
        let human = run(&session, line, &at);
        assert_eq!((human.code, human.out.as_str()), (4, ""), "{line}");
        assert!(human.err.contains("error[LW007]"), "{}", human.err);
    }
    // If one machine cannot be built, the others are.
    let at = "building the machine `Lamp`";
    let printed = run(&session, "build lamp.lw --target source --out c", at);
    assert_eq!(printed.code, 4, "{}", printed.err);
    assert!(printed.err.contains(at), "{}", printed.err);
    // The variable applies to these words only.
    assert_eq!(run(&session, "check lamp.lw", "something else").code, 0);
    assert_eq!(run(&session, "check lamp.lw", "").code, 0);
}
