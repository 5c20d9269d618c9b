//! The remedy in a finding works.

use super::examples::load;
use linewright::diagnostics::Diagnostic;
use linewright::game::Limits;
use linewright::line::abstraction::{Abstraction, decide, findings, with_losses};

/// A station joins two P and one Q, which reach it through one buffer. Returns the advice; `None`
/// if the line is proved.
fn advice(first: &str, second: &str) -> Option<String> {
    let text = format!(
        "import std.coordination.single
contract Work {{
    input requested: bool
    output finished: bool
    guarantee report: always (finished <-> requested)
}}
machine M {{
    coordinator c: Single {{
        job = operation = go
        executed = a.finished
    }}
    action a: Work when c.command {{
        requested = c.command
        time 1 s
    }}
    operation go: a
    done c.done
}}
line L {{
    part P
    part Q
    part A from 2 P, 1 Q
    product A
    source p: P every 10 s{first}
    source q: Q every 10 s{second}
    sink out
    buffer b capacity 3
    station s: M {{ perform go on A }}
    route P: p -> b -> s
    route Q: q -> b -> s
    route A: s -> out
}}
"
    );
    advice_on(&text)
}

/// Returns the advice on the first finding about the line of a file; `None` if it is proved.
fn advice_on(text: &str) -> Option<String> {
    finding_on(text).map(|finding| finding.help.unwrap_or_default())
}

/// Returns the first finding about the line of a file.
fn finding_on(text: &str) -> Option<Diagnostic> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("line.lw");
    std::fs::write(&file, text).expect("a file");
    let line = load(&file.display().to_string());
    let line = with_losses(&line);
    let abstraction = Abstraction::of(&line).expect("an abstraction");
    let verdict = decide(&abstraction, &Limits::default()).expect("no limit");
    let found = findings(&line, &abstraction, &verdict);
    found.into_iter().next()
}

#[test]
fn the_parts_that_fill_a_circle_are_limited() {
    let limit = |n: u32| format!(", at most {n} in the line");
    // A second Q takes the place of a P. With fewer P, no A is made.
    let help = advice(&limit(2), "").expect("a circle");
    assert!(
        help.contains("write `at most N in the line` behind source q"),
        "{help}"
    );
    assert!(!help.contains("of p"), "{help}");
    assert_eq!(advice(&limit(2), &limit(1)), None);
    // A third P takes the place of the Q.
    let help = advice(&limit(3), &limit(1)).expect("a circle");
    assert!(
        help.contains("make the limit of p less than 3. Or"),
        "{help}"
    );
    assert!(!help.contains("source q"), "{help}");
}

/// Where a buffer of the cycle lets parts expire, the finding says that this does not count.
#[test]
fn a_cycle_in_which_parts_expire_says_so() {
    let text = |shelf_life: &str| {
        format!(
            "line Round {{
    part P {{ property rounds: 0..2 = 0 }}
    product P
    source a: P every 1 s
    buffer q capacity 2 {shelf_life}
    station x {{ takes 2 s sets rounds = min(rounds + 1, 2) }}
    sink k
    route P: a -> x
    route P: x -> q when rounds < 2
    route P: x -> k otherwise
    route P: q -> x
    limit 9 products
}}
"
        )
    };
    let note =
        "times are left out: a part in q counts as waiting, even where it would expire first";
    for (shelf_life, is_said) in [("", false), ("shelf life 1 min", true)] {
        let finding = finding_on(&text(shelf_life)).expect("a cycle");
        assert_eq!(finding.code.id, "LW408");
        assert_eq!(
            finding.notes.iter().any(|n| n == note),
            is_said,
            "{finding:?}"
        );
    }
}

/// A station that passes parts to itself blocks with a single one, so no limit helps.
#[test]
fn a_station_in_a_circle_with_itself_needs_a_buffer() {
    let text = "contract Work {
    input requested: bool
    output finished: bool
    guarantee reports: always (finished <-> requested)
}

machine Press {
    property passes: 0..3 = 0
    action work: Work when operation = press {
        requested = operation = press
        time 2 s
    }
    operation press: work
    done work.finished
    write passes = min(passes + 1, 3)
}

line Itself {
    part Plate {
        property passes: 0..3 = 0
    }
    source rack: Plate every 5 s, at most 2 in the line
    station press: Press {
        perform press on Plate
    }
    sink box
    route Plate: rack -> press
    route Plate: press -> press when passes < 2
    route Plate: press -> box otherwise
}
";
    let help = advice_on(text).expect("a circle");
    assert!(
        help.starts_with("Put a buffer into the cycle press,"),
        "{help}"
    );
    let buffered = text
        .replace("sink box", "sink box\n    buffer again capacity 2")
        .replace("press -> press when", "press -> again when")
        .replace(
            "route Plate: press -> box",
            "route Plate: again -> press\n    route Plate: press -> box",
        );
    assert_eq!(advice_on(&buffered), None);
}
