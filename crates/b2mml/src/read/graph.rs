//! The graph of a workflow, and how it becomes the transitions of a recipe.
//!
//! Operations that one connection enters together are a *group*; it becomes a step. A transition
//! follows connections from a state through groups, each of which is entered and left by one
//! connection, to the next state. Where a group is entered or left otherwise, or left under a
//! guard, a state is put before or behind it. So every graph of states and operations can be read.

use super::problems::Places;
use super::source::Source;
use crate::finding::Rule;
use crate::xml::Element;
use linewright_recipe::model::{Guard, OperationCall, Part, Recipe, RecipeTransition, Step};
use rustc_hash::FxHashSet;

/// A node.
pub(super) struct Node {
    element: Element,
    /// Name of the state, or identifier of the operation.
    name: String,
    /// Operation; none for a state.
    call: Option<OperationCall>,
    /// Whether it is a state whose type says that it is the start.
    is_start: bool,
}

/// A connection in time.
pub(super) struct Flow {
    /// Its element.
    pub element: Element,
    /// Nodes that it leaves.
    pub from: Vec<usize>,
    /// Nodes that it enters.
    pub to: Vec<usize>,
    /// When it is taken.
    pub guard: Guard,
}

/// A workflow.
#[derive(Default)]
pub(super) struct Graph {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Connections in time.
    pub flows: Vec<Flow>,
    /// Connections of nodes that begin together.
    pub parallel: Vec<(Element, Vec<usize>)>,
    /// Whether a connection refers to nothing, so that the graph is incomplete.
    pub is_broken: bool,
}

impl Node {
    pub(super) fn state(element: Element, name: String, is_start: bool) -> Self {
        Self {
            element,
            name,
            call: None,
            is_start,
        }
    }

    pub(super) fn operation(element: Element, name: String, call: OperationCall) -> Self {
        Self {
            element,
            name,
            call: Some(call),
            is_start: false,
        }
    }
}

/// A state or a group.
#[derive(Clone, Copy)]
enum Vertex {
    /// Number of a node.
    State(usize),
    /// Number of a group.
    Group(usize),
}

/// Operations that begin together, and how they are connected.
#[derive(Default)]
struct Group {
    nodes: Vec<usize>,
    entering: usize,
    leaving: Vec<usize>,
    /// Name of the state that is put before it.
    before: Option<String>,
    /// Name of the state that is put behind it.
    behind: Option<String>,
    is_reached: bool,
}

impl Graph {
    /// Returns the parts that operations name, with their names as types.
    pub(super) fn mentioned_parts(&self) -> Vec<Part> {
        let calls = self.nodes.iter().filter_map(|n| n.call.as_ref());
        let names = calls.flat_map(|c| c.inputs.iter().chain(&c.outputs));
        let mut known = FxHashSet::default();
        let new = names.filter(|n| known.insert(*n));
        new.map(|n| Part::new(n, n)).collect()
    }

    /// Returns the state whose type says that it is the start, or else the one that no transition
    /// enters, if there is only one.
    pub(super) fn only_start(&self, recipe: &Recipe) -> Option<String> {
        let mut starts: Vec<&String> = self
            .nodes
            .iter()
            .filter(|n| n.is_start)
            .map(|n| &n.name)
            .collect();
        if starts.is_empty() {
            let entered: FxHashSet<&String> = recipe.transitions.iter().map(|t| &t.to).collect();
            starts = recipe
                .states
                .iter()
                .filter(|s| !entered.contains(s))
                .collect();
        }
        match starts.as_slice() {
            [only] => Some((*only).clone()),
            _ => None,
        }
    }

    /// Returns the states that no transition leaves.
    #[expect(clippy::unused_self, reason = "it is asked as the start is")]
    pub(super) fn ends(&self, recipe: &Recipe) -> Vec<String> {
        let left: FxHashSet<&String> = recipe.transitions.iter().map(|t| &t.from).collect();
        let ends = recipe.states.iter().filter(|s| !left.contains(s));
        ends.cloned().collect()
    }

