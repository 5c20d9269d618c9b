//! Compatibility: is there an environment that keeps the parts' assumptions, whatever they do
//! within their guarantees?
//!
//! This is a game with swapped roles. The player sets what comes from outside; the opponent sets
//! the parts' outputs and keeps all guarantees. The player has to keep the assumptions for as long
//! as the opponent keeps the guarantees: the strict semantics of GR(1), with the parts' assumptions
//! as its guarantees. For a single contract without guarantees, the question is simply whether its
//! assumption can be realized.
//!
//! The order of moves is swapped as well: Moore machines answer before the environment, which sees
//! their answer, and Mealy machines after it.
//!
//! Either side can leave the other no way to keep its promise. An environment that does so has won,
//! but only if it keeps the assumptions itself, in that step too. That "some answer" does so is no
//! formula of GR(1), so the side that needs the answer names it, in variables of its own.

mod between;

use super::proof::{Refutation, last_step, latest};
use super::system::{KINDS, Part, System, formulas, list, list_mut, rule};
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use linewright_solver::game::{
    self, Ending, Lasso, Limit, Limits, Outcome, RuleKind, Runs, SafetyViolationQuery,
};
use std::collections::{BTreeMap, BTreeSet};

/// Result of the compatibility check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Compatibility {
    /// There is such an environment.
    Compatible,
    /// There is none: the parts can keep their guarantees in such a way that an assumption is
    /// broken.
    Incompatible {
        /// Names of assumptions that cannot be kept together, although any fewer of them could.
        assumptions: Vec<String>,
        /// Play in which one of them is broken. `None` if a limit was reached before one was found.
        play: Option<Refutation>,
    },
}

/// Decides whether there is an environment for all parts of a system together.
///
/// # Errors
/// When a limit was reached.
pub fn compatible(system: &System, limits: &Limits) -> Result<Compatibility, Limit> {
    let is_moore = |part: &Part| part.timing == Timing::Moore;
    let order = if system.parts.iter().all(is_moore) {
        Turn::Last
    } else if system.parts.iter().any(is_moore) {
        Turn::Between
    } else {
        Turn::First
    };
    let late = |v: &VarId| {
        let driver = system.driver(*v);
        driver.is_some_and(|part| !is_moore(&system.parts[part])) || defined(system, *v)
    };
    let game = match order {
        Turn::First => environment_first(system),
        Turn::Between => between::game(system, &late),
        Turn::Last => environment_last(system),
    };
    let lost = match game::solve(&game, limits) {
        Outcome::Realizable(_) => return Ok(Compatibility::Compatible),
        Outcome::Unrealizable(lost) => lost,
        Outcome::GaveUp(limit) => return Err(limit),
    };
    let play = match game::attack(&game, &[], limits) {
        Ok(Some(attack)) => Some(shown(&attack.play, order, system, &late, limits)),
        _ => None,
    };
    Ok(Compatibility::Incompatible {
        assumptions: lost.core_names(&game),
        play,
    })
}

/// Position of the environment's move in a step: before the parts, after those that are Moore
/// machines, or after all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    First,
    Between,
    Last,
}

/// Returns whether a variable belongs to a monitor.
fn defined(system: &System, v: VarId) -> bool {
    let place = system.variables[v.index()].span;
    let sides = system.parts.iter().map(|p| &p.definitions);
    sides
        .flat_map(formulas)
        .any(|(_, _, f)| f.span.holds(place))
}

/// A game of the environment under construction. Its variables are the machine's; those that the
/// parts set are inputs.
struct Game<'s> {
    system: &'s System,
    specification: Specification,
}

impl<'s> Game<'s> {
    /// Creates the game from the parts' assumptions and their justice guarantees. The environment
    /// is the player and sets what is `outside`.
    fn new(system: &'s System, timing: Timing, outside: impl Fn(&VarId) -> bool) -> Self {
        let variables = (0..).map(VarId).zip(&system.variables);
        let variables = variables.map(|(v, variable)| Variable {
            owner: if outside(&v) {
                Owner::System
            } else {
                Owner::Environment
            },
            internal: false,
            ..variable.clone()
        });
        let mut game = Self {
            system,
            specification: Specification {
                name: "environment".to_owned(),
                timing,
                variables: variables.collect(),
                assumptions: Side::default(),
                guarantees: Side::default(),
            },
        };
        let Specification {
            assumptions,
            guarantees,
            ..
        } = &mut game.specification;
        for part in &system.parts {
            extend(guarantees, &part.assumptions);
            let owed = part.guarantees.justice.iter().cloned();
            assumptions.justice.extend(owed);
        }
        game
    }

    fn add(&mut self, owner: Owner, domain: Domain) -> VarId {
        let id = VarId(self.specification.variables.len() as u32);
        let like = self.specification.variables[0].clone();
        self.specification.variables.push(Variable {
            owner,
            internal: true,
            domain,
            ..like
        });
        id
    }

