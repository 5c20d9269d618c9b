//! Resolution of machines: instantiates the contracts of components, numbers the wires, and
//! resolves expressions.

mod component;
mod durations;
mod expand;
mod jobs;
mod nested;
mod orders;
mod plant;
mod promises;
mod properties;
mod same_step;
mod settings;

pub(super) use durations::{duration, failures, random_duration};
pub(super) use properties::{
    PropertyType, assigned, declare_property, element_names, property_type, property_values,
};
pub(super) use settings::{assignments, check_written_once, non_negative, out_of_range};

use super::elaborate::{Elaborator, Findings, nearest};
use super::instantiate::{self, Arguments, instantiate};
use super::machine::{Layers, Machine, PlantInput, Property, PropertyKind, Rules};
use super::scope::{self, Decl, Scope, duplicate_name, duplicate_statement};
use component::{component, scope_of_wires};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Domain, Specification, Timing};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, MachineItem};
use nested::{Level, Nested, nested};
use plant::{declare_plant, operations};
use settings::settings;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Default maximum number of steps of an operation.
const DEFAULT_STEP_LIMIT: u64 = 10_000;

/// Declarations of a machine that have been resolved so far.
struct Parts<'a> {
    machine: &'a ast::Machine,
    properties: Vec<(Property, Option<Domain>)>,
    /// Properties by name: index of the first element, and type.
    property_types: BTreeMap<String, (usize, PropertyType)>,
    plant: Vec<PlantInput>,
    /// Plant wires by name: one, or one per element of an array.
    plant_entries: BTreeMap<String, Vec<usize>>,
    /// Components with their contracts; the contract of an inner machine is its view.
    components: Vec<(&'a ast::Component, Arc<Specification>)>,
    /// For every component, the inner machine if the component is one.
    nested: Vec<Option<Nested>>,
    /// Names of the enclosing machines, outermost first, and of this machine.
    path: Vec<&'a str>,
}

/// Resolves a machine with these arguments. Returns `None` if there is an error, which is added to
/// the findings.
pub(super) fn machine(
    scope: &Scope<'_>,
    sources: &SourceMap,
    machine: &ast::Machine,
    given: &Arguments,
    call: Option<Span>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Machine> {
    level(scope, sources, machine, given, call, &[], findings).map(expand::finish)
}

/// Resolves a machine without expanding its inner machines. `path` contains the names of the
/// enclosing machines.
fn level(
    scope: &Scope<'_>,
    sources: &SourceMap,
    machine: &ast::Machine,
    given: &Arguments,
    call: Option<Span>,
    path: &[&str],
    findings: &mut Vec<Diagnostic>,
) -> Option<Level> {
    let mut e = scope.elaborator();
    e.dialect.real = true;
    if instantiate::bind(&mut e, &machine.header.parameters, given, call).is_none() {
        findings.append(&mut e.findings.list);
        return None;
    }
    let decls: Vec<_> = machine
        .items
        .iter()
        .filter_map(|item| match item {
            MachineItem::Const(decl) => Some(Decl::Constant(decl)),
            MachineItem::Type(decl) => Some(Decl::Type(decl)),
            _ => None,
        })
        .collect();
    scope::evaluate_all(&mut e, &decls);
    let mut parts = Parts {
        machine,
        properties: Vec::new(),
        property_types: BTreeMap::new(),
        plant: Vec::new(),
        plant_entries: BTreeMap::new(),
        components: Vec::new(),
        nested: Vec::new(),
        path: [path, &[machine.header.name.text.as_str()]].concat(),
    };
    let result = build(&mut e, &mut parts, scope, sources);
    let broken = e.findings.has_errors();
    findings.append(&mut e.findings.list);
    if broken { None } else { result }
}

fn build<'a>(
    e: &mut Elaborator<'a>,
    parts: &mut Parts<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
) -> Option<Level> {
    let machine = parts.machine;
    report_duplicates(&mut e.findings, machine);
    declare_properties(e, parts);
    instantiate_components(e, parts, scope, sources);
    let (operations, performed) = operations(&mut e.findings, parts);
    jobs::check(&mut e.findings, parts, sources);
    declare_plant(e, parts);
    orders::guarantee(e, parts, scope);
    let mut model = Machine {
        name: machine.header.name.text.clone(),
        doc: machine.header.doc.clone(),
        codes: instantiate::stated_codes(&machine.header),
        components: Vec::new(),
        plant: Vec::new(),
        properties: Vec::new(),
        operations: Vec::new(),
        writes: Vec::new(),
        done: None,
        step_seconds: 1.0,
        base_watts: 0.0,
        idle_watts: 0.0,
        step_limit: DEFAULT_STEP_LIMIT,
        failures: Vec::new(),
        refines: Vec::new(),
        guarantees: Rules::default(),
        orders: Vec::new(),
        layers: Layers::default(),
        span: machine.header.name.span,
    };
    settings::numbers(e, machine, &mut model);
    if e.findings.has_errors() {
        return None;
    }
    let properties = parts.properties.len();

    // Wires: the plant's first, then every component's outputs.
    let mut wires = scope_of_wires(&e.names, parts);
    let mut components = Vec::new();
    let mut first = parts.plant.len();
    let firsts: Vec<usize> = parts
        .components
        .iter()
        .map(|(_, s)| {
            let here = first;
            first += s.outputs().count();
            here
        })
        .collect();
    for index in 0..parts.components.len() {
        let component = component(e, &mut wires, parts, index, &firsts);
        components.extend(component);
    }
    e.findings.absorb(&mut wires.findings);

    model.components = components;
    model.plant.clone_from(&parts.plant);
    model.properties = parts.properties.iter().map(|(p, _)| p.clone()).collect();
    model.operations = operations;
    settings(e, parts, &mut model, &mut wires, properties);
    model.refines = promises::refined_contracts(e, &mut wires, parts, scope, sources);
    model.orders = orders::orders(&mut wires, parts, scope);
    model.guarantees = promises::guarantees(&mut wires, parts, sources);
    for watch in orders::watches(&mut wires.findings, &model) {
        orders::add(&mut model, watch);
        parts.nested.push(None);
    }
    e.findings.absorb(&mut wires.findings);
    let has_done = machine
        .items
        .iter()
        .any(|i| matches!(i, MachineItem::Done(_)));
    let has_operations = machine
        .items
        .iter()
        .any(|i| matches!(i, MachineItem::Operation { .. }));
    if has_operations != has_done {
        e.findings.error_with(
            codes::OPERATION,
            machine.header.name.span,
            if has_operations {
                "this machine has operations, but no `done` condition"
            } else {
                "this machine has a `done` condition, but no operations"
            },
            "write both `operation ...` and `done ...`, or neither for a machine that is only stepped, such as a conveyor",
        );
    }
    Some(Level {
        machine: model,
        nested: std::mem::take(&mut parts.nested),
        performed,
        properties: std::mem::take(&mut parts.property_types),
    })
}

