//! Every controller of the library against its function block: 100,000 random steps each.

use crate::library::{Controlled, as_functions, functions, machines};
use crate::play::{Counts, compare, compiled, show};
use linewright::gr1::Specification;
use linewright::mealy::Controller;
use linewright::station::structured_text::{block, block_of_tables};
use std::collections::BTreeMap;

const STEPS: usize = 100_000;

fn played(text: &str, controller: &Controller, specification: &Specification, steps: usize) -> Counts {
    let program = compiled(text).unwrap_or_else(|e| panic!("{}: {e}\n{text}", controller.name()));
    match compare(&program, controller, specification, steps, 5) {
        Ok(counts) => counts,
        Err(difference) => panic!("{difference}"),
    }
}

#[test]
fn machines_and_their_blocks_make_the_same_steps() {
    let mut all = BTreeMap::new();
    for Controlled { specification, controller } in machines() {
        let text = block(controller, specification).to_text();
        let clock = std::time::Instant::now();
        let counts = played(&text, controller, specification, STEPS);
        eprintln!("{} {} {:?} {counts:?}", controller.name(), text.len(), clock.elapsed());
        all.insert(format!("{} {}", controller.name(), all.len()), counts);
    }
    println!("{}", show(&all));
}

#[test]
fn tables_and_their_blocks_make_the_same_steps() {
    for Controlled { specification, controller } in machines() {
        let machine = controller.machine().expect("a machine");
        let text = block_of_tables(machine, specification).to_text();
        let clock = std::time::Instant::now();
        let counts = played(&text, controller, specification, STEPS / 10);
        eprintln!("{} {} {:?} {counts:?}", controller.name(), text.len(), clock.elapsed());
    }
}

#[test]
fn functions_and_their_blocks_make_the_same_steps() {
    for Controlled { specification, .. } in machines() {
        let controller = as_functions(specification);
        let text = block(&controller, specification).to_text();
        let clock = std::time::Instant::now();
        let counts = played(&text, &controller, specification, STEPS / 10);
        eprintln!("{} {} {:?} {counts:?}", controller.name(), text.len(), clock.elapsed());
    }
}

#[test]
fn large_controllers_and_their_blocks_make_the_same_steps() {
    for Controlled { specification, controller } in functions() {
        let text = block(controller, specification).to_text();
        let clock = std::time::Instant::now();
        let counts = played(&text, controller, specification, STEPS / 100);
        eprintln!("{} {} {:?} {counts:?}", controller.name(), text.len(), clock.elapsed());
    }
}
