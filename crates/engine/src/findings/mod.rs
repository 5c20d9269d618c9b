//! Findings about a contract, in words.

pub mod environment;
pub mod lost;
pub mod play;
pub mod shape;

use linewright_core::gr1::Specification;

/// A valuation in words: the values of all variables that some formula mentions.
fn situation(specification: &Specification, values: &[i64]) -> String {
    let shown: Vec<String> = specification
        .variables
        .iter()
        .zip(values)
        .filter(|(v, _)| !v.internal)
        .map(|(v, x)| format!("{} = {}", v.name, v.show(*x)))
        .collect();
    shown.join(", ")
}

/// `a`, `a` and `b`, `a`, `b` and `c`
pub fn list(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
