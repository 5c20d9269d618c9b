//! Layouts: resources as labelled transition systems.

/// A set of resources that exchange parts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layout {
    /// Name of the layout.
    pub name: String,
    /// Resources. Their order is the order of a vector's components.
    pub resources: Vec<Resource>,
}

/// A resource: a machine, a robot, a buffer or a transport.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Resource {
    /// Name, unique in the layout.
    pub name: String,
    /// States.
    pub states: Vec<State>,
    /// Name of the state at the start.
    pub initial: String,
    /// Maximum number of parts that the resource holds.
    pub capacity: usize,
    /// Parts that the resource holds at the start: the name of a part of the recipe, or else the
    /// type of a part in stock.
    pub holds: Vec<String>,
    /// Transitions.
    pub transitions: Vec<Transition>,
}

/// A state of a resource.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct State {
    /// Name, unique in the resource.
    pub name: String,
    /// Whether the resource may wait here. If not, it has to take a transition in the next vector.
    /// In the paper this is a transition `nop` from the state to itself.
    pub may_wait: bool,
}

/// A transition of a resource.
#[derive(Debug, Clone, PartialEq)]
pub struct Transition {
    /// Name of the state that it leaves.
    pub from: String,
    /// Name of the state that it enters.
    pub to: String,
    /// What it does.
    pub action: Action,
    /// Duration in s. It does not influence realizability.
    pub seconds: Option<f64>,
    /// Electrical power in W while it lasts. It does not influence realizability.
    pub watts: Option<f64>,
}

/// What a transition of a resource does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Action {
    /// Operation that a recipe can ask for.
    Operation(String),
    /// Operation of the resource's own, which no recipe sees.
    Internal(String),
    /// Takes a part from the resource that gives it under this label.
    In(String),
    /// Gives a part to the resource that takes it under this label.
    Out(String),
}

impl Layout {
    /// Returns the index of a resource.
    pub fn resource(&self, name: &str) -> Option<usize> {
        self.resources.iter().position(|r| r.name == name)
    }
}

impl Resource {
    /// Creates an empty resource that holds one part. Its states are those that may wait, then
    /// those that may not; the first is the initial one.
    pub fn new(name: &str, may_wait: &[&str], may_not_wait: &[&str]) -> Self {
        let state = |name: &&str, may_wait| State {
            name: (*name).to_owned(),
            may_wait,
        };
        let waiting = may_wait.iter().map(|s| state(s, true));
        let states: Vec<State> = waiting
            .chain(may_not_wait.iter().map(|s| state(s, false)))
            .collect();
        Self {
            name: name.to_owned(),
            initial: states.first().map_or_else(String::new, |s| s.name.clone()),
            states,
            capacity: 1,
            holds: Vec::new(),
            transitions: Vec::new(),
        }
    }

    /// Adds a transition without duration and power.
    #[must_use]
    pub fn with(mut self, from: &str, action: Action, to: &str) -> Self {
        self.transitions.push(Transition {
            from: from.to_owned(),
            to: to.to_owned(),
            action,
            seconds: None,
            watts: None,
        });
        self
    }

    /// Sets the capacity in parts.
    #[must_use]
    pub fn holding(mut self, capacity: usize) -> Self {
        self.capacity = capacity;
        self
    }

    /// Returns whether the resource may wait in a state. It may not in one that it does not have.
    pub fn may_wait(&self, name: &str) -> bool {
        self.states.iter().any(|s| s.name == name && s.may_wait)
    }

    /// Returns the index of a state.
    pub fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|s| s.name == name)
    }
}

impl Transition {
    /// Returns the duration in ns, rounded; 0 if none is given.
    pub fn nanoseconds(&self) -> i64 {
        (self.seconds.unwrap_or(0.0) * 1e9).round() as i64
    }

    /// Returns the electrical energy in µJ, rounded; 0 if no duration or no power is given.
    pub fn microjoules(&self) -> i64 {
        (self.seconds.unwrap_or(0.0) * self.watts.unwrap_or(0.0) * 1e6).round() as i64
    }
}

impl Action {
    /// Returns the label of a transfer.
    pub fn label(&self) -> Option<&str> {
        match self {
            Self::In(label) | Self::Out(label) => Some(label),
            Self::Operation(_) | Self::Internal(_) => None,
        }
    }
}
