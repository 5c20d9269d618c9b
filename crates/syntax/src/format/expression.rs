//! Prints expressions, formulas and types.
//!
//! Brackets are printed where the grammar needs them to produce the same tree, and where mixed
//! operators are easily misread: around `and` within `or`, around the operand of `not` and `always`
//! if it has operators, and around an `if` within an `if`. Chains that the builder balanced
//! (`a and b and c`) or expanded (`a < b < c`) are reassembled before printing.

use super::super::ast::{
    BinaryOp, Domain, DomainKind, Expr, ExprKind, Pattern, PatternKind, Quantifier, Scope,
};
use super::super::binds;
use super::parts::{Parts, binding, parts, wide};
use super::printer::Printer;
use linewright_core::source::Span;

/// Binding strength above that of every expression. An operand that must have it is always put in
/// brackets.
const APART: u8 = u8::MAX;

/// What follows an expression. It decides whether the expression needs brackets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Continuation {
    /// A closing bracket, a keyword of a statement, or nothing.
    Nothing,
    /// An operator or a scope, which would become part of the operand of a prefix word such as
    /// `always`.
    Operator,
    /// `within 5 steps`, which would also become part of `once`.
    Within,
}

impl Printer<'_> {
    /// Prints an expression that is not followed by text that could become part of it.
    pub fn expression(&mut self, e: &Expr) {
        self.operand(e, binds::PATTERN, Continuation::Nothing);
    }

    /// Prints an expression where the grammar requires a minimum binding strength.
    pub fn operand(&mut self, e: &Expr, least: u8, behind: Continuation) {
        let parts = parts(e);
        let tight = match &parts {
            Parts::Chain(_, _, whole, _) | Parts::Single(whole) => *whole,
        };
        let open = match &e.kind {
            ExprKind::Past(_, _, None) => behind == Continuation::Within,
            kind => wide(kind) && behind != Continuation::Nothing,
        };
        self.before(e.span);
        if tight < least || open {
            self.put("(");
            self.parts(e, parts, Continuation::Nothing);
            self.put(")");
        } else {
            self.parts(e, parts, behind);
        }
    }

    /// Prints the operand of a prefix word. An operand with operators is put in brackets, because
    /// it would be easily misread without them.
    fn argument_of_word(&mut self, e: &Expr, behind: Continuation) {
        let brackets = match &e.kind {
            ExprKind::If(..) => true,
            _ => (binds::COMPARISON..=binds::PRODUCT).contains(&binding(e)),
        };
        let least = if brackets { APART } else { binds::NEGATION };
        self.operand(e, least, behind);
    }

    fn parts(&mut self, e: &Expr, parts: Parts<'_>, behind: Continuation) {
        match parts {
            Parts::Single(_) => self.single(e, behind),
            Parts::Chain(operands, signs, whole, least) => {
                let at_break = self.at_break();
                self.level(|p, level| {
                    let mut last: Option<Span> = None;
                    for (i, operand) in operands.iter().enumerate() {
                        if let Some(last) = last {
                            if i == 1 {
                                p.nest(at_break);
                            }
                            p.put(" ");
                            p.put(signs[i - 1]);
                            let forced = p.broken(last, operand.span);
                            p.gap(level, true, forced);
                        }
                        let ends = i + 1 == operands.len();
                        let behind = if ends { behind } else { Continuation::Operator };
                        // Two operands are easily misread without brackets: `-b` in `a - -b`, and
                        // an `if` among operators, whose end is not visible.
                        let apart = match operand.kind {
                            ExprKind::Neg(_) => whole >= binds::ADDITIVE && i > 0,
                            ExprKind::If(..) => true,
                            _ => false,
                        };
                        p.operand(operand, if apart { APART } else { least }, behind);
                        last = Some(operand.span);
                    }
                });
            }
        }
    }

    fn single(&mut self, e: &Expr, behind: Continuation) {
        match &e.kind {
            ExprKind::Unknown => {
                let written = self.number(e.span).map(str::to_owned);
                self.put(&written.unwrap_or_else(|| "0".to_owned()));
            }
            ExprKind::Bool(value) => self.put(if *value { "true" } else { "false" }),
            ExprKind::Int(value) => {
                let written = self.number(e.span).map(str::to_owned);
                self.put(&written.unwrap_or_else(|| value.to_string()));
            }
            ExprKind::Quantity(value, unit) => self.quantity(e.span, *value, unit),
            ExprKind::Path(names) => {
                let names: Vec<&str> = names.iter().map(|n| n.text.as_str()).collect();
                self.put(&names.join("."));
            }
            ExprKind::Index(base, index) => {
                self.base(base, !matches!(base.kind, ExprKind::Path(_)));
                self.put("[");
                self.expression(index);
                self.put("]");
            }
            ExprKind::Field(base, name) => {
                self.base(base, true);
                self.put(".");
                self.name(name);
            }
            ExprKind::Next(a) => {
                self.put("next ");
                let not = matches!(a.kind, ExprKind::Not(_));
                self.operand(a, if not { binds::NEGATION } else { binds::SIGNED }, behind);
            }
            ExprKind::Neg(a) => {
                self.put("-");
                let twice = matches!(a.kind, ExprKind::Neg(_));
                self.operand(a, if twice { APART } else { binds::SIGNED }, behind);
            }
            ExprKind::Not(a) => {
                self.put("not ");
                self.argument_of_word(a, behind);
            }
            ExprKind::Always(a) => {
                self.put("always ");
                self.argument_of_word(a, behind);
            }
            ExprKind::Eventually(a) => {
                self.put("eventually ");
                self.argument_of_word(a, behind);
            }
            ExprKind::Past(op, a, bound) => {
                self.put(op.word());
                self.put(" ");
                let within = bound.is_some();
                self.argument_of_word(a, if within { Continuation::Within } else { behind });
                self.bound(bound.as_deref());
            }
            ExprKind::Binary(..) | ExprKind::Since(..) | ExprKind::Until(..) => {
                unreachable!(
                    "the operators of a chain were printed one at a time; please report this"
                )
            }
            ExprKind::If(..) => self.ladder(e, behind),
            ExprKind::Quantifier(kind, name, domain, body) => {
                self.put(match kind {
                    Quantifier::Forall => "forall ",
                    Quantifier::Exists => "exists ",
                    Quantifier::Count => "count ",
                    Quantifier::Sum => "sum ",
                    Quantifier::Array => "array ",
                });
                self.name(name);
                self.put(" in ");
                self.domain(domain);
                self.put(":");
                let at_break = self.at_break();
                let forced = self.broken(domain.span, body.span);
                self.level(|p, level| {
                    if forced {
                        p.nest(at_break);
                        p.gap(level, true, true);
                    } else {
                        p.put(" ");
                    }
                    p.operand(body, binds::PATTERN, behind);
                });
            }
            ExprKind::Call(name, arguments) => {
                self.put(&name.text);
                self.sequence(
                    ["(", ")"],
                    name.span,
                    arguments,
                    |a| a.span,
                    Self::expression,
                );
            }
            ExprKind::List(items) => {
                let open = at_start(e.span);
                self.sequence(["[", "]"], open, items, |a| a.span, Self::expression);
            }
            ExprKind::Record(items) => {
                let open = at_start(e.span);
                self.sequence(["{", "}"], open, items, |a| a.name.span, Self::argument);
            }
            ExprKind::Member(a, items) => {
                self.operand(a, binds::ADDITIVE, Continuation::Operator);
                self.put(" in ");
                self.sequence(["{", "}"], a.span, items, |a| a.span, Self::expression);
            }
            ExprKind::Within(a, low, high) => {
                self.operand(a, binds::ADDITIVE, Continuation::Operator);
                self.put(" in ");
                // A brace here would begin a set of values, so a bound that begins with one is put
                // in brackets.
                if begins_with_brace(low) {
                    self.operand(low, APART, Continuation::Nothing);
                    self.put("..");
                    self.limit(high, false);
                } else {
                    self.limits(low, high, false);
                }
            }
            ExprKind::Pattern(pattern) => self.pattern(pattern, behind),
        }
    }

    /// Prints the expression before an index or a member, in brackets if necessary.
    fn base(&mut self, base: &Expr, paths_apart: bool) {
        let plain = match &base.kind {
            ExprKind::Index(..) | ExprKind::Field(..) | ExprKind::Call(..) | ExprKind::List(_) => {
                true
            }
            ExprKind::Path(_) => !paths_apart,
            _ => false,
        };
        self.operand(base, if plain { 0 } else { APART }, Continuation::Operator);
    }

    /// Returns a number as the author wrote it, without its unit.
    fn number(&self, span: Span) -> Option<&str> {
        let text = self.written(span)?;
        let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
        let text = &text[..end.unwrap_or(text.len())];
        // The unit can follow the number directly, as in `1e3mm`.
        let end = text
            .char_indices()
            .rev()
            .map(|(i, c)| i + c.len_utf8())
            .find(|end| {
                text[..*end].ends_with(|c: char| c.is_ascii_digit())
                    && text[..*end].parse::<f64>().is_ok()
            });
        end.map(|end| &text[..end])
    }

    fn quantity(&mut self, span: Span, value: f64, unit: &str) {
        let number = match self.number(span) {
            Some(written) => written.to_owned(),
            None if !unit.is_empty() && value.fract() == 0.0 && value < 1e15 => {
                format!("{value:.0}")
            }
            None => format!("{value:?}"),
        };
        self.put(&number);
        if !unit.is_empty() {
            self.put(" ");
            self.put(unit);
        }
    }

    /// Prints `if a then b else if c then d else e`.
    fn ladder(&mut self, e: &Expr, behind: Continuation) {
        let at_break = self.at_break();
        self.level(|p, level| {
            p.nest(at_break);
            let begun = p.ladder_begins(level);
            let mut rest = e;
            while let ExprKind::If(condition, then, otherwise) = &rest.kind {
                p.before(rest.span);
                p.put("if ");
                p.expression(condition);
                p.put(" then");
                p.level(|p, inner| {
                    let forced = p.broken(condition.span, then.span);
                    p.nest += 1;
                    p.gap(inner, true, forced);
                    let again = matches!(then.kind, ExprKind::If(..));
                    p.operand(then, if again { APART } else { 0 }, Continuation::Nothing);
                });
                let forced = p.broken(then.span, otherwise.span);
                p.gap(level, true, forced);
                p.put("else ");
                rest = otherwise;
            }
            p.operand(rest, binds::PATTERN, behind);
            p.ladder_ends(begun);
        });
    }

    fn bound(&mut self, bound: Option<&Expr>) {
        if let Some(bound) = bound {
            self.put(" within ");
            self.operand(bound, binds::ADDITIVE, Continuation::Nothing);
            let one = matches!(bound.kind, ExprKind::Int(1));
            self.put(if one { " step" } else { " steps" });
        }
    }

    fn pattern(&mut self, pattern: &Pattern, behind: Continuation) {
        let after = match (&pattern.bound, &pattern.scope) {
            (Some(_), _) => Continuation::Within,
            (None, Scope::Globally) => behind,
            _ => Continuation::Operator,
        };
        let at_break = self.at_break();
        self.level(|p, level| {
            let outer = p.nest;
            let (word, last) = match &pattern.kind {
                PatternKind::Absence(a) => ("never ", a),
                PatternKind::Existence(a) => ("eventually ", a),
                PatternKind::Universality(a) => ("always ", a),
                PatternKind::Precedence(_, b) => (" precedes", b),
                PatternKind::Response(_, b) => (" responds to", b),
            };
            if let PatternKind::Precedence(a, b) | PatternKind::Response(a, b) = &pattern.kind {
                p.operand(a, binds::NEGATION, Continuation::Operator);
                p.put(word);
                p.nest(at_break);
                let forced = p.broken(a.span, b.span);
                p.gap(level, true, forced);
                p.operand(b, binds::NEGATION, after);
            } else {
                p.put(word);
                p.argument_of_word(last, after);
            }
            p.bound(pattern.bound.as_deref());
            let (word, first, second) = match &pattern.scope {
                Scope::Globally => return,
                Scope::Before(a) => ("before ", a, None),
                Scope::After(a) => ("after ", a, None),
                Scope::Between(a, b) => ("between ", a, Some((" and ", b))),
                Scope::AfterUntil(a, b) => ("after ", a, Some((" until ", b))),
            };
            p.nest = outer;
            p.nest(at_break);
            let forced = p.broken(last.span, first.span);
            p.gap(level, true, forced);
            p.put(word);
            let ends = if second.is_some() {
                Continuation::Operator
            } else {
                behind
            };
            p.operand(first, binds::NEGATION, ends);
            if let Some((word, second)) = second {
                p.put(word);
                p.operand(second, binds::NEGATION, behind);
            }
        });
    }

    // ---- types ----------------------------------------------------------------------------------

    /// Prints a type.
    pub fn domain(&mut self, domain: &Domain) {
        self.before(domain.span);
        match &domain.kind {
            DomainKind::Labels(names) => {
                let open = at_start(domain.span);
                self.sequence(["{", "}"], open, names, |n| n.span, Self::name);
            }
            DomainKind::Range(low, high, unit) => {
                self.limits(low, high, unit.is_some());
                if let Some(unit) = unit {
                    self.put(" ");
                    self.put(unit);
                }
            }
            DomainKind::Record(members) => {
                self.put("record ");
                let open = at_start(domain.span);
                self.sequence(
                    ["{", "}"],
                    open,
                    members,
                    |(name, domain)| name.span.to(domain.span),
                    |p, (name, domain)| {
                        p.name(name);
                        p.put(": ");
                        p.domain(domain);
                    },
                );
            }
            DomainKind::Array(length, domain) => {
                self.put("array[");
                self.operand(length, binds::ADDITIVE, Continuation::Nothing);
                self.put("] of ");
                self.domain(domain);
            }
            DomainKind::Named(name) => self.name(name),
            DomainKind::Unit(unit) => self.put(unit),
        }
    }

    /// Prints `0..n-1`. If `unit` is true, a unit follows. It must not become the unit of the last
    /// number.
    fn limits(&mut self, low: &Expr, high: &Expr, unit: bool) {
        self.limit(low, false);
        self.put("..");
        self.limit(high, unit);
    }

    fn limit(&mut self, e: &Expr, unit: bool) {
        let plain = |e: &Expr| matches!(&e.kind, ExprKind::Path(_) | ExprKind::Int(_));
        match &e.kind {
            ExprKind::Binary(op @ (BinaryOp::Add | BinaryOp::Sub), a, b)
                if plain(a) && plain(b) =>
            {
                self.put(if unit { "(" } else { "" });
                self.operand(a, binds::PRODUCT, Continuation::Operator);
                self.put(op.sign());
                self.operand(b, binds::PRODUCT, Continuation::Operator);
                self.put(if unit { ")" } else { "" });
            }
            ExprKind::Path(_) | ExprKind::Call(..) | ExprKind::Index(..) | ExprKind::Field(..) => {
                self.operand(e, binds::ADDITIVE, Continuation::Operator);
            }
            _ => self.operand(
                e,
                if unit { APART } else { binds::ADDITIVE },
                Continuation::Operator,
            ),
        }
    }
}

/// Returns whether the text of an expression begins with the brace of a record.
fn begins_with_brace(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Record(_) => true,
        ExprKind::Binary(_, a, _) | ExprKind::Index(a, _) | ExprKind::Field(a, _) => {
            begins_with_brace(a)
        }
        _ => false,
    }
}

fn at_start(span: Span) -> Span {
    Span {
        end: span.start,
        ..span
    }
}
