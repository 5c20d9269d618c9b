//! Converts guards to decisions, so that a few comparisons find a state's transition. Otherwise, a
//! step would evaluate one guard after another.
//!
//! A split compares one input with a bound; both outcomes lead to another split or to a leaf, which
//! holds an answer and the next place. Equal splits of all places are shared. A component steps
//! only if its assumptions hold, and for such inputs its guards leave no gap (the machine was
//! verified). The decision is therefore only between guards: once all remaining guards lead to the
//! same leaf, no further comparison is needed.
//!
//! Each split is chosen to leave the fewest guards on its larger side. Guards that cannot be split
//! well would be copied repeatedly. If the decisions of a place would therefore need more than a
//! few splits per test, its splits compare one guard after another instead.

use linewright_solver::mealy::{Cube, Machine, Transition};
use std::collections::BTreeMap;

/// Target of a split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Target {
    /// The split with this index.
    Split(usize),
    /// The leaf with this index.
    Leaf(usize),
}

/// A comparison of one input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Split {
    /// Index of the component's input.
    pub input: usize,
    /// Bound of the comparison.
    pub bound: i64,
    /// Target if the input is at most the bound.
    pub at_most: Target,
    /// Target if the input is greater than the bound.
    pub above: Target,
}

/// Result of a transition: the index of its answer, and the next place; `None` if no guard holds.
pub(super) type Leaf = Option<(usize, usize)>;

/// The transitions of a machine, as decisions.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Decisions {
    /// Splits; each leads only to splits before it.
    pub splits: Vec<Split>,
    /// Distinct leaves.
    pub leaves: Vec<Leaf>,
    /// Distinct answers: the values of all outputs.
    pub answers: Vec<Vec<i64>>,
    /// Start of each place: place 0 is before step 0, place `s + 1` is state `s`.
    pub places: Vec<Target>,
    /// Answer of the first transition of each place: for a Moore machine, the place's only answer.
    pub first_answers: Vec<Option<usize>>,
}

/// Number of splits that a place can use in addition to two per test of its guards.
const EXTRA_SPLITS: usize = 16;

/// A guard's cube, and its leaf.
type Row<'a> = (&'a Cube, usize);

impl Decisions {
    /// Computes the decisions of a machine.
    pub fn of(machine: &Machine) -> Self {
        let mut work = Work::default();
        let (mut places, mut first_answers) = (Vec::new(), Vec::new());
        let domains: Vec<(i64, i64)> = machine
            .inputs
            .iter()
            .map(|port| (port.domain.low(), port.domain.high()))
            .collect();
        for transitions in std::iter::once(&machine.initial).chain(&machine.states) {
            let mut rows: Vec<Row<'_>> = Vec::new();
            for transition in transitions {
                let answer = work.answer(transition);
                let leaf = work.leaf(Some((answer, transition.to + 1)));
                rows.extend(transition.guard.0.iter().map(|cube| (cube, leaf)));
            }
            first_answers.push(transitions.first().map(|t| work.answer(t)));
            let tests: usize = rows.iter().map(|(cube, _)| cube.0.len()).sum();
            work.remaining = 2 * tests + EXTRA_SPLITS;
            let target = match work.balanced(&rows, &mut domains.clone()) {
                Some(target) => target,
                None => work.sequential(&rows, &domains),
            };
            places.push(target);
        }
        Self {
            splits: work.splits,
            leaves: work.leaves,
            answers: work.answers,
            places,
            first_answers,
        }
    }
}

impl Decisions {
    /// Size in bytes of the emitted tables, with four bytes per value.
    pub fn bytes(&self) -> usize {
        let answers: usize = self.answers.iter().map(Vec::len).sum();
        16 * self.splits.len() + 8 * self.leaves.len() + 4 * (answers + 2 * self.places.len())
    }
}

#[derive(Default)]
struct Work {
    splits: Vec<Split>,
    split_numbers: BTreeMap<Split, usize>,
    leaves: Vec<Leaf>,
    leaf_numbers: BTreeMap<Leaf, usize>,
    answers: Vec<Vec<i64>>,
    answer_numbers: BTreeMap<Vec<i64>, usize>,
    /// Number of splits that the current place can still use.
    remaining: usize,
}

impl Work {
    fn answer(&mut self, transition: &Transition) -> usize {
        let fresh = self.answers.len();
        let output = transition.output.clone();
        let number = *self.answer_numbers.entry(output.clone()).or_insert(fresh);
        if number == fresh {
            self.answers.push(output);
        }
        number
    }

