//! Controllers: how the resources of a layout realize a recipe.

/// A controller: the graph of the recipe, where each state has the states and parts of all
/// resources, and each transition the vectors that realize it. A state of the recipe has several
/// positions if it is reached with different resource states or parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Controller {
    /// Positions; the first is the start.
    pub positions: Vec<Position>,
    /// Number of vectors until the recipe ends or closes a loop (see
    /// [`Recipe::closes_loop`](crate::model::Recipe::closes_loop)), in the worst case over the
    /// outcomes of the tests.
    pub worst_case: u32,
    /// Whether no controller has a smaller worst case.
    pub is_least: bool,
}

/// A state of the recipe with the states and parts of all resources.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Position {
    /// Index of the state of the recipe.
    pub recipe_state: usize,
    /// State of each resource, as an index into its states.
    pub resource_states: Vec<usize>,
    /// Parts that each resource holds, sorted: names of parts of the recipe, and types of stock.
    pub parts: Vec<Vec<String>>,
    /// One leg for each transition of the recipe that leaves the state, in their order.
    pub legs: Vec<Leg>,
}

/// A transition of the recipe with the vectors that realize it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leg {
    /// Index of the transition of the recipe.
    pub transition: usize,
    /// Vectors in their order.
    pub vectors: Vec<Vector>,
    /// Index of the position that it leads to.
    pub to: usize,
}

/// What the resources do at the same time. Resources without a move wait.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vector {
    /// Moves, ordered by resource.
    pub moves: Vec<Move>,
}

/// What one resource does in a vector.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Move {
    /// Index of the resource.
    pub resource: usize,
    /// Index of its transition.
    pub transition: usize,
    /// What it is about.
    pub subject: Subject,
}

/// What a move is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// An operation of the recipe's current step, as an index into it.
    Operation(usize),
    /// A part that is given or taken.
    Part(String),
    /// Nothing: an internal operation.
    Internal,
}

impl Controller {
    /// Returns the number of vectors of all legs.
    pub fn vectors(&self) -> usize {
        let legs = self.positions.iter().flat_map(|p| &p.legs);
        legs.map(|l| l.vectors.len()).sum()
    }
}
