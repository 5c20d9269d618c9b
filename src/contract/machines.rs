//! From a machine's syntax tree and arguments to its model: contracts instantiated, wires laid, expressions resolved.

use super::TaxonomyCode;
use super::elaborate::{Elaborator, Entry};
use super::instantiate::{self, Arguments, instantiate};
use super::machine::{
    ActionTime, Component, Failures, Machine, Operation, PlantInput, PlantSource, Property,
    PropertyKind, RealExpr, Role,
};
use super::scope::{Scope, double};
use super::value::{Dimension, Term, Type, Value, unit};
use crate::diagnostics::{Diagnostic, codes, has_errors};
use crate::gr1::interval::{Interval, interval};
use crate::gr1::{Domain, Expr, Specification, Time, Timing, VarId};
use crate::source::{SourceMap, Span};
use crate::syntax::ast::{self, ExprKind, MachineItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Operations that say nothing else end within so many steps.
const DEFAULT_STEP_LIMIT: u64 = 10_000;

/// The type of a property: what a plant expression sees of it.
#[derive(Debug, Clone)]
pub(super) struct PropertyType {
    /// How it is shown, `deg`; empty for a bare number.
    pub unit: String,
    /// Its finite domain, for truth values, ranges and labels.
    pub domain: Option<Domain>,
    /// How many elements, for an array.
    pub length: Option<usize>,
}

/// The type of a property as it was written.
pub(super) fn property_type<'a>(
    e: &mut Elaborator<'a>,
    domain: &'a ast::Domain,
) -> Option<PropertyType> {
    match &domain.kind {
        ast::DomainKind::Unit(unit) => Some(PropertyType {
            unit: unit.clone(),
            domain: None,
            length: None,
        }),
        ast::DomainKind::Named(name) if name.text == "number" => Some(PropertyType {
            unit: String::new(),
            domain: None,
            length: None,
        }),
        ast::DomainKind::Array(length, of) => {
            let n = e.constant_int(length)?;
            if !(1..=super::elaborate::MAX_EXPANSION).contains(&n) {
                e.error(
                    codes::DOMAIN_EMPTY,
                    length.span,
                    format!("an array has at least one element, not {n}"),
                );
                return None;
            }
            let inner = property_type(e, of)?;
            if inner.length.is_some() {
                e.error(
                    codes::TYPE_MISMATCH,
                    of.span,
                    "arrays of arrays are not known",
                );
                return None;
            }
            Some(PropertyType {
                length: Some(n as usize),
                ..inner
            })
        }
        _ => {
            let (base, length) = e.domain(domain)?;
            Some(PropertyType {
                unit: String::new(),
                domain: Some(base),
                length,
            })
        }
    }
}

/// The value of a property, in its declared unit: a constant, or a list of them for an array.
pub(super) fn property_values<'a>(
    e: &mut Elaborator<'a>,
    ty: &PropertyType,
    value: Option<&'a ast::Expr>,
) -> Option<Vec<f64>> {
    let n = ty.length.unwrap_or(1);
    let Some(value) = value else {
        return Some(vec![ty.domain.as_ref().map_or(0.0, |d| d.low() as f64); n]);
    };
    let expected = ty.domain.as_ref().map(Type::of);
    let expected = match (&expected, ty.length) {
        (Some(t), Some(n)) => Some(Type::Array(Box::new(t.clone()), n)),
        _ => expected,
    };
    let values = match e.value(value, expected.as_ref(), Time::Now)? {
        Value::Array(values) if values.len() == n && ty.length.is_some() => values,
        Value::Array(values) => {
            e.error(
                codes::TYPE_MISMATCH,
                value.span,
                format!("{} values for {n} elements", values.len()),
            );
            return None;
        }
        scalar @ Value::Scalar(..) => vec![scalar; n],
    };
    let (dimension, factor) = unit(&ty.unit);
    let mut numbers = Vec::with_capacity(n);
    for v in values {
        let Value::Scalar(term, found) = v else {
            return None;
        };
        let Some(number) = super::elaborate::constant_real(&term) else {
            e.error(
                codes::NOT_CONSTANT,
                value.span,
                "this has to be known beforehand",
            );
            return None;
        };
        let fits = match (&ty.domain, &found) {
            (Some(d), Type::Int | Type::Bool | Type::Enum(_)) => {
                *d != Domain::Bool && found == Type::Int && Type::of(d) == Type::Int
                    || Type::of(d) == found
            }
            (None, Type::Int) => true,
            (None, Type::Number(d)) => *d == dimension || *d == Dimension::None,
            _ => false,
        };
        if !fits {
            let wanted = ty
                .domain
                .as_ref()
                .map_or_else(|| dimension.word().to_owned(), |d| Type::of(d).describe());
            e.error(
                codes::TYPE_MISMATCH,
                value.span,
                format!("expected {wanted}, found {}", found.describe()),
            );
            return None;
        }
        if let Some(d) = &ty.domain
            && !d.contains(number as i64)
        {
            e.error(
                codes::PROPERTY,
                value.span,
                format!("{number} is outside {}", d.describe()),
            );
            return None;
        }
        // A bare number is in the declared unit already.
        numbers.push(match found {
            Type::Number(d) if d != Dimension::None => number / factor,
            _ => number,
        });
    }
    Some(numbers)
}

