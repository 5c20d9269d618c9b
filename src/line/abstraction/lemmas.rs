//! What helps to prove a line, place by place: formulas that hold of most lines and that the claim may rest on where they do.
//!
//! A circle of places goes on because it is never full, and a station that joins parts goes on because its components come. Both are
//! said of few places; without them, whatever goes through a circle could only be proved of all places at once.

use super::parts::formula;
use super::vocabulary::{Model, Phase, Queue};
use super::words::{count, is, sum};
use crate::contract::line::Line;
use crate::game::RuleKind;
use crate::gr1::{BinaryOp, Expr, Formula};
use std::collections::BTreeSet;

/// The lemmas: invariants, and justice.
pub(super) fn lemmas(model: Model<'_>, line: &Line) -> Vec<(RuleKind, Formula)> {
    let circles = circles(model, line).into_iter();
    let components = components(model, line).into_iter();
    let circles = circles.map(|f| (RuleKind::Invariant, f));
    circles
        .chain(components.map(|f| (RuleKind::Justice, f)))
        .collect()
}

/// Of every circle of places, and every supply that lets only so many parts into the line: not more of them are in the circle.
fn circles(model: Model<'_>, line: &Line) -> Vec<Formula> {
    let mut found = Vec::new();
    for circle in all_circles(model) {
        for (supply, declared) in model.shape.places.iter().enumerate() {
            let (Some((_, most)), [ways]) = (model.vars(supply).in_line, declared.ways.as_slice())
            else {
                continue;
            };
            let held: Vec<Expr> = { circle.iter() }
                .flat_map(|place| held(model, *place, ways.part))
                .collect();
            if held.is_empty() {
                continue;
            }
            let names: Vec<&str> = { circle.iter() }
                .map(|p| model.shape.places[*p].name.as_str())
                .collect();
            let kind = &model.shape.types[ways.part];
            let text = format!(
                "at most {most} of {kind} are in {}, alone or in something else",
                names.join(", ")
            );
            let name = format!("{}_is_never_overrun", names.join("_"));
            let few = Expr::binary(BinaryOp::Le, sum(held), Expr::Const(i64::from(most)));
            found.push(formula(line.nodes[declared.node].span, &name, &text, &few));
        }
    }
    found
}

/// The sets of places from each of which parts may come to each other one.
fn all_circles(model: Model<'_>) -> BTreeSet<BTreeSet<usize>> {
    let reached = |from: usize| {
        let mut seen = BTreeSet::new();
        let mut open = vec![from];
        while let Some(place) = open.pop() {
            open.extend(
                model
                    .shape
                    .after(place)
                    .into_iter()
                    .filter(|to| seen.insert(*to)),
            );
        }
        seen
    };
    let reached: Vec<BTreeSet<usize>> = (0..model.shape.places.len()).map(reached).collect();
    (0..reached.len())
        .filter(|place| reached[*place].contains(place))
        .map(|place| {
            let back = reached[place].iter().copied();
            back.filter(|other| reached[*other].contains(&place))
                .collect()
        })
        .collect()
}

/// How many parts of a type are in a place, alone or in others: the terms of a sum.
fn held(model: Model<'_>, place: usize, part: usize) -> Vec<Expr> {
    let vars = model.vars(place);
    let content = |kind: usize| i64::try_from(model.shape.contents[kind][part]).unwrap_or(i64::MAX);
    let mut terms = Vec::new();
    let mut add = |number: Expr, kind: usize| match content(kind) {
        0 => {}
        1 => terms.push(number),
        many => terms.push(Expr::binary(BinaryOp::Mul, number, Expr::Const(many))),
    };
    if let Some(phase) = vars.phase {
        for (index, at) in vars.phases.iter().enumerate() {
            let (Phase::Work(kind) | Phase::Done(kind, _)) = *at;
            add(count([is(phase, index + 1)]), kind);
        }
    }
    if let super::shape::PlaceKind::Station { tasks } = &model.shape.places[place].kind {
        for (task, bill) in vars.bills.iter().enumerate() {
            for (line, (there, _)) in bill.iter().enumerate() {
                add(Expr::now(*there), tasks[task].bill[line].0);
            }
        }
    }
    match &vars.queue {
        Some(Queue::Count(held, _)) => {
            for ways in &model.shape.places[place].ways {
                add(Expr::now(*held), ways.part);
            }
        }
        Some(Queue::Slots(slots, types)) => {
            for (label, kind) in types.iter().enumerate() {
                add(count(slots.iter().map(|s| is(*s, label + 1))), *kind);
            }
        }
        None => {}
    }
    terms
}

/// Of every component that a station joins: its places there are filled again and again.
fn components(model: Model<'_>, line: &Line) -> Vec<Formula> {
    let mut found = Vec::new();
    for (place, declared) in model.shape.places.iter().enumerate() {
        let super::shape::PlaceKind::Station { tasks } = &declared.kind else {
            continue;
        };
        let bills = tasks.iter().zip(&model.vars(place).bills);
        for (component, there, most) in bills.flat_map(|(task, bill)| {
            let lines = task.bill.iter().zip(bill);
            lines.map(|((component, _), (there, most))| (*component, *there, *most))
        }) {
            let kind = &model.shape.types[component];
            let name = format!("{kind}_comes_to_{}", declared.name);
            let text = format!(
                "{} has the {kind} that it joins, again and again",
                declared.name
            );
            let full = is(there, most as usize);
            found.push(formula(line.nodes[declared.node].span, &name, &text, &full));
        }
    }
    found
}
