//! Compatibility compared with a naive solver of the game with swapped roles.
//!
//! The outside plays: it sets what no part sets, must keep all assumptions for as long as the parts
//! keep their guarantees, and must meet the justice of the assumptions whenever that of the
//! guarantees is met. If machines see the inputs of the step that they answer, the outside moves
//! first. Moore machines answer before it, and it sees their answer. The answer is allowed if it
//! keeps the guarantees of the Moore machines together with some values of everything else; with
//! other values the outside leaves the parts with a broken promise.

use super::contracts::{self, formula};
use super::graph::{Board, Relation, Set, Steps, members};
use super::lassos::keeps;
use super::wired::{self, Plan};
use crate::random::Random;
use linewright::algebra::compat::{Assumption, Compatibility, compatible};
use linewright::algebra::proof::Refutation;
use linewright::algebra::system::{Component, System};
use linewright::game::Limits;
use linewright::gr1::{BinaryOp, Domain, Expr, Formula, Side, Timing, VarId};

const SYSTEMS: u64 = 5_000;

/// The game, with explicit states.
struct Swapped {
    board: Board,
    sees: bool,
    /// Whether the outside may leave the parts no legal answer.
    corners: bool,
    /// The parts' moves, those that only the Moore machines' guarantees restrict, and the
    /// obligations of the outside.
    parts: Steps,
    early: Steps,
    outside: Steps,
    owed: Vec<Relation>,
    goals: Vec<Relation>,
    /// Valuations with the same values from outside, and with the same values of Moore machines.
    from_outside: Vec<Set>,
    of_moore: Vec<Set>,
}

/// Combines the formulas of some sides.
fn together<'a>(sides: impl Iterator<Item = &'a Side>) -> Side {
    let mut all = Side::default();
    for side in sides {
        all.append(side);
    }
    all
}

fn names(assumptions: &[Assumption]) -> Vec<&str> {
    assumptions.iter().map(|a| a.name.as_str()).collect()
}

/// Only the formulas with these names.
fn named(side: &Side, names: &[&str]) -> Side {
    let only = |list: &[Formula]| -> Vec<Formula> {
        list.iter()
            .filter(|f| names.contains(&f.name.as_str()))
            .cloned()
            .collect()
    };
    Side {
        initial: only(&side.initial),
        invariants: only(&side.invariants),
        safety: only(&side.safety),
        justice: only(&side.justice),
    }
}

impl Swapped {
    /// The game for the remaining assumptions.
    fn new(system: &System, assumptions: &Side) -> Self {
        let board = Board::new(&system.variables);
        let guarantees = together(system.components.iter().map(|p| &p.guarantees));
        let first = system.components.iter();
        let first = first.filter(|p| p.timing == Timing::Moore);
        let early = together(first.map(|p| &p.guarantees));
        let own = |v: &VarId| system.driver(*v).is_some();
        let moore = |v: &VarId| {
            let driver = system.driver(*v);
            driver.is_some_and(|p| system.components[p].timing == Timing::Moore)
        };
        let sees = system.components.iter().any(|p| p.timing == Timing::Moore);
        let alike = |which: &dyn Fn(&VarId) -> bool| {
            let key = |valuation: &Vec<i64>| -> Vec<i64> {
                let all = valuation.iter().enumerate();
                all.filter(|(i, _)| which(&VarId(*i as u32)))
                    .map(|(_, x)| *x)
                    .collect()
            };
            let mut keys: Vec<Vec<i64>> = board.valuations.iter().map(key).collect();
            let each: Vec<Vec<i64>> = keys.clone();
            keys.sort();
            keys.dedup();
            let group = |k: &Vec<i64>| {
                let all = each.iter().enumerate().filter(|(_, e)| *e == k);
                all.fold(0, |set: Set, (i, _)| set | 1 << i)
            };
            keys.iter().map(group).collect::<Vec<Set>>()
        };
        // An empty justice list is the condition that is always met.
        let or_true = |list: Vec<Relation>| {
            if list.is_empty() {
                vec![vec![board.everything(); board.valuations.len()]]
            } else {
                list
            }
        };
        Self {
            parts: board.steps([&guarantees]),
            early: board.steps([&early]),
            outside: board.steps([assumptions]),
            owed: or_true(board.relations(&guarantees.justice)),
            goals: or_true(board.relations(&assumptions.justice)),
            from_outside: alike(&|v| !own(v)),
            of_moore: alike(&moore),
            corners: true,
            sees,
            board,
        }
    }

