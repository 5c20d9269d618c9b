//! Names that are invalid in Structured Text: the output is legal, every name is unique, and
//! nothing else changes.

use super::play::{compiled, play as played};
use crate::iec::document::text_of;
use crate::library::{as_functions, machines};
use linewright::gr1::{Domain, Owner, Specification};
use linewright::mealy::{Controller, Port};
use linewright::station::structured_text::{Block, block, block_with_tables};
use proptest::prelude::*;
use std::sync::OnceLock;

/// Words reserved by the language or by the block itself, and names that become equal.
const NAMES: [&str; 40] = [
    "END_IF",
    "End_If",
    "end_if",
    "step",
    "STEP",
    "Move",
    "int_to_bool",
    "EN",
    "a.b[3]",
    "a_b[3]",
    "A.B.3",
    "__a__b_3_",
    "Förderband[2].x",
    "Foerderband_2_x",
    "Ω",
    "漢字",
    "",
    "_",
    "3d",
    "v_3d",
    "enable",
    "ENABLE",
    "reset",
    "stepped",
    "error",
    "error_id",
    "refused",
    "state",
    "row",
    "memory",
    "signals",
    "Turn",
    "FB_Turn",
    "E_Command",
    "Command_turn",
    "Turn_no_error",
    "E_Turn_Error",
    "last_desired",
    "x *) y",
    "{pragma} (* <&\"'",
];

/// Turn in both forms.
fn turn() -> &'static (Specification, Controller, Controller) {
    static TURN: OnceLock<(Specification, Controller, Controller)> = OnceLock::new();
    TURN.get_or_init(|| {
        let found = machines().iter().find(|c| c.controller.name() == "Turn");
        let controlled = found.expect("a contract of the library");
        let specification = (*controlled.specification).clone();
        let functions = as_functions(&specification);
        (specification, controlled.controller.clone(), functions)
    })
}

/// The same with other names for its six variables, its labels, its assumptions and itself.
fn renamed(names: &[String], labels: &[String], own: &str) -> (Specification, [Controller; 2]) {
    let (mut specification, machine, functions) = turn().clone();
    let relabel = |domain: &mut Domain| {
        if let Domain::Enum { labels: old, .. } = domain {
            *old = labels[..old.len()].to_vec();
        }
    };
    for (variable, name) in specification.variables.iter_mut().zip(names) {
        variable.name.clone_from(name);
        relabel(&mut variable.domain);
    }
    for (formula, name) in specification.assumptions.safety.iter_mut().zip(names) {
        formula.name.clone_from(name);
    }
    own.clone_into(&mut specification.name);
    let of = |owner| {
        let all = specification.variables.iter();
        let names: Vec<String> = all
            .filter(|v| v.owner == owner)
            .map(|v| v.name.clone())
            .collect();
        names
    };
    let (inputs, outputs) = (of(Owner::Environment), of(Owner::System));
    let rename = |ports: &mut Vec<Port>, names: &[String]| {
        for (port, name) in ports.iter_mut().zip(names) {
            port.name.clone_from(name);
            relabel(&mut port.domain);
        }
    };
    let mut controllers = [machine, functions];
    for controller in &mut controllers {
        match controller {
            Controller::Machine(m) => {
                own.clone_into(&mut m.name);
                rename(&mut m.inputs, &inputs);
                rename(&mut m.outputs, &outputs);
            }
            Controller::Functions(f) => {
                own.clone_into(&mut f.name);
                rename(&mut f.inputs, &inputs);
                rename(&mut f.outputs, &outputs);
            }
        }
    }
    (specification, controllers)
}

/// Every form of it, as text and as a document, is accepted and makes the same steps. That a
/// violated assumption is named is tested with the names of the library.
fn check(names: &[String], labels: &[String], own: &str, steps: usize) -> Result<(), String> {
    let (specification, [machine, functions]) = renamed(names, labels, own);
    let explicit = machine.machine().expect("a machine");
    let play = |block: &Block, controller: &Controller| {
        for text in [block.to_text(), text_of(&block.to_plcopen())] {
            let program = compiled(&text).map_err(|e| format!("{e}\n{text}"))?;
            let broken = |error: &str, _: &str| error.contains("_BROKEN_");
            played(&program, controller, &specification, steps, 3, &broken)?;
        }
        Ok::<(), String>(())
    };
    play(&block(&machine, &specification), &machine)?;
    play(&block_with_tables(explicit, &specification), &machine)?;
    play(&block(&functions, &specification), &functions)
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| (*n).to_owned()).collect()
}

#[test]
fn keywords_and_equal_names_are_distinguished() {
    let labels = owned(&["turn", "Turn", "TURN", "end_if", "ä", "a.b[3]", "END_IF"]);
    for names in NAMES.chunks(6) {
        let mut names = owned(names);
        while names.len() < 6 {
            names.push(format!("rest{}", names.len()));
        }
        for own in ["Turn", "Move", "Über 3", ""] {
            check(&names, &labels, own, 400).unwrap_or_else(|e| panic!("{names:?} {own}: {e}"));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 40,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_names_will_do(
        names in prop::collection::vec(
            prop_oneof![prop::sample::select(NAMES.to_vec()).prop_map(str::to_owned), "\\PC{0,12}"], 6),
        labels in prop::collection::vec(
            prop_oneof![prop::sample::select(NAMES.to_vec()).prop_map(str::to_owned), "\\PC{0,6}"], 7),
        own in prop_oneof![prop::sample::select(NAMES.to_vec()).prop_map(str::to_owned), "\\PC{0,8}"],
    ) {
        if let Err(error) = check(&names, &labels, &own, 60) {
            return Err(TestCaseError::fail(error));
        }
    }
}