/// Reports names that are declared twice, and second occurrences of statements that are allowed
/// only once.
fn report_duplicates(findings: &mut Findings, machine: &ast::Machine) {
    let parameters = machine.header.parameters.iter().map(|p| &p.name);
    let mut names: BTreeMap<&str, Span> = BTreeMap::new();
    for name in parameters {
        if let Some(first) = names.insert(&name.text, name.span) {
            findings.push(duplicate_name(name, first));
        }
    }
    // Operations have a separate name space, because an operation with a single action can have the
    // name of the action.
    let mut operations: BTreeMap<&str, Span> = BTreeMap::new();
    let mut rules: BTreeMap<&str, Span> = BTreeMap::new();
    let mut once: BTreeMap<&str, Span> = BTreeMap::new();
    for item in &machine.items {
        let name = match item {
            MachineItem::Property(t)
            | MachineItem::Parameter(t)
            | MachineItem::Signal(t)
            | MachineItem::Abstract(t) => &t.name,
            MachineItem::Component(c) => &c.name,
            MachineItem::Guarantee { name, .. } => {
                // Formulas have a separate name space, too.
                let first = name.as_ref().and_then(|n| rules.insert(&n.text, n.span));
                if let (Some(name), Some(first)) = (name, first) {
                    findings.push(duplicate_name(name, first));
                }
                continue;
            }
            MachineItem::Const(c) => &c.name,
            MachineItem::Type(t) => &t.name,
            MachineItem::Operation { name, .. } => {
                if let Some(first) = operations.insert(&name.text, name.span) {
                    findings.push(duplicate_name(name, first));
                }
                continue;
            }
            MachineItem::Done(x)
            | MachineItem::Step(x)
            | MachineItem::IdlePower(x)
            | MachineItem::Power(x)
            | MachineItem::Limit(x) => {
                let (word, help) = match item {
                    MachineItem::Done(_) => ("done", "join the two with `or`"),
                    MachineItem::Step(_) => ("step", "remove one of the two"),
                    MachineItem::IdlePower(_) => ("idle power", "remove one of the two"),
                    MachineItem::Power(_) => ("power", "add the two numbers"),
                    _ => ("limit", "remove one of the two"),
                };
                if let Some(first) = once.insert(word, x.span) {
                    findings.push(duplicate_statement(word, x.span, first, help));
                }
                continue;
            }
            MachineItem::Write { .. }
            | MachineItem::Refines(_)
            | MachineItem::Skills(_)
            | MachineItem::Failures(_) => {
                continue;
            }
        };
        if let Some(first) = names.insert(&name.text, name.span) {
            findings.push(duplicate_name(name, first));
        }
    }
}

