//! Resolution of a machine's components: bindings of inputs, times and powers.

use super::settings::out_of_range;
use super::{Parts, jobs, nested, plant, same_step};
use crate::contract::elaborate::{Elaborator, Findings, Names, VariableTable, fitted, nearest};
use crate::contract::machine::{ActionTime, Component, RealExpr, Role};
use crate::contract::shape::{Segment, entries_of, leaf_path, measured};
use crate::contract::units::Unit;
use crate::contract::value::{Dimension, Term, Type, Value};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{Expr, Specification, Time, VarId};
use linewright_core::source::Span;
use linewright_syntax::ast;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

/// Returns an elaborator for expressions over the machine's wires.
pub(super) fn scope_of_wires<'a>(outer: &Names<'a>, parts: &Parts<'a>) -> Elaborator<'a> {
    let mut names = outer.without_variables();
    let mut variables = VariableTable::default();
    let mut leaves = Vec::new();
    for input in &parts.plant {
        let wire = variables.add(input.domain.clone(), Unit::named(&input.unit));
        leaves.push((input.name.as_str(), wire));
    }
    for (name, entry) in entries_of(leaves) {
        // A wire hides outer declarations of the same name.
        names.hide(&name);
        names.variables.insert(name, entry);
    }
    for (c, s) in &parts.components {
        let mut leaves = Vec::new();
        for id in s.outputs() {
            let v = s.variable(id);
            let wire = variables.add(v.domain.clone(), Unit::named(&v.unit));
            leaves.push((v.name.as_str(), wire));
        }
        for (name, entry) in entries_of(leaves) {
            names
                .variables
                .insert(format!("{}.{name}", c.name.text), entry);
        }
    }
    Elaborator {
        names,
        variables,
        ..Elaborator::default()
    }
}

