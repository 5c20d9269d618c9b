//! The search for a plan of least cost.
//!
//! Between two tests nothing depends on their outcomes, so a *segment* is a search for one way: A*
//! (P. E. Hart, N. J. Nilsson, B. Raphael, 1968) over states with sets of times, with the bounds of
//! [`super::bounds`]. A state is left out if another one of the segment has the same resources and
//! parts, costs no more and permits all its times. A test ends a segment; each of its outcomes
//! begins one, whose times are counted from the test. What a segment costs depends only on its
//! root, so each root is solved once. The cost of a test is the greatest of its outcomes, so the
//! first way of a segment that the queue gives out is the best.
//!
//! All that begins after a test begins no earlier than the test. Without resources that may not
//! wait, it is best to begin everything before a test as early as possible. Otherwise, a later test
//! may be better if something else is going on at the same time; some times are tried then, and the
//! bound of such a test counts as a bound of the plan.
//!
//! Loops are a greatest fixpoint, as in [`crate::realize`]: a transition that closes a loop ends
//! the count in a *position*, which has to have a plan of its own; positions without one are
//! refuted.

mod expand;

use super::Objective;
use super::bounds::{Bounds, is_never};
use super::shop::Shop;
use super::state::{Happening, PLACE, Settled, State};
use super::zone::Zone;
use rustc_hash::{FxHashMap, FxHashSet, FxHasher};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::hash::{Hash, Hasher};
use std::rc::Rc;

/// Stands for a bound that nothing can keep.
pub(in crate::plan) const NONE: i64 = i64::MAX;

/// How a segment ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::plan) enum Stop {
    /// All products are finished.
    Ended,
    /// A product closes a loop. A slot is given if its product has waited for the resources that
    /// test it there.
    Loop(Option<usize>),
    /// The product of a slot is tested.
    Test(Test),
}

/// A test at the end of a segment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::plan) struct Test {
    pub slot: usize,
    /// Variables that it follows.
    pub after: Vec<u16>,
    /// Least time that was asked for.
    pub least: i64,
    /// Time from the root of the segment.
    pub time: i64,
    /// Least values of all variables.
    low: Vec<i64>,
}

/// The solution of a segment.
#[derive(Debug)]
pub(in crate::plan) struct Solved {
    /// Cost from the root in the worst case; `None` if no plan was found.
    pub value: Option<i64>,
    /// No plan costs less; [`NONE`] if there is none at all.
    pub lower: i64,
    /// What happens from the root.
    pub way: Vec<Happening>,
    pub stop: Stop,
}

/// Error: the limit of nodes was reached.
pub(in crate::plan) struct LimitReached;

/// A search, with all segments that it has solved.
pub(in crate::plan) struct Search<'s> {
    pub shop: &'s Shop<'s>,
    pub bounds: Bounds,
    objective: Objective,
    limit: usize,
    /// Number of states found.
    pub nodes: usize,
    solved: FxHashMap<(Vec<u16>, Zone), Rc<Solved>>,
    /// Positions that have no plan.
    refuted: FxHashSet<Vec<u16>>,
    /// Bound of the first segment as far as it has been searched.
    pub floor: i64,
    /// Whether a position was refuted that may have a plan.
    is_doubtful: bool,
}

/// A state of a segment.
struct Node {
    state: State,
    parent: u32,
    happening: Option<Happening>,
    cost: i64,
}

/// An entry of the queue.
enum Item {
    Open,
    Test(Test),
    Done(Stop),
}

/// The queue and the states of a segment.
struct Segment {
    /// Ways of at least this cost are not wanted.
    cutoff: i64,
    nodes: Vec<Node>,
    /// Cost, steps and transfers that are left at least, number of the item.
    queue: BinaryHeap<Reverse<(i64, u32, Reverse<usize>)>>,
    items: Vec<(u32, Item)>,
    seen: FxHashMap<u64, Vec<u32>>,
}

