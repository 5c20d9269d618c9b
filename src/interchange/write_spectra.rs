//! Writes Spectra's language.
//!
//! Numbers, comparisons and sums are written as they are. What the language has not: `if`, `min`, `max`, `abs`, truth values as numbers;
//! a comparison with one of them is taken apart, value by value, by [`gates`](super::gates), and so is one with `/` or `mod`, whose
//! meaning for negative numbers differs between tools. Enumerations keep their labels where these can be names. A Moore machine is
//! written as one that answers after; see [`lower`](super::lower).

use super::gates::{Gate, Gates, Shape, TooMany, is_truth};
use super::lower;
use super::rename::renamed;
use super::spectra::is_keyword;
use crate::diagnostics::Diagnostic;
use crate::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, UnaryOp, VarId,
    Variable,
};
use std::fmt::Write as _;

/// A formula may have so many gates, written out.
const MAX_SIZE: u64 = 1 << 18;

pub(super) fn write(specification: &Specification) -> Result<String, Vec<Diagnostic>> {
    // A step put in front would have invariants to keep.
    let lowered = match specification.timing {
        Timing::Mealy => specification.clone(),
        Timing::Moore => lower::answering_second(&lower::without_invariants(specification)),
    };
    let sides = [&lowered.assumptions, &lowered.guarantees];
    let formulas: Vec<&Formula> = sides.into_iter().flat_map(Side::all).collect();
    let variables = lowered.variables.iter().map(|v| v.name.as_str());
    let wanted = variables.chain(formulas.iter().map(|f| f.name.as_str()));
    let mut names = renamed(wanted, "v_", is_name);
    let labels = names.split_off(lowered.variables.len());
    let mut writer = Writer {
        specification: &lowered,
        names: &names,
        gates: Gates::default(),
        findings: Vec::new(),
    };
    let text = writer.file(&labels);
    if writer.findings.is_empty() {
        Ok(text)
    } else {
        Err(writer.findings)
    }
}

fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !is_keyword(name)
}

/// How tightly a piece of text binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    Implies,
    Iff,
    Or,
    And,
    Relation,
    Sum,
    Product,
    Tight,
}

type Piece = (Rank, String);

struct Writer<'s> {
    specification: &'s Specification,
    names: &'s [String],
    gates: Gates,
    findings: Vec<Diagnostic>,
}

