//! Builds types, expressions and formulas.

use super::super::ast::{BinaryOp, Domain, DomainKind, Expr, ExprKind, Name, Quantifier, UntilOp};
use super::super::binds;
use super::super::parser::Rule;
use super::pattern::until_op;
use super::{Builder, Children};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use pest::iterators::Pair;

impl Builder {
    pub(super) fn domain(&mut self, pair: Pair<'_, Rule>) -> Domain {
        // Expressions in a type are separate trees, even if an expression contains the type.
        // Therefore the depth is counted from 0.
        let level = std::mem::take(&mut self.level);
        let domain = self.domain_part(pair);
        self.level = level;
        domain
    }

    fn domain_part(&mut self, pair: Pair<'_, Rule>) -> Domain {
        let span = self.span(&pair);
        if pair.as_rule() == Rule::range {
            return self.range_domain(pair);
        }
        let mut children = Children::of(pair);
        let inner = children.next();
        let unit = children.take(Rule::unit);
        let kind = match inner.as_rule() {
            Rule::array_of => {
                let mut c = Children::of(inner);
                let length = self.expr(c.next());
                DomainKind::Array(length, Box::new(self.domain(c.next())))
            }
            Rule::labels => {
                DomainKind::Labels(Children::of(inner).rest().map(|n| self.name(&n)).collect())
            }
            Rule::record_of => {
                let members: Vec<_> = Children::of(inner).rest().collect();
                DomainKind::Record(members.into_iter().map(|m| self.member(m)).collect())
            }
            Rule::range => {
                let mut domain = self.range_domain(inner);
                if let Some(u) = unit
                    && let DomainKind::Range(_, _, written) = &mut domain.kind
                {
                    *written = Some(u.as_str().trim().to_owned());
                    domain.span = span;
                }
                return domain;
            }
            Rule::unit_type => DomainKind::Unit(inner.as_str().trim().to_owned()),
            _ => DomainKind::Named(self.name(&inner)),
        };
        Domain { kind, span }
    }

    fn member(&mut self, pair: Pair<'_, Rule>) -> (Name, Domain) {
        let mut c = Children::of(pair);
        (self.name(&c.next()), self.domain(c.next()))
    }

    pub(super) fn range_domain(&mut self, pair: Pair<'_, Rule>) -> Domain {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        let low = self.expr(c.next());
        let high = self.expr(c.next());
        Domain {
            kind: DomainKind::Range(low, high, None),
            span,
        }
    }

    /// Builds an expression. If its tree is deeper than [`MAX_TREE`], reports this and returns
    /// `false` instead, because later stages walk the tree by recursion and have the stack for this
    /// depth only.
    pub(super) fn expr(&mut self, pair: Pair<'_, Rule>) -> Expr {
        self.level += 1;
        let expr = self.part(pair);
        self.level -= 1;
        if self.level == 0 && deeper_than(&expr, MAX_TREE) {
            let span = expr.span;
            self.findings.push(
                Diagnostic::error(
                    codes::SYNTAX,
                    span,
                    format!("this formula is more than {MAX_TREE} operators deep"),
                )
                .with_help("give parts of it names with `define`"),
            );
            return make(ExprKind::Bool(false), span);
        }
        expr
    }

    fn part(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let rule = pair.as_rule();
        match rule {
            Rule::expression => self.patterned(pair),
            Rule::parenthesis | Rule::wide => self.expr(Children::of(pair).next()),
            Rule::past => self.past(pair),
            Rule::operators | Rule::disjunction | Rule::additive => self.operators(pair),
            Rule::negation => self.negation(pair),
            Rule::comparison => self.comparison(pair),
            Rule::signed => self.signed(pair),
            Rule::postfix => self.postfix(pair),
            Rule::conditional => {
                let span = self.span(&pair);
                let mut c = Children::of(pair);
                let (a, b, e) = (self.boxed(&mut c), self.boxed(&mut c), self.boxed(&mut c));
                make(ExprKind::If(a, b, e), span)
            }
            Rule::quantifier => {
                let span = self.span(&pair);
                let mut c = Children::of(pair);
                let kind = match c.next().as_str().trim() {
                    "forall" => Quantifier::Forall,
                    "exists" => Quantifier::Exists,
                    "count" => Quantifier::Count,
                    "sum" => Quantifier::Sum,
                    _ => Quantifier::Array,
                };
                let name = self.name(&c.next());
                let domain = Box::new(self.domain(c.next()));
                make(
                    ExprKind::Quantifier(kind, name, domain, self.boxed(&mut c)),
                    span,
                )
            }
            Rule::wide_always | Rule::wide_eventually | Rule::wide_never => self.wide(rule, pair),
            _ => self.atom(pair),
        }
    }

    pub(super) fn boxed(&mut self, c: &mut Children<'_>) -> Box<Expr> {
        Box::new(self.expr(c.next()))
    }

