//! Skills called from outside: each operation is a call, even if the same one follows itself.

use super::mutant::library;
use crate::laboratory::{Controlled, of_lines};
use crate::support::linewright;
use linewright::contract::machine::Machine;
use linewright::station::interpret::Interpreter;
use linewright::station::{Controller, ErrorCode};
use serde_json::Value;
use std::fmt::Write as _;
use std::sync::Arc;

const MOVER: &str = "import std.coordination.single

skills Arm {
    component x: {left, right} = left {
        Left -> left
        Right -> right
    }

    order home: Right before Left
    order tidy [R-7]: never Left, Right twice in a row
}

contract Drive {
    input asked: bool
    output stage: 0..2
    output executed: bool

    guarantee start: stage = 0
    guarantee report: always (executed <-> asked and stage = 2)
    guarantee moves: always (next stage = (if asked and stage < 2 then stage + 1 else 0))
}

machine Mover {
    coordinator control: Single {
        job = operation in {left, right}
        executed = go.executed
    }
    action go: Drive when control.command {
        asked = control.command
    }

    operation left: go
    operation right: go
    done control.done

    skills Arm {
        Left = operation = left
        Right = operation = right
    }
}

line Hall {
    part Crate
    product Crate

    source dock: Crate every 60 s
    sink store

    station mover: Mover {
        perform right, right on Crate
    }

    route Crate: dock -> mover -> store
}
";

fn mover() -> Controlled {
    controlled(MOVER)
}

fn controlled(text: &str) -> Controlled {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mover.lw");
    std::fs::write(&path, text).expect("a file can be written");
    of_lines(&[&path.display().to_string()]).swap_remove(0)
}

fn operation(machine: &Machine, name: &str) -> usize {
    let mut all = machine.operations.iter();
    all.position(|o| o.name == name).expect("an operation")
}

#[test]
fn every_operation_is_a_call() {
    let mover = mover();
    let interpreter = Interpreter::new(Arc::clone(&mover.machine), Arc::clone(&mover.controllers));
    let both: [Box<dyn Controller>; 2] = [Box::new(interpreter), Box::new(library(&mover))];
    let [left, right] = ["left", "right"].map(|name| operation(&mover.machine, name));
    for mut controller in both {
        let mut call = |operation: usize| controller.simulate(operation, &mut []);
        let refused = |error: linewright::station::CallError, rule: &str, text: &str| {
            assert_eq!(error.code, ErrorCode::Order, "{error:?}");
            assert_eq!(error.rule.as_deref(), Some(rule));
            assert!(error.message.ends_with(text), "{error:?}");
        };
        let first = call(left).expect_err("it has not been called Right");
        refused(
            first,
            "Arm: order home",
            "the order `home` is broken: Right before Left",
        );
        call(right).expect("now it is");
        let twice = call(right).expect_err("twice in a row");
        refused(
            twice,
            "Arm: order tidy",
            "the order `tidy` (R-7) is broken: never Left, Right twice in a row",
        );
        call(left).expect("what was refused was not called");
        let twice = call(left).expect_err("twice in a row");
        refused(twice, "Arm: order tidy", "never Left, Right twice in a row");
        call(right).expect("one after the other");
    }
}

#[test]
fn the_caller_answers_for_them() {
    let document = checked(MOVER);
    let table = document["machines"][0]["discharges"].as_array();
    let order = |line: &&Value| line.to_string().contains("order tidy\"");
    let line = table.expect("a table").iter().find(order);
    let line = line.expect("the order is in it").to_string();
    assert!(line.contains("\"exported\""), "{line}");
}

#[test]
fn a_line_that_asks_against_an_order_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mover.lw"), MOVER).expect("a file can be written");
    let output = linewright(folder.path(), &["run", "mover.lw", "--until", "90"]);
    let text = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(1), "{text}");
    for said in [
        "LW405",
        "mover",
        "Arm: the order `tidy`",
        "Crate 1",
        "(R-7)",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
}

/// The output of `check` for a file, as a document.
fn checked(text: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mover.lw"), text).expect("a file can be written");
    let arguments = ["check", "mover.lw", "--format", "json", "--no-timing"];
    let output = linewright(folder.path(), &arguments);
    serde_json::from_slice(&output.stdout).expect("a document")
}

/// The same mover with other orders, in a line that performs these sequences on as many types of
/// parts.
fn mover_with(orders: &str, tasks: &[&[&str]]) -> String {
    let (head, rest) = MOVER.split_once("    order home").expect("its orders");
    let (_, machine) = rest.split_once("\n}").expect("their end");
    let (machine, _) = machine.split_once("line Hall").expect("its line");
    let mut parts = String::new();
    let mut performs = String::new();
    for (number, task) in tasks.iter().enumerate() {
        let _ = write!(
            parts,
            "    part Crate{number}\n    source dock{number}: Crate{number} every 60 s\n    route Crate{number}: dock{number} -> mover -> store\n"
        );
        let _ = writeln!(
            performs,
            "        perform {} on Crate{number}",
            task.join(", ")
        );
    }
    format!(
        "{head}{orders}\n}}{machine}line Hall {{\n{parts}    product Crate0\n    sink store\n    station mover: Mover {{\n{performs}    }}\n}}\n"
    )
}

