//! Findings about the parts of a line, in words, with the way of the part as evidence.

use super::station::Refusal;
use super::walk::{Choice, RangeViolation, Stage, Vertex, Walk};
use super::{Calls, machine_of};
use crate::abstraction::words::an;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Formula;
use linewright_language::contract::is_covered;
use linewright_language::contract::line::{Line, NodeKind};
use linewright_language::contract::machine::{Component, Machine};
use linewright_station::{ErrorCode, messages};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of operations or value changes that a finding lists.
const MAX_LISTED: usize = 8;

/// Adds all findings.
pub(super) fn add(walk: &Walk<'_>, calls: &mut Calls) {
    let writer = Writer {
        walk,
        certain: certain(walk),
        depth: depth(walk),
    };
    for node in 0..walk.line.nodes.len() {
        writer.refusals(node, &mut calls.findings);
    }
    writer.range_violations(&mut calls.findings);
    writer.stranded(&mut calls.findings);
    if walk.is_complete() {
        writer.dead_routes(calls);
        writer.empty_stores(calls);
    }
}

/// By vertex: whether some part certainly reaches it if the line keeps running, because nothing on
/// the way depends on what is left open.
fn certain(walk: &Walk<'_>) -> Vec<bool> {
    let mut certain = vec![false; walk.vertices.len()];
    let mut open: Vec<usize> = walk.origins.clone();
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut certain[at], true) {
            continue;
        }
        let vertex = &walk.vertices[at];
        let refused = vertex.call.is_some_and(|call| {
            let station = walk.stations[vertex.node].as_ref();
            station.is_some_and(|d| d.calls[call].answers.values().any(Result::is_err))
        });
        let decided = vertex.choice == Choice::Chance || vertex.next.len() == 1;
        if decided && !refused {
            open.extend(&vertex.next);
        }
    }
    certain
}

/// Number of vertices on the way to each vertex, including itself.
fn depth(walk: &Walk<'_>) -> Vec<usize> {
    let mut depth = Vec::with_capacity(walk.vertices.len());
    for vertex in &walk.vertices {
        // The vertex from which another was first reached has a smaller index, so its depth is
        // known.
        depth.push(vertex.before.map_or(1, |before| depth[before] + 1));
    }
    depth
}

struct Writer<'a> {
    walk: &'a Walk<'a>,
    certain: Vec<bool>,
    depth: Vec<usize>,
}