/// Brings a property into an elaborator's sight under new ids; gives the ids.
pub(super) fn see_property(e: &mut Elaborator<'_>, name: &str, ty: &PropertyType) -> Vec<VarId> {
    let ids: Vec<VarId> = (0..ty.length.unwrap_or(1))
        .map(|_| {
            let id = VarId(e.domains.len() as u32);
            e.domains.push(ty.domain.clone());
            if ty.domain.is_none() {
                e.units.insert(id, unit(&ty.unit));
            }
            id
        })
        .collect();
    let entry = match ty.length {
        None => Entry::One(ids[0]),
        Some(_) => Entry::Many(ids.clone()),
    };
    e.variables.insert(name.to_owned(), entry);
    ids
}

/// The names of a property's elements.
pub(super) fn element_names(name: &str, ty: &PropertyType) -> Vec<String> {
    match ty.length {
        None => vec![name.to_owned()],
        Some(n) => (0..n).map(|i| format!("{name}[{i}]")).collect(),
    }
}

/// A real expression assigned to a property: a value with a dimension is converted to the property's unit, a bare number is
/// taken to be in it.
pub(super) fn assigned<'a>(
    e: &mut Elaborator<'a>,
    ty: &PropertyType,
    value: &'a ast::Expr,
) -> Option<Term> {
    let expected = ty.domain.as_ref().map(Type::of);
    let (term, found) = e.any_scalar(value, expected.as_ref(), Time::Now)?;
    let (dimension, factor) = unit(&ty.unit);
    match (&expected, &found) {
        (Some(want), _) if want == &found => Some(term),
        (Some(Type::Int), Type::Number(Dimension::None)) | (None, Type::Int | Type::Bool) => {
            Some(term)
        }
        (None, Type::Number(d)) if *d == Dimension::None => Some(term),
        (None, Type::Number(d)) if *d == dimension =>
        {
            #[expect(clippy::float_cmp, reason = "base units have exactly the factor 1")]
            if factor == 1.0 {
                Some(term)
            } else {
                Some(Term::Binary(
                    crate::gr1::BinaryOp::Div,
                    Box::new(term),
                    Box::new(Term::Real(factor)),
                ))
            }
        }
        _ => {
            let want = expected.map_or_else(|| dimension.word().to_owned(), |t| t.describe());
            e.error(
                codes::TYPE_MISMATCH,
                value.span,
                format!("expected {want}, found {}", found.describe()),
            );
            None
        }
    }
}

struct Parts<'a> {
    machine: &'a ast::Machine,
    properties: Vec<(Property, Option<Domain>)>,
    /// By name: its first element's index and its type.
    property_types: BTreeMap<String, (usize, PropertyType)>,
    plant: Vec<PlantInput>,
    plant_entries: BTreeMap<String, Vec<usize>>,
    components: Vec<(&'a ast::Component, Arc<Specification>)>,
}

