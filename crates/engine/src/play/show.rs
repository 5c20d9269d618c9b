//! Formats a play as text and as JSON.

use super::legal::Values;
use super::session::Session;
use super::values::{listed, named_internals, shown_variables};
use linewright_core::gr1::{Domain, Formula, Owner, VarId, eval};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::ops::ControlFlow;

/// The JSON Schema of an output line.
pub const LINE_SCHEMA: &str = include_str!("step.schema.json");

/// Name of the schema, in every output line.
pub(super) const SCHEMA: &str = "linewright/step/1";

/// Maximum number of steps shown by `state`.
const MAX_STEPS: usize = 8;

/// Maximum number of moves that `moves` lists one by one; beyond it, the values of each variable
/// are listed.
const MAX_LISTED_MOVES: usize = 12;

/// Maximum size of a domain whose values `moves` tries one by one.
const MAX_TRIED_VALUES: u64 = 400;

pub(super) fn role(side: Owner) -> &'static str {
    match side {
        Owner::Environment => "plant",
        Owner::System => "machine",
    }
}

pub(super) fn other(side: Owner) -> Owner {
    match side {
        Owner::Environment => Owner::System,
        Owner::System => Owner::Environment,
    }
}

/// Introduces the roles and the variables of both sides.
pub(super) fn opening(session: &Session<'_>) -> String {
    let name = &session.specification.name;
    let mut text = match session.person() {
        Owner::Environment => {
            format!("`{name}` is realizable: you are the plant, and its controller answers.\n")
        }
        Owner::System => {
            format!("`{name}` is unrealizable: you are the machine, and the plant plays to win.\n")
        }
    };
    let person = session.person();
    for (who, side) in [("You set", person), ("It sets", other(person))] {
        let variables = shown_variables(session.specification, side)
            .into_iter()
            .map(|v| {
                let variable = session.specification.variable(v);
                format!("{}: {}", variable.name, variable.describe())
            });
        let variables: Vec<String> = variables.collect();
        if variables.is_empty() {
            let _ = writeln!(text, "{who} nothing.");
        } else {
            let _ = writeln!(text, "{who} {}.", variables.join("; "));
        }
    }
    text + "`help` lists the commands.\n"
}

/// Formats one side's values in a step: `  plant    command = turn`.
fn line(session: &Session<'_>, side: Owner, values: impl Fn(VarId) -> Option<i64>) -> String {
    let variables = shown_variables(session.specification, side).into_iter();
    let values: Values = variables.filter_map(|v| Some((v, values(v)?))).collect();
    if values.is_empty() {
        return String::new();
    }
    format!(
        "  {:<7}  {}\n",
        role(side),
        listed(session.specification, &values)
    )
}

/// Shows the last step. If the opponent moved first, its values were already shown.
pub(super) fn step(session: &Session<'_>, opponent_first: bool) -> String {
    let Some(step) = session.steps.last() else {
        return String::new();
    };
    let person = session.person();
    let line = |side| line(session, side, |v| Some(step[v.index()]));
    if opponent_first {
        return line(person);
    }
    let number = session.steps.len() - 1;
    format!("step {number}\n{}{}", line(person), line(other(person)))
}

/// Shows the opponent's values in the upcoming step, in which it moves first.
pub(super) fn first_values(session: &Session<'_>, given: &[(VarId, i64)]) -> String {
    let of = |v: VarId| given.iter().find(|(g, _)| *g == v).map(|(_, value)| *value);
    let line = line(session, other(session.person()), of);
    format!("step {}\n{line}", session.steps.len())
}

/// The last step as JSON, with the values of the upcoming step that the opponent has already set if
/// it moves first.
pub(super) fn step_object(session: &Session<'_>, over: Option<&str>) -> Value {
    let step = session.steps.last().map_or(&[][..], Vec::as_slice);
    let side = |side: Owner| {
        let variables = shown_variables(session.specification, side).into_iter();
        let values: Values = variables.map(|v| (v, step[v.index()])).collect();
        object(session, &values)
    };
    let mut line = json!({
        "schema": SCHEMA,
        "step": session.steps.len().saturating_sub(1),
        "plant": side(Owner::Environment),
        "machine": side(Owner::System),
    });
    if let Some(given) = session.first_values() {
        line["next"] = object(session, &given);
    }
    if let Some(over) = over {
        line["over"] = json!(over);
    }
    line
}

/// Values as an object, keyed by name.
fn object(session: &Session<'_>, values: &[(VarId, i64)]) -> Value {
    let mut object = Map::new();
    for (v, value) in values {
        let variable = session.specification.variable(*v);
        let value = match &variable.domain {
            Domain::Bool => json!(*value != 0),
            Domain::Range { .. } => json!(value),
            Domain::Enum { .. } => json!(variable.domain.show(*value)),
        };
        if !variable.internal {
            object.insert(variable.name.clone(), value);
        }
    }
    Value::Object(object)
}

/// The introduction as JSON, with the opponent's values in step 0 if the opponent moves first.
pub(super) fn opening_object(session: &Session<'_>) -> Value {
    let mut line = json!({
        "schema": SCHEMA,
        "contract": session.specification.name,
        "you": session.role(),
    });
    if let Some(given) = session.first_values() {
        line["next"] = object(session, &given);
    }
    line
}

