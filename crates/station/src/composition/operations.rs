//! Checks whether each operation runs the actions that it names, and always ends.
//!
//! An operation begins at step 0, or after the previous operation has ended. From then on, the wire
//! of the operation keeps its value until the operation ends. Along the coordinator's steps, the
//! check counts the actions that have begun: this count is the *position* in the operation's
//! sequence. Consecutive active steps of one action count once.

use super::over_wires;
use super::query::{Answer, Question};
use super::walk::{Node, Step, Walk};
use crate::messages;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Expr, Time, VarId};
use linewright_language::contract::machine::Operation;
use std::collections::BTreeSet;

/// A point in an operation: the node, the number of actions that have begun, and the active action.
type Place = (Node, usize, Option<usize>);

/// Adds findings about the operations to `findings`.
pub(super) fn check(walk: &Walk<'_>, findings: &mut Vec<Diagnostic>) {
    for operation in &walk.machine.operations {
        if let Some(finding) = examine(walk, operation) {
            findings.push(finding);
        }
    }
}

fn examine(walk: &Walk<'_>, operation: &Operation) -> Option<Diagnostic> {
    let machine = walk.machine;
    let chosen = Expr::now(VarId(0)).equals(Expr::Const(operation.value));
    let done = machine.done.as_ref()?;
    let begins = beginnings(walk, operation, done);
    if begins.is_empty() {
        return Some(
            Diagnostic::warning(
                codes::OPERATION,
                operation.span,
                format!("the operation `{}` can never begin: an assumption of the coordinator excludes it in every state", operation.name),
            )
            .with_help("weaken that assumption, or add an operation that leads to a state in which this one can begin"),
        );
    }
    let mut seen: BTreeSet<Place> = BTreeSet::new();
    let mut open: Vec<Place> = Vec::new();
    for node in begins {
        match advance(walk, operation, node, 0, None) {
            Ok((position, active)) => open.push((node, position, active)),
            Err(found) => return Some(*found),
        }
    }
    let mut edges: Vec<(Place, Place, Step)> = Vec::new();
    while let Some(place) = open.pop() {
        if !seen.insert(place) {
            continue;
        }
        let (node, position, active) = place;
        let ended = specialized(walk, node, done, operation);
        if !is_certain(walk, node, &ended.clone().not()) {
            // The operation ends at this node, or can end at it.
            if position != operation.sequence.len() {
                return Some(wrong(walk, operation, position, None));
            }
            if is_certain(walk, node, &ended) {
                continue;
            }
        }
        for step in walk.steps_from(node) {
            if !walk.is_possible(step, std::slice::from_ref(&chosen)) {
                continue;
            }
            let target = walk.target(step);
            match advance(walk, operation, target, position, active) {
                Ok((position, active)) => {
                    let next = (target, position, active);
                    edges.push((place, next, step));
                    open.push(next);
                }
                Err(found) => return Some(*found),
            }
        }
    }
    endless(walk, operation, &seen, &edges)
}

/// Nodes at which the operation can begin: the start, and nodes after the last step of an
/// operation.
fn beginnings(walk: &Walk<'_>, operation: &Operation, done: &Expr) -> BTreeSet<Node> {
    let mut found = BTreeSet::new();
    if walk.can_begin(None, operation.value) {
        found.insert(Node::Start);
    }
    for step in walk.steps() {
        if walk.known(step.from, done) != Expr::FALSE && walk.can_begin(Some(step), operation.value)
        {
            found.insert(walk.target(step));
        }
    }
    found
}

/// Simplifies an expression at a node, with the wire of the operation set to this operation.
fn specialized(walk: &Walk<'_>, node: Node, expr: &Expr, operation: &Operation) -> Expr {
    let with = expr.substitute(&mut |w, t| {
        if w == VarId(0) && t == Time::Now {
            Expr::Const(operation.value)
        } else {
            Expr::Var(w, t)
        }
    });
    walk.known(node, &with)
}

/// Whether a condition holds in every step at a node, given the guarantees of the actions.
fn is_certain(walk: &Walk<'_>, node: Node, condition: &Expr) -> bool {
    let question = Question {
        at: (Some(node), None),
        ..Question::plain(condition)
    };
    walk.ask(0, &question) == Answer::Holds
}

/// Returns the position in the sequence and the active action after a node, or a finding about that
/// node.
fn advance(
    walk: &Walk<'_>,
    operation: &Operation,
    node: Node,
    position: usize,
    before: Option<usize>,
) -> Result<(usize, Option<usize>), Box<Diagnostic>> {
    let components = walk.machine.components.iter().enumerate();
    let now = components
        .filter(|(_, c)| {
            c.active
                .as_ref()
                .is_some_and(|a| is_certain(walk, node, &specialized(walk, node, a, operation)))
        })
        .map(|(i, _)| i)
        .next();
    match now {
        Some(action) if now != before => {
            if operation.sequence.get(position) == Some(&action) {
                Ok((position + 1, now))
            } else {
                Err(Box::new(wrong(walk, operation, position, Some(action))))
            }
        }
        _ => Ok((position, now)),
    }
}

