//! Converts a value to the type that its context needs. Reports a value that has another type.

use super::super::ast::Tree;
use super::super::ltl::FormulaId;
use super::super::value::Value;
use super::{Expander, MAX_SET, Result, Scope};
use linewright_core::diagnostics::codes;
use std::collections::BTreeSet;
use std::rc::Rc;

impl<'f> Expander<'f, '_> {
    pub(super) fn large_set<T>(&mut self, tree: &Tree, site: u32) -> Result<T> {
        self.fail(
            codes::TOO_LARGE,
            &tree.range,
            site,
            format!("this set has more than {MAX_SET} elements"),
            "give the parameters smaller values",
        )
    }

    pub(super) fn as_formula(
        &mut self,
        value: &Value,
        tree: &Tree,
        site: u32,
    ) -> Result<FormulaId> {
        match value {
            Value::Formula(f) => Ok(*f),
            Value::Bus(_) => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                "this is a bus, where a truth value is needed",
                "refer to one of its elements, `b[0]`, or compare it with a value of its enumeration",
            ),
            other => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("this is {}, where a truth value is needed", other.word()),
                "compare it with another value",
            ),
        }
    }

    pub(super) fn condition(
        &mut self,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<FormulaId> {
        let value = self.value(tree, scope, site)?;
        self.as_formula(&value, tree, site)
    }

    pub(super) fn numeric(&mut self, tree: &'f Tree, scope: Scope<'_>, site: u32) -> Result<i64> {
        match self.value(tree, scope, site)? {
            Value::Number(n) => Ok(n),
            other => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("this is {}, where a number is needed", other.word()),
                "write a constant, a parameter, a calculation or `SIZEOF` of a bus",
            ),
        }
    }

    pub(super) fn set(
        &mut self,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Rc<BTreeSet<Value>>> {
        match self.value(tree, scope, site)? {
            Value::Set(set) => Ok(set),
            other => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("this is {}, where a set is needed", other.word()),
                "write a set as `{1,2,5}` or `{0,1..n}`",
            ),
        }
    }
}
