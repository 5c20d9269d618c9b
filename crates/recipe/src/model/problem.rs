//! Problems of layouts and recipes.

/// A problem of a layout or a recipe. Its text has no place; whoever read the text adds that.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// There is more of something than the search can number.
    #[error("there are more than {limit} {what}")]
    TooLarge {
        /// What, in the plural.
        what: &'static str,
        /// Maximum number.
        limit: usize,
    },
    /// The layout has no resources.
    #[error("the layout `{0}` has no resources")]
    EmptyLayout(String),
    /// Two resources have the same name.
    #[error("two resources are called `{0}`")]
    DuplicateResource(String),
    /// A resource has two states with the same name.
    #[error("resource `{resource}` has two states `{state}`")]
    DuplicateResourceState {
        /// Name of the resource.
        resource: String,
        /// Name of the state.
        state: String,
    },
    /// A resource names a state that it does not have.
    #[error("resource `{resource}` has no state `{state}`")]
    UnknownResourceState {
        /// Name of the resource.
        resource: String,
        /// Name of the state.
        state: String,
    },
    /// A duration or a power is negative or not a number.
    #[error(
        "resource `{resource}`: the {what} of the transition from `{from}` to `{to}` is not a \
         number of at least zero"
    )]
    BadQuantity {
        /// Name of the resource.
        resource: String,
        /// `duration` or `power`.
        what: &'static str,
        /// Name of the state that the transition leaves.
        from: String,
        /// Name of the state that it enters.
        to: String,
    },
    /// A resource holds more parts at the start than it has room for.
    #[error("resource `{resource}` holds {parts} parts at the start, but has room for {capacity}")]
    TooManyParts {
        /// Name of the resource.
        resource: String,
        /// Number of its parts.
        parts: usize,
        /// Its capacity.
        capacity: usize,
    },
    /// A resource can get into a state where it may not wait and that it cannot leave (warning).
    #[error("resource `{resource}` may not wait in state `{state}`, and no transition leaves it")]
    Stuck {
        /// Name of the resource.
        resource: String,
        /// Name of the state.
        state: String,
    },
    /// A transition of a resource needs a partner with the same label that does not exist
    /// (warning).
    #[error("resource `{resource}` has a transfer `{label}`, but no other resource is its partner")]
    NoPartner {
        /// Name of the resource.
        resource: String,
        /// The transfer, as `in:x` or `out:x`.
        label: String,
    },
    /// A part is declared twice.
    #[error("part `{0}` is declared twice")]
    DuplicatePart(String),
    /// A state of the recipe is declared twice.
    #[error("state `{0}` of the recipe is declared twice")]
    DuplicateState(String),
    /// The recipe names a state that it does not have.
    #[error("the recipe has no state `{0}`")]
    UnknownState(String),
    /// The recipe names a part that it does not have.
    #[error("transition {transition}: the recipe has no part `{part}`")]
    UnknownPart {
        /// Number of the transition, from 0.
        transition: usize,
        /// Name of the part.
        part: String,
    },
    /// What may be left over is neither a part nor a type of a part.
    #[error("`{0}` may be left over, but is neither a part nor a type of a part")]
    UnknownLeftover(String),
    /// The recipe has no end.
    #[error("the recipe `{0}` has no end")]
    NoEnd(String),
    /// A transition leaves an end.
    #[error("transition {transition} leaves the end `{state}`")]
    LeavesEnd {
        /// Number of the transition.
        transition: usize,
        /// Name of the end.
        state: String,
    },
    /// No transition leaves a state that is not an end.
    #[error("no transition leaves state `{0}`, which is not an end")]
    NoWayOn(String),
    /// A state cannot be reached from the start (warning).
    #[error("state `{0}` cannot be reached from the start of the recipe")]
    Unreachable(String),
    /// The guards of a state do not cover every outcome.
    #[error("the guards of state `{0}` do not cover every outcome: `otherwise` is missing")]
    NotCovered(String),
    /// Two transitions with `otherwise` leave a state.
    #[error("two transitions with `otherwise` leave state `{0}`")]
    TwoOtherwise(String),
    /// A step has no operations.
    #[error("step {step} of transition {transition} has no operations")]
    EmptyStep {
        /// Number of the transition.
        transition: usize,
        /// Number of the step, from 0.
        step: usize,
    },
    /// A loop has no operation, so it could be repeated for ever in no time.
    #[error("a loop through state `{0}` has no operation")]
    IdleLoop(String),
    /// A guard is tested by a resource that the layout does not have.
    #[error("transition {transition}: the layout has no resource `{resource}` for the test")]
    UnknownTester {
        /// Number of the transition.
        transition: usize,
        /// Name of the resource.
        resource: String,
    },
}

impl Problem {
    /// Returns whether the problem is only a warning: the search can run in spite of it.
    pub fn is_warning(&self) -> bool {
        matches!(
            self,
            Self::Stuck { .. } | Self::NoPartner { .. } | Self::Unreachable(_)
        )
    }
}
