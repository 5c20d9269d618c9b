//! Controllers of recipes, as they are written: machine, C and Structured Text make the same steps,
//! and their vectors are those of the plan. What the verifier accepts is right for all outcomes, so
//! it has to refuse machines with one change.

mod c;
mod cells;
mod mutants;
mod plan;
mod ports;
mod runs;

use crate::structured_text::play::{compare, compiled};
use cells::Made;
use linewright::mealy::Controller;
use linewright::station::structured_text::block_from;

/// Steps of a play beside Structured Text.
const STEPS: usize = 2_000;

#[test]
fn compiled_c_makes_the_steps_of_the_machine() {
    c::compare(&cells::all());
}

#[test]
fn structured_text_makes_the_steps_of_the_machine() {
    for Made {
        layout,
        recipe,
        built,
        ..
    } in cells::all()
    {
        let (specification, origin) = (built.specification(), built.origin(&layout, &recipe));
        let controller = Controller::Machine(built.machine);
        let text = block_from(&controller, &specification, &origin).to_text();
        let program = compiled(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let played = compare(&program, &controller, &specification, STEPS, 3);
        let counts = played.unwrap_or_else(|difference| panic!("{difference}\n{text}"));
        assert_eq!(counts.accepted, STEPS, "{}", controller.name());
    }
}

#[test]
fn in_lockstep_the_vectors_are_those_of_the_plan() {
    let mut runs = 0;
    for made in cells::all() {
        runs += plan::compare(&made);
    }
    println!("{runs} runs");
    assert!(runs > 50, "{runs}");
}

#[test]
fn runs_have_the_steps_of_the_plan_and_the_time_of_their_vectors() {
    let mut counts = runs::Counts::default();
    for (seed, made) in (0..).zip(cells::all()) {
        runs::compare(&made, seed, &mut counts);
        runs::compare_worst_cases(&made, seed, &mut counts);
    }
    println!("{counts:?}");
    assert!(counts.runs > 50 && counts.loops > 20 && counts.tests > 40);
    assert!(counts.timed > 20 && counts.others == 0);
    for (seed, made) in (0..).zip(cells::random().take(200)) {
        runs::compare(&made, seed, &mut counts);
    }
    println!("{counts:?}");
    assert!(counts.runs > 400 && counts.loops > 100 && counts.tests > 250);
    assert!(counts.overruns > 5 && counts.others < 20);
}

#[test]
fn a_state_is_what_the_resources_perform() {
    for made in cells::all() {
        let (states, vectors) = (made.built.machine.states.len(), made.controller.vectors());
        assert!(states <= vectors + 1, "{states} states for {vectors}");
    }
}

#[test]
fn machines_with_a_change_are_refused() {
    let (mut refused, mut all) = (0, 0);
    for made in cells::all() {
        let (one, of) = mutants::refused(&made);
        refused += one;
        all += of;
    }
    println!("{refused} of {all} refused");
    assert!(all > 1_000 && refused == all, "{refused} of {all}");
}
