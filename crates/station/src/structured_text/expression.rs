//! Emits formulas as conditions of Structured Text.
//!
//! Integers are computed in the narrowest type that holds every intermediate value. The standard
//! rounds quotients toward 0 while contracts round them down, so a division of possibly negative
//! numbers needs a longer expression. Enumerations are compared by their labels, and converted to
//! numbers only if necessary.

use super::interface::Port;
use super::{Type, Width, literal};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Owner, Specification, Time, UnaryOp, VarId};
use std::collections::BTreeMap;

/// Maximum length of a condition in characters. Quotients of negative numbers repeat their
/// operands, so nested quotients can grow exponentially.
pub(super) const MAX_CONDITION_CHARS: usize = 100_000;

/// Translates formulas to conditions, with the names of the block's variables.
pub(super) struct Translator<'a> {
    pub specification: &'a Specification,
    pub inputs: &'a [Port<'a>],
    pub outputs: &'a [Port<'a>],
    /// For a formula about two steps: copies of the earlier step's inputs, by index.
    pub kept: Option<&'a BTreeMap<usize, String>>,
}

impl Translator<'_> {
    /// Condition that is true if a formula is violated; `None` if the condition would be too long.
    pub fn violation(&self, expr: &Expr) -> Option<String> {
        let expr = expr.simplify();
        bounded(match self.connected(&expr, true) {
            Some((operands, sign)) => operands?.join(sign),
            None => self.truth(&expr, true)?,
        })
    }

    /// Returns the operands and the operator of a truth value or of its negation, if that is a
    /// conjunction or a disjunction. The operands are `None` if one of them would be too long.
    fn connected(&self, expr: &Expr, negate: bool) -> Option<(Option<Vec<String>>, &'static str)> {
        let signs = [(true, " AND "), (false, " OR ")];
        let mut found = signs.into_iter().filter_map(|(and, sign)| {
            let operands = operands(expr, negate, and);
            (operands.len() > 1).then_some((operands, sign))
        });
        let (operands, sign) = found.next()?;
        let operands = operands.into_iter();
        let texts = operands.map(|(expr, negate)| self.truth(expr, negate));
        Some((texts.collect(), sign))
    }

    /// Name and port of a variable.
    fn variable(&self, id: VarId, time: Time) -> Option<(String, &Port<'_>)> {
        let specification = self.specification;
        match (specification.variable(id).owner, time, self.kept) {
            (Owner::Environment, ..) => {
                let place = specification.inputs().position(|v| v == id)?;
                let port = &self.inputs[place];
                let name = match (time, self.kept) {
                    (Time::Now, Some(kept)) => kept.get(&place)?.clone(),
                    _ => port.name.clone(),
                };
                Some((name, port))
            }
            // Before the step is made, outputs have the values of the previous step.
            (Owner::System, Time::Now, Some(_)) => {
                let place = specification.outputs().position(|v| v == id)?;
                let port = &self.outputs[place];
                Some((port.name.clone(), port))
            }
            _ => None,
        }
    }

    fn domain(&self, id: VarId) -> &Domain {
        &self.specification.variable(id).domain
    }

    /// Whether an expression's form makes it a truth value.
    fn is_truth(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Const(_) => false,
            Expr::Var(v, _) => *self.domain(*v) == Domain::Bool,
            Expr::Unary(op, _) => *op == UnaryOp::Not,
            Expr::Binary(op, ..) => !is_arithmetic(*op),
            Expr::If(_, a, b) => self.is_truth(a) || self.is_truth(b),
        }
    }

    /// A truth value or its negation, as an operand.
    fn truth(&self, expr: &Expr, negate: bool) -> Option<String> {
        use BinaryOp as B;
        bounded(match expr {
            Expr::Const(c) => if (*c != 0) == negate { "FALSE" } else { "TRUE" }.to_owned(),
            Expr::Var(v, t) if *self.domain(*v) == Domain::Bool => {
                let (name, _) = self.variable(*v, *t)?;
                if negate { format!("NOT {name}") } else { name }
            }
            Expr::Unary(UnaryOp::Not, a) => self.truth(a, !negate)?,
            Expr::Binary(B::And | B::Or | B::Implies, ..) => {
                let (operands, sign) = self.connected(expr, negate)?;
                format!("({})", operands?.join(sign))
            }
            Expr::Binary(op @ (B::Eq | B::Ne), a, b) => {
                let equal = (*op == B::Eq) != negate;
                match (self.is_truth(a), &**a, self.is_truth(b), &**b) {
                    (true, _, _, Expr::Const(c @ (0 | 1))) => self.truth(a, equal != (*c != 0))?,
                    (_, Expr::Const(c @ (0 | 1)), true, _) => self.truth(b, equal != (*c != 0))?,
                    (true, _, true, _) => {
                        let sign = if equal { "=" } else { "<>" };
                        let (a, b) = (self.truth(a, false)?, self.truth(b, false)?);
                        format!("({a} {sign} {b})")
                    }
                    _ => match self.labels(a, b, equal) {
                        Some(text) => text,
                        None => self.compared(a, if equal { "=" } else { "<>" }, b)?,
                    },
                }
            }
            Expr::Binary(B::Lt | B::Ge, a, b) => {
                let less = matches!(expr, Expr::Binary(B::Lt, ..)) != negate;
                self.compared(a, if less { "<" } else { ">=" }, b)?
            }
            Expr::Binary(B::Gt | B::Le, a, b) => {
                let more = matches!(expr, Expr::Binary(B::Gt, ..)) != negate;
                self.compared(a, if more { ">" } else { "<=" }, b)?
            }
            Expr::If(c, a, b) => {
                let (a, b) = (self.truth(a, negate)?, self.truth(b, negate)?);
                match &**c {
                    // A short condition can be repeated.
                    Expr::Var(..) | Expr::Unary(..) => {
                        let (yes, no) = (self.truth(c, false)?, self.truth(c, true)?);
                        format!("(({yes} AND {a}) OR ({no} AND {b}))")
                    }
                    _ => format!("SEL({}, {b}, {a})", self.truth(c, false)?),
                }
            }
            // A number is true if it is not 0.
            _ => self.compared(expr, if negate { "=" } else { "<>" }, &Expr::Const(0))?,
        })
    }

    /// Returns the comparison of two values of one enumeration; `None` for other operands.
    fn labels(&self, a: &Expr, b: &Expr, equal: bool) -> Option<String> {
        let (a, b) = match (a, b) {
            (Expr::Const(_) | Expr::If(..), Expr::Var(..)) => (b, a),
            _ => (a, b),
        };
        let Expr::Var(v, t) = a else {
            return None;
        };
        let (name, port) = self.variable(*v, *t)?;
        let other = self.label(b, port)?;
        let sign = if equal { "=" } else { "<>" };
        Some(format!("({name} {sign} {other})"))
    }

    /// Returns the label for a value of a port's enumeration; `None` for any other expression.
    fn label(&self, expr: &Expr, port: &Port<'_>) -> Option<String> {
        match expr {
            Expr::Const(c) => port.labels.get(usize::try_from(*c).ok()?).cloned(),
            Expr::Var(v, t) => {
                let (name, other) = self.variable(*v, *t)?;
                (!port.labels.is_empty() && port.kind == other.kind).then_some(name)
            }
            Expr::If(c, a, b) => {
                let (a, b) = (self.label(a, port)?, self.label(b, port)?);
                Some(format!("SEL({}, {b}, {a})", self.truth(c, false)?))
            }
            _ => None,
        }
    }

    fn compared(&self, a: &Expr, sign: &str, b: &Expr) -> Option<String> {
        let width = self.width(a)?.max(self.width(b)?);
        let (a, b) = (self.number(a, width)?, self.number(b, width)?);
        Some(format!("({a} {sign} {b})"))
    }

    fn range(&self, expr: &Expr) -> Option<Interval> {
        interval(expr, &|v| Interval::of(self.domain(v))).ok()
    }

    /// The narrowest type for an expression and all its parts.
    fn width(&self, expr: &Expr) -> Option<Width> {
        let range = self.range(expr)?;
        let own = Width::of(range.low, range.high);
        let parts: Vec<&Expr> = match expr {
            Expr::Unary(UnaryOp::Not, _) => Vec::new(),
            Expr::Unary(_, a) => vec![a],
            Expr::Binary(op, a, b) if is_arithmetic(*op) => vec![a, b],
            Expr::If(_, a, b) => vec![a, b],
            _ => Vec::new(),
        };
        parts
            .into_iter()
            .try_fold(own, |width, part| Some(width.max(self.width(part)?)))
    }

    /// An integer of this width, as an operand.
    fn number(&self, expr: &Expr, width: Width) -> Option<String> {
        use BinaryOp as B;
        let word = width.keyword();
        if self.is_truth(expr) {
            let condition = self.truth(expr, false)?;
            return Some(format!("SEL({condition}, {word}#0, {word}#1)"));
        }
        bounded(match expr {
            Expr::Const(c) => literal(*c),
            Expr::Var(v, t) => {
                let (name, port) = self.variable(*v, *t)?;
                match port.kind {
                    Type::Integer(own) => own.convert(width, &name),
                    _ => numbered(&name, &port.labels, word),
                }
            }
            Expr::Unary(UnaryOp::Neg, a) => format!("(0 - {})", self.number(a, width)?),
            Expr::Unary(_, a) => format!("ABS({})", self.number(a, width)?),
            Expr::If(c, a, b) => {
                // SEL needs a typed literal if both operands are literals.
                let typed = |e: &Expr| match e {
                    Expr::Const(c) => Some(format!("{word}#{c}")),
                    _ => self.number(e, width),
                };
                let (a, b) = (typed(a)?, typed(b)?);
                format!("SEL({}, {b}, {a})", self.truth(c, false)?)
            }
            Expr::Binary(op, a, b) => {
                let (x, y) = (self.number(a, width)?, self.number(b, width)?);
                match op {
                    B::Add => format!("({x} + {y})"),
                    B::Sub => format!("({x} - {y})"),
                    B::Mul => format!("({x} * {y})"),
                    B::Div | B::Mod => {
                        let signs = (self.range(a)?.low < 0, self.range(b)?.low < 0);
                        rounded_down(*op, &x, &y, signs, word)
                    }
                    B::Min => format!("MIN({x}, {y})"),
                    B::Max => format!("MAX({x}, {y})"),
                    _ => return None,
                }
            }
        })
    }
}

