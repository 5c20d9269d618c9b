//! Both kernels, all heuristics on and off, on random games: the verdict of the naive solver, and
//! machines that keep their specification.

use super::ways::{Extent, Tried, agree, complete};
use crate::game::{Board, Subset};
use crate::random::{Random, specification, specification_with_goals};
use linewright::game::GuaranteeRef;
use linewright::gr1::{Domain, Formula, FormulaKind, Specification, Timing};
use rayon::prelude::*;
use std::ops::AddAssign;

/// Number of games of each kind.
const ORDINARY: u64 = 2_000;

/// Number of games of each kind in the tests that are ignored by default.
const LONG: u64 = 20_000;

/// Statistics of the games.
#[derive(Debug, Default, Clone)]
struct Counts {
    /// By timing (Mealy, Moore): numbers of unrealizable and realizable ones.
    verdicts: [[u64; 2]; 2],
    /// Unrealizable ones that would be realizable without the machine's goals.
    goals_decide: u64,
    /// Realizable ones that would not be without the environment's justice.
    assumptions_decide: u64,
    /// Those where a justice formula of each side mentions an integer.
    integer_goals: u64,
    /// Those with goals that refer to next values.
    step_goals: u64,
    tried: Tried,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        for (mine, theirs) in self.verdicts.iter_mut().zip(other.verdicts) {
            for (mine, theirs) in mine.iter_mut().zip(theirs) {
                *mine += theirs;
            }
        }
        self.goals_decide += other.goals_decide;
        self.assumptions_decide += other.assumptions_decide;
        self.integer_goals += other.integer_goals;
        self.step_goals += other.step_goals;
        self.tried += other.tried;
    }
}

impl Counts {
    fn say(&self) {
        let [[lost, won], [lost_first, won_first]] = self.verdicts;
        println!(
            "Mealy: {won} realizable, {lost} not; Moore: {won_first}, {lost_first}; the machine's goals decide {}, the environment's \
             justice {}; {} with integers in the justice of both sides, {} with next values there; {}",
            self.goals_decide,
            self.assumptions_decide,
            self.integer_goals,
            self.step_goals,
            self.tried,
        );
    }
}

fn mentions_integer(specification: &Specification, formulas: &[Formula]) -> bool {
    let mut found = false;
    for formula in formulas {
        formula.expr.for_each_var(&mut |v, _| {
            found |= matches!(specification.variable(v).domain, Domain::Range { .. });
        });
    }
    found
}

/// Plays one game in every way.
fn play(specification: &Specification, seed: u64) -> Counts {
    let board = Board::new(specification);
    let expected = board.realizable(&Subset::All);
    let mut counts = Counts {
        tried: agree(specification, &board, expected, seed, Extent::Five),
        ..Counts::default()
    };
    let moore = usize::from(specification.timing == Timing::Moore);
    counts.verdicts[moore][usize::from(expected)] = 1;
    let (assumed, wanted) = (
        &specification.assumptions.justice,
        &specification.guarantees.justice,
    );
    counts.integer_goals = u64::from(
        mentions_integer(specification, assumed) && mentions_integer(specification, wanted),
    );
    let mut goals = assumed.iter().chain(wanted);
    counts.step_goals = u64::from(goals.any(|f| f.expr.mentions_next()));
    if expected {
        let mut alone = specification.clone();
        alone.assumptions.justice.clear();
        let lost = !Board::new(&alone).realizable(&Subset::All);
        counts.assumptions_decide = u64::from(lost);
    } else {
        let sides = &specification.guarantees;
        let lists = [
            (FormulaKind::Initial, sides.initial.len()),
            (FormulaKind::Invariant, sides.invariants.len()),
            (FormulaKind::Safety, sides.safety.len()),
        ];
        let refs = lists
            .into_iter()
            .flat_map(|(kind, length)| (0..length).map(move |index| GuaranteeRef { kind, index }));
        let refs: Vec<GuaranteeRef> = refs.collect();
        counts.goals_decide = u64::from(board.realizable(&Subset::Only(&refs)));
    }
    counts
}

fn play_all(
    seeds: std::ops::Range<u64>,
    draw: impl Fn(&mut Random) -> Specification + Sync,
) -> Counts {
    let played = seeds.into_par_iter().map(|seed| {
        let specification = draw(&mut Random::new(seed));
        play(&specification, seed)
    });
    played.reduce(Counts::default, |mut a, b| {
        a += b;
        a
    })
}

/// Every way of solving finds the naive solver's verdict, whatever the specification.
#[test]
fn any_games_in_every_way() {
    play_any(ORDINARY);
}

#[test]
#[ignore = "takes minutes: cargo test --test solver oracle:: -- --ignored"]
fn many_games_in_every_way() {
    play_any(LONG);
}

fn play_any(count: u64) {
    let counts = play_all(0..count, specification);
    counts.say();
    let [mealy, moore] = counts.verdicts;
    assert!(
        mealy.iter().chain(&moore).all(|n| n * 10 > count),
        "{counts:?}"
    );
    assert!(
        counts.tried.verdicts == Extent::Five.verdicts() * count,
        "{counts:?}"
    );
    assert!(counts.tried.reordered > count / 2, "{counts:?}");
    complete(&counts.tried);
}

/// The hardest case: all three fixpoints matter, and integers make some codes invalid.
#[test]
fn games_with_integers_and_goals_in_every_way() {
    play_with_goals(ORDINARY);
}

#[test]
#[ignore = "takes minutes: cargo test --test solver oracle:: -- --ignored"]
fn many_games_with_integers_and_goals_in_every_way() {
    play_with_goals(LONG);
}

fn play_with_goals(count: u64) {
    let counts = play_all(2_000_000..2_000_000 + count, |r| {
        let specification = specification_with_goals(r);
        assert!(specification.assumptions.justice.len() >= 2);
        assert!(specification.guarantees.justice.len() >= 2);
        let mut domains = specification.variables.iter().map(|v| &v.domain);
        assert!(domains.any(|d| matches!(d, Domain::Range { .. })));
        specification
    });
    counts.say();
    let [mealy, moore] = counts.verdicts;
    assert!(
        mealy.iter().chain(&moore).all(|n| n * 10 > count),
        "{counts:?}"
    );
    // Justice matters in many of them, on either side.
    assert!(counts.goals_decide * 20 > count, "{counts:?}");
    assert!(counts.assumptions_decide * 5 > count, "{counts:?}");
    assert!(counts.integer_goals * 2 > count, "{counts:?}");
    assert!(counts.step_goals * 5 > count, "{counts:?}");
    assert!(
        counts.tried.verdicts == Extent::Five.verdicts() * count,
        "{counts:?}"
    );
    assert!(counts.tried.reordered > count / 2, "{counts:?}");
    complete(&counts.tried);
}
