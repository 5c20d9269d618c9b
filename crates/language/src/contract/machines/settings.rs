//! Numeric settings of a machine, its `done` condition and its writes to the part.

use super::Parts;
use super::durations::failures;
use super::properties::{PropertyType, assigned, assigned_array};
use crate::contract::elaborate::{Elaborator, Findings, nearest};
use crate::contract::machine::{Machine, PropertyKind};
use crate::contract::value::{Dimension, Term};
use crate::contract::{MAX_SECONDS, MAX_WATTS, MIN_SECONDS, is_duration};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Time, VarId};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, MachineItem};
use std::collections::BTreeMap;

/// Resolves the `done` condition and the writes of a machine. `properties` is the number of
/// properties.
pub(super) fn settings<'a>(
    e: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    model: &mut Machine,
    wires: &mut Elaborator<'a>,
    properties: usize,
) {
    // Writes can read properties and wires. The ids of wires follow those of properties.
    let mut both = Elaborator::new(e.names.clone());
    both.dialect.real = true;
    both.variables.clone_from(&e.variables);
    both.variables
        .domains
        .extend(wires.variables.domains.iter().cloned());
    let shift = |id: VarId| VarId(id.0 + properties as u32);
    for (id, unit) in &wires.variables.measures {
        both.variables.measures.insert(shift(*id), *unit);
    }
    for (name, entry) in &wires.names.variables {
        let entry = entry.renumbered(&shift);
        both.names.constants.remove(name);
        both.names.variables.entry(name.clone()).or_insert(entry);
    }
    // Position of the first write to each property.
    let mut written: BTreeMap<usize, Span> = BTreeMap::new();
    for item in &parts.machine.items {
        let before = model.writes.len();
        match item {
            MachineItem::Done(x) => {
                model.done = wires
                    .boolean(x, Time::Now)
                    .and_then(|t| wires.formula(&t, x.span));
            }
            MachineItem::Write { name, index, value } => {
                let Some((first, ty)) = parts.property_types.get(&name.text) else {
                    let known = parts.property_types.keys().map(String::as_str);
                    let help = match nearest(&name.text, known) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("declare it: `property {}: number`", name.text),
                    };
                    e.findings.error_with(
                        codes::PROPERTY,
                        name.span,
                        format!("the part has no property `{}`", name.text),
                        help,
                    );
                    continue;
                };
                if parts.properties[*first].0.kind == PropertyKind::Parameter {
                    e.findings.error_with(
                        codes::PROPERTY,
                        name.span,
                        format!("`{}` is a parameter, which parts do not carry", name.text),
                        format!("write to a property: `property {}: ...`", name.text),
                    );
                    continue;
                }
                let place = (name, *first, ty);
                let terms = assignments(e, &mut both, place, index.as_ref(), value);
                let written = terms.into_iter();
                model
                    .writes
                    .extend(written.map(|(at, term)| (at, term.to_real(properties))));
            }
            _ => {}
        }
        if let MachineItem::Write { name, .. } = item {
            let assigned = model.writes[before..].iter().map(|(property, _)| *property);
            check_written_once(&mut e.findings, name, assigned, &mut written);
        }
    }
    e.findings.absorb(&mut both.findings);
}

/// Resolves `property[index] = value`. `place` contains the property's name, the index of its first
/// element, and its type. The value is elaborated in `scope`. Returns the elements that are
/// assigned to, with their values.
pub(in crate::contract) fn assignments<'a>(
    e: &mut Elaborator<'a>,
    scope: &mut Elaborator<'a>,
    place: (&ast::Name, usize, &PropertyType),
    index: Option<&'a ast::Expr>,
    value: &'a ast::Expr,
) -> Vec<(usize, Term)> {
    let (name, first, ty) = place;
    let element = PropertyType {
        length: None,
        ..ty.clone()
    };
    match (ty.length, index) {
        (None, None) => {
            let term = assigned(scope, &element, value);
            term.map(|term| (first, term)).into_iter().collect()
        }
        (Some(n), Some(index)) => {
            let Some(i) = e.constant_int(index) else {
                return Vec::new();
            };
            if !(0..n as i64).contains(&i) {
                e.findings.error_with(
                    codes::INDEX_RANGE,
                    index.span,
                    format!("`{}` has no element {i}", name.text),
                    format!("its elements are 0..{}", n - 1),
                );
                return Vec::new();
            }
            let term = assigned(scope, &element, value);
            term.map(|term| (first + i as usize, term))
                .into_iter()
                .collect()
        }
        (Some(n), None) => {
            let terms = assigned_array(scope, &element, n, value);
            let terms = terms.unwrap_or_default().into_iter().enumerate();
            terms.map(|(i, term)| (first + i, term)).collect()
        }
        (None, Some(index)) => {
            e.findings.error_with(
                codes::TYPE_MISMATCH,
                index.span,
                format!("`{}` is not an array", name.text),
                format!("write `{} = ...`", name.text),
            );
            Vec::new()
        }
    }
}

