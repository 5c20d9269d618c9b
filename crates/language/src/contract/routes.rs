//! Checks that every part has a route to the end of its line.
//!
//! The *origins* of a part type are its sources, the stores that have it in stock, and the stations
//! that join it. The check follows the routes from there. A place is reported if a part would stay
//! there for ever: the part is neither taken out of the line nor joined to others there, and no
//! route leads on.

mod covered;

pub use covered::is_covered;

use super::line::{Choice, Line, NodeKind, Route, Supply};
use linewright_core::diagnostics::{Diagnostic, codes};
use std::collections::BTreeSet;

/// End of the warnings that depend on the values of parts, which this check does not know.
pub const NONE_HOLDS: &str = "if none of the conditions holds";

/// Adds findings about the routes of a line to `findings`.
pub(super) fn check(line: &Line, findings: &mut Vec<Diagnostic>) {
    let mut ended: Vec<usize> = Vec::new();
    for route in &line.routes {
        let (from, to) = (&line.nodes[route.from], &line.nodes[route.to]);
        let mut refuse = |way: &str, place: &str, help: &str| {
            let ty = &line.parts[route.part].name;
            let message = format!("a `{ty}` is sent {way} `{place}`");
            findings
                .push(Diagnostic::error(codes::LINE_ROUTE, route.span, message).with_help(help));
        };
        if matches!(from.kind, NodeKind::Sink { .. }) {
            let help = "parts leave the line at a sink: end the route there";
            refuse("on from the sink", &from.name, help);
        }
        if matches!(to.kind, NodeKind::Source { .. }) {
            let help = "a source takes no parts: send the part to a `sink` or a `store`";
            refuse("into the source", &to.name, help);
        }
    }
    report_never_taken(line, findings);
    report_covered(line, findings);
    report_after_endless_room(line, findings);
    report_empty_sources(line, findings);
    report_unreached(line, findings);
    for (part, ty) in line.parts.iter().enumerate() {
        let mut open: Vec<usize> = origins(line, part);
        if open.is_empty() && is_used(line, part) {
            findings.push(
                Diagnostic::error(
                    codes::LINE_ROUTE,
                    ty.span,
                    format!("nothing makes a `{}`", ty.name),
                )
                .with_help(missing_origin(line, part)),
            );
        }
        let origins: BTreeSet<usize> = open.iter().copied().collect();
        let mut seen: BTreeSet<usize> = BTreeSet::new();
        while let Some(node) = open.pop() {
            if !seen.insert(node) {
                continue;
            }
            let place = &line.nodes[node];
            let routes: Vec<_> = line
                .routes
                .iter()
                .filter(|r| r.part == part && r.from == node)
                .collect();
            open.extend(routes.iter().map(|r| r.to));
            let arrives = !origins.contains(&node);
            match &place.kind {
                NodeKind::Sink { reject, .. } => {
                    if !reject {
                        ended.push(part);
                    }
                    continue;
                }
                NodeKind::Store { .. } if arrives => {
                    ended.push(part);
                    continue;
                }
                NodeKind::Source { .. } if arrives => continue,
                NodeKind::Station(station) => {
                    let tasks = &station.tasks;
                    let joins = tasks
                        .iter()
                        .any(|t| line.parts[t.part].bill.iter().any(|(p, _)| *p == part));
                    let handles = tasks.iter().any(|t| t.part == part);
                    if !joins && !handles {
                        findings.push(
                            Diagnostic::error(
                                codes::LINE_ROUTE,
                                place.span,
                                format!(
                                    "`{}` performs no operation on a `{}`",
                                    place.name, ty.name
                                ),
                            )
                            .with_help(format!("add `perform ... on {}`", ty.name)),
                        );
                        continue;
                    }
                    if joins && !handles {
                        continue;
                    }
                }
                _ => {}
            }
            if routes.is_empty() {
                findings.push(
                    Diagnostic::error(
                        codes::LINE_ROUTE,
                        place.span,
                        format!("a `{}` has no route from `{}`", ty.name, place.name),
                    )
                    .with_help(format!("add `route {}: {} -> ...`", ty.name, place.name)),
                );
            } else if routes.iter().all(|r| r.condition.is_some()) {
                findings.push(
                    Diagnostic::warning(
                        codes::LINE_ROUTE,
                        routes[routes.len() - 1].span,
                        format!("a `{}` stays at `{}` {NONE_HOLDS}", ty.name, place.name),
                    )
                    .with_help("end the last route with `otherwise`"),
                );
            }
        }
    }
    let unfinished = line.products.iter().filter(|part| !ended.contains(part));
    for product in unfinished.filter_map(|part| line.parts.get(*part)) {
        findings.push(
            Diagnostic::error(
                codes::LINE_ROUTE,
                product.span,
                format!("no `{}` ever reaches a sink or store", product.name),
            )
            .with_help("add a route to a sink or store"),
        );
    }
}