impl Writer<'_> {
    fn line(&self) -> &Line {
        self.walk.line
    }

    fn name(&self, node: usize) -> &str {
        &self.line().nodes[node].name
    }

    /// Adds one finding per operation and kind of problem: the most certain one and, among equally
    /// certain ones, the one with the shortest way.
    fn refusals(&self, node: usize, findings: &mut Vec<Diagnostic>) {
        let (Some(machine), Some(station)) =
            (machine_of(self.line(), node), &self.walk.stations[node])
        else {
            return;
        };
        let mut best: BTreeMap<(usize, i32, String), (Rank, Refused<'_>)> = BTreeMap::new();
        for (call, state, refusal) in self.walk.refusals(node) {
            let always = station.calls[call].answers.values().all(Result::is_err);
            let before = station.way_to(state).len();
            for at in self.walk.callers(node, call) {
                let way = self.depth[*at];
                let rank = (!(always && self.certain[*at]), before, way, *at);
                let what = refusal
                    .error
                    .rule
                    .clone()
                    .unwrap_or_else(|| without_numbers(&refusal.error.message));
                let refused = Refused {
                    at: *at,
                    call,
                    state,
                    always,
                    refusal,
                };
                let key = (refusal.operation, refusal.error.code as i32, what);
                let kept = best.entry(key).or_insert((rank, refused));
                if rank < kept.0 {
                    *kept = (rank, refused);
                }
            }
        }
        let found = best.into_values().map(|(_, r)| self.refused(machine, &r));
        findings.extend(found);
    }

    fn refused(&self, machine: &Machine, refused: &Refused<'_>) -> Diagnostic {
        let vertex = &self.walk.vertices[refused.at];
        let (node, error) = (&self.line().nodes[vertex.node], &refused.refusal.error);
        let rule = error
            .rule
            .as_ref()
            .and_then(|rule| formula_of(machine, rule));
        let kind = &self.line().parts[vertex.part].name;
        let way = self.walk.stations[vertex.node].as_ref();
        let earlier = way.map_or(Vec::new(), |station| station.way_to(refused.state));
        let of_order = error.code == ErrorCode::Order || !refused.always;
        let is_assumed = matches!(error.code, ErrorCode::Order | ErrorCode::Assumption);
        let mut finding = match rule.filter(|_| of_order && is_assumed) {
            Some((component, formula)) => {
                let forbids = messages::describe_assumption(component, formula);
                let message = format!(
                    "{} may be asked for what {forbids} forbids: {}",
                    node.name, formula.text
                );
                Diagnostic::warning(codes::LINE_FORBIDDEN_REQUEST, node.span, message)
            }
            None if of_order || !self.certain[refused.at] => {
                let message = format!("{} may refuse {}: {}", node.name, an(kind), error.message);
                Diagnostic::warning(codes::LINE_REFUSED, node.span, message)
            }
            None => {
                let message = format!("{} refuses {}: {}", node.name, an(kind), error.message);
                Diagnostic::error(codes::LINE_REFUSED, node.span, message)
            }
        };
        if let Some((component, formula)) = rule {
            let label = if finding.code == codes::LINE_FORBIDDEN_REQUEST {
                "this would be broken".to_owned()
            } else {
                format!("the broken rule, of the component `{}`", component.name)
            };
            finding = finding.with_label(formula.span, label);
        }
        if of_order {
            let asked = self.operations(vertex.node, machine, &earlier, refused);
            finding = finding.with_note(format!(
                "this happens when {} is asked for {}: {} is refused, and the current part is removed from the line",
                node.name,
                in_turn(&asked),
                if asked.len() == 1 { "this" } else { "the last of these" }
            ));
        }
        if !self.line().parts[vertex.part].properties.is_empty() {
            finding = finding.with_note(self.history(refused.at));
        }
        finding.with_help(self.help(refused, machine, of_order))
    }

    fn help(&self, refused: &Refused<'_>, machine: &Machine, of_order: bool) -> String {
        let vertex = &self.walk.vertices[refused.at];
        match refused.refusal.error.code {
            ErrorCode::Limit => {
                let station = self.walk.stations[vertex.node].as_ref();
                let NodeKind::Station(declared) = &self.line().nodes[vertex.node].kind else {
                    return String::new();
                };
                let needed = station.and_then(|station| {
                    let call = &station.calls[refused.call];
                    station.steps_needed(refused.state, &declared.tasks[call.task], call, self.walk.bounds.steps)
                });
                match needed {
                    Some(steps) => format!(
                        "it would take {steps} steps, and `{}` allows {}: write `limit {steps} steps`, or a larger number",
                        machine.name, machine.step_limit
                    ),
                    None => "the operation does not end within a far larger limit, either: find out what its actions wait for"
                        .to_owned(),
                }
            }
            ErrorCode::Domain => {
                "divert parts with such values by a route with a condition, or extend the machine's expressions and ranges to these values"
                    .to_owned()
            }
            _ if of_order => {
                "let the station perform other operations, or the same ones in another order; or weaken the rule that forbids this".to_owned()
            }
            _ => "keep such parts away by a route with a condition, change the machine's `abstract`, which computes inputs from their properties, or weaken the assumption"
                .to_owned(),
        }
    }

    /// Names of the operations called, up to the one that is refused.
    fn operations<'m>(
        &self,
        node: usize,
        machine: &'m Machine,
        earlier: &[usize],
        refused: &Refused<'_>,
    ) -> Vec<&'m str> {
        let NodeKind::Station(declared) = &self.line().nodes[node].kind else {
            return Vec::new();
        };
        let Some(station) = &self.walk.stations[node] else {
            return Vec::new();
        };
        let of_call = |call: usize| declared.tasks[station.calls[call].task].operations.iter();
        let name = |operation: usize| machine.operations[operation].name.as_str();
        let mut asked: Vec<&str> = earlier
            .iter()
            .flat_map(|call| of_call(*call))
            .map(|(operation, _)| name(*operation))
            .collect();
        for (operation, _) in of_call(refused.call) {
            asked.push(name(*operation));
            if *operation == refused.refusal.operation {
                break;
            }
        }
        asked
    }

    fn range_violations(&self, findings: &mut Vec<Diagnostic>) {
        let mut shown = BTreeSet::new();
        for violation in &self.walk.range_violations {
            let vertex = &self.walk.vertices[violation.vertex];
            if shown.insert((
                vertex.node,
                vertex.part,
                violation.property,
                violation.defect,
            )) {
                findings.push(self.violation(violation, vertex));
            }
        }
    }

    fn violation(&self, violation: &RangeViolation, vertex: &Vertex) -> Diagnostic {
        let node = &self.line().nodes[vertex.node];
        let part = &self.line().parts[vertex.part];
        let property = &part.properties[violation.property];
        let defect = match &node.kind {
            NodeKind::Station(station) => violation.defect.map(|d| &station.defects[d]),
            _ => None,
        };
        let range = property.describe();
        let who = match (defect, vertex.stage) {
            (Some(_), _) => format!("a defect at {}", node.name),
            (None, Stage::Joined | Stage::Comes) => format!("joining at {}", node.name),
            (None, _) => format!("the work of {}", node.name),
        };
        let message = format!(
            "{who} sets `{}` of {} to {}, which is outside {range}",
            property.name, part.name, violation.value
        );
        let span = defect.map_or(node.span, |d| d.span);
        let finding = if self.certain[violation.vertex] {
            Diagnostic::error(codes::LINE_VALUE, span, message)
        } else {
            Diagnostic::warning(codes::LINE_VALUE, span, message)
        };
        finding
            .with_note(self.history(violation.vertex))
            .with_help("keep the value in its range with `min`, `max` or `mod`, or declare a wider range for the property")
    }

    fn stranded(&self, findings: &mut Vec<Diagnostic>) {
        let mut shown = BTreeSet::new();
        for at in &self.walk.stranded {
            let vertex = &self.walk.vertices[*at];
            if !shown.insert((vertex.node, vertex.part)) {
                continue;
            }
            let (node, kind) = (
                &self.line().nodes[vertex.node],
                &self.line().parts[vertex.part].name,
            );
            let message = format!(
                "{} has no way onward from {}: none of the conditions of its routes holds",
                an(kind),
                node.name
            );
            let finding = if self.certain[*at] {
                Diagnostic::error(codes::LINE_ROUTE, node.span, message)
            } else {
                Diagnostic::warning(codes::LINE_ROUTE, node.span, message)
            };
            findings.push(
                finding
                    .with_note(self.history(*at))
                    .with_help("end the last route with `otherwise`"),
            );
        }
    }

    fn dead_routes(&self, calls: &mut Calls) {
        for (index, route) in self.line().routes.iter().enumerate() {
            let leaves = |v: &Vertex| {
                v.stage == Stage::Leaves && (v.node, v.part) == (route.from, route.part)
            };
            let is_stranded = |at: &usize| leaves(&self.walk.vertices[*at]);
            // It is harmless if a catch-all route gets no parts, unless the route leads to a
            // station that no part reaches at all. If no part even reaches the start of a route,
            // the cause is reported further upstream.
            let is_net = route.condition.is_none() && !self.is_idle_station(route.to);
            if calls.taken[index]
                || is_net
                || is_covered(self.line(), index)
                || self.walk.stranded.iter().any(is_stranded)
                || !self.walk.vertices.iter().any(leaves)
            {
                continue;
            }
            let kind = &self.line().parts[route.part].name;
            let why = if route.condition.is_some() {
                "its condition never holds there"
            } else {
                "the routes before it take all of them"
            };
            let message = format!(
                "no {kind} ever goes from {} to {}: {why}",
                self.name(route.from),
                self.name(route.to)
            );
            calls.remarks.push(
                Diagnostic::warning(codes::LINE_ROUTE, route.span, message).with_help(
                    "check the values that the part can have there, or remove the route",
                ),
            );
        }
    }

    /// Reports stores that have routes for a part type but never hold a part of this type.
    fn empty_stores(&self, calls: &mut Calls) {
        let line = self.line();
        for (node, declared) in line.nodes.iter().enumerate() {
            if !matches!(declared.kind, NodeKind::Store { .. }) {
                continue;
            }
            let routes = line.routes.iter().filter(|r| r.from == node);
            let parts: BTreeSet<usize> = routes.map(|r| r.part).collect();
            for part in parts {
                if self
                    .walk
                    .vertices
                    .iter()
                    .any(|v| (v.node, v.part) == (node, part))
                {
                    continue;
                }
                let kind = &line.parts[part].name;
                let message = format!(
                    "no {kind} ever leaves {}: it has none in stock, and none arrives",
                    declared.name
                );
                calls.remarks.push(
                    Diagnostic::warning(codes::LINE_ROUTE, declared.span, message)
                        .with_help("give it a stock, or remove the route"),
                );
            }
        }
    }

    /// Whether a node is a station that no part ever reaches.
    fn is_idle_station(&self, node: usize) -> bool {
        let is_station = matches!(self.line().nodes[node].kind, NodeKind::Station(_));
        is_station && !self.walk.vertices.iter().any(|v| v.node == node)
    }

    /// The vertices on the way of a part, from where it is made.
    fn way(&self, at: usize) -> Vec<usize> {
        let mut way = vec![at];
        while let Some(before) = self.walk.vertices[way[way.len() - 1]].before {
            way.push(before);
        }
        way.reverse();
        way
    }

    /// Describes the way of a part: `the way of this part: made at s with x = 0; m makes x = 1`.
    fn history(&self, at: usize) -> String {
        let way = self.way(at);
        let mut shown: Vec<String> = Vec::new();
        let mut last: Option<&Vertex> = None;
        for vertex in way.iter().map(|v| &self.walk.vertices[*v]) {
            let node = self.name(vertex.node);
            let all = self.values(vertex, None);
            match last {
                None => shown.push(format!("made at {node}{}", with(&all))),
                Some(before) if before.part != vertex.part => {
                    let kind = &self.line().parts[vertex.part].name;
                    shown.push(format!("joined to {} at {node}{}", an(kind), with(&all)));
                }
                Some(before) => {
                    let changed = self.values(vertex, Some(before));
                    if !changed.is_empty() {
                        let how = match vertex.stage {
                            Stage::Leaves => format!("a defect at {node}"),
                            _ => node.to_owned(),
                        };
                        shown.push(format!("{how} makes {}", changed.join(", ")));
                    }
                }
            }
            last = Some(vertex);
        }
        let left_out = shown.len().saturating_sub(MAX_LISTED + 1);
        if left_out > 0 {
            let rest = format!("{left_out} more changes");
            shown.splice(1..=left_out, [rest]);
        }
        format!("the way of this part: {}", shown.join("; "))
    }

    /// The values of a part, as `name = value`. With `before`, only those that have changed since
    /// then.
    fn values(&self, vertex: &Vertex, before: Option<&Vertex>) -> Vec<String> {
        let properties = self.line().parts[vertex.part].properties.iter().enumerate();
        let changed = |i: &usize| before.is_none_or(|b| b.values[*i] != vertex.values[*i]);
        properties
            .filter(|(i, _)| changed(i) && !self.walk.unread[vertex.part][*i])
            .map(|(i, property)| {
                let value = vertex.values[i].0;
                let shown = match &property.domain {
                    Some(domain) if domain.contains_real(value) => domain.show(value as i64),
                    _ if value.abs() >= 1e15 => format!("{value:e}"),
                    _ => value.to_string(),
                };
                format!("{} = {shown}", property.name)
            })
            .collect()
    }
}

