//! Plays as timing diagrams.

use super::{Domain, Owner, Specification, VarId, Variable};
use crate::drawing::timing::{Level, Signal, TimingDiagram};

/// Returns steps of a play as a timing diagram, without auxiliary variables. A step has a value for
/// each variable, unless it is not known. `repeats_from` is the index of the step from which on the
/// steps repeat for ever.
pub fn of_steps(
    specification: &Specification,
    steps: &[Vec<Option<i64>>],
    repeats_from: Option<usize>,
) -> TimingDiagram {
    let group = |name: &str, owner: Owner| {
        let variables = specification.variables.iter().enumerate();
        let wanted = variables.filter(|(index, v)| {
            v.owner == owner && !specification.is_auxiliary(VarId(*index as u32))
        });
        let signals = wanted.map(|(index, variable)| Signal {
            name: variable.name.clone(),
            values: steps
                .iter()
                .map(|step| level(variable, step[index]))
                .collect(),
        });
        (name.to_owned(), signals.collect::<Vec<_>>())
    };
    let groups = [
        group("Inputs", Owner::Environment),
        group("Outputs", Owner::System),
    ];
    let groups = groups
        .into_iter()
        .filter(|(_, signals)| !signals.is_empty());
    TimingDiagram {
        groups: groups.collect(),
        first: 0,
        steps: steps.len(),
        repeats_from,
    }
}

fn level(variable: &Variable, value: Option<i64>) -> Level {
    match (value, &variable.domain) {
        (None, _) => Level::Unknown,
        (Some(value), Domain::Bool) => Level::Bit(value != 0),
        (Some(value), _) => Level::Word(variable.show(value)),
    }
}