/// Reports places and routes that no part ever reaches, as far as the routes alone decide it. A
/// station whose machine performs nothing on any part is no mistake: it is a spare machine that
/// only uses its idle power.
fn report_unreached(line: &Line, findings: &mut Vec<Diagnostic>) {
    let reached = reached(line);
    let is_reached = |node: usize| reached.iter().any(|(_, at)| *at == node);
    for (node, place) in line.nodes.iter().enumerate() {
        let is_spare = match &place.kind {
            NodeKind::Station(station) => station.machine.is_some() && station.tasks.is_empty(),
            _ => false,
        };
        let leads_on = line.routes.iter().any(|r| r.from == node);
        if is_reached(node) || is_spare && !leads_on {
            continue;
        }
        let (message, help) = if line.routes.iter().any(|r| r.to == node) {
            (
                format!("no part ever reaches `{}`", place.name),
                "add a route to it from a place that parts reach, or remove the place",
            )
        } else if matches!(&place.kind, NodeKind::Station(s) if s.machine.is_some()) && !leads_on {
            (
                format!("no route leads to `{}`", place.name),
                "add a route, or remove the place; a spare machine has no `perform`",
            )
        } else {
            (
                format!("no route leads to `{}`", place.name),
                "add a route, or remove the place",
            )
        };
        findings.push(Diagnostic::warning(codes::LINE_ROUTE, place.span, message).with_help(help));
    }
    let mut reported: BTreeSet<(usize, usize)> = BTreeSet::new();
    for route in &line.routes {
        let way = (route.part, route.from);
        // A place that no part reaches is reported itself, and so is a store that has no such parts
        // when the parts are followed.
        let is_explained = !is_reached(route.from)
            || matches!(line.nodes[route.from].kind, NodeKind::Store { .. });
        if reached.contains(&way) || is_explained || !reported.insert(way) {
            continue;
        }
        let (ty, from) = (&line.parts[route.part], &line.nodes[route.from]);
        findings.push(
            Diagnostic::warning(
                codes::LINE_ROUTE,
                route.span,
                format!(
                    "no `{}` ever takes this route: none reaches `{}`",
                    ty.name, from.name
                ),
            )
            .with_help(format!(
                "add a route that brings it, `route {}: ... -> {}`, or remove this one",
                ty.name, from.name
            )),
        );
    }
}

/// Returns the pairs of part type and place such that parts of this type come to this place, or are
/// made there, if each route is taken. Other findings explain why nothing makes a part type, or why
/// a component is missing; so such parts count as made, lest each place behind be reported, too.
fn reached(line: &Line) -> BTreeSet<(usize, usize)> {
    let mut reached: BTreeSet<(usize, usize)> = BTreeSet::new();
    let mut open: Vec<(usize, usize)> = Vec::new();
    for (node, place) in line.nodes.iter().enumerate() {
        match &place.kind {
            NodeKind::Source { part, .. } => open.push((*part, node)),
            NodeKind::Store { stock } => open.extend(stock.iter().map(|(part, _)| (*part, node))),
            _ => {}
        }
    }
    for part in (0..line.parts.len()).filter(|part| origins(line, *part).is_empty()) {
        let routes = line.routes.iter().filter(|r| r.part == part);
        open.extend(routes.map(|r| (part, r.from)));
    }
    while let Some((part, node)) = open.pop() {
        if !reached.insert((part, node)) {
            continue;
        }
        let onward = line.routes.iter();
        let onward = onward.filter(|r| r.part == part && r.from == node);
        open.extend(onward.map(|r| (part, r.to)));
        let joined = line.parts.iter().enumerate().filter(|(joined, ty)| {
            let mut bill = ty.bill.iter();
            line.is_joined_at(node, *joined) && bill.any(|(component, _)| *component == part)
        });
        open.extend(joined.map(|(joined, _)| (joined, node)));
    }
    reached
}

/// Reports routes that are never taken because an earlier route of the same part type from the same
/// place has no condition: a part takes the first route whose condition holds. A second route to
/// the same place is no mistake, because the routes `a -> m -> k` and `b -> m -> k` share their
/// end.
fn report_never_taken(line: &Line, findings: &mut Vec<Diagnostic>) {
    for (i, route) in line.routes.iter().enumerate() {
        let begin = line.first_of_way(i);
        let always = (0..begin).find(|&first| {
            let first = &line.routes[first];
            first.part == route.part && first.from == route.from && first.condition.is_none()
        });
        let Some(always) = always else { continue };
        let way = &line.routes[always..line.end_of_way(always)];
        if way.iter().any(|first| first.to == route.to) {
            continue;
        }
        let first = &way[0];
        let (ty, from) = (&line.parts[route.part], &line.nodes[route.from]);
        let help = if route.condition.is_some() {
            "put the conditional route before the unconditional one".to_owned()
        } else {
            format!(
                "add a condition to the first route, `when ...`, or let each part go to the first free of these places: \
                 `route {}: {} -> {}, {}`",
                ty.name, from.name, line.nodes[first.to].name, line.nodes[route.to].name
            )
        };
        findings.push(
            Diagnostic::error(
                codes::LINE_ROUTE,
                route.span,
                format!(
                    "no `{}` ever takes this route from `{}`",
                    ty.name, from.name
                ),
            )
            .with_label(
                first.span,
                "every part takes this route, which has no condition",
            )
            .with_help(help),
        );
    }
}

