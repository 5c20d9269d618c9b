//! Defines: names for expressions, with or without parameters.
//!
//! A define has the same meaning wherever it is used. Its body can therefore use its own parameters
//! and the names in scope at its declaration, but no quantified names of the place where it is
//! used. A define at the top level of a file cannot use the names of a contract either.

use super::Elaborator;
use super::units::fitted_value;
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Expr, Time};
use linewright_core::source::Span;
use linewright_syntax::ast;

impl<'a> Elaborator<'a> {
    /// Returns the value of a define that is used without arguments. Reports a define that has
    /// parameters.
    pub(super) fn constant_define(
        &mut self,
        span: Span,
        define: &'a ast::Define,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        if let Some(first) = define.formals.first() {
            let names: Vec<&str> = define
                .formals
                .iter()
                .map(|f| f.name.text.as_str())
                .collect();
            self.findings.error_with(
                codes::ARGUMENT,
                span,
                format!(
                    "`{}` needs a value for `{}`",
                    define.name.text, first.name.text
                ),
                format!("write `{}({})`", define.name.text, names.join(", ")),
            );
            return None;
        }
        self.expanded(span, define, Vec::new(), expected, time)
    }

    /// Returns the value of a define for these arguments. Reports a wrong number of arguments.
    pub(super) fn predicate(
        &mut self,
        span: Span,
        name: &ast::Name,
        arguments: &'a [ast::Expr],
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let define = self.names.defines.get(&name.text).copied()?;
        let formals = &define.formals;
        if formals.len() != arguments.len() {
            let names: Vec<&str> = formals.iter().map(|f| f.name.text.as_str()).collect();
            let help = if names.is_empty() {
                format!("write `{}`", name.text)
            } else {
                format!("write `{}({})`", name.text, names.join(", "))
            };
            self.findings.error_with(
                codes::ARGUMENT,
                span,
                format!(
                    "`{}` takes {}, not {}",
                    name.text,
                    counted(formals.len()),
                    arguments.len()
                ),
                help,
            );
            return None;
        }
        let mut values = Vec::with_capacity(arguments.len());
        for (formal, argument) in formals.iter().zip(arguments) {
            values.push(self.argument(formal, argument, time));
        }
        let values: Vec<Value> = values.into_iter().collect::<Option<_>>()?;
        self.expanded(span, define, values, expected, time)
    }

    /// Elaborates an argument, and converts it to the type of its parameter if the parameter
    /// declares one. The argument is elaborated for the current step, because `next` applies to the
    /// define as a whole.
    fn argument(
        &mut self,
        formal: &'a ast::Formal,
        argument: &'a ast::Expr,
        time: Time,
    ) -> Option<Value> {
        let expected = match &formal.domain {
            Some(domain) => Some(self.shape(domain)?.ty()),
            None => None,
        };
        let value = self.value(argument, expected.as_ref(), Time::Now)?;
        if time == Time::Next {
            self.later(argument.span, value.clone())?;
        }
        match expected {
            Some(ty) => fitted_value(argument.span, value, &ty, &mut self.findings),
            None => Some(value),
        }
    }

    /// Returns the value of a define's body, where `values` are the values of its parameters.
    fn expanded(
        &mut self,
        span: Span,
        define: &'a ast::Define,
        values: Vec<Value>,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let name = &define.name.text;
        if self.expansion.defining.contains(name) {
            self.findings.error_with(
                codes::NAME_DUPLICATE,
                span,
                format!("`{name}` is defined in terms of itself"),
                "break the cycle; to compute a value from its previous value, use an internal variable and `next`",
            );
            return None;
        }
        self.expansion.defining.push(name.clone());
        let is_top_level = self
            .names
            .of_file
            .defines
            .get(name)
            .is_some_and(|d| std::ptr::eq(*d, define));
        let body = |e: &mut Self| {
            let names = define.formals.iter().map(|f| f.name.text.clone());
            for (name, value) in names.zip(values) {
                e.names.bind(name, value);
            }
            let value = e.value(&define.value, expected, time);
            for _ in &define.formals {
                e.names.unbind();
            }
            value
        };
        let value = self.without_bound_names(|e| {
            if is_top_level {
                e.with_file_names_only(body)
            } else {
                body(e)
            }
        });
        self.expansion.defining.pop();
        value
    }

    /// Returns the value of an expression one step later. Reports an expression that already
    /// contains `next`.
    pub(super) fn later(&mut self, span: Span, value: Value) -> Option<Value> {
        let mut has_next = false;
        let monitors = self.memory.monitors.as_ref();
        let value = value.map(&mut |term, ty| {
            if !term.has_variable() {
                return Some((term, ty));
            }
            let expr = term.to_expr()?;
            has_next |= expr.mentions_next();
            if has_next {
                return Some((term, ty));
            }
            let next = match monitors {
                Some(monitors) => monitors.one_step_later(&expr),
                None => expr.substitute(&mut |v, _| Expr::next(v)),
            };
            Some((Term::from_expr(&next), ty))
        });
        if has_next {
            self.findings.error_with(
                codes::NEXT_NESTED,
                span,
                "`next` is nested in `next`",
                "GR(1) looks one step ahead; hold the value in an internal variable to look further",
            );
            return None;
        }
        value
    }

    /// Runs a function without the quantified names in scope.
    pub(super) fn without_bound_names<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        let bound = self.names.hide_bound();
        let result = run(self);
        self.names.restore_bound(bound);
        result
    }

    /// Runs a function with only the top-level names of files in scope.
    fn with_file_names_only<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        let local = self.names.hide_local();
        let result = run(self);
        self.names.restore_local(local);
        result
    }
}

fn counted(values: usize) -> String {
    match values {
        0 => "no value".to_owned(),
        1 => "1 value".to_owned(),
        n => format!("{n} values"),
    }
}
