//! Counters: `counter c(0..9) { c = 0; inc: p; dec: q; reset: r; overflow: keep; underflow: modulo;
//! }`.
//!
//! The counter is an internal variable of the system. In each transition:
//!
//! | | |
//! |---|---|
//! | `inc` | up by one; at the upper end, `keep` stays, `modulo` moves to the lower end, `false` forbids `inc` |
//! | `dec` | down by one; `underflow` applies at the lower end |
//! | `reset` | to the lower end |
//! | none of these | unchanged |
//!
//! The default of `overflow` and `underflow` is `false`. As in Spectra, each section is a separate
//! guarantee. If two sections require different values in one step, the guarantees conflict, so
//! the system has to avoid such steps.

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
            let Some(condition) = self.any(nodes) else {
                continue;
            };
            idle.push(condition.clone().not());
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
            let step = Value::binary(BinaryOp::Implies, condition, allowed);
            self.add(Owner::System, TemporalForm::Transition, step);
        }
        if let Some(condition) = self.any(&counter.reset) {
            idle.push(condition.clone().not());
            let step = Value::binary(BinaryOp::Implies, condition, is(&next, low));
            self.add(Owner::System, TemporalForm::Transition, step);
        }
        let still = Value::binary(BinaryOp::Eq, next, now);
        let idle = Value::chain(BinaryOp::And, idle);
        let step = Value::binary(BinaryOp::Implies, idle, still);
        self.add(Owner::System, TemporalForm::Transition, step);
    }

    /// The disjunction of `nodes`, without those that are invalid; `None` if none is left.
    fn any(&mut self, nodes: &[Node]) -> Option<Value> {
        let values: Vec<Value> = nodes.iter().filter_map(|n| self.truth(n)).collect();
        (!values.is_empty()).then(|| Value::chain(BinaryOp::Or, values))
    }
}
