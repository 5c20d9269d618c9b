//! Check of the order in which components read and set wires within a step.
//!
//! A Mealy component reads its inputs before it sets its outputs. It can read only wires that are
//! already set: those of the plant and of Moore components, which are set at the beginning of the
//! step, and those of components that are declared earlier. An inner machine is treated as one
//! Mealy component, with two exceptions: outputs of its Moore components are set at the beginning,
//! and inputs that only its Moore components read can be set later.

use super::Parts;
use crate::contract::elaborate::Findings;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Expr, Timing};

/// Reports inputs that a component reads before they are set. `firsts` contains the first wire of
/// each component.
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
        let is_read_in_step = parts.nested[index]
            .as_ref()
            .is_none_or(|nested| nested.is_read_early(place));
        if !is_read_in_step {
            continue;
        }
        let mut offending = None;
        expr.for_each_var(&mut |v, _| {
            if !is_set_before(parts, index, firsts, v.index()) {
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
                "make the contract `moore`, or remove the feedback".to_owned(),
            )
        } else {
            (
                format!("`{name}` reads `{other}`, which sets its outputs later in the same step"),
                format!(
                    "declare `{other}` before `{name}`, or make one of the two contracts `moore`"
                ),
            )
        };
        findings.push(Diagnostic::error(codes::SAME_STEP_LOOP, span, what).with_help(help));
    }
}

/// Returns whether a wire is set when a component reads it.
fn is_set_before(parts: &Parts<'_>, index: usize, firsts: &[usize], wire: usize) -> bool {
    if wire < parts.plant.len() {
        return true;
    }
    let Some(owner) = firsts.iter().rposition(|f| *f <= wire) else {
        return false;
    };
    let early = parts.nested[owner]
        .as_ref()
        .is_some_and(|nested| nested.early_outputs()[wire - firsts[owner]]);
    early || owner < index || parts.components[owner].1.timing == Timing::Moore
}
