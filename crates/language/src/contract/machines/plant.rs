//! Resolution of operations and plant inputs: the wire `operation`, signals, and abstractions of
//! properties.

use super::Parts;
use super::jobs::performer;
use super::properties::{PropertyType, assigned, assigned_array};
use crate::contract::elaborate::{Elaborator, Findings, nearest};
use crate::contract::instantiate::taxonomy_codes;
use crate::contract::machine::{Operation, PlantInput, PlantSource};
use crate::contract::shape::measured;
use crate::contract::value::Term;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Domain;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, ExprKind, Machine, MachineItem, OperationCall};

/// Index of a component that an operation runs and, if the component is a machine, the index of the
/// operation that this machine performs.
type Run = (usize, Option<usize>);

/// Resolves the operations, and adds the plant wire that selects one (wire 0). Also returns, for
/// each operation, the components that it runs.
pub(super) fn operations(
    findings: &mut Findings,
    parts: &mut Parts<'_>,
) -> (Vec<Operation>, Vec<Vec<Run>>) {
    let mut declared = Vec::new();
    for item in &parts.machine.items {
        if let MachineItem::Operation {
            name,
            codes,
            sequence,
        } = item
        {
            declared.push((name, codes, sequence));
        }
    }
    if declared.is_empty() {
        return (Vec::new(), Vec::new());
    }
    // The type of the wire is the type of the input that is bound to `operation`. If there are
    // several such types, the wire has the labels of all of them.
    let mut bound: Vec<(Domain, Span)> = Vec::new();
    for (c, s) in &parts.components {
        let chosen = c.bindings.iter().filter(|b| is_operation(&b.value));
        for b in chosen {
            let mut inputs = s.inputs().map(|id| s.variable(id));
            if let Some(input) = inputs.find(|v| v.name == b.name.text)
                && matches!(input.domain, Domain::Enum { .. })
                && !bound.iter().any(|(d, _)| *d == input.domain)
            {
                bound.push((input.domain.clone(), input.span));
            }
        }
    }
    let mut labels: Vec<String> = vec!["none".to_owned()];
    for (domain, _) in &bound {
        if let Domain::Enum { labels: known, .. } = domain {
            labels.extend(
                known
                    .iter()
                    .filter(|l| !labels.contains(l))
                    .cloned()
                    .collect::<Vec<_>>(),
            );
        }
    }
    let domain = match bound.as_slice() {
        [(domain, _)] => domain.clone(),
        [] => {
            labels.extend(declared.iter().map(|(n, ..)| n.text.clone()));
            Domain::Enum {
                name: None,
                labels: labels.clone(),
            }
        }
        _ => Domain::Enum {
            name: None,
            labels: labels.clone(),
        },
    };
    if let ([(_, _)], Domain::Enum { labels: own, .. }) = (bound.as_slice(), &domain) {
        labels.clone_from(own);
    }
    let span = declared[0].0.span;
    parts.plant.push(PlantInput {
        name: "operation".to_owned(),
        domain,
        unit: String::new(),
        source: PlantSource::Operation,
        span,
    });
    parts.plant_entries.insert("operation".to_owned(), vec![0]);
    let mut result = Vec::new();
    let mut performed = Vec::new();
    for (name, code_names, sequence) in declared {
        let Some(value) = labels.iter().position(|l| *l == name.text) else {
            let mut finding = Diagnostic::error(
                codes::OPERATION,
                name.span,
                match bound.len() {
                    0 | 1 => format!(
                        "the coordinator does not know the operation `{}`",
                        name.text
                    ),
                    _ => format!("no coordinator knows the operation `{}`", name.text),
                },
            )
            .with_help(format!("the known operations are {}", labels.join(", ")));
            if let [(_, span)] = bound.as_slice()
                && span.file == name.span.file
            {
                finding = finding.with_label(*span, "they are declared here");
            }
            findings.push(finding);
            continue;
        };
        let mut runs: Vec<Run> = Vec::new();
        for OperationCall { name: action, .. } in sequence {
            runs.extend(run(findings, parts, action, false));
        }
        if sequence.is_empty() {
            runs.extend(run(findings, parts, name, true));
        }
        result.push(Operation {
            name: name.text.clone(),
            codes: taxonomy_codes(code_names, &mut findings.list),
            sequence: runs.iter().map(|(component, _)| *component).collect(),
            value: value as i64,
            span: name.span,
        });
        performed.push(runs);
    }
    (result, performed)
}