    /// Builds `a op b op c` according to the binding strength of each operator.
    fn operators(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let first = c.next();
        if c.pairs.peek().is_none() {
            return self.expr(first);
        }
        let first = self.placed(first);
        let mut rest = Vec::new();
        while let Some(op) = c.pairs.next() {
            rest.push((Infix::of(&op), self.placed(c.next())));
        }
        self.grouped(first, rest).expr
    }

    /// Splits operands into groups at the loosest operators, builds each group, and joins the
    /// groups.
    fn grouped(&mut self, first: PlacedExpr, rest: Vec<(Infix, PlacedExpr)>) -> PlacedExpr {
        let Some(loosest) = rest.iter().map(|(op, _)| op.binds()).min() else {
            return first;
        };
        let mut ops = Vec::new();
        let mut operands = Vec::new();
        let mut group = (first, Vec::new());
        for (op, operand) in rest {
            if op.binds() == loosest {
                let before = std::mem::replace(&mut group, (operand, Vec::new()));
                operands.push(self.grouped(before.0, before.1));
                ops.push(op);
            } else {
                group.1.push((op, operand));
            }
        }
        operands.push(self.grouped(group.0, group.1));
        self.joined(&ops, operands)
    }

    /// Joins operands of equally strong operators: implications group to the right, all others to
    /// the left. A chain of one associative operator becomes a balanced tree instead, which keeps
    /// long conjunctions and sums shallow.
    fn joined(&mut self, ops: &[Infix], mut operands: Vec<PlacedExpr>) -> PlacedExpr {
        if let Infix::Binary(op) = ops[0]
            && op.is_associative()
            && ops.iter().all(|o| *o == ops[0])
        {
            return balanced(op, operands);
        }
        self.limit(&mut operands);
        let joined = if ops[0] == Infix::Binary(BinaryOp::Implies) {
            let last_first = operands.into_iter().rev();
            last_first.reduce(|b, a| ops[0].join(a, b))
        } else {
            let mut ops = ops.iter();
            operands.into_iter().reduce(|a, b| {
                let op = ops
                    .next()
                    .expect("there is an operator between two operands");
                op.join(a, b)
            })
        };
        joined.unwrap_or_else(|| unreachable!("a chain has an operand"))
    }

    /// Builds an operand with its place.
    pub(super) fn placed(&mut self, pair: Pair<'_, Rule>) -> PlacedExpr {
        let place = self.span(&pair);
        let expr = self.expr(pair);
        PlacedExpr { expr, place }
    }

    /// Rejects chains of more than [`MAX_CHAIN`] operands, which would become deep trees. Used only
    /// for operators whose chains cannot be balanced.
    pub(super) fn limit(&mut self, operands: &mut Vec<PlacedExpr>) {
        if let Some(last) = operands.get(MAX_CHAIN) {
            self.findings.push(
                Diagnostic::error(
                    codes::SYNTAX,
                    last.expr.span,
                    format!("this chain of operators has more than {MAX_CHAIN} operands"),
                )
                .with_help("give parts of it names with `define`, or use `sum`"),
            );
            operands.truncate(1);
        }
    }

    fn many_prefixes(&mut self, span: Span) {
        self.findings.push(
            Diagnostic::error(
                codes::SYNTAX,
                span,
                format!("there are more than {MAX_PREFIXES} of these in a row"),
            )
            .with_help("remove those that cancel each other"),
        );
    }

    pub(super) fn negation(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let mut prefixes = Vec::new();
        while let Some(prefix) = c.take(Rule::prefix) {
            let span = self.span(&prefix);
            let inner = Children::of(prefix).next();
            prefixes.push((inner.as_rule(), inner.as_str().trim() == "GF", span));
        }
        if let Some((_, _, span)) = prefixes.get(MAX_PREFIXES) {
            self.many_prefixes(*span);
            prefixes.truncate(1);
        }
        if prefixes.is_empty() {
            return self.expr(c.next());
        }
        let PlacedExpr { expr, place } = self.placed(c.next());
        prefixes
            .into_iter()
            .rev()
            .fold(expr, |body, (rule, both, span)| {
                let whole = span.to(place);
                let body = Box::new(body);
                match rule {
                    Rule::not_op => make(ExprKind::Not(body), whole),
                    Rule::next_op => make(ExprKind::Next(body), whole),
                    Rule::tight_always if both => {
                        let inner = make(ExprKind::Eventually(body), whole);
                        make(ExprKind::Always(Box::new(inner)), whole)
                    }
                    Rule::tight_always => make(ExprKind::Always(body), whole),
                    _ => make(ExprKind::Eventually(body), whole),
                }
            })
    }