/// Returns the text, or `None` if it is too long.
fn bounded(text: String) -> Option<String> {
    (text.len() <= MAX_CONDITION_CHARS).then_some(text)
}

/// Expression that converts an enumeration to the number of its label.
fn numbered(name: &str, labels: &[String], word: &str) -> String {
    let last = labels.len().saturating_sub(1);
    let labels = labels.iter().enumerate().take(last).rev();
    labels.fold(format!("{word}#{last}"), |rest, (number, label)| {
        format!("SEL(({name} = {label}), {rest}, {word}#{number})")
    })
}

/// Expression for a quotient that is rounded down, or for its remainder, which has the divisor's
/// sign. `signs` tells whether dividend and divisor can be negative. The standard's own quotient
/// rounds toward 0, and its remainder has the dividend's sign.
fn rounded_down(op: BinaryOp, x: &str, y: &str, signs: (bool, bool), word: &str) -> String {
    let rest = format!("({x} MOD {y})");
    // No divisor's range contains 0. If the remainder's sign differs from the divisor's, the
    // quotient is one too high.
    let high = match signs {
        (false, false) => None,
        (true, false) => Some(format!("({rest} < 0)")),
        (_, true) => Some(format!("({rest} > 0)")),
    };
    let zero = format!("{word}#0");
    match (op, high) {
        (BinaryOp::Div, None) => format!("({x} / {y})"),
        (BinaryOp::Div, Some(high)) => {
            format!("(({x} / {y}) - SEL({high}, {zero}, {word}#1))")
        }
        (_, None) => rest,
        // The divisor can be an untyped literal, which SEL does not accept.
        (_, Some(high)) => format!("({rest} + SEL({high}, {zero}, ({zero} + {y})))"),
    }
}

