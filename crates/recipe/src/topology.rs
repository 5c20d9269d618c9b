//! The topology: the reachable synchronous product of the resources, without parts.
//!
//! This is `ComputeTop` of the paper (its Algorithm 1). A transition of the topology takes one
//! transition of every resource, where waiting counts as one; each `in:x` among them needs exactly
//! one `out:x`, and the other way round. The paper tries every combination. Here a combination is
//! built resource by resource, and given up as soon as a label can no longer find its partner.

use crate::intern::Interner;
use crate::model::{Action, Layout, Problem};

/// Size of a topology.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TopologySize {
    /// Number of reachable states.
    pub states: usize,
    /// Number of transitions. Those that differ only in their operations count apart.
    pub transitions: u64,
}

/// A transition of the topology.
#[derive(Debug, Clone, Copy)]
pub struct TopologyTransition<'a> {
    /// State of each resource before it, as an index into its states.
    pub from: &'a [u16],
    /// Transition of each resource, as an index into its transitions; `None` if it waits.
    pub taken: &'a [Option<u16>],
    /// State of each resource after it.
    pub to: &'a [u16],
}

/// Error for a topology that cannot be explored.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TopologyError {
    /// The layout has problems that are more than warnings.
    #[error("the layout has problems")]
    Problems(Vec<Problem>),
    /// There are more states than the limit.
    #[error("the topology has more than {0} states")]
    TooManyStates(usize),
}

/// A choice of a resource in one of its states.
#[derive(Clone, Copy)]
struct Choice {
    taken: Option<u16>,
    to: u16,
    /// Label of a transfer, doubled, plus one for `out`.
    transfer: Option<usize>,
}

