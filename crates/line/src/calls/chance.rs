//! Whether chance sees to it that a route is taken again and again.
//!
//! Where several routes remain for parts of a type, which one a part takes is decided by its values, and these by chance and by what is left
//! open here. A route is taken again and again, almost surely, where every part of that type, when it is made, has a chance to come to that
//! route whatever else happens: the vertices from which that is so are the positive attractor of a game in which chance helps and all that is
//! left open does not (Chatterjee and Henzinger, "A survey of stochastic omega-regular games", JCSS 78(2), 2012). The line holds finitely
//! many values, so the chances are bounded from below; each part draws by itself; and only finitely many parts are on their way at a time, so
//! that infinitely many of those that are made take the route. That many are made is not said where a part can go round for ever: so a part
//! that goes another way and may come again has to have a chance still. A store holds any number of parts, so no way through one counts.

use super::Calls;
use super::walk::{Choice, Stage, Walk};
use linewright_language::contract::line::NodeKind;

/// Marks the routes that chance sees to.
pub(super) fn branches(walk: &Walk<'_>, calls: &mut Calls) {
    for (index, route) in walk.line.routes.iter().enumerate() {
        if !calls.taken[index] {
            continue;
        }
        let rivals = walk
            .line
            .routes
            .iter()
            .zip(&calls.taken)
            .filter(|(other, taken)| {
                **taken && (other.from, other.part) == (route.from, route.part)
            });
        calls.by_chance[index] = rivals.count() == 1 || Branch::of(walk, index).is_sure();
    }
}

/// A route among several.
struct Branch<'a> {
    walk: &'a Walk<'a>,
    /// The type that takes it.
    part: usize,
    /// By vertex: it has a chance to come to the route whatever is left open.
    sure: Vec<bool>,
    /// By vertex: it may come to where the route begins.
    comes: Vec<bool>,
    /// Whether a part may come to where the route begins, go another way, come there again, and have no chance of this route any more: it
    /// could go round for ever.
    has_trap: bool,
}

impl<'a> Branch<'a> {
    fn of(walk: &'a Walk<'a>, index: usize) -> Self {
        let route = &walk.line.routes[index];
        let vertices = &walk.vertices;
        let at_branch = |v: usize| {
            let v = &vertices[v];
            v.stage == Stage::Leaves && (v.node, v.part) == (route.from, route.part)
        };
        let all = 0..vertices.len();
        let mut comes: Vec<bool> = all.clone().map(at_branch).collect();
        let mut sure: Vec<bool> = vertices.iter().map(|v| v.route == Some(index)).collect();
        let grow = |marked: &mut Vec<bool>, step: &dyn Fn(&[bool], usize) -> bool| loop {
            let more: Vec<usize> = all
                .clone()
                .filter(|v| !marked[*v] && step(marked, *v))
                .collect();
            if more.is_empty() {
                break;
            }
            for v in more {
                marked[v] = true;
            }
        };
        grow(&mut comes, &|marked, v| {
            vertices[v].next.iter().any(|n| marked[*n])
        });
        grow(&mut sure, &|marked, v| {
            let v = &vertices[v];
            let in_store = v.stage == Stage::Comes
                && matches!(walk.line.nodes[v.node].kind, NodeKind::Store { .. });
            let mut next = v.next.iter().map(|n| marked[*n]);
            !in_store
                && match v.choice {
                    Choice::Chance => next.any(|n| n),
                    Choice::Open => !v.next.is_empty() && next.all(|n| n),
                }
        });
        let comes_again = |v: usize| at_branch(v) && vertices[v].next.iter().any(|n| comes[*n]);
        let has_trap = all.clone().any(|v| comes_again(v) && !sure[v]);
        Self {
            walk,
            part: route.part,
            sure,
            comes,
            has_trap,
        }
    }

    fn is_sure(&self) -> bool {
        !self.has_trap && self.made_surely(self.part, self.walk.line.parts.len())
    }

    /// Whether of infinitely many parts of a type infinitely many come to the route. What is joined may owe it to a component.
    fn made_surely(&self, part: usize, depth: usize) -> bool {
        let vertices = &self.walk.vertices;
        let counts = |v: &usize| self.comes[*v] && vertices[*v].part == part;
        let mut sources = self.walk.births.iter().copied().filter(counts);
        let joined = (0..vertices.len()).filter(|v| vertices[*v].stage == Stage::Joined);
        let mut joined = joined.filter(counts);
        let of_component = || {
            let bill = &self.walk.line.parts[part].bill;
            depth > 0
                && bill
                    .iter()
                    .any(|(kind, _)| self.made_surely(*kind, depth - 1))
        };
        sources.all(|v| self.sure[v]) && (joined.all(|v| self.sure[v]) || of_component())
    }
}
