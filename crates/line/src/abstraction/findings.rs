//! Findings about a line, in words: who waits for whom, how this comes about, and the remedy.

use super::Abstraction;
use super::chain::{Chain, View};
use super::decide::{Open, Verdict};
use super::requirements::{NO_CIRCULAR_WAIT, orders_are_finished};
use super::shape::{Place, PlaceKind, Shape};
use linewright_algebra::proof::Refutation;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::eval::holds;
use linewright_language::contract::line::{Line, NodeKind};
use std::collections::BTreeMap;

/// The findings of a verdict: at most one per problem.
pub fn findings(line: &Line, abstraction: &Abstraction, verdict: &Verdict) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut shown = false;
    for open in &verdict.open {
        let name = &abstraction.goal(open.what).name;
        match &open.why {
            Refutation::Trace(trace) if name == NO_CIRCULAR_WAIT => found.push(stuck(line, abstraction, trace)),
            Refutation::Lasso(lasso) => {
                // If one place does not proceed, the places before it do not either, and orders are
                // not finished. Therefore, only the first of these goals is reported.
                if !std::mem::replace(&mut shown, true) {
                    let run: Vec<&Vec<i64>> = lasso.prefix.iter().chain(&lasso.cycle).collect();
                    found.push(unfinished(line, abstraction, open, &run, &lasso.cycle));
                }
            }
            Refutation::Trace(_) => found.push(
                Diagnostic::error(
                    codes::LINE_PART_LOST,
                    line.span,
                    format!("the abstraction of the line violates its own rule {name}: this is a fault of linewright"),
                )
                .with_help("please report it with the files of the line"),
            ),
        }
    }
    if verdict.late {
        for finding in &mut found {
            finding.notes.push(
                "in this example, a part can move later than it could; whether this also happens if all parts move at once \
                 was not decided in time"
                    .to_owned(),
            );
        }
    }
    found
}

fn stuck(line: &Line, abstraction: &Abstraction, trace: &[Vec<i64>]) -> Diagnostic {
    let last = trace.last().map_or(&[][..], Vec::as_slice);
    let view = View {
        abstraction,
        state: last,
    };
    let chain = view.chain(0..abstraction.shape.places.len());
    let mut message = "parts can deadlock (circular wait)".to_owned();
    if !chain.texts.is_empty() {
        message = format!("{message}: {}", chain.texts.join(", "));
    }
    let mut finding = Diagnostic::warning(codes::LINE_CYCLE, line.span, message);
    for place in &chain.places {
        let node = &line.nodes[abstraction.shape.places[*place].node];
        finding = finding.with_label(node.span, format!("{} is here", node.name));
        if let NodeKind::Buffer {
            shelf_life: Some(_),
            ..
        } = node.kind
        {
            finding = finding.with_note(format!(
                "times are left out: a part in {} counts as waiting, even where it would expire first",
                node.name
            ));
        }
    }
    let there: Vec<String> = (0..abstraction.shape.places.len())
        .filter_map(|p| view.contents(p))
        .collect();
    let states: Vec<&Vec<i64>> = trace.iter().collect();
    finding
        .with_note(format!(
            "whatever the times, this happens when {}",
            there.join(", ")
        ))
        .with_note(format!(
            "on the shortest way there, {}",
            moves(abstraction, &states)
        ))
        .with_help(advice(line, abstraction, &chain))
}

fn unfinished(
    line: &Line,
    abstraction: &Abstraction,
    open: &Open,
    run: &[&Vec<i64>],
    cycle: &[Vec<i64>],
) -> Diagnostic {
    let goal = abstraction.goal(open.what);
    let state = cycle.first().map_or(&[][..], Vec::as_slice);
    let view = View { abstraction, state };
    // A place is stuck if nothing comes or leaves in the cycle.
    let model = abstraction.model();
    let quiet = (0..abstraction.shape.places.len()).filter(|place| {
        cycle.iter().all(|s| {
            !holds(&model.leaves(*place), s, &[]) && !holds(&model.arrives_any(*place), s, &[])
        })
    });
    let chain = view.chain(quiet);
    let (code, mut message) = if chain.cycle {
        (
            codes::LINE_CYCLE,
            "some parts can deadlock (circular wait) while others go on".to_owned(),
        )
    } else if let Some(product) = product_of(&abstraction.shape, &goal.name) {
        (
            codes::LINE_UNFINISHED,
            format!(
                "it is possible that no {product} is finished any more, though more are ordered"
            ),
        )
    } else {
        (
            codes::LINE_UNFINISHED,
            format!("this might fail: {}", goal.text),
        )
    };
    if !chain.texts.is_empty() {
        message = format!("{message}: {}", chain.texts.join(", "));
    }
    let mut finding = Diagnostic::warning(code, goal.span, message);
    for place in &chain.places {
        let node = &line.nodes[abstraction.shape.places[*place].node];
        finding = finding.with_label(node.span, format!("{} is here", node.name));
        if let NodeKind::Buffer {
            shelf_life: Some(_),
            ..
        } = node.kind
        {
            finding = finding.with_note(format!(
                "times are left out: a part in {} counts as waiting, even where it would expire first",
                node.name
            ));
        }
    }
    let going = moves(
        abstraction,
        &cycle.iter().chain(cycle.first()).collect::<Vec<_>>(),
    );
    finding
        .with_note(format!("before that, {}", moves(abstraction, run)))
        .with_note(format!("from then on, repeatedly, {going}"))
        .with_help(advice(line, abstraction, &chain))
}

