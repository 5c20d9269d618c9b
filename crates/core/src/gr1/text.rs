//! Formatting of expressions in the syntax of the contract language, with labels by name.

use super::{BinaryOp, Domain, Expr, Specification, Time, UnaryOp, Variable};

/// Binding strength, from the weakest to the strongest.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binds {
    Implication,
    Or,
    And,
    Not,
    Comparison,
    Sum,
    Product,
    Name,
}

/// Formats a boolean expression. In a contract with the same variables, the text parses to an equal
/// expression.
pub fn text(specification: &Specification, expr: &Expr) -> String {
    print(specification, expr, TRUTH).0
}

/// Formats a value for this variable, which can be one of another specification.
pub fn value(specification: &Specification, expr: &Expr, variable: &Variable) -> String {
    print(specification, expr, notation_for(variable)).0
}

/// Formats a boolean expression as an operand: in parentheses unless it is a name, a comparison or
/// a negation.
pub fn operand(specification: &Specification, expr: &Expr) -> String {
    let (text, binds) = print(specification, expr, TRUTH);
    if binds >= Binds::Not {
        text
    } else {
        format!("({text})")
    }
}

/// Notation of a constant.
#[derive(Clone, Copy)]
enum Notation<'s> {
    /// A label or truth value of this domain.
    Label(&'s Domain),
    /// A number with this unit.
    Unit(&'s str),
}

const TRUTH: Option<Notation<'static>> = Some(Notation::Label(&Domain::Bool));

fn print<'s>(s: &'s Specification, expr: &Expr, notation: Option<Notation<'s>>) -> (String, Binds) {
    use BinaryOp as B;
    let part = |expr: &Expr, least: Binds, notation: Option<Notation<'s>>| {
        let (text, binds) = print(s, expr, notation);
        if binds >= least {
            text
        } else {
            format!("({text})")
        }
    };
    let both = |a: &Expr, word: &str, b: &Expr, (binds, inner), notation: Option<Notation<'s>>| {
        let (a, b) = (part(a, inner, notation), part(b, inner, notation));
        (format!("{a} {word} {b}"), binds)
    };
    match expr {
        Expr::Const(value) => match notation {
            Some(Notation::Label(domain)) => (domain.show(*value), Binds::Name),
            Some(Notation::Unit(unit)) if *value >= 0 => (format!("{value} {unit}"), Binds::Name),
            _ if *value < 0 => (format!("(0 - {})", value.unsigned_abs()), Binds::Name),
            _ => (value.to_string(), Binds::Name),
        },
        Expr::Var(v, time) => {
            let name = &s.variable(*v).name;
            match time {
                Time::Now => (name.clone(), Binds::Name),
                Time::Next => (format!("next {name}"), Binds::Name),
            }
        }
        Expr::Unary(UnaryOp::Not, a) => {
            let inner = if matches!(**a, Expr::Var(..)) {
                Binds::Name
            } else {
                Binds::Implication
            };
            let text = part(a, inner, TRUTH);
            if inner == Binds::Name {
                (format!("not {text}"), Binds::Not)
            } else {
                (format!("not ({text})"), Binds::Not)
            }
        }
        Expr::Unary(UnaryOp::Neg, a) => (
            format!("0 - {}", part(a, Binds::Product, notation)),
            Binds::Sum,
        ),
        Expr::Unary(UnaryOp::Abs, a) => (
            format!("abs({})", part(a, Binds::Implication, notation)),
            Binds::Name,
        ),
        Expr::If(c, a, b) => {
            let own = if is_boolean(s, expr) {
                TRUTH
            } else {
                notation_of(s, expr)
            };
            let notation = notation.or(own);
            let c = part(c, Binds::Or, TRUTH);
            let (a, b) = (part(a, Binds::Or, notation), part(b, Binds::Or, notation));
            (format!("if {c} then {a} else {b}"), Binds::Implication)
        }
        Expr::Binary(op, a, b) => match op {
            B::And | B::Or => {
                let (word, binds) = match op {
                    B::And => ("and", Binds::And),
                    _ => ("or", Binds::Or),
                };
                let (a, b) = (part(a, binds, TRUTH), part(b, binds, TRUTH));
                (format!("{a} {word} {b}"), binds)
            }
            B::Implies => {
                let (a, b) = (part(a, Binds::Or, TRUTH), part(b, Binds::Or, TRUTH));
                (format!("{a} -> {b}"), Binds::Implication)
            }
            B::Eq | B::Ne if compares_booleans(s, a, b) => {
                let word = if *op == B::Eq { "<->" } else { "xor" };
                let (a, b) = (part(a, Binds::Not, TRUTH), part(b, Binds::Not, TRUTH));
                (format!("{a} {word} {b}"), Binds::Implication)
            }
            B::Eq | B::Ne | B::Lt | B::Le | B::Gt | B::Ge => {
                let word = match op {
                    B::Eq => "=",
                    B::Ne => "!=",
                    B::Lt => "<",
                    B::Le => "<=",
                    B::Gt => ">",
                    _ => ">=",
                };
                let (of_a, of_b) = (notation_of(s, a), notation_of(s, b));
                let a = part(a, Binds::Sum, of_b);
                let b = part(b, Binds::Sum, of_a);
                (format!("{a} {word} {b}"), Binds::Comparison)
            }
            B::Min | B::Max => {
                let word = if *op == B::Min { "min" } else { "max" };
                let a = part(a, Binds::Implication, notation);
                let b = part(b, Binds::Implication, notation);
                (format!("{word}({a}, {b})"), Binds::Name)
            }
            B::Add => both(a, "+", b, (Binds::Sum, Binds::Sum), notation),
            B::Sub => {
                let (a, b) = (
                    part(a, Binds::Sum, notation),
                    part(b, Binds::Product, notation),
                );
                (format!("{a} - {b}"), Binds::Sum)
            }
            B::Mul => both(a, "*", b, (Binds::Product, Binds::Name), None),
            B::Div => both(a, "/", b, (Binds::Product, Binds::Name), None),
            B::Mod => both(a, "mod", b, (Binds::Product, Binds::Name), None),
        },
    }
}

