//! Checks that every part has a route to the end of its line.
//!
//! The *origins* of a part type are its sources, the stores that have it in stock, and the stations
//! that join it. The check follows the routes from there. A place is reported if a part would stay
//! there for ever: the part is neither taken out of the line nor joined to others there, and no
//! route leads on.

use super::line::{Choice, Line, NodeKind, PartType, Route, Supply};
use super::machine::{RealBinary, RealExpr};
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

/// Maximum number of combinations of values for which conditions are tried.
const MAX_COMBINATIONS: usize = 100_000;

/// Returns whether no part ever takes a route because, whatever values the part has, it takes one
/// of the routes with a condition that come before. If this is too large to be decided, returns
/// false. A route to the place of one of these is no mistake, because routes share their ends.
pub fn is_covered(line: &Line, index: usize) -> bool {
    let route = &line.routes[index];
    let earlier = &line.routes[..line.first_of_way(index)];
    let earlier = earlier
        .iter()
        .filter(|first| (first.part, first.from) == (route.part, route.from));
    if earlier.clone().any(|first| first.condition.is_none()) {
        return false;
    }
    let conditions: Vec<&RealExpr> = earlier
        .clone()
        .filter_map(|first| first.condition.as_ref())
        .collect();
    let mut ends = earlier.map(|first| first.to);
    if conditions.is_empty() || ends.any(|to| to == route.to) {
        return false;
    }
    let part = &line.parts[route.part];
    let Some(tried) = values_to_try(part, &conditions) else {
        return false;
    };
    let mut values = vec![0.0; part.properties.len()];
    let combinations: usize = tried.iter().map(|(_, values)| values.len()).product();
    (0..combinations).all(|number| {
        let mut rest = number;
        for (property, of) in &tried {
            values[*property] = of[rest % of.len()];
            rest /= of.len();
        }
        let mut conditions = conditions.iter();
        conditions.any(|condition| condition.eval(&values, &[]) != 0.0)
    })
}

/// Returns values of the properties in these conditions such that the conditions cover everything
/// if they cover each combination of these: all values, or for real numbers one at, between and
/// beyond the numbers with which they are compared. `None` if that is too many, or if real numbers
/// are used in another way.
fn values_to_try(part: &PartType, conditions: &[&RealExpr]) -> Option<Vec<(usize, Vec<f64>)>> {
    let mut used: BTreeSet<usize> = BTreeSet::new();
    for condition in conditions {
        condition.for_each(&mut |expr| {
            if let RealExpr::Property(property) = expr {
                used.insert(*property);
            }
        });
    }
    let mut combinations: usize = 1;
    let mut all = Vec::new();
    for property in used {
        let values: Vec<f64> = match &part.properties.get(property)?.domain {
            Some(domain) if domain.size() <= MAX_COMBINATIONS as u64 => (domain.low()
                ..=domain.high())
                .map(|value| value as f64)
                .collect(),
            Some(_) => return None,
            None => {
                let mut compared = Vec::new();
                let mut conditions = conditions.iter();
                if !conditions.all(|condition| compares(condition, property, &mut compared)) {
                    return None;
                }
                compared.sort_by(f64::total_cmp);
                let (first, last) = (*compared.first()?, *compared.last()?);
                let between = compared
                    .windows(2)
                    .map(|pair| f64::midpoint(pair[0], pair[1]));
                let between: Vec<f64> = between.collect();
                let beyond = [first - first.abs() - 1.0, last + last.abs() + 1.0];
                compared.into_iter().chain(between).chain(beyond).collect()
            }
        };
        combinations = combinations.saturating_mul(values.len());
        all.push((property, values));
    }
    (combinations <= MAX_COMBINATIONS).then_some(all)
}

/// Collects the numbers with which a property is compared. Returns whether the expression uses the
/// property in no other way.
fn compares(expr: &RealExpr, property: usize, with: &mut Vec<f64>) -> bool {
    use RealBinary::{Eq, Ge, Gt, Le, Lt, Ne};
    match expr {
        RealExpr::Number(_) | RealExpr::Wire(_) => true,
        RealExpr::Property(used) => *used != property,
        RealExpr::Unary(_, a) => compares(a, property, with),
        RealExpr::Binary(op, a, b) => {
            let compared = match (&**a, &**b) {
                (of, RealExpr::Number(number)) | (RealExpr::Number(number), of)
                    if matches!(op, Eq | Ne | Lt | Le | Gt | Ge) =>
                {
                    scale_of(of, property).map(|scale| number / scale)
                }
                _ => None,
            };
            if let Some(bound) = compared {
                // The scale may be rounded.
                with.extend([bound.next_down(), bound, bound.next_up()]);
                return true;
            }
            compares(a, property, with) && compares(b, property, with)
        }
        RealExpr::If(c, a, b) => {
            let mut all = [c, a, b].into_iter();
            all.all(|part| compares(part, property, with))
        }
    }
}

/// By which number an expression multiplies a property, as a unit does; `None` if it is anything
/// else.
fn scale_of(expr: &RealExpr, property: usize) -> Option<f64> {
    let scale = match expr {
        RealExpr::Property(used) if *used == property => 1.0,
        RealExpr::Binary(RealBinary::Mul, a, b) => match (&**a, &**b) {
            (RealExpr::Number(by), of) | (of, RealExpr::Number(by)) => by * scale_of(of, property)?,
            _ => return None,
        },
        RealExpr::Binary(RealBinary::Div, a, b) => match &**b {
            RealExpr::Number(by) => scale_of(a, property)? / by,
            _ => return None,
        },
        _ => return None,
    };
    (scale.is_finite() && scale != 0.0).then_some(scale)
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