/// Rank of a finding; the smallest comes first. In this order: whether it depends on something left
/// open, the number of calls before it, the length of the part's way, and the vertex.
type Rank = (bool, usize, usize, usize);

#[derive(Clone, Copy)]
struct Refused<'a> {
    at: usize,
    call: usize,
    state: usize,
    /// Whether the call is refused in every state of the station.
    always: bool,
    refusal: &'a Refusal,
}

fn with(values: &[String]) -> String {
    if values.is_empty() {
        String::new()
    } else {
        format!(" with {}", values.join(", "))
    }
}

/// A message without its numbers, to recognize similar mistakes.
fn without_numbers(message: &str) -> String {
    message.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// The formula, with its component, to which the rule in a library's error refers.
fn formula_of<'m>(machine: &'m Machine, rule: &str) -> Option<(&'m Component, &'m Formula)> {
    machine.components.iter().find_map(|component| {
        let sides = [
            &component.specification.assumptions,
            &component.specification.guarantees,
        ];
        let mut formulas = sides.into_iter().flat_map(linewright_core::gr1::Side::all);
        let formula = formulas.find(|f| messages::rule_name(component, f) == rule)?;
        Some((component, formula))
    })
}

/// Lists operations in order, for a message: `` `left` twice, then `right` ``. Of a long sequence,
/// only the end is listed.
pub fn in_turn(operations: &[&str]) -> String {
    let mut shown: Vec<(&str, usize)> = Vec::new();
    for name in operations {
        match shown.last_mut() {
            Some((last, times)) if last == name => *times += 1,
            _ => shown.push((name, 1)),
        }
    }
    let text = |(name, times): &(&str, usize)| match times {
        1 => format!("`{name}`"),
        2 => format!("`{name}` twice"),
        times => format!("`{name}` {times} times"),
    };
    let left_out = shown.len().saturating_sub(MAX_LISTED);
    let mut texts: Vec<String> = Vec::new();
    if left_out > 0 {
        texts.push(format!("{left_out} others"));
    }
    texts.extend(shown[left_out..].iter().map(text));
    texts.join(", then ")
}