    /// Whether the outside can reach one of `kept` that is also in `good`, after whatever the Moore
    /// machines set and whichever of `legal` the others then choose.
    fn controls(&self, moves: &Moves, good: Set) -> bool {
        let mut answers = self.of_moore.iter();
        answers.all(|y| self.answers(*y, moves, good))
    }

    /// The same after `y`. If it leaves the parts no way to keep their promise, any of `kept` is
    /// sufficient: it must not violate an assumption itself.
    fn answers(&self, y: Set, moves: &Moves, good: Set) -> bool {
        let mut choices = self.from_outside.iter().map(|x| x & y);
        self.sees && y & moves.early == 0
            || choices.any(|x| match x & moves.legal {
                0 => self.corners && x & moves.kept != 0,
                answers => answers & !(moves.kept & good) == 0,
            })
    }

    /// νZ. ⋀ⱼ μY. ⋁ᵢ νX, as in the textbook.
    fn winning(&self) -> Set {
        let all = self.board.everything();
        let before = |target: &dyn Fn(usize) -> Set| {
            members(all)
                .filter(|s| self.controls(&self.moves(Some(*s)), target(*s)))
                .fold(0, |set: Set, s| set | 1 << s)
        };
        let mut z = all;
        loop {
            let mut everywhere = all;
            for goal in &self.goals {
                let mut y = 0;
                loop {
                    let mut more = 0;
                    for owed in &self.owed {
                        let mut x = all;
                        loop {
                            let less = before(&|s| (goal[s] & z) | y | (!owed[s] & x));
                            if less == x {
                                break;
                            }
                            x = less;
                        }
                        more |= x;
                    }
                    if more == y {
                        break;
                    }
                    y = more;
                }
                everywhere &= y;
            }
            if everywhere == z {
                return z;
            }
            z = everywhere;
        }
    }

    fn won(&self) -> bool {
        self.controls(&self.moves(None), self.winning())
    }

    /// Possible steps after a state, or at the beginning.
    fn moves(&self, after: Option<usize>) -> Moves {
        let of = |steps: &Steps| after.map_or(steps.start, |s| steps.step[s]);
        Moves {
            early: of(&self.early),
            legal: of(&self.parts),
            kept: of(&self.outside),
        }
    }
}

/// Valuations that keep the Moore machines' guarantees, all guarantees, and the assumptions.
struct Moves {
    early: Set,
    legal: Set,
    kept: Set,
}

/// A finite play: everything is kept before the last step; then, whatever the outside does, the
/// parts can make it violate some assumption.
fn check_trace(game: &Swapped, steps: &[Vec<i64>]) {
    let states: Vec<usize> = steps.iter().map(|s| game.board.number(s)).collect();
    let mut before = None;
    for (i, state) in states.iter().enumerate() {
        let moves = game.moves(before);
        let Moves { early, legal, kept } = moves;
        if i + 1 < states.len() {
            assert!((legal & kept) >> state & 1 == 1, "step {i} of {steps:?}");
        } else {
            // The Moore machines' values are given; no outside values are compatible.
            let same = game.of_moore.iter().find(|y| *y >> state & 1 == 1);
            let same = *same.expect("a group");
            assert!(!game.sees || same & early != 0, "{steps:?}");
            let everything = game.board.everything();
            assert!(!game.answers(same, &moves, everything), "{steps:?}");
            let mut choices = game.from_outside.iter().map(|x| x & same);
            let own = choices.find(|x| x >> state & 1 == 1);
            let is_cornered = own.expect("a group") & legal == 0;
            assert!(
                is_cornered || (legal & !kept) >> state & 1 == 1,
                "the end of {steps:?}"
            );
        }
        before = Some(*state);
    }
}

