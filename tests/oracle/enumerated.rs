//! Games over two inputs and two outputs with at most one initial, one safety and one justice formula a side, of up to three
//! operators each. There are more than anyone could play, so one role is exhausted: every formula of the machine's safety occurs
//! three times, up to renaming inputs and outputs among themselves; the other formulas are drawn by the game's number, each
//! length as often as the others, and none as often as one.
//!
//! A formula stands for all that mean the same: functions are told apart by their values, and each is written with as few
//! operators as it can be.

use super::exhaustive::{listed, variable};
use super::random::Random;
use super::ways::play;
use linewright::gr1::{Expr, Owner, Side, Specification, Timing, VarId};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashSet;

/// The values of a function for every valuation of the atoms: bit `i` of a valuation's number is atom `i`.
type Values = [u64; 4];

/// Two inputs, two outputs, and their next values.
const ATOMS: usize = 8;

/// An atom is a variable now, or four places further on its next value.
const VARIABLES: usize = 4;

const MOST_OPERATORS: usize = 3;

#[derive(Clone, Copy)]
enum Operator {
    And,
    Or,
    Iff,
}

#[derive(Clone, Copy)]
enum Form {
    Literal(usize, bool),
    Binary(Operator, usize, usize),
}

/// Every function of some atoms that up to three operators can say; a negated variable counts as none.
struct Functions {
    all: Vec<(Values, Form)>,
    /// Where those of each number of operators begin, and the end.
    begin: Vec<usize>,
}

impl Functions {
    fn of(atoms: &[usize]) -> Self {
        let mut all: Vec<(Values, Form)> = Vec::new();
        let mut known: HashSet<Values> = HashSet::new();
        for atom in atoms {
            for positive in [true, false] {
                let values = literal(*atom, positive);
                known.insert(values);
                all.push((values, Form::Literal(*atom, positive)));
            }
        }
        let mut begin = vec![0, all.len()];
        for operators in 1..=MOST_OPERATORS {
            let mut fresh = Vec::new();
            for left in 0..operators {
                let right = operators - 1 - left;
                if left < right {
                    continue;
                }
                for i in begin[left]..begin[left + 1] {
                    for j in begin[right]..begin[right + 1] {
                        for operator in [Operator::And, Operator::Or, Operator::Iff] {
                            let values = apply(operator, &all[i].0, &all[j].0);
                            if known.insert(values) {
                                fresh.push((values, Form::Binary(operator, i, j)));
                            }
                        }
                    }
                }
            }
            all.extend(fresh);
            begin.push(all.len());
        }
        Self { all, begin }
    }

    fn expr(&self, index: usize) -> Expr {
        match self.all[index].1 {
            Form::Literal(atom, positive) => {
                let variable = VarId((atom % VARIABLES) as u32);
                let atom = if atom < VARIABLES {
                    Expr::now(variable)
                } else {
                    Expr::next(variable)
                };
                if positive { atom } else { atom.not() }
            }
            Form::Binary(operator, left, right) => {
                let (left, right) = (self.expr(left), self.expr(right));
                match operator {
                    Operator::And => left.and(right),
                    Operator::Or => left.or(right),
                    Operator::Iff => left.equals(right),
                }
            }
        }
    }

    /// None, or one of any number of operators.
    fn any(&self, random: &mut Random) -> Option<Expr> {
        let operators = random.below(MOST_OPERATORS as u64 + 2).checked_sub(1)? as usize;
        let (begin, end) = (self.begin[operators], self.begin[operators + 1]);
        if begin == end {
            return None;
        }
        Some(self.expr(begin + random.below((end - begin) as u64) as usize))
    }

    /// One of each set that renaming makes of a function, the first one.
    fn up_to_renaming(&self) -> Vec<usize> {
        let renamings = renamings();
        let mut seen: HashSet<Values> = HashSet::new();
        let functions = self.all.iter().enumerate();
        let first = functions.filter(|(_, (values, _))| {
            let renamed = renamings.iter().map(|r| rename(values, r));
            let least = renamed.min();
            seen.insert(least.expect("there is the one that changes nothing"))
        });
        first.map(|(index, _)| index).collect()
    }
}

fn literal(atom: usize, positive: bool) -> Values {
    let mut values = [0; 4];
    for valuation in 0..1_usize << ATOMS {
        if (valuation >> atom & 1 == 1) == positive {
            values[valuation / 64] |= 1 << (valuation % 64);
        }
    }
    values
}