    /// Creates copies of the given variables.
    fn copies(&mut self, of: BTreeSet<VarId>, owner: Owner) -> BTreeMap<VarId, VarId> {
        let copied = of.into_iter().map(|v| {
            let domain = self.specification.variables[v.index()].domain.clone();
            (v, self.add(owner, domain))
        });
        copied.collect()
    }

    /// Creates variables for whether a guarantee has been broken so far, and had been a step
    /// earlier, and the rules that set them.
    fn breach(&mut self, owner: Owner) -> (VarId, VarId, Side) {
        let over = self.add(owner, Domain::Bool);
        let before = self.add(owner, Domain::Bool);
        let promised = |kind| asked(self.system, &|p| &p.guarantees, kind);
        let (first, later) = (promised(RuleKind::Initial), promised(RuleKind::Safety));
        let rules = Side {
            initial: vec![
                unnamed(Expr::now(before).not()),
                unnamed(Expr::now(over).equals(first.not())),
            ],
            safety: vec![
                unnamed(Expr::next(before).equals(Expr::now(over))),
                unnamed(Expr::next(over).equals(Expr::now(over).or(later.not()))),
            ],
            ..Side::default()
        };
        (over, before, rules)
    }

    /// Replaces each assumption that the environment has to keep.
    fn rewrite(&mut self, put: impl Fn(RuleKind, &Formula) -> Expr) {
        for kind in KINDS {
            for f in list_mut(&mut self.specification.guarantees, kind) {
                f.expr = put(kind, f);
            }
        }
    }
}

/// Builds the game in which the environment moves first: all parts are Mealy machines.
///
/// The environment is responsible for its assumptions even if it leaves the parts no answer. The
/// parts may break a guarantee here: `over` is true once they have, `before` one step later. Until
/// `over`, the environment keeps each assumption with the parts' answer; until `before`, with an
/// answer that it names itself. The second matters only if the parts have no answer: an assumption
/// that all allowed answers keep is kept by one of them.
fn environment_first(system: &System) -> Specification {
    let driven = |v: &VarId| system.driver(*v).is_some();
    let mut game = Game::new(system, Timing::Moore, |v| !driven(v));
    let definitions = || system.parts.iter().map(|p| &p.definitions);
    let assumed = system.parts.iter().map(|p| &p.assumptions);
    let answers = assumed.chain(definitions()).flat_map(of_last_step);
    let named = game.copies(answers.filter(driven).collect(), Owner::System);
    let (over, before, rules) = game.breach(Owner::Environment);
    game.rewrite(|kind, f| {
        if kind == RuleKind::Justice {
            return f.expr.clone().or(Expr::now(over));
        }
        let time = last_step(kind);
        let defined = definitions().flat_map(|side| list(side, kind));
        let defined = defined.fold(f.expr.clone(), |all, d| all.and(d.expr.clone()));
        let answered = Expr::Var(over, time).or(f.expr.clone());
        answered.and(Expr::Var(before, time).or(with_copies(&defined, kind, &named)))
    });
    for side in definitions().chain([&rules]) {
        extend(&mut game.specification.assumptions, side);
    }
    game.specification
}

/// Builds the game in which the environment moves last: all parts are Moore machines. A step's
/// monitor values are known after it.
///
/// An answer counts if some outside values make it an allowed one: the parts name these. With other
/// values the environment may leave the parts with a broken guarantee (`over`), as long as it keeps
/// the assumptions itself, in that step too.
fn environment_last(system: &System) -> Specification {
    let definitions: Vec<&Side> = system.parts.iter().map(|p| &p.definitions).collect();
    let defined = |v: &VarId| defined(system, *v);
    let late = |v: &VarId| system.driver(*v).is_none() || defined(v);
    let mut game = Game::new(system, Timing::Mealy, late);
    let promised = system.parts.iter().map(|p| &p.guarantees);
    let mut read: BTreeSet<VarId> = promised.flat_map(of_last_step).filter(late).collect();
    let monitored = read.iter().any(defined);
    if monitored {
        let also = definitions.iter().copied().flat_map(of_last_step);
        read.extend(also.filter(late));
    }
    let is_blind = read.is_empty();
    let named = game.copies(read, Owner::Environment);
    for part in &system.parts {
        for kind in [RuleKind::Initial, RuleKind::Invariant, RuleKind::Safety] {
            let also = list(&part.definitions, kind).iter().filter(|_| monitored);
            for f in list(&part.guarantees, kind).iter().chain(also) {
                list_mut(&mut game.specification.assumptions, kind).push(Formula {
                    expr: with_copies(&f.expr, kind, &named),
                    ..f.clone()
                });
            }
        }
    }
    if !is_blind {
        let (over, before, rules) = game.breach(Owner::System);
        game.rewrite(|kind, f| match kind {
            RuleKind::Justice => f.expr.clone().or(Expr::now(over)),
            _ => Expr::Var(before, last_step(kind)).or(f.expr.clone()),
        });
        extend(&mut game.specification.guarantees, &rules);
    }
    for kind in KINDS {
        let defining = definitions.iter().flat_map(|side| list(side, kind));
        let defining = defining.map(|f| unnamed(f.expr.clone()));
        list_mut(&mut game.specification.guarantees, kind).extend(defining);
    }
    game.specification
}

