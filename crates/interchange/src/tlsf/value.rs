//! What an expression comes to when it is expanded.

use super::ltl::FormulaId;
use linewright_core::gr1::VarId;
use std::collections::BTreeSet;
use std::rc::Rc;

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Value {
    Number(i64),
    Formula(FormulaId),
    Set(Rc<BTreeSet<Value>>),
    Bus(Rc<Vec<VarId>>),
    /// A value of an enumeration: which one of which.
    Label(usize, usize),
}

impl Value {
    /// What it is called.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Number(_) => "a number",
            Self::Formula(_) => "a formula",
            Self::Set(_) => "a set",
            Self::Bus(_) => "a bus",
            Self::Label(..) => "a value of an enumeration",
        }
    }
}

/// Names of arguments and of what big operators run over, innermost first.
pub(super) struct ScopeBinding<'a> {
    pub name: &'a str,
    pub value: Value,
    pub outer: Option<&'a ScopeBinding<'a>>,
}

impl ScopeBinding<'_> {
    pub fn find(scope: Option<&Self>, name: &str) -> Option<Value> {
        let mut at = scope;
        while let Some(bound) = at {
            if bound.name == name {
                return Some(bound.value.clone());
            }
            at = bound.outer;
        }
        None
    }
}
