//! Declares definitions, enumerations and signals.

use super::ast::{File, Section, Shape};
use super::expand::{Expander, Globals};
use super::found::Conjunct;
use super::ltl::{Op, Place};
use super::report::Report;
use super::value::Value;
use crate::names::quoted;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Domain, Owner, VarId, Variable};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Maximum number of declared signals; a bus counts as its elements.
const MAX_SIGNALS: usize = 4096;

/// Collects definitions, enumerations and labels by name; reports duplicates.
pub(super) fn globals<'f>(file: &'f File, report: &mut Report) -> Globals<'f> {
    let mut globals = Globals {
        definitions: BTreeMap::new(),
        enumerations: &file.enumerations,
        labels: BTreeMap::new(),
        signals: BTreeMap::new(),
    };
    let twice = |report: &mut Report, name: &str, place: &std::ops::Range<usize>| {
        report.error(
            codes::NAME_DUPLICATE,
            place.clone(),
            format!("`{}` is declared twice", quoted(name)),
            "give one of the two another name, or another number of arguments",
        );
    };
    for definition in &file.definitions {
        let key = (definition.name.as_str(), definition.arguments.len());
        if globals.definitions.insert(key, definition).is_some() {
            twice(report, &definition.name, &definition.place);
        }
    }
    for (e, enumeration) in file.enumerations.iter().enumerate() {
        let mut others: Vec<(&str, &Vec<Option<bool>>)> = Vec::new();
        for (l, label) in enumeration.labels.iter().enumerate() {
            if globals.labels.insert(&label.name, (e, l)).is_some() {
                twice(report, &label.name, &label.place);
            }
            for code in &label.codes {
                let clash = others.iter().find(|(_, other)| {
                    code.iter()
                        .zip(*other)
                        .all(|(a, b)| a.is_none() || b.is_none() || a == b)
                });
                if let Some((other, _)) = clash {
                    report.error(
                        codes::TYPE_MISMATCH,
                        label.place.clone(),
                        format!(
                            "`{}` and `{}` have overlapping codes",
                            quoted(&label.name),
                            quoted(other)
                        ),
                        "give each value distinct codes",
                    );
                }
                others.push((&label.name, code));
            }
        }
    }
    globals
}

/// Declares the signals, with one variable for each element of a bus.
pub(super) fn signals<'f>(
    file: &'f File,
    expander: &mut Expander<'f, '_>,
) -> Option<Vec<Variable>> {
    let mut variables: Vec<Variable> = Vec::new();
    for signal in &file.signals {
        let width = match &signal.shape {
            Shape::Single => None,
            Shape::Bus(size) => {
                let Ok(number) = expander.number(size) else {
                    continue;
                };
                if number < 0 || number > MAX_SIGNALS as i64 {
                    expander.report.error(
                        codes::DOMAIN_EMPTY,
                        size.range.clone(),
                        format!("a bus cannot have {number} signals"),
                        format!("use a size from 0 to {MAX_SIGNALS}"),
                    );
                    continue;
                }
                Some(number as usize)
            }
            Shape::Typed(kind, place) => {
                let known = file.enumerations.iter().find(|e| e.name == *kind);
                let Some(enumeration) = known else {
                    expander.report.error(
                        codes::NAME_UNKNOWN,
                        place.clone(),
                        format!("the enumeration `{}` is not declared", quoted(kind)),
                        "define it under DEFINITIONS: `enum name = A: 0  B: 1`, or end the signal before it with `;`",
                    );
                    continue;
                };
                Some(enumeration.width)
            }
        };
        let first = variables.len();
        let span = expander.report.span(&signal.place);
        let mut declare = |name: String| {
            variables.push(Variable {
                name,
                owner: if signal.input {
                    Owner::Environment
                } else {
                    Owner::System
                },
                internal: false,
                domain: Domain::Bool,
                unit: String::new(),
                span,
            });
            VarId(variables.len() as u32 - 1)
        };
        let value = match width {
            None => {
                let id = declare(signal.name.clone());
                let place = Place::new(&signal.place, 0);
                Value::Formula(expander.formulas.make(Op::Atom(id), place))
            }
            Some(width) => {
                let bits = (0..width).map(|k| declare(format!("{}[{k}]", signal.name)));
                Value::Bus(Rc::new(bits.collect()))
            }
        };
        let globals = &mut expander.globals;
        let name = signal.name.as_str();
        let double = globals.signals.insert(name, value).is_some()
            || globals.definitions.contains_key(&(name, 0))
            || globals.labels.contains_key(name);
        if double {
            expander.report.error(
                codes::NAME_DUPLICATE,
                signal.place.clone(),
                format!("`{}` is declared twice", quoted(name)),
                "give one of the two another name",
            );
        }
        if variables.len() > MAX_SIGNALS {
            expander.report.error(
                codes::TOO_LARGE,
                signal.place.clone(),
                format!("the file has more than {MAX_SIGNALS} signals"),
                "give the parameters smaller values",
            );
            variables.truncate(first);
            return None;
        }
    }
    if variables.is_empty() {
        expander.report.syntax(
            0..0,
            "no signal is declared",
            "declare at least one in INPUTS or OUTPUTS",
        );
        return None;
    }
    Some(variables)
}

/// Formulas that restrict each bus of an enumeration type to valid codes. They belong to REQUIRE
/// for inputs and to ASSERT for outputs.
pub(super) fn enumeration_formulas<'f>(
    file: &'f File,
    expander: &mut Expander<'f, '_>,
) -> Vec<Conjunct> {
    let mut found = Vec::new();
    for signal in &file.signals {
        let Shape::Typed(kind, _) = &signal.shape else {
            continue;
        };
        let known = file.enumerations.iter().find(|e| e.name == *kind);
        let bus = expander.globals.signals.get(signal.name.as_str()).cloned();
        let (Some(enumeration), Some(Value::Bus(bits))) = (known, bus) else {
            continue;
        };
        let codes: Vec<Vec<Option<bool>>> = enumeration
            .labels
            .iter()
            .flat_map(|l| l.codes.clone())
            .collect();
        // Codes do not overlap, so they cover all bit patterns if and only if their counts add up.
        let free = |code: &Vec<Option<bool>>| code.iter().filter(|b| b.is_none()).count();
        let power = |bits: usize| 1_u128.checked_shl(u32::try_from(bits).unwrap_or(u32::MAX));
        let covered = codes
            .iter()
            .map(|c| power(free(c)).unwrap_or(u128::MAX))
            .fold(0, u128::saturating_add);
        if power(enumeration.width) == Some(covered) {
            continue;
        }
        let formula = expander.has_code(&bits, &codes, Place::new(&signal.place, 0));
        found.push(Conjunct {
            section: if signal.input {
                Section::Require
            } else {
                Section::Assert
            },
            name: format!("{} is a value of {}", signal.name, enumeration.name),
            heading: signal.place.clone(),
            formula,
        });
    }
    found
}