/// Reports a property that has already been written, by itself or with its array.
pub(in crate::contract) fn check_written_once(
    findings: &mut Findings,
    name: &ast::Name,
    writes: impl IntoIterator<Item = usize>,
    written: &mut BTreeMap<usize, Span>,
) {
    let mut first = None;
    for property in writes {
        first = first.or(written.insert(property, name.span));
    }
    if let Some(first) = first {
        findings.push(
            Diagnostic::error(
                codes::NAME_DUPLICATE,
                name.span,
                format!("`{}` is written twice", name.text),
            )
            .with_label(first, "first here")
            .with_help("remove one of the two, or combine them: `if ... then ... else ...`"),
        );
    }
}

/// Resolves settings that do not depend on the components: durations, powers, limits.
pub(super) fn numbers<'a>(e: &mut Elaborator<'a>, machine: &'a ast::Machine, model: &mut Machine) {
    for item in &machine.items {
        match item {
            MachineItem::Step(x) => {
                if let Some(v) = non_negative(e, x, Dimension::Time) {
                    model.step_seconds = v;
                }
            }
            MachineItem::Power(x) => {
                if let Some(v) = non_negative(e, x, Dimension::Power) {
                    model.base_watts = v;
                }
            }
            MachineItem::IdlePower(x) => {
                if let Some(v) = non_negative(e, x, Dimension::Power) {
                    model.idle_watts = v;
                }
            }
            MachineItem::Limit(x) => match e.constant_int(x) {
                Some(n) if n > 0 => model.step_limit = n as u64,
                Some(_) => e.findings.error_with(
                    codes::ARGUMENT,
                    x.span,
                    "the step limit must be at least 1",
                    "write the number of steps after which an operation counts as failed: `limit 500 steps`",
                ),
                None => {}
            },
            _ => {}
        }
    }
    let modes: Vec<&ast::Failures> = machine
        .items
        .iter()
        .filter_map(|item| match item {
            MachineItem::Failures(mode) => Some(mode),
            _ => None,
        })
        .collect();
    model.failures = failures(e, &modes);
}

/// Resolves a constant quantity that is not negative. Reports a duration that [`is_duration`]
/// rejects, and a power above [`MAX_WATTS`].
pub(in crate::contract) fn non_negative<'a>(
    e: &mut Elaborator<'a>,
    x: &'a ast::Expr,
    dimension: Dimension,
) -> Option<f64> {
    let value = e.constant_quantity(x, dimension)?;
    if value < 0.0 || !value.is_finite() {
        e.findings.error_with(
            codes::ARGUMENT,
            x.span,
            if value < 0.0 {
                "this must not be negative"
            } else {
                "this has no finite value"
            },
            if dimension == Dimension::None {
                "write a number that is at least 0"
            } else {
                "write a number that is at least 0, with its unit"
            },
        );
        return None;
    }
    if let Some((message, help)) = out_of_range(value, dimension) {
        e.findings
            .error_with(codes::ARGUMENT, x.span, message, help);
        return None;
    }
    Some(value)
}

/// Returns a message and a help text if a run does not support this duration or power.
pub(in crate::contract) fn out_of_range(
    value: f64,
    dimension: Dimension,
) -> Option<(String, String)> {
    match dimension {
        Dimension::Time if !is_duration(value) => Some((
            format!("{value:e} s is not a valid duration"),
            format!("write 0 s, or a time from {MIN_SECONDS:e} s to {MAX_SECONDS:e} s"),
        )),
        Dimension::Power if value > MAX_WATTS => Some((
            format!("{value:e} W is more power than a run supports"),
            format!("write a power up to {MAX_WATTS:e} W"),
        )),
        _ => None,
    }
}
