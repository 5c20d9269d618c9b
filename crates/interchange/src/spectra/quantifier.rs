//! Expands `forall i in Int(0..3) . p(i)` and `exists v in {a, b} . x = v` into a conjunction or
//! disjunction over the values.

use super::array::constant;
use super::reader::{Binding, Reader};
use super::syntax::{Name, Node, TypeName};
use super::value::Value;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::BinaryOp;

/// Maximum number of values of a quantifier.
const MAX_VALUES: u64 = 1 << 12;

impl Reader {
    pub fn quantified(
        &mut self,
        all: bool,
        name: &Name,
        domain: &TypeName,
        body: &Node,
    ) -> Option<Value> {
        let values = self.values(domain)?;
        let mut found = Vec::new();
        for value in values {
            found.push(self.with(&name.text, value, |reader| reader.truth(body))?);
        }
        let op = if all { BinaryOp::And } else { BinaryOp::Or };
        Some(Value::chain(op, found))
    }

    /// All values of a type; reports an array type or too many values.
    pub fn values(&mut self, of: &TypeName) -> Option<Vec<Value>> {
        let (domain, sizes) = self.domain(of)?;
        if !sizes.is_empty() || domain.size() > MAX_VALUES {
            self.error(
                codes::DOMAIN_EMPTY,
                of.span,
                "a quantifier cannot range over this type",
                format!("use a type with at most {MAX_VALUES} values that is not an array"),
            );
            return None;
        }
        let values = domain.low()..=domain.high();
        Some(values.map(|v| constant(&domain, v)).collect())
    }

    /// Runs `work` while `name` is bound to `value`.
    pub fn with<T>(&mut self, name: &str, value: Value, work: impl FnOnce(&mut Self) -> T) -> T {
        let depth = self.frames.len();
        if let Some(frame) = self.frames.last_mut() {
            frame.push((name.to_owned(), Binding::Value(value)));
        }
        let found = work(self);
        debug_assert_eq!(depth, self.frames.len());
        if let Some(frame) = self.frames.last_mut() {
            frame.pop();
        }
        found
    }
}
