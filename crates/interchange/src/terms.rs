//! Formulas under construction, as shared nodes that store the size and depth of their tree.
//!
//! A file can recall a memory cell a thousand times in one line, or join ten thousand operands with
//! `&`, but later stages traverse the tree of an [`Expr`] recursively. Therefore operands are
//! shared nodes, the size of the tree is known before it is built, and a chain of one associative
//! operator becomes a balanced tree of logarithmic depth.

use linewright_core::gr1::{BinaryOp, Expr, Time, UnaryOp, VarId};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum depth of a formula with balanced chains, the same as in Linewright's own language.
pub(super) const MAX_DEPTH: u32 = 500;
/// Maximum number of operators and operands of a single expanded formula.
const MAX_SIZE: u64 = 1 << 20;

/// The type of a node's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Int,
}

/// Index of a node in a [`Terms`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Term(u32);

#[derive(Debug, Clone, Copy)]
enum Shape {
    Const(i64),
    Var(VarId, Time),
    Unary(UnaryOp, Term),
    Binary(BinaryOp, Term, Term),
}

#[derive(Debug, Clone, Copy)]
struct Node {
    shape: Shape,
    kind: Kind,
    /// Number of nodes of the expanded tree.
    size: u64,
    /// The number of operands in the chain of operators that ends at this node (`links`), and the
    /// depth of the deepest operand (`below`).
    links: u64,
    below: u32,
    /// Whether a current value occurs in the tree (`now`), and whether a next value does (`next`).
    now: bool,
    next: bool,
}

impl Node {
    fn depth(&self) -> u32 {
        self.below + u64::BITS - (self.links.max(1) - 1).leading_zeros()
    }
}

/// The limit that the tree of a formula exceeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TermLimit {
    Deep,
    Large,
}

/// An arena of nodes.
#[derive(Debug, Default)]
pub(super) struct Terms {
    nodes: Vec<Node>,
}

impl Terms {
    /// Removes all nodes; existing terms become invalid.
    pub fn clear(&mut self) {
        self.nodes.clear();
    }

    fn node(&self, term: Term) -> &Node {
        &self.nodes[term.0 as usize]
    }

    fn push(&mut self, node: Node) -> Term {
        self.nodes.push(node);
        Term(self.nodes.len() as u32 - 1)
    }

    fn leaf(&mut self, shape: Shape, kind: Kind) -> Term {
        let time = match shape {
            Shape::Var(_, time) => Some(time),
            _ => None,
        };
        self.push(Node {
            shape,
            kind,
            size: 1,
            links: 1,
            below: 1,
            now: time == Some(Time::Now),
            next: time == Some(Time::Next),
        })
    }

    pub fn bool(&mut self, value: bool) -> Term {
        self.leaf(Shape::Const(i64::from(value)), Kind::Bool)
    }

    pub fn int(&mut self, value: i64) -> Term {
        self.leaf(Shape::Const(value), Kind::Int)
    }

    pub fn var(&mut self, var: VarId, time: Time, kind: Kind) -> Term {
        self.leaf(Shape::Var(var, time), kind)
    }

    pub fn kind(&self, term: Term) -> Kind {
        self.node(term).kind
    }

    /// Whether the term contains a next value.
    pub fn has_next(&self, term: Term) -> bool {
        self.node(term).next
    }

    /// The value, if the term is a constant.
    pub fn constant(&self, term: Term) -> Option<i64> {
        match self.node(term).shape {
            Shape::Const(value) => Some(value),
            _ => None,
        }
    }

    /// Whether the term is a variable.
    pub fn is_var(&self, term: Term) -> bool {
        matches!(self.node(term).shape, Shape::Var(..))
    }

    /// The truth value as the number 0 or 1.
    pub fn as_number(&mut self, term: Term) -> Term {
        let node = *self.node(term);
        self.push(Node {
            kind: Kind::Int,
            ..node
        })
    }

    pub fn not(&mut self, a: Term) -> Term {
        match self.node(a).shape {
            Shape::Const(value) => self.bool(value == 0),
            Shape::Unary(UnaryOp::Not, inner) => inner,
            _ => self.unary(UnaryOp::Not, a, Kind::Bool),
        }
    }

    fn unary(&mut self, op: UnaryOp, a: Term, kind: Kind) -> Term {
        let below = *self.node(a);
        self.push(Node {
            shape: Shape::Unary(op, a),
            kind,
            size: below.size.saturating_add(1),
            links: 1,
            below: below.depth().saturating_add(1),
            ..below
        })
    }

