//! Computes a deterministic strategy for a won game: for every goal, the answer to each next input
//! in each state.
//!
//! There are four steps, each of which keeps at least one winning move wherever one exists:
//!
//! 1. *Preference.* Of the winning moves, keep the best kind that is possible (Bloem et al. 2012,
//!    section 4): reach the goal, and get as close to the next goal as possible; or else get as
//!    close to this goal as possible; or else wait while an assumption fails. If many valuations
//!    could occur, or a small number of states is preferred, keep only moves into a small closed
//!    set of states.
//! 2. *Forgetting.* A move should depend on as few inputs as possible, since the machine has to
//!    remember current inputs, and next inputs make its guards longer. Input by input, prefer moves
//!    that are correct for every value of that input. Combinations of values that cannot occur in a
//!    play count as correct.
//! 3. *Choice.* One after the other, each output keeps its value where possible, and otherwise
//!    takes the smallest possible value.
//! 4. *Reachability.* Compute the reachable states, so that all others can be omitted.
//!
//! The pursued goal is not encoded in bits: there is one relation per goal. In addition to the next
//! outputs, a relation determines a flag `g`: the number of consecutive goals that the transition
//! reaches, starting with the pursued one. The goal after these is pursued next.

use super::arena::Arena;
use super::fixpoint::{Layer, layers};
use crate::symbolic::{Bit, BitSet, Kernel, Limit};
use linewright_core::gr1::{Owner, Specification, Time, Timing, VarId};

/// Number of valuations, summed over the goals, above which moves are restricted to a small set of
/// states; see `gather`.
const MANY_VALUATIONS: f64 = 5_000.0;

/// What a machine is optimized for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Preference {
    /// Reaching the next goal in few steps.
    #[default]
    Reaction,
    /// A small number of states.
    States,
}

/// A deterministic strategy.
#[derive(Debug)]
pub struct Strategy<K: Kernel> {
    /// For each goal, the transitions (x, y, x′, y′, g) of the strategy. Meaningless in unreachable
    /// states.
    pub moves: Vec<K::Function>,
    /// For each goal, the states (x, y) in which it is pursued.
    pub reachable: Vec<K::Function>,
    /// The initial valuations (x, y), over current bits.
    pub initial: K::Function,
    /// The bits of the flag g, most significant first: the number of consecutive goals that a
    /// transition reaches, starting with the pursued one.
    pub flag: [Bit; 2],
}

/// Computes a strategy; `region` is the winning region.
pub fn strategy<K: Kernel>(
    arena: &Arena<K>,
    specification: &Specification,
    preference: Preference,
    region: &K::Function,
) -> Result<Strategy<K>, Limit> {
    let builder = StrategyBuilder::new(arena, specification, region)?;
    let goals = arena.goals.len();
    let layers: Vec<Vec<Layer<K>>> = (0..goals)
        .map(|j| layers(arena, j, region))
        .collect::<Result<_, _>>()?;
    let initial = builder.initial()?;

    let mut wide = Vec::new();
    for j in 0..goals {
        let mut targets = builder.targets(j, &layers[j], &layers[(j + 1) % goals])?;
        if preference == Preference::States {
            targets = vec![builder.union(targets)?];
        }
        wide.push(match arena.timing {
            Timing::Mealy => builder.first_feasible_mealy(&targets)?,
            Timing::Moore => builder.first_feasible_moore(&targets)?,
        });
    }
    // Moves have to be correct only in the reachable states. A superset of these states is used
    // because it is cheaper to compute.
    let mut possible = builder.reachable(&wide, &initial)?;
    let gather = preference == Preference::States || builder.count(&possible) > MANY_VALUATIONS;
    if gather && arena.timing == Timing::Mealy {
        possible = builder.gather(&wide, &initial)?;
        for (j, moves) in wide.iter_mut().enumerate() {
            *moves = builder.moves_into(moves, j, &possible)?;
        }
    }
    let mut moves = Vec::new();
    for j in 0..goals {
        let chosen = builder.choose(&builder.forget(&wide[j], &possible[j])?)?;
        moves.push(builder.with_flag(&chosen, j)?);
    }
    drop(wide);
    let reachable = builder.reachable(&moves, &initial)?;
    Ok(Strategy {
        moves,
        reachable,
        initial,
        flag: builder.flag,
    })
}