/// A machine with these arguments. `None` when something is wrong; findings say what.
pub(super) fn machine(
    scope: &Scope<'_>,
    sources: &SourceMap,
    machine: &ast::Machine,
    given: &Arguments,
    call: Option<Span>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Machine> {
    let mut e = scope.elaborator();
    e.real = true;
    if instantiate::bind(&mut e, &machine.header.parameters, given, call).is_none() {
        findings.append(&mut e.findings);
        return None;
    }
    for item in &machine.items {
        match item {
            MachineItem::Const(decl) => super::scope::constant(&mut e, decl, &mut Vec::new()),
            MachineItem::Type(decl) => super::scope::type_decl(&mut e, decl),
            _ => {}
        }
    }
    let mut parts = Parts {
        machine,
        properties: Vec::new(),
        property_types: BTreeMap::new(),
        plant: Vec::new(),
        plant_entries: BTreeMap::new(),
        components: Vec::new(),
    };
    let result = build(&mut e, &mut parts, scope, sources);
    let broken = has_errors(&e.findings);
    findings.append(&mut e.findings);
    if broken { None } else { result }
}

fn build<'a>(
    e: &mut Elaborator<'a>,
    parts: &mut Parts<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
) -> Option<Machine> {
    let machine = parts.machine;
    no_doubles(e, machine);
    declare_properties(e, parts);
    instantiate_components(e, parts, scope, sources);
    let operations = operations(e, parts);
    declare_plant(e, parts, &operations);
    if has_errors(&e.findings) {
        return None;
    }
    let properties = parts.properties.len();

    // Wires: the plant's first, then every component's outputs.
    let mut wires = scope_of_wires(e, parts);
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
    e.findings.append(&mut wires.findings);

    let mut model = Machine {
        name: machine.header.name.text.clone(),
        doc: machine.header.doc.clone(),
        codes: machine
            .header
            .codes
            .iter()
            .map(|c| TaxonomyCode {
                text: c.text.clone(),
                span: c.span,
            })
            .collect(),
        components,
        plant: parts.plant.clone(),
        properties: parts.properties.iter().map(|(p, _)| p.clone()).collect(),
        operations,
        writes: Vec::new(),
        done: None,
        step_seconds: 1.0,
        base_watts: 0.0,
        idle_watts: 0.0,
        step_limit: DEFAULT_STEP_LIMIT,
        failures: None,
        span: machine.header.name.span,
    };
    settings(e, parts, &mut model, &mut wires, properties);
    e.findings.append(&mut wires.findings);
    if model.operations.is_empty() != model.done.is_none() {
        e.error_with(
            codes::OPERATION,
            machine.header.name.span,
            if model.done.is_none() {
                "this machine has operations, but does not say when one is done"
            } else {
                "this machine says when an operation is done, but has none"
            },
            "a machine has both `operation ...` and `done ...`, or neither (a belt that is only stepped)",
        );
    }
    Some(model)
}

/// Statements that may stand once, and names that may be declared once.
fn no_doubles(e: &mut Elaborator<'_>, machine: &ast::Machine) {
    let mut names: BTreeMap<&str, Span> = BTreeMap::new();
    let mut operations: BTreeMap<&str, Span> = BTreeMap::new();
    let mut done: Option<Span> = None;
    for item in &machine.items {
        let name = match item {
            MachineItem::Property(t)
            | MachineItem::Parameter(t)
            | MachineItem::Signal(t)
            | MachineItem::Abstract(t) => &t.name,
            MachineItem::Component(c) => &c.name,
            MachineItem::Operation { name, .. } => {
                if let Some(first) = operations.insert(&name.text, name.span) {
                    e.findings.push(double(name, first));
                }
                continue;
            }
            MachineItem::Done(expr) => {
                if let Some(first) = done {
                    e.findings.push(
                        Diagnostic::error(codes::NAME_DOUBLE, expr.span, "`done` stands twice")
                            .with_label(first, "first here")
                            .with_help("join the two with `or`"),
                    );
                }
                done = Some(expr.span);
                continue;
            }
            _ => continue,
        };
        if let Some(first) = names.insert(&name.text, name.span) {
            e.findings.push(double(name, first));
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
            continue;
        };
        let Some(values) = property_values(e, &ty, typed.values.first()) else {
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
        see_property(e, &typed.name.text, &ty);
        parts
            .property_types
            .insert(typed.name.text.clone(), (first, ty));
    }
}

fn instantiate_components<'a>(
    e: &mut Elaborator<'a>,
    parts: &mut Parts<'a>,
    scope: &Scope<'_>,
    sources: &SourceMap,
) {
    let items = parts.machine.items.iter().filter_map(|i| match i {
        MachineItem::Component(c) => Some(c),
        _ => None,
    });
    let mut ordered: Vec<&'a ast::Component> = items.collect();
    let coordinators = ordered.iter().filter(|c| c.coordinator).count();
    if coordinators > 1
        && let Some(second) = ordered.iter().filter(|c| c.coordinator).nth(1)
    {
        e.error_with(
            codes::COORDINATOR_KIND,
            second.name.span,
            "a machine has one coordinator",
            "make the second one an `action`, or put it into a machine of its own",
        );
    }
    ordered.sort_by_key(|c| !c.coordinator);
    if ordered.is_empty() {
        e.error_with(
            codes::OPERATION,
            parts.machine.header.name.span,
            "this machine has no component",
            "add `action name: Contract`",
        );
    }
    for c in ordered {
        let Some(contract) = scope.contracts.get(c.contract.text.as_str()) else {
            let known = scope.contracts.keys().copied();
            let help = match super::elaborate::nearest(&c.contract.text, known) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "import the file that declares it".to_owned(),
            };
            e.error_with(
                codes::NAME_UNKNOWN,
                c.contract.span,
                format!("there is no contract `{}`", c.contract.text),
                help,
            );
            continue;
        };
        let given = instantiate::arguments(
            e,
            &contract.header.parameters,
            &c.arguments,
            &c.contract.text,
        );
        // What is wrong within the contract is reported once, with the contract; here only what the call gets wrong.
        let mut found = Vec::new();
        let instance = instantiate(
            scope,
            sources,
            contract,
            &given,
            Some(c.contract.span),
            &mut found,
        );
        let calls = found.into_iter().filter(|d| {
            d.span.is_some_and(|s| {
                s.file == c.contract.span.file
                    && s.start >= c.name.span.start
                    && parts.machine.header.name.span.start < s.start
            }) && d.code == codes::ARGUMENT
        });
        let before = e.findings.len();
        e.findings.extend(calls);
        match instance {
            Some(instance) => parts.components.push((c, instance.specification)),
            None if e.findings.len() == before => e.error_with(
                codes::NAME_UNKNOWN,
                c.contract.span,
                format!(
                    "the contract `{}` cannot be used with these arguments",
                    c.contract.text
                ),
                format!(
                    "see the findings of `{}`, or other arguments",
                    c.contract.text
                ),
            ),
            None => {}
        }
    }
    for (c, s) in &parts.components {
        if c.coordinator && s.timing != Timing::Moore {
            e.findings.push(
                Diagnostic::error(
                    codes::COORDINATOR_KIND,
                    c.contract.span,
                    format!("the coordinator `{}` is not a `moore` contract", c.name.text),
                )
                .with_help(format!(
                    "write `moore contract {}`: a coordinator answers before it sees what the actions do in the same step",
                    c.contract.text
                )),
            );
        }
    }
}

