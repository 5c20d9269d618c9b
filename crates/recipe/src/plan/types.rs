//! Plans as plain data.

/// How a plan is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Execution {
    /// In vectors, as in the paper: each transition takes one unit of time, all resources begin and
    /// end together, and each label is used by one transfer in a vector.
    Lockstep,
    /// Each transition takes its own time.
    Timed,
}

/// What a plan has least of, in the worst case over the outcomes of the tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Objective {
    /// Number of vectors, in lockstep.
    Steps,
    /// Time until all is done.
    Time,
    /// Electrical energy of all transitions.
    Energy,
    /// Number of transfers.
    Transfers,
}

impl Objective {
    /// Returns how plans with this objective are executed.
    pub fn execution(self) -> Execution {
        match self {
            Self::Steps => Execution::Lockstep,
            _ => Execution::Timed,
        }
    }

    /// Returns whether it is a length of time, in vectors or in nanoseconds.
    pub fn is_time(self) -> bool {
        matches!(self, Self::Steps | Self::Time)
    }

    /// Returns the unit of [`Plan::value`].
    pub fn unit(self) -> &'static str {
        match self {
            Self::Steps => "vectors",
            Self::Time => "ns",
            Self::Energy => "uJ",
            Self::Transfers => "transfers",
        }
    }
}

/// A plan: what each resource does when.
///
/// Times are counted from the beginning of a position: in nanoseconds, or in vectors in lockstep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// What it has least of.
    pub objective: Objective,
    /// Index of the demand of each product.
    pub products: Vec<usize>,
    /// Positions; the first is the start.
    pub positions: Vec<PlanPosition>,
    /// Value of the objective in the worst case, until all products are finished or a product
    /// closes a loop of its recipe. In vectors, nanoseconds, microjoules or transfers; see
    /// [`Objective::unit`].
    pub value: i64,
    /// No plan has a smaller value. If the two are equal, the plan is proved optimal.
    pub lower_bound: i64,
    /// How it was found.
    pub method: Method,
    /// Number of search nodes.
    pub nodes: usize,
}

/// How a plan was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Method {
    /// A search over all plans.
    Search,
    /// One product after the other, in this order of demands. Other orders, and products that are
    /// made at the same time, may be better.
    OneAfterTheOther(Vec<usize>),
    /// The order of the operations in a schedule with ample buffers, in which the cell can perform
    /// them.
    JobShop,
}

/// A configuration of the cell in which a schedule begins. All resources are at rest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanPosition {
    /// Progress of each product.
    pub progress: Vec<Progress>,
    /// State of each resource, as an index into its states.
    pub resource_states: Vec<usize>,
    /// Parts that each resource holds, sorted.
    pub parts: Vec<Vec<HeldPart>>,
    /// What happens.
    pub schedule: Schedule,
}

/// How far a product is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Progress {
    /// In a state of its recipe, as an index.
    At(usize),
    /// In a transition of its recipe.
    Performing {
        /// Index of the transition.
        transition: usize,
        /// Number of its steps that have been performed.
        steps: usize,
    },
    /// Finished.
    Ended,
}

/// A part.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HeldPart {
    /// Name of a part of a recipe, or type of a part in stock.
    pub name: String,
    /// To what it belongs.
    pub owner: PartOwner,
}

/// To what a part belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartOwner {
    /// To no product.
    Stock,
    /// To a product, as an index.
    Product(usize),
    /// A finished product of a demand has left it over.
    LeftOver(usize),
}

/// What happens from a position or from a test on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schedule {
    /// Moves in the order in which they are decided: of each resource, and of the steps of each
    /// product, the earlier come first.
    pub entries: Vec<Entry>,
    /// What follows.
    pub then: Next,
}

/// What follows a schedule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Next {
    /// All products are finished and all resources at rest.
    End {
        /// When.
        time: i64,
    },
    /// All resources are at rest, and another position begins.
    Goto {
        /// When.
        time: i64,
        /// Index of the position.
        position: usize,
        /// Whether a product has closed a loop of its recipe. This ends the count of the objective.
        closes_loop: bool,
    },
    /// A product is tested. What was decided before the test does not depend on its outcome; what
    /// is decided after it begins no earlier.
    Test {
        /// When.
        time: i64,
        /// Index of the product.
        product: usize,
        /// For each transition that leaves the product's state, its index and what follows.
        outcomes: Vec<(usize, Schedule)>,
    },
}

/// A transition of one resource.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Number of the event in the position. The two sides of a transfer, and the operations of one
    /// step, have the same.
    pub event: usize,
    /// When it begins.
    pub start: i64,
    /// When it ends.
    pub end: i64,
    /// Index of the resource.
    pub resource: usize,
    /// Index of its transition.
    pub transition: usize,
    /// What it is about.
    pub subject: EntrySubject,
}

/// What an entry is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EntrySubject {
    /// An operation of a product.
    Operation {
        /// Index of the product.
        product: usize,
        /// Index of the transition of its recipe.
        transition: usize,
        /// Index of the step.
        step: usize,
        /// Index of the operation in the step.
        call: usize,
    },
    /// A part that is given or taken.
    Part(HeldPart),
    /// Nothing: an internal operation.
    Internal,
}

impl Plan {
    /// Returns whether it is proved that no plan has a smaller value.
    pub fn is_least(&self) -> bool {
        self.value == self.lower_bound
    }

    /// Returns the execution that the plan is for.
    pub fn execution(&self) -> Execution {
        self.objective.execution()
    }
}
