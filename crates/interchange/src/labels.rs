//! Decides which enumerations keep their labels in a printed contract.
//!
//! In Linewright's language a label can only be compared with a value of its own enumeration. A
//! variable that occurs in arithmetic, or whose labels cannot be names, is printed as a number.

use linewright_core::gr1::{BinaryOp, Domain, Expr, Specification, VarId};

/// For each variable, the labels that its values are printed with.
///
/// `None` for a number or truth value, and for an enumeration that has to be printed as a number.
/// `is_free` returns whether a label is a valid name that nothing else has.
pub(super) fn kept<'s>(
    specification: &'s Specification,
    is_free: &dyn Fn(&str) -> bool,
) -> Vec<Option<&'s [String]>> {
    let variables = &specification.variables;
    let mut kept: Vec<Option<&[String]>> = variables
        .iter()
        .map(|v| match &v.domain {
            Domain::Enum { labels, .. } => Some(labels.as_slice()),
            _ => None,
        })
        .collect();
    // If a label occurs in two different enumerations, both are printed as numbers, so that a label
    // always means the same value.
    let all = kept.clone();
    let is_clear = |labels: &[String]| {
        labels.iter().all(|l| {
            let mut others = all.iter().flatten().filter(|other| **other != labels);
            is_free(l) && !others.any(|other| other.contains(l))
        })
    };
    for slot in &mut kept {
        *slot = slot.filter(|labels| is_clear(labels));
    }
    // A variable that is compared with one that is printed as a number has to be printed as a
    // number, too. Therefore repeat until nothing changes.
    loop {
        let before = kept.iter().flatten().count();
        for side in [&specification.assumptions, &specification.guarantees] {
            for formula in side.all() {
                count_with(&formula.expr, &mut kept);
            }
        }
        if kept.iter().flatten().count() == before {
            return kept;
        }
    }
}

/// Removes the labels of the variables that `expr` uses as numbers. The recursion is as deep as the
/// expression.
fn count_with(expr: &Expr, kept: &mut [Option<&[String]>]) {
    let label = |v: &VarId| kept[v.index()];
    match expr {
        Expr::Var(v, _) => kept[v.index()] = None,
        Expr::Const(_) => {}
        Expr::Binary(BinaryOp::Eq | BinaryOp::Ne, a, b) => {
            let compared = match (&**a, &**b) {
                (Expr::Var(v, _), Expr::Const(value)) | (Expr::Const(value), Expr::Var(v, _)) => {
                    label(v).is_some_and(|labels| nth(labels, *value).is_some())
                }
                (Expr::Var(v, _), Expr::Var(w, _)) => label(v).is_some() && label(v) == label(w),
                _ => false,
            };
            if !compared {
                count_with(a, kept);
                count_with(b, kept);
            }
        }
        Expr::Unary(_, a) => count_with(a, kept),
        Expr::Binary(_, a, b) => {
            count_with(a, kept);
            count_with(b, kept);
        }
        Expr::If(c, a, b) => {
            count_with(c, kept);
            count_with(a, kept);
            count_with(b, kept);
        }
    }
}

/// The label of `value`; `None` if no label has this index.
pub(super) fn nth(labels: &[String], value: i64) -> Option<&String> {
    labels.get(usize::try_from(value).ok()?)
}

/// The labels of `expr`; `None` unless it is a variable that is printed with labels.
pub(super) fn of<'s>(expr: &Expr, kept: &[Option<&'s [String]>]) -> Option<&'s [String]> {
    match expr {
        Expr::Var(v, _) => kept[v.index()],
        _ => None,
    }
}