/// The jobs, and the plant wire that selects one: wire 0.
fn operations<'a>(e: &mut Elaborator<'a>, parts: &mut Parts<'a>) -> Vec<Operation> {
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
        return Vec::new();
    }
    // The type of the input that is bound to `operation` is the type of the wire.
    let bound = parts.components.iter().find_map(|(c, s)| {
        c.bindings.iter().find_map(|b| {
            let is_operation = matches!(&b.value.kind, ExprKind::Path(p) if p.len() == 1 && p[0].text == "operation");
            let input = s.inputs().map(|id| s.variable(id)).find(|v| v.name == b.name.text)?;
            match (&input.domain, is_operation) {
                (Domain::Enum { labels, .. }, true) => Some((input.domain.clone(), labels.clone(), input.span)),
                _ => None,
            }
        })
    });
    let (domain, labels) = match &bound {
        Some((domain, labels, _)) => (domain.clone(), labels.clone()),
        None => {
            let labels: Vec<String> = std::iter::once("none".to_owned())
                .chain(declared.iter().map(|(n, ..)| n.text.clone()))
                .collect();
            (
                Domain::Enum {
                    name: None,
                    labels: labels.clone(),
                },
                labels,
            )
        }
    };
    let span = declared[0].0.span;
    parts.plant.push(PlantInput {
        name: "operation".to_owned(),
        domain,
        source: PlantSource::Operation,
        span,
    });
    parts.plant_entries.insert("operation".to_owned(), vec![0]);
    let mut result = Vec::new();
    for (name, code_names, sequence) in declared {
        let Some(value) = labels.iter().position(|l| *l == name.text) else {
            let mut finding = Diagnostic::error(
                codes::OPERATION,
                name.span,
                format!("the coordinator does not know the job `{}`", name.text),
            )
            .with_help(format!("its jobs are {}", labels.join(", ")));
            if let Some((_, _, span)) = &bound
                && span.file == name.span.file
            {
                finding = finding.with_label(*span, "the job is chosen here");
            }
            e.findings.push(finding);
            continue;
        };
        let mut indices = Vec::new();
        for action in sequence {
            match parts
                .components
                .iter()
                .position(|(c, _)| c.name.text == action.text && !c.coordinator)
            {
                Some(i) => indices.push(i),
                None => e.error_with(
                    codes::NAME_UNKNOWN,
                    action.span,
                    format!("this machine has no action `{}`", action.text),
                    "name actions of this machine, in the order in which they run",
                ),
            }
        }
        if sequence.is_empty() {
            match parts
                .components
                .iter()
                .position(|(c, _)| c.name.text == name.text && !c.coordinator)
            {
                Some(i) => indices.push(i),
                None => e.error_with(
                    codes::OPERATION,
                    name.span,
                    format!("no action is called `{}`", name.text),
                    "name the actions after a colon: `operation emptying: pick, turn, place`",
                ),
            }
        }
        result.push(Operation {
            name: name.text.clone(),
            codes: instantiate::taxonomy_codes(code_names, &mut e.findings),
            sequence: indices,
            value: value as i64,
            span: name.span,
        });
    }
    result
}

