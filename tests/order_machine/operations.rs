//! Skills that are called from outside: each operation is a call, also where the same one follows on itself.

use crate::laboratory::{Controlled, of_lines};
use crate::mutant::library;
use crate::support::linewright;
use linewright::contract::machine::Machine;
use linewright::station::interpret::Interpreter;
use linewright::station::{Controller, ErrorCode};
use serde_json::Value;
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
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mover.lw");
    std::fs::write(&path, MOVER).expect("a file can be written");
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
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mover.lw"), MOVER).expect("a file can be written");
    let arguments = ["check", "mover.lw", "--format", "json", "--no-timing"];
    let output = linewright(folder.path(), &arguments);
    let text = String::from_utf8(output.stdout).expect("a document");
    assert_eq!(output.status.code(), Some(0), "{text}");
    let document: Value = serde_json::from_str(&text).expect("a document");
    let table = document["machines"][0]["discharges"].as_array();
    let order = |line: &&Value| line.to_string().contains("order tidy\"");
    let line = { table.expect("a table").iter() }.find(order);
    let line = line.expect("the order is in it").to_string();
    assert!(line.contains("\"exported\""), "{line}");
}

#[test]
fn a_line_that_asks_against_an_order_is_told_so() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mover.lw"), MOVER).expect("a file can be written");
    let output = linewright(folder.path(), &["run", "mover.lw", "--until", "90"]);
    let text = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(1), "{text}");
    for said in ["LW405", "mover", "Arm: order tidy", "Crate 1", "(R-7)"] {
        assert!(text.contains(said), "{said}: {text}");
    }
}