/// The product whose orders a goal with this name is about.
fn product_of<'s>(shape: &'s Shape, goal: &str) -> Option<&'s str> {
    let mut products = shape.products.iter();
    let product = products.find(|part| orders_are_finished(shape, **part) == goal)?;
    Some(&shape.types[*product])
}

/// Describes how many parts move on each way in a run.
fn moves(abstraction: &Abstraction, run: &[&Vec<i64>]) -> String {
    let model = abstraction.model();
    let shape = model.shape;
    let mut counts: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (to, place) in shape.places.iter().enumerate() {
        for from in &place.from {
            let taken = model.taken(*from, to);
            // A part taken in one step has moved by the next, so the last state does not count.
            let moved = run.iter().take(run.len().saturating_sub(1));
            let count = moved.filter(|state| holds(&taken, state, &[])).count();
            if count > 0 {
                counts.insert((*from, to), count);
            }
        }
    }
    let texts = counts.iter().map(|((from, to), n)| {
        format!(
            "{n} from {} to {}",
            shape.places[*from].name, shape.places[*to].name
        )
    });
    let texts: Vec<String> = texts.collect();
    if texts.is_empty() {
        "nothing moves".to_owned()
    } else {
        format!("these parts move: {}", texts.join(", "))
    }
}

/// The remedy for the problem that a chain shows.
fn advice(line: &Line, abstraction: &Abstraction, chain: &Chain) -> String {
    let shape = &abstraction.shape;
    if !chain.cycle {
        let limits: Vec<String> = supplies(line, shape)
            .filter_map(|(place, _, most)| {
                Some(format!(
                    "{} lets at most {} into the line",
                    place.name, most?
                ))
            })
            .collect();
        return if limits.is_empty() {
            "Make sure that the missing part can arrive: it must not wait behind parts that are not needed yet."
                .to_owned()
        } else {
            format!("Find out why the part is missing; {}.", limits.join(", "))
        };
    }
    let places = chain.places.iter().map(|place| &shape.places[*place]);
    let names: Vec<&str> = places.clone().map(|p| p.name.as_str()).collect();
    let names = names.join(", ");
    let has_room = places.into_iter().any(|place| {
        matches!(
            place.kind,
            PlaceKind::Conveyor { .. } | PlaceKind::Room { .. }
        )
    });
    // A station that passes parts to itself blocks with a single one.
    let fewer = if chain.places.len() == 1 && !has_room {
        Vec::new()
    } else {
        fewer(line, shape, chain)
    };
    let way_out = "give parts in it a way out by another station";
    match (has_room, fewer.is_empty()) {
        (true, true) => format!("Make room for more parts in the cycle {names}, or {way_out}."),
        (true, false) => format!(
            "Let fewer parts in than fill the cycle {names}: {}. Or {way_out}.",
            fewer.join(" or ")
        ),
        (false, true) => format!("Put a buffer into the cycle {names}, or {way_out}."),
        (false, false) => format!(
            "Let fewer parts in than fill the cycle {names}: {}; a buffer in the cycle lets you admit more, but does not help alone. Or {way_out}.",
            fewer.join(" or ")
        ),
    }
}

/// How to admit fewer of the parts that wait in a cycle, and of their components. A limit below the
/// number of parts in one product is not suggested, because the line could make no products then.
fn fewer(line: &Line, shape: &Shape, chain: &Chain) -> Vec<String> {
    let mut found = Vec::new();
    for (place, part, most) in supplies(line, shape) {
        let mut waiting = chain.waiting.iter().flatten();
        if !waiting.any(|kind| shape.contents[*kind][part] > 0) {
            continue;
        }
        let name = &place.name;
        let needed = shape.products.iter().map(|p| shape.contents[*p][part]);
        let needed = needed.fold(1, u64::max);
        match most {
            None => found.push(format!(
                "write `at most N in the line` behind source {name}"
            )),
            Some(most) if u64::from(most) > needed => {
                found.push(format!("make the limit of {name} less than {most}"));
            }
            Some(_) => {}
        }
    }
    found
}

/// The sources: their places, part types, and how many parts of the type they admit to the line.
fn supplies<'s>(
    line: &'s Line,
    shape: &'s Shape,
) -> impl Iterator<Item = (&'s Place, usize, Option<u32>)> {
    shape.places.iter().filter_map(|place| match place.kind {
        PlaceKind::Supply { part, most, .. }
            if matches!(line.nodes[place.node].kind, NodeKind::Source { .. }) =>
        {
            Some((place, part, most))
        }
        _ => None,
    })
}