fn declare_properties<'a>(e: &mut Elaborator<'a>, parts: &mut Parts<'a>) {
    for item in &parts.machine.items {
        let (typed, kind) = match item {
            MachineItem::Property(t) => (t, PropertyKind::Part),
            MachineItem::Parameter(t) => (t, PropertyKind::Parameter),
            _ => continue,
        };
        let Some(ty) = property_type(e, &typed.domain) else {
            e.names.broken.insert(typed.name.text.clone());
            continue;
        };
        let Some(values) = property_values(e, &ty, typed.values.first()) else {
            e.names.broken.insert(typed.name.text.clone());
            continue;
        };
        let first = parts.properties.len();
        for (name, default) in element_names(&typed.name.text, &ty).into_iter().zip(values) {
            parts.properties.push((
                Property {
                    name,
                    unit: ty.unit.clone(),
                    default,
                    kind,
                    domain: ty.domain.clone(),
                    span: typed.name.span,
                },
                ty.domain.clone(),
            ));
        }
        declare_property(e, &typed.name.text, &ty);
        parts
            .property_types
            .insert(typed.name.text.clone(), (first, ty));
    }
}

/// Instantiates the contract of a component with the component's arguments. Reports an unknown
/// contract and wrong arguments.
fn instance<'a>(
    e: &mut Elaborator<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
    c: &'a ast::Component,
) -> Option<Arc<Specification>> {
    let Some(contract) = scope.contracts.get(c.contract.text.as_str()) else {
        let known = scope.contracts.keys().copied();
        let help = match nearest(&c.contract.text, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "import the file that declares it".to_owned(),
        };
        e.findings.error_with(
            codes::NAME_UNKNOWN,
            c.contract.span,
            format!("there is no contract `{}`", c.contract.text),
            help,
        );
        return None;
    };
    let given = instantiate::arguments(
        e,
        &contract.header.parameters,
        &c.arguments,
        &c.contract.text,
    );
    let mut found = Vec::new();
    let instance = instantiate(
        scope,
        sources,
        contract,
        &given,
        Some(c.contract.span),
        &mut found,
    );
    let instance = checked_call(&mut e.findings, c, found, "contract", instance)?;
    Some(instance.specification)
}

/// Returns the result of instantiating a contract or machine (`what`), and adds the findings that
/// concern the arguments. Errors within the contract or machine are reported at its declaration.
fn checked_call<T>(
    findings: &mut Findings,
    c: &ast::Component,
    found: Vec<Diagnostic>,
    what: &str,
    result: Option<T>,
) -> Option<T> {
    let calls = found.into_iter().filter(|d| {
        let argument = |s: Span| c.arguments.iter().any(|a| a.value.span == s);
        // Machines that contain each other are reported only here.
        d.code == codes::MACHINE_IN_ITSELF
            || d.code == codes::ARGUMENT
                && d.span.is_some_and(|s| s == c.contract.span || argument(s))
    });
    let before = findings.list.len();
    findings.list.extend(calls);
    if result.is_some() {
        return result;
    }
    // If there are no arguments, the error is in the contract or machine itself and was reported at
    // its declaration.
    if c.arguments.is_empty() {
        findings.tainted = true;
    } else if findings.list.len() == before {
        let name = &c.contract.text;
        findings.error_with(
            codes::NAME_UNKNOWN,
            c.contract.span,
            format!("the {what} `{name}` cannot be used with these arguments"),
            format!("correct the errors in `{name}`, or use other arguments"),
        );
    }
    None
}

fn instantiate_components<'a>(
    e: &mut Elaborator<'a>,
    parts: &mut Parts<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
) {
    let mut ordered: Vec<&'a ast::Component> = parts
        .machine
        .items
        .iter()
        .filter_map(|i| match i {
            MachineItem::Component(c) => Some(c),
            _ => None,
        })
        .collect();
    ordered.sort_by_key(|c| !c.is_coordinator());
    if ordered.is_empty() {
        e.findings.error_with(
            codes::OPERATION,
            parts.machine.header.name.span,
            "this machine has no component",
            "add `action name: Contract`",
        );
    }
    for c in ordered {
        if c.is_machine() {
            if let Some((nested, view)) = nested(e, parts, scope, sources, c) {
                parts.components.push((c, view));
                parts.nested.push(Some(nested));
            }
        } else if let Some(specification) = instance(e, scope, sources, c) {
            parts.components.push((c, specification));
            parts.nested.push(None);
        }
    }
    for (c, s) in &parts.components {
        if c.is_coordinator() && s.timing != Timing::Moore {
            e.findings.push(
                Diagnostic::error(
                    codes::COORDINATOR_KIND,
                    c.contract.span,
                    format!("the coordinator `{}` is not a `moore` contract", c.name.text),
                )
                .with_help(format!(
                    "write `moore contract {}`: a coordinator sets its outputs before it sees those of the actions in the same step",
                    c.contract.text
                )),
            );
        }
    }
}
