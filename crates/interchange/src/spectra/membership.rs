//! `x in {a, b}`, `x in {1, 3-5}`, `x not in {..}`: comparisons with each value.

use super::reader::Reader;
use super::syntax::{Item, Node};
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::BinaryOp;

impl Reader {
    pub fn membership(&mut self, node: &Node, items: &[Item]) -> Option<Value> {
        let value = self.value(node)?;
        let mut found = Vec::new();
        for item in items {
            found.push(match item {
                Item::One(other) => {
                    let other_value = self.value(other)?;
                    self.equal(value.clone(), other_value, other.span)?
                }
                Item::Range(low, high, span) => {
                    self.expect_kind(&value, &Kind::Int, *span)?;
                    if low > high {
                        self.error(
                            codes::DOMAIN_EMPTY,
                            *span,
                            format!("the domain from {low} to {high} is empty"),
                            "write the smaller number first",
                        );
                        return None;
                    }
                    let compare = |op, n| Value::binary(op, value.clone(), Value::int(n));
                    Value::binary(
                        BinaryOp::And,
                        compare(BinaryOp::Ge, *low),
                        compare(BinaryOp::Le, *high),
                    )
                }
            });
        }
        Some(Value::chain(BinaryOp::Or, found))
    }
}