struct StrategyBuilder<'a, K: Kernel> {
    arena: &'a Arena<K>,
    specification: &'a Specification,
    region: &'a K::Function,
    environment: K::Function,
    system: K::Function,
    now: BitSet,
    flag: [Bit; 2],
}

impl<'a, K: Kernel> StrategyBuilder<'a, K> {
    fn new(
        arena: &'a Arena<K>,
        specification: &'a Specification,
        region: &'a K::Function,
    ) -> Result<Self, Limit> {
        let now = arena.inputs_now.iter().chain(arena.outputs_now.iter());
        Ok(Self {
            arena,
            specification,
            region,
            environment: arena.environment_moves()?,
            system: arena.system_moves()?,
            now: BitSet::new(now),
            flag: [0, 1].map(|i| Bit(2 * arena.encoding.pairs() as u16 + i)),
        })
    }

    /// Returns the valuations of step 0, with the smallest possible outputs, since there are no
    /// earlier values to keep.
    fn initial(&self) -> Result<K::Function, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let mut good = m.and(&arena.sys_initial, self.region)?;
        if arena.timing == Timing::Moore {
            good = m.implies_forall(&arena.env_initial, &good, &arena.inputs_now)?;
        }
        let good = self.smallest(good, Time::Now)?;
        m.and(&good, &arena.env_initial)
    }

    /// Returns the kinds of transitions to prefer in pursuit of goal `j`, the best kind first.
    /// `own` and `next` are the layers of this goal and of the next one.
    fn targets(
        &self,
        j: usize,
        own: &[Layer<K>],
        next: &[Layer<K>],
    ) -> Result<Vec<K::Function>, Limit> {
        let m = &self.arena.kernel;
        let goal = &self.arena.goals[j];
        let mut targets = Vec::new();
        for layer in next {
            targets.push(m.and(goal, &m.prime(&layer.reached)?)?);
        }
        for layer in own {
            let nearer = m.and_not(&m.prime(&layer.reached)?, &layer.reached)?;
            targets.push(nearer);
        }
        let mut waiting = m.constant(false);
        let mut below = m.constant(false);
        for layer in own {
            let here = m.and_not(&layer.wait, &below)?;
            let idle = m.and_not(
                &m.prime(&layer.wait)?,
                &self.arena.assumptions[layer.assumption],
            )?;
            waiting = m.or(&waiting, &m.and(&here, &idle)?)?;
            below = layer.reached.clone();
        }
        targets.push(waiting);
        Ok(targets)
    }

    /// Returns the union of all targets. Every move in it makes progress toward the goal or waits
    /// while an assumption fails.
    fn union(&self, targets: Vec<K::Function>) -> Result<K::Function, Limit> {
        let mut any = self.arena.kernel.constant(false);
        for target in targets {
            any = self.arena.kernel.or(&any, &target)?;
        }
        Ok(any)
    }

    /// Returns, for every state of the region and every next input, the moves of the best possible
    /// kind.
    fn first_feasible_mealy(&self, targets: &[K::Function]) -> Result<K::Function, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let mut todo = m.and(self.region, &self.environment)?;
        let mut moves = m.constant(false);
        for target in targets {
            if m.is_false(&todo) {
                break;
            }
            let possible = m.and(&m.and(&todo, target)?, &self.system)?;
            todo = m.and_not(&todo, &m.exists(&possible, &arena.outputs_next)?)?;
            moves = m.or(&moves, &possible)?;
        }
        debug_assert!(m.is_false(&todo), "a winning state without a winning move");
        Ok(moves)
    }

    /// Returns, for every state of the region, the next outputs that are of the best possible kind
    /// and correct for all next inputs. Over (x, y, y′).
    fn first_feasible_moore(&self, targets: &[K::Function]) -> Result<K::Function, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let mut todo = self.region.clone();
        let mut moves = m.constant(false);
        let mut aim = m.constant(false);
        for target in targets {
            if m.is_false(&todo) {
                break;
            }
            aim = m.or(&aim, target)?;
            let possible = m.and(&arena.for_all_inputs(&aim)?, &self.system)?;
            let possible = m.and(&todo, &possible)?;
            todo = m.and_not(&todo, &m.exists(&possible, &arena.outputs_next)?)?;
            moves = m.or(&moves, &possible)?;
        }
        debug_assert!(m.is_false(&todo), "a winning state without a winning move");
        Ok(moves)
    }

    /// Prefers moves that do not depend on inputs, one input after the other. Only `possible`
    /// states and inputs that keep the assumptions matter.
    fn forget(&self, moves: &K::Function, possible: &K::Function) -> Result<K::Function, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let mut care = possible.clone();
        if arena.timing == Timing::Mealy {
            care = m.and(&care, &self.environment)?;
        }
        let mut allowed = m.implies(&care, moves)?;
        // Next inputs are forgotten, too, to shorten the guards. They come last, since reading an
        // input is better than remembering it.
        //
        // The first round forgets a current input only where that is correct for all next inputs.
        // Otherwise the machine might forget a command but remember other inputs that reveal it.
        let rounds = [(Time::Now, true), (Time::Now, false), (Time::Next, false)];
        let inputs = |round| self.specification.inputs().map(move |v| (v, round));
        for (input, (time, for_all_inputs)) in rounds.into_iter().flat_map(inputs) {
            let bits = arena.encoding.bit_set([input], time);
            if !bits.iter().any(|b| m.depends_on(&allowed, b)) {
                continue;
            }
            let always = m.forall(&allowed, &bits)?;
            let mut offers = m.exists(&always, &arena.outputs_next)?;
            if for_all_inputs {
                offers = m.forall(&offers, &arena.inputs_next)?;
            }
            allowed = m.ite(&offers, &always, &allowed)?;
        }
        Ok(allowed)
    }

    /// Fixes the next outputs: each output keeps its value where possible, and otherwise takes the
    /// smallest possible value.
    fn choose(&self, moves: &K::Function) -> Result<K::Function, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let mut moves = moves.clone();
        for output in self.outputs() {
            let same = arena.encoding.unchanged(m, output)?;
            moves = self.prefer(&moves, &same, &arena.outputs_next)?;
            for bit in arena.encoding.bits(output, Time::Next) {
                moves = self.prefer(&moves, &m.literal(bit, false), &arena.outputs_next)?;
            }
        }
        Ok(moves)
    }

    /// Restricts the relation to the smallest current or next outputs, one output after the other.
    fn smallest(&self, mut relation: K::Function, time: Time) -> Result<K::Function, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let answers = match time {
            Time::Now => &arena.outputs_now,
            Time::Next => &arena.outputs_next,
        };
        for output in self.outputs() {
            for bit in arena.encoding.bits(output, time) {
                relation = self.prefer(&relation, &m.literal(bit, false), answers)?;
            }
        }
        Ok(relation)
    }

    /// Restricts the relation to answers that satisfy `preferred`, wherever there are any.
    fn prefer(
        &self,
        relation: &K::Function,
        preferred: &K::Function,
        answers: &BitSet,
    ) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        let satisfying = m.and(relation, preferred)?;
        let possible = m.exists(&satisfying, answers)?;
        m.or(&satisfying, &m.and_not(relation, &possible)?)
    }

    /// Adds the flag: the number of goals that the transition reaches from goal `j` on.
    fn with_flag(&self, moves: &K::Function, j: usize) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        let mut moves = moves.clone();
        for (bit, holds) in self.flag.into_iter().zip(self.reached(j)?) {
            moves = m.and(&moves, &m.iff(&m.literal(bit, true), &holds)?)?;
        }
        Ok(moves)
    }

    /// Returns the number of consecutive goals that a transition reaches, from goal `j` on and up
    /// to three, as two bits, most significant first. With a single goal it is always 0, since
    /// there is nothing to remember.
    fn reached(&self, j: usize) -> Result<[K::Function; 2], Limit> {
        let (m, goals) = (&self.arena.kernel, &self.arena.goals);
        let mut all = m.constant(goals.len() > 1);
        let mut at_least = Vec::new();
        for k in 0..3 {
            all = if k < goals.len() {
                m.and(&all, &goals[(j + k) % goals.len()])?
            } else {
                m.constant(false)
            };
            at_least.push(all.clone());
        }
        let odd = m.or(&m.and_not(&at_least[0], &at_least[1])?, &at_least[2])?;
        Ok([at_least.swap_remove(1), odd])
    }

    /// Groups steps in pursuit of goal `j` by the goal that is pursued after them.
    fn by_goal(&self, steps: K::Function, j: usize) -> Result<Vec<(usize, K::Function)>, Limit> {
        let m = &self.arena.kernel;
        let goals = self.arena.goals.len();
        if goals == 1 {
            return Ok(vec![(0, steps)]);
        }
        let [high, low] = self.reached(j)?;
        let (many, few) = (m.and(&steps, &high)?, m.and_not(&steps, &high)?);
        Ok(vec![
            ((j + 3) % goals, m.and(&many, &low)?),
            ((j + 2) % goals, m.and_not(&many, &low)?),
            ((j + 1) % goals, m.and(&few, &low)?),
            (j, m.and_not(&few, &low)?),
        ])
    }

    /// Returns the moves in pursuit of goal `j` that lead into `states`. For each goal, `states`
    /// holds the allowed states in which that goal is pursued.
    fn moves_into(
        &self,
        moves: &K::Function,
        j: usize,
        states: &[K::Function],
    ) -> Result<K::Function, Limit> {
        let m = &self.arena.kernel;
        let mut into = m.constant(false);
        for (k, steps) in self.by_goal(moves.clone(), j)? {
            into = m.or(&into, &m.and(&steps, &m.prime(&states[k])?)?)?;
        }
        Ok(into)
    }

    /// Returns a small set of states for every goal. The sets are closed: from each state, every
    /// legal next input has an answer that leads into one of the sets. An answer that leads into a
    /// known state is preferred. Otherwise a new state is added, and the same new state is used for
    /// as many source states as possible.
    fn gather(
        &self,
        moves: &[K::Function],
        initial: &K::Function,
    ) -> Result<Vec<K::Function>, Limit> {
        let (arena, m) = (self.arena, &self.arena.kernel);
        let goals = moves.len();
        let mut known = vec![m.constant(false); goals];
        let mut fresh = known.clone();
        fresh[0] = initial.clone();
        known[0] = initial.clone();
        while let Some(j) = (0..goals).find(|j| !m.is_false(&fresh[*j])) {
            let from = std::mem::replace(&mut fresh[j], m.constant(false));
            let mut todo = m.and(&m.and(&moves[j], &from)?, &self.environment)?;
            loop {
                m.safe_point()?;
                let served = self.moves_into(&todo, j, &known)?;
                todo = m.and_not(&todo, &m.exists(&served, &arena.outputs_next)?)?;
                if m.is_false(&todo) {
                    break;
                }
                // Adds one more valuation for every remaining next input, shared by all states that
                // can answer with it.
                for (k, steps) in self.by_goal(todo.clone(), j)? {
                    let offers = self.smallest(m.exists(&steps, &self.now)?, Time::Next)?;
                    let offers = m.unprime(&offers)?;
                    let more = m.and_not(&offers, &known[k])?;
                    fresh[k] = m.or(&fresh[k], &more)?;
                    known[k] = m.or(&known[k], &more)?;
                    if !m.is_false(&more) {
                        break;
                    }
                }
            }
        }
        Ok(known)
    }

    /// Returns the number of valuations, summed over the goals.
    fn count(&self, states: &[K::Function]) -> f64 {
        let states: Vec<&K::Function> = states.iter().collect();
        let shares = self.arena.kernel.export(&states).shares();
        shares.iter().sum::<f64>() * (self.now.iter().count() as f64).exp2()
    }

    /// Returns, for every goal, the reachable states in which it is pursued.
    fn reachable(
        &self,
        moves: &[K::Function],
        initial: &K::Function,
    ) -> Result<Vec<K::Function>, Limit> {
        let m = &self.arena.kernel;
        let goals = moves.len();
        let mut known = vec![m.constant(false); goals];
        let mut fresh = known.clone();
        fresh[0] = initial.clone();
        let mut relations = Vec::new();
        for relation in moves {
            relations.push(m.and(relation, &self.environment)?);
        }
        while let Some(j) = (0..goals).find(|j| !m.is_false(&fresh[*j])) {
            let from = std::mem::replace(&mut fresh[j], m.constant(false));
            known[j] = m.or(&known[j], &from)?;
            let steps = m.and(&relations[j], &from)?;
            let mut gone = self.now.clone();
            for bit in self.flag {
                gone.insert(bit);
            }
            for (k, steps) in self.by_goal(steps, j)? {
                let successors = m.unprime(&m.exists(&steps, &gone)?)?;
                fresh[k] = m.and_not(&m.or(&fresh[k], &successors)?, &known[k])?;
            }
        }
        Ok(known)
    }

    fn outputs(&self) -> impl Iterator<Item = VarId> {
        let variables = self.specification.variables.iter().enumerate();
        variables
            .filter(|(_, v)| v.owner == Owner::System)
            .map(|(i, _)| VarId(i as u32))
    }
}