fn declare_plant<'a>(e: &mut Elaborator<'a>, parts: &mut Parts<'a>, operations: &[Operation]) {
    let _ = operations;
    let properties = parts.properties.len();
    for item in &parts.machine.items {
        let (typed, signal) = match item {
            MachineItem::Signal(t) => (t, true),
            MachineItem::Abstract(t) => (t, false),
            _ => continue,
        };
        let Some((domain, length)) = e.domain(&typed.domain) else {
            continue;
        };
        let n = length.unwrap_or(1);
        let mut sources: Vec<PlantSource> = Vec::new();
        if signal {
            let ty = Type::of(&domain);
            let mut script = Vec::new();
            for value in &typed.values {
                match e.scalar(value, &ty) {
                    Some(Term::Int(i)) if domain.contains(i) => script.push(i),
                    Some(Term::Int(i)) => e.error(
                        codes::ARGUMENT,
                        value.span,
                        format!("{} is outside {}", domain.show(i), domain.describe()),
                    ),
                    Some(_) => e.error(
                        codes::NOT_CONSTANT,
                        value.span,
                        "a signal's script is made of constants",
                    ),
                    None => {}
                }
            }
            if script.is_empty() {
                continue;
            }
            sources = vec![PlantSource::Signal { script }; n];
        } else if let Some(value) = typed.values.first() {
            let element = PropertyType {
                unit: String::new(),
                domain: Some(domain.clone()),
                length: None,
            };
            match (&value.kind, length) {
                (_, None) => {
                    if let Some(term) = assigned(e, &element, value) {
                        sources.push(PlantSource::Property(term.to_real(properties)));
                    }
                }
                (ExprKind::List(members), Some(_)) => {
                    for m in members {
                        if let Some(term) = assigned(e, &element, m) {
                            sources.push(PlantSource::Property(term.to_real(properties)));
                        }
                    }
                    if members.len() != n {
                        e.error(
                            codes::TYPE_MISMATCH,
                            value.span,
                            format!("{} values for {n} elements", members.len()),
                        );
                        continue;
                    }
                }
                (_, Some(_)) => match e.value(value, None, Time::Now) {
                    Some(Value::Array(values)) if values.len() == n => {
                        for v in values {
                            if let Value::Scalar(term, _) = v {
                                sources.push(PlantSource::Property(term.to_real(properties)));
                            }
                        }
                    }
                    Some(other) => e.error(
                        codes::TYPE_MISMATCH,
                        value.span,
                        format!("expected an array of {n}, found {}", other.ty().describe()),
                    ),
                    None => {}
                },
            }
        }
        if sources.len() != n {
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
                source,
                span: typed.name.span,
            });
        }
        parts.plant_entries.insert(typed.name.text.clone(), entries);
    }
}

/// An elaborator for bindings: whole-number expressions over wires.
fn scope_of_wires<'a>(e: &Elaborator<'a>, parts: &Parts<'a>) -> Elaborator<'a> {
    let mut w = Elaborator::new();
    w.constants.clone_from(&e.constants);
    w.types.clone_from(&e.types);
    w.named_domains.clone_from(&e.named_domains);
    for input in &parts.plant {
        w.domains.push(Some(input.domain.clone()));
    }
    for (name, wires) in &parts.plant_entries {
        let is_array = parts.plant[wires[0]].name != *name;
        let entry = if is_array {
            Entry::Many(wires.iter().map(|w| VarId(*w as u32)).collect())
        } else {
            Entry::One(VarId(wires[0] as u32))
        };
        w.variables.insert(name.clone(), entry);
    }
    for (c, s) in &parts.components {
        let mut arrays: BTreeMap<String, Vec<VarId>> = BTreeMap::new();
        for id in s.outputs() {
            let variable = s.variable(id);
            let wire = VarId(w.domains.len() as u32);
            w.domains.push(Some(variable.domain.clone()));
            match variable.name.split_once('[') {
                Some((array, _)) => arrays
                    .entry(format!("{}.{array}", c.name.text))
                    .or_default()
                    .push(wire),
                None => {
                    w.variables.insert(
                        format!("{}.{}", c.name.text, variable.name),
                        Entry::One(wire),
                    );
                }
            }
        }
        for (name, ids) in arrays {
            w.variables.insert(name, Entry::Many(ids));
        }
    }
    w
}