/// Resolves a component: its bindings, time and power. Reports unbound inputs, and circular
/// dependencies within a step. `firsts` contains the first wire of each component.
pub(super) fn component<'a>(
    e: &mut Elaborator<'a>,
    wires: &mut Elaborator<'a>,
    parts: &mut Parts<'a>,
    index: usize,
    firsts: &[usize],
) -> Option<Component> {
    if let Some(mut nested) = parts.nested[index].take() {
        let decl = parts.components[index].0;
        nested::reject_settings(&mut e.findings, decl);
        nested.properties = nested::bind_properties(e, parts, decl, &nested);
        parts.nested[index] = Some(nested);
    }
    let parts = &*parts;
    let (decl, specification) = &parts.components[index];
    let mut known: Vec<&str> = specification
        .inputs()
        .map(|id| specification.variable(id).name.as_str())
        .map(|name| leaf_path(name).0)
        .collect();
    known.dedup();
    if let Some(nested) = &parts.nested[index] {
        known.extend(nested.level.properties.keys().map(String::as_str));
    }
    for b in &decl.bindings {
        if !known.contains(&leaf_path(&b.name.text).0) {
            let help = match nearest(&b.name.text, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its inputs are {}", known.join(", ")),
            };
            wires.findings.error_with(
                codes::NAME_UNKNOWN,
                b.name.span,
                format!("`{}` has no input `{}`", decl.contract.text, b.name.text),
                help,
            );
        }
    }
    check_bindings(&mut wires.findings, decl, specification);
    let active = match (&decl.when, decl.is_coordinator()) {
        (Some(when), false) => wires
            .boolean(when, Time::Now)
            .and_then(|t| wires.formula(&t, when.span)),
        (Some(when), true) => {
            wires.findings.error_with(
                codes::OPERATION,
                when.span,
                "`when` is allowed only for actions, and this is a coordinator",
                "remove it here, and write it in each action",
            );
            None
        }
        (None, _) => None,
    };
    let mut bindings = Vec::new();
    for id in specification.inputs() {
        let variable = specification.variable(id);
        if let Some(expr) = binding(wires, parts, decl, specification, variable) {
            bindings.push(expr);
        }
    }
    if bindings.len() != specification.inputs().count() {
        return None;
    }
    same_step::check(&mut wires.findings, parts, index, firsts, &bindings);
    let properties = parts.properties.len();
    let time = decl.time.as_ref().and_then(|(value, per_step)| {
        let term = e.quantity(value, Dimension::Time)?;
        let real = term.to_real(properties);
        report_out_of_range(wires, value, &real, Dimension::Time);
        Some(if *per_step {
            ActionTime::PerStep(real)
        } else {
            ActionTime::PerExecution(real)
        })
    });
    let watts = decl
        .power
        .as_ref()
        .and_then(|value| {
            let real = e.quantity(value, Dimension::Power)?.to_real(properties);
            report_out_of_range(wires, value, &real, Dimension::Power);
            Some(real)
        })
        .unwrap_or(RealExpr::Number(0.0));
    if decl.is_coordinator() {
        warn_without_effect(&mut wires.findings, decl);
    } else if (decl.time.is_some() || decl.power.is_some()) && decl.when.is_none() {
        wires.findings.error_with(
            codes::OPERATION,
            decl.name.span,
            format!(
                "`{}` has a time or a power, but no `when` condition",
                decl.name.text
            ),
            "add `when`: `action turn: Turn when cell.command = turn { ... }`",
        );
    }
    Some(Component {
        name: decl.name.text.clone(),
        contract: decl.contract.text.clone(),
        role: if decl.is_coordinator() {
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

/// Reports a constant time or power that no run supports. The proof of the line reports one that is
/// not finite, together with the part for which this is so.
fn report_out_of_range(
    wires: &mut Elaborator<'_>,
    written: &ast::Expr,
    value: &RealExpr,
    dimension: Dimension,
) {
    if let RealExpr::Number(value) = value
        && value.is_finite()
        && let Some((message, help)) = out_of_range(*value, dimension)
    {
        wires
            .findings
            .error_with(codes::ARGUMENT, written.span, message, help);
    }
}

/// Warns about times and powers of a coordinator, which have no effect.
fn warn_without_effect(findings: &mut Findings, coordinator: &ast::Component) {
    let time = coordinator.time.as_ref().map(|(e, _)| ("time", e.span));
    let power = coordinator.power.as_ref().map(|e| ("power", e.span));
    for (word, span) in time.into_iter().chain(power) {
        let message = format!(
            "`{word}` of the coordinator `{}` has no effect",
            coordinator.name.text
        );
        findings.push(
            Diagnostic::warning(codes::UNUSED, span, message)
                .with_help("write it in an action, or write `step` or `power` in the machine"),
        );
    }
}

/// Reports inputs that are bound twice, and indices and members that do not exist.
fn check_bindings(findings: &mut Findings, decl: &ast::Component, specification: &Specification) {
    let mut seen: BTreeMap<String, Span> = BTreeMap::new();
    let inputs: Vec<&str> = specification
        .inputs()
        .map(|id| specification.variable(id).name.as_str())
        .collect();
    for b in &decl.bindings {
        let name = &b.name;
        let target = target(b);
        if let Some(first) = seen.insert(target.clone(), name.span) {
            let message = format!("`{target}` is bound twice");
            findings.push(
                Diagnostic::error(codes::NAME_DUPLICATE, name.span, message)
                    .with_label(first, "first here")
                    .with_help("remove one of the two"),
            );
        }
        let (root, path) = leaf_path(&target);
        let own: Vec<&&str> = inputs.iter().filter(|v| leaf_path(v).0 == root).collect();
        let exists = own.iter().any(|v| leaf_path(v).1.starts_with(&path));
        if own.is_empty() || exists {
            continue;
        }
        let scalar = own.len() == 1 && *own[0] == root;
        let elements = own
            .iter()
            .filter(|v| matches!(leaf_path(v).1.first(), Some(Segment::Element(_))));
        let count = elements.count();
        match (b.index, b.index.is_some() && scalar) {
            (Some(_), true) => findings.error_with(
                codes::TYPE_MISMATCH,
                name.span,
                format!("the input `{root}` is not an array"),
                format!("write `{root} = ...`"),
            ),
            (Some(index), false) if b.member.is_none() && count == own.len() => findings
                .error_with(
                    codes::INDEX_RANGE,
                    name.span,
                    format!("`{root}` has no element {index}"),
                    format!("its elements are 0..{}", own.len() - 1),
                ),
            _ => findings.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("the input `{root}` has no `{target}`"),
                format!(
                    "its parts are {}",
                    own.iter()
                        .map(|v| format!("`{v}`"))
                        .collect::<Vec<_>>()
                        .join(", ")
                ),
            ),
        }
    }
}

/// Returns the target of a binding as text: an input or a part of one, such as `h`, `h[0]` or
/// `target.x`.
fn target(b: &ast::Binding) -> String {
    let mut text = b.name.text.clone();
    if let Some(index) = b.index {
        let _ = write!(text, "[{index}]");
    }
    if let Some(member) = &b.member {
        let _ = write!(text, ".{}", member.text);
    }
    text
}

/// Help text on how to bind an array or record.
const BINDING_HELP: &str = "bind an array to an array of the same length and element type, to one value for all elements, or element by element: `h[0] = ...`; bind a record to a record with the same members, or member by member: `target.x = ...`";

/// Returns the value of a leaf of an input, over wires. It is the first of the following that
/// exists: the value that the running operation sets, the declared binding, the plant's wire of the
/// same name, and the coordinator's output of the same name. Reports an unbound input.
pub(super) fn binding<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    decl: &'a ast::Component,
    specification: &Specification,
    variable: &linewright_core::gr1::Variable,
) -> Option<Expr> {
    let (name, path) = leaf_path(&variable.name);
    let mut jobs = Vec::new();
    let mut missing = None;
    for job in jobs::jobs(parts.machine, &decl.name.text) {
        match job.arguments.iter().find(|a| a.name.text == name) {
            Some(argument) => jobs.push((job.operation, &argument.value)),
            None => missing = Some(job.operation),
        }
    }
    let bound = match default_binding(wires, parts, decl, specification, variable)? {
        None if jobs.is_empty() || missing.is_some() => {
            report_unbound(
                &mut wires.findings,
                decl,
                variable,
                missing.filter(|_| !jobs.is_empty()),
            );
            return None;
        }
        bound => bound,
    };
    let whole = expected(specification, name, &[]);
    let mut chosen = bound;
    for (operation, value) in jobs.into_iter().rev() {
        let term = part_of(wires, value, whole.as_ref(), variable, &path, name)?;
        chosen = Some(match chosen {
            None => (term, value.span),
            Some((other, _)) => {
                let runs = jobs::runs(&wires.variables, &operation.text)?;
                (Term::choose(runs, term, other), value.span)
            }
        });
    }
    let (term, span) = chosen?;
    let expr = wires.formula(&term, span)?;
    let range = interval(&expr, &|v| wires.variables.interval(v)).unwrap_or(Interval::BOOL);
    if range.low < variable.domain.low() || range.high > variable.domain.high() {
        wires.findings.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!(
                "this {}, but the input `{}` takes only {}",
                if range.low == range.high {
                    format!("is {}", range.low)
                } else {
                    format!("can be {}..{}", range.low, range.high)
                },
                variable.name,
                variable.describe()
            ),
            "limit the value with `min` and `max`, or use the same range for both",
        );
        return None;
    }
    Some(expr)
}

/// Returns the type of an input, or of the part of it at the end of `path`.
fn expected(specification: &Specification, name: &str, path: &[Segment<'_>]) -> Option<Type> {
    let own = specification.inputs().filter_map(|id| {
        let (root, leaf) = leaf_path(&specification.variable(id).name);
        (root == name).then_some((id, leaf))
    });
    let leaves: Vec<(VarId, Vec<Segment<'_>>)> = own
        .filter_map(|(id, leaf)| Some((id, leaf.strip_prefix(path)?.to_vec())))
        .collect();
    type_of(specification, &leaves)
}

fn type_of(specification: &Specification, leaves: &[(VarId, Vec<Segment<'_>>)]) -> Option<Type> {
    let (id, first) = leaves.first()?;
    let below = |segment: Segment<'_>| -> Vec<(VarId, Vec<Segment<'_>>)> {
        let inner = leaves.iter().filter(|(_, l)| l.first() == Some(&segment));
        inner.map(|(id, l)| (*id, l[1..].to_vec())).collect()
    };
    match first.first() {
        None => {
            let variable = specification.variable(*id);
            Some(measured(&variable.domain, Unit::named(&variable.unit)))
        }
        Some(first @ Segment::Element(_)) => {
            let indices = leaves.iter().filter_map(|(_, l)| match l.first() {
                Some(Segment::Element(i)) => Some(*i),
                _ => None,
            });
            let length = indices.max().map_or(0, |i| i + 1);
            let of = type_of(specification, &below(*first))?;
            Some(Type::Array(Box::new(of), length))
        }
        Some(Segment::Member(_)) => {
            let mut members: Vec<(String, Type)> = Vec::new();
            for (_, leaf) in leaves {
                if let Some(Segment::Member(name)) = leaf.first()
                    && !members.iter().any(|(n, _)| n == name)
                {
                    let ty = type_of(specification, &below(Segment::Member(name)))?;
                    members.push(((*name).to_owned(), ty));
                }
            }
            Some(Type::Record(members))
        }
    }
}

/// Returns the scalar at the end of a path into a value. Where a scalar is given instead of an
/// array, it is the value of all elements.
fn leaf(value: Value, path: &[Segment<'_>]) -> Option<(Term, Type)> {
    match (value, path) {
        (Value::Scalar(term, ty), path)
            if path.iter().all(|s| matches!(s, Segment::Element(_))) =>
        {
            Some((term, ty))
        }
        (Value::Array(values), [Segment::Element(i), rest @ ..]) => {
            leaf(values.into_iter().nth(*i)?, rest)
        }
        (Value::Record(members), [Segment::Member(name), rest @ ..]) => {
            let (_, value) = members.into_iter().find(|(n, _)| n == name)?;
            leaf(value, rest)
        }
        _ => None,
    }
}

/// Returns the value of a leaf of an input while no operation sets it. Returns `None` if an error
/// was reported, and `Some(None)` if the input is not bound.
#[expect(
    clippy::option_option,
    reason = "the outer `None` means an error, the inner one no binding"
)]
fn default_binding<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    decl: &'a ast::Component,
    specification: &Specification,
    variable: &linewright_core::gr1::Variable,
) -> Option<Option<(Term, Span)>> {
    let (name, path) = leaf_path(&variable.name);
    let ty = measured(&variable.domain, Unit::named(&variable.unit));
    // The most specific binding of this leaf.
    let explicit = decl
        .bindings
        .iter()
        .rev()
        .filter_map(|b| {
            let target = target(b);
            let (root, part) = leaf_path(&target);
            (root == name && path.starts_with(&part)).then_some((part.len(), b))
        })
        .max_by_key(|(length, _)| *length);
    if let Some((length, b)) = explicit {
        let whole = expected(specification, name, &path[..length]);
        let rest = &path[length..];
        let term = part_of(wires, &b.value, whole.as_ref(), variable, rest, &target(b))?;
        return Some(Some((term, b.value.span)));
    }
    // If several coordinators have an output of this name, none of these outputs is used.
    let seen = &wires.names.variables;
    let mut outputs = parts
        .components
        .iter()
        .filter(|(c, _)| c.is_coordinator() && c.name.text != decl.name.text)
        .filter_map(|(c, _)| seen.get(&format!("{}.{name}", c.name.text)));
    let entry = match (seen.get(name), outputs.next(), outputs.next()) {
        (Some(entry), ..) | (None, Some(entry), None) => Some(entry.clone()),
        _ => None,
    };
    let Some(id) = entry.and_then(|e| e.at(&path)) else {
        return Some(None);
    };
    let domain = wires.variables.domains[id.index()].clone()?;
    let found = measured(&domain, wires.variables.measures.get(&id).copied());
    if found != ty {
        wires.findings.error_with(
            codes::TYPE_MISMATCH,
            decl.name.span,
            format!(
                "the input `{}` of `{}` is {}, but the wire of the same name is {}",
                variable.name,
                decl.name.text,
                ty.describe(),
                found.describe()
            ),
            format!("bind it: `{name} = ...`"),
        );
        return None;
    }
    Some(Some((Term::Var(id, Time::Now), decl.name.span)))
}

/// Elaborates a value, and returns the part of it at the end of `path`, converted to the type of
/// `variable`. `whole` is the expected type of the whole value. `target` names the bound input in
/// messages.
fn part_of<'a>(
    wires: &mut Elaborator<'a>,
    value: &'a ast::Expr,
    whole: Option<&Type>,
    variable: &linewright_core::gr1::Variable,
    path: &[Segment<'_>],
    target: &str,
) -> Option<Term> {
    let ty = measured(&variable.domain, Unit::named(&variable.unit));
    if plant::is_operation(value)
        && let Some(term) = jobs::known_operation(&wires.variables, &ty)
    {
        return Some(term);
    }
    let given = wires.value(value, whole, Time::Now)?;
    let Some((term, found)) = leaf(given.clone(), path) else {
        let message = format!(
            "`{target}` is {}, and this is {}",
            whole.map_or_else(|| ty.describe(), Type::describe),
            given.ty().describe()
        );
        wires
            .findings
            .error_with(codes::TYPE_MISMATCH, value.span, message, BINDING_HELP);
        return None;
    };
    if path.is_empty() || found.is_numeric() && ty.is_numeric() {
        return fitted(value.span, (term, found), &ty, &mut wires.findings);
    }
    if found == ty {
        return Some(term);
    }
    let message = format!(
        "`{}` is {}, not {}",
        variable.name,
        ty.describe(),
        found.describe()
    );
    wires
        .findings
        .error_with(codes::TYPE_MISMATCH, value.span, message, BINDING_HELP);
    None
}

/// Reports that an input is not bound, or not bound while an operation runs.
fn report_unbound(
    findings: &mut Findings,
    decl: &ast::Component,
    variable: &linewright_core::gr1::Variable,
    operation: Option<&ast::Name>,
) {
    if decl.broken {
        // The text that could not be parsed might contain the binding.
        findings.tainted = true;
        return;
    }
    let (name, action) = (leaf_path(&variable.name).0, &decl.name.text);
    let (span, during, help) = match operation {
        Some(operation) => (
            operation.span,
            format!(" while `{}` runs", operation.text),
            format!(
                "write `{action}({name} = ...)` in the operation, or `{name} = ...` in `{action}`"
            ),
        ),
        None => (
            decl.name.span,
            String::new(),
            format!(
                "write `{name} = ...` in `{action}`, where `...` is another component's output, a `signal`, an `abstract` of a property, or `operation`"
            ),
        ),
    };
    findings.error_with(
        codes::INPUT_UNBOUND,
        span,
        format!(
            "the input `{}` of `{action}` is not bound{during}",
            variable.name
        ),
        help,
    );
}