impl Segment {
    fn push(&mut self, cost: i64, left: u32, node: u32, item: Item) {
        self.queue
            .push(Reverse((cost, left, Reverse(self.items.len()))));
        self.items.push((node, item));
    }

    /// Returns whether a state with the same words costs no more and permits all times.
    fn is_dominated(&self, hash: u64, state: &State, cost: i64) -> bool {
        let same = self.seen.get(&hash).into_iter().flatten();
        let mut nodes = same.map(|n| &self.nodes[*n as usize]);
        nodes.any(|n| {
            n.cost <= cost && n.state.words == state.words && n.state.zone.includes(&state.zone)
        })
    }
}

fn hash(words: &[u16]) -> u64 {
    let mut hasher = FxHasher::default();
    words.hash(&mut hasher);
    hasher.finish()
}

impl<'s> Search<'s> {
    pub fn new(shop: &'s Shop<'s>, objective: Objective, limit: usize) -> Self {
        Self {
            shop,
            bounds: Bounds::new(shop, objective),
            objective,
            limit,
            nodes: 0,
            solved: FxHashMap::default(),
            refuted: FxHashSet::default(),
            floor: 0,
            is_doubtful: false,
        }
    }

    /// Returns a lower bound of all plans from a state.
    pub fn bound(&self, root: &State) -> i64 {
        self.bounds.least(self.shop, root, 0)
    }

    /// Solves a root of which only plans that cost less than `cutoff` are wanted. All positions of
    /// the plan have plans, too.
    pub fn run(&mut self, root: &State, cutoff: i64) -> Result<Rc<Solved>, LimitReached> {
        loop {
            if cutoff == NONE && !self.is_doubtful {
                let solved = self.solve(root)?;
                if solved.value.is_none() || self.confirm(root, &solved)? {
                    return Ok(solved);
                }
                self.solved.clear();
                continue;
            }
            let mut solved = self.segment(root, cutoff, true)?;
            if self.is_doubtful {
                solved.lower = solved.lower.min(self.bound(root));
            }
            let solved = Rc::new(solved);
            if solved.value.is_none() || self.confirm(root, &solved)? {
                return Ok(solved);
            }
            // What was found may rest on a position that has no plan.
            self.solved.clear();
        }
    }

    /// Solves all positions that a plan comes to. Returns whether each has a plan; those that have
    /// none are refuted.
    fn confirm(&mut self, root: &State, solved: &Rc<Solved>) -> Result<bool, LimitReached> {
        let mut seen: FxHashSet<(Vec<u16>, Zone)> = FxHashSet::default();
        let mut open = vec![(root.clone(), Rc::clone(solved))];
        let mut holds = true;
        while let Some((root, solved)) = open.pop() {
            if solved.value.is_none() {
                self.is_doubtful |= solved.lower != NONE;
                self.refuted.insert(root.words);
                holds = false;
                continue;
            }
            let (mut end, _) = self.follow(&root, &solved.way);
            let mut next = Vec::new();
            match &solved.stop {
                Stop::Ended => {}
                Stop::Loop(waits) => {
                    self.close_loop(&mut end, *waits);
                    next.push(self.position(&end));
                }
                Stop::Test(test) => {
                    next.extend(self.outcomes(&end, test).into_iter().map(|o| o.1));
                }
            }
            for root in next {
                if seen.insert((root.words.clone(), root.zone.clone())) {
                    let solved = self.solve(&root)?;
                    open.push((root, solved));
                }
            }
        }
        Ok(holds)
    }

    /// Returns the state after a way from a root, and the states before each happening.
    pub fn follow(&self, root: &State, way: &[Happening]) -> (State, Vec<State>) {
        let mut state = root.clone();
        state.origin = (0..self.shop.slots.len() as u16).collect();
        let mut states = Vec::new();
        if self.shop.advance(&mut state) == Settled::Open {
            self.shop.sort(&mut state);
        }
        for happening in way {
            let next = self.shop.apply(&state, happening);
            states.push(state);
            state = next.expect("the search has found the same");
            if self.shop.advance(&mut state) == Settled::Open {
                self.shop.sort(&mut state);
            }
        }
        (state, states)
    }