    fn leaf(&mut self, leaf: Leaf) -> usize {
        let fresh = self.leaves.len();
        let number = *self.leaf_numbers.entry(leaf).or_insert(fresh);
        if number == fresh {
            self.leaves.push(leaf);
        }
        number
    }

    fn split(&mut self, split: Split) -> Target {
        if split.at_most == split.above {
            return split.above;
        }
        let fresh = self.splits.len();
        let number = *self.split_numbers.entry(split).or_insert(fresh);
        if number == fresh {
            self.splits.push(split);
        }
        Target::Split(number)
    }

    /// Returns the target that decides between guards for inputs in `within`; `None` if the
    /// decision needs too many splits.
    fn balanced(&mut self, rows: &[Row<'_>], within: &mut [(i64, i64)]) -> Option<Target> {
        let Some(&(_, leaf)) = rows.first() else {
            return Some(Target::Leaf(self.leaf(None)));
        };
        if rows.iter().all(|&(_, l)| l == leaf) {
            return Some(Target::Leaf(leaf));
        }
        self.remaining = self.remaining.checked_sub(1)?;
        let (input, bound) = best(rows, within);
        let (low, high) = within[input];
        let mut side = |low: i64, high: i64| {
            let met: Vec<Row<'_>> = rows
                .iter()
                .copied()
                .filter(|(cube, _)| {
                    let (first, last) = interval(cube, input).unwrap_or((low, high));
                    first <= high && low <= last
                })
                .collect();
            let outer = std::mem::replace(&mut within[input], (low, high));
            let target = self.balanced(&met, within);
            within[input] = outer;
            target
        };
        let at_most = side(low, bound)?;
        let above = side(bound + 1, high)?;
        Some(self.split(Split {
            input,
            bound,
            at_most,
            above,
        }))
    }

    /// Compares the guards in order.
    fn sequential(&mut self, rows: &[Row<'_>], within: &[(i64, i64)]) -> Target {
        let mut otherwise = Target::Leaf(self.leaf(None));
        for (cube, leaf) in rows.iter().rev() {
            let mut target = Target::Leaf(*leaf);
            for test in cube.0.iter().rev() {
                let (low, high) = within[test.input];
                if test.high < high {
                    target = self.split(Split {
                        input: test.input,
                        bound: test.high,
                        at_most: target,
                        above: otherwise,
                    });
                }
                if test.low > low {
                    target = self.split(Split {
                        input: test.input,
                        bound: test.low - 1,
                        at_most: otherwise,
                        above: target,
                    });
                }
            }
            otherwise = target;
        }
        otherwise
    }
}

/// Returns the interval in which an input must lie to satisfy a cube; `None` if the cube does not
/// test the input.
fn interval(cube: &Cube, input: usize) -> Option<(i64, i64)> {
    let test = cube.0.iter().find(|t| t.input == input)?;
    Some((test.low, test.high))
}

/// Finds the split that leaves the fewest guards on its larger side, then the fewest in total. Two
/// disjoint guards are on different sides of some bound, so a separating split always exists.
fn best(rows: &[Row<'_>], within: &[(i64, i64)]) -> (usize, i64) {
    let mut found: Option<((usize, usize), usize, i64)> = None;
    for (input, &(low, high)) in within.iter().enumerate() {
        let intervals: Vec<(i64, i64)> = rows
            .iter()
            .map(|(cube, _)| interval(cube, input).unwrap_or((low, high)))
            .collect();
        // The lower ends and the upper ends of the intervals, each sorted: two binary searches then
        // count the guards that begin at or below a bound and those that end above it.
        let (mut firsts, mut lasts): (Vec<i64>, Vec<i64>) = intervals.into_iter().unzip();
        firsts.sort_unstable();
        lasts.sort_unstable();
        let mut bounds: Vec<i64> = firsts
            .iter()
            .map(|f| f - 1)
            .chain(lasts.iter().copied())
            .collect();
        bounds.sort_unstable();
        bounds.dedup();
        for bound in bounds {
            if bound < low || bound >= high {
                continue;
            }
            let below = firsts.partition_point(|&f| f <= bound);
            let above = rows.len() - lasts.partition_point(|&l| l <= bound);
            let weight = (below.max(above), below + above);
            if found.is_none_or(|(least, _, _)| weight < least) {
                found = Some((weight, input, bound));
            }
        }
    }
    let (_, input, bound) =
        found.expect("guards with different leaves overlap; please report this");
    (input, bound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::gr1::{Domain, Timing};
    use linewright_solver::mealy::{Guard, Port, Test};
    use proptest::prelude::*;

    const HIGH: i64 = 5;
    const INPUTS: usize = 3;

    /// Transitions with disjoint guards: a random tree of cuts, whose regions get one of a few
    /// answers or none.
    fn transitions(choices: &[(u8, u8, u8)]) -> Vec<Transition> {
        let mut regions = vec![[(0, HIGH); INPUTS]];
        for &(region, input, bound) in choices {
            let region = usize::from(region) % regions.len();
            let input = usize::from(input) % INPUTS;
            let (low, high) = regions[region][input];
            if low < high {
                let bound = low + i64::from(bound) % (high - low);
                let mut upper = regions[region];
                regions[region][input] = (low, bound);
                upper[input] = (bound + 1, high);
                regions.push(upper);
            }
        }
        let cubes = regions.iter().map(|region| {
            let tests = region.iter().enumerate().filter(|(_, r)| **r != (0, HIGH));
            Cube(
                tests
                    .map(|(input, &(low, high))| Test { input, low, high })
                    .collect(),
            )
        });
        let mut transitions: Vec<Transition> = Vec::new();
        for (i, cube) in cubes.enumerate() {
            match i % 4 {
                3 => {}
                to => transitions.push(Transition {
                    guard: Guard(vec![cube]),
                    output: vec![to as i64],
                    to: 0,
                }),
            }
        }
        transitions
    }

    fn walk(decisions: &Decisions, place: usize, inputs: &[i64]) -> Leaf {
        let mut target = decisions.places[place];
        loop {
            match target {
                Target::Leaf(leaf) => return decisions.leaves[leaf],
                Target::Split(number) => {
                    let split = &decisions.splits[number];
                    target = if inputs[split.input] <= split.bound {
                        split.at_most
                    } else {
                        split.above
                    };
                }
            }
        }
    }

    fn machine(initial: Vec<Transition>, state: Vec<Transition>) -> Machine {
        let port = |name: &str| Port {
            name: name.to_owned(),
            domain: Domain::Range { low: 0, high: HIGH },
            unit: String::new(),
            internal: false,
        };
        Machine {
            name: "M".to_owned(),
            timing: Timing::Mealy,
            inputs: (0..INPUTS).map(|i| port(&format!("i{i}"))).collect(),
            outputs: vec![port("o")],
            initial,
            states: vec![state],
            goals: Vec::new(),
        }
    }

    /// Checks that the decisions give the machine's answer for every input for which a guard holds.
    fn assert_agrees(machine: &Machine, decisions: &Decisions) {
        for letter in 0..(HIGH + 1).pow(INPUTS as u32) {
            let inputs = [letter % 6, letter / 6 % 6, letter / 36];
            for (place, state) in [(0, None), (1, Some(0))] {
                if let Some(transition) = machine.step(state, &inputs) {
                    let (answer, to) = walk(decisions, place, &inputs).expect("a transition");
                    assert_eq!(decisions.answers[answer], transition.output);
                    assert_eq!(to, transition.to + 1);
                }
            }
        }
    }

    proptest! {
        #[test]
        fn decisions_find_the_guard_that_holds(
            initial in prop::collection::vec(any::<(u8, u8, u8)>(), 0..40),
            state in prop::collection::vec(any::<(u8, u8, u8)>(), 0..40),
        ) {
            let machine = machine(transitions(&initial), transitions(&state));
            let decisions = Decisions::of(&machine);
            assert_agrees(&machine, &decisions);
            let tests: usize = machine.states.iter().chain([&machine.initial]).flatten().flat_map(|t| &t.guard.0).map(|c| c.0.len()).sum();
            prop_assert!(decisions.splits.len() <= 4 * tests + 4 * EXTRA_SPLITS);
        }

        #[test]
        fn sequential_decisions_find_the_guard_that_holds(choices in prop::collection::vec(any::<(u8, u8, u8)>(), 0..40)) {
            let machine = machine(transitions(&choices), transitions(&choices));
            let mut work = Work::default();
            let mut rows = Vec::new();
            for t in &machine.initial {
                let answer = work.answer(t);
                let leaf = work.leaf(Some((answer, t.to + 1)));
                rows.extend(t.guard.0.iter().map(|cube| (cube, leaf)));
            }
            let target = work.sequential(&rows, &[(0, HIGH); INPUTS]);
            let decisions = Decisions {
                splits: work.splits,
                leaves: work.leaves,
                answers: work.answers,
                places: vec![target, target],
                first_answers: Vec::new(),
            };
            assert_agrees(&machine, &decisions);
        }
    }
}