/// One component: every input bound, no same-step loop, its times and powers.
fn component<'a>(
    e: &mut Elaborator<'a>,
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    index: usize,
    firsts: &[usize],
) -> Option<Component> {
    let (decl, specification) = &parts.components[index];
    let mut known: Vec<&str> = specification
        .inputs()
        .map(|id| {
            specification
                .variable(id)
                .name
                .split('[')
                .next()
                .unwrap_or("")
        })
        .collect();
    known.dedup();
    for b in &decl.bindings {
        if !known.contains(&b.name.text.as_str()) {
            let help = match super::elaborate::nearest(&b.name.text, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its inputs are {}", known.join(", ")),
            };
            wires.error_with(
                codes::NAME_UNKNOWN,
                b.name.span,
                format!("`{}` has no input `{}`", decl.contract.text, b.name.text),
                help,
            );
        }
    }
    let mut bindings = Vec::new();
    for id in specification.inputs() {
        let variable = specification.variable(id);
        if let Some(expr) = binding(wires, parts, decl, variable) {
            bindings.push(expr);
        }
    }
    if bindings.len() != specification.inputs().count() {
        return None;
    }
    let active = match (&decl.when, decl.coordinator) {
        (Some(when), false) => wires.boolean(when, Time::Now).and_then(|t| t.to_expr()),
        (Some(when), true) => {
            wires.error(
                codes::OPERATION,
                when.span,
                "a coordinator is never active itself; `when` belongs to actions",
            );
            None
        }
        (None, _) => None,
    };
    // Same-step loops: a Mealy action may read what stands on the wires before it answers.
    if specification.timing == Timing::Mealy {
        let readable = |wire: usize| {
            wire < parts.plant.len()
                || parts.components.iter().enumerate().any(|(i, (_, s))| {
                    let range = firsts[i]..firsts[i] + s.outputs().count();
                    range.contains(&wire) && (s.timing == Timing::Moore || i < index)
                })
        };
        for (expr, id) in bindings.iter().zip(specification.inputs()) {
            let mut offending = None;
            expr.for_each_var(&mut |v, _| {
                if !readable(v.index()) {
                    offending = Some(v.index());
                }
            });
            if let Some(wire) = offending {
                let input = &specification.variable(id).name;
                let owner = firsts.iter().rposition(|f| *f <= wire).unwrap_or(index);
                let other = &parts.components[owner].0.name.text;
                let span = decl
                    .bindings
                    .iter()
                    .find(|b| b.name.text == *input)
                    .map_or(decl.name.span, |b| b.value.span);
                let what = if owner == index {
                    format!("`{}` reads its own output in the same step", decl.name.text)
                } else {
                    format!(
                        "`{}` reads `{other}`, which answers after it in the same step",
                        decl.name.text
                    )
                };
                wires.findings.push(
                    Diagnostic::error(codes::SAME_STEP_LOOP, span, what).with_help(if owner == index {
                        "make the contract `moore`, or drop the feedback".to_owned()
                    } else {
                        format!("declare `{other}` before `{}`, or make one of the two contracts `moore`", decl.name.text)
                    }),
                );
            }
        }
    }
    let properties = parts.properties.len();
    let time = decl.time.as_ref().and_then(|(value, per_step)| {
        let term = e.quantity(value, Dimension::Time)?;
        let real = term.to_real(properties);
        Some(if *per_step {
            ActionTime::PerStep(real)
        } else {
            ActionTime::PerExecution(real)
        })
    });
    let watts = decl
        .power
        .as_ref()
        .and_then(|value| e.quantity(value, Dimension::Power))
        .map_or(RealExpr::Number(0.0), |t| t.to_real(properties));
    if (decl.time.is_some() || decl.power.is_some()) && decl.when.is_none() && !decl.coordinator {
        wires.error_with(
            codes::OPERATION,
            decl.name.span,
            format!(
                "`{}` has a time or a power, but does not say when it is active",
                decl.name.text
            ),
            "add `when`: `action turn: Turn when cell.command = turn { ... }`",
        );
    }
    Some(Component {
        name: decl.name.text.clone(),
        contract: decl.contract.text.clone(),
        role: if decl.coordinator {
            Role::Coordinator
        } else {
            Role::Action
        },
        specification: Arc::clone(specification),
        bindings,
        active,
        time,
        watts,
        span: decl.name.span,
    })
}