/// Returns the variables whose values in the last step a side's formulas depend on, justice
/// excluded.
fn of_last_step(side: &Side) -> BTreeSet<VarId> {
    formulas(side)
        .filter(|(kind, ..)| *kind != RuleKind::Justice)
        .flat_map(|(kind, _, f)| latest(&f.expr, kind))
        .collect()
}

/// Replaces variables by copies in the last step of a formula.
fn with_copies(expr: &Expr, kind: RuleKind, copies: &BTreeMap<VarId, VarId>) -> Expr {
    expr.substitute(&mut |v, time| {
        let copy = copies.get(&v).filter(|_| time == last_step(kind));
        Expr::Var(copy.copied().unwrap_or(v), time)
    })
}

fn extend(side: &mut Side, more: &Side) {
    for kind in KINDS {
        list_mut(side, kind).extend(list(more, kind).iter().cloned());
    }
}

/// Returns a rule of the game that belongs to no promise.
fn unnamed(expr: Expr) -> Formula {
    Formula {
        name: String::new(),
        requirement: None,
        expr,
        span: Span::default(),
        text: String::new(),
        defines: true,
    }
}

/// Converts a play to a counterexample: up to the step that breaks an assumption, or round the
/// cycle that starves one.
fn shown(
    play: &game::Play,
    order: Turn,
    system: &System,
    late: &dyn Fn(&VarId) -> bool,
    limits: &Limits,
) -> Refutation {
    let own = |step: &Vec<i64>| step[..system.variables.len()].to_vec();
    let mut steps: Vec<Vec<i64>> = play.steps.iter().map(own).collect();
    if order == Turn::Between {
        let next = match &play.ending {
            Ending::Clash(_) => None,
            Ending::Starved { from, .. } => Some(steps[*from].clone()),
        };
        steps = between::undelayed(&steps, next.as_ref(), late);
    }
    match &play.ending {
        // The outside values of the last step are an example: whatever they are, something is
        // broken. The answers to them are examples too; an allowed one says more.
        Ending::Clash(_) => {
            if order != Turn::Last
                && let Some(last) = steps.pop()
            {
                let allowed = breaking(system, steps.last(), &last, limits);
                steps.push(allowed.unwrap_or(last));
            }
            Refutation::Trace(steps)
        }
        Ending::Starved { from, .. } => Refutation::Lasso(Lasso {
            prefix: steps[..*from].to_vec(),
            cycle: steps[*from..].to_vec(),
        }),
    }
}

/// Returns a step after `state`, or a first one, in which the parts keep their guarantees and some
/// assumption is broken; Moore machines answer as in `last`. `None` if every such step leaves the
/// parts no answer, or if a limit was reached.
fn breaking(
    system: &System,
    state: Option<&Vec<i64>>,
    last: &[i64],
    limits: &Limits,
) -> Option<Vec<i64>> {
    let kind = match state {
        None => RuleKind::Initial,
        Some(_) => RuleKind::Safety,
    };
    let asked = |pick: &dyn Fn(&Part) -> &Side| asked(system, pick, kind);
    let mut kept = asked(&|p| &p.guarantees).and(asked(&|p| &p.definitions));
    for (v, value) in (0..).map(VarId).zip(last) {
        let driver = system.driver(v).map(|part| &system.parts[part]);
        if driver.is_some_and(|p| p.timing == Timing::Moore) && !defined(system, v) {
            kept = kept.and(Expr::Var(v, last_step(kind)).equals(Expr::Const(*value)));
        }
    }
    let assumed = asked(&|p| &p.assumptions);
    let mut rules = vec![rule(kind, &kept), rule(kind, &assumed)];
    if let Some(state) = state {
        let values = (0..).map(VarId).zip(state);
        let here = values.map(|(v, value)| Expr::now(v).equals(Expr::Const(*value)));
        rules.push(rule(
            RuleKind::Initial,
            &here.fold(Expr::Const(1), Expr::and),
        ));
    }
    let keep: Vec<usize> = (0..rules.len()).filter(|i| *i != 1).collect();
    let slip = SafetyViolationQuery {
        before: keep.clone(),
        last: keep,
        broken: 1,
    };
    let mut runs = Runs::new(&system.variables, rules, limits).ok()?;
    let mut run = runs.step(&slip).ok()??;
    let length = 1 + usize::from(state.is_some());
    (run.len() == length).then(|| run.pop())?
}

/// Returns what one side of all parts requires of the first step (`Initial`) or of a later one
/// (`Safety`), invariants included.
fn asked(system: &System, pick: &dyn Fn(&Part) -> &Side, kind: RuleKind) -> Expr {
    let mut all = Expr::Const(1);
    for side in system.parts.iter().map(pick) {
        for f in list(side, kind) {
            all = all.and(f.expr.clone());
        }
        for f in &side.invariants {
            let expr = &f.expr;
            all = all.and(expr.substitute(&mut |v, _| Expr::Var(v, last_step(kind))));
        }
    }
    all
}