    pub(super) fn comparison(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let whole = pair.clone();
        let mut c = Children::of(pair);
        let first = c.next();
        if c.pairs.peek().is_none() {
            return self.expr(first);
        }
        let first = self.placed(first);
        if let Some(membership) = c.take(Rule::membership) {
            let first = first.expr;
            let span = self.span(&whole);
            let set = Children::of(membership).next();
            let mut inner = Children::of(set);
            if let Some(range) = inner.take(Rule::range) {
                let mut r = Children::of(range);
                let (low, high) = (self.boxed(&mut r), self.boxed(&mut r));
                return make(ExprKind::Within(Box::new(first), low, high), span);
            }
            let members: Vec<_> = inner.rest().collect();
            let members = members.into_iter().map(|m| self.expr(m)).collect();
            return make(ExprKind::Member(Box::new(first), members), span);
        }
        // `a < b < c` is `a < b and b < c`.
        let mut links: Vec<PlacedExpr> = Vec::new();
        let mut left = first;
        while let Some(op) = c.take(Rule::compare_op) {
            // The middle operand is compared twice, so it is copied. If chains nest, the number of
            // copies would grow exponentially.
            if !links.is_empty() && !small_enough_for_the_middle(&left.expr) {
                self.findings.push(
                    Diagnostic::error(
                        codes::SYNTAX,
                        left.expr.span,
                        "this operand is too large for the middle of a chain of comparisons",
                    )
                    .with_help("give it a name with `define`, or write two comparisons with `and`"),
                );
                return left.expr;
            }
            let right = self.placed(c.next());
            links.push(Infix::of(&op).join(left, right.clone()));
            left = right;
        }
        balanced(BinaryOp::And, links).expr
    }

    pub(super) fn signed(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let mut signs = Vec::new();
        while let Some(sign) = c.take(Rule::sign) {
            let span = self.span(&sign);
            signs.push((Children::of(sign).next().as_rule(), span));
        }
        if let Some((_, span)) = signs.get(MAX_PREFIXES) {
            self.many_prefixes(*span);
            signs.truncate(1);
        }
        if signs.is_empty() {
            return self.expr(c.next());
        }
        let PlacedExpr { expr, place } = self.placed(c.next());
        signs.into_iter().rev().fold(expr, |body, (rule, span)| {
            let whole = span.to(place);
            let body = Box::new(body);
            make(
                if rule == Rule::minus {
                    ExprKind::Neg(body)
                } else {
                    ExprKind::Next(body)
                },
                whole,
            )
        })
    }

    pub(super) fn postfix(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let mut c = Children::of(pair);
        let base = c.next();
        if c.pairs.peek().is_none() {
            return self.expr(base);
        }
        let PlacedExpr { mut expr, place } = self.placed(base);
        for (count, p) in c.rest().enumerate() {
            let span = place.to(self.span(&p));
            if count == MAX_PREFIXES {
                self.many_prefixes(span);
                break;
            }
            expr = match p.as_rule() {
                Rule::prime => make(ExprKind::Next(Box::new(expr)), span),
                Rule::field => {
                    let name = self.name(&Children::of(p).next());
                    make(ExprKind::Field(Box::new(expr), name), span)
                }
                _ => {
                    let index = self.expr(Children::of(p).next());
                    make(ExprKind::Index(Box::new(expr), Box::new(index)), span)
                }
            };
        }
        expr
    }

    pub(super) fn atom(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let pair = if pair.as_rule() == Rule::atom {
            Children::of(pair).next()
        } else {
            pair
        };
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::parenthesis => return self.expr(pair),
            Rule::boolean => ExprKind::Bool(pair.as_str().trim() == "true"),
            Rule::quantity => self.quantity(pair),
            Rule::list => {
                let members: Vec<_> = Children::of(pair).rest().collect();
                ExprKind::List(members.into_iter().map(|m| self.expr(m)).collect())
            }
            Rule::record => {
                let members: Vec<_> = Children::of(pair).rest().collect();
                ExprKind::Record(members.into_iter().map(|m| self.argument(m)).collect())
            }
            Rule::call => {
                let mut c = Children::of(pair);
                let name = self.name(&c.next());
                let arguments: Vec<_> = c.rest().collect();
                ExprKind::Call(name, arguments.into_iter().map(|a| self.expr(a)).collect())
            }
            _ => ExprKind::Path(Children::of(pair).rest().map(|n| self.name(&n)).collect()),
        };
        make(kind, span)
    }

    pub(super) fn quantity(&mut self, pair: Pair<'_, Rule>) -> ExprKind {
        let mut c = Children::of(pair);
        let number = c.next();
        let unit = c.take(Rule::unit).map(|u| u.as_str().trim().to_owned());
        match (number.as_rule(), unit) {
            (Rule::integer, None) => match self.integer(&number) {
                Some(value) => ExprKind::Int(value),
                None => ExprKind::Unknown,
            },
            (_, unit) => {
                let value: f64 = number.as_str().trim().parse().unwrap_or(f64::INFINITY);
                if !value.is_finite() {
                    let span = self.span(&number);
                    self.findings.push(
                        Diagnostic::error(codes::NUMBER_RANGE, span, "this number is too large")
                            .with_help("the largest number is about 1.8e308"),
                    );
                    return ExprKind::Unknown;
                }
                ExprKind::Quantity(value, unit.unwrap_or_default())
            }
        }
    }
}

