//! Expanded formulas of linear temporal logic: nodes with their location, size and look-ahead.
//!
//! In contrast to [`linewright_automata::ltl`], equal formulas are not shared, so that each one
//! keeps its own location for messages.

use linewright_core::gr1::VarId;
use std::collections::BTreeMap;
use std::ops::Range;

/// Maximum number of operators and operands of an expanded formula.
const MAX_SIZE: u64 = 1 << 16;
/// Maximum nesting depth of formulas.
const MAX_DEPTH: u32 = 400;
/// Maximum number of nodes of a file.
const MAX_NODES: usize = 1 << 21;

/// Index of a node in [`Formulas`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct FormulaId(u32);

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Op {
    True,
    False,
    Atom(VarId),
    Not(FormulaId),
    And(Vec<FormulaId>),
    Or(Vec<FormulaId>),
    Implies(FormulaId, FormulaId),
    Iff(FormulaId, FormulaId),
    Next(FormulaId),
    Globally(FormulaId),
    Finally(FormulaId),
    Until(FormulaId, FormulaId),
    Weak(FormulaId, FormulaId),
    Release(FormulaId, FormulaId),
}

/// The location of a formula, and the call in which it was expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub start: u32,
    pub end: u32,
    /// Index into the expansion sites; 0 if the formula was not expanded from a call.
    pub site: u32,
}

impl Place {
    pub fn new(range: &Range<usize>, site: u32) -> Self {
        Self {
            start: range.start as u32,
            end: range.end as u32,
            site,
        }
    }

    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

#[derive(Debug, Clone)]
struct Node {
    op: Op,
    place: Place,
    size: u64,
    depth: u32,
    /// Number of steps that the formula looks ahead; `None` if it contains a temporal operator
    /// other than `X`.
    ahead: Option<u32>,
}

#[derive(Debug, Default)]
pub(super) struct Formulas {
    nodes: Vec<Node>,
    /// Memoized results of [`positive`](Self::positive).
    pub positives: BTreeMap<(FormulaId, bool), FormulaId>,
    /// Whether a limit was exceeded, after which all formulas are invalid.
    pub too_large: bool,
}

impl Formulas {
    pub fn op(&self, f: FormulaId) -> &Op {
        &self.nodes[f.0 as usize].op
    }

    pub fn place(&self, f: FormulaId) -> Place {
        self.nodes[f.0 as usize].place
    }

    /// Number of steps that the formula looks ahead; `None` if it contains a temporal operator
    /// other than `X`.
    pub fn ahead(&self, f: FormulaId) -> Option<u32> {
        self.nodes[f.0 as usize].ahead
    }

    /// Whether the formula is about a single step.
    pub fn is_state(&self, f: FormulaId) -> bool {
        self.ahead(f) == Some(0)
    }

    pub fn truth(&self, f: FormulaId) -> Option<bool> {
        match self.op(f) {
            Op::True => Some(true),
            Op::False => Some(false),
            _ => None,
        }
    }

    pub fn constant(&mut self, value: bool, place: Place) -> FormulaId {
        self.push(if value { Op::True } else { Op::False }, place)
    }

    pub fn not(&mut self, a: FormulaId) -> FormulaId {
        let place = self.place(a);
        self.make(Op::Not(a), place)
    }

    pub fn and(&mut self, list: Vec<FormulaId>, place: Place) -> FormulaId {
        self.make(Op::And(list), place)
    }

    pub fn or(&mut self, list: Vec<FormulaId>, place: Place) -> FormulaId {
        self.make(Op::Or(list), place)
    }

    /// The operands of an operator.
    pub fn children(op: &Op) -> Vec<FormulaId> {
        match op {
            Op::True | Op::False | Op::Atom(_) => Vec::new(),
            Op::Not(a) | Op::Next(a) | Op::Globally(a) | Op::Finally(a) => vec![*a],
            Op::And(list) | Op::Or(list) => list.clone(),
            Op::Implies(a, b)
            | Op::Iff(a, b)
            | Op::Until(a, b)
            | Op::Weak(a, b)
            | Op::Release(a, b) => vec![*a, *b],
        }
    }

