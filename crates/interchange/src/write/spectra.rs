//! Writes the Spectra language.
//!
//! Numbers, comparisons and sums are written directly. The language has no `if`, `min`, `max` and
//! `abs`, and no truth values as numbers. [`gates`](super::gates) decomposes comparisons that
//! contain these, and those with `/` or `mod`, whose meaning for negative numbers differs between
//! tools. Enumerations keep their labels if all labels can be names. A Moore game is turned into a
//! Mealy game; see [`lower`].

use super::super::lower;
use super::super::spectra::is_keyword;
use super::gates::{Shape, TooManyCases, is_truth};
use super::one_line;
use super::text::{Piece, Rank, Words, at_least};
use super::{Writing, is_plain};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, FormulaKind, Owner, Side, Specification, Time, Timing,
    UnaryOp, VarId, Variable,
};
use linewright_core::rename::renamed;
use std::fmt::Write as _;

const WORDS: Words = Words {
    truth: ["false", "true"],
    not: "!",
    and: "&",
    or: "|",
    iff: "<->",
};

/// Maximum number of gates of an expanded formula.
const MAX_SIZE: u64 = 1 << 18;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    // Invariants are replaced first, because they must not apply to the first step that the
    // lowering of a Moore game adds.
    let lowered = match specification.timing {
        Timing::Mealy => specification.clone(),
        Timing::Moore => lower::to_mealy(&lower::without_invariants(specification)),
    };
    let sides = [&lowered.assumptions, &lowered.guarantees];
    let formulas: Vec<&Formula> = sides.into_iter().flat_map(Side::all).collect();
    let variables = lowered.variables.iter().map(|v| v.name.as_str());
    let wanted = variables.chain(formulas.iter().map(|f| f.name.as_str()));
    let mut names = renamed(wanted, "v_", is_name);
    let labels = names.split_off(lowered.variables.len());
    let base = Writing::new(&lowered, &names);
    let mut writer = Writer { base };
    let text = writer.file(&labels);
    writer.base.finish(text)
}

/// An assumption or guarantee over the variables of a Spectra file, as a statement of that file.
/// `None` if Spectra cannot express the formula, or if the formula mentions a variable that the
/// file does not declare.
pub(super) fn statement(
    specification: &Specification,
    side: Owner,
    name: Option<&str>,
    kind: FormulaKind,
    expr: &Expr,
) -> Option<String> {
    let mut is_declared = true;
    expr.for_each_var(&mut |v, _| is_declared &= !specification.is_auxiliary(v));
    if !is_declared {
        return None;
    }
    let names = specification.variables.iter().map(|v| v.name.clone());
    let names: Vec<String> = names.collect();
    let mut writer = Writer {
        base: Writing::new(specification, &names),
    };
    let (_, body) = writer.truth(expr).ok()?;
    let keyword = match side {
        Owner::Environment => "asm",
        Owner::System => "gar",
    };
    let name = name.map_or(String::new(), |name| format!(" {name}:"));
    let operator = match kind {
        FormulaKind::Initial => "ini",
        FormulaKind::Invariant => "alw",
        FormulaKind::Safety => "G",
        FormulaKind::Justice => "GF",
    };
    Some(format!("{keyword}{name} {operator} ({body});"))
}

fn is_name(name: &str) -> bool {
    is_plain(name, "", &[]) && !is_keyword(name)
}

struct Writer<'s> {
    base: Writing<'s>,
}

