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

use super::proof::{Broken, latest};
use super::system::{System, formulas};
use linewright_core::gr1::{Owner, Side, Specification, Timing, Variable};
use linewright_solver::game::{self, Ending, Lasso, Limit, Limits, Outcome, RuleKind};

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
    let all = |pick: &dyn Fn(&super::system::Part) -> Vec<&Side>| {
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
    let specification = environments_game(system);
    let lost = match game::solve(&specification, limits) {
        Outcome::Realizable(_) => return Ok(Compatibility::Compatible),
        Outcome::Unrealizable(lost) => lost,
        Outcome::GaveUp(limit) => return Err(limit),
    };
    let play = match game::attack(&specification, &[], limits) {
        Ok(Some(attack)) => Some(shown(&attack.play)),
        _ => None,
    };
    Ok(Compatibility::Incompatible {
        assumptions: lost.core_names(&specification),
        play,
    })
}

/// A play as a counterexample: up to the step that breaks an assumption, or round the cycle that starves one.
fn shown(play: &game::Play) -> Broken {
    match &play.ending {
        // Of the last step only what the parts set means something: whatever comes from outside then, something is broken.
        Ending::Clash(_) => Broken::Trace(play.steps.clone()),
        Ending::Starved { from, .. } => Broken::Lasso(Lasso {
            prefix: play.steps[..*from].to_vec(),
            cycle: play.steps[*from..].to_vec(),
        }),
    }
}
