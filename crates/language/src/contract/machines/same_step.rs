//! Who may read whose answer within a step.
//!
//! A component that reads before it answers may read the wires that are already set: the plant's
//! values, the outputs of Moore components from the beginning of the step, and the answers of
//! components declared earlier. An inner machine is treated as a whole, with two exceptions:
//! outputs of its own Moore components are set from the beginning, and inputs that only those read
//! may come later.

use super::Parts;
use crate::contract::elaborate::Findings;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Expr, Timing};

/// Reports inputs that a component reads too early. `firsts` are the first wires of all components.
pub(super) fn check(
    findings: &mut Findings,
    parts: &Parts<'_>,
    index: usize,
    firsts: &[usize],
    bindings: &[Expr],
) {
    let (decl, specification) = &parts.components[index];
    if specification.timing == Timing::Moore {
        return;
    }
    for (place, (expr, id)) in bindings.iter().zip(specification.inputs()).enumerate() {
        let within_a_step = parts.nested[index]
            .as_ref()
            .is_none_or(|nested| nested.is_read_early(place));
        if !within_a_step {
            continue;
        }
        let mut offending = None;
        expr.for_each_var(&mut |v, _| {
            if !is_there(parts, index, firsts, v.index()) {
                offending = Some(v.index());
            }
        });
        let Some(wire) = offending else {
            continue;
        };
        let input = &specification.variable(id).name;
        let owner = firsts.iter().rposition(|f| *f <= wire).unwrap_or(index);
        let other = &parts.components[owner].0.name.text;
        let name = &decl.name.text;
        let span = decl
            .bindings
            .iter()
            .find(|b| b.name.text == *input)
            .map_or(decl.name.span, |b| b.value.span);
        let (what, help) = if owner == index {
            (
                format!("`{name}` reads its own output in the same step"),
                "make the contract `moore`, or drop the feedback".to_owned(),
            )
        } else {
            (
                format!("`{name}` reads `{other}`, which answers after it in the same step"),
                format!(
                    "declare `{other}` before `{name}`, or make one of the two contracts `moore`"
                ),
            )
        };
        findings.push(Diagnostic::error(codes::SAME_STEP_LOOP, span, what).with_help(help));
    }
}

/// Returns whether a wire is set when a component reads it.
fn is_there(parts: &Parts<'_>, index: usize, firsts: &[usize], wire: usize) -> bool {
    if wire < parts.plant.len() {
        return true;
    }
    let Some(owner) = firsts.iter().rposition(|f| *f <= wire) else {
        return false;
    };
    let early = parts.nested[owner]
        .as_ref()
        .is_some_and(|nested| nested.early()[wire - firsts[owner]]);
    early || owner < index || parts.components[owner].1.timing == Timing::Moore
}
