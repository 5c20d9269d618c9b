//! The definitions of a contract, such as `define requested = command = turn`, for those who read
//! its rules.
//!
//! Formulas contain no definitions, because elaboration puts in their values. Here each has its
//! text and, if it is a single value over the variables of the contract, its value.

use super::formula::one_line;
use super::instantiate::{Arguments, bind, declare};
use super::scope::Scope;
use super::uses::Mentions;
use super::value::Type;
use linewright_core::gr1::monitors::Monitors;
use linewright_core::gr1::{Expr, Time, VarId, Variable};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, ContractItem};
use std::collections::BTreeMap;

/// A definition that rules of a contract use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// Name with its parameters, such as `requested` or `free(i)`.
    pub name: String,
    /// What the name stands for, in one line.
    pub text: String,
    /// Place of the name.
    pub span: Span,
    /// The value over the variables of the contract; `None` if it depends on parameters or on
    /// earlier steps, or is not a single value.
    pub value: Option<DefinedValue>,
}

/// The value of a definition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DefinedValue {
    /// The value.
    pub expr: Expr,
    /// Names of the values from 0 on; empty for numbers.
    pub labels: Vec<String>,
    /// Unit of the number; empty if there is none.
    pub unit: String,
}

/// Returns the definitions that the rules of a contract mention, also within others, in the order
/// of their names. The contract has its default parameters.
pub(super) fn definitions(
    scope: &Scope<'_>,
    sources: &SourceMap,
    contract: &ast::Contract,
) -> Vec<Definition> {
    // The findings of this elaboration are those of the contract's own.
    let mut e = scope.elaborator();
    e.dialect.next = true;
    if bind(&mut e, &contract.header.parameters, &Arguments::new(), None).is_none() {
        return Vec::new();
    }
    let mut variables: Vec<Variable> = Vec::new();
    declare(&mut e, contract, &mut variables, &mut BTreeMap::new());
    let own = variables.len() as u32;
    e.memory.monitors = Some(Monitors::new(VarId(own), std::iter::empty()));
    let mut mentioned = Mentions::default();
    for item in &contract.items {
        if let ContractItem::Formula { expr, .. } = item {
            mentioned.expr(expr);
        }
    }
    let known: Vec<&ast::Define> = e.names.defines.values().copied().collect();
    let mut used: Vec<&ast::Define> = Vec::new();
    // Each round adds those that the ones before it mention.
    loop {
        let is_new = |define: &&&ast::Define| {
            mentioned.has(&define.name.text) && !used.iter().any(|u| std::ptr::eq(*u, **define))
        };
        let new: Vec<&ast::Define> = known.iter().filter(is_new).copied().collect();
        if new.is_empty() {
            break;
        }
        mentioned.exprs(new.iter().map(|define| &define.value));
        used.extend(new);
    }
    used.sort_by(|a, b| a.name.text.cmp(&b.name.text));
    let defined = used.into_iter().map(|define| {
        let formals = define.formals.iter();
        let formals: Vec<&str> = formals.map(|f| f.name.text.as_str()).collect();
        let name = &define.name.text;
        let scalar = formals.is_empty().then_some(&define.value);
        let scalar = scalar.and_then(|value| e.any_scalar(value, None, Time::Now));
        Definition {
            name: match formals.as_slice() {
                [] => name.clone(),
                formals => format!("{name}({})", formals.join(", ")),
            },
            text: one_line(sources.text(define.value.span)),
            span: define.name.span,
            value: scalar.and_then(|(term, ty)| {
                let expr = e.formula(&term, define.value.span)?;
                let mut is_own = true;
                expr.for_each_var(&mut |variable, _| is_own &= variable.0 < own);
                let (labels, unit) = shown(ty)?;
                is_own.then_some(DefinedValue { expr, labels, unit })
            }),
        }
    });
    defined.collect()
}

/// How values of a type are shown: the names of the values, and the unit; `None` for quantities of
/// the plant.
fn shown(ty: Type) -> Option<(Vec<String>, String)> {
    match ty {
        Type::Bool => Some((["false", "true"].map(str::to_owned).to_vec(), String::new())),
        Type::Int => Some((Vec::new(), String::new())),
        Type::Measured(unit) => Some((Vec::new(), unit.name().to_owned())),
        Type::Enum(labels) => Some((labels, String::new())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use crate::contract::load;

    #[test]
    fn used_definitions_have_their_texts_and_values() {
        let text = "define anywhere = 3
define elsewhere = 4
contract Turn {
    input command: {none, turn}
    input seen: array[2] of bool
    output angle: 0..4
    define requested = command =
        turn // and nothing else
    define at(i) = seen[i]
    define far = angle + 1
    define looked = once seen[0]
    assume held: always (requested and at(0) -> next requested)
    assume back: always (looked -> seen[1])
    guarantee reached: always eventually (far = anywhere or not requested)
}
";
        let none = |path: &str, _: &str| Err(format!("{path} is not needed"));
        let (library, findings) = load(&[("a.lw".to_owned(), text.to_owned())], &none);
        assert!(findings.iter().all(|f| f.span.is_some()), "{findings:?}");
        let [contract] = library.contracts.as_slice() else {
            panic!("{findings:?}");
        };
        let definitions = library.definitions_of(contract).iter();
        let shown = definitions.map(|d| (d.name.as_str(), d.text.as_str(), d.value.is_some()));
        let wanted = [
            ("anywhere", "3", true),
            ("at(i)", "seen[i]", false),
            ("far", "angle + 1", true),
            ("looked", "once seen[0]", false),
            ("requested", "command = turn", true),
        ];
        assert_eq!(shown.collect::<Vec<_>>(), wanted);
    }
}
