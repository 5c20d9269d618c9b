//! Decomposes expressions for printing: reassembles chains that the builder balanced
//! (`a and b and c`) or expanded (`a < b < c`), and determines binding strengths.

use super::super::ast::{BinaryOp, Expr, ExprKind, Pattern, PatternKind};
use super::super::binds;
use super::super::build::{MAX_CHAIN, small_enough_for_the_middle};

/// A decomposed expression.
pub(super) enum Parts<'e> {
    /// A chain: operands, operators between them, binding strength of the chain, and minimum
    /// binding strength of its operands.
    Chain(Vec<&'e Expr>, Vec<&'static str>, u8, u8),
    /// Any other expression, with its binding strength.
    Single(u8),
}

/// Collects the operands of a chain that the builder balanced. Returns whether the tree is the one
/// that the builder would make from `count` operands.
fn halved<'e>(op: BinaryOp, e: &'e Expr, count: usize, operands: &mut Vec<&'e Expr>) -> bool {
    if count == 1 {
        operands.push(e);
        return true;
    }
    // The number of operands on the left is the largest power of two below the count.
    let left = count.next_power_of_two() / 2;
    match sides(e, op) {
        Some((a, b)) => halved(op, a, left, operands) && halved(op, b, count - left, operands),
        None => false,
    }
}

/// Returns the operands of `a op b`; `None` if the expression is not of this form. A chain of
/// comparisons does not count as `and`.
fn sides(e: &Expr, op: BinaryOp) -> Option<(&Expr, &Expr)> {
    match &e.kind {
        ExprKind::Binary(o, a, b) if *o == op && (op != BinaryOp::And || links(e).is_none()) => {
            Some((a, b))
        }
        _ => None,
    }
}

/// Returns the number of operands if all nested uses of the operator belong to one chain, which is
/// the maximum.
fn leaves(op: BinaryOp, e: &Expr) -> usize {
    sides(e, op).map_or(1, |(a, b)| leaves(op, a) + leaves(op, b))
}

/// Returns the comparisons of `a < b < c`, which the builder expands to `a < b and b < c`.
fn links(e: &Expr) -> Option<Vec<&Expr>> {
    fn collect<'e>(e: &'e Expr, list: &mut Vec<&'e Expr>) -> bool {
        match &e.kind {
            ExprKind::Binary(BinaryOp::And, a, b) => collect(a, list) && collect(b, list),
            ExprKind::Binary(op, a, _) if compares(*op) => {
                let goes_on = list.last().is_none_or(|last| match &last.kind {
                    ExprKind::Binary(_, _, middle) => {
                        middle == a && small_enough_for_the_middle(middle)
                    }
                    _ => false,
                });
                list.push(e);
                goes_on
            }
            _ => false,
        }
    }
    fn balanced(e: &Expr, count: usize) -> bool {
        let left = count.next_power_of_two() / 2;
        match &e.kind {
            ExprKind::Binary(BinaryOp::And, a, b) if count > 1 => {
                balanced(a, left) && balanced(b, count - left)
            }
            ExprKind::Binary(BinaryOp::And, ..) => false,
            _ => count == 1,
        }
    }
    if !matches!(e.kind, ExprKind::Binary(BinaryOp::And, ..)) {
        return None;
    }
    let mut list = Vec::new();
    (collect(e, &mut list) && balanced(e, list.len())).then_some(list)
}

fn compares(op: BinaryOp) -> bool {
    use BinaryOp::{Eq, Ge, Gt, Le, Lt, Ne};
    matches!(op, Eq | Ne | Lt | Le | Gt | Ge)
}

/// Splits a chain that groups to the left into its operands and operators, which are among `ops`.
fn to_the_left<'e>(e: &'e Expr, ops: &[BinaryOp]) -> (Vec<&'e Expr>, Vec<BinaryOp>) {
    let (mut operands, mut between) = (Vec::new(), Vec::new());
    let mut left = e;
    while let ExprKind::Binary(op, a, b) = &left.kind {
        if !ops.contains(op) || operands.len() + 2 > MAX_CHAIN {
            break;
        }
        operands.push(&**b);
        between.push(*op);
        left = a;
    }
    operands.push(left);
    operands.reverse();
    between.reverse();
    (operands, between)
}

fn chain_of(op: BinaryOp, e: &Expr, whole: u8, operand: u8) -> Parts<'_> {
    let mut operands = Vec::new();
    for count in (2..=leaves(op, e)).rev() {
        operands.clear();
        if halved(op, e, count, &mut operands) {
            break;
        }
    }
    let signs = vec![op.sign(); operands.len().saturating_sub(1)];
    Parts::Chain(operands, signs, whole, operand)
}

