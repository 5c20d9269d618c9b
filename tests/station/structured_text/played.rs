//! Every controller of the library compared with its function block, 100,000 random steps each: as
//! a CASE and as functions; fewer as tables, for which the library's machines are too small, and
//! for the laboratory's controllers at real size.

use super::play::{Counts, compare, compiled};
use crate::library::{as_functions, large, machines};
use linewright::gr1::Specification;
use linewright::mealy::Controller;
use linewright::station::structured_text::{block, block_with_tables};

const STEPS: usize = 100_000;

fn played(
    text: &str,
    controller: &Controller,
    specification: &Specification,
    steps: usize,
) -> Counts {
    let program = compiled(text).unwrap_or_else(|e| panic!("{}: {e}\n{text}", controller.name()));
    match compare(&program, controller, specification, steps, 5) {
        Ok(counts) => counts,
        Err(difference) => panic!("{difference}"),
    }
}

#[test]
fn machines_and_their_blocks_make_the_same_steps() {
    let mut sum = Counts::default();
    for controlled in machines() {
        let (specification, controller) = (&controlled.specification, &controlled.controller);
        let text = block(controller, specification).to_text();
        let counts = played(&text, controller, specification, STEPS);
        println!("{} of {} bytes: {counts:?}", controller.name(), text.len());
        assert!(counts.accepted > STEPS / 2, "{}", controller.name());
        sum = sum.and(counts);
    }
    println!("all machines: {sum:?}");
    assert!(
        sum.outside > 1_000 && sum.broken > 10_000 && sum.resets > 1_000,
        "{sum:?}"
    );
    assert!(sum.overruled > 1_000, "{sum:?}");
}

#[test]
fn tables_and_their_blocks_make_the_same_steps() {
    let mut sum = Counts::default();
    for controlled in machines() {
        let specification = &controlled.specification;
        let machine = controlled.controller.machine().expect("a machine");
        let text = block_with_tables(machine, specification).to_text();
        let counts = played(&text, &controlled.controller, specification, STEPS / 5);
        sum = sum.and(counts);
    }
    println!("all tables: {sum:?}");
    assert!(sum.broken > 1_000 && sum.overruled > 1_000, "{sum:?}");
}

#[test]
fn functions_and_their_blocks_make_the_same_steps() {
    let mut sum = Counts::default();
    for controlled in machines() {
        let specification = &controlled.specification;
        let controller = as_functions(specification);
        let text = block(&controller, specification).to_text();
        let counts = played(&text, &controller, specification, STEPS);
        println!("{} of {} bytes: {counts:?}", controller.name(), text.len());
        sum = sum.and(counts);
    }
    println!("all functions: {sum:?}");
    assert!(
        sum.outside > 1_000 && sum.broken > 10_000 && sum.resets > 1_000,
        "{sum:?}"
    );
}

#[test]
fn large_controllers_and_their_blocks_make_the_same_steps() {
    for controlled in large() {
        let (specification, controller) = (&controlled.specification, &controlled.controller);
        let text = block(controller, specification).to_text();
        let counts = played(&text, controller, specification, STEPS / 10);
        println!("{} of {} bytes: {counts:?}", controller.name(), text.len());
        assert!(counts.accepted > STEPS / 20, "{counts:?}");
    }
}
