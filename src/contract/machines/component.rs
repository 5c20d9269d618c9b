//! Components in their places: every input bound, no loop within a step.

use super::Parts;
use crate::contract::elaborate::{Elaborator, Entry, nearest};
use crate::contract::machine::{ActionTime, Component, RealExpr, Role};
use crate::contract::value::{Dimension, Term, Type, Value};
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::interval::{Interval, interval};
use crate::gr1::{Expr, Specification, Time, Timing, VarId};
use crate::source::Span;
use crate::syntax::ast;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An elaborator for bindings: whole-number expressions over wires.
pub(super) fn scope_of_wires<'a>(e: &Elaborator<'a>, parts: &Parts<'a>) -> Elaborator<'a> {
    let mut w = Elaborator::new();
    w.constants.clone_from(&e.constants);
    w.types.clone_from(&e.types);
    w.named_domains.clone_from(&e.named_domains);
    w.broken.clone_from(&e.broken);
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
        // A wire hides a constant of the same name from outside.
        w.constants.remove(name);
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
pub(super) fn component<'a>(
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
            let help = match nearest(&b.name.text, known.iter().copied()) {
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
    bindings_once(wires, decl, specification);
    let active = match (&decl.when, decl.coordinator) {
        (Some(when), false) => wires
            .boolean(when, Time::Now)
            .and_then(|t| wires.formula(&t, when.span)),
        (Some(when), true) => {
            wires.error_with(
                codes::OPERATION,
                when.span,
                "a coordinator is never active itself; `when` belongs to actions",
                "leave it out here, and write it with each action",
            );
            None
        }
        (None, _) => None,
    };
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

/// Every input is bound once, and an index names an element that there is.
fn bindings_once(wires: &mut Elaborator<'_>, decl: &ast::Component, specification: &Specification) {
    let mut seen: BTreeMap<(&str, Option<i64>), Span> = BTreeMap::new();
    for b in &decl.bindings {
        let name = &b.name;
        if let Some(first) = seen.insert((&name.text, b.index), name.span) {
            let message = format!("`{}` is bound twice", name.text);
            wires.findings.push(
                Diagnostic::error(codes::NAME_DOUBLE, name.span, message)
                    .with_label(first, "first here")
                    .with_help("leave one of the two out"),
            );
        }
        let Some(index) = b.index else { continue };
        let inputs = specification
            .inputs()
            .map(|id| &specification.variable(id).name);
        let own: Vec<_> = inputs
            .filter(|v| v.split('[').next() == Some(name.text.as_str()))
            .collect();
        if own.len() == 1 && *own[0] == name.text {
            wires.error_with(
                codes::TYPE_MISMATCH,
                name.span,
                format!("the input `{}` is not an array", name.text),
                format!("write `{} = ...`", name.text),
            );
        } else if !own.is_empty() && index >= own.len() as i64 {
            wires.error_with(
                codes::INDEX_RANGE,
                name.span,
                format!("`{}` has no element {index}", name.text),
                format!("its elements are 0..{}", own.len() - 1),
            );
        }
    }
}

/// What an input is bound to: what the file says, else the plant's wire of its name, else the coordinator's output of its name.
pub(super) fn binding<'a>(
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
                            wires.error_with(
                                codes::TYPE_MISMATCH,
                                b.value.span,
                                format!(
                                    "`{}` is {}, not {}",
                                    variable.name,
                                    ty.describe(),
                                    other.ty().describe()
                                ),
                                "an array is bound to an array of the same length and kind, to one value for all, or element by element: `h[0] = ...`",
                            );
                            return None;
                        }
                        None => {
                            wires.error_with(
                                codes::TYPE_MISMATCH,
                                b.value.span,
                                format!("there is no element {i} for `{}`", variable.name),
                                "an array is bound to an array of the same length and kind, to one value for all, or element by element: `h[0] = ...`",
                            );
                            return None;
                        }
                    },
                    Value::Scalar(term, found) if found == ty => term,
                    other @ Value::Scalar(..) => {
                        wires.error_with(
                            codes::TYPE_MISMATCH,
                            b.value.span,
                            format!(
                                "`{name}` is an array, each element {}; this is {}",
                                ty.describe(),
                                other.ty().describe()
                            ),
                            "an array is bound to an array of the same length and kind, to one value for all, or element by element: `h[0] = ...`",
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
            if decl.broken {
                // It may be bound by what could not be understood.
                wires.tainted = true;
                return None;
            }
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
    let expr = wires.formula(&term, span)?;
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
