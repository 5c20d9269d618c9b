//! Words of the documents that the schema leaves open: properties, parameters, node types.
//!
//! Both directions use them, and the reference page lists them.

/// Prefix of the identifier of a node that is a state of a recipe.
pub(crate) const STATE_PREFIX: &str = "state:";
/// Prefix of the identifier of a node that is an operation of a recipe.
pub(crate) const OPERATION_PREFIX: &str = "operation:";

/// Properties of a resource.
pub(crate) mod resource {
    /// Maximum number of parts.
    pub(crate) const CAPACITY: &str = "Capacity";
    /// State at the start.
    pub(crate) const INITIAL_STATE: &str = "InitialState";
    /// All states.
    pub(crate) const STATES: &str = "States";
    /// States in which the resource may wait.
    pub(crate) const WAITING_STATES: &str = "WaitingStates";
    /// Parts at the start.
    pub(crate) const HOLDS: &str = "Holds";
    /// Prefix of a transition; its number follows.
    pub(crate) const TRANSITION: &str = "Transition ";
}

/// Keys of the values of a transition of a resource.
pub(crate) mod transition {
    /// State that it leaves.
    pub(crate) const FROM: &str = "From";
    /// State that it enters.
    pub(crate) const TO: &str = "To";
    /// Operation that a recipe can ask for.
    pub(crate) const OPERATION: &str = "Operation";
    /// Internal operation.
    pub(crate) const INTERNAL: &str = "Internal";
    /// Label under which it takes a part.
    pub(crate) const IN: &str = "In";
    /// Label under which it gives a part.
    pub(crate) const OUT: &str = "Out";
    /// Duration in s.
    pub(crate) const DURATION: &str = "Duration";
    /// Power in W.
    pub(crate) const POWER: &str = "Power";
}

/// Properties and parameters of a recipe and its transitions.
pub(crate) mod recipe {
    /// Other type of the segment with the declarations of a recipe.
    pub(crate) const DECLARATIONS: &str = "Recipe";
    /// Parts; in a workflow their keys are the types.
    pub(crate) const PARTS: &str = "Parts";
    /// States.
    pub(crate) const STATES: &str = "States";
    /// State at the start.
    pub(crate) const START: &str = "Start";
    /// States at the end.
    pub(crate) const ENDS: &str = "Ends";
    /// What may be left over.
    pub(crate) const LEFTOVER: &str = "Leftover";
    /// State that a transition leaves.
    pub(crate) const FROM: &str = "From";
    /// State that a transition enters.
    pub(crate) const TO: &str = "To";
    /// Name of a test.
    pub(crate) const TEST: &str = "Test";
    /// Parts of a test.
    pub(crate) const TESTED: &str = "Tested";
    /// Resources of a test.
    pub(crate) const TESTED_AT: &str = "TestedAt";
    /// Whether the transition is taken if no test succeeds.
    pub(crate) const OTHERWISE: &str = "Otherwise";
    /// Parts that an operation needs.
    pub(crate) const CONSUMED: &str = "Consumed";
    /// Parts that an operation makes.
    pub(crate) const PRODUCED: &str = "Produced";
}

/// Types of the nodes of a workflow.
pub(crate) mod node {
    /// State at the start.
    pub(crate) const START: &str = "Start";
    /// State that several transitions leave.
    pub(crate) const CHOICE: &str = "Choice";
    /// State at the end.
    pub(crate) const END: &str = "End";
    /// Any other state.
    pub(crate) const STATE: &str = "State";
    /// Operation.
    pub(crate) const OPERATION: &str = "Operation";
}

/// Parameters and other words of schedules and performances.
pub(crate) mod activity {
    /// Other type of a transfer.
    pub(crate) const ROUTING: &str = "Routing";
    /// Other type of an internal operation.
    pub(crate) const INTERNAL: &str = "Internal";
    /// Process segment of transfers.
    pub(crate) const TRANSFER: &str = "Transfer";
    /// Label of a transfer.
    pub(crate) const LABEL: &str = "Label";
    /// Other use of a part that is transferred.
    pub(crate) const TRANSFERRED: &str = "Transferred";
    /// Use of the resource that gives a part.
    pub(crate) const OUT: &str = "out";
    /// Use of the resource that takes a part.
    pub(crate) const IN: &str = "in";
    /// Name of the part of a material.
    pub(crate) const PART: &str = "Part";
    /// Position of the controller where the leg begins, from 1.
    pub(crate) const POSITION: &str = "Position";
    /// Transition of the recipe, from 1.
    pub(crate) const TRANSITION: &str = "Transition";
    /// Vector of the leg, from 1.
    pub(crate) const VECTOR: &str = "Vector";
    /// Product that something was done for.
    pub(crate) const PRODUCT: &str = "Product";
    /// Time of the begin in s after the start of the run.
    pub(crate) const BEGIN: &str = "Begin";
    /// Time of the end in s after the start of the run.
    pub(crate) const END: &str = "End";
}
