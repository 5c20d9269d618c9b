//! The graph of all that can happen while a recipe is made, explored breadth first.
//!
//! A *place* is a state of the recipe with a configuration of the cell: all transitions of the
//! recipe that leave the state have to be realized from there (AND). A *task* is a transition of
//! the recipe, the number of its steps that have been performed, and a configuration: one of the
//! vectors has to lead on (OR). Each vector costs one, and everything else nothing.

use super::SearchLimits;
use super::cell::{Cell, Work};
use super::moves::Moves;
use crate::intern::Interner;

/// A node that cannot exist: the recipe may not end like this, or a test cannot be performed.
pub(super) const DEAD: u32 = u32::MAX;
/// Second word of a place; that of a task is its number of steps.
const PLACE: u16 = u16::MAX;

/// The explored graph.
pub(super) struct Graph<'c> {
    pub cell: &'c Cell,
    /// Each node as two words (state of the recipe, or transition and steps), then a
    /// configuration.
    nodes: Interner,
    /// Targets of all edges.
    edges: Vec<u32>,
    /// Number of events in each edge's vector, at most 255.
    weights: Vec<u8>,
    /// The edges of each node, as a range.
    ranges: Vec<(usize, usize)>,
    /// For a task without further steps, the place that it ends in.
    pub stops: Vec<u32>,
    /// Number of vectors before each node.
    depth: Vec<u32>,
    /// Tasks in the order of exploration.
    queue: Vec<u32>,
    /// Number of tasks explored.
    done: usize,
    /// Number of vectors tried.
    pub vectors: usize,
    /// For each transition of the recipe, the most steps that were performed.
    pub furthest_steps: Vec<Option<usize>>,
    /// New nodes whose edges without cost have not been added.
    fresh: Vec<u32>,
}

impl<'c> Graph<'c> {
    /// Creates a graph with the start.
    pub fn new(cell: &'c Cell) -> Self {
        let mut graph = Self {
            cell,
            nodes: Interner::default(),
            edges: Vec::new(),
            weights: Vec::new(),
            ranges: Vec::new(),
            stops: Vec::new(),
            depth: Vec::new(),
            queue: Vec::new(),
            done: 0,
            vectors: 0,
            furthest_steps: vec![None; cell.works.len()],
            fresh: Vec::new(),
        };
        graph.place(cell.start, &cell.configuration, 0);
        graph.settle();
        graph
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns whether all that can be reached has been explored.
    pub fn is_complete(&self) -> bool {
        self.done == self.queue.len()
    }

    /// Returns the state of the recipe if the node is a place.
    pub fn place_of(&self, node: u32) -> Option<u16> {
        let words = self.nodes.get(node);
        (words[1] == PLACE).then_some(words[0])
    }

    /// Returns the transition of the recipe and the number of steps of a task.
    pub fn task_of(&self, node: u32) -> (usize, usize) {
        let words = self.nodes.get(node);
        (words[0] as usize, words[1] as usize)
    }

    /// Returns the configuration of a node.
    pub fn configuration(&self, node: u32) -> &[u16] {
        &self.nodes.get(node)[2..]
    }

    /// Returns the edges of a node, each with the number of its events. For a place, they are in
    /// the order of the transitions that leave the state.
    pub fn edges(&self, node: u32) -> impl ExactSizeIterator<Item = (u32, u8)> + '_ {
        let (begin, end) = self.ranges[node as usize];
        (begin..end).map(|at| (self.edges[at], self.weights[at]))
    }

    /// Returns a lower bound on the worst case of each controller that is not in the explored part.
    pub fn least_unexplored(&self) -> u32 {
        let open = self.queue[self.done..].iter();
        let bound = open.map(|node| {
            let (number, step) = self.task_of(*node);
            let work = &self.cell.works[number];
            let steps = (work.steps.len() - step) as u32 + self.cell.steps_after(work);
            self.depth[*node as usize] + steps
        });
        bound.min().unwrap_or(u32::MAX)
    }