    /// Lets a product that waits before the end of a loop enter the state that begins it.
    pub fn close_loop(&self, state: &mut State, waits: Option<usize>) {
        if let Some(slot) = waits
            && let Some(place) = self.shop.pending(&state.words, slot)
        {
            state.set(slot, [place, PLACE]);
        }
    }

    /// Returns the root with the words of a state in which all times are 0.
    pub fn position(&self, state: &State) -> State {
        let mut root = State {
            words: state.words.clone(),
            zone: Zone::new(
                vec![0; state.zone.low.len()],
                self.shop.anchors(&state.words),
            ),
            origin: (0..self.shop.slots.len() as u16).collect(),
        };
        self.shop.sort(&mut root);
        root
    }

    /// Returns the transitions of the recipe that a test can lead to, each with the root of its
    /// segment.
    pub fn outcomes(&self, state: &State, test: &Test) -> Vec<(usize, State)> {
        let anchors = &state.zone.anchors;
        let low = test.low.iter().map(|low| (*low).max(test.time) - test.time);
        let mut low: Vec<i64> = low.collect();
        if let Some(clock) = self.shop.clock_variable() {
            low[clock as usize] = 0;
        }
        let zone = Zone::new(low, anchors.clone());
        let place = state.words[2 * test.slot];
        let leaving = &self.shop.cell(test.slot).recipe_states[place as usize].leaving;
        let outcome = |transition: &u16| {
            let mut root = State {
                words: state.words.clone(),
                zone: zone.clone(),
                origin: (0..self.shop.slots.len() as u16).collect(),
            };
            root.set(test.slot, [*transition, 0]);
            self.shop.sort(&mut root);
            (*transition as usize, root)
        };
        leaving.iter().map(outcome).collect()
    }

    /// Returns the solution of a root that has been solved.
    pub fn known(&self, root: &State) -> Option<Rc<Solved>> {
        let key = (root.words.clone(), root.zone.clone());
        self.solved.get(&key).cloned()
    }

    /// Returns the solution of a root, from the table if it is there.
    pub fn solve(&mut self, root: &State) -> Result<Rc<Solved>, LimitReached> {
        let key = (root.words.clone(), root.zone.clone());
        if let Some(solved) = self.solved.get(&key) {
            return Ok(Rc::clone(solved));
        }
        let solved = Rc::new(self.segment(root, NONE, false)?);
        self.solved.insert(key, Rc::clone(&solved));
        Ok(solved)
    }

    /// Searches a segment.
    fn segment(
        &mut self,
        root: &State,
        cutoff: i64,
        is_first: bool,
    ) -> Result<Solved, LimitReached> {
        let mut segment = Segment {
            cutoff,
            nodes: Vec::new(),
            queue: BinaryHeap::new(),
            items: Vec::new(),
            seen: FxHashMap::default(),
        };
        let mut start = root.clone();
        start.origin = (0..self.shop.slots.len() as u16).collect();
        self.add(&mut segment, start, None, u32::MAX, 0)?;
        let mut lower = NONE;
        while let Some(Reverse((cost, left, Reverse(number)))) = segment.queue.pop() {
            if cost >= cutoff {
                break;
            }
            if is_first {
                self.floor = cost.min(lower);
            }
            let (node, item) = (segment.items[number].0, &mut segment.items[number].1);
            match std::mem::replace(item, Item::Open) {
                Item::Open => self.expand(&mut segment, node, cost, &mut lower)?,
                Item::Test(test) => {
                    let at = &segment.nodes[node as usize];
                    let begin = if self.objective.is_time() {
                        test.time
                    } else {
                        at.cost
                    };
                    let (mut value, mut least) = (Some(0), 0);
                    for (_, outcome) in self.outcomes(&at.state, &test) {
                        let solved = self.solve(&outcome)?;
                        value = value.zip(solved.value).map(|(a, b)| a.max(b));
                        least = least.max(solved.lower);
                        if solved.lower == NONE {
                            break;
                        }
                    }
                    if least != NONE && value.is_none_or(|v| least < v) {
                        lower = lower.min(begin + least);
                    }
                    if let Some(value) = value {
                        segment.push(begin + value, left, node, Item::Done(Stop::Test(test)));
                    }
                }
                Item::Done(stop) => {
                    return Ok(Solved {
                        value: Some(cost),
                        lower: lower.min(cost),
                        way: way(&segment, node),
                        stop,
                    });
                }
            }
        }
        Ok(Solved {
            value: None,
            lower,
            way: Vec::new(),
            stop: Stop::Ended,
        })
    }