fn arithmetic<'e>(e: &'e Expr, ops: &[BinaryOp], whole: u8) -> Parts<'e> {
    let (operands, between) = to_the_left(e, ops);
    // The builder balances a chain of one associative operator.
    if between.iter().all(|op| *op == ops[0]) {
        return chain_of(ops[0], e, whole, whole + 1);
    }
    let signs = between.into_iter().map(BinaryOp::sign).collect();
    Parts::Chain(operands, signs, whole, whole + 1)
}

pub(super) fn parts(e: &Expr) -> Parts<'_> {
    use BinaryOp::{Add, And, Div, Eq, Ge, Gt, Iff, Implies, Le, Lt, Mod, Mul, Ne, Or, Sub, Xor};
    let (op, a, b) = match &e.kind {
        ExprKind::Binary(op, a, b) => (*op, a, b),
        ExprKind::Since(..) => {
            let mut operands = Vec::new();
            let mut left = e;
            while let ExprKind::Since(a, b) = &left.kind
                && operands.len() + 2 <= MAX_CHAIN
            {
                operands.push(&**b);
                left = a;
            }
            operands.push(left);
            operands.reverse();
            let signs = vec!["since"; operands.len() - 1];
            return Parts::Chain(operands, signs, binds::SINCE, binds::NEGATION);
        }
        ExprKind::Until(op, a, b) => {
            return Parts::Chain(vec![a, b], vec![op.word()], binds::PATTERN, binds::NEGATION);
        }
        kind => return Parts::Single(single(kind)),
    };
    match op {
        Iff => chain_of(Iff, e, binds::IFF, binds::DISJUNCTION),
        Implies => {
            let mut operands = vec![&**a];
            let mut right = &**b;
            while let ExprKind::Binary(Implies, a, b) = &right.kind
                && operands.len() + 2 <= MAX_CHAIN
            {
                operands.push(a);
                right = b;
            }
            operands.push(right);
            let signs = vec![op.sign(); operands.len() - 1];
            Parts::Chain(operands, signs, binds::IMPLICATION, binds::DISJUNCTION)
        }
        Or => chain_of(Or, e, binds::DISJUNCTION, binds::NEGATION),
        Xor => chain_of(Xor, e, binds::EXCLUSIVE, binds::NEGATION),
        And => match links(e) {
            None => chain_of(And, e, binds::CONJUNCTION, binds::NEGATION),
            Some(links) => {
                let (mut operands, mut signs) = (Vec::new(), Vec::new());
                for link in links {
                    if let ExprKind::Binary(op, a, b) = &link.kind {
                        if operands.is_empty() {
                            operands.push(&**a);
                        }
                        signs.push(op.sign());
                        operands.push(b);
                    }
                }
                Parts::Chain(operands, signs, binds::COMPARISON, binds::ADDITIVE)
            }
        },
        Add | Sub => arithmetic(e, &[Add, Sub], binds::ADDITIVE),
        Mul | Div | Mod => arithmetic(e, &[Mul, Div, Mod], binds::PRODUCT),
        Eq | Ne | Lt | Le | Gt | Ge => Parts::Chain(
            vec![a, b],
            vec![op.sign()],
            binds::COMPARISON,
            binds::ADDITIVE,
        ),
    }
}

/// Returns the binding strength of an expression other than a chain.
fn single(kind: &ExprKind) -> u8 {
    match kind {
        ExprKind::Pattern(Pattern {
            kind: PatternKind::Precedence(..) | PatternKind::Response(..),
            ..
        }) => binds::PATTERN,
        ExprKind::Member(..) | ExprKind::Within(..) => binds::COMPARISON,
        ExprKind::Next(a) if matches!(a.kind, ExprKind::Not(_)) => binds::NEGATION,
        ExprKind::Next(_) | ExprKind::Neg(_) => binds::SIGNED,
        ExprKind::Always(_)
        | ExprKind::Eventually(_)
        | ExprKind::If(..)
        | ExprKind::Quantifier(..)
        | ExprKind::Pattern(_)
        | ExprKind::Not(_)
        | ExprKind::Past(..) => binds::NEGATION,
        _ => binds::POSTFIX,
    }
}

/// Returns whether an expression extends as far to the right as possible.
pub(super) fn wide(kind: &ExprKind) -> bool {
    matches!(
        kind,
        ExprKind::Always(_)
            | ExprKind::Eventually(_)
            | ExprKind::If(..)
            | ExprKind::Quantifier(..)
            | ExprKind::Pattern(_)
    )
}

/// Returns the binding strength of an expression; the tightest if it has no operators.
pub(super) fn binding(e: &Expr) -> u8 {
    match parts(e) {
        Parts::Chain(_, _, whole, _) | Parts::Single(whole) => whole,
    }
}