/// Explores the topology and calls `visit` for each transition: states in breadth-first order,
/// the transitions of a state in lexicographic order of the resources' transitions, waiting first.
///
/// Takes time proportional to the number of transitions and resources, and memory proportional to
/// the number of states and resources.
pub fn explore(
    layout: &Layout,
    max_states: usize,
    mut visit: impl FnMut(TopologyTransition<'_>),
) -> Result<TopologySize, TopologyError> {
    let problems = layout.problems();
    if problems.iter().any(|p| !p.is_warning()) {
        return Err(TopologyError::Problems(problems));
    }
    let (choices, labels) = tabulate(layout);
    let start: Vec<u16> = (layout.resources.iter())
        .map(|r| r.state(&r.initial).unwrap_or(0) as u16)
        .collect();
    let mut states = Interner::default();
    states.intern(&start);
    let mut transitions = 0;
    let mut combiner = Combiner::new(start.len(), labels);
    let mut state = 0;
    while (state as usize) < states.len() {
        let from = states.get(state).to_vec();
        combiner.each(&choices, &from, &mut |taken, to| {
            transitions += 1;
            states.intern(to);
            visit(TopologyTransition {
                from: &from,
                taken,
                to,
            });
        });
        if states.len() > max_states {
            return Err(TopologyError::TooManyStates(max_states));
        }
        state += 1;
    }
    Ok(TopologySize {
        states: states.len(),
        transitions,
    })
}

/// Returns the size of the topology; see [`explore`].
pub fn size(layout: &Layout, max_states: usize) -> Result<TopologySize, TopologyError> {
    explore(layout, max_states, |_| {})
}

/// Choices of a resource in each state.
type Table = Vec<Vec<Choice>>;

/// Returns the choices of each resource in each state, and the number of labels.
fn tabulate(layout: &Layout) -> (Vec<Table>, usize) {
    let mut labels: Vec<&str> = (layout.resources.iter())
        .flat_map(|r| &r.transitions)
        .filter_map(|t| t.action.label())
        .collect();
    labels.sort_unstable();
    labels.dedup();
    let number = |label: &str| labels.binary_search(&label).unwrap_or(0);
    let choices = (layout.resources.iter())
        .map(|resource| {
            let of_state = |(at, state): (usize, &crate::model::State)| {
                let wait = state.may_wait.then_some(Choice {
                    taken: None,
                    to: at as u16,
                    transfer: None,
                });
                let others = (resource.transitions.iter().enumerate())
                    .filter(|(_, t)| t.from == state.name)
                    .map(|(number_of, t)| Choice {
                        taken: Some(number_of as u16),
                        to: resource.state(&t.to).unwrap_or(0) as u16,
                        transfer: match &t.action {
                            Action::In(label) => Some(2 * number(label)),
                            Action::Out(label) => Some(2 * number(label) + 1),
                            _ => None,
                        },
                    });
                wait.into_iter().chain(others).collect()
            };
            resource.states.iter().enumerate().map(of_state).collect()
        })
        .collect();
    (choices, labels.len())
}

/// Receives the transitions and the next states of a combination.
type Found<'f> = dyn FnMut(&[Option<u16>], &[u16]) + 'f;

/// Combines the choices of all resources.
struct Combiner {
    /// Next choice of each resource.
    cursor: Vec<usize>,
    taken: Vec<Option<u16>>,
    to: Vec<u16>,
    /// Whether each transfer is in the combination.
    used: Vec<bool>,
    /// For each transfer, one more than the last resource that offers it in the current state.
    offered_until: Vec<usize>,
    /// For each resource, the transfers of which it is the last to offer them.
    last_offers: Vec<Vec<usize>>,
}

impl Combiner {
    fn new(resources: usize, labels: usize) -> Self {
        Self {
            cursor: vec![0; resources],
            taken: vec![None; resources],
            to: vec![0; resources],
            used: vec![false; 2 * labels],
            offered_until: vec![0; 2 * labels],
            last_offers: vec![Vec::new(); resources],
        }
    }

    /// Calls `found` with each valid combination, as transitions and next states.
    fn each(&mut self, choices: &[Table], from: &[u16], found: &mut Found<'_>) {
        self.offered_until.fill(0);
        for (at, state) in from.iter().enumerate() {
            self.last_offers[at].clear();
            for choice in &choices[at][*state as usize] {
                if let Some(transfer) = choice.transfer {
                    self.offered_until[transfer] = at + 1;
                }
            }
        }
        for (transfer, until) in self.offered_until.iter().enumerate() {
            if *until > 0 {
                self.last_offers[until - 1].push(transfer);
            }
        }
        let of = |at: usize| &choices[at][from[at] as usize];
        let mut at = 0;
        self.cursor[0] = 0;
        loop {
            // Take back the choice that stands, and go on to the next.
            if self.cursor[at] > 0
                && let Some(transfer) = of(at)[self.cursor[at] - 1].transfer
            {
                self.used[transfer] = false;
            }
            let next = (self.cursor[at]..of(at).len()).find(|c| self.fits(at, of(at)[*c].transfer));
            let Some(next) = next else {
                if at == 0 {
                    return;
                }
                at -= 1;
                continue;
            };
            let choice = of(at)[next];
            self.cursor[at] = next + 1;
            self.taken[at] = choice.taken;
            self.to[at] = choice.to;
            if let Some(transfer) = choice.transfer {
                self.used[transfer] = true;
            }
            if at + 1 == from.len() {
                found(&self.taken, &self.to);
            } else {
                at += 1;
                self.cursor[at] = 0;
            }
        }
    }

    /// Returns whether resource `at` can make a choice: no other resource has the same transfer,
    /// its partner is there or can still come, and no partner waits in vain for this resource.
    fn fits(&self, at: usize, transfer: Option<usize>) -> bool {
        let own = transfer.is_none_or(|t| {
            !self.used[t] && (self.used[t ^ 1] || self.offered_until[t ^ 1] > at + 1)
        });
        own && (self.last_offers[at].iter())
            .all(|t| transfer == Some(*t) || self.used[*t] || !self.used[t ^ 1])
    }
}
