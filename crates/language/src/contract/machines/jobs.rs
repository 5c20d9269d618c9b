//! Inputs that an operation sets for the actions that it runs:
//! `operation shift: pick, move(tx = 2, ty = 1), place`.
//!
//! While the operation runs, the input has the value that the operation sets. At other times, it
//! has the value to which the action binds it, if there is one. An action that runs several times
//! in one operation has to get the same values each time, because only the coordinator knows the
//! position in the sequence. To use different values, declare a second action with the same
//! contract.

use super::Parts;
use crate::contract::elaborate::{Findings, VariableTable, nearest};
use crate::contract::scope::duplicate_name;
use crate::contract::shape::leaf_path;
use crate::contract::value::{Term, Type};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{BinaryOp, Domain, Specification, Time, VarId};
use linewright_core::source::SourceMap;
use linewright_syntax::ast::{self, MachineItem};

/// Input values that one operation sets for an action.
pub(super) struct Job<'a> {
    /// Name of the operation.
    pub operation: &'a ast::Name,
    /// Inputs and their values.
    pub arguments: &'a [ast::Argument],
}

/// Returns the name of the component that performs an element of a sequence: `left` for
/// `left.fetch`.
pub(super) fn performer(run: &str) -> &str {
    run.split('.').next().unwrap_or(run)
}

/// Returns one job for each operation that runs an action, in order.
pub(super) fn jobs<'a>(machine: &'a ast::Machine, action: &str) -> Vec<Job<'a>> {
    let mut found = Vec::new();
    for item in &machine.items {
        let MachineItem::Operation { name, sequence, .. } = item else {
            continue;
        };
        let mut runs = sequence
            .iter()
            .filter(|p| performer(&p.name.text) == action);
        if let Some(first) = runs.next() {
            found.push(Job {
                operation: name,
                arguments: &first.arguments,
            });
        } else if sequence.is_empty() && name.text == action {
            found.push(Job {
                operation: name,
                arguments: &[],
            });
        }
    }
    found
}

/// Reports operations that set an unknown input, set an input twice, or set the inputs of one
/// action differently in two runs.
pub(super) fn check(findings: &mut Findings, parts: &Parts<'_>, sources: &SourceMap) {
    for item in &parts.machine.items {
        let MachineItem::Operation { name, sequence, .. } = item else {
            continue;
        };
        for (i, run) in sequence.iter().enumerate() {
            let component = parts
                .components
                .iter()
                .find(|(c, _)| c.name.text == performer(&run.name.text) && !c.is_coordinator());
            if let Some((_, specification)) = component {
                inputs_exist(findings, run, specification);
            }
            let mut earlier = sequence[..i].iter();
            if let Some(first) =
                earlier.find(|p| performer(&p.name.text) == performer(&run.name.text))
                && !same(sources, &first.arguments, &run.arguments)
            {
                findings.push(
                    Diagnostic::error(
                        codes::OPERATION,
                        run.name.span,
                        format!(
                            "`{}` sets the inputs of `{}` differently than in its earlier run",
                            name.text, run.name.text
                        ),
                    )
                    .with_label(first.name.span, "the earlier run")
                    .with_help(format!(
                        "set the same values in both runs, or declare a second action with the contract of `{}`",
                        run.name.text
                    )),
                );
            }
        }
    }
}

fn inputs_exist(findings: &mut Findings, run: &ast::OperationCall, specification: &Specification) {
    let mut known: Vec<&str> = specification
        .inputs()
        .map(|id| leaf_path(&specification.variable(id).name).0)
        .collect();
    known.dedup();
    for (i, argument) in run.arguments.iter().enumerate() {
        let name = &argument.name;
        if !known.contains(&name.text.as_str()) {
            let help = match nearest(&name.text, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its inputs are {}", known.join(", ")),
            };
            findings.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("`{}` has no input `{}`", run.name.text, name.text),
                help,
            );
        }
        let mut earlier = run.arguments[..i].iter().map(|a| &a.name);
        if let Some(first) = earlier.find(|n| n.text == name.text) {
            findings.push(duplicate_name(name, first.span));
        }
    }
}

/// Returns whether two runs have the same arguments, compared as text without regard to white space
/// and order.
fn same(sources: &SourceMap, a: &[ast::Argument], b: &[ast::Argument]) -> bool {
    let words = |x: &ast::Argument| -> Vec<String> {
        let text = sources.text(x.value.span).split_whitespace();
        text.map(str::to_owned).collect()
    };
    let given =
        |y: &ast::Argument, x: &ast::Argument| y.name.text == x.name.text && words(y) == words(x);
    a.len() == b.len() && a.iter().all(|x| b.iter().any(|y| given(y, x)))
}

/// Returns the value of an `operation` input whose type `ty` contains only some of the machine's
/// operations, as is common if there are several coordinators. The value is the running operation
/// if `ty` contains it, otherwise the label `none`. Returns `None` if `ty` has no label `none`, or
/// is the type of the wire itself.
pub(super) fn known_operation(variables: &VariableTable, ty: &Type) -> Option<Term> {
    let (Type::Enum(own), Some(Domain::Enum { labels, .. })) =
        (ty, variables.domains.first()?.as_ref())
    else {
        return None;
    };
    let rest = own.iter().position(|l| l == "none")?;
    if own == labels {
        return None;
    }
    let jobs = own.iter().enumerate().filter(|(i, _)| *i != rest);
    Some(jobs.fold(Term::Int(rest as i64), |otherwise, (i, job)| {
        match runs(variables, job) {
            Some(runs) => Term::choose(runs, Term::Int(i as i64), otherwise),
            None => otherwise,
        }
    }))
}

/// Returns the condition over wires that this operation runs; `None` if there is no such operation.
pub(super) fn runs(variables: &VariableTable, operation: &str) -> Option<Term> {
    let Some(Domain::Enum { labels, .. }) = variables.domains.first()?.as_ref() else {
        return None;
    };
    let value = labels.iter().position(|l| l == operation)?;
    let wire = Term::Var(VarId(0), Time::Now);
    Some(Term::binary(BinaryOp::Eq, wire, Term::Int(value as i64)))
}