/// Reports routes behind conditions of which one always holds.
fn report_covered(line: &Line, findings: &mut Vec<Diagnostic>) {
    for (index, route) in line.routes.iter().enumerate() {
        if line.first_of_way(index) != index || !is_covered(line, index) {
            continue;
        }
        let (ty, from) = (&line.parts[route.part].name, &line.nodes[route.from].name);
        let message = format!(
            "no `{ty}` ever takes this route from `{from}`: whatever its values are, a condition of the routes before it holds"
        );
        findings.push(
            Diagnostic::warning(codes::LINE_ROUTE, route.span, message)
                .with_help("remove the route, or correct the conditions before it"),
        );
    }
}

/// Reports sources that make nothing, because their limit is 0 and no sink orders replacements.
fn report_empty_sources(line: &Line, findings: &mut Vec<Diagnostic>) {
    for (node, source) in line.nodes.iter().enumerate() {
        let is_empty = match &source.kind {
            NodeKind::Source {
                supply: Supply::Every { limit, .. },
                ..
            } => *limit == Some(0),
            _ => false,
        };
        if is_empty && !line.is_reordered_from(node) {
            findings.push(
                Diagnostic::warning(
                    codes::LINE_ROUTE,
                    source.span,
                    format!("`{}` makes no part: its limit is 0", source.name),
                )
                .with_help("write a limit of at least 1, or remove the source"),
            );
        }
    }
}

/// Reports places of a choice that come after a sink or a store: these always have room, so no part
/// goes farther down the list.
fn report_after_endless_room(line: &Line, findings: &mut Vec<Diagnostic>) {
    let mut end = 0;
    while end < line.routes.len() {
        let first = end;
        end = line.end_of_way(first);
        let choice = line.routes[first].choice;
        if choice.is_none_or(|choice| line.choices[choice] != Choice::FirstFree) {
            continue;
        }
        let way = &line.routes[first..end];
        let endless = way.iter().position(|route| {
            let kind = &line.nodes[route.to].kind;
            matches!(kind, NodeKind::Sink { .. } | NodeKind::Store { .. })
        });
        let Some(endless) = endless.filter(|at| at + 1 < way.len()) else {
            continue;
        };
        let (full, never) = (&way[endless], &way[endless + 1]);
        let name = |route: &Route| line.nodes[route.to].name.as_str();
        findings.push(
            Diagnostic::error(
                codes::LINE_ROUTE,
                never.span,
                format!(
                    "no `{}` ever goes to `{}`: `{}` comes before it in the list, and always has room",
                    line.parts[never.part].name,
                    name(never),
                    name(full)
                ),
            )
            .with_help(format!("write `{}` last", name(full))),
        );
    }
}

/// Returns the nodes at which parts of this type first appear in the line.
fn origins(line: &Line, part: usize) -> Vec<usize> {
    line.nodes
        .iter()
        .enumerate()
        .filter(|(i, n)| match &n.kind {
            NodeKind::Source { part: p, .. } => *p == part,
            NodeKind::Store { stock } => stock.iter().any(|(p, _)| *p == part),
            NodeKind::Station(_) => line.is_joined_at(*i, part),
            _ => false,
        })
        .map(|(i, _)| i)
        .collect()
}

/// Returns a help text for a part type that has no origin: how to make parts of this type.
fn missing_origin(line: &Line, part: usize) -> String {
    let kind = &line.parts[part].name;
    let mut stations = line.nodes.iter().enumerate();
    let passed = stations.find(|(i, n)| {
        let NodeKind::Station(station) = &n.kind else {
            return false;
        };
        let has_task = station.tasks.iter().any(|t| t.part == part);
        has_task && !line.parts[part].bill.is_empty() && line.is_brought(*i, part)
    });
    match passed {
        Some((_, station)) => format!(
            "`{}` does not join the components of this part, because a route leads a `{kind}` there that is already joined, and some of the components have no route there, or a separate `perform`: join them at another station",
            station.name
        ),
        None => "add a `source`, stock in a `store`, or a station that performs an operation on it"
            .to_owned(),
    }
}

/// Returns whether the part type is a product, or occurs in a route or a bill of materials.
fn is_used(line: &Line, part: usize) -> bool {
    line.is_product(part)
        || line.routes.iter().any(|r| r.part == part)
        || line
            .parts
            .iter()
            .any(|p| p.bill.iter().any(|(b, _)| *b == part))
}