/// The values of the last steps as a table, and when each goal was last met.
pub(super) fn state(session: &Session<'_>) -> String {
    let made = session.steps.len();
    let first = made.saturating_sub(MAX_STEPS);
    let given = session.first_values().unwrap_or_default();
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut head = vec!["step".to_owned()];
    head.extend((first..made).map(|s| s.to_string()));
    if !given.is_empty() {
        head.push(made.to_string());
    }
    rows.push(head);
    let [inputs, outputs] = [Owner::Environment, Owner::System]
        .map(|side| shown_variables(session.specification, side));
    let internal = named_internals(session.specification);
    for v in inputs.into_iter().chain(outputs).chain(internal) {
        let variable = session.specification.variable(v);
        let cell = |value: i64| variable.domain.show(value);
        let mut row = vec![variable.name.clone()];
        row.extend(session.steps[first..].iter().map(|s| cell(s[v.index()])));
        if !given.is_empty() {
            let value = given.iter().find(|(g, _)| *g == v);
            row.push(value.map_or("?".to_owned(), |(_, value)| cell(*value)));
        }
        rows.push(row);
    }
    let mut text = if made == 0 && given.is_empty() {
        "no steps yet\n".to_owned()
    } else {
        aligned(&rows)
    };
    let specification = session.specification;
    let goals = specification.assumptions.justice.iter();
    for goal in goals.chain(&specification.guarantees.justice) {
        let title = session.printer.title(goal);
        let _ = match last_met(session, goal) {
            Some(step) => writeln!(text, "{title}\n  last met in step {step}"),
            None => writeln!(text, "{title}\n  not met yet"),
        };
    }
    text
}

/// The last step in which a formula of justice held.
fn last_met(session: &Session<'_>, goal: &Formula) -> Option<usize> {
    let steps = &session.steps;
    let follows = goal.expr.mentions_next();
    (0..steps.len()).rev().find(|step| {
        let next = steps.get(step + 1);
        match next {
            None if follows => false,
            next => eval::holds(&goal.expr, &steps[*step], next.map_or(&[], Vec::as_slice)),
        }
    })
}

fn aligned(rows: &[Vec<String>]) -> String {
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (c, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let _ = if c == 0 {
                write!(line, "{cell:<width$}")
            } else {
                write!(line, "  {cell:>width$}")
            };
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// Lists the legal moves one by one, or the values of each variable if there are many moves.
pub(super) fn moves(session: &Session<'_>) -> String {
    if let Some(over) = session.over() {
        return over;
    }
    let specification = session.specification;
    let moves = session.legal_moves();
    let own = shown_variables(specification, session.person());
    let (bound, free): (Vec<VarId>, Vec<VarId>) = own.into_iter().partition(|v| moves.matters(*v));
    let mut listing: Vec<Values> = Vec::new();
    let ended = moves.each(&mut |values| {
        let values: Values = values
            .iter()
            .copied()
            .filter(|(v, _)| bound.contains(v))
            .collect();
        if !listing.contains(&values) {
            listing.push(values);
        }
        if listing.len() > MAX_LISTED_MOVES {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let free = free.iter().map(|v| {
        let variable = specification.variable(*v);
        format!("{}: {}", variable.name, variable.describe())
    });
    let free: Vec<String> = free.collect();
    let number = session.steps.len();
    let mut text = String::new();
    let mut last = String::new();
    if ended.is_ok() && listing.len() <= MAX_LISTED_MOVES {
        if !bound.is_empty() {
            let _ = writeln!(text, "legal in step {number}:");
            for values in &listing {
                let violated = moves.violated_on_leaving(values);
                let mark = if violated.is_empty() {
                    ""
                } else {
                    let mut known = session.known();
                    for (v, value) in values {
                        known[v.index()] = Some(*value);
                    }
                    let _ = write!(
                        last,
                        "no step after {} can keep\n{}",
                        listed(specification, values),
                        session.printer.leaving(&violated, &known)
                    );
                    match session.person() {
                        Owner::System => "  (loses)",
                        Owner::Environment => "  (leads to a broken assumption)",
                    }
                };
                let _ = writeln!(text, "  {}{mark}", listed(specification, values));
            }
        }
    } else {
        if !moves.leaving.is_empty() {
            let rules: Vec<_> = moves.leaving.iter().collect();
            let _ = write!(
                last,
                "a move that breaks one of these {}, since no step can follow it:\n{}",
                session.consequence_of_last_move(),
                session.printer.leaving(&rules, &session.known())
            );
        }
        let _ = writeln!(
            text,
            "these values are legal in step {number}, but not in every combination:"
        );
        for v in &bound {
            let variable = specification.variable(*v);
            let _ = writeln!(text, "  {}: {}", variable.name, values_of(session, *v));
        }
    }
    let _ = match (free.is_empty(), bound.is_empty()) {
        (true, true) => writeln!(
            text,
            "you have no variables to set: `random` makes the next step"
        ),
        (true, false) => Ok(()),
        (false, true) => writeln!(
            text,
            "any value is legal in step {number}: {}",
            free.join("; ")
        ),
        (false, false) => writeln!(text, "with any value of {}", free.join("; ")),
    };
    text + &last
}

/// Formats the values that a variable has in any legal move, as ranges.
fn values_of(session: &Session<'_>, v: VarId) -> String {
    let variable = session.specification.variable(v);
    let domain = &variable.domain;
    let moves = session.legal_moves();
    if domain.size() > MAX_TRIED_VALUES {
        return format!("{} (too many to try each)", variable.describe());
    }
    let mut ranges: Vec<(i64, i64)> = Vec::new();
    for value in domain.low()..=domain.high() {
        // A value that takes too long to check is listed, too.
        if matches!(moves.find(&[(v, value)]), Ok(None)) {
            continue;
        }
        match ranges.last_mut() {
            Some((_, high)) if *high + 1 == value && matches!(domain, Domain::Range { .. }) => {
                *high = value;
            }
            _ => ranges.push((value, value)),
        }
    }
    let texts = ranges.iter().map(|(low, high)| {
        if low == high {
            domain.show(*low)
        } else {
            format!("{low}..{high}")
        }
    });
    texts.collect::<Vec<_>>().join(", ")
}