fn apply(operator: Operator, a: &Values, b: &Values) -> Values {
    std::array::from_fn(|i| match operator {
        Operator::And => a[i] & b[i],
        Operator::Or => a[i] | b[i],
        Operator::Iff => !(a[i] ^ b[i]),
    })
}

/// Inputs swapped or not, outputs swapped or not: for every valuation the one it becomes.
fn renamings() -> Vec<Vec<usize>> {
    let swap = |valuation: usize, a: usize, b: usize| {
        let different = (valuation >> a ^ valuation >> b) & 1;
        valuation ^ (different << a | different << b)
    };
    let mut renamings = Vec::new();
    for (inputs, outputs) in [(false, false), (true, false), (false, true), (true, true)] {
        let renamed = |mut valuation: usize| {
            if inputs {
                valuation = swap(swap(valuation, 0, 1), 4, 5);
            }
            if outputs {
                valuation = swap(swap(valuation, 2, 3), 6, 7);
            }
            valuation
        };
        renamings.push((0..1 << ATOMS).map(renamed).collect());
    }
    renamings
}

fn rename(values: &Values, renaming: &[usize]) -> Values {
    let mut renamed = [0; 4];
    for (valuation, becomes) in renaming.iter().enumerate() {
        let value = values[valuation / 64] >> (valuation % 64) & 1;
        renamed[becomes / 64] |= value << (becomes % 64);
    }
    renamed
}

/// The functions that each kind of formula may be.
struct Roles {
    inputs: Functions,
    states: Functions,
    /// States and next inputs.
    moves: Functions,
    steps: Functions,
}

impl Roles {
    fn new() -> Self {
        Self {
            inputs: Functions::of(&[0, 1]),
            states: Functions::of(&[0, 1, 2, 3]),
            moves: Functions::of(&[0, 1, 2, 3, 4, 5]),
            steps: Functions::of(&[0, 1, 2, 3, 4, 5, 6, 7]),
        }
    }

    /// The game of a number, with this formula as the machine's safety.
    fn game(&self, number: usize, safety: usize) -> Specification {
        let mut random = Random::new(number as u64);
        Specification {
            name: "enumerated".to_owned(),
            timing: if random.chance(70) {
                Timing::Mealy
            } else {
                Timing::Moore
            },
            variables: vec![
                variable("a", Owner::Environment),
                variable("b", Owner::Environment),
                variable("x", Owner::System),
                variable("y", Owner::System),
            ],
            assumptions: Side {
                initial: listed(self.inputs.any(&mut random)),
                safety: listed(self.moves.any(&mut random)),
                justice: listed(self.moves.any(&mut random)),
                ..Side::default()
            },
            guarantees: Side {
                initial: listed(self.states.any(&mut random)),
                safety: listed(Some(self.steps.expr(safety))),
                justice: listed(self.steps.any(&mut random)),
                ..Side::default()
            },
        }
    }
}

/// How many games each formula of the machine's safety occurs in.
const ROUNDS: usize = 3;

/// Plays every `stride`-th game; gives how many there were.
fn play_every(stride: usize) -> usize {
    let roles = Roles::new();
    let formulas = roles.steps.up_to_renaming();
    println!(
        "{} functions of a step, {} up to renaming",
        roles.steps.all.len(),
        formulas.len()
    );
    let rounds = formulas.iter().flat_map(|f| [*f; ROUNDS]);
    let games: Vec<(usize, usize)> = rounds.enumerate().step_by(stride).collect();
    let played = games.par_iter().map(|(number, safety)| {
        let game = roles.game(*number, *safety);
        (*number, Cow::Owned(game))
    });
    let realizable = play(played);
    let count = games.len() as u64;
    assert!(realizable * 5 > count && (count - realizable) * 5 > count);
    games.len()
}

#[test]
fn every_function_is_there_and_renaming_loses_none() {
    assert_eq!(Functions::of(&[0, 1]).all.len(), 16);
    let functions = Roles::new().steps;
    let renamings = renamings();
    let first = functions.up_to_renaming().into_iter();
    let sizes = first.map(|index| {
        let values = &functions.all[index].0;
        let renamed = renamings.iter().map(|r| rename(values, r));
        renamed.collect::<HashSet<Values>>().len()
    });
    assert_eq!(sizes.sum::<usize>(), functions.all.len());
}

#[test]
fn games_of_four_bits_by_the_formula() {
    assert!(play_every(5) >= 20_000);
}

#[test]
#[ignore = "takes minutes: cargo test --test oracle -- --ignored"]
fn all_games_of_four_bits_by_the_formula() {
    assert!(play_every(1) >= 100_000);
}