/// The calls after which one is refused, found by trying all sequences of `tasks` on the machine
/// itself.
fn refused_after(text: &str, tasks: &[&[&str]], most: usize) -> Option<Vec<String>> {
    let mover = controlled(text);
    let mut sequences: Vec<Vec<String>> = vec![Vec::new()];
    let mut shortest: Option<Vec<String>> = None;
    for _ in 0..most {
        let longer = sequences.iter().flat_map(|before| {
            tasks.iter().map(|task| {
                let task = task.iter().map(|operation| (*operation).to_owned());
                before.iter().cloned().chain(task).collect::<Vec<String>>()
            })
        });
        sequences = longer.collect();
        for sequence in &sequences {
            let mut machine =
                Interpreter::new(Arc::clone(&mover.machine), Arc::clone(&mover.controllers));
            let refused = sequence.iter().position(|name| {
                let operation = operation(&mover.machine, name);
                machine.simulate(operation, &mut []).is_err()
            });
            if let Some(at) = refused
                && shortest.as_ref().is_none_or(|known| at + 1 < known.len())
            {
                shortest = Some(sequence[..=at].to_vec());
            }
        }
    }
    shortest
}

#[test]
fn a_line_is_proved_only_where_no_sequence_of_its_parts_is_refused() {
    let orders = [
        "",
        "    order wear: at most 2 of Left\n",
        "    order wear: at most 2 of Left between Right and Right\n",
        "    order single: never Left twice in a row\n",
        "    order home: Right before Left\n",
        "    order sides: never Left, Right twice in a row\n",
        "    order mirror: Right only after Left\n",
        "    order locked: after Right until Left: never Right\n",
    ];
    let tasks: [&[&[&str]]; 5] = [
        &[&["left"]],
        &[&["left", "right"]],
        &[&["right", "left", "left"]],
        &[&["left", "right"], &["right", "left"]],
        &[&["left", "left", "right"], &["right"]],
    ];
    let (mut proved, mut open) = (0, 0);
    // A signal that never changes makes no difference.
    let with_signal = |text: String| {
        text.replace("operation = left\n", "operation = left and on\n")
            .replace(
                "machine Mover {",
                "machine Mover {\n    signal on: bool = true",
            )
    };
    for (at, orders) in orders.into_iter().enumerate() {
        for (of, tasks) in tasks.into_iter().enumerate() {
            let text = mover_with(orders, tasks);
            let text = if (at + of) % 2 == 0 {
                text
            } else {
                with_signal(text)
            };
            let document = checked(&text);
            let line = &document["lines"][0];
            let findings = line["findings"].as_array().expect("findings");
            let mut asks = findings.iter().filter(|f| f["code"] == "LW411");
            let refused = refused_after(&text, tasks, 4);
            let shown = format!("{orders}{tasks:?}: {refused:?}: {line}");
            if let Some(sequence) = refused {
                open += 1;
                assert_eq!(line["proof"], "open", "{shown}");
                let asked = asks.next().unwrap_or_else(|| panic!("{shown}")).to_string();
                let last = format!("`{}`", sequence[sequence.len() - 1]);
                assert!(asked.contains(&last), "{shown}");
            } else {
                proved += 1;
                assert_eq!(line["proof"], "proved", "{shown}");
                assert!(asks.next().is_none(), "{shown}");
            }
        }
    }
    assert!(proved >= 10 && open >= 10, "{proved} proved, {open} not");
}

/// The values that a line gives a parameter are known, and so are those that its parts carry.
#[test]
fn parameters_and_properties_are_known() {
    let with = |declared: &str, part: &str, performs: &str| {
        mover_with("    order single: never Left twice in a row\n", &[&["left"]])
            .replace("machine Mover {", &format!("machine Mover {{\n    {declared} to: {{l, r}} = l\n    abstract side: {{l, r}} = to"))
            .replace("Left = operation = left", "Left = operation = left and side = l")
            .replace("Right = operation = right", "Right = operation = right or operation = left and side = r")
            .replace("part Crate0", &format!("part Crate0{part}"))
            .replace("perform left", performs)
    };
    for (performs, proof, code) in [
        ("perform left(to = l)", "open", Some("LW411")),
        ("perform left(to = r)", "proved", None),
        ("perform left(to = l), left(to = r)", "proved", None),
        (
            "perform left(to = r), left(to = l), left(to = l)",
            "open",
            Some("LW411"),
        ),
    ] {
        let document = checked(&with("parameter", "", performs));
        let line = &document["lines"][0];
        assert_eq!(line["proof"], proof, "{performs}: {line}");
        assert_eq!(line.to_string().contains("LW411"), code.is_some(), "{line}");
    }
    let part = " { property to: {l, r} = l }";
    let document = checked(&with("property", part, "perform left"));
    let line = &document["lines"][0];
    // Every Crate keeps its initial value: it calls Left, again and again.
    assert_eq!(line["proof"], "open", "{line}");
    assert!(line.to_string().contains("LW411"), "{line}");
    let part = " { property to: {l, r} = r }";
    let document = checked(&with("property", part, "perform left"));
    assert_eq!(document["lines"][0]["proof"], "proved", "{document}");
}

#[test]
fn what_forbids_an_operation_for_ever_is_named() {
    let text = MOVER
        .replace("order tidy [R-7]: never", "order tidy [R-7]: at most 0 of")
        .replace("Left, Right twice in a row", "Left");
    let document = checked(&text).to_string();
    let shown = "the operation `left` can never begin: the order `tidy` (R-7) prevents it";
    assert!(document.contains(shown), "{document}");
}