/// Resolves a name in a sequence. `alone` tells whether the operation has no sequence, so that
/// `name` is the name of the operation itself.
fn run(findings: &mut Findings, parts: &Parts<'_>, name: &ast::Name, alone: bool) -> Option<Run> {
    let who = performer(&name.text);
    let is = |(c, _): &(&ast::Component, _)| c.name.text == who && !c.is_coordinator();
    if let Some(place) = parts.components.iter().position(is) {
        return match &parts.nested[place] {
            Some(nested) => Some((place, Some(nested.operation(findings, name)?))),
            None if who == name.text => Some((place, None)),
            None => {
                findings.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("`{who}` is an action, which has no operations"),
                    format!("write `{who}`"),
                );
                None
            }
        };
    }
    if is_action(parts.machine, who) {
        findings.tainted = true;
        return None;
    }
    if alone {
        findings.error_with(
            codes::OPERATION,
            name.span,
            format!("there is no action `{who}`"),
            "list the actions after a colon: `operation emptying: pick, turn, place`",
        );
        return None;
    }
    let known = parts
        .components
        .iter()
        .filter(|(c, _)| !c.is_coordinator())
        .map(|(c, _)| c.name.text.as_str());
    let help = match nearest(who, known) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "list the actions of this machine in the order in which they run".to_owned(),
    };
    findings.error_with(
        codes::NAME_UNKNOWN,
        name.span,
        format!("this machine has no action `{who}`"),
        help,
    );
    None
}

/// Returns whether the value of a binding is just the wire `operation`.
pub(super) fn is_operation(value: &ast::Expr) -> bool {
    matches!(&value.kind, ExprKind::Path(p) if p.len() == 1 && p[0].text == "operation")
}

/// Resolves signals and abstractions, and adds their wires.
pub(super) fn declare_plant<'a>(e: &mut Elaborator<'a>, parts: &mut Parts<'a>) {
    let properties = parts.properties.len();
    for item in &parts.machine.items {
        let (typed, signal) = match item {
            MachineItem::Signal(t) => (t, true),
            MachineItem::Abstract(t) => (t, false),
            _ => continue,
        };
        let Some((domain, unit, length)) = e.measured_domain(&typed.domain) else {
            e.names.broken.insert(typed.name.text.clone());
            continue;
        };
        let n = length.unwrap_or(1);
        let mut sources: Vec<PlantSource> = Vec::new();
        if signal {
            // The values of a script are whole numbers, as in a contract.
            let real_values = e.dialect.real && unit.is_none();
            let real = std::mem::replace(&mut e.dialect.real, real_values);
            let ty = measured(&domain, unit);
            let mut script = Vec::new();
            for value in &typed.values {
                match e.scalar(value, &ty) {
                    Some(Term::Int(i)) if domain.contains(i) => script.push(i),
                    Some(Term::Int(i)) => e.findings.error_with(
                        codes::ARGUMENT,
                        value.span,
                        format!("{} is outside {}", domain.show(i), domain.describe()), "use a value in this range, or extend the range"),
                    Some(_) => e.findings.error_with(
                        codes::NOT_CONSTANT,
                        value.span,
                        "the values of a signal have to be constant", "use numbers, constants and parameters; use `abstract` for a value that depends on the part"),
                    None => {}
                }
            }
            e.dialect.real = real;
            if script.is_empty() {
                continue;
            }
            sources = vec![PlantSource::Signal { script }; n];
        } else if let Some(value) = typed.values.first() {
            let element = PropertyType {
                unit: unit.map(|u| u.name().to_owned()).unwrap_or_default(),
                domain: Some(domain.clone()),
                length: None,
            };
            let terms = match length {
                None => assigned(e, &element, value).map(|t| vec![t]),
                Some(n) => assigned_array(e, &element, n, value),
            };
            for term in terms.unwrap_or_default() {
                sources.push(PlantSource::Property(term.to_real(properties)));
            }
        }
        if sources.len() != n {
            e.names.broken.insert(typed.name.text.clone());
            continue;
        }
        let names = match length {
            None => vec![typed.name.text.clone()],
            Some(n) => (0..n)
                .map(|i| format!("{}[{i}]", typed.name.text))
                .collect(),
        };
        let mut entries = Vec::new();
        for (name, source) in names.into_iter().zip(sources) {
            entries.push(parts.plant.len());
            parts.plant.push(PlantInput {
                name,
                domain: domain.clone(),
                unit: unit.map(|u| u.name().to_owned()).unwrap_or_default(),
                source,
                span: typed.name.span,
            });
        }
        parts.plant_entries.insert(typed.name.text.clone(), entries);
    }
}

/// Returns whether the machine declares an action with this name, even if it has errors.
fn is_action(machine: &Machine, name: &str) -> bool {
    machine.items.iter().any(
        |i| matches!(i, MachineItem::Component(c) if !c.is_coordinator() && c.name.text == name),
    )
}
