//! Evaluates formulas: resolves names, applies operators and checks types. Constructs with their
//! own rules have their own modules.

use super::reader::{Binding, Reader};
use super::scope::Symbol;
use super::syntax::{Define, Elements, Name, Node, Shape};
use super::types::kind_of;
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Expr, Time, UnaryOp};
use linewright_core::source::Span;
use std::rc::Rc;

impl Reader {
    /// The value of a formula; `None` after an error, which is reported.
    pub fn value(&mut self, node: &Node) -> Option<Value> {
        self.down(node.span)?;
        let value = self.shape(node);
        self.up();
        value.and_then(|v| self.check_size(v, node.span))
    }

    /// The value of a formula. If it is not a truth value, reports this and returns `None`.
    pub fn truth(&mut self, node: &Node) -> Option<Value> {
        let value = self.value(node)?;
        self.expect_kind(&value, &Kind::Bool, node.span)?;
        Some(value)
    }

    pub fn expect_kind(&mut self, value: &Value, kind: &Kind, span: Span) -> Option<()> {
        if value.kind == *kind {
            return Some(());
        }
        self.error(
            codes::TYPE_MISMATCH,
            span,
            format!(
                "this is {}, where {} is needed",
                value.kind.describe(),
                kind.describe()
            ),
            match kind {
                Kind::Bool => "compare it with a value: `x = 3`",
                _ => "use a number here",
            },
        );
        None
    }

    fn shape(&mut self, node: &Node) -> Option<Value> {
        let span = node.span;
        match &node.shape {
            Shape::Bool(value) => Some(Value::bool(*value)),
            Shape::Number(value) => Some(Value::int(*value)),
            Shape::Name(name, indices) => self.name(name, indices, span),
            Shape::Call(name, arguments) => self.call(name, arguments, span),
            Shape::Array(name, indices, function) => self.function(name, indices, function),
            Shape::Not(inner) => Some(self.truth(inner)?.not()),
            Shape::Negative(inner) => {
                let value = self.value(inner)?;
                self.expect_kind(&value, &Kind::Int, inner.span)?;
                Some(match value.expr {
                    Expr::Const(number) => Value::int(-number),
                    _ => value.unary(UnaryOp::Neg),
                })
            }
            Shape::Next(inner) => {
                let value = self.value(inner)?;
                self.primed(value, span)
            }
            Shape::Past(past, inner) => {
                let value = self.truth(inner)?;
                self.past(*past, &value, span)
            }
            Shape::Since(first, rest) => self.since(first, rest),
            Shape::Chain(first, rest) => self.chain(first, rest),
            Shape::Implies(a, b) => {
                let (a, b) = (self.truth(a), self.truth(b));
                Some(Value::binary(BinaryOp::Implies, a?, b?))
            }
            Shape::In {
                value,
                negated,
                items,
            } => {
                let found = self.membership(value, items)?;
                Some(if *negated { found.not() } else { found })
            }
            Shape::Quantified {
                all,
                name,
                domain,
                body,
            } => self.quantified(*all, name, domain, body),
            Shape::Matches(_) => {
                self.error(
                    codes::NOT_GR1,
                    span,
                    "a regular expression appears within a formula",
                    "use it as the whole formula of `G` or `GF`: `gar G regexp(r);`; for the steps after a match, write `gar trig r |=> e;`",
                );
                None
            }
        }
    }

    /// The value with next values in place of current ones.
    fn primed(&mut self, mut value: Value, span: Span) -> Option<Value> {
        if value.expr.mentions_next() {
            self.error(
                codes::NEXT_NESTED,
                span,
                "`next` is nested in `next`, perhaps through a define or a predicate",
                "refer only to the current step and the next one; to look further ahead, remember a value in a variable",
            );
            return None;
        }
        value.expr = value.expr.substitute(&mut |v, _| Expr::Var(v, Time::Next));
        Some(value)
    }