    /// Adds states and transitions to a recipe, and their places. Returns false if the graph cannot
    /// be read; the reasons are findings. Takes time proportional to the graph.
    pub(super) fn transitions(
        &self,
        source: &mut Source<'_, '_>,
        recipe: &mut Recipe,
        places: &mut Places,
    ) -> bool {
        if self.is_broken {
            return false;
        }
        for node in self.nodes.iter().filter(|n| n.call.is_none()) {
            recipe.states.push(node.name.clone());
            places.states.insert(node.name.clone(), node.element);
        }
        let Some(mut walk) = self.walk(source) else {
            return false;
        };
        walk.add_states(recipe, places);
        for flow in &self.flows {
            for from in walk.sources(flow) {
                let guard = flow.guard.clone();
                let target = walk.vertex(flow.to[0]);
                let transition = walk.transition(from, guard, target, false);
                recipe.transitions.push(transition);
                places.transitions.push(flow.element);
            }
        }
        for number in 0..walk.groups.len() {
            if let Some(before) = walk.groups[number].before.clone() {
                let target = Vertex::Group(number);
                let transition = walk.transition(before, Guard::Always, target, true);
                recipe.transitions.push(transition);
                places
                    .transitions
                    .push(self.nodes[walk.groups[number].nodes[0]].element);
            }
        }
        for group in walk.groups.iter().filter(|g| !g.is_reached) {
            let element = self.nodes[group.nodes[0]].element;
            source.add(element, Rule::Meaning, "the operation is never reached");
        }
        true
    }

    /// Finds the groups. Returns nothing if connections contradict each other.
    fn walk(&self, source: &mut Source<'_, '_>) -> Option<Walk<'_>> {
        let mut walk = Walk {
            graph: self,
            groups: Vec::new(),
            group_of: vec![None; self.nodes.len()],
        };
        let is_operation = |node: &usize| self.nodes[*node].call.is_some();
        let mut is_right = true;
        let mut wrong = |element, message: &str| {
            source.add(element, Rule::Meaning, message);
            is_right = false;
        };
        for flow in &self.flows {
            let operations = flow.to.iter().filter(|n| is_operation(n)).count();
            if flow.to.len() > 1 && operations < flow.to.len() {
                wrong(flow.element, "only operations can begin together");
                continue;
            }
            // Of several states, each begins a transition.
            let from_states = flow.from.iter().filter(|n| !is_operation(n)).count();
            if operations > 0 && !walk.enter(&flow.to, from_states.max(1)) {
                wrong(
                    flow.element,
                    "operations begin together with different ones",
                );
            }
        }
        for node in (0..self.nodes.len()).filter(is_operation) {
            if walk.group_of[node].is_none() {
                walk.add_group(vec![node]);
            }
        }
        for (number, flow) in self.flows.iter().enumerate() {
            let operations = flow.from.iter().filter(|n| is_operation(n)).count();
            if operations == 0 {
                continue;
            }
            match walk.group_of[flow.from[0]] {
                Some(group) if same_nodes(&walk.groups[group].nodes, &flow.from) => {
                    walk.groups[group].leaving.push(number);
                }
                _ => wrong(flow.element, "operations that begin together end together"),
            }
        }
        for (element, nodes) in &self.parallel {
            let group = walk.group_of[nodes[0]];
            if group.is_none() || nodes.iter().any(|n| walk.group_of[*n] != group) {
                wrong(
                    *element,
                    "`AtStart` joins operations that one connection enters",
                );
            }
        }
        is_right.then_some(walk)
    }
}

/// Returns whether two lists have the same nodes, each once.
fn same_nodes(one: &[usize], other: &[usize]) -> bool {
    let known: FxHashSet<usize> = one.iter().copied().collect();
    let distinct: FxHashSet<usize> = other.iter().copied().collect();
    one.len() == known.len() && other.len() == distinct.len() && known == distinct
}

