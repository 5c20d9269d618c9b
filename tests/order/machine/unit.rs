//! The proof of the synthesized unit, and its operation.

use super::mutant::{LINE, unit};
use crate::support::{linewright, root};
use linewright::algebra::closed::ClosedComposition;
use linewright::contract::machine::Role;
use linewright::mealy;
use linewright::station::Controller as _;
use linewright::station::interpret::Interpreter;
use serde_json::Value;
use std::sync::Arc;

#[test]
fn the_synthesized_coordinator_is_proved_to_keep_the_orders() {
    let output = linewright(root(), &["check", LINE, "--format", "json", "--no-timing"]);
    let text = String::from_utf8(output.stdout).expect("a document");
    assert_eq!(output.status.code(), Some(0), "{text}");
    let document: Value = serde_json::from_str(&text).expect("a document");
    let machine = &document["machines"][0];
    let table = machine["discharges"].as_array().expect("a table");
    for order in ["order trays", "order transport"] {
        let met = table.iter().any(|line| {
            let line = line.to_string();
            line.contains(&format!("\"{order}\"")) && line.contains("\"PickAndPlace\"")
        });
        assert!(met, "{order}: {table:#?}");
    }
}

#[test]
fn the_controllers_keep_the_orders_together() {
    let unit = unit();
    let controllers: Vec<&mealy::Controller> = unit.controllers.iter().collect();
    let closed = ClosedComposition::of_machine(&unit.machine, &controllers);
    let limits = linewright::game::Limits::default();
    let verdict = closed.decide(&limits).expect("it is small");
    assert!(verdict.holds(), "{verdict:#?}");
    let watches = unit.machine.components.iter();
    assert_eq!(watches.filter(|c| c.role == Role::Watch).count(), 1);
}

#[test]
fn it_carries_one_workpiece_after_the_other() {
    let unit = unit();
    let mut interpreter =
        Interpreter::new(Arc::clone(&unit.machine), Arc::clone(&unit.controllers));
    for _ in 0..5 {
        let service = interpreter
            .simulate(0, &mut [])
            .expect("it keeps the orders");
        assert!(service.steps > 8, "{service:?}");
    }
}
