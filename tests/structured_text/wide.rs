//! Numbers of every width and sign, and assumptions that compute with them.

use crate::library::as_functions;
use crate::play::{compare, compiled};
use linewright::cli::files::{self, StandardLibrary};
use linewright::game::{Limits, Outcome, solve};
use linewright::gr1::{Domain, Side, Specification, Timing};
use linewright::mealy::extract::extract;
use linewright::mealy::{Controller, Cube, Guard, Machine, Port, Test, Transition};
use linewright::station::structured_text::{Block, block, block_of_tables};

const CONTRACT: &str = "
contract Wide {
    input near: -300..300
    input far: -40000..40000
    input mode: {slow, fast, off}
    input other: {slow, fast, off}
    input go: bool
    output place: -70000..70000
    output few: 3..5
    output on: bool
    assume begins: near >= 0 and mode = off
    assume product: always (near * near <= 80000 or mode != off)
    assume smooth: always (abs(next near - near) <= 200 or go)
    assume least: always (min(next near, near) > -290 or max(near, 0) = 0 or place > 0)
    assume rest: always ((near + 300) mod 7 != 3 or next mode = mode or (near + 300) / 3 < 50)
    assume choice: always ((if go then near else 0 - near) < 250)
    assume same: always (mode = other and not next go -> next other != slow)
    assume flag: always ((go <-> on) or next near < 100 or next far > near)
    assume counted: always ((if go then 1 else 0) + (if on then 1 else 0) < 2 or next far != 5)
    guarantee places: always (place = (if far < -39990 then -70000 else if far > 39990 then 70000 else -1))
    guarantee small: always (few = (if near < 0 then 3 else if mode = fast then 4 else 5))
    guarantee lamp: always (next on <-> go)
}
";

fn specification() -> Specification {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wide.lw");
    std::fs::write(&path, CONTRACT).expect("a file can be written");
    let loaded = files::load(&[path.display().to_string()], &StandardLibrary::default());
    assert_eq!(loaded.findings, []);
    (*loaded.library.contracts[0].specification).clone()
}

fn plays(block: &Block, controller: &Controller, specification: &Specification) {
    let text = block.to_text();
    let program = compiled(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let counts = compare(&program, controller, specification, 20_000, 17);
    let counts = counts.unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(counts.unnamed, 0, "{text}");
    assert!(
        counts.accepted > 1_000 && counts.outside > 100,
        "{counts:?}"
    );
}

#[test]
fn every_form_computes_with_negative_and_wide_numbers() {
    let specification = specification();
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
        &block_of_tables(&machine, &specification),
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
        block_of_tables(&machine, &specification),
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