/// Whether an operator returns a number instead of a truth value.
fn is_arithmetic(op: BinaryOp) -> bool {
    use BinaryOp as B;
    matches!(
        op,
        B::Add | B::Sub | B::Mul | B::Div | B::Mod | B::Min | B::Max
    )
}

/// Splits a truth value or its negation into the operands of a conjunction, or of a disjunction if
/// `conjunction` is false. Returns the operands from left to right, each with whether it is
/// negated.
fn operands(expr: &Expr, negate: bool, conjunction: bool) -> Vec<(&Expr, bool)> {
    use BinaryOp as B;
    let mut found = Vec::new();
    let mut stack = vec![(expr, negate)];
    while let Some((expr, negate)) = stack.pop() {
        match expr {
            Expr::Unary(UnaryOp::Not, a) => stack.push((a, !negate)),
            Expr::Binary(B::And, a, b) if conjunction != negate => {
                stack.extend([(&**b, negate), (&**a, negate)]);
            }
            Expr::Binary(B::Or, a, b) if conjunction == negate => {
                stack.extend([(&**b, negate), (&**a, negate)]);
            }
            Expr::Binary(B::Implies, a, b) if conjunction == negate => {
                stack.extend([(&**b, negate), (&**a, !negate)]);
            }
            _ => found.push((expr, negate)),
        }
    }
    found
}
