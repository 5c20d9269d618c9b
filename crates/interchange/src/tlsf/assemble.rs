//! Assembles the sides, the signals and the monitors into a specification.

use super::classify::Classifier;
use super::meaning::Sides;
use linewright_core::gr1::{Domain, Expr, Owner, Side, Specification, Timing, VarId, Variable};
use linewright_core::source::Span;

/// The specification, and a copy with only the file's own assumptions; `None` if there are no
/// others.
pub(super) fn specifications(
    name: &str,
    timing: Timing,
    variables: Vec<Variable>,
    sides: Sides,
    classifier: &Classifier<'_>,
    span: Span,
) -> (Specification, Option<Specification>) {
    let own = (sides.unchanged.all().count() < sides.assumptions.all().count()).then(|| Sides {
        assumptions: sides.unchanged.clone(),
        guarantees: sides.guarantees.clone(),
        unchanged: Side::default(),
    });
    let own =
        own.map(|sides| specification(name, timing, variables.clone(), sides, classifier, span));
    let all = specification(name, timing, variables, sides, classifier, span);
    (all, own)
}

fn specification(
    name: &str,
    timing: Timing,
    mut variables: Vec<Variable>,
    sides: Sides,
    classifier: &Classifier<'_>,
    span: Span,
) -> Specification {
    let Sides {
        assumptions,
        guarantees,
        ..
    } = sides;
    let mut taken: Vec<String> = variables.iter().map(|v| v.name.clone()).collect();
    taken.extend(classifier.monitors.variables().map(|v| v.name.clone()));
    let mut word = "broken".to_owned();
    while taken.contains(&word) {
        word.push('_');
    }
    variables.push(Variable {
        name: word,
        owner: Owner::System,
        internal: true,
        domain: Domain::Bool,
        unit: String::new(),
        span,
    });
    let mut specification = Specification {
        name: name.to_owned(),
        timing,
        variables,
        assumptions,
        guarantees,
    };
    classifier.monitors.add_to(&mut specification);
    remove_unused(&mut specification, classifier.broken);
    specification
}

/// Removes a variable if no formula mentions it.
fn remove_unused(specification: &mut Specification, id: VarId) {
    let sides = [&specification.assumptions, &specification.guarantees];
    let mut used = false;
    for formula in sides.into_iter().flat_map(Side::all) {
        formula.expr.for_each_var(&mut |v, _| used |= v == id);
    }
    if used {
        return;
    }
    specification.variables.remove(id.index());
    for side in [
        &mut specification.assumptions,
        &mut specification.guarantees,
    ] {
        for list in [
            &mut side.initial,
            &mut side.invariants,
            &mut side.safety,
            &mut side.justice,
        ] {
            for formula in list {
                formula.expr = formula
                    .expr
                    .substitute(&mut |v, t| Expr::Var(if v > id { VarId(v.0 - 1) } else { v }, t));
            }
        }
    }
}