/// Creates the finding for a position at which the coordinator does not follow the operation's
/// sequence: it requests the action `found`, or, for `None`, reports completion.
fn wrong(
    walk: &Walk<'_>,
    operation: &Operation,
    position: usize,
    found: Option<usize>,
) -> Diagnostic {
    let name = |i: usize| format!("`{}`", walk.machine.components[i].name);
    let expected = operation
        .sequence
        .get(position)
        .map_or("ends there".to_owned(), |i| {
            format!("lists {} next", name(*i))
        });
    let does = found.map_or("report completion".to_owned(), |i| {
        format!("request {}", name(i))
    });
    Diagnostic::warning(
        codes::OPERATION,
        operation.span,
        format!(
            "after {} of `{}`, the coordinator can {does}, but the operation {expected}",
            messages::format_action_count(position),
            operation.name
        ),
    )
    .with_help("change the operation's list or the coordinator's contract so that they agree")
}

/// Reports a cycle in which the operation never ends although every justice assumption of the
/// coordinator can hold in that cycle.
fn endless(
    walk: &Walk<'_>,
    operation: &Operation,
    places: &BTreeSet<Place>,
    edges: &[(Place, Place, Step)],
) -> Option<Diagnostic> {
    let chosen = Expr::now(VarId(0)).equals(Expr::Const(operation.value));
    let justice: Vec<Expr> = walk.machine.components[0]
        .specification
        .assumptions
        .justice
        .iter()
        .map(|f| over_wires(walk.machine, 0, &f.expr))
        .collect();
    let going = walk
        .machine
        .done
        .as_ref()
        .map_or(Expr::TRUE, |d| d.clone().not());
    let order: Vec<Place> = places.iter().copied().collect();
    let index = |p: &Place| order.binary_search(p).unwrap_or(0);
    for component in strongly_connected(
        order.len(),
        edges.iter().map(|(a, b, _)| (index(a), index(b))),
    ) {
        let inner: Vec<&(Place, Place, Step)> = edges
            .iter()
            .filter(|(a, b, _)| component.contains(&index(a)) && component.contains(&index(b)))
            .collect();
        if inner.is_empty() {
            continue;
        }
        let fair = justice.iter().all(|goal| {
            inner.iter().any(|(_, _, step)| {
                walk.is_possible(*step, &[chosen.clone(), going.clone(), goal.clone()])
            })
        });
        if fair {
            let next = order[*component.first()?].1;
            let at = operation
                .sequence
                .get(next)
                .map_or("the end".to_owned(), |i| {
                    format!("`{}`", walk.machine.components[*i].name)
                });
            return Some(
                Diagnostic::warning(
                    codes::REQUEST_INCOMPLETE,
                    operation.span,
                    format!(
                        "the operation `{}` might never end: it can wait before {at} forever",
                        operation.name
                    ),
                )
                .with_help(
                    "let the coordinator guarantee that it continues after each executed action",
                ),
            );
        }
    }
    None
}

/// The strongly connected components of a graph, by Kosaraju's two passes; without recursion.
fn strongly_connected(
    nodes: usize,
    edges: impl Iterator<Item = (usize, usize)>,
) -> Vec<BTreeSet<usize>> {
    let mut forward = vec![Vec::new(); nodes];
    let mut backward = vec![Vec::new(); nodes];
    for (a, b) in edges {
        forward[a].push(b);
        backward[b].push(a);
    }
    let mut finished = Vec::with_capacity(nodes);
    let mut seen = vec![false; nodes];
    for root in 0..nodes {
        if seen[root] {
            continue;
        }
        seen[root] = true;
        let mut stack = vec![(root, 0)];
        while let Some((node, next)) = stack.pop() {
            if let Some(&child) = forward[node].get(next) {
                stack.push((node, next + 1));
                if !seen[child] {
                    seen[child] = true;
                    stack.push((child, 0));
                }
            } else {
                finished.push(node);
            }
        }
    }
    let mut components = Vec::new();
    let mut taken = vec![false; nodes];
    for root in finished.into_iter().rev() {
        if taken[root] {
            continue;
        }
        taken[root] = true;
        let mut component = BTreeSet::new();
        let mut stack = vec![root];
        while let Some(node) = stack.pop() {
            component.insert(node);
            for &before in &backward[node] {
                if !taken[before] {
                    taken[before] = true;
                    stack.push(before);
                }
            }
        }
        components.push(component);
    }
    components
}
