//! Formulas and plant numbers as C expressions.
//!
//! Integer expressions are computed in `int64_t`, exactly as in
//! [`gr1::eval`](linewright_core::gr1::eval); real ones in `double`, exactly as in
//! [`RealExpr::eval`]. Every operand that is not atomic is in parentheses, but chains of one
//! associative operator do not nest, because compilers limit the depth.
//!
//! Comparisons of equal operands and constant parts are simplified first, because compilers would
//! warn about them.

use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{BinaryOp, Expr, Time, UnaryOp, VarId, eval};
use linewright_language::contract::machine::{RealBinary, RealExpr, RealUnary};

/// C type and form of an expression, which determine how it can be used.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A name, a call or a literal: an `int64_t` that needs no parentheses.
    Atom,
    /// Arithmetic: an `int64_t`.
    Number,
    /// A comparison or a connective: an `int` that is 0 or 1.
    Truth,
}

struct Text {
    kind: Kind,
    text: String,
}

/// Returns the C text of an integer or Boolean expression. `name` returns the C text of a variable,
/// which must be an `int64_t` that needs no parentheses.
pub fn integer(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> String {
    emit(&simplify(expr), name).text
}

/// Returns the C text of an expression as a condition: an `int` that is 0 or 1.
pub fn truth(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> String {
    let Text { kind, text } = emit(&simplify(expr), name);
    match kind {
        Kind::Atom => format!("{text} != 0"),
        Kind::Number => format!("({text}) != 0"),
        Kind::Truth => text,
    }
}

/// Returns the C text of an `int64_t` literal.
pub fn literal(value: i64) -> String {
    if value == i64::MIN {
        "(-9223372036854775807LL - 1)".to_owned()
    } else if i32::try_from(value).is_ok() {
        value.to_string()
    } else {
        format!("{value}LL")
    }
}

/// Returns the C text of a `double` literal that reads back as the same number.
pub fn real_literal(value: f64) -> String {
    if value.is_nan() {
        "(double)NAN".to_owned()
    } else if value == f64::INFINITY {
        "HUGE_VAL".to_owned()
    } else if value == f64::NEG_INFINITY {
        "(-HUGE_VAL)".to_owned()
    } else if value.is_sign_negative() {
        format!("({value:?})")
    } else {
        format!("{value:?}")
    }
}

/// The runtime's header, which defines the operators that C lacks.
const RUNTIME: &str = include_str!("../../../../ffi/machine.h");

/// Returns the runtime's definitions of the operators that a text calls.
pub fn operators(text: &str) -> Vec<String> {
    let calls = |name: &str| text.contains(&format!("{name}("));
    let names = ["lw_abs", "lw_min", "lw_max", "lw_div", "lw_mod", "lw_int"];
    // `lw_mod` calls `lw_div`.
    let called = names
        .into_iter()
        .filter(|name| calls(name) || *name == "lw_div" && calls("lw_mod"));
    called
        .map(|name| operator(name).replace("LW_MAY_BE_UNUSED ", ""))
        .collect()
}

/// The definition of one operator in the runtime.
fn operator(name: &str) -> &'static str {
    let head = format!("LW_MAY_BE_UNUSED static int64_t {name}(");
    let definition = RUNTIME.find(&head).and_then(|start| {
        let rest = &RUNTIME[start..];
        Some(&rest[..rest.find("\n}\n")? + 2])
    });
    definition.expect("the runtime header does not define an operator that the generated code calls; please report this")
}

/// Simplifies constant parts of an expression. Arithmetic that could overflow an `int64_t` stays
/// unchanged.
fn simplify(expr: &Expr) -> Expr {
    let simple = match expr {
        Expr::Const(_) | Expr::Var(..) => expr.clone(),
        Expr::Unary(op, a) => Expr::Unary(*op, Box::new(simplify(a))),
        Expr::Binary(op, a, b) => {
            let (a, b) = (simplify(a), simplify(b));
            match (op, constant(&a), constant(&b)) {
                // A constant decides the result,
                (BinaryOp::And, Some(0), _) | (BinaryOp::And, _, Some(0)) => Expr::FALSE,
                (BinaryOp::Or, Some(x), _) | (BinaryOp::Or | BinaryOp::Implies, _, Some(x))
                    if x != 0 =>
                {
                    Expr::TRUE
                }
                (BinaryOp::Implies, Some(0), _) => Expr::TRUE,
                // or has no effect, so the other operand remains,
                (BinaryOp::And | BinaryOp::Or | BinaryOp::Implies, Some(_), _)
                | (BinaryOp::Eq, Some(1), _)
                    if is_truth(&b) =>
                {
                    b
                }
                (BinaryOp::And | BinaryOp::Or, _, Some(_)) | (BinaryOp::Eq, _, Some(1))
                    if is_truth(&a) =>
                {
                    a
                }
                // or negates the other operand.
                (BinaryOp::Implies, _, Some(_)) | (BinaryOp::Eq, _, Some(0)) if is_truth(&a) => {
                    a.not()
                }
                (BinaryOp::Eq, Some(0), _) if is_truth(&b) => b.not(),
                (BinaryOp::Eq | BinaryOp::Le | BinaryOp::Ge, _, _) if is_same(&a, &b) => Expr::TRUE,
                (BinaryOp::Ne | BinaryOp::Lt | BinaryOp::Gt, _, _) if is_same(&a, &b) => {
                    Expr::FALSE
                }
                _ => match comparison(*op).and_then(|_| decided(*op, &a, &b)) {
                    Some(holds) => Expr::Const(holds.into()),
                    None => Expr::binary(*op, a, b),
                },
            }
        }
        Expr::If(c, a, b) => {
            let (c, a, b) = (simplify(c), simplify(a), simplify(b));
            match constant(&c) {
                Some(0) => b,
                Some(_) => a,
                None => Expr::If(Box::new(c), Box::new(a), Box::new(b)),
            }
        }
    };
    let mut variables = false;
    simple.for_each_var(&mut |_, _| variables = true);
    // An expression without variables has an interval only if evaluating it neither overflows nor
    // divides by zero.
    if !variables && interval(&simple, &|_| Interval::BOOL).is_ok() {
        return Expr::Const(eval::eval(&simple, &[], &[]));
    }
    simple
}

/// Returns whether two expressions are equal but for the order of the operands of commutative
/// operators. Compilers warn of a comparison of such expressions.
fn is_same(a: &Expr, b: &Expr) -> bool {
    use BinaryOp as B;
    match (a, b) {
        (Expr::Unary(op, a), Expr::Unary(other, b)) => op == other && is_same(a, b),
        (Expr::Binary(op, a1, a2), Expr::Binary(other, b1, b2)) if op == other => {
            let commutes = matches!(
                op,
                B::Add | B::Mul | B::Min | B::Max | B::And | B::Or | B::Eq | B::Ne
            );
            (is_same(a1, b1) && is_same(a2, b2)) || (commutes && is_same(a1, b2) && is_same(a2, b1))
        }
        _ => a == b,
    }
}

/// Returns the result of a comparison that is the same for all values of the variables. Compilers
/// warn of some of these, such as of `if x then 1 else 2` and a number of more than 32 bits.
fn decided(op: BinaryOp, a: &Expr, b: &Expr) -> Option<bool> {
    const ANY: Interval = Interval {
        low: -(1 << 62),
        high: 1 << 62,
    };
    let (a, b) = (interval(a, &|_| ANY).ok()?, interval(b, &|_| ANY).ok()?);
    let (below, above) = (a.high < b.low, a.low > b.high);
    match op {
        BinaryOp::Eq if below || above => Some(false),
        BinaryOp::Ne if below || above => Some(true),
        BinaryOp::Lt | BinaryOp::Le if below => Some(true),
        BinaryOp::Lt | BinaryOp::Le if above => Some(false),
        BinaryOp::Gt | BinaryOp::Ge if below => Some(false),
        BinaryOp::Gt | BinaryOp::Ge if above => Some(true),
        _ => None,
    }
}

fn constant(expr: &Expr) -> Option<i64> {
    match expr {
        Expr::Const(c) => Some(*c),
        _ => None,
    }
}

/// Whether the expression's form makes it 0 or 1.
fn is_truth(expr: &Expr) -> bool {
    match expr {
        Expr::Const(c) => *c == 0 || *c == 1,
        Expr::Unary(op, _) => *op == UnaryOp::Not,
        Expr::Binary(op, ..) => comparison(*op).is_some() || connective(*op).is_some(),
        Expr::Var(..) | Expr::If(..) => false,
    }
}

fn comparison(op: BinaryOp) -> Option<&'static str> {
    Some(match op {
        BinaryOp::Eq => "==",
        BinaryOp::Ne => "!=",
        BinaryOp::Lt => "<",
        BinaryOp::Le => "<=",
        BinaryOp::Gt => ">",
        BinaryOp::Ge => ">=",
        _ => return None,
    })
}

