//! Extracts a machine from a won game.

use super::{Cube, Guard, Machine, Port, Test, Transition, minimise};
use crate::game::{Limit, Limits, Preference, Row, WonGame};
use linewright_core::gr1::{Specification, VarId};

/// Extracts the minimized machine of a won game. It is not verified yet.
pub fn extract(
    specification: &Specification,
    won: &WonGame,
    limits: &Limits,
) -> Result<Machine, Limit> {
    extract_with_preference(Preference::default(), specification, won, limits)
}

/// Extracts the minimized machine of a won game with a preference. It is not verified yet.
///
/// [`Preference::States`] usually leads to fewer states, but not always. So if it is requested, the
/// machines for both preferences are extracted, and the one with fewer states is returned.
pub fn extract_with_preference(
    preference: Preference,
    specification: &Specification,
    won: &WonGame,
    limits: &Limits,
) -> Result<Machine, Limit> {
    let make = |preference| machine(preference, specification, won, limits);
    let quick = make(Preference::Reaction);
    if preference == Preference::Reaction {
        return quick;
    }
    match (make(preference), quick) {
        (Ok(free), Ok(quick)) if free.states.len() < quick.states.len() => Ok(free),
        (Ok(_), Ok(quick)) => Ok(quick),
        (Ok(only), Err(Limit::Size | Limit::Memory))
        | (Err(Limit::Size | Limit::Memory), Ok(only)) => Ok(only),
        (Err(limit), _) | (_, Err(limit)) => Err(limit),
    }
}

/// Extracts the minimized machine of one strategy.
fn machine(
    preference: Preference,
    specification: &Specification,
    won: &WonGame,
    limits: &Limits,
) -> Result<Machine, Limit> {
    let explicit = won.explore(specification, preference, limits)?;
    let rows = |rows: Vec<Row>| -> Vec<Transition> { rows.into_iter().map(transition).collect() };
    let machine = Machine {
        name: specification.name.clone(),
        timing: specification.timing,
        inputs: ports(specification, specification.inputs()),
        outputs: ports(specification, specification.outputs()),
        initial: rows(explicit.initial),
        states: explicit.states.into_iter().map(rows).collect(),
        goals: explicit.goals.into_iter().map(|goal| vec![goal]).collect(),
    };
    minimise::minimise(&machine, limits)
}

/// Returns variables as ports.
pub(super) fn ports(specification: &Specification, ids: impl Iterator<Item = VarId>) -> Vec<Port> {
    let port = |id: VarId| {
        let variable = specification.variable(id);
        Port {
            name: variable.name.clone(),
            domain: variable.domain.clone(),
            unit: variable.unit.clone(),
            internal: variable.internal,
        }
    };
    ids.map(port).collect()
}

/// Converts a row of an explicit strategy to a transition.
pub(super) fn transition(row: Row) -> Transition {
    let cube = |conditions: Vec<(usize, i64, i64)>| {
        let tests = conditions.into_iter();
        Cube(
            tests
                .map(|(input, low, high)| Test { input, low, high })
                .collect(),
        )
    };
    Transition {
        guard: Guard(row.cubes.into_iter().map(cube).collect()),
        output: row.output,
        to: row.to,
    }
}
