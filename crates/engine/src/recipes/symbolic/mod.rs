//! Whether a recipe can be made on a layout, by a symbolic game: for cells whose explicit search
//! reaches its limits. Sets of configurations are decision diagrams, so that many resources that
//! act independently of each other need no enumeration.

mod encode;

use encode::Encoding;
use linewright_core::gr1::eval::{eval, holds};
use linewright_recipe::controller::{Controller, Leg, Position, Vector};
use linewright_recipe::model::{Layout, Recipe};
use linewright_recipe::realize::cell::Cell;
use linewright_recipe::realize::{Outcome, Refusal, SearchSize};
use linewright_solver::game::{self, Budget, BudgetFactor, Limits, Rank, Ranking};

/// Limits of the game.
const BUDGET: Budget = Budget {
    work: 1_200_000_000,
    nodes: 4_000_000,
};

/// Decides whether a recipe can be made on a layout; both have no problems other than warnings.
/// `None` if some resource may not always wait, or if the game reaches its limits. A controller has
/// more vectors than necessary, one event each; a refusal does not say how far the recipe gets.
pub(super) fn decide(layout: &Layout, recipe: &Recipe, factor: BudgetFactor) -> Option<Outcome> {
    let cell = Cell::new(layout, recipe);
    let encoding = Encoding::new(&cell)?;
    let limits = Limits {
        budget_factor: factor,
        ..Limits::default()
    };
    let limits = limits.with_budget(BUDGET);
    let options = game::Options {
        limits,
        without_core: true,
        ..game::Options::default()
    };
    let specification = &encoding.specification;
    match game::solve_with(specification, &options).outcome {
        game::Outcome::Realizable(won) => {
            let limits = limits.with_budget_after(won.work(), BUDGET);
            let ranking = won.ranking(specification, &limits).ok()?;
            let controller = controller(&encoding, recipe, &ranking)?;
            Some(Outcome::Realizable(controller))
        }
        game::Outcome::Unrealizable(_) => Some(Outcome::Unrealizable(Refusal {
            obstacles: Vec::new(),
            furthest_steps: Vec::new(),
            size: SearchSize::default(),
        })),
        game::Outcome::GaveUp(_) => None,
    }
}

/// Follows a won game from place to place, one event at a time: each event leads to a layer nearer
/// to the next place.
struct Walk<'e, 'c> {
    encoding: &'e Encoding<'c>,
    ranking: &'e Ranking,
}

impl Walk<'_, '_> {
    /// The layer of a state that is won, given as the values of all variables.
    fn layer(&self, state: &[i64]) -> Option<usize> {
        let numbers = self.ranking.bits.iter().flatten();
        let most = numbers.max().map_or(0, |bit| usize::from(*bit) + 1);
        let mut bits = vec![false; most];
        for (numbers, value) in self.ranking.bits.iter().zip(state) {
            for (place, bit) in numbers.iter().rev().enumerate() {
                bits[usize::from(*bit)] = value >> place & 1 == 1;
            }
        }
        let layers = self.ranking.goals.first()?;
        let holds = |layer: &Rank| self.ranking.diagram.evaluate(layer.reached, &bits);
        layers.iter().position(holds)
    }

    /// The event that gets nearest to a place, and the state after it. `outcome` is that of the
    /// tests, if there are any now.
    fn step(&self, state: &[i64], outcome: usize) -> Option<(usize, Vec<i64>)> {
        let mut next = state.to_vec();
        next[self.encoding.outcome.index()] = outcome as i64;
        let mut best: Option<(usize, usize, Vec<i64>)> = None;
        for (number, event) in self.encoding.events.iter().enumerate() {
            if !holds(&event.enabled, state, &next) {
                continue;
            }
            let mut after = next.clone();
            for (variable, value) in &event.changes {
                after[variable.index()] = eval(value, state, &next);
            }
            after[self.encoding.event.index()] = number as i64;
            if let Some(layer) = self.layer(&after)
                && best.as_ref().is_none_or(|(least, ..)| layer < *least)
            {
                best = Some((layer, number, after));
            }
        }
        best.map(|(_, number, after)| (number, after))
    }

    /// The events from a place to the next one, after this outcome of its tests.
    fn leg(&self, place: &[i64], outcome: usize) -> Option<(Vec<Vector>, Vec<i64>)> {
        let (_, mut state) = self.step(place, outcome)?;
        let mut vectors = Vec::new();
        let mut layer = usize::MAX;
        while self.encoding.place(&state).is_none() {
            let (number, next) = self.step(&state, 0)?;
            let moves = &self.encoding.events[number].moves;
            if !moves.is_empty() {
                let mut moves = moves.clone();
                moves.sort_by_key(|m| m.resource);
                vectors.push(Vector { moves });
            }
            // Each event leads to a lower layer, or else there is a fault.
            let nearer = self.layer(&next).filter(|next| *next < layer);
            layer = nearer?;
            state = next;
        }
        Some((vectors, state))
    }
}

/// Reads the controller off a won game; `None` if that does not get from place to place, which
/// would be a fault.
fn controller(encoding: &Encoding<'_>, recipe: &Recipe, ranking: &Ranking) -> Option<Controller> {
    let walk = Walk { encoding, ranking };
    let mut places = vec![encoding.start.clone()];
    let mut positions: Vec<Position> = Vec::new();
    while let Some(place) = places.get(positions.len()).cloned() {
        let recipe_state = encoding.place(&place)?;
        let leaving = &encoding.cell.recipe_states[recipe_state].leaving;
        let mut legs = Vec::new();
        for (outcome, work) in leaving.iter().enumerate() {
            let (vectors, mut to) = walk.leg(&place, outcome)?;
            // What led here makes no difference from now on.
            to[encoding.event.index()] = 0;
            to[encoding.outcome.index()] = 0;
            let known = places.iter().position(|known| *known == to);
            legs.push(Leg {
                transition: *work as usize,
                vectors,
                to: known.unwrap_or(places.len()),
            });
            if known.is_none() {
                places.push(to);
            }
        }
        let (resource_states, parts) = encoding.configuration(&place);
        positions.push(Position {
            recipe_state,
            resource_states,
            parts,
            legs,
        });
    }
    let worst_case = worst_case(&positions, &recipe.closes_loop());
    Some(Controller {
        positions,
        worst_case,
        is_least: false,
    })
}

/// The most vectors from the start until the recipe ends or closes a loop.
fn worst_case(positions: &[Position], closes_loop: &[bool]) -> u32 {
    let mut costs = vec![0_u32; positions.len()];
    // Without the transitions that close loops, each round settles at least one position more.
    loop {
        let mut changed = false;
        for at in (0..positions.len()).rev() {
            let legs = positions[at].legs.iter();
            let most = legs.map(|leg| {
                let after = if closes_loop[leg.transition] {
                    0
                } else {
                    costs[leg.to]
                };
                leg.vectors.len() as u32 + after
            });
            let most = most.max().unwrap_or(0);
            changed |= most != costs[at];
            costs[at] = most;
        }
        if !changed {
            return costs.first().copied().unwrap_or(0);
        }
    }
}

#[cfg(test)]
mod tests;