    /// Explores until there are `until` nodes, or everything is explored, or a limit is reached.
    /// Returns whether it stopped at a limit.
    pub fn explore(&mut self, moves: &mut Moves<'_>, until: usize, limits: SearchLimits) -> bool {
        let mut found: Vec<(u32, u8)> = Vec::new();
        while self.done < self.queue.len() && self.len() < until {
            let node = self.queue[self.done];
            let words = self.nodes.get(node).to_vec();
            let (number, step) = (words[0] as usize, words[1] as usize);
            let work: &Work = &self.cell.works[number];
            let depth = self.depth[node as usize] + 1;
            found.clear();
            let within = moves.each(
                &words[2..],
                work.steps.get(step).map(Vec::as_slice),
                &mut |vector, target, performs| {
                    self.vectors += 1;
                    let next = self.arrive(number, step + usize::from(performs), target, depth);
                    if next != DEAD {
                        found.push((next, vector.len().min(255) as u8));
                    }
                    self.len() <= limits.nodes && self.vectors <= limits.vectors
                },
            );
            if !within {
                return true;
            }
            let begin = self.edges.len();
            self.edges.extend(found.iter().map(|f| f.0));
            self.weights.extend(found.iter().map(|f| f.1));
            self.ranges[node as usize] = (begin, self.edges.len());
            self.settle();
            self.done += 1;
        }
        false
    }

    /// Returns the node for a transition of the recipe of which some steps have been performed.
    fn arrive(&mut self, number: usize, steps: usize, configuration: &[u16], depth: u32) -> u32 {
        let furthest = &mut self.furthest_steps[number];
        *furthest = (*furthest).max(Some(steps));
        let work = &self.cell.works[number];
        let tested = !self.cell.recipe_states[work.to as usize].tests.is_empty();
        if steps == work.steps.len() && !tested {
            self.place(work.to, configuration, depth)
        } else {
            self.node([number as u16, steps as u16], configuration, depth)
        }
    }

    /// Returns the place for a state of the recipe, or [`DEAD`].
    fn place(&mut self, state: u16, configuration: &[u16], depth: u32) -> u32 {
        let held = &configuration[self.cell.resources()..];
        let about = &self.cell.recipe_states[state as usize];
        let testable = (about.tests.iter())
            .all(|(inputs, resources)| resources.iter().any(|r| self.cell.holds(*r, inputs, held)));
        let left_over = || {
            let mut kinds = held.chunks_exact(2).map(|p| p[1]);
            kinds.any(|kind| !self.cell.may_remain[kind as usize])
        };
        if !testable || (about.is_end && left_over()) {
            DEAD
        } else {
            self.node([state, PLACE], configuration, depth)
        }
    }

    fn node(&mut self, tag: [u16; 2], configuration: &[u16], depth: u32) -> u32 {
        let words = [&tag, configuration].concat();
        let (node, is_new) = self.nodes.intern(&words);
        if is_new {
            self.ranges.push((0, 0));
            self.stops.push(DEAD);
            self.depth.push(depth);
            self.fresh.push(node);
        }
        node
    }

    /// Adds the edges without cost of new nodes, and puts new tasks into the queue.
    fn settle(&mut self) {
        let mut next = 0;
        while let Some(node) = self.fresh.get(next).copied() {
            next += 1;
            let depth = self.depth[node as usize];
            let configuration = self.configuration(node).to_vec();
            let Some(state) = self.place_of(node) else {
                let (number, steps) = self.task_of(node);
                let work = &self.cell.works[number];
                if steps == work.steps.len() {
                    self.stops[node as usize] = self.place(work.to, &configuration, depth);
                }
                self.queue.push(node);
                continue;
            };
            let leaving = &self.cell.recipe_states[state as usize].leaving;
            let children: Vec<u32> = (leaving.iter())
                .map(|number| self.arrive(*number as usize, 0, &configuration, depth))
                .collect();
            let begin = self.edges.len();
            self.edges.extend(&children);
            self.weights.resize(self.edges.len(), 0);
            self.ranges[node as usize] = (begin, self.edges.len());
        }
        self.fresh.clear();
    }
}
