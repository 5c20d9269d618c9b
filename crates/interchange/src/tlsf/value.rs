//! Values of expanded expressions.

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
    /// A value of an enumeration: the indices of the enumeration and of the value.
    Label(usize, usize),
}

impl Value {
    /// The type in words, for messages.
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

/// An argument or a big operator's variable with its value, linked to the outer bindings.
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
