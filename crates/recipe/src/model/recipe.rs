//! Recipes: graphs of operations on parts.

use rustc_hash::FxHashMap;

/// A recipe of a product.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recipe {
    /// Name of the recipe.
    pub name: String,
    /// Parts.
    pub parts: Vec<Part>,
    /// Names of the states.
    pub states: Vec<String>,
    /// Name of the state at the start.
    pub start: String,
    /// Names of the states where the recipe ends. No transition leaves them.
    pub ends: Vec<String>,
    /// Names or types of the parts that may remain in the cell at an end. Stock that the layout
    /// holds at the start, and that the recipe has not used, may always remain.
    pub leftover: Vec<String>,
    /// Transitions.
    pub transitions: Vec<RecipeTransition>,
}

/// A part of a recipe. Parts with the same name are interchangeable.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Part {
    /// Name, unique in the recipe.
    pub name: String,
    /// Type. While no part with the name is in the cell, one of the layout's stock of this type
    /// can be used in its place.
    pub kind: String,
}

/// A transition of a recipe: a guard, then steps in sequence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipeTransition {
    /// Name of the state that it leaves.
    pub from: String,
    /// Name of the state that it enters.
    pub to: String,
    /// When it is taken.
    pub guard: Guard,
    /// Steps in their order.
    pub steps: Vec<Step>,
}

/// When a transition of a recipe is taken. The cell does not choose the outcome of a test, so
/// every transition that leaves a state has to be realizable.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Guard {
    /// Always.
    #[default]
    Always,
    /// If a test of parts succeeds. It takes no vector and does not change the parts.
    Test {
        /// Name of the test.
        name: String,
        /// Names of the tested parts.
        inputs: Vec<String>,
        /// Names of the resources that can perform the test. One of them has to hold all inputs
        /// when the recipe is in the state that the transition leaves. If empty, the test reads
        /// what earlier operations recorded, and the parts may be anywhere.
        at: Vec<String>,
    },
    /// If no test of the other transitions succeeds.
    Otherwise,
}

/// Operations that are performed in one vector, each by a resource of its own.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Step {
    /// The operations.
    pub operations: Vec<OperationCall>,
}

/// An operation with its parts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OperationCall {
    /// Name of the operation.
    pub name: String,
    /// Names of the parts that it consumes. The resource that performs it has to hold them.
    pub inputs: Vec<String>,
    /// Names of the parts that it produces, at the same resource.
    pub outputs: Vec<String>,
}

impl Part {
    /// Creates a part from its name and its type.
    pub fn new(name: &str, kind: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind: kind.to_owned(),
        }
    }
}

impl OperationCall {
    /// Creates a call from the name of an operation and the names of its parts.
    pub fn new(name: &str, inputs: &[&str], outputs: &[&str]) -> Self {
        let owned = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        Self {
            name: name.to_owned(),
            inputs: owned(inputs),
            outputs: owned(outputs),
        }
    }
}

impl Step {
    /// Creates a step of parallel operations.
    pub fn new(operations: Vec<OperationCall>) -> Self {
        Self { operations }
    }
}

impl RecipeTransition {
    /// Creates a transition.
    pub fn new(from: &str, to: &str, guard: Guard, steps: Vec<Step>) -> Self {
        Self {
            from: from.to_owned(),
            to: to.to_owned(),
            guard,
            steps,
        }
    }
}

impl Guard {
    /// Creates a test that reads recorded data.
    pub fn test(name: &str, inputs: &[&str]) -> Self {
        Self::Test {
            name: name.to_owned(),
            inputs: inputs.iter().map(|i| (*i).to_owned()).collect(),
            at: Vec::new(),
        }
    }
}

impl Recipe {
    /// Returns the index of a state.
    pub fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|s| s == name)
    }

    /// Returns the index of a part.
    pub fn part(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|p| p.name == name)
    }

    /// Returns, for each transition, whether it closes a loop: in a depth-first search from the
    /// start that takes transitions in their order, it enters a state whose search has not ended.
    ///
    /// Without them the recipe has no loop. Unknown states are ignored. Takes time proportional to
    /// the size of the recipe.
    pub fn closes_loop(&self) -> Vec<bool> {
        let roots: Vec<usize> = self.state(&self.start).into_iter().collect();
        closing_edges(self.states.len(), &self.edges(), &roots)
    }

    /// Returns the states that each transition leaves and enters, if both are known.
    pub(crate) fn edges(&self) -> Vec<Option<(usize, usize)>> {
        let mut numbers = FxHashMap::default();
        for (number, name) in self.states.iter().enumerate() {
            numbers.entry(name.as_str()).or_insert(number);
        }
        let number = |name: &String| numbers.get(name.as_str()).copied();
        let edges = self
            .transitions
            .iter()
            .map(|t| number(&t.from).zip(number(&t.to)));
        edges.collect()
    }
}

/// Returns, for each edge of a graph, whether it enters a node whose search has not ended, in a
/// depth-first search from the roots in their order.
pub(super) fn closing_edges(
    nodes: usize,
    edges: &[Option<(usize, usize)>],
    roots: &[usize],
) -> Vec<bool> {
    let mut leaving: Vec<Vec<(usize, usize)>> = vec![Vec::new(); nodes];
    for (number, edge) in edges.iter().enumerate() {
        if let Some((from, to)) = edge {
            leaving[*from].push((number, *to));
        }
    }
    let mut closing = vec![false; edges.len()];
    let (mut seen, mut open) = (vec![false; nodes], vec![false; nodes]);
    for root in roots {
        // Each entry is a node and its next edge.
        let mut stack = Vec::new();
        if !std::mem::replace(&mut seen[*root], true) {
            open[*root] = true;
            stack.push((*root, 0));
        }
        while let Some((node, next)) = stack.last_mut() {
            let Some((number, to)) = leaving[*node].get(*next).copied() else {
                open[*node] = false;
                stack.pop();
                continue;
            };
            *next += 1;
            closing[number] = open[to];
            if !std::mem::replace(&mut seen[to], true) {
                open[to] = true;
                stack.push((to, 0));
            }
        }
    }
    closing
}