/// The verdict equals that of the naive solver; the named assumptions cannot be kept, but any
/// proper subset can; and every play is valid.
#[test]
fn environments_exist_where_the_swapped_game_is_won() {
    let limits = Limits::default();
    let (mut can, mut cannot, mut sees, mut traces, mut cycles, mut several) = (0, 0, 0, 0, 0, 0);
    let mut cornered = 0;
    for seed in 70_000..70_000 + SYSTEMS {
        let mut r = Random::new(seed);
        let plan = Plan {
            parts: 1 + r.below(2),
            outside: 1 + r.below(2),
            moore: if r.chance(40) { 90 } else { 20 },
            derived: 25,
            demanding: r.chance(90),
            sees: 40,
        };
        let system = wired::system(&mut r, &plan, &|_, _| ());
        let assumptions = together(system.components.iter().map(|p| &p.assumptions));
        let mut game = Swapped::new(&system, &assumptions);
        let found = compatible(&system, &limits).expect("no limit");
        sees += u32::from(game.sees);
        let Compatibility::Incompatible {
            assumptions: core_of,
            play,
        } = found
        else {
            assert!(game.won(), "seed {seed}: {system:#?}");
            can += 1;
            game.corners = false;
            cornered += u32::from(!game.won());
            continue;
        };
        assert!(!game.won(), "seed {seed}: {system:#?}");
        cannot += 1;
        let named_ones = names(&core_of);
        for a in &core_of {
            let component = &system.components[a.component].name;
            assert!(a.name.starts_with(component.as_str()), "seed {seed}: {a:?}");
        }
        let core = Swapped::new(&system, &named(&assumptions, &named_ones));
        assert!(!core.won(), "seed {seed}: {named_ones:?}");
        several += u32::from(named_ones.len() > 1);
        for i in 0..named_ones.len() {
            let mut fewer = named_ones.clone();
            fewer.remove(i);
            let fewer = Swapped::new(&system, &named(&assumptions, &fewer));
            assert!(fewer.won(), "seed {seed}: {named_ones:?} without {i}");
        }
        match play.expect("no limit") {
            Refutation::Trace(steps) => {
                traces += 1;
                check_trace(&game, &steps);
            }
            Refutation::Lasso(run) => {
                cycles += 1;
                let promised = system.components.iter().all(|p| keeps(&p.guarantees, &run));
                assert!(promised, "seed {seed}: {run:?}");
                let safe = Side {
                    justice: Vec::new(),
                    ..assumptions.clone()
                };
                assert!(keeps(&safe, &run), "seed {seed}: {run:?}");
                assert!(!keeps(&assumptions, &run), "seed {seed}: {run:?}");
            }
        }
    }
    println!(
        "{SYSTEMS} systems ({sees} where the outside answers last): {can} compatible ({cornered} only by \
         cornering the parts), {cannot} not; {traces} plays end, {cycles} go round; {several} cores of more than one assumption"
    );
    let systems = SYSTEMS as u32;
    assert!(can * 5 >= systems && cannot * 5 >= systems && sees * 10 >= systems);
    assert!(traces >= 100 && cycles >= 50 && several >= 20);
}

/// A Moore machine that shares no variable with the others, and can always answer, changes no
/// verdict: neither among Mealy machines, which otherwise all answer after the environment, nor
/// among others.
#[test]
fn unrelated_moore_machines_change_no_verdict() {
    let limits = Limits::default();
    let (mut can, mut cannot, mut stuck) = (0, 0, 0);
    for seed in 90_000..92_000 {
        let mut r = Random::new(seed);
        let plan = Plan {
            parts: 1 + r.below(2),
            outside: 1 + r.below(2),
            moore: 20,
            derived: 25,
            demanding: r.chance(90),
            sees: 40,
        };
        let mut system = wired::system(&mut r, &plan, &|_, _| ());
        let alone = compatible(&system, &limits).expect("no limit");
        let own = VarId(system.variables.len() as u32);
        let domains = system.variables.iter().map(|v| v.domain.clone());
        let domains: Vec<Domain> = domains.chain([Domain::Bool]).collect();
        system.variables = contracts::named(&domains);
        let turns = Expr::next(own).equals(Expr::now(own).not());
        system.components.push(Component {
            name: "Unrelated".to_owned(),
            timing: Timing::Moore,
            drives: vec![own],
            assumptions: Side::default(),
            guarantees: Side {
                initial: vec![formula("off".to_owned(), Expr::now(own).not())],
                safety: vec![formula("turns".to_owned(), turns)],
                justice: vec![formula("on".to_owned(), Expr::now(own))],
                ..Side::default()
            },
            definitions: Side::default(),
            completions: Side::default(),
        });
        let joined = compatible(&system, &limits).expect("no limit");
        match (&alone, &joined) {
            (Compatibility::Compatible, Compatibility::Compatible) => can += 1,
            (Compatibility::Incompatible { .. }, Compatibility::Incompatible { .. }) => cannot += 1,
            _ => panic!("seed {seed}: {alone:?} alone, then {joined:?}: {system:#?}"),
        }
        let guarantees = together(system.components.iter().map(|p| &p.guarantees));
        let board = Board::new(&system.variables);
        let steps = board.steps([&guarantees]);
        stuck += u32::from(steps.start == 0 || steps.step.contains(&0));
    }
    println!("{can} compatible, {cannot} not; in {stuck} the parts can be without an answer");
    assert!(can >= 400 && cannot >= 400 && stuck >= 400);
}

