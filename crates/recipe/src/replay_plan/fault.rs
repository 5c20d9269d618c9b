//! What can be wrong with a plan.

/// What is wrong with a plan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanFault {
    /// The layout or a recipe has problems other than warnings, so it has no meaning.
    #[error("the layout or a recipe has problems")]
    Problems,
    /// The products are not those of the demands.
    #[error("the products are not those of the demands")]
    Products,
    /// The first position is not the start.
    #[error("the first position is not the start")]
    Start,
    /// An index is too large, or a list has the wrong length.
    #[error("position {0}: something does not exist")]
    Malformed(usize),
    /// An event is not possible.
    #[error("position {position}, event {event}: {reason}")]
    Event {
        /// Index of the position.
        position: usize,
        /// Number of the event.
        event: usize,
        /// Why not.
        reason: EventFault,
    },
    /// A test is not possible.
    #[error("position {position}: product {product} cannot be tested like this")]
    Test {
        /// Index of the position.
        position: usize,
        /// Index of the product.
        product: usize,
    },
    /// A schedule ends before all is done, or the time of its end is wrong.
    #[error("position {0}: a schedule ends too early, or its time is wrong")]
    End(usize),
    /// A part remains of a finished product that may not.
    #[error("position {position}: part `{part}` of product {product} remains")]
    LeftOver {
        /// Index of the position.
        position: usize,
        /// Index of the product.
        product: usize,
        /// Name of the part.
        part: String,
    },
    /// A schedule leads to a position that differs from what is then the case.
    #[error("position {0}: a schedule does not lead to its target")]
    Target(usize),
    /// Positions follow each other in a circle in which no loop of a recipe is closed.
    #[error("position {0} leads back to itself")]
    Circle(usize),
    /// The value is wrong, or the lower bound is greater.
    #[error("the value is {actual} instead of {claimed}, or the bound is greater")]
    Value {
        /// Value that the plan claims.
        claimed: i64,
        /// Its value.
        actual: i64,
    },
}

/// Why an event is not possible.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EventFault {
    /// A resource, a transition or an operation does not exist.
    #[error("it does not exist")]
    NoSuchMove,
    /// A resource is not in the state that its transition leaves.
    #[error("resource `{0}` is in another state")]
    State(String),
    /// A resource begins before it is free, or before the test that decides this.
    #[error("resource `{0}` begins too early")]
    Early(String),
    /// A resource waits where it may not.
    #[error("resource `{0}` may not wait")]
    Waits(String),
    /// A transition does not take its time.
    #[error("resource `{0}` takes another time")]
    Time(String),
    /// The entries of an event do not belong together.
    #[error("its entries do not belong together")]
    Apart,
    /// A label is used twice in one vector.
    #[error("label `{0}` is used twice")]
    Label(String),
    /// A resource does not hold a part that it gives or needs.
    #[error("resource `{0}` does not hold a part")]
    NoPart(String),
    /// A resource would hold too many parts.
    #[error("resource `{0}` has no room")]
    NoRoom(String),
    /// The operations are not the next step of the product, or begin before the last one has ended.
    #[error("it is not the next step of product {0}")]
    Step(usize),
}
