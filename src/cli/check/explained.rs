//! Converts explanations of a contract's verdict to entries of the document.

use super::document::{CounterstrategyEntry, PlayEntry, WellSeparation};
use crate::game::{Ending, EnvironmentFindings, GuaranteeRef, Play};
use crate::gr1::{Domain, Owner, Specification, Timing};
use crate::mealy::Machine;
use serde_json::Value;

/// The values of all variables in each step of a play, as far as they matter: in a step in which
/// the machine has no answer, only the inputs have values.
pub(super) fn steps(s: &Specification, play: &Play) -> Vec<Vec<Option<i64>>> {
    let last = play.steps.len() - 1;
    let clashes = matches!(play.ending, Ending::Clash(_));
    let steps = play.steps.iter().enumerate().map(|(at, step)| {
        let answered = !clashes || at < last || s.timing == Timing::Moore;
        let values = s.variables.iter().zip(step);
        let known =
            values.map(|(v, value)| (answered || v.owner == Owner::Environment).then_some(*value));
        known.collect()
    });
    steps.collect()
}

/// Converts a play; values are keyed by variable name.
pub(super) fn play(s: &Specification, play: &Play) -> PlayEntry {
    let name = |g: &GuaranteeRef| g.formula(&s.guarantees).name.clone();
    let steps = steps(s, play).into_iter().map(|step| {
        let known = s.variables.iter().zip(step);
        known
            .filter_map(|(v, value)| Some((v.name.clone(), shown(&v.domain, value?))))
            .collect()
    });
    let mut entry = PlayEntry {
        steps: steps.collect(),
        clash: Vec::new(),
        repeats_from: None,
        never: None,
    };
    match &play.ending {
        Ending::Clash(rules) => {
            for rule in rules.iter().map(name) {
                if !entry.clash.contains(&rule) {
                    entry.clash.push(rule);
                }
            }
        }
        Ending::Starved { from, goal } => {
            entry.repeats_from = Some(*from);
            entry.never = Some(name(goal));
        }
    }
    entry
}

/// Converts a value to JSON.
fn shown(domain: &Domain, value: i64) -> Value {
    match domain {
        Domain::Bool => Value::Bool(value != 0),
        Domain::Range { .. } => Value::from(value),
        Domain::Enum { .. } => Value::String(domain.show(value)),
    }
}

/// Entry for a counterstrategy. It is always verified, because only verified ones are kept.
pub(super) fn counterstrategy(machine: &Machine) -> CounterstrategyEntry {
    CounterstrategyEntry {
        states: machine.states.len(),
        verified: true,
    }
}

/// Converts the results of both checks.
pub(super) fn well_separation(found: &EnvironmentFindings) -> WellSeparation {
    // Counts above 2^53 are rounded.
    let whole = |counts: [f64; 2]| counts.map(|n| n as u64);
    WellSeparation {
        forced: whole(found.forced_states),
        forced_ignoring_guarantees: whole(found.forced_recklessly_states),
    }
}
