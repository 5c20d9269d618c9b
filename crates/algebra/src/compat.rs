//! Compatibility: is there an environment that keeps what parts assume, whatever they do within their guarantees?
//!
//! It is a game with the roles swapped. What comes from outside is the player's; what parts set is the opponent's, who keeps all
//! guarantees. The player has to keep the assumptions for as long as the opponent keeps the guarantees: the strict semantics of GR(1), with
//! the assumptions of the parts as its guarantees. A single contract without guarantees is the plain question whether its assumption can be
//! realized.
//!
//! Who moves first is swapped as well. Machines that see the inputs of the step that they answer leave the environment the first word;
//! where all parts answer first, and no step that they may take depends on the inputs of that step, it sees their answer. What they do again
//! and again may depend on these inputs all the same: such a promise binds no single step.
//!
//! An environment that speaks first can leave the parts no answer. It has won by that, but only if it has kept the
//! assumptions itself, in that step too: some answer, allowed or not, has to keep them. No formula of GR(1) says that there is such an
//! answer, so that the environment names it, in variables of its own ([`witnessed`]).

use super::proof::{Broken, last_step, latest};
use super::system::{KINDS, Part, System, formulas, list, list_mut, rule};
use linewright_core::gr1::{
    Domain, Expr, Formula, Owner, Side, Specification, Timing, VarId, Variable,
};
use linewright_solver::game::{
    self, Ending, Lasso, Limit, Limits, Outcome, RuleKind, Runs, SafetyViolationQuery,
};
use std::collections::{BTreeMap, BTreeSet};

/// Whether there is an environment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Compatibility {
    /// There is one.
    Compatible,
    /// There is none: the parts can keep their guarantees in such a way that an assumption is broken.
    Incompatible {
        /// The names of assumptions that cannot be kept together, although any fewer of them could.
        assumptions: Vec<String>,
        /// A play in which one of them is broken. `None` when a limit was reached before there was one.
        play: Option<Broken>,
    },
}

/// The game of the environment: its variables are the machine's, everything that parts set is an input.
pub fn environments_game(system: &System) -> Specification {
    let variables = system.variables.iter().enumerate().map(|(i, variable)| {
        let driven = system
            .driver(linewright_core::gr1::VarId(i as u32))
            .is_some();
        Variable {
            owner: if driven {
                Owner::Environment
            } else {
                Owner::System
            },
            internal: false,
            ..variable.clone()
        }
    });
    let sees = system.parts.iter().all(|part| {
        let own = |side: &Side| {
            formulas(side).all(|(kind, _, f)| {
                kind == RuleKind::Justice
                    || latest(&f.expr, kind)
                        .iter()
                        .all(|v| system.driver(*v).is_some())
            })
        };
        part.timing == Timing::Moore && own(&part.guarantees) && own(&part.definitions)
    });
    let all = |pick: &dyn Fn(&Part) -> Vec<&Side>| {
        let mut whole = Side::default();
        for side in system.parts.iter().flat_map(pick) {
            whole.initial.extend(side.initial.iter().cloned());
            whole.invariants.extend(side.invariants.iter().cloned());
            whole.safety.extend(side.safety.iter().cloned());
            whole.justice.extend(side.justice.iter().cloned());
        }
        whole
    };
    Specification {
        name: "environment".to_owned(),
        timing: if sees { Timing::Mealy } else { Timing::Moore },
        variables: variables.collect(),
        assumptions: all(&|p| vec![&p.guarantees, &p.definitions]),
        guarantees: all(&|p| vec![&p.assumptions]),
    }
}

/// Whether there is an environment for the parts of a system together.
///
/// # Errors
/// When a limit was reached.
pub fn compatible(system: &System, limits: &Limits) -> Result<Compatibility, Limit> {
    let game = environments_game(system);
    match game.timing {
        // The parts answer first: nothing leaves them without an answer.
        Timing::Mealy => play(&game, system, limits),
        Timing::Moore => play(&witnessed(&game, system), system, limits),
    }
}

fn play(game: &Specification, system: &System, limits: &Limits) -> Result<Compatibility, Limit> {
    let lost = match game::solve(game, limits) {
        Outcome::Realizable(_) => return Ok(Compatibility::Compatible),
        Outcome::Unrealizable(lost) => lost,
        Outcome::GaveUp(limit) => return Err(limit),
    };
    let play = match game::attack(game, &[], limits) {
        Ok(Some(attack)) => Some(shown(&attack.play, game.timing, system, limits)),
        _ => None,
    };
    Ok(Compatibility::Incompatible {
        assumptions: lost.core_names(game),
        play,
    })
}