    /// Builds a node; folds constants and flattens chains.
    pub fn make(&mut self, op: Op, place: Place) -> FormulaId {
        let t = |s: &Self, f: FormulaId| s.truth(f);
        match op {
            Op::Not(a) => match self.op(a).clone() {
                Op::True => self.constant(false, place),
                Op::False => self.constant(true, place),
                Op::Not(inner) => inner,
                _ => self.push(Op::Not(a), place),
            },
            Op::And(list) => self.chain(list, place, true),
            Op::Or(list) => self.chain(list, place, false),
            Op::Implies(a, b) => match (t(self, a), t(self, b)) {
                (Some(true), _) => b,
                (Some(false), _) | (_, Some(true)) => self.constant(true, place),
                (_, Some(false)) => self.make(Op::Not(a), place),
                _ => self.push(Op::Implies(a, b), place),
            },
            Op::Iff(a, b) => match (t(self, a), t(self, b)) {
                (Some(true), _) => b,
                (_, Some(true)) => a,
                (Some(false), _) => self.make(Op::Not(b), place),
                (_, Some(false)) => self.make(Op::Not(a), place),
                _ => self.push(Op::Iff(a, b), place),
            },
            Op::Next(a) | Op::Globally(a) | Op::Finally(a) if t(self, a).is_some() => a,
            Op::Globally(a) if matches!(self.op(a), Op::Globally(_)) => a,
            Op::Finally(a) if matches!(self.op(a), Op::Finally(_)) => a,
            Op::Until(a, b) => match (t(self, a), t(self, b)) {
                (Some(false), _) | (_, Some(_)) => b,
                (Some(true), _) => self.make(Op::Finally(b), place),
                _ => self.push(Op::Until(a, b), place),
            },
            Op::Weak(a, b) => match (t(self, a), t(self, b)) {
                (Some(false), _) | (_, Some(true)) => b,
                (Some(true), _) => self.constant(true, place),
                (_, Some(false)) => self.make(Op::Globally(a), place),
                _ => self.push(Op::Weak(a, b), place),
            },
            Op::Release(a, b) => match (t(self, a), t(self, b)) {
                (Some(true), _) | (_, Some(_)) => b,
                (Some(false), _) => self.make(Op::Globally(b), place),
                _ => self.push(Op::Release(a, b), place),
            },
            op => self.push(op, place),
        }
    }

    fn chain(&mut self, list: Vec<FormulaId>, place: Place, and: bool) -> FormulaId {
        let mut flat = Vec::new();
        for f in list {
            match (self.op(f), and) {
                (Op::And(inner), true) | (Op::Or(inner), false) => {
                    flat.extend(inner.iter().copied());
                }
                (Op::True, true) | (Op::False, false) => {}
                (Op::False, true) | (Op::True, false) => return f,
                _ => flat.push(f),
            }
            if flat.len() as u64 > MAX_SIZE {
                self.too_large = true;
                break;
            }
        }
        match flat.len() {
            0 => self.constant(and, place),
            1 => flat[0],
            _ => self.push(if and { Op::And(flat) } else { Op::Or(flat) }, place),
        }
    }

    fn push(&mut self, op: Op, place: Place) -> FormulaId {
        let (mut size, mut depth) = (1_u64, 0);
        let step = u32::from(matches!(op, Op::Next(_)));
        let mut ahead = Some(0);
        for child in Self::children(&op) {
            let child = &self.nodes[child.0 as usize];
            size = size.saturating_add(child.size);
            depth = depth.max(child.depth);
            ahead = ahead.zip(child.ahead).map(|(a, b)| a.max(b + step));
        }
        if matches!(
            op,
            Op::Globally(_) | Op::Finally(_) | Op::Until(..) | Op::Weak(..) | Op::Release(..)
        ) {
            ahead = None;
        }
        let full = size > MAX_SIZE || depth >= MAX_DEPTH || self.nodes.len() >= MAX_NODES;
        let node = Node {
            op: if full { Op::True } else { op },
            place,
            size: if full { 1 } else { size },
            depth: if full { 1 } else { depth + 1 },
            ahead: if full { Some(0) } else { ahead },
        };
        self.too_large |= full;
        // Once the limit is reached, the last node is reused, to bound the memory.
        if self.nodes.len() > MAX_NODES {
            return FormulaId(self.nodes.len() as u32 - 1);
        }
        self.nodes.push(node);
        FormulaId(self.nodes.len() as u32 - 1)
    }

    /// Whether `chosen` accepts all variables of the formula.
    pub fn all_atoms(&self, f: FormulaId, chosen: &dyn Fn(VarId) -> bool) -> bool {
        match self.op(f) {
            Op::Atom(v) => chosen(*v),
            op => Self::children(op)
                .iter()
                .all(|g| self.all_atoms(*g, chosen)),
        }
    }

    pub(super) fn map_operands(
        &mut self,
        op: Op,
        map: &mut dyn FnMut(&mut Self, FormulaId) -> FormulaId,
    ) -> Op {
        let mut m = |f: FormulaId| map(self, f);
        match op {
            Op::True | Op::False | Op::Atom(_) => op,
            Op::Not(a) => Op::Not(m(a)),
            Op::And(list) => Op::And(list.into_iter().map(m).collect()),
            Op::Or(list) => Op::Or(list.into_iter().map(m).collect()),
            Op::Implies(a, b) => Op::Implies(m(a), m(b)),
            Op::Iff(a, b) => Op::Iff(m(a), m(b)),
            Op::Next(a) => Op::Next(m(a)),
            Op::Globally(a) => Op::Globally(m(a)),
            Op::Finally(a) => Op::Finally(m(a)),
            Op::Until(a, b) => Op::Until(m(a), m(b)),
            Op::Weak(a, b) => Op::Weak(m(a), m(b)),
            Op::Release(a, b) => Op::Release(m(a), m(b)),
        }
    }
}
