//! Parses and formats names and values; suggests similar ones.

use super::command::{Part, WORDS};
use super::legal::Values;
use linewright_core::diagnostics::nearest;
use linewright_core::gr1::{Domain, Owner, Specification, VarId, Variable};

/// The variables of a side, without internal ones.
pub(super) fn shown_variables(specification: &Specification, side: Owner) -> Vec<VarId> {
    let all = (0..specification.variables.len() as u32).map(VarId);
    all.filter(|v| {
        let variable = specification.variable(*v);
        variable.owner == side && !variable.internal
    })
    .collect()
}

/// The internal variables that the file declares, such as monitors and counters.
pub(super) fn named_internals(specification: &Specification) -> Vec<VarId> {
    let all = (0..specification.variables.len() as u32).map(VarId);
    all.filter(|v| specification.variable(*v).internal && !specification.is_auxiliary(*v))
        .collect()
}

/// Resolves the names and values of a move of `side`. If `side` is `None`, the variables of both
/// sides are accepted, but only with their names.
pub(super) fn resolve(
    specification: &Specification,
    side: Option<Owner>,
    parts: &[Part],
) -> Result<Values, String> {
    let mut values = Values::new();
    if parts.iter().all(|p| p.name.is_none()) {
        let Some(side) = side else {
            return Err("write `name = value`".to_owned());
        };
        let variables = shown_variables(specification, side);
        if variables.len() != parts.len() {
            let names: Vec<&str> = variables
                .iter()
                .map(|v| specification.variable(*v).name.as_str())
                .collect();
            return Err(match parts {
                [only] => unknown_word(&only.value, &names),
                _ => format!(
                    "{} values are given, but {} are needed: {}",
                    parts.len(),
                    names.len(),
                    names.join(", ")
                ),
            });
        }
        for (variable, part) in variables.into_iter().zip(parts) {
            values.push((
                variable,
                value(specification.variable(variable), &part.value)?,
            ));
        }
        return Ok(values);
    }
    for part in parts {
        let name = part.name.as_deref().unwrap_or_default();
        let variable = variable(specification, side, name)?;
        if values.iter().any(|(v, _)| *v == variable) {
            return Err(format!("`{name}` is given twice"));
        }
        values.push((
            variable,
            value(specification.variable(variable), &part.value)?,
        ));
    }
    Ok(values)
}

/// Error for a single word that is neither a command nor a complete move.
fn unknown_word(word: &str, names: &[&str]) -> String {
    let meant = match nearest(word, WORDS.into_iter()) {
        Some(command) => format!("did you mean `{command}`?"),
        None => "`help` lists the commands".to_owned(),
    };
    format!(
        "`{word}` is not a command, and a move needs values for {}; {meant}",
        names.join(", ")
    )
}

fn variable(
    specification: &Specification,
    side: Option<Owner>,
    name: &str,
) -> Result<VarId, String> {
    let own = |v: &Variable| side.is_none_or(|side| v.owner == side);
    match specification.variables.iter().position(|v| v.name == name) {
        Some(index) if own(&specification.variables[index]) => Ok(VarId(index as u32)),
        Some(index) => {
            let owner = match specification.variables[index].owner {
                Owner::Environment => "the plant",
                Owner::System => "the machine",
            };
            Err(format!("`{name}` is set by {owner}, not by you"))
        }
        None => {
            let all = specification.variables.iter();
            let names: Vec<&str> = all.filter(|v| own(v)).map(|v| v.name.as_str()).collect();
            let instead = match nearest(name, names.iter().copied()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("the variables are {}", names.join(", ")),
            };
            Err(format!("there is no variable `{name}`: {instead}"))
        }
    }
}

fn value(variable: &Variable, text: &str) -> Result<i64, String> {
    let name = &variable.name;
    let domain = variable.describe();
    match &variable.domain {
        Domain::Bool => match text {
            "true" | "1" => Ok(1),
            "false" | "0" => Ok(0),
            _ => Err(format!("`{name}` can be true or false, not `{text}`")),
        },
        Domain::Range { low, high } => {
            let number = text.strip_suffix(&variable.unit).unwrap_or(text).trim();
            match number.parse::<i64>() {
                Ok(value) if (*low..=*high).contains(&value) => Ok(value),
                Ok(_) => Err(format!(
                    "`{name}` has no value {text}: its values are {domain}"
                )),
                Err(_) => Err(format!("`{name}` needs a number in {domain}, not `{text}`")),
            }
        }
        Domain::Enum { labels, .. } => match labels.iter().position(|l| l == text) {
            Some(index) => Ok(index as i64),
            None => Err(match nearest(text, labels.iter().map(String::as_str)) {
                Some(meant) => {
                    format!("`{name}` has no value `{text}`: did you mean `{meant}`?")
                }
                None => format!("`{name}` has no value `{text}`: its values are {domain}"),
            }),
        },
    }
}

/// Formats values: `a = 1, b = true`.
pub(super) fn listed(specification: &Specification, values: &[(VarId, i64)]) -> String {
    let texts: Vec<String> = values
        .iter()
        .map(|(v, value)| {
            let variable = specification.variable(*v);
            format!("{} = {}", variable.name, variable.show(*value))
        })
        .collect();
    texts.join(", ")
}
