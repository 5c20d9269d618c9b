//! Everything of a machine that is a number or a plant expression.

use super::Parts;
use super::properties::{PropertyType, assigned};
use crate::contract::elaborate::{Elaborator, Entry, nearest};
use crate::contract::machine::{Failures, Machine};
use crate::contract::value::{Dimension, Value};
use crate::diagnostics::codes;
use crate::gr1::{Time, VarId};
use crate::syntax::ast::{self, MachineItem};

/// Everything of a machine that is a number or a plant expression.
pub(super) fn settings<'a>(
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
            MachineItem::Done(x) => {
                model.done = wires.boolean(x, Time::Now).and_then(|t| t.to_expr());
            }
            MachineItem::Write { name, index, value } => {
                let Some((first, ty)) = parts.property_types.get(&name.text) else {
                    let known = parts.property_types.keys().map(String::as_str);
                    let help = match nearest(&name.text, known) {
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

/// What is known without looking at the components: durations, powers, limits.
pub(super) fn numbers<'a>(e: &mut Elaborator<'a>, machine: &'a ast::Machine, model: &mut Machine) {
    for item in &machine.items {
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
            _ => {}
        }
    }
}

/// A quantity that is not negative.
pub(in crate::contract) fn positive<'a>(
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
pub(in crate::contract) fn failures<'a>(
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