struct Walk<'a> {
    graph: &'a Graph,
    groups: Vec<Group>,
    group_of: Vec<Option<usize>>,
}

impl Walk<'_> {
    fn add_group(&mut self, nodes: Vec<usize>) {
        for node in &nodes {
            self.group_of[*node] = Some(self.groups.len());
        }
        self.groups.push(Group {
            nodes,
            ..Group::default()
        });
    }

    /// Notes that operations are entered together. Returns false if some of them were entered
    /// together with others, or one is listed twice. `times` is the number of transitions that
    /// enter.
    fn enter(&mut self, nodes: &[usize], times: usize) -> bool {
        let group = self.group_of[nodes[0]];
        match group {
            None if nodes.iter().all(|n| self.group_of[*n].is_none()) => {
                self.add_group(nodes.to_vec());
                let group = self.groups.len() - 1;
                self.groups[group].entering = times;
                same_nodes(nodes, nodes)
            }
            Some(group) if same_nodes(&self.groups[group].nodes, nodes) => {
                self.groups[group].entering += times;
                true
            }
            _ => false,
        }
    }

    /// Decides where states are put, and adds them to the recipe.
    fn add_states(&mut self, recipe: &mut Recipe, places: &mut Places) {
        let mut known: FxHashSet<String> = recipe.states.iter().cloned().collect();
        let graph = self.graph;
        for group in &mut self.groups {
            let node = &graph.nodes[group.nodes[0]];
            let mut add = |prefix: &str| {
                let mut name = format!("{prefix} {}", node.name);
                while !known.insert(name.clone()) {
                    name.push('\'');
                }
                recipe.states.push(name.clone());
                places.states.insert(name.clone(), node.element);
                Some(name)
            };
            if group.entering != 1 {
                group.before = add("before");
            }
            let is_plain = |flow: &usize| graph.flows[*flow].guard == Guard::Always;
            if group.leaving.len() != 1 || !group.leaving.iter().all(is_plain) {
                group.behind = add("behind");
            }
        }
    }

    fn vertex(&self, node: usize) -> Vertex {
        self.group_of[node].map_or(Vertex::State(node), Vertex::Group)
    }

    /// Returns the states that a connection leaves: none if it only goes on from a group.
    fn sources(&self, flow: &Flow) -> Vec<String> {
        if let Vertex::Group(group) = self.vertex(flow.from[0]) {
            return self.groups[group].behind.iter().cloned().collect();
        }
        let names = flow.from.iter().map(|n| self.graph.nodes[*n].name.clone());
        names.collect()
    }

    /// Returns the transition that begins in a state and leads to a vertex. `is_before` says
    /// whether it begins in the state before that.
    ///
    /// A group without a state before it is entered once, so each is part of one transition.
    fn transition(
        &mut self,
        from: String,
        guard: Guard,
        target: Vertex,
        is_before: bool,
    ) -> RecipeTransition {
        let (mut vertex, mut steps) = (target, Vec::new());
        let to = loop {
            let group = match vertex {
                Vertex::State(node) => break self.graph.nodes[node].name.clone(),
                Vertex::Group(group) => group,
            };
            match &self.groups[group].before {
                Some(before) if !is_before || !steps.is_empty() => break before.clone(),
                _ => {}
            }
            self.groups[group].is_reached = true;
            let nodes = self.groups[group].nodes.iter();
            let calls = nodes.filter_map(|n| self.graph.nodes[*n].call.clone());
            steps.push(Step::new(calls.collect()));
            if let Some(behind) = &self.groups[group].behind {
                break behind.clone();
            }
            // A group without a state behind it is left by one connection.
            let flow = &self.graph.flows[self.groups[group].leaving[0]];
            vertex = self.vertex(flow.to[0]);
        };
        RecipeTransition {
            from,
            to,
            guard,
            steps,
        }
    }
}
