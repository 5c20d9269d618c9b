//! Plant inputs: the operation, signals, and abstractions of properties.

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

/// A component to run, and its operation if it is a machine.
type Run = (usize, Option<usize>);

/// Returns the operations, each with the components that it runs, and the plant wire that selects
/// one: wire 0.
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
    // The type of the wire is that of the input bound to `operation`; if several coordinators have
    // operations, the wire has those of all.
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
                    0 | 1 => format!("the coordinator does not know the job `{}`", name.text),
                    _ => format!("no coordinator knows the job `{}`", name.text),
                },
            )
            .with_help(format!("its jobs are {}", labels.join(", ")));
            if let [(_, span)] = bound.as_slice()
                && span.file == name.span.file
            {
                finding = finding.with_label(*span, "the job is chosen here");
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

/// Returns what a name in a sequence runs. `alone` tells whether it is the operation's own name.
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
                    format!("`{who}` is an action, and has no operations"),
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
            format!("no action is called `{who}`"),
            "name the actions after a colon: `operation emptying: pick, turn, place`",
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
        None => "name actions of this machine, in the order in which they run".to_owned(),
    };
    findings.error_with(
        codes::NAME_UNKNOWN,
        name.span,
        format!("this machine has no action `{who}`"),
        help,
    );
    None
}

/// Returns whether a binding is the wire with the running operation.
pub(super) fn is_operation(value: &ast::Expr) -> bool {
    matches!(&value.kind, ExprKind::Path(p) if p.len() == 1 && p[0].text == "operation")
}

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
            // A script is counted like a contract's values.
            let counted = e.dialect.real && unit.is_none();
            let real = std::mem::replace(&mut e.dialect.real, counted);
            let ty = measured(&domain, unit);
            let mut script = Vec::new();
            for value in &typed.values {
                match e.scalar(value, &ty) {
                    Some(Term::Int(i)) if domain.contains(i) => script.push(i),
                    Some(Term::Int(i)) => e.findings.error_with(
                        codes::ARGUMENT,
                        value.span,
                        format!("{} is outside {}", domain.show(i), domain.describe()), "use a value of that range, or make the range larger"),
                    Some(_) => e.findings.error_with(
                        codes::NOT_CONSTANT,
                        value.span,
                        "a signal's script is made of constants", "use numbers, constants and parameters; what depends on the part is an `abstract`"),
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

/// Returns whether the machine declares an action of this name, even an unusable one.
fn is_action(machine: &Machine, name: &str) -> bool {
    machine.items.iter().any(
        |i| matches!(i, MachineItem::Component(c) if !c.is_coordinator() && c.name.text == name),
    )
}
