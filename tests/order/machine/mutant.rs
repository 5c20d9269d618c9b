//! A coordinator with two answers exchanged: it moves to the other tray before it goes up.

use crate::laboratory::{Controlled, of_lines};
use linewright::algebra::closed::{ClosedComposition, replay};
use linewright::contract::line::{Line, NodeKind};
use linewright::diagnostics::codes;
use linewright::engine::files::{self, StandardLibrary};
use linewright::game::Limits;
use linewright::gr1::Domain;
use linewright::line::{Options, Plant};
use linewright::mealy;
use linewright::station::interpret::Interpreter;
use linewright::station::load::{Instance, Library};
use linewright::station::{CallError, Controller, ErrorCode, Package, Toolchain};
use std::collections::BTreeMap;
use std::sync::Arc;

pub const LINE: &str = "examples/pick-and-place/unit.lw";

const RULE: &str = "PickAndPlace: order trays";

/// The unit with its synthesized controllers.
pub fn unit() -> Controlled {
    let mut machines = of_lines(&[LINE]);
    assert_eq!(machines.len(), 1);
    machines.swap_remove(0)
}

/// The same, but its coordinator calls Left in phase 4 and Up in phase 5.
fn mutant() -> Controlled {
    let unit = unit();
    let mut controllers = Vec::clone(&unit.controllers);
    let mealy::Controller::Machine(coordinator) = &mut controllers[0] else {
        panic!("a coordinator is a table");
    };
    let place = |name: &str| {
        let mut outputs = coordinator.outputs.iter();
        outputs.position(|p| p.name == name).expect("an output")
    };
    let (phase, call) = (place("phase"), place("call"));
    let Domain::Enum { labels, .. } = &coordinator.outputs[call].domain else {
        panic!("call has labels");
    };
    let label = |name: &str| labels.iter().position(|l| l == name).expect("a label") as i64;
    let (up, left) = (label("up"), label("left"));
    let mut exchanged = [0, 0];
    for transition in coordinator.states.iter_mut().flatten() {
        let output = &mut transition.output;
        match (output[phase], output[call]) {
            (4, c) if c == up => {
                output[call] = left;
                exchanged[0] += 1;
            }
            (5, c) if c == left => {
                output[call] = up;
                exchanged[1] += 1;
            }
            _ => {}
        }
    }
    assert!(exchanged.iter().all(|e| *e > 0), "{exchanged:?}");
    Controlled {
        machine: unit.machine,
        controllers: Arc::new(controllers),
    }
}

pub fn library(controlled: &Controlled) -> Instance {
    // Unlinked on drop; the loaded library stays.
    let folder = tempfile::tempdir().expect("a folder");
    let package = Package::emit(&controlled.machine, &controlled.controllers);
    let built = Toolchain::host().build(&package, folder.path(), false);
    let library = Library::open(&built.expect("a library").path);
    library.expect("it loads").instance().expect("an instance")
}

#[test]
fn the_proof_refuses_it() {
    let mutant = mutant();
    let controllers: Vec<&mealy::Controller> = mutant.controllers.iter().collect();
    let closed = ClosedComposition::of_machine(&mutant.machine, &controllers);
    let verdict = closed.decide(&Limits::default()).expect("it is small");
    let broken = verdict.open.iter().find(|open| {
        let formula = closed.system.formula(open.what);
        formula.is_some_and(|f| f.name == "order trays")
    });
    let broken = broken.unwrap_or_else(|| panic!("{verdict:#?}"));
    // The controllers themselves produce the run.
    assert_eq!(replay::check_open(&closed, broken), Ok(()));
}

fn refused(controller: &mut dyn Controller) -> CallError {
    let error = controller.simulate(0, &mut []);
    error.expect_err("Left is called while the arm is down")
}

#[test]
fn the_library_answers_with_a_code_of_its_own() {
    let mutant = mutant();
    let mut interpreter =
        Interpreter::new(Arc::clone(&mutant.machine), Arc::clone(&mutant.controllers));
    let expected = refused(&mut interpreter);
    assert_eq!(expected.code, ErrorCode::Order);
    assert_eq!(ErrorCode::Order as i32, -10);
    assert_eq!(expected.rule.as_deref(), Some(RULE));
    assert_eq!(
        expected.message,
        "PickAndPlace: the order `trays` is broken: after Down until Up: never Left, Right"
    );
    let mut instance = library(&mutant);
    assert_eq!(refused(&mut instance), expected);
    // Nothing has changed, so that it is refused for the same reason again.
    assert_eq!(refused(&mut instance), expected);
}

fn line() -> Arc<Line> {
    let file = crate::support::root().join(LINE).display().to_string();
    let mut loaded = files::load(&[file], &StandardLibrary::default());
    Arc::new(loaded.library.lines.remove(0))
}

#[test]
fn a_run_reports_the_violation() {
    for (controlled, sound) in [(unit(), true), (mutant(), false)] {
        let line = line();
        let station = line
            .nodes
            .iter()
            .position(|n| matches!(n.kind, NodeKind::Station(_)));
        let station = station.expect("a station");
        let controller: Box<dyn Controller> = Box::new(library(&controlled));
        let options = Options {
            until: Some(60.0),
            ..Options::default()
        };
        let plant = Plant::new(
            Arc::clone(&line),
            BTreeMap::from([(station, controller)]),
            options,
        );
        let trace = plant.expect("a line that fits").run();
        assert_eq!(trace.violations.is_empty(), sound, "{:#?}", trace.findings);
        if sound {
            continue;
        }
        let first = &trace.violations[0];
        assert_eq!((first.node, first.code), (station, ErrorCode::Order));
        assert_eq!(first.rule.as_deref(), Some(RULE));
        assert!(
            first.part.is_some_and(|(number, _)| number == 1),
            "{first:?}"
        );
        let finding = trace
            .findings
            .iter()
            .find(|f| f.code == codes::LINE_VIOLATION);
        let message = &finding.expect("a finding").message;
        for said in [
            "unit refused Workpiece 1 at 0:00:",
            "PickAndPlace: the order `trays` is broken",
        ] {
            assert!(message.contains(said), "{said}: {message}");
        }
    }
}
