//! Counters: `counter c(0..9) { c = 0; inc: p; dec: q; reset: r; overflow: keep; underflow: modulo;
//! }`.
//!
//! The counter is an internal variable of the machine. From each step to the next:
//!
//! | | |
//! |---|---|
//! | `inc` | up by one; at the upper end `keep` stays there, `modulo` goes to the lower end, `false` forbids `inc` |
//! | `dec` | down by one, likewise with `underflow` |
//! | `reset` | to the lower end |
//! | none of them | as it was |
//!
//! Where nothing is said of an end, it is `false`. Each is a demand of its own, as in Spectra: two
//! of them in one step that ask for different values cannot be kept, so the machine has to prevent
//! that.

use super::reader::Reader;
use super::scope::Cells;
use super::syntax::{Counter, Node, Overflow, TemporalForm};
use super::value::{Kind, Value};
use linewright_core::gr1::{BinaryOp, Expr, Owner};

impl Reader {
    pub fn counter(&mut self, counter: &Counter, cells: &Cells) {
        let (low, high) = (cells.domain.low(), cells.domain.high());
        for node in &counter.initial {
            if let Some(value) = self.truth(node) {
                self.add(Owner::System, TemporalForm::Initially, value);
            }
        }
        let sections = [
            (&counter.up, 1, high, low, counter.overflow),
            (&counter.down, -1, low, high, counter.underflow),
        ];
        let now = Value::leaf(Expr::now(cells.first), Kind::Int);
        let next = Value::leaf(Expr::next(cells.first), Kind::Int);
        let is = |v: &Value, n: i64| Value::binary(BinaryOp::Eq, v.clone(), Value::int(n));
        let mut idle = Vec::new();
        for (nodes, by, end, other, method) in sections {
            let Some(asked) = self.any(nodes) else {
                continue;
            };
            idle.push(asked.clone().not());
            let moved = Value::binary(BinaryOp::Add, now.clone(), Value::int(by));
            let moved = Value::binary(BinaryOp::Eq, next.clone(), moved);
            let method = method.map_or(Overflow::Refuse, |(m, _)| m);
            let target = match method {
                Overflow::Refuse => None,
                Overflow::Keep => Some(end),
                Overflow::Modulo => Some(other),
            };
            let allowed = match target {
                None => moved,
                Some(target) => {
                    let at_end = is(&now, end);
                    let turned = Value::binary(BinaryOp::And, at_end, is(&next, target));
                    Value::binary(BinaryOp::Or, moved, turned)
                }
            };
            let step = Value::binary(BinaryOp::Implies, asked, allowed);
            self.add(Owner::System, TemporalForm::Transition, step);
        }
        if let Some(asked) = self.any(&counter.reset) {
            idle.push(asked.clone().not());
            let step = Value::binary(BinaryOp::Implies, asked, is(&next, low));
            self.add(Owner::System, TemporalForm::Transition, step);
        }
        let still = Value::binary(BinaryOp::Eq, next, now);
        let idle = Value::chain(BinaryOp::And, idle);
        let step = Value::binary(BinaryOp::Implies, idle, still);
        self.add(Owner::System, TemporalForm::Transition, step);
    }

    /// Whether one of the formulas holds; `None` if there is none or one has a mistake.
    fn any(&mut self, nodes: &[Node]) -> Option<Value> {
        let values: Vec<Value> = nodes.iter().filter_map(|n| self.truth(n)).collect();
        (!values.is_empty()).then(|| Value::chain(BinaryOp::Or, values))
    }
}