/// A code that a variable's bits allow but its domain does not is no answer: `y` has three values
/// in two bits, and with a fourth one the part would have no legal answer. It need not ever
/// withdraw `x`.
#[test]
fn codes_without_a_value_are_no_way_out() {
    let now = |v: u32| Expr::now(VarId(v));
    let within = |e: Expr| Expr::binary(BinaryOp::Le, e, Expr::Const(2));
    let part = |timing, guarantees| Component {
        name: "A".to_owned(),
        timing,
        drives: vec![VarId(0)],
        assumptions: Side {
            justice: vec![formula("withdrawn".to_owned(), now(0).not())],
            ..Side::default()
        },
        guarantees,
        definitions: Side::default(),
        completions: Side::default(),
    };
    let step = || formula("step".to_owned(), within(Expr::next(VarId(1))));
    let state = || formula("state".to_owned(), within(now(1)));
    let kinds = [
        Side {
            safety: vec![step()],
            ..Side::default()
        },
        Side {
            invariants: vec![state()],
            ..Side::default()
        },
        Side {
            initial: vec![state()],
            ..Side::default()
        },
    ];
    for guarantees in kinds {
        for timing in [Timing::Mealy, Timing::Moore] {
            let system = System {
                variables: contracts::named(&[Domain::Bool, Domain::Range { low: 0, high: 2 }]),
                components: vec![part(timing, guarantees.clone())],
            };
            let found = compatible(&system, &Limits::default()).expect("no limit");
            let Compatibility::Incompatible { assumptions, play } = found else {
                panic!("{timing:?}: {guarantees:?}");
            };
            assert_eq!(names(&assumptions), ["withdrawn"]);
            assert!(matches!(play, Some(Refutation::Lasso(_))), "{play:?}");
        }
    }
}

/// Without power the heater cannot start hot, as it promises; but without power the environment has
/// broken an assumption itself. So the heater starts with power and hot, and the next step breaks
/// one of the two.
#[test]
fn no_answer_is_left_only_within_the_assumptions() {
    let (power, hot) = (VarId(0), VarId(1));
    let heater = Component {
        name: "Heater".to_owned(),
        timing: Timing::Mealy,
        drives: vec![hot],
        assumptions: Side {
            invariants: vec![formula("powered".to_owned(), Expr::now(power))],
            safety: vec![formula(
                "cuts_out".to_owned(),
                Expr::now(hot).implies(Expr::next(power).not()),
            )],
            ..Side::default()
        },
        guarantees: Side {
            initial: vec![
                formula(
                    "follows".to_owned(),
                    Expr::now(hot).implies(Expr::now(power)),
                ),
                formula("starts_hot".to_owned(), Expr::now(hot)),
            ],
            ..Side::default()
        },
        definitions: Side::default(),
        completions: Side::default(),
    };
    let mut system = System {
        variables: contracts::named(&[Domain::Bool, Domain::Bool]),
        components: vec![heater],
    };
    let found = compatible(&system, &Limits::default()).expect("no limit");
    let Compatibility::Incompatible { assumptions, play } = found else {
        panic!("no environment keeps both");
    };
    assert_eq!(names(&assumptions), ["powered", "cuts_out"]);
    let Some(Refutation::Trace(steps)) = play else {
        panic!("a step without a way on");
    };
    assert_eq!((steps.len(), &steps[0]), (2, &vec![1, 1]));
    // It need not always be powered.
    system.components[0].assumptions.invariants.clear();
    let found = compatible(&system, &Limits::default()).expect("no limit");
    assert_eq!(found, Compatibility::Compatible);
}
