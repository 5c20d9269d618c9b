//! Checks whether a line satisfies what a conveyor's contract assumes, and whether the conveyor
//! keeps every part.
//!
//! In each step, a belt reads the behavior of its neighbors: whether a part waits to come on, and
//! whether the next place would take the first part. A waiting part keeps waiting until it is let
//! on; nothing else is known about these inputs. The other inputs are set by the belt's file.

use super::Calls;
use crate::abstraction::words::{all, any, count, is, later};
use linewright_algebra::machine::of_machine;
use linewright_algebra::proof::{Claim, Exports, decide};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{BinaryOp, Expr, Formula, FormulaKind, Side, VarId};
use linewright_language::contract::line::{Belt, Line, NodeKind};
use linewright_language::contract::machine::{Machine, PlantSource};
use linewright_solver::game::{Limit, Limits};
use linewright_station::messages;

/// Examines the belts of a line.
pub(super) fn examine(line: &Line, limits: &Limits, calls: &mut Calls) {
    for (node, declared) in line.nodes.iter().enumerate() {
        let NodeKind::Conveyor {
            belt: Some(belt), ..
        } = &declared.kind
        else {
            continue;
        };
        if let Some(wire) = constant_outside(&belt.machine) {
            let input = &belt.machine.plant[wire];
            let message = format!(
                "{}: the plant input `{}` gets a value outside {}",
                declared.name,
                input.name,
                input.describe()
            );
            let finding = Diagnostic::error(codes::LINE_REFUSED, declared.span, message)
                .with_label(input.span, "this input")
                .with_help("correct the default of the property that it reads");
            calls.findings.push(finding);
            continue;
        }
        match open(belt, limits) {
            Ok(found) => calls.findings.extend(found.into_iter().map(|what| match what {
                BeltViolation::Assumption(text, formula) => {
                    Diagnostic::warning(
                        codes::LINE_FORBIDDEN_REQUEST,
                        declared.span,
                        format!("{} may be asked for what {text} forbids: {}", declared.name, formula.text),
                    )
                    .with_label(formula.span, "this would be broken")
                    .with_help("a line guarantees only that a part that waits to come on keeps waiting; weaken the assumption")
                }
                BeltViolation::Keeping => Diagnostic::warning(
                    codes::LINE_PART_LOST,
                    declared.span,
                    format!("the contract of {} does not guarantee that parts stay on it, in order, until they are taken", declared.name),
                )
                .with_help("compare the guarantee about each place with those about the places before it"),
            })),
            Err(limit) => calls.undecided.push((node, limit.into())),
        }
    }
}

/// A property that could not be proved from a belt's contracts.
enum BeltViolation {
    /// An assumption, with a description of it.
    Assumption(String, Formula),
    /// The property that every part stays on the belt, in order.
    Keeping,
}

/// Finds a plant input whose constant value is outside its domain.
fn constant_outside(machine: &Machine) -> Option<usize> {
    let defaults: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
    machine.plant.iter().position(|input| match &input.source {
        PlantSource::Property(expr) => !input.domain.contains_real(expr.eval(&defaults, &[])),
        _ => false,
    })
}

fn open(belt: &Belt, limits: &Limits) -> Result<Vec<BeltViolation>, Limit> {
    let machine = &belt.machine;
    let (mut system, claim) = of_machine(machine);
    // Justice is examined elsewhere, with the whole line.
    for part in &mut system.components {
        part.assumptions.justice.clear();
        part.guarantees.justice.clear();
    }
    let assumed = system
        .components
        .iter()
        .any(|p| p.assumptions.formulas().next().is_some());
    let claim = Claim {
        given: given(belt),
        goal: keeping(belt),
        exports: Exports::Never,
        ..claim
    };
    let proof = decide(&system, &claim, limits)?;
    if !proof.loops.is_empty() && assumed {
        return Err(Limit::Size);
    }
    let mut found = Vec::new();
    let mut shown = std::collections::BTreeSet::new();
    for open in proof.open {
        match open.what.component {
            Some(part) => {
                let side = &system.components[part].assumptions;
                let formula = side.list(open.what.kind)[open.what.index].clone();
                let component = &machine.components[part];
                if shown.insert((part, formula.span)) {
                    found.push(BeltViolation::Assumption(
                        messages::describe_assumption(component, &formula),
                        formula,
                    ));
                }
            }
            None if open.what.kind == FormulaKind::Justice => {}
            None => {
                if !found.iter().any(|f| matches!(f, BeltViolation::Keeping)) {
                    found.push(BeltViolation::Keeping);
                }
            }
        }
    }
    Ok(found)
}

fn formula(belt: &Belt, name: &str, expr: &Expr) -> Formula {
    Formula {
        defines: false,
        name: name.to_owned(),
        requirement: None,
        expr: expr.simplify(),
        span: belt.machine.span,
        text: name.to_owned(),
    }
}

/// What the line and the machine's file guarantee to the belt.
fn given(belt: &Belt) -> Side {
    let mut side = Side::default();
    let on = |wire: usize| is(VarId(wire as u32), 1);
    let waits = on(belt.load)
        .and(on(belt.ready).not())
        .implies(later(&on(belt.load)));
    side.safety.push(formula(
        belt,
        "a part that waits to come on keeps waiting",
        &waits,
    ));
    let defaults: Vec<f64> = belt.machine.properties.iter().map(|p| p.default).collect();
    for (wire, input) in belt.machine.plant.iter().enumerate() {
        if wire == belt.load || wire == belt.unload_ready {
            continue;
        }
        let values = match &input.source {
            PlantSource::Signal { script } => script.clone(),
            PlantSource::Property(expr) => vec![expr.eval(&defaults, &[]).round() as i64],
            PlantSource::Operation => vec![input.domain.low()],
        };
        let wire = Expr::now(VarId(wire as u32));
        let known = any(values
            .into_iter()
            .map(|v| wire.clone().equals(Expr::Const(v))));
        side.invariants
            .push(formula(belt, "inputs that the machine's file sets", &known));
    }
    side
}

/// Requires that the number of occupied places equals the number of parts on the belt, and that no
/// part moves backward: the number of parts from each place to the end decreases only by the part
/// that is taken off.
fn keeping(belt: &Belt) -> Side {
    let mut side = Side::default();
    let on = |wire: usize| is(VarId(wire as u32), 1);
    let number = |condition: Expr| count([condition]);
    let none = all(belt.places.iter().map(|p| on(*p).not()));
    side.initial
        .push(formula(belt, "a belt is empty at first", &none));
    let last = belt.places.last().map_or(Expr::FALSE, |p| on(*p));
    let taken = number(on(belt.unload_ready).and(last));
    let comes = number(on(belt.load).and(on(belt.ready)));
    let sub = |a: Expr, b: Expr| Expr::binary(BinaryOp::Sub, a, b);
    let held = count(belt.places.iter().map(|p| on(*p)));
    let after = Expr::binary(BinaryOp::Add, sub(held.clone(), taken.clone()), comes);
    side.safety.push(formula(
        belt,
        "a belt keeps every part",
        &later(&held).equals(after),
    ));
    for place in 1..belt.places.len() {
        let ahead = count(belt.places[place..].iter().map(|p| on(*p)));
        let rest = sub(ahead.clone(), taken.clone());
        let kept = Expr::binary(BinaryOp::Ge, later(&ahead), rest);
        side.safety
            .push(formula(belt, "a belt keeps the order of its parts", &kept));
    }
    side
}