/// What an input is bound to: what the file says, else the plant's wire of its name, else the coordinator's output of its name.
fn binding<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    decl: &'a ast::Component,
    variable: &crate::gr1::Variable,
) -> Option<Expr> {
    let (name, element) = match variable.name.split_once('[') {
        Some((name, rest)) => (name, rest.trim_end_matches(']').parse::<usize>().ok()),
        None => (variable.name.as_str(), None),
    };
    let ty = Type::of(&variable.domain);
    let explicit = decl
        .bindings
        .iter()
        .find(|b| {
            b.name.text == name && b.index.is_some() && b.index.map(|i| i as usize) == element
        })
        .or_else(|| {
            decl.bindings
                .iter()
                .find(|b| b.name.text == name && b.index.is_none())
        });
    let (term, span) = if let Some(b) = explicit {
        let term = match (element, b.index) {
            (Some(i), None) => {
                let expected = Type::Array(Box::new(ty.clone()), 0);
                match wires.value(&b.value, Some(&expected), Time::Now)? {
                    Value::Array(values) => match values.into_iter().nth(i) {
                        Some(Value::Scalar(term, found)) if found == ty => term,
                        Some(other) => {
                            wires.error(
                                codes::TYPE_MISMATCH,
                                b.value.span,
                                format!(
                                    "`{}` is {}, not {}",
                                    variable.name,
                                    ty.describe(),
                                    other.ty().describe()
                                ),
                            );
                            return None;
                        }
                        None => {
                            wires.error(
                                codes::TYPE_MISMATCH,
                                b.value.span,
                                format!("there is no element {i} for `{}`", variable.name),
                            );
                            return None;
                        }
                    },
                    Value::Scalar(term, found) if found == ty => term,
                    other @ Value::Scalar(..) => {
                        wires.error(
                            codes::TYPE_MISMATCH,
                            b.value.span,
                            format!(
                                "`{name}` is an array, each element {}; this is {}",
                                ty.describe(),
                                other.ty().describe()
                            ),
                        );
                        return None;
                    }
                }
            }
            _ => wires.scalar(&b.value, &ty)?,
        };
        (term, b.value.span)
    } else {
        let coordinator = parts
            .components
            .first()
            .filter(|(c, _)| c.coordinator && c.name.text != decl.name.text)
            .map(|(c, _)| format!("{}.{name}", c.name.text));
        let entry = wires
            .variables
            .get(name)
            .cloned()
            .or_else(|| coordinator.and_then(|c| wires.variables.get(&c).cloned()));
        let id = match (entry, element) {
            (Some(Entry::One(id)), None) => Some(id),
            (Some(Entry::Many(ids)), Some(i)) => ids.get(i).copied(),
            _ => None,
        };
        let Some(id) = id else {
            wires.error_with(
                codes::INPUT_UNBOUND,
                decl.name.span,
                format!("the input `{}` of `{}` is bound to nothing", variable.name, decl.name.text),
                format!("write `{name} = ...` in `{}`: another component's output, a `signal`, an `abstract` of a property, or `operation`", decl.name.text),
            );
            return None;
        };
        let domain = wires.domains[id.index()].clone()?;
        if Type::of(&domain) != ty {
            wires.error_with(
                codes::TYPE_MISMATCH,
                decl.name.span,
                format!(
                    "the input `{}` of `{}` is {}, but what has its name is {}",
                    variable.name,
                    decl.name.text,
                    ty.describe(),
                    Type::of(&domain).describe()
                ),
                format!("bind it: `{name} = ...`"),
            );
            return None;
        }
        (Term::Var(id, Time::Now), decl.name.span)
    };
    let expr = term.to_expr()?;
    let range = interval(&expr, &|v| {
        wires.domains[v.index()]
            .as_ref()
            .map_or(Interval::BOOL, Interval::of)
    })
    .unwrap_or(Interval::BOOL);
    if range.low < variable.domain.low() || range.high > variable.domain.high() {
        wires.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!(
                "this can be {}..{}, but the input `{}` takes {} only",
                range.low,
                range.high,
                variable.name,
                variable.domain.describe()
            ),
            "hold it there with `min` and `max`, or give both the same range",
        );
        return None;
    }
    Some(expr)
}

