//! Determines whether a route is taken again and again with probability 1.
//!
//! If several routes remain for parts of a type, the values of a part decide which one it takes.
//! These values depend on chance and on what is left open here. A route is almost surely taken
//! again and again if every new part of the type has a chance to reach the route, whatever else
//! happens. The vertices for which this holds are the positive attractor of a game in which chance
//! helps and everything left open opposes (Chatterjee and Henzinger, "A survey of stochastic
//! omega-regular games", JCSS 78(2), 2012).
//!
//! The argument: The line holds finitely many values, so the chances are bounded from below. Each
//! part draws independently. Only finitely many parts are on their way at a time, so if infinitely
//! many are made, infinitely many take the route. A part that can go round for ever might prevent
//! others from being made. Therefore, a part that takes another route and can return must still
//! have a chance to take this route. A store holds any number of parts, so a way through a store
//! does not count.

use super::attractor::attractor;
use super::walk::{Choice, Stage, Walk};
use super::{Calls, is_alone};
use linewright_language::contract::line::NodeKind;

/// Marks the routes that chance guarantees. For each route, the run time is linear in the edges of
/// the walk.
pub(super) fn branches(walk: &Walk<'_>, calls: &mut Calls) {
    let before = walk.before();
    for route in 0..walk.line.routes.len() {
        if calls.taken[route] {
            calls.by_chance[route] = is_alone(walk.line, &calls.taken, route)
                || Branch::of(walk, &before, route).is_sure();
        }
    }
}

/// One of several alternative routes.
struct Branch<'a> {
    walk: &'a Walk<'a>,
    /// Type of the parts that take the route.
    part: usize,
    /// By vertex: whether a part there has a chance to take the route, however open choices are
    /// made.
    sure: Vec<bool>,
    /// By vertex: whether a part there can reach the start of the route.
    comes: Vec<bool>,
    /// Whether a part that has no chance to take the route can leave its start another way and
    /// return there: such a part could go round for ever.
    has_trap: bool,
}

impl<'a> Branch<'a> {
    fn of(walk: &'a Walk<'a>, before: &[Vec<usize>], index: usize) -> Self {
        let route = &walk.line.routes[index];
        let vertices = &walk.vertices;
        let at_branch = |v: usize| {
            let v = &vertices[v];
            v.stage == Stage::Leaves && (v.node, v.part) == (route.from, route.part)
        };
        let all = 0..vertices.len();
        let comes = attractor(before, all.clone().filter(|v| at_branch(*v)), |_| Some(1));
        // Each route of a choice is taken again and again if the choice is made again and again: in
        // turn, or by chance. Where a part goes to whichever place is free, they count as one.
        let first = walk.line.first_of_way(index);
        let takes = |v: &usize| vertices[*v].route == Some(first);
        let sure = attractor(before, all.clone().filter(takes), |v| {
            let v = &vertices[v];
            let in_store = v.stage == Stage::Comes
                && matches!(walk.line.nodes[v.node].kind, NodeKind::Store { .. });
            let wanted = match v.choice {
                Choice::Chance => 1,
                Choice::Open => v.next.len(),
            };
            (!in_store).then_some(wanted)
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

    /// Whether infinitely many parts of a type reach the route if infinitely many are made. For
    /// joined parts, it suffices that this holds for one of their components.
    fn made_surely(&self, part: usize, depth: usize) -> bool {
        let vertices = &self.walk.vertices;
        let counts = |v: &usize| self.comes[*v] && vertices[*v].part == part;
        let mut sources = self.walk.origins.iter().copied().filter(counts);
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
