//! Records and arrays: literals, members, and choices between values of any shape.

use super::findings::Findings;
use super::units::aligned;
use super::{Elaborator, comparable, nearest};
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Time;
use linewright_core::source::Span;
use linewright_syntax::ast;

impl<'a> Elaborator<'a> {
    /// Elaborates `{x = 0, y = 1}`. The members are in the order of the expected type if there is
    /// one.
    pub(super) fn record(
        &mut self,
        span: Span,
        members: &'a [ast::Argument],
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let types = match expected {
            Some(Type::Record(types)) => types.as_slice(),
            _ => &[],
        };
        let mut values: Vec<(String, Value)> = Vec::with_capacity(members.len());
        let mut complete = true;
        for member in members {
            let name = &member.name;
            if values.iter().any(|(n, _)| *n == name.text) {
                self.findings.error_with(
                    codes::NAME_DUPLICATE,
                    name.span,
                    format!("the member `{}` appears twice", name.text),
                    "remove one of the two",
                );
                complete = false;
                continue;
            }
            let ty = types.iter().find(|(n, _)| *n == name.text).map(|(_, t)| t);
            if ty.is_none() && !types.is_empty() {
                let known: Vec<&str> = types.iter().map(|(n, _)| n.as_str()).collect();
                self.findings.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("the record has no member `{}`", name.text),
                    match nearest(&name.text, known.iter().copied()) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("its members are {}", known.join(", ")),
                    },
                );
                complete = false;
            }
            match self.value(&member.value, ty, time) {
                Some(value) => values.push((name.text.clone(), value)),
                None => complete = false,
            }
        }
        for (name, _) in types {
            if !members.iter().any(|m| m.name.text == *name) {
                self.findings.error_with(
                    codes::ARGUMENT,
                    span,
                    format!("the member `{name}` has no value"),
                    format!("add `{name} = ...`"),
                );
                complete = false;
            }
        }
        let place = |name: &str| types.iter().position(|(n, _)| n == name);
        values.sort_by_key(|(name, _)| place(name));
        complete.then_some(Value::Record(values))
    }

    /// Builds `if condition then a else b` for two values of the same shape.
    pub(super) fn choose(
        &mut self,
        condition: &Term,
        (a, a_span): (Value, Span),
        (b, b_span): (Value, Span),
    ) -> Option<Value> {
        match (a, b) {
            (Value::Scalar(l, lt), Value::Scalar(r, rt)) if comparable(&lt, &rt) => {
                self.expansion
                    .spend(a_span, condition.size(), &mut self.findings)?;
                let (l, r, ty) = if lt.is_numeric() && !self.dialect.real {
                    aligned(b_span, (l, lt), (r, rt), &mut self.findings)?
                } else {
                    let ty = if lt == Type::Int { rt } else { lt };
                    (l, r, ty)
                };
                Some(Value::Scalar(Term::choose(condition.clone(), l, r), ty))
            }
            (Value::Array(l), Value::Array(r)) if l.len() == r.len() => {
                let chosen = l
                    .into_iter()
                    .zip(r)
                    .map(|(l, r)| self.choose(condition, (l, a_span), (r, b_span)));
                Some(Value::Array(chosen.collect::<Option<_>>()?))
            }
            (Value::Record(l), Value::Record(r))
                if l.len() == r.len() && l.iter().zip(&r).all(|((a, _), (b, _))| a == b) =>
            {
                let chosen = l.into_iter().zip(r).map(|((name, l), (_, r))| {
                    let value = self.choose(condition, (l, a_span), (r, b_span))?;
                    Some((name, value))
                });
                Some(Value::Record(chosen.collect::<Option<_>>()?))
            }
            (l, r) => {
                self.findings.mismatch(b_span, &l.ty().describe(), &r.ty());
                None
            }
        }
    }
}

/// Returns a member of a record; reports an unknown member, and a value that is not a record.
pub(super) fn member(
    span: Span,
    value: Value,
    name: &ast::Name,
    findings: &mut Findings,
) -> Option<Value> {
    let Value::Record(members) = value else {
        findings.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("this is {}, which has no members", value.ty().describe()),
            "remove the member, or declare the value as `record {...}`",
        );
        return None;
    };
    let known: Vec<String> = members.iter().map(|(n, _)| n.clone()).collect();
    let found = members.into_iter().find(|(n, _)| *n == name.text);
    if found.is_none() {
        let help = match nearest(&name.text, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("its members are {}", known.join(", ")),
        };
        findings.error_with(
            codes::NAME_UNKNOWN,
            name.span,
            format!("the record has no member `{}`", name.text),
            help,
        );
    }
    found.map(|(_, v)| v)
}
