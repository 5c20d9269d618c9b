//! Compatibility of components: whether some environment keeps the components' assumptions,
//! whatever the components do within their guarantees.
//!
//! This is a game with swapped roles. The player (the environment) sets the outside variables; the
//! opponent sets the components' outputs and keeps all guarantees. The player has to keep the
//! assumptions for as long as the opponent keeps the guarantees. This is the strict semantics of
//! GR(1), with the components' assumptions as the guarantees of the player. For a single contract
//! without guarantees, the question is simply whether its assumption is realizable.
//!
//! The order of moves is also swapped: Moore machines answer before the environment, which sees
//! their answer. Mealy machines answer after the environment.
//!
//! Either side can leave the other without an allowed move. An environment that does so has won,
//! but only if it keeps the assumptions in that step as well. GR(1) cannot express that some answer
//! keeps a formula. Therefore, the side that needs such an answer names one, in additional
//! variables (*named answer*).

mod between;

use super::proof::{Refutation, last_step, latest};
use super::system::{Component, System, rule};
use linewright_core::gr1::{
    Domain, Expr, Formula, FormulaKind, Owner, Side, Specification, Timing, VarId, Variable,
};
use linewright_core::source::Span;
use linewright_solver::game::{
    self, Ending, Lasso, Limit, Limits, Outcome, PlayEnd, Runs, SafetyViolationQuery,
};
use std::collections::{BTreeMap, BTreeSet};

/// Result of the compatibility check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Compatibility {
    /// Some environment keeps the assumptions.
    Compatible,
    /// No environment keeps the assumptions: the components can keep their guarantees in such a way
    /// that an assumption is broken.
    Incompatible {
        /// A minimal set of assumptions that cannot be kept together.
        assumptions: Vec<Assumption>,
        /// Play in which one of these assumptions is broken; `None` if a limit was reached before a
        /// play was found.
        play: Option<Refutation>,
    },
}

/// An assumption of a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumption {
    /// Index of the component in the system.
    pub component: usize,
    /// Name of the formula.
    pub name: String,
    /// Position of the formula in its file.
    pub span: Span,
}

/// Decides whether all components of a system together are compatible.
///
/// # Errors
/// When a limit was reached.
pub fn compatible(system: &System, limits: &Limits) -> Result<Compatibility, Limit> {
    let is_moore = |component: &Component| component.timing == Timing::Moore;
    let order = if system.components.iter().all(is_moore) {
        Turn::Last
    } else if system.components.iter().any(is_moore) {
        Turn::Between
    } else {
        Turn::First
    };
    let late = |v: &VarId| {
        let driver = system.driver(*v);
        driver.is_some_and(|component| !is_moore(&system.components[component]))
            || is_monitor(system, *v)
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
    let play = match game::attack_until(PlayEnd::NoMove, &game, &[], limits) {
        Ok(Some(attack)) => Some(counterexample(&attack.play, order, system, &late, limits)),
        _ => None,
    };
    Ok(Compatibility::Incompatible {
        assumptions: assumptions_of(system, &lost.core_formulas(&game)),
        play,
    })
}

/// Returns the components' assumptions that these formulas of the game stand for. The game rewrites
/// an assumption, but keeps its name and its position.
fn assumptions_of(system: &System, core: &[&Formula]) -> Vec<Assumption> {
    let mut found: Vec<Assumption> = Vec::new();
    for formula in core {
        let components = (0..).zip(&system.components);
        let mut candidates = components.flat_map(|(component, p)| {
            let assumed = p.assumptions.formulas();
            let same = assumed.filter(|(_, _, f)| f.name == formula.name && f.span == formula.span);
            same.map(move |(_, _, f)| Assumption {
                component,
                name: f.name.clone(),
                span: f.span,
            })
        });
        // Two components may be instances of one contract.
        found.extend(candidates.find(|candidate| !found.contains(candidate)));
    }
    found
}

/// Position of the environment's move in a step: before the components, after those that are Moore
/// machines, or after all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    First,
    Between,
    Last,
}

/// Returns whether a variable is a monitor.
fn is_monitor(system: &System, v: VarId) -> bool {
    let place = system.variables[v.index()].span;
    let sides = system.components.iter().map(|p| &p.definitions);
    sides
        .flat_map(Side::formulas)
        .any(|(_, _, f)| f.span.contains(place))
}

/// A game under construction, in which the environment takes the place of the machine: the outside
/// variables are its outputs, and the variables that components set are its inputs.
struct Game<'s> {
    system: &'s System,
    specification: Specification,
}

