//! Games over two inputs and two outputs with at most one initial, one safety and one justice
//! formula per side, of up to three operators each.
//!
//! Their product is too large to enumerate, so it is covered role by role. A role is the side and
//! kind of a formula. In a role's pass every formula allowed there is used once, up to renaming
//! inputs and outputs among themselves; meanwhile timing and the other five roles go through every
//! combination of being absent and of each number of operators, and the formulas of each number are
//! taken in turn. A pass is never shorter than these combinations.

use super::exhaustive::{listed, variable};
use super::formulas::{Functions, MOST_OPERATORS, Values, renamings};
use super::ways::play;
use linewright::gr1::{Formula, Owner, Side, Specification, Timing};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashSet;

const ROLES: usize = 6;

/// Name of each role, and the atoms that its formulas may mention: 0 and 1 are the inputs, 2 and 3
/// the outputs, and four more is the next value. The environment chooses without seeing the outputs
/// of the same step.
const ATOMS: [(&str, &[usize]); ROLES] = [
    ("assumed initial", &[0, 1]),
    ("assumed safety", &[0, 1, 2, 3, 4, 5]),
    ("assumed justice", &[0, 1, 2, 3, 4, 5, 6, 7]),
    ("initial", &[0, 1, 2, 3]),
    ("safety", &[0, 1, 2, 3, 4, 5, 6, 7]),
    ("justice", &[0, 1, 2, 3, 4, 5, 6, 7]),
];

/// A game by the indices of its formulas in the lists of their roles.
#[derive(Clone, Copy)]
struct Draft {
    timing: Timing,
    formulas: [Option<usize>; ROLES],
}

/// Formulas with a number of operators, taken in turn; adjacent ones in the list are similar, so
/// they are not taken consecutively.
struct Walk {
    begin: usize,
    count: usize,
    step: usize,
    taken: usize,
}

impl Walk {
    fn next(&mut self) -> usize {
        let place = self.taken * self.step % self.count;
        self.taken += 1;
        self.begin + place
    }
}

fn coprime(a: usize, b: usize) -> bool {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}

/// The walks through a role's formulas, one for each number of operators that occurs.
fn walks(functions: &Functions) -> Vec<Walk> {
    let lengths = (0..=MOST_OPERATORS).map(|operators| functions.of_length(operators));
    let present = lengths.filter(|range| !range.is_empty());
    let walk = present.map(|range| {
        let count = range.len();
        let mut steps = count * 5 / 8 + 1..;
        Walk {
            begin: range.start,
            count,
            step: steps
                .find(|s| coprime(*s, count))
                .expect("a multiple and one"),
            taken: 0,
        }
    });
    walk.collect()
}

fn lists() -> Vec<Functions> {
    ATOMS
        .iter()
        .map(|(_, atoms)| Functions::of(atoms))
        .collect()
}

/// Number of combinations of the other roles being absent or having some number of operators.
fn combinations(lists: &[Functions], role: usize) -> usize {
    let others = (0..ROLES).filter(|other| *other != role);
    others.map(|other| walks(&lists[other]).len() + 1).product()
}

/// All games, pass by pass.
fn drafts(lists: &[Functions]) -> Vec<Draft> {
    let mut walks: Vec<Vec<Walk>> = lists.iter().map(walks).collect();
    let mut drafts = Vec::new();
    for (role, (name, _)) in ATOMS.iter().enumerate() {
        let formulas = lists[role].up_to_renaming();
        let games = formulas.len().max(2 * combinations(lists, role));
        println!(
            "{name}: {} formulas, {} up to renaming, {games} games",
            lists[role].count(),
            formulas.len()
        );
        for number in 0..games {
            // Shifted by one in each round, so that a formula does not meet the same combinations
            // again.
            let turn = number + number / formulas.len();
            let mut rest = number / 2;
            let mut draft = Draft {
                timing: [Timing::Mealy, Timing::Moore][number % 2],
                formulas: [None; ROLES],
            };
            for (other, walks) in walks.iter_mut().enumerate() {
                if other == role {
                    draft.formulas[other] = Some(formulas[turn % formulas.len()]);
                    continue;
                }
                let choice = rest % (walks.len() + 1);
                rest /= walks.len() + 1;
                let walk = choice.checked_sub(1).map(|length| &mut walks[length]);
                draft.formulas[other] = walk.map(Walk::next);
            }
            drafts.push(draft);
        }
    }
    drafts
}