/// Everything of a machine that is a number or a plant expression.
fn settings<'a>(
    e: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    model: &mut Machine,
    wires: &mut Elaborator<'a>,
    properties: usize,
) {
    // Writes see properties and wires: wires get ids after the properties.
    let mut both = Elaborator::new();
    both.real = true;
    both.constants.clone_from(&e.constants);
    both.types.clone_from(&e.types);
    both.named_domains.clone_from(&e.named_domains);
    both.domains.clone_from(&e.domains);
    both.units.clone_from(&e.units);
    both.variables.clone_from(&e.variables);
    both.domains.extend(wires.domains.iter().cloned());
    let shift = |id: &VarId| VarId(id.0 + properties as u32);
    for (name, entry) in &wires.variables {
        let entry = match entry {
            Entry::One(id) => Entry::One(shift(id)),
            Entry::Many(ids) => Entry::Many(ids.iter().map(shift).collect()),
        };
        both.variables.entry(name.clone()).or_insert(entry);
    }
    for item in &parts.machine.items {
        match item {
            MachineItem::Step(x) => {
                if let Some(v) = positive(e, x, Dimension::Time) {
                    model.step_seconds = v;
                }
            }
            MachineItem::Power(x) => {
                if let Some(v) = positive(e, x, Dimension::Power) {
                    model.base_watts = v;
                }
            }
            MachineItem::IdlePower(x) => {
                if let Some(v) = positive(e, x, Dimension::Power) {
                    model.idle_watts = v;
                }
            }
            MachineItem::Limit(x) => match e.constant_int(x) {
                Some(n) if n > 0 => model.step_limit = n as u64,
                Some(_) => e.error(codes::ARGUMENT, x.span, "the step limit is at least 1"),
                None => {}
            },
            MachineItem::Failures(mtbf, mttr) => model.failures = failures(e, mtbf, mttr),
            MachineItem::Done(x) => {
                model.done = wires.boolean(x, Time::Now).and_then(|t| t.to_expr());
            }
            MachineItem::Write { name, index, value } => {
                let Some((first, ty)) = parts.property_types.get(&name.text) else {
                    let known = parts.property_types.keys().map(String::as_str);
                    let help = match super::elaborate::nearest(&name.text, known) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("declare it: `property {}: number`", name.text),
                    };
                    e.error_with(
                        codes::PROPERTY,
                        name.span,
                        format!("the part has no property `{}`", name.text),
                        help,
                    );
                    continue;
                };
                let element = PropertyType {
                    length: None,
                    ..ty.clone()
                };
                match (ty.length, index) {
                    (None, None) => {
                        if let Some(term) = assigned(&mut both, &element, value) {
                            model.writes.push((*first, term.to_real(properties)));
                        }
                    }
                    (Some(n), Some(index)) => {
                        let Some(i) = e.constant_int(index) else {
                            continue;
                        };
                        if !(0..n as i64).contains(&i) {
                            e.error(
                                codes::INDEX_RANGE,
                                index.span,
                                format!("indices of `{}` are 0..{}", name.text, n - 1),
                            );
                            continue;
                        }
                        if let Some(term) = assigned(&mut both, &element, value) {
                            model
                                .writes
                                .push((first + i as usize, term.to_real(properties)));
                        }
                    }
                    (Some(n), None) => match both.value(value, None, Time::Now) {
                        Some(Value::Array(values)) if values.len() == n => {
                            for (i, v) in values.into_iter().enumerate() {
                                if let Value::Scalar(term, _) = v {
                                    model.writes.push((first + i, term.to_real(properties)));
                                }
                            }
                        }
                        Some(other) => both.error(
                            codes::TYPE_MISMATCH,
                            value.span,
                            format!("expected an array of {n}, found {}", other.ty().describe()),
                        ),
                        None => {}
                    },
                    (None, Some(index)) => e.error(
                        codes::TYPE_MISMATCH,
                        index.span,
                        format!("`{}` is not an array", name.text),
                    ),
                }
            }
            _ => {}
        }
    }
    e.findings.append(&mut both.findings);
}

/// A quantity that is not negative.
pub(super) fn positive<'a>(
    e: &mut Elaborator<'a>,
    x: &'a ast::Expr,
    dimension: Dimension,
) -> Option<f64> {
    let value = e.constant_quantity(x, dimension)?;
    if value < 0.0 || !value.is_finite() {
        e.error(codes::ARGUMENT, x.span, "this must not be negative");
        return None;
    }
    Some(value)
}

/// `mtbf a mttr b`
pub(super) fn failures<'a>(
    e: &mut Elaborator<'a>,
    mtbf: &'a ast::Expr,
    mttr: &'a ast::Expr,
) -> Option<Failures> {
    let (a, b) = (
        positive(e, mtbf, Dimension::Time),
        positive(e, mttr, Dimension::Time),
    );
    let (a, b) = (a?, b?);
    if a == 0.0 {
        e.error(
            codes::ARGUMENT,
            mtbf.span,
            "the mean time between failures is longer than 0",
        );
        return None;
    }
    Some(Failures { mtbf: a, mttr: b })
}
