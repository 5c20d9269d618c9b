//! Machines for cases that the others never reach in their plans: limits of ranges, times of 0,
//! texts cut at every offset, scripts of two values, controllers with holes, functions with several
//! goals. The mutants of the runtime are judged by them ([`super::runtime`]).

use super::machines::{Subject, as_functions};
use crate::controlled::controlled;
use crate::counting;
use crate::fixtures::{jammed, manipulator, op, v};
use linewright::contract::machine::{
    ActionTime, Machine, PlantSource, RealBinary, RealExpr, RealUnary,
};
use linewright::engine::controller::ExtractionOptions;
use linewright::gr1::{BinaryOp, Domain};
use linewright::mealy;
use std::sync::Arc;

/// Indices of the manipulator's components, plant inputs and properties.
const TURN: usize = 1;
const PICK: usize = 2;
const IDLE: usize = 4;
const REQUEST: usize = 0;
const FREE: usize = 3;
const HEIGHT: u32 = 4;
const STEPS: usize = 2;

fn subject(name: &str, mut machine: Machine, controllers: Arc<Vec<mealy::Controller>>) -> Subject {
    name.clone_into(&mut machine.name);
    Subject {
        machine: Arc::new(machine),
        controllers,
    }
}

fn product(a: RealExpr, b: RealExpr) -> RealExpr {
    RealExpr::Binary(RealBinary::Mul, Box::new(a), Box::new(b))
}

/// The counting machine, at its limits.
pub fn edges() -> Subject {
    let (machine, controllers) = counting::counting();
    let mut machine = (*machine).clone();
    // An operation writes the lowest and the highest value of the range, and one beyond either.
    let wish = machine.properties.len() - 2;
    machine.properties[wish].domain = Some(Domain::Range { low: -4, high: 7 });
    // The first property is not written.
    machine.writes.retain(|(property, _)| *property != 0);
    // A binding that can leave its input's domain on both sides.
    machine.components[IDLE].bindings[1] = op(BinaryOp::Add, v(HEIGHT), v(HEIGHT));
    // A time of 0, negative and infinite; infinite power.
    let steps = || RealExpr::Property(STEPS);
    let size = RealExpr::Unary(RealUnary::Abs, Box::new(steps()));
    machine.components[TURN].time = Some(ActionTime::PerStep(product(steps(), size)));
    machine.components[PICK].watts = product(steps(), steps());
    // A time that depends on the first wire before the operation.
    machine.components[PICK].time = Some(ActionTime::PerExecution(RealExpr::Wire(0)));
    machine.plant[FREE].source = PlantSource::Signal { script: vec![1, 0] };
    // Characters of three bytes, starting at each position where one can be cut.
    for (i, component) in machine.components.iter_mut().enumerate() {
        let specification = Arc::make_mut(&mut component.specification);
        for (k, formula) in specification.assumptions.safety.iter_mut().enumerate() {
            let long = format!("{}{}", "x".repeat((i + k) % 3), "\u{2192}".repeat(500));
            formula.requirement = Some(long);
        }
    }
    subject("Edges", machine, controllers)
}

/// An axis that is never free, so that two assumptions are never kept; and a request that comes in
/// the second step.
pub fn blocked() -> Subject {
    let (machine, controllers) = manipulator();
    let mut machine = (*machine).clone();
    machine.plant[FREE].source = PlantSource::Signal { script: vec![0] };
    let mut script = vec![1; 80];
    script[0] = 0;
    machine.plant[REQUEST].source = PlantSource::Signal { script };
    // The first property becomes infinite.
    let steps = || RealExpr::Property(STEPS);
    machine.writes[0].1 = product(steps(), steps());
    subject("Blocked", machine, controllers)
}

/// An axis that is free in the first three steps, with a step limit: the only justice assumption
/// held last `step_limit - 3` steps ago.
pub fn hurried(step_limit: u64) -> Subject {
    let (machine, controllers) = manipulator();
    let mut machine = (*machine).clone();
    machine.step_limit = step_limit;
    let script = vec![1, 1, 1, 0];
    machine.plant[FREE].source = PlantSource::Signal { script };
    for (i, component) in machine.components.iter_mut().enumerate() {
        let specification = Arc::make_mut(&mut component.specification);
        let justice = &mut specification.assumptions.justice;
        justice.retain(|formula| i == TURN && formula.name == "free");
    }
    subject("Hurried", machine, controllers)
}

/// The jammed manipulator without any justice, and with controllers that lack answers or give wrong
/// ones.
pub fn faulty() -> Subject {
    let (machine, controllers) = jammed();
    let mut machine = (*machine).clone();
    for component in &mut machine.components {
        let specification = Arc::make_mut(&mut component.specification);
        specification.assumptions.justice.clear();
    }
    let tables = controllers.iter().map(|c| c.machine().expect("a table"));
    let mut tables: Vec<mealy::Machine> = tables.cloned().collect();
    // The coordinator has no answer once it is done, the picker has states without a transition,
    // the turner turns incorrectly.
    for transitions in &mut tables[0].states {
        if transitions.first().is_some_and(|t| t.output[1] == 1) {
            transitions.clear();
        }
    }
    for transitions in tables[PICK].states.iter_mut().skip(2).step_by(3) {
        transitions.clear();
    }
    // The axis gets this far only in single steps.
    for transition in tables[TURN].states.iter_mut().flatten() {
        if transition.output[0] == 3 {
            transition.output[0] = 0;
        }
    }
    let controllers = tables.into_iter().map(Into::into).collect();
    subject("Faulty", machine, Arc::new(controllers))
}

/// Functions with several goals over domains that do not begin at 0.
pub fn odd() -> Subject {
    let wish = ExtractionOptions {
        functions: true,
        ..ExtractionOptions::default()
    };
    let (machine, controllers) = controlled("tests/station/libraries/odd.lw", "Oddity", wish);
    Subject {
        machine,
        controllers,
    }
}

/// Functions whose first variable with a domain that does not begin at 0 is an output.
pub fn lonely() -> Subject {
    let (machine, controllers) = controlled(
        "tests/station/host/lone.lw",
        "Lonely",
        ExtractionOptions::default(),
    );
    as_functions(&Subject {
        machine,
        controllers,
    })
}