fn game(lists: &[Functions], draft: &Draft) -> Specification {
    let formula = |role: usize| -> Vec<Formula> {
        listed(draft.formulas[role].map(|index| lists[role].expr(index)))
    };
    let side = |first: usize| Side {
        initial: formula(first),
        safety: formula(first + 1),
        justice: formula(first + 2),
        ..Side::default()
    };
    Specification {
        name: "enumerated".to_owned(),
        timing: draft.timing,
        variables: vec![
            variable("a", Owner::Environment),
            variable("b", Owner::Environment),
            variable("x", Owner::System),
            variable("y", Owner::System),
        ],
        assumptions: side(0),
        guarantees: side(3),
    }
}

/// Plays every `stride`-th game; returns their number.
fn play_every(stride: usize) -> usize {
    let lists = lists();
    let drafts = drafts(&lists);
    let games: Vec<&Draft> = drafts.iter().step_by(stride).collect();
    let played = games
        .par_iter()
        .enumerate()
        .map(|(number, draft)| (number, Cow::Owned(game(&lists, draft))));
    let realizable = play(played);
    let count = games.len() as u64;
    assert!(realizable * 5 > count && (count - realizable) * 5 > count);
    games.len()
}

/// Judged by the games themselves, not by their construction.
#[test]
fn every_formula_stands_in_every_role() {
    let (lists, renamings) = (lists(), renamings());
    let drafts = drafts(&lists);
    for role in 0..ROLES {
        let standing: HashSet<usize> = drafts.iter().filter_map(|d| d.formulas[role]).collect();
        let sets: HashSet<Values> = standing
            .iter()
            .map(|index| lists[role].set_of(*index, &renamings))
            .collect();
        let (name, list) = (ATOMS[role].0, &lists[role]);
        assert_eq!(sets.len(), list.up_to_renaming().len(), "{name}");
        // Formulas of up to two operators with all their names, too.
        let short = 0..list.of_length(2).end;
        assert!(
            short.into_iter().all(|index| standing.contains(&index)),
            "{name}"
        );
        assert!(drafts.iter().any(|d| d.formulas[role].is_none()), "{name}");
    }
    let lengths: Vec<[Option<usize>; ROLES]> = drafts.iter().map(|d| lengths(&lists, d)).collect();
    for role in 0..ROLES {
        // What the other roles do meanwhile.
        let others: HashSet<_> = drafts
            .iter()
            .zip(&lengths)
            .filter(|(_, lengths)| lengths[role].is_some())
            .map(|(draft, lengths)| {
                let mut others = *lengths;
                others[role] = None;
                (draft.timing == Timing::Moore, others)
            })
            .collect();
        assert_eq!(others.len(), 2 * combinations(&lists, role));
    }
}

/// The number of operators of each role's formula.
fn lengths(lists: &[Functions], draft: &Draft) -> [Option<usize>; ROLES] {
    std::array::from_fn(|role| {
        let index = draft.formulas[role]?;
        let mut lengths = 0..=MOST_OPERATORS;
        lengths.find(|n| lists[role].of_length(*n).contains(&index))
    })
}

/// The ordinary tests play one game in this many: coprime to every number of choices, so that all
/// choices occur.
const STRIDE: usize = 23;

#[test]
fn games_of_four_bits_by_the_formula() {
    assert!(play_every(STRIDE) >= 6_000);
}

#[test]
#[ignore = "takes minutes: cargo test --test solver oracle:: -- --ignored"]
fn all_games_of_four_bits_by_the_formula() {
    assert!(play_every(1) >= 100_000);
}