    /// Applies a binary operator. Constant truth values are folded, since most carries of an adder
    /// that is written bit by bit are constants.
    pub fn binary(&mut self, op: BinaryOp, a: Term, b: Term) -> Term {
        use BinaryOp as B;
        if self.kind(a) == Kind::Bool {
            match (op, self.constant(a), self.constant(b)) {
                (B::And, Some(0), _) | (B::Or, Some(1), _) => return a,
                (B::And, _, Some(0)) | (B::Or | B::Implies, _, Some(1)) => return b,
                (B::And | B::Eq | B::Implies, Some(1), _) | (B::Or | B::Ne, Some(0), _) => {
                    return b;
                }
                (B::And | B::Eq, _, Some(1)) | (B::Or | B::Ne, _, Some(0)) => return a,
                (B::Implies, Some(0), _) => return self.bool(true),
                (B::Implies | B::Eq, _, Some(0)) | (B::Ne, _, Some(1)) => return self.not(a),
                (B::Eq, Some(0), _) | (B::Ne, Some(1), _) => return self.not(b),
                _ => {}
            }
        }
        let kind = match op {
            B::Add | B::Sub | B::Mul | B::Div | B::Mod | B::Min | B::Max => Kind::Int,
            _ => Kind::Bool,
        };
        let (x, y) = (*self.node(a), *self.node(b));
        let shape = Shape::Binary(op, a, b);
        // If an operand continues the chain of this node, its operands count as operands of this
        // node.
        let part = |node: &Node| match node.shape {
            Shape::Binary(inner, p, _) if chains(op, self.kind(a), inner, self.kind(p)) => {
                (node.links, node.below)
            }
            _ => (1, node.depth()),
        };
        let ((l, m), (n, o)) = (part(&x), part(&y));
        self.push(Node {
            shape,
            kind,
            size: x.size.saturating_add(y.size).saturating_add(1),
            links: l.saturating_add(n),
            below: m.max(o),
            now: x.now || y.now,
            next: x.next || y.next,
        })
    }

    /// The term with next values in place of current ones.
    pub fn primed(&mut self, term: Term) -> Term {
        if !self.node(term).now {
            return term;
        }
        // Nodes follow their operands, so copying them in order needs no recursion.
        let (mut needed, mut open) = (BTreeSet::new(), vec![term.0]);
        while let Some(index) = open.pop() {
            if !needed.insert(index) {
                continue;
            }
            match self.nodes[index as usize].shape {
                Shape::Unary(_, a) => open.push(a.0),
                Shape::Binary(_, a, b) => open.extend([a.0, b.0]),
                _ => {}
            }
        }
        let mut copies: BTreeMap<u32, Term> = BTreeMap::new();
        for index in needed {
            let mut node = self.nodes[index as usize];
            (node.now, node.next) = (false, node.now || node.next);
            let copy = |t: Term| copies.get(&t.0).copied().unwrap_or(t);
            node.shape = match node.shape {
                Shape::Var(v, _) => Shape::Var(v, Time::Next),
                Shape::Unary(op, a) => Shape::Unary(op, copy(a)),
                Shape::Binary(op, a, b) => Shape::Binary(op, copy(a), copy(b)),
                constant @ Shape::Const(_) => constant,
            };
            let copy = self.push(node);
            copies.insert(index, copy);
        }
        copies.get(&term.0).copied().unwrap_or(term)
    }

    /// The operands of a chain, from left to right.
    fn links(&self, op: BinaryOp, operands: Kind, term: Term) -> Vec<Term> {
        let (mut found, mut open) = (Vec::new(), vec![term]);
        while let Some(term) = open.pop() {
            match self.node(term).shape {
                Shape::Binary(inner, a, b) if chains(op, operands, inner, self.kind(a)) => {
                    open.push(b);
                    open.push(a);
                }
                _ => found.push(term),
            }
        }
        found
    }

    /// Number of nodes of the expanded tree.
    pub fn size(&self, term: Term) -> u64 {
        self.node(term).size
    }

    /// Builds the tree, unless it exceeds a limit.
    pub fn tree(&self, term: Term) -> Result<Expr, TermLimit> {
        let node = self.node(term);
        if node.depth() > MAX_DEPTH {
            return Err(TermLimit::Deep);
        }
        if node.size > MAX_SIZE {
            return Err(TermLimit::Large);
        }
        Ok(self.build(term))
    }

    /// Builds the tree; the recursion is as deep as the tree, whose depth was checked.
    fn build(&self, term: Term) -> Expr {
        match self.node(term).shape {
            Shape::Const(value) => Expr::Const(value),
            Shape::Var(v, time) => Expr::Var(v, time),
            Shape::Unary(op, a) => Expr::Unary(op, Box::new(self.build(a))),
            Shape::Binary(op, a, b) => {
                let operands = self.kind(a);
                if chains(op, operands, op, operands) {
                    balanced(
                        op,
                        self.links(op, operands, term)
                            .into_iter()
                            .map(|t| self.build(t))
                            .collect(),
                    )
                } else {
                    Expr::binary(op, self.build(a), self.build(b))
                }
            }
        }
    }
}

/// Whether `(p inner q) outer r` is a chain of one associative operator. `=` and `!=` are
/// associative for truth values only.
fn chains(outer: BinaryOp, operands: Kind, inner: BinaryOp, inner_operands: Kind) -> bool {
    use BinaryOp as B;
    outer == inner
        && match outer {
            B::And | B::Or | B::Add => true,
            B::Eq | B::Ne => operands == Kind::Bool && inner_operands == Kind::Bool,
            _ => false,
        }
}

/// Joins operands with an associative operator in a balanced tree that keeps their order.
pub(super) fn balanced(op: BinaryOp, mut operands: Vec<Expr>) -> Expr {
    while operands.len() > 1 {
        let mut rest = operands.into_iter();
        operands = Vec::new();
        while let Some(a) = rest.next() {
            operands.push(match rest.next() {
                Some(b) => Expr::binary(op, a, b),
                None => a,
            });
        }
    }
    operands.pop().unwrap_or(match op {
        BinaryOp::Or | BinaryOp::Ne | BinaryOp::Add => Expr::FALSE,
        _ => Expr::TRUE,
    })
}

/// The simplified negation of `e`, without double negations.
pub(super) fn negated(e: &Expr) -> Expr {
    match e.simplify() {
        Expr::Unary(UnaryOp::Not, inner) => *inner,
        e => e.not().simplify(),
    }
}