/// The environment's game (Moore) where it answers for its assumptions although it leaves the parts no answer.
///
/// The parts may break a guarantee here: `over` says that they have, `before` that they had a step earlier. Until `over`, the environment
/// keeps each assumption with the parts' answer; until `before`, with an answer that it names itself. The second matters only where the
/// parts have no answer: an assumption that all allowed answers keep is kept by one of them.
fn witnessed(game: &Specification, system: &System) -> Specification {
    let mut variables = game.variables.clone();
    let mut add = |like: &Variable, owner, domain: &Domain| {
        let id = VarId(variables.len() as u32);
        variables.push(Variable {
            owner,
            internal: true,
            domain: domain.clone(),
            ..like.clone()
        });
        id
    };
    let definitions = || system.parts.iter().map(|p| &p.definitions);
    let answers: BTreeSet<VarId> = std::iter::once(&game.guarantees)
        .chain(definitions())
        .flat_map(formulas)
        .filter(|(kind, ..)| *kind != RuleKind::Justice)
        .flat_map(|(kind, _, f)| latest(&f.expr, kind))
        .filter(|v| system.driver(*v).is_some())
        .collect();
    let mut names = BTreeMap::new();
    for v in answers {
        let answer = &game.variables[v.index()];
        names.insert(v, add(answer, Owner::System, &answer.domain));
    }
    let like = &game.variables[0];
    let over = add(like, Owner::Environment, &Domain::Bool);
    let before = add(like, Owner::Environment, &Domain::Bool);

    let kept = |kind, f: &Formula| {
        let time = last_step(kind);
        let defined = definitions().flat_map(|side| list(side, kind));
        let defined = defined.fold(f.expr.clone(), |all, d| all.and(d.expr.clone()));
        let named = defined.substitute(&mut |v, t| {
            let named = names.get(&v).filter(|_| t == time);
            Expr::Var(named.copied().unwrap_or(v), t)
        });
        let answered = Expr::Var(over, time).or(f.expr.clone());
        answered.and(Expr::Var(before, time).or(named))
    };
    let mut guarantees = game.guarantees.clone();
    for kind in KINDS {
        for f in list_mut(&mut guarantees, kind) {
            f.expr = match kind {
                RuleKind::Justice => f.expr.clone().or(Expr::now(over)),
                _ => kept(kind, f),
            };
        }
    }
    let formula = |expr: Expr| Formula {
        name: String::new(),
        requirement: None,
        expr,
        span: like.span,
        text: String::new(),
        defines: false,
    };
    let promised = |kind| asked(system, &|p| &p.guarantees, kind);
    let mut assumptions = Side::default();
    for side in definitions() {
        for kind in KINDS {
            list_mut(&mut assumptions, kind).extend(list(side, kind).iter().cloned());
        }
    }
    assumptions.initial.extend([
        formula(Expr::now(before).not()),
        formula(Expr::now(over).equals(promised(RuleKind::Initial).not())),
    ]);
    assumptions.safety.extend([
        formula(Expr::next(before).equals(Expr::now(over))),
        formula(Expr::next(over).equals(Expr::now(over).or(promised(RuleKind::Safety).not()))),
    ]);
    let owed = system.parts.iter().flat_map(|p| &p.guarantees.justice);
    assumptions.justice.extend(owed.cloned());
    Specification {
        name: game.name.clone(),
        timing: game.timing,
        variables,
        assumptions,
        guarantees,
    }
}

/// A play as a counterexample: up to the step that breaks an assumption, or round the cycle that starves one.
fn shown(play: &game::Play, timing: Timing, system: &System, limits: &Limits) -> Broken {
    let own = |step: &Vec<i64>| step[..system.variables.len()].to_vec();
    let mut steps: Vec<Vec<i64>> = play.steps.iter().map(own).collect();
    match &play.ending {
        // What comes from outside in the last step is an example: whatever it is, something is broken. Where it comes first, so are
        // the parts' answers, and an allowed one says more.
        Ending::Clash(_) => {
            if timing == Timing::Moore {
                let last = steps.pop();
                let allowed = breaking(system, steps.last(), limits);
                steps.extend(allowed.or(last));
            }
            Broken::Trace(steps)
        }
        Ending::Starved { from, .. } => Broken::Lasso(Lasso {
            prefix: steps[..*from].to_vec(),
            cycle: steps[*from..].to_vec(),
        }),
    }
}

/// A step after `state`, or a first one, in which the parts keep their guarantees and some assumption is broken. `None` where every
/// such step leaves the parts no answer, and where a limit was reached.
fn breaking(system: &System, state: Option<&Vec<i64>>, limits: &Limits) -> Option<Vec<i64>> {
    let kind = match state {
        None => RuleKind::Initial,
        Some(_) => RuleKind::Safety,
    };
    let asked = |pick: &dyn Fn(&Part) -> &Side| asked(system, pick, kind);
    let kept = asked(&|p| &p.guarantees).and(asked(&|p| &p.definitions));
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

/// What one side of all parts asks of the first step (`Initial`) or of a later one (`Safety`), invariants included.
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
