//! Every way of solving: both kernels, the heuristics switched, and orders of all kinds.

use super::check::accepts;
use crate::game::{Board, Subset};
use crate::random::Random;
use linewright::game::{
    GuaranteeRef, Heuristic, Heuristics, KernelChoice, Limits, Options, Order, Outcome, Solution,
    order_from_variables, solve_with,
};
use linewright::gr1::Specification;
use linewright::mealy::{extract::extract, verify::verify};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::ops::AddAssign;

/// The kernels by their names in the statistics.
const KERNELS: [(KernelChoice, &str); 2] = [
    (KernelChoice::Biodivine, "biodivine"),
    (KernelChoice::Shared, "shared"),
];

/// One way of solving.
struct Way {
    heuristics: Heuristics,
    order: Option<Order>,
    /// Whether a machine is made and checked.
    machine: bool,
}

/// Statistics of the tests.
#[derive(Debug, Default, Clone)]
pub struct Tried {
    /// Verdicts on both kernels together.
    pub verdicts: u64,
    /// Machines accepted by both the verifier and the oracle's checker.
    pub machines: u64,
    /// Sets of heuristics with which a game was solved; the oracle agreed.
    pub sets: BTreeSet<String>,
    /// Games whose order changed because sifting found a better one.
    pub reordered: u64,
    /// Minimal cores; all those of a game are the same.
    pub cores: u64,
}

impl AddAssign for Tried {
    fn add_assign(&mut self, other: Self) {
        self.verdicts += other.verdicts;
        self.machines += other.machines;
        self.sets.extend(other.sets);
        self.reordered += other.reordered;
        self.cores += other.cores;
    }
}

impl fmt::Display for Tried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            verdicts,
            machines,
            sets,
            reordered,
            cores,
        } = self;
        write!(
            f,
            "{verdicts} verdicts with {} sets of heuristics, {machines} machines, {cores} cores, {reordered} orders changed",
            sets.len()
        )
    }
}

/// Number of ways in which a game is solved on each kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// With all heuristics; with none; with a single one and without one, in turn (by seed); with a
    /// random set from a random order.
    Five,
    /// The first two, and one of the others in turn.
    Three,
}

impl Extent {
    /// Number of verdicts on both kernels.
    pub fn verdicts(self) -> u64 {
        match self {
            Self::Five => 10,
            Self::Three => 6,
        }
    }
}

fn ways(specification: &Specification, seed: u64, extent: Extent) -> Vec<Way> {
    let count = Heuristic::ALL.len() as u64;
    let one = Heuristic::ALL[(seed % count) as usize].0;
    let other = Heuristic::ALL[(seed / count % count) as usize].0;
    let mut random = Random::new(!seed);
    let turn = seed / 7 % 3;
    let any = Heuristic::ALL
        .iter()
        .fold(Heuristics::none(), |set, (h, _)| {
            if random.chance(50) { set.with(*h) } else { set }
        });
    let mut variables: Vec<usize> = (0..specification.variables.len()).collect();
    for i in (1..variables.len()).rev() {
        variables.swap(i, random.below(i as u64 + 1) as usize);
    }
    let way = |heuristics, order, machine| Way {
        heuristics,
        order,
        machine,
    };
    let mut ways = vec![
        way(Heuristics::all(), None, true),
        way(Heuristics::none(), None, turn == 0),
        way(Heuristics::all().without(one), None, turn == 1),
        way(Heuristics::none().with(other), None, turn == 2),
        way(any, order_from_variables(specification, variables), false),
    ];
    if extent == Extent::Three {
        ways.swap(2, 2 + (seed % 3) as usize);
        ways.truncate(3);
    }
    ways
}

fn names(heuristics: Heuristics) -> String {
    let known = Heuristic::ALL.iter().filter(|(h, _)| heuristics.has(*h));
    known.map(|(_, name)| *name).collect::<Vec<_>>().join(",")
}

/// Solves the game in every way on both kernels; each must find `expected`, and machines must be
/// correct.
pub fn agree(
    specification: &Specification,
    board: &Board<'_>,
    expected: bool,
    seed: u64,
    extent: Extent,
) -> Tried {
    let mut tried = Tried::default();
    // Enough memory for such small games; more would have to be set up thousands of times.
    let limits = Limits {
        max_nodes: Some(1 << 16),
        ..Limits::default()
    };
    let mut cores: Vec<Vec<GuaranteeRef>> = Vec::new();
    for way in ways(specification, seed, extent) {
        for (kernel, name) in KERNELS {
            let options = Options {
                limits,
                kernel,
                heuristics: way.heuristics,
                without_core: !way.machine,
                initial_order: way.order.clone(),
                ..Options::default()
            };
            let what = || format!("seed {seed}, {name}, with `{}`", names(way.heuristics));
            let Solution {
                outcome,
                statistics,
            } = solve_with(specification, &options);
            assert_eq!(statistics.kernel, name);
            tried.verdicts += 1;
            tried.reordered += u64::from(statistics.order_before != statistics.order_after);
            let realizable = match outcome {
                Outcome::GaveUp(limit) => panic!("{}: {limit}", what()),
                Outcome::Unrealizable(lost) => {
                    if way.machine {
                        cores.push(lost.core.expect("no limit"));
                    }
                    false
                }
                Outcome::Realizable(won) => {
                    if way.machine {
                        let machine = extract(specification, &won, &limits).expect("no limit");
                        let accepted = accepts(board, &machine);
                        assert_eq!(accepted, Ok(()), "{}\n{specification:#?}", what());
                        let verdict = verify(specification, &machine, &limits).expect("no limit");
                        assert_eq!(verdict, Ok(()), "{}\n{specification:#?}", what());
                        tried.machines += 1;
                    }
                    true
                }
            };
            assert_eq!(realizable, expected, "{}\n{specification:#?}", what());
        }
        tried.sets.insert(names(way.heuristics));
    }
    for core in &cores {
        assert_eq!(*core, cores[0], "seed {seed}\n{specification:#?}");
        tried.cores += 1;
    }
    tried
}

/// Plays numbered games in three ways on each kernel, all compared with the oracle; returns the
/// number of realizable ones.
pub fn play<'a>(games: impl ParallelIterator<Item = (usize, Cow<'a, Specification>)>) -> u64 {
    let played = games.map(|(number, specification)| {
        let board = Board::new(&specification);
        let expected = board.realizable(&Subset::All);
        let seed = number as u64;
        let tried = agree(&specification, &board, expected, seed, Extent::Three);
        (1, u64::from(expected), tried)
    });
    let (count, realizable, tried) = played.reduce(
        || (0, 0, Tried::default()),
        |mut a, b| {
            a.2 += b.2;
            (a.0 + b.0, a.1 + b.1, a.2)
        },
    );
    println!("{count} games, {realizable} realizable; {tried}");
    assert_eq!(tried.verdicts, Extent::Three.verdicts() * count);
    complete(&tried);
    realizable
}

/// Checks that nothing was missed over many games: every heuristic alone and omitted, machines,
/// cores.
pub fn complete(tried: &Tried) {
    let enough = |count: u64, percent: u64| count * 100 > tried.verdicts * percent;
    assert!(enough(tried.machines, 10), "{tried}");
    assert!(enough(tried.cores, 10), "{tried}");
    let (all, none) = (Heuristics::all(), Heuristics::none());
    for (heuristic, name) in Heuristic::ALL {
        for set in [all, none, all.without(heuristic), none.with(heuristic)] {
            assert!(tried.sets.contains(&names(set)), "{name}");
        }
    }
}