impl<'s> Game<'s> {
    /// Creates the game with the components' assumptions as guarantees and their justice guarantees
    /// as assumptions. The player sets the variables for which `outside` is true.
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
        for component in &system.components {
            guarantees.append(&component.assumptions);
            let guaranteed = component.guarantees.justice.iter().cloned();
            assumptions.justice.extend(guaranteed);
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

    /// Creates two variables: `violated` is true once a guarantee has been broken,
    /// `violated_before` one step later. Also returns the rules that define the variables.
    fn add_violation_tracking(&mut self, owner: Owner) -> (VarId, VarId, Side) {
        let violated = self.add(owner, Domain::Bool);
        let violated_before = self.add(owner, Domain::Bool);
        let guaranteed = |kind| requirement(self.system, &|p| &p.guarantees, kind);
        let (first, later) = (
            guaranteed(FormulaKind::Initial),
            guaranteed(FormulaKind::Safety),
        );
        let rules = Side {
            initial: vec![
                auxiliary(Expr::now(violated_before).not()),
                auxiliary(Expr::now(violated).equals(first.not())),
            ],
            safety: vec![
                auxiliary(Expr::next(violated_before).equals(Expr::now(violated))),
                auxiliary(Expr::next(violated).equals(Expr::now(violated).or(later.not()))),
            ],
            ..Side::default()
        };
        (violated, violated_before, rules)
    }

    /// Replaces the expression of each assumption that the environment has to keep.
    fn rewrite(&mut self, put: impl Fn(FormulaKind, &Formula) -> Expr) {
        for kind in FormulaKind::ALL {
            for f in self.specification.guarantees.list_mut(kind) {
                f.expr = put(kind, f);
            }
        }
    }
}

/// Builds the game in which the environment moves first: all components are Mealy machines.
///
/// The environment has to keep the assumptions even if it leaves the components no allowed answer.
/// In this game the components can break a guarantee: `violated` is true once they have,
/// `violated_before` one step later. Until `violated` is true, the environment has to keep each
/// assumption with the components' answer; until `violated_before` is true, also with an answer
/// that the environment names itself. The named answer matters only if the components have no
/// allowed answer. If they have one, the environment can name it, because it has to keep the
/// assumption with every allowed answer.
fn environment_first(system: &System) -> Specification {
    let driven = |v: &VarId| system.driver(*v).is_some();
    let mut game = Game::new(system, Timing::Moore, |v| !driven(v));
    let definitions = || system.components.iter().map(|p| &p.definitions);
    let assumed = system.components.iter().map(|p| &p.assumptions);
    let answers = assumed.chain(definitions()).flat_map(of_last_step);
    let named = game.copies(answers.filter(driven).collect(), Owner::System);
    let (violated, violated_before, rules) = game.add_violation_tracking(Owner::Environment);
    game.rewrite(|kind, f| {
        if kind == FormulaKind::Justice {
            return f.expr.clone().or(Expr::now(violated));
        }
        let time = last_step(kind);
        let defined = definitions().flat_map(|side| side.list(kind));
        let defined = defined.fold(f.expr.clone(), |all, d| all.and(d.expr.clone()));
        let answered = Expr::Var(violated, time).or(f.expr.clone());
        answered.and(Expr::Var(violated_before, time).or(with_copies(&defined, kind, &named)))
    });
    for side in definitions().chain([&rules]) {
        game.specification.assumptions.append(side);
    }
    game.specification
}

/// Builds the game in which the environment moves last: all components are Moore machines. The
/// values of monitors in a step are known after the environment's move.
///
/// An answer is allowed if it keeps the guarantees with some outside values; the components name
/// these values. With other values, the environment can make the components break a guarantee
/// (`violated`), as long as it keeps the assumptions in that step as well.
fn environment_last(system: &System) -> Specification {
    let definitions: Vec<&Side> = system.components.iter().map(|p| &p.definitions).collect();
    let defined = |v: &VarId| is_monitor(system, *v);
    let late = |v: &VarId| system.driver(*v).is_none() || defined(v);
    let mut game = Game::new(system, Timing::Mealy, late);
    let guaranteed = system.components.iter().map(|p| &p.guarantees);
    let mut read: BTreeSet<VarId> = guaranteed.flat_map(of_last_step).filter(late).collect();
    let monitored = read.iter().any(defined);
    if monitored {
        let also = definitions.iter().copied().flat_map(of_last_step);
        read.extend(also.filter(late));
    }
    let is_blind = read.is_empty();
    let named = game.copies(read, Owner::Environment);
    for component in &system.components {
        for kind in [
            FormulaKind::Initial,
            FormulaKind::Invariant,
            FormulaKind::Safety,
        ] {
            let also = component
                .definitions
                .list(kind)
                .iter()
                .filter(|_| monitored);
            for f in component.guarantees.list(kind).iter().chain(also) {
                game.specification.assumptions.list_mut(kind).push(Formula {
                    expr: with_copies(&f.expr, kind, &named),
                    ..f.clone()
                });
            }
        }
    }
    if !is_blind {
        let (violated, violated_before, rules) = game.add_violation_tracking(Owner::System);
        game.rewrite(|kind, f| match kind {
            FormulaKind::Justice => f.expr.clone().or(Expr::now(violated)),
            _ => Expr::Var(violated_before, last_step(kind)).or(f.expr.clone()),
        });
        game.specification.guarantees.append(&rules);
    }
    for kind in FormulaKind::ALL {
        let defining = definitions.iter().flat_map(|side| side.list(kind));
        let defining = defining.map(|f| auxiliary(f.expr.clone()));
        game.specification
            .guarantees
            .list_mut(kind)
            .extend(defining);
    }
    game.specification
}

/// Returns the variables that a side's formulas read in the last step that they constrain, without
/// justice.
fn of_last_step(side: &Side) -> BTreeSet<VarId> {
    side.formulas()
        .filter(|(kind, ..)| *kind != FormulaKind::Justice)
        .flat_map(|(kind, _, f)| latest(&f.expr, kind))
        .collect()
}

/// Replaces variables by their copies in the last step that a formula constrains.
fn with_copies(expr: &Expr, kind: FormulaKind, copies: &BTreeMap<VarId, VarId>) -> Expr {
    expr.substitute(&mut |v, time| {
        let copy = copies.get(&v).filter(|_| time == last_step(kind));
        Expr::Var(copy.copied().unwrap_or(v), time)
    })
}

/// Creates a formula of the game that is not a formula of a contract.
fn auxiliary(expr: Expr) -> Formula {
    Formula {
        name: String::new(),
        requirement: None,
        expr,
        span: Span::default(),
        text: String::new(),
        defines: true,
    }
}

/// Converts a play to a counterexample: a trace to the step that breaks an assumption, or a lasso
/// on which an assumed justice never recurs.
fn counterexample(
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
        steps = between::undo_delay(&steps, next.as_ref(), late);
    }
    match &play.ending {
        // The outside values of the last step are only an example: some formula is broken with any
        // values. The answers to these values are also an example; an allowed answer is more
        // helpful.
        Ending::Clash(_) => {
            if order != Turn::Last
                && let Some(last) = steps.pop()
            {
                let allowed = violating_step(system, steps.last(), &last, limits);
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

/// Returns a step after `state`, or a step 0, in which the components keep their guarantees and an
/// assumption is broken, and in which Moore machines answer as in `last`. Returns `None` if there
/// is no such step, or if a limit was reached.
fn violating_step(
    system: &System,
    state: Option<&Vec<i64>>,
    last: &[i64],
    limits: &Limits,
) -> Option<Vec<i64>> {
    let kind = match state {
        None => FormulaKind::Initial,
        Some(_) => FormulaKind::Safety,
    };
    let required = |pick: &dyn Fn(&Component) -> &Side| requirement(system, pick, kind);
    let mut kept = required(&|p| &p.guarantees).and(required(&|p| &p.definitions));
    for (v, value) in (0..).map(VarId).zip(last) {
        let driver = system
            .driver(v)
            .map(|component| &system.components[component]);
        if driver.is_some_and(|p| p.timing == Timing::Moore) && !is_monitor(system, v) {
            kept = kept.and(Expr::Var(v, last_step(kind)).equals(Expr::Const(*value)));
        }
    }
    let assumed = required(&|p| &p.assumptions);
    let mut rules = vec![rule(kind, &kept), rule(kind, &assumed)];
    if let Some(state) = state {
        let values = (0..).map(VarId).zip(state);
        let here = values.map(|(v, value)| Expr::now(v).equals(Expr::Const(*value)));
        rules.push(rule(
            FormulaKind::Initial,
            &here.fold(Expr::Const(1), Expr::and),
        ));
    }
    let keep: Vec<usize> = (0..rules.len()).filter(|i| *i != 1).collect();
    let query = SafetyViolationQuery {
        before: keep.clone(),
        last: keep,
        broken: 1,
    };
    let mut runs = Runs::new(&system.variables, rules, limits).ok()?;
    let mut run = runs.find_violation(&query).ok()??;
    let length = 1 + usize::from(state.is_some());
    (run.len() == length).then(|| run.pop())?
}

/// Returns the conjunction of what one side of all components requires of step 0 (`Initial`) or of
/// a later step (`Safety`), including invariants.
fn requirement(system: &System, pick: &dyn Fn(&Component) -> &Side, kind: FormulaKind) -> Expr {
    let mut all = Expr::Const(1);
    for side in system.components.iter().map(pick) {
        for f in side.list(kind) {
            all = all.and(f.expr.clone());
        }
        for f in &side.invariants {
            let expr = &f.expr;
            all = all.and(expr.substitute(&mut |v, _| Expr::Var(v, last_step(kind))));
        }
    }
    all
}