    /// Adds a state that has just been reached.
    fn add(
        &mut self,
        segment: &mut Segment,
        mut state: State,
        happening: Option<Happening>,
        parent: u32,
        cost: i64,
    ) -> Result<(), LimitReached> {
        let settled = self.shop.advance(&mut state);
        let stop = match settled {
            Settled::Dead => return Ok(()),
            Settled::Ended => Some(Stop::Ended),
            Settled::Loop => Some(Stop::Loop(None)),
            Settled::Open => None,
        };
        if let Some(stop) = stop {
            return self.finish(segment, state, happening, parent, cost, stop);
        }
        self.shop.sort(&mut state);
        let bound = self.bounds.least(self.shop, &state, cost);
        if is_never(bound) || bound >= segment.cutoff {
            return Ok(());
        }
        let hash = hash(&state.words);
        let own = if self.objective.is_time() { 0 } else { cost };
        if segment.is_dominated(hash, &state, own) {
            return Ok(());
        }
        let left = self.events_left(&state);
        let node = self.keep(segment, state, happening, parent, own)?;
        segment.seen.entry(hash).or_default().push(node);
        segment.push(bound, left, node, Item::Open);
        Ok(())
    }

    fn keep(
        &mut self,
        segment: &mut Segment,
        state: State,
        happening: Option<Happening>,
        parent: u32,
        cost: i64,
    ) -> Result<u32, LimitReached> {
        if self.nodes >= self.limit {
            return Err(LimitReached);
        }
        self.nodes += 1;
        segment.nodes.push(Node {
            state,
            parent,
            happening,
            cost,
        });
        Ok((segment.nodes.len() - 1) as u32)
    }

    /// Adds an end of the segment at which all resources are at rest.
    fn finish(
        &mut self,
        segment: &mut Segment,
        state: State,
        happening: Option<Happening>,
        parent: u32,
        cost: i64,
        stop: Stop,
    ) -> Result<(), LimitReached> {
        let all: Vec<u16> = (0..state.zone.low.len() as u16).collect();
        let Some((time, _)) = state.zone.settle(&all, 0, true) else {
            return Ok(());
        };
        if matches!(stop, Stop::Loop(_)) && self.refuted.contains(&self.position(&state).words) {
            return Ok(());
        }
        let (value, own) = if self.objective.is_time() {
            (time, 0)
        } else {
            (cost, cost)
        };
        if value >= segment.cutoff {
            return Ok(());
        }
        let node = self.keep(segment, state, happening, parent, own)?;
        segment.push(value, 0, node, Item::Done(stop));
        Ok(())
    }
}

/// Returns what happens from the root of a segment to a node.
fn way(segment: &Segment, node: u32) -> Vec<Happening> {
    let (mut way, mut at) = (Vec::new(), node);
    while let Some(node) = segment.nodes.get(at as usize) {
        way.extend(node.happening.clone());
        at = node.parent;
    }
    way.reverse();
    way
}
