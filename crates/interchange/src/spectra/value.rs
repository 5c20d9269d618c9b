//! Values of formulas: typed expressions with their size and depth.

use linewright_core::gr1::{BinaryOp, Expr, UnaryOp};
use std::rc::Rc;

/// The type of an expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Int,
    /// An enumeration with these labels.
    Labels(Rc<[String]>),
    /// A single label, whose enumeration is not known yet.
    Label(String),
}

impl Kind {
    /// Whether the type is an enumeration; `false` for a single label.
    pub fn is_enumeration(&self) -> bool {
        matches!(self, Self::Labels(_))
    }

    /// Whether the type is an enumeration or a single label.
    pub fn is_of_enumeration(&self) -> bool {
        matches!(self, Self::Labels(_) | Self::Label(_))
    }

    /// The type in words, for messages.
    pub fn describe(&self) -> String {
        match self {
            Self::Bool => "a truth value".to_owned(),
            Self::Int => "a number".to_owned(),
            Self::Labels(labels) => {
                let shown: Vec<&str> = labels.iter().take(4).map(String::as_str).collect();
                let more = if labels.len() > 4 { ", ..." } else { "" };
                format!("one of {{{}{more}}}", shown.join(", "))
            }
            Self::Label(label) => format!("the value `{label}`"),
        }
    }
}

/// An expression with its type, number of nodes and depth.
#[derive(Debug, Clone)]
pub(super) struct Value {
    pub expr: Expr,
    pub kind: Kind,
    pub size: u64,
    pub depth: u32,
}

impl Value {
    pub fn leaf(expr: Expr, kind: Kind) -> Self {
        Self {
            expr,
            kind,
            size: 1,
            depth: 1,
        }
    }

    pub fn bool(value: bool) -> Self {
        Self::leaf(Expr::Const(i64::from(value)), Kind::Bool)
    }

    pub fn int(value: i64) -> Self {
        Self::leaf(Expr::Const(value), Kind::Int)
    }

    /// Measures and wraps an expression, which takes time linear in its size.
    pub fn of(expr: Expr, kind: Kind) -> Self {
        let (size, depth) = measure(&expr);
        Self {
            expr,
            kind,
            size,
            depth,
        }
    }

    /// The value, if the expression is constant.
    pub fn constant(&self) -> Option<i64> {
        match self.expr.simplify() {
            Expr::Const(value) => Some(value),
            _ => None,
        }
    }

    pub fn unary(self, op: UnaryOp) -> Self {
        Self {
            expr: Expr::Unary(op, Box::new(self.expr)),
            kind: self.kind,
            size: self.size + 1,
            depth: self.depth + 1,
        }
    }

    pub fn not(self) -> Self {
        match self.expr {
            Expr::Const(value) => Self::bool(value == 0),
            _ => self.unary(UnaryOp::Not),
        }
    }

    pub fn binary(op: BinaryOp, a: Self, b: Self) -> Self {
        use BinaryOp as B;
        let kind = match op {
            B::Add | B::Sub | B::Mul | B::Div | B::Mod | B::Min | B::Max => Kind::Int,
            _ => Kind::Bool,
        };
        Self {
            size: a.size.saturating_add(b.size).saturating_add(1),
            depth: a.depth.max(b.depth) + 1,
            expr: Expr::binary(op, a.expr, b.expr),
            kind,
        }
    }

    /// `if c then a else b`; its kind is that of `a`.
    pub fn choose(c: Self, a: Self, b: Self) -> Self {
        Self {
            size: (c.size.saturating_add(a.size)).saturating_add(b.size) + 1,
            depth: c.depth.max(a.depth).max(b.depth) + 1,
            kind: a.kind,
            expr: Expr::If(Box::new(c.expr), Box::new(a.expr), Box::new(b.expr)),
        }
    }

    /// Joins operands with an associative operator in a balanced tree.
    pub fn chain(op: BinaryOp, mut operands: Vec<Self>) -> Self {
        while operands.len() > 1 {
            let mut rest = operands.into_iter();
            operands = Vec::new();
            while let Some(a) = rest.next() {
                operands.push(match rest.next() {
                    Some(b) => Self::binary(op, a, b),
                    None => a,
                });
            }
        }
        operands.pop().unwrap_or_else(|| match op {
            BinaryOp::Or => Self::bool(false),
            _ => Self::bool(true),
        })
    }
}

/// Number of nodes and depth of an expression.
fn measure(expr: &Expr) -> (u64, u32) {
    match expr {
        Expr::Const(_) | Expr::Var(..) => (1, 1),
        Expr::Unary(_, a) => {
            let (size, depth) = measure(a);
            (size + 1, depth + 1)
        }
        Expr::Binary(_, a, b) => {
            let (a, b) = (measure(a), measure(b));
            (a.0 + b.0 + 1, a.1.max(b.1) + 1)
        }
        Expr::If(c, a, b) => {
            let (c, a, b) = (measure(c), measure(a), measure(b));
            (c.0 + a.0 + b.0 + 1, c.1.max(a.1).max(b.1) + 1)
        }
    }
}
