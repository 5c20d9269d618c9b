//! Findings about a contract.

pub mod environment;
pub mod lost;
pub mod play;
pub mod shape;

use linewright_core::gr1::Specification;
use linewright_solver::game::PartialValuation;

/// Formats the known values of a situation: `a = 1, b = true`; `None` if there are none.
fn shown(specification: &Specification, situation: &PartialValuation) -> Option<String> {
    let values: Vec<String> = specification
        .variables
        .iter()
        .zip(situation)
        .filter(|(v, _)| !v.internal)
        .filter_map(|(v, x)| x.map(|x| format!("{} = {}", v.name, v.show(x))))
        .collect();
    (!values.is_empty()).then(|| values.join(", "))
}

/// Joins names in words: `a`; `a and b`; `a, b and c`. Empty if there are no names.
pub fn list(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