impl Writer<'_> {
    fn file(&mut self, labels: &[String]) -> String {
        let specification = self.base.specification;
        let names = renamed([specification.name.as_str()], "s_", is_name);
        let stem = names.first().map_or("specification", String::as_str);
        let mut text = format!("spec {stem}\n\n");
        for (index, (variable, name)) in specification
            .variables
            .iter()
            .zip(self.base.names)
            .enumerate()
        {
            let owner = match (variable.owner, variable.internal) {
                (Owner::Environment, _) => "env",
                (Owner::System, false) => "sys",
                (Owner::System, true) => "aux",
            };
            let of = self.type_of(VarId(index as u32));
            let _ = write!(text, "{owner} {of} {name};");
            if *name != variable.name {
                let was = one_line(&variable.name);
                let _ = write!(text, " -- was {was}");
            }
            if let Domain::Enum { labels, .. } = &variable.domain
                && self.labels(variable).is_none()
            {
                let labels = labels.iter().enumerate().map(|(i, l)| format!("{i} {l}"));
                let _ = write!(text, " -- {}", labels.collect::<Vec<_>>().join(", "));
            }
            text.push('\n');
        }
        let mut labels = labels.iter();
        for (keyword, side) in [
            ("asm", &specification.assumptions),
            ("gar", &specification.guarantees),
        ] {
            for (operator, formulas) in [
                ("ini", &side.initial),
                ("alw", &side.invariants),
                ("G", &side.safety),
                ("GF", &side.justice),
            ] {
                for formula in formulas {
                    let name = labels.next().map_or("formula", String::as_str);
                    let piece = self.truth(&formula.expr);
                    if let Some((_, body)) = self.base.unless_too_many(formula, piece) {
                        let _ = write!(text, "\n{keyword} {name}:\n  {operator} ({body});\n");
                    }
                }
            }
        }
        text
    }

    fn type_of(&self, v: VarId) -> String {
        let variable = self.base.specification.variable(v);
        match (&variable.domain, self.labels(variable)) {
            (Domain::Bool, _) => "boolean".to_owned(),
            (_, Some(labels)) => format!("{{{}}}", labels.join(", ")),
            (domain, None) => format!("Int({}..{})", number(domain.low()), number(domain.high())),
        }
    }

    /// The labels of a variable, if all of them can be written and none is the name of a variable.
    fn labels<'v>(&self, variable: &'v Variable) -> Option<&'v [String]> {
        match &variable.domain {
            Domain::Enum { labels, .. }
                if labels
                    .iter()
                    .all(|l| is_name(l) && !self.base.names.contains(l)) =>
            {
                Some(labels)
            }
            _ => None,
        }
    }

    /// The text of a Boolean expression. The recursion is as deep as the expression.
    fn truth(&mut self, expr: &Expr) -> Result<Piece, TooManyCases> {
        use BinaryOp as B;
        let s = self.base.specification;
        match expr {
            Expr::Const(value) => Ok(WORDS.truth(*value != 0)),
            Expr::Var(v, time) if s.variable(*v).domain == Domain::Bool => {
                Ok((Rank::Tight, self.variable(*v, *time)))
            }
            Expr::Unary(UnaryOp::Not, a) => {
                let a = self.truth(a)?;
                Ok(WORDS.not(a))
            }
            Expr::Binary(op @ (B::And | B::Or), ..) => {
                let (mut parts, mut open) = (Vec::new(), vec![expr]);
                while let Some(at) = open.pop() {
                    match at {
                        Expr::Binary(inner, a, b) if inner == op => open.extend([&**b, &**a]),
                        other => parts.push(self.truth(other)?),
                    }
                }
                Ok(match op {
                    B::And => WORDS.all(parts),
                    _ => WORDS.any(parts),
                })
            }
            Expr::Binary(B::Implies, a, b) => {
                let (a, b) = (self.truth(a)?, self.truth(b)?);
                let (a, b) = (at_least(a, Rank::Relation), at_least(b, Rank::Relation));
                Ok((Rank::Implies, format!("{a} -> {b}")))
            }
            Expr::Binary(op @ (B::Eq | B::Ne), a, b) if is_truth(s, a) && is_truth(s, b) => {
                let (a, b) = (self.truth(a)?, self.truth(b)?);
                let same = WORDS.iff(a, b);
                Ok(match op {
                    B::Ne => WORDS.not(same),
                    _ => same,
                })
            }
            Expr::If(c, a, b) if is_truth(s, a) && is_truth(s, b) => {
                let (c, a, b) = (self.truth(c)?, self.truth(a)?, self.truth(b)?);
                let yes = WORDS.all(vec![c.clone(), a]);
                let no = WORDS.all(vec![WORDS.not(c), b]);
                Ok(WORDS.any(vec![yes, no]))
            }
            _ => match self.comparison(expr) {
                Some(text) => Ok((Rank::Relation, text)),
                None => self.decompose(expr),
            },
        }
    }

    /// The text of a comparison; `None` if it has to be decomposed.
    fn comparison(&self, expr: &Expr) -> Option<String> {
        let Expr::Binary(op, a, b) = expr else {
            return None;
        };
        let sign = match op {
            BinaryOp::Eq => "=",
            BinaryOp::Ne => "!=",
            BinaryOp::Lt => "<",
            BinaryOp::Le => "<=",
            BinaryOp::Gt => ">",
            BinaryOp::Ge => ">=",
            _ => return None,
        };
        let equation = matches!(op, BinaryOp::Eq | BinaryOp::Ne);
        if equation && let Some((a, b)) = self.labelled(a, b).or_else(|| self.labelled(b, a)) {
            return Some(format!("{a} {sign} {b}"));
        }
        let (a, b) = (self.number(a)?, self.number(b)?);
        let (a, b) = (at_least(a, Rank::Sum), at_least(b, Rank::Sum));
        Some(format!("{a} {sign} {b}"))
    }

    /// The texts of a variable with labels and of a label or variable to compare it with.
    fn labelled(&self, a: &Expr, b: &Expr) -> Option<(String, String)> {
        let s = self.base.specification;
        let Expr::Var(v, time) = a else { return None };
        let labels = self.labels(s.variable(*v))?;
        let other = match b {
            Expr::Const(value) => labels.get(usize::try_from(*value).ok()?)?.clone(),
            Expr::Var(w, time) if self.labels(s.variable(*w)) == Some(labels) => {
                self.variable(*w, *time)
            }
            _ => return None,
        };
        Some((self.variable(*v, *time), other))
    }

    /// The text of a number; `None` if the language lacks one of its operators.
    fn number(&self, expr: &Expr) -> Option<Piece> {
        use BinaryOp as B;
        match expr {
            Expr::Const(value) => Some((Rank::Tight, number(*value))),
            Expr::Var(v, time) => {
                let variable = self.base.specification.variable(*v);
                let plain = variable.domain != Domain::Bool && self.labels(variable).is_none();
                plain.then(|| (Rank::Tight, self.variable(*v, *time)))
            }
            Expr::Unary(UnaryOp::Neg, a) => {
                let a = at_least(self.number(a)?, Rank::Tight);
                Some((Rank::Tight, format!("(-{a})")))
            }
            Expr::Binary(op @ (B::Add | B::Sub), a, b) => {
                let a = at_least(self.number(a)?, Rank::Sum);
                let b = at_least(self.number(b)?, Rank::Product);
                let sign = if *op == B::Add { "+" } else { "-" };
                // The blanks prevent `--`, which would begin a comment.
                Some((Rank::Sum, format!("{a} {sign} {b}")))
            }
            Expr::Binary(B::Mul, a, b) => {
                let a = at_least(self.number(a)?, Rank::Product);
                let b = at_least(self.number(b)?, Rank::Tight);
                Some((Rank::Product, format!("{a} * {b}")))
            }
            _ => None,
        }
    }

    fn variable(&self, v: VarId, time: Time) -> String {
        let name = &self.base.names[v.index()];
        match time {
            Time::Now => name.clone(),
            Time::Next => format!("next({name})"),
        }
    }

    /// Decomposes a truth value into tests of single variables.
    fn decompose(&mut self, expr: &Expr) -> Result<Piece, TooManyCases> {
        let gate = self.base.gates.formula(self.base.specification, expr)?;
        if self.base.gates.tree_size(gate) > MAX_SIZE {
            return Err(TooManyCases);
        }
        Ok(WORDS.gate(&self.base.gates, gate, &|shape| match shape {
            Shape::Within(v, time, low, high) => self.within(v, time, low, high),
            // Unreachable: only other writers create bits.
            _ => WORDS.truth(true),
        }))
    }

    fn within(&self, v: VarId, time: Time, low: i64, high: i64) -> Piece {
        let name = self.variable(v, time);
        let variable = self.base.specification.variable(v);
        if variable.domain == Domain::Bool {
            let yes = (Rank::Tight, name);
            return if low == 1 { yes } else { WORDS.not(yes) };
        }
        if let Some(labels) = self.labels(variable) {
            let cases = (low..=high).filter_map(|i| labels.get(i as usize));
            let cases = cases.map(|l| (Rank::Relation, format!("{name} = {l}")));
            return WORDS.any(cases.collect());
        }
        let test = |sign: &str, n: i64| (Rank::Relation, format!("{name} {sign} {}", number(n)));
        if low == high {
            return test("=", low);
        }
        let mut tests = Vec::new();
        if low != variable.domain.low() {
            tests.push(test(">=", low));
        }
        if high != variable.domain.high() {
            tests.push(test("<=", high));
        }
        WORDS.all(tests)
    }
}

fn number(value: i64) -> String {
    if value < 0 {
        format!("(-{})", value.unsigned_abs())
    } else {
        value.to_string()
    }
}