    fn chain(&mut self, first: &Node, rest: &[(BinaryOp, Node)]) -> Option<Value> {
        use BinaryOp as B;
        let spans: Vec<Span> = std::iter::once(first.span)
            .chain(rest.iter().map(|(_, n)| n.span))
            .collect();
        let mut values = vec![self.value(first)];
        for (_, node) in rest {
            values.push(self.value(node));
        }
        let values: Option<Vec<Value>> = values.into_iter().collect();
        let values = values?;
        let op = rest.first().map_or(B::And, |(op, _)| *op);
        let kind = match op {
            B::And | B::Or => Kind::Bool,
            B::Eq | B::Ne => return self.equations(values, rest, &spans),
            B::Lt | B::Le | B::Gt | B::Ge if values.iter().any(|v| v.kind.is_of_enumeration()) => {
                return self.compare_positions(op, values, first.span.to(spans[spans.len() - 1]));
            }
            _ => Kind::Int,
        };
        for (value, span) in values.iter().zip(&spans) {
            // Check every operand, because a chain can mix `xor` and `|`.
            self.expect_kind(value, &kind, *span)?;
        }
        if matches!(op, B::And | B::Or | B::Add) && rest.iter().all(|(o, _)| *o == op) {
            return Some(Value::chain(op, values));
        }
        let mut values = values.into_iter();
        let first = values.next()?;
        let operands = rest.iter().map(|(op, _)| *op).zip(values);
        Some(operands.fold(first, |a, (op, b)| Value::binary(op, a, b)))
    }

    /// The value of a name with its indices.
    fn name(&mut self, name: &str, indices: &[Node], span: Span) -> Option<Value> {
        match self.bound(name).cloned() {
            Some(Binding::Value(value)) => {
                self.no_indices(name, indices, span)?;
                return Some(value);
            }
            Some(Binding::Cells(cells)) => return self.element(&cells, name, indices, span),
            Some(Binding::Elements(define)) => return self.defined(&define, indices, span),
            None => {}
        }
        match self.symbol(name, span).map(|(symbol, _)| symbol.clone()) {
            Some(Symbol::Variable(cells)) => self.element(&cells, name, indices, span),
            Some(Symbol::Define(define)) => self.defined(&define, indices, span),
            Some(Symbol::Predicate(predicate)) if indices.is_empty() => {
                self.predicate(&predicate, &[], span)
            }
            Some(_) => {
                self.error(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("`{name}` has no value: it is a pattern or a regular expression"),
                    "write a pattern on its own, `gar p(a, b);`, and a regular expression in `regexp(r)` or `trig`",
                );
                None
            }
            None if self.labels.contains(name) => {
                self.no_indices(name, indices, span)?;
                Some(Value::leaf(Expr::Const(0), Kind::Label(name.to_owned())))
            }
            None => {
                self.unknown("name", name, span);
                None
            }
        }
    }

    pub fn no_indices(&mut self, name: &str, indices: &[Node], span: Span) -> Option<()> {
        if indices.is_empty() {
            return Some(());
        }
        self.error(
            codes::TYPE_MISMATCH,
            span,
            format!("`{name}` is not an array"),
            "remove the index",
        );
        None
    }

    /// The value of a define or of an element of an array define.
    fn defined(&mut self, define: &Rc<Define>, indices: &[Node], span: Span) -> Option<Value> {
        let name = &define.name;
        if let Elements::One(node) = &define.value {
            self.no_indices(&name.text, indices, span)?;
            if let Some((value, mentions)) = self.expanded.get(&name.span) {
                let value = value.clone();
                self.mentions.extend(mentions.iter().copied());
                return value;
            }
            let mut before = std::mem::take(&mut self.mentions);
            let value = self.expanded(name, span, |reader| reader.value(node));
            let mentions = self.mentions.clone();
            self.mentions.append(&mut before);
            self.expanded.insert(name.span, (value.clone(), mentions));
            return value;
        }
        self.defined_element(define, indices, span)
    }

    /// Expands a definition in an empty frame. If the definition is circular, reports this and
    /// returns `None`.
    pub fn expanded<T>(
        &mut self,
        name: &Name,
        span: Span,
        expand: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Option<T> {
        if self.open.contains(&name.span) {
            self.error(
                codes::NOT_CONSTANT,
                span,
                format!("`{}` is defined in terms of itself", name.text),
                "avoid the cycle; for a value that changes over time, declare a variable, a monitor or a counter",
            );
            return None;
        }
        self.open.push(name.span);
        self.frames.push(Vec::new());
        let found = expand(self);
        self.frames.pop();
        self.open.pop();
        found
    }

    /// The value of a variable.
    pub fn mention(&mut self, v: linewright_core::gr1::VarId, span: Span) -> Value {
        self.mentions.insert((v, span));
        let kind = kind_of(&self.variable(v).domain);
        Value::leaf(Expr::now(v), kind)
    }
}