fn connective(op: BinaryOp) -> Option<&'static str> {
    Some(match op {
        BinaryOp::And => "&&",
        BinaryOp::Or | BinaryOp::Implies => "||",
        _ => return None,
    })
}

fn emit(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> Text {
    let text = |kind, text| Text { kind, text };
    match expr {
        Expr::Const(c) if *c < 0 => text(Kind::Number, literal(*c)),
        Expr::Const(c) => text(Kind::Atom, literal(*c)),
        Expr::Var(v, t) => text(Kind::Atom, name(*v, *t)),
        Expr::Unary(UnaryOp::Not, a) => text(Kind::Truth, negated(a, name)),
        Expr::Unary(UnaryOp::Neg, a) => text(Kind::Number, format!("-{}", operand(a, name))),
        Expr::Unary(UnaryOp::Abs, a) => text(Kind::Atom, call("lw_abs", &[a], name)),
        Expr::Binary(op, a, b) => {
            if let Some(sign) = comparison(*op) {
                let constants = constant(a).is_some() || constant(b).is_some();
                let (a, b) = (compared(a, constants, name), compared(b, constants, name));
                return text(Kind::Truth, format!("{a} {sign} {b}"));
            }
            match op {
                BinaryOp::And => text(
                    Kind::Truth,
                    chain(expr, BinaryOp::And, "&&", name, condition),
                ),
                BinaryOp::Or => text(
                    Kind::Truth,
                    chain(expr, BinaryOp::Or, "||", name, condition),
                ),
                BinaryOp::Implies => text(
                    Kind::Truth,
                    format!("{} || {}", negated(a, name), condition(b, name)),
                ),
                BinaryOp::Add => text(Kind::Number, chain_left(expr, name)),
                BinaryOp::Sub => text(
                    Kind::Number,
                    format!("{} - {}", operand(a, name), operand(b, name)),
                ),
                BinaryOp::Mul => text(
                    Kind::Number,
                    format!("{} * {}", operand(a, name), operand(b, name)),
                ),
                BinaryOp::Div => text(Kind::Atom, call("lw_div", &[a, b], name)),
                BinaryOp::Mod => text(Kind::Atom, call("lw_mod", &[a, b], name)),
                BinaryOp::Min => text(Kind::Atom, call("lw_min", &[a, b], name)),
                _ => text(Kind::Atom, call("lw_max", &[a, b], name)),
            }
        }
        Expr::If(c, a, b) => {
            // A chain of conditions is not nested in parentheses, because compilers limit the
            // depth.
            let otherwise = match **b {
                Expr::If(..) => emit(b, name).text,
                _ => operand(b, name),
            };
            let (c, a) = (condition(c, name), operand(a, name));
            text(Kind::Number, format!("{c} ? {a} : {otherwise}"))
        }
    }
}

/// C text of an operand of arithmetic: an `int64_t`.
fn operand(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> String {
    let Text { kind, text } = emit(expr, name);
    match kind {
        Kind::Atom => text,
        Kind::Number => format!("({text})"),
        Kind::Truth => format!("lw_int({text})"),
    }
}

/// C text of an operand of a comparison. Compilers warn if a truth value is compared with a number.
fn compared(expr: &Expr, constants: bool, name: &impl Fn(VarId, Time) -> String) -> String {
    let Text { kind, text } = emit(expr, name);
    match kind {
        Kind::Atom => text,
        Kind::Truth if constants => format!("lw_int({text})"),
        Kind::Number | Kind::Truth => format!("({text})"),
    }
}

/// C text of an operand of a connective. Compilers warn if arithmetic is used as a truth value.
fn condition(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> String {
    let Text { kind, text } = emit(expr, name);
    match kind {
        Kind::Atom => match constant(expr) {
            Some(c) => i64::from(c != 0).to_string(),
            None => text,
        },
        Kind::Number => format!("(({text}) != 0)"),
        Kind::Truth => format!("({text})"),
    }
}

fn negated(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> String {
    format!("!{}", condition(expr, name))
}

fn call(function: &str, arguments: &[&Expr], name: &impl Fn(VarId, Time) -> String) -> String {
    let arguments: Vec<String> = arguments
        .iter()
        .map(|a| {
            let Text { kind, text } = emit(a, name);
            if kind == Kind::Truth {
                format!("lw_int({text})")
            } else {
                text
            }
        })
        .collect();
    format!("{function}({})", arguments.join(", "))
}

/// C text of a chain of one associative operator, without nesting.
fn chain<N: Fn(VarId, Time) -> String>(
    expr: &Expr,
    op: BinaryOp,
    sign: &str,
    name: &N,
    emit: fn(&Expr, &N) -> String,
) -> String {
    let mut operands = Vec::new();
    let mut stack = vec![expr];
    while let Some(expr) = stack.pop() {
        match expr {
            Expr::Binary(o, a, b) if *o == op => {
                stack.push(b);
                stack.push(a);
            }
            _ => operands.push(emit(expr, name)),
        }
    }
    operands.join(&format!(" {sign} "))
}

/// C text of a sum. Only left operands are flattened, because another order could overflow an
/// `int64_t`.
fn chain_left(expr: &Expr, name: &impl Fn(VarId, Time) -> String) -> String {
    let mut terms = Vec::new();
    let mut expr = expr;
    while let Expr::Binary(BinaryOp::Add, a, b) = expr {
        terms.push(operand(b, name));
        expr = a;
    }
    terms.push(operand(expr, name));
    terms.reverse();
    terms.join(" + ")
}

/// Returns the C text of a real expression over `properties` (doubles) and `values` (`int64_t`).
/// `wires` holds, for each wire, the C name of its index.
pub fn real(expr: &RealExpr, wires: &[String]) -> String {
    let real = |e: &RealExpr| real(e, wires);
    let zero = |e: &RealExpr| format!("({} == 0.0)", real(e));
    let nonzero = |e: &RealExpr| format!("({} != 0.0)", real(e));
    match expr {
        RealExpr::Number(x) => real_literal(*x),
        RealExpr::Property(i) => format!("properties[{i}]"),
        RealExpr::Wire(i) => format!("(double)values[{}]", wires[*i]),
        RealExpr::Unary(op, a) => match op {
            RealUnary::Not => format!("lw_truth({})", zero(a)),
            RealUnary::Neg => format!("(-{})", real(a)),
            RealUnary::Abs => format!("fabs({})", real(a)),
            RealUnary::Floor => format!("floor({})", real(a)),
            RealUnary::Ceil => format!("ceil({})", real(a)),
            RealUnary::Round => format!("round({})", real(a)),
        },
        RealExpr::Binary(op, a, b) => {
            let infix = |sign: &str| format!("({} {sign} {})", real(a), real(b));
            let truth = |sign: &str| format!("lw_truth({} {sign} {})", real(a), real(b));
            let call = |function: &str| format!("{function}({}, {})", real(a), real(b));
            match op {
                RealBinary::And => format!("lw_truth({} && {})", nonzero(a), nonzero(b)),
                RealBinary::Or => format!("lw_truth({} || {})", nonzero(a), nonzero(b)),
                RealBinary::Implies => format!("lw_truth({} || {})", zero(a), nonzero(b)),
                RealBinary::Eq => truth("=="),
                RealBinary::Ne => truth("!="),
                RealBinary::Lt => truth("<"),
                RealBinary::Le => truth("<="),
                RealBinary::Gt => truth(">"),
                RealBinary::Ge => truth(">="),
                RealBinary::Add => infix("+"),
                RealBinary::Sub => infix("-"),
                RealBinary::Mul => infix("*"),
                RealBinary::Div => infix("/"),
                RealBinary::Mod => call("lw_real_mod"),
                RealBinary::Min => call("fmin"),
                RealBinary::Max => call("fmax"),
            }
        }
        RealExpr::If(c, a, b) => format!("({} ? {} : {})", nonzero(c), real(a), real(b)),
    }
}