/// Maximum number of operands in a chain that cannot be balanced.
pub(crate) const MAX_CHAIN: usize = 200;
/// Maximum number of consecutive prefixes (`not`, signs) or suffixes (indices, members, primes).
const MAX_PREFIXES: usize = 100;
/// Maximum depth of an expression's tree.
const MAX_TREE: usize = 256;
/// Maximum number of operators and operands in the middle of `a < b < c`.
const MAX_MIDDLE: usize = 64;

fn deeper_than(e: &Expr, levels: usize) -> bool {
    let mut open = vec![(e, 0)];
    while let Some((e, depth)) = open.pop() {
        if depth > levels {
            return true;
        }
        open.extend(e.children().into_iter().map(|c| (c, depth + 1)));
    }
    false
}

/// Returns whether an expression is small enough for the middle of `a < b < c`.
pub(crate) fn small_enough_for_the_middle(e: &Expr) -> bool {
    smaller_than(e, MAX_MIDDLE)
}

fn smaller_than(e: &Expr, nodes: usize) -> bool {
    let mut open = vec![e];
    let mut count = 0;
    while let Some(e) = open.pop() {
        count += 1;
        if count >= nodes {
            return false;
        }
        open.extend(e.children());
    }
    true
}

pub(super) fn make(kind: ExprKind, span: Span) -> Expr {
    Expr { kind, span }
}

/// An expression with its place. The place includes the brackets around the expression, because an
/// enclosing expression covers them, too.
#[derive(Clone)]
pub(super) struct PlacedExpr {
    pub expr: Expr,
    pub place: Span,
}

/// An infix operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Infix {
    Binary(BinaryOp),
    Since,
    Until(UntilOp),
}

impl Infix {
    fn of(pair: &Pair<'_, Rule>) -> Self {
        match pair.as_rule() {
            Rule::since_op => Self::Since,
            Rule::until_op => Self::Until(until_op(pair.as_str())),
            _ => Self::Binary(binary_op(pair.as_str())),
        }
    }

    fn binds(self) -> u8 {
        match self {
            Self::Binary(op) => binds::of(op),
            Self::Since | Self::Until(_) => binds::SINCE,
        }
    }

    fn join(self, a: PlacedExpr, b: PlacedExpr) -> PlacedExpr {
        let place = a.place.to(b.place);
        let (a, b) = (Box::new(a.expr), Box::new(b.expr));
        let kind = match self {
            Self::Binary(op) => ExprKind::Binary(op, a, b),
            Self::Since => ExprKind::Since(a, b),
            Self::Until(op) => ExprKind::Until(op, a, b),
        };
        PlacedExpr {
            expr: make(kind, place),
            place,
        }
    }
}

fn balanced(op: BinaryOp, mut operands: Vec<PlacedExpr>) -> PlacedExpr {
    while operands.len() > 1 {
        let mut halved = Vec::with_capacity(operands.len().div_ceil(2));
        let mut pairs = operands.into_iter();
        while let Some(a) = pairs.next() {
            halved.push(match pairs.next() {
                Some(b) => Infix::Binary(op).join(a, b),
                None => a,
            });
        }
        operands = halved;
    }
    operands
        .pop()
        .unwrap_or_else(|| unreachable!("a chain has an operand"))
}

pub(super) fn binary_op(text: &str) -> BinaryOp {
    match text.trim() {
        "<->" | "<=>" | "↔" | "⇔" | "iff" => BinaryOp::Iff,
        "->" | "=>" | "→" | "⇒" | "implies" => BinaryOp::Implies,
        "||" | "|" | "\\/" | "∨" | "or" => BinaryOp::Or,
        "xor" => BinaryOp::Xor,
        "&&" | "&" | "/\\" | "∧" | "and" => BinaryOp::And,
        "!=" | "≠" => BinaryOp::Ne,
        "<" => BinaryOp::Lt,
        "<=" | "≤" => BinaryOp::Le,
        ">" => BinaryOp::Gt,
        ">=" | "≥" => BinaryOp::Ge,
        "+" => BinaryOp::Add,
        "-" => BinaryOp::Sub,
        "*" => BinaryOp::Mul,
        "/" => BinaryOp::Div,
        "mod" => BinaryOp::Mod,
        "=" | "==" => BinaryOp::Eq,
        other => unreachable!("the grammar has no operator `{other}`"),
    }
}
