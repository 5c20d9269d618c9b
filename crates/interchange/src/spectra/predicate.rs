//! Predicates: `predicate free(Int(0..3) room): !occupied[room];`, used as `free(2)`.
//!
//! Arguments are substituted by value. A value is an expression, so `next(free(r))` refers to next
//! values in the argument `r`, too.

use super::reader::{Binding, Reader};
use super::scope::Symbol;
use super::syntax::{Name, Node, Parameter, Predicate};
use super::types::kind_of;
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Expr;
use linewright_core::source::Span;
use std::rc::Rc;

impl Reader {
    /// The value of `p(a, b)` within a formula.
    pub fn call(&mut self, name: &Name, arguments: &[Node], span: Span) -> Option<Value> {
        match self.symbol(&name.text, name.span).map(|(s, _)| s.clone()) {
            Some(Symbol::Predicate(predicate)) => self.predicate(&predicate, arguments, span),
            Some(Symbol::Pattern(_) | Symbol::Published(_)) => {
                self.error(
                    codes::NOT_GR1,
                    span,
                    format!("the pattern `{}` appears within a formula", name.text),
                    "write the pattern as an assumption or a guarantee of its own: `gar p(a, b);`",
                );
                None
            }
            Some(_) => {
                self.error(
                    codes::TYPE_MISMATCH,
                    name.span,
                    format!("`{}` takes no arguments", name.text),
                    "remove the parentheses",
                );
                None
            }
            None if name.text == "ite" && arguments.len() == 3 => self.if_then_else(arguments),
            None => {
                self.unknown("predicate or pattern", &name.text, name.span);
                None
            }
        }
    }

    /// `ite(c, a, b)`: `a` if `c` holds, otherwise `b`, which are of the same type.
    fn if_then_else(&mut self, arguments: &[Node]) -> Option<Value> {
        let [condition, yes, no] = arguments else {
            return None;
        };
        let (condition, yes, other) = (self.truth(condition), self.value(yes), self.value(no));
        let (condition, yes, other) = (condition?, yes?, other?);
        self.expect_kind(&other, &yes.kind, no.span)?;
        Some(Value::choose(condition, yes, other))
    }

    pub fn predicate(
        &mut self,
        predicate: &Rc<Predicate>,
        arguments: &[Node],
        span: Span,
    ) -> Option<Value> {
        let name = &predicate.name;
        self.check_arity(
            &name.text,
            predicate.parameters.len(),
            arguments.len(),
            span,
        )?;
        let mut bindings = Vec::new();
        for (parameter, argument) in predicate.parameters.iter().zip(arguments) {
            let binding = self.argument(parameter, argument)?;
            bindings.push((parameter.name.text.clone(), binding));
        }
        self.expanded(name, span, |reader| {
            if let Some(frame) = reader.frames.last_mut() {
                frame.extend(bindings);
            }
            reader.truth(&predicate.body)
        })
    }

    pub fn check_arity(
        &mut self,
        name: &str,
        wanted: usize,
        given: usize,
        span: Span,
    ) -> Option<()> {
        if wanted == given {
            return Some(());
        }
        self.error(
            codes::ARGUMENT,
            span,
            format!("`{name}` takes {}, but has {given} here", arguments(wanted)),
            "write one argument for each parameter",
        );
        None
    }

    fn argument(&mut self, parameter: &Parameter, argument: &Node) -> Option<Binding> {
        if let Some(array) = self.whole_array(argument) {
            return Some(array);
        }
        let value = self.value(argument)?;
        let (domain, _) = self.domain(&parameter.of)?;
        let wanted = kind_of(&domain);
        let matches_type = match (&wanted, &value.kind) {
            (Kind::Labels(labels), Kind::Label(label)) => {
                // The label becomes a value of the parameter's enumeration.
                if let Some(index) = labels.iter().position(|l| l == label) {
                    let index = Expr::Const(index as i64);
                    return Some(Binding::Value(Value::leaf(index, wanted)));
                }
                false
            }
            (Kind::Labels(_), Kind::Labels(_)) => true,
            (wanted, given) => wanted == given,
        };
        if !matches_type {
            self.error(
                codes::TYPE_MISMATCH,
                argument.span,
                format!(
                    "the parameter `{}` is {}, but the argument is {}",
                    parameter.name.text,
                    wanted.describe(),
                    value.kind.describe()
                ),
                "pass an argument of the parameter's type",
            );
            return None;
        }
        Some(Binding::Value(value))
    }
}

fn arguments(count: usize) -> String {
    match count {
        0 => "no arguments".to_owned(),
        1 => "1 argument".to_owned(),
        _ => format!("{count} arguments"),
    }
}