impl Writer<'_> {
    fn file(&mut self, labels: &[String]) -> String {
        let specification = self.specification;
        let stem = renamed([specification.name.as_str()], "s_", is_name);
        let stem = stem.first().map_or("specification", String::as_str);
        let mut text = format!("spec {stem}\n\n");
        for (index, (variable, name)) in specification.variables.iter().zip(self.names).enumerate()
        {
            let owner = match (variable.owner, variable.internal) {
                (Owner::Environment, _) => "env",
                (Owner::System, false) => "sys",
                (Owner::System, true) => "aux",
            };
            let of = self.type_of(VarId(index as u32));
            let _ = write!(text, "{owner} {of} {name};");
            if *name != variable.name {
                let was = super::names::one_line(&variable.name);
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
                    match self.truth(&formula.expr) {
                        Ok((_, body)) => {
                            let _ = write!(text, "\n{keyword} {name}:\n  {operator} ({body});\n");
                        }
                        Err(TooMany) => self.findings.push(TooMany::finding(formula)),
                    }
                }
            }
        }
        text
    }

    fn type_of(&self, v: VarId) -> String {
        let variable = self.specification.variable(v);
        match (&variable.domain, self.labels(variable)) {
            (Domain::Bool, _) => "boolean".to_owned(),
            (_, Some(labels)) => format!("{{{}}}", labels.join(", ")),
            (domain, None) => format!("Int({}..{})", number(domain.low()), number(domain.high())),
        }
    }

    /// The labels of a variable's values, if they can be written: no label may look like a variable.
    fn labels<'v>(&self, variable: &'v Variable) -> Option<&'v [String]> {
        match &variable.domain {
            Domain::Enum { labels, .. }
                if labels.iter().all(|l| is_name(l) && !self.names.contains(l)) =>
            {
                Some(labels)
            }
            _ => None,
        }
    }

    /// A truth value. The recursion is as deep as the formula.
    fn truth(&mut self, expr: &Expr) -> Result<Piece, TooMany> {
        use BinaryOp as B;
        let s = self.specification;
        match expr {
            Expr::Const(value) => Ok((Rank::Tight, (*value != 0).to_string())),
            Expr::Var(v, time) if s.variable(*v).domain == Domain::Bool => {
                Ok((Rank::Tight, self.variable(*v, *time)))
            }
            Expr::Unary(UnaryOp::Not, a) => {
                let a = self.truth(a)?;
                Ok(not(a))
            }
            Expr::Binary(op @ (B::And | B::Or), ..) => {
                let (mut parts, mut open) = (Vec::new(), vec![expr]);
                while let Some(at) = open.pop() {
                    match at {
                        Expr::Binary(inner, a, b) if inner == op => open.extend([&**b, &**a]),
                        other => parts.push(self.truth(other)?),
                    }
                }
                Ok(joined(*op, parts))
            }
            Expr::Binary(B::Implies, a, b) => {
                let (a, b) = (self.truth(a)?, self.truth(b)?);
                let (a, b) = (at_least(a, Rank::Iff), at_least(b, Rank::Iff));
                Ok((Rank::Implies, format!("{a} -> {b}")))
            }
            Expr::Binary(op @ (B::Eq | B::Ne), a, b) if is_truth(s, a) && is_truth(s, b) => {
                let (a, b) = (self.truth(a)?, self.truth(b)?);
                let (a, b) = (at_least(a, Rank::Or), at_least(b, Rank::Or));
                let same = (Rank::Iff, format!("{a} <-> {b}"));
                Ok(if *op == B::Ne { not(same) } else { same })
            }
            Expr::If(c, a, b) if is_truth(s, a) && is_truth(s, b) => {
                let (c, a, b) = (self.truth(c)?, self.truth(a)?, self.truth(b)?);
                let yes = joined(B::And, vec![c.clone(), a]);
                let no = joined(B::And, vec![not(c), b]);
                Ok(joined(B::Or, vec![yes, no]))
            }
            _ => match self.comparison(expr) {
                Some(text) => Ok((Rank::Relation, text)),
                None => self.apart(expr),
            },
        }
    }

    /// A comparison that can be written as it is.
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

    /// A variable with labels, and what it can be compared with by name.
    fn labelled(&self, a: &Expr, b: &Expr) -> Option<(String, String)> {
        let s = self.specification;
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

    /// A number that can be written as it is.
    fn number(&self, expr: &Expr) -> Option<Piece> {
        use BinaryOp as B;
        match expr {
            Expr::Const(value) => Some((Rank::Tight, number(*value))),
            Expr::Var(v, time) => {
                let variable = self.specification.variable(*v);
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
                // Two of the latter would begin a comment.
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
        let name = &self.names[v.index()];
        match time {
            Time::Now => name.clone(),
            Time::Next => format!("next({name})"),
        }
    }

    /// A truth value as tests of single variables.
    fn apart(&mut self, expr: &Expr) -> Result<Piece, TooMany> {
        let gate = self.gates.formula(self.specification, expr)?;
        if self.gates.tree_size(gate) > MAX_SIZE {
            return Err(TooMany);
        }
        Ok(self.gate(gate))
    }

    /// The recursion is as deep as the trees of cases.
    fn gate(&self, gate: Gate) -> Piece {
        match self.gates.shape(gate) {
            Shape::Const(value) => (Rank::Tight, value.to_string()),
            Shape::Not(a) => not(self.gate(a)),
            Shape::And(a, b) => joined(BinaryOp::And, vec![self.gate(a), self.gate(b)]),
            Shape::Or(a, b) => joined(BinaryOp::Or, vec![self.gate(a), self.gate(b)]),
            Shape::Xor(a, b) => {
                let (a, b) = (self.gate(a), self.gate(b));
                let (a, b) = (at_least(a, Rank::Or), at_least(b, Rank::Or));
                not((Rank::Iff, format!("{a} <-> {b}")))
            }
            Shape::Within(v, time, low, high) => self.within(v, time, low, high),
            // Bits are made by another writer only.
            Shape::Bit(..) => (Rank::Tight, String::new()),
        }
    }

    fn within(&self, v: VarId, time: Time, low: i64, high: i64) -> Piece {
        let name = self.variable(v, time);
        let variable = self.specification.variable(v);
        if variable.domain == Domain::Bool {
            let yes = (Rank::Tight, name);
            return if low == 1 { yes } else { not(yes) };
        }
        if let Some(labels) = self.labels(variable) {
            let cases = (low..=high).filter_map(|i| labels.get(i as usize));
            let cases = cases.map(|l| (Rank::Relation, format!("{name} = {l}")));
            return joined(BinaryOp::Or, cases.collect());
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
        joined(BinaryOp::And, tests)
    }
}

fn number(value: i64) -> String {
    if value < 0 {
        format!("(-{})", value.unsigned_abs())
    } else {
        value.to_string()
    }
}

/// The text, in parentheses where it would fall apart.
fn at_least((rank, text): Piece, wanted: Rank) -> String {
    if rank >= wanted {
        text
    } else {
        format!("({text})")
    }
}

fn not(piece: Piece) -> Piece {
    (Rank::Tight, format!("!{}", at_least(piece, Rank::Tight)))
}

fn joined(op: BinaryOp, parts: Vec<Piece>) -> Piece {
    let (rank, sign) = match op {
        BinaryOp::And => (Rank::And, " & "),
        _ => (Rank::Or, " | "),
    };
    if parts.len() == 1 {
        return parts
            .into_iter()
            .next()
            .unwrap_or((Rank::Tight, String::new()));
    }
    let parts: Vec<String> = parts
        .into_iter()
        .map(|p| {
            if p.0 == Rank::Tight || p.0 == Rank::Relation {
                p.1
            } else {
                at_least(p, rank)
            }
        })
        .collect();
    (rank, parts.join(sign))
}
