//! Numbers of every width and sign, with arithmetic on them in assumptions.

use super::play::{compare, compiled};
use crate::library::{as_functions, wide};
use linewright::game::{Limits, Outcome, solve};
use linewright::gr1::{Domain, Side, Specification, Timing};
use linewright::mealy::extract::extract;
use linewright::mealy::{Controller, Cube, Guard, Machine, Port, Test, Transition};
use linewright::station::structured_text::{Block, block, block_with_tables};

fn plays(block: &Block, controller: &Controller, specification: &Specification) {
    let text = block.to_text();
    let program = compiled(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let counts = compare(&program, controller, specification, 20_000, 17);
    let counts = counts.unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert!(
        counts.accepted > 1_000 && counts.outside > 100 && counts.broken > 1_000,
        "{counts:?}"
    );
}

#[test]
fn every_form_computes_with_negative_and_wide_numbers() {
    let specification = wide();
    let limits = Limits::default();
    let Outcome::Realizable(won) = solve(&specification, &limits) else {
        panic!("a controller");
    };
    let machine = extract(&specification, &won, &limits).expect("no limit");
    let controller = Controller::Machine(machine.clone());
    plays(
        &block(&controller, &specification),
        &controller,
        &specification,
    );
    plays(
        &block_with_tables(&machine, &specification),
        &controller,
        &specification,
    );
    let functions = as_functions(&specification);
    plays(
        &block(&functions, &specification),
        &functions,
        &specification,
    );
}

#[test]
fn sixty_four_bits_are_lint() {
    let port = |name: &str, low: i64, high: i64| Port {
        name: name.to_owned(),
        domain: Domain::Range { low, high },
        unit: String::new(),
        internal: false,
    };
    let (low, high) = (-5_000_000_000, 5_000_000_000);
    let go = |low, high, output: i64| Transition {
        guard: Guard(vec![Cube(vec![Test {
            input: 0,
            low,
            high,
        }])]),
        output: vec![output],
        to: 0,
    };
    let transitions = vec![go(low, -7, high), go(-5, 12, 0), go(13, high, low)];
    let machine = Machine {
        name: "Long".to_owned(),
        timing: Timing::Mealy,
        inputs: vec![port("x", low, high)],
        outputs: vec![port("y", low, high)],
        initial: transitions.clone(),
        states: vec![transitions],
        goals: Vec::new(),
    };
    let specification = Specification {
        name: "Long".to_owned(),
        timing: Timing::Mealy,
        variables: Vec::new(),
        assumptions: Side::default(),
        guarantees: Side::default(),
    };
    let controller = Controller::Machine(machine.clone());
    for block in [
        block(&controller, &specification),
        block_with_tables(&machine, &specification),
    ] {
        let text = block.to_text();
        assert!(
            text.contains("x : LINT;") && text.contains("LINT#-5000000000"),
            "{text}"
        );
        let program = compiled(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let counts = compare(&program, &controller, &specification, 5_000, 1);
        assert!(counts.expect("the same steps").accepted > 1_000);
    }
}