/// Returns the notation for the values of a variable; `None` for bare numbers.
fn notation_for(variable: &Variable) -> Option<Notation<'_>> {
    match &variable.domain {
        Domain::Range { .. } if variable.unit.is_empty() => None,
        Domain::Range { .. } => Some(Notation::Unit(&variable.unit)),
        domain => Some(Notation::Label(domain)),
    }
}

/// Returns the notation for constants that an expression is compared with; `None` for bare numbers.
fn notation_of<'s>(s: &'s Specification, expr: &Expr) -> Option<Notation<'s>> {
    use BinaryOp as B;
    match expr {
        Expr::Var(v, _) => notation_for(s.variable(*v)),
        Expr::If(_, a, b) | Expr::Binary(B::Add | B::Sub | B::Min | B::Max, a, b) => {
            notation_of(s, a).or_else(|| notation_of(s, b))
        }
        Expr::Unary(UnaryOp::Neg | UnaryOp::Abs, a) => notation_of(s, a),
        _ => None,
    }
}

/// Returns whether a comparison is written with `<->` or `xor` because its operands are boolean. A
/// variable and a constant are compared like other values: `b = true`.
fn compares_booleans(s: &Specification, a: &Expr, b: &Expr) -> bool {
    let plain = |e: &Expr| matches!(e, Expr::Var(..) | Expr::Const(_));
    match (is_boolean(s, a), is_boolean(s, b)) {
        (true, true) => true,
        // The operands have the same type, so the other one is a boolean constant.
        (true, false) | (false, true) => !(plain(a) && plain(b)),
        (false, false) => false,
    }
}

/// Returns whether an expression is boolean by its form; `false` for constants, whose type depends
/// on their context.
pub fn is_boolean(s: &Specification, expr: &Expr) -> bool {
    use BinaryOp as B;
    match expr {
        Expr::Const(_) => false,
        Expr::Var(v, _) => s.variable(*v).domain == Domain::Bool,
        Expr::Unary(op, _) => *op == UnaryOp::Not,
        // Both branches have the same type; one of them can be a constant.
        Expr::If(_, a, b) => is_boolean(s, a) || is_boolean(s, b),
        Expr::Binary(op, ..) => matches!(
            op,
            B::And | B::Or | B::Implies | B::Eq | B::Ne | B::Lt | B::Le | B::Gt | B::Ge
        ),
    }
}
