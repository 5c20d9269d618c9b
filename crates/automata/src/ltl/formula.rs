//! Formulas over numbered atoms.

use std::collections::BTreeMap;

/// A node of [`Formulas`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(u32);

/// A formula over numbered atoms; negations stand before atoms only.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Formula {
    /// True or false.
    Constant(bool),
    /// An atom, or its negation.
    Atom(usize, bool),
    /// All of them.
    And(Vec<Node>),
    /// One of them.
    Or(Vec<Node>),
    /// From the next step on.
    Next(Node),
    /// The first up to the second, which has to come.
    Until(Node, Node),
    /// The first up to the second, or for ever.
    Weak(Node, Node),
    /// The second up to and with the first, or for ever.
    Release(Node, Node),
}

/// Formulas that share what is equal.
#[derive(Debug, Default)]
pub struct Formulas {
    nodes: Vec<Formula>,
    known: BTreeMap<Formula, Node>,
    /// For every node, whether it can be kept by going on: whether a `weak` or a `release` is in
    /// it.
    goes_on: Vec<bool>,
}

impl Formulas {
    /// The node of a formula.
    pub fn node(&mut self, formula: Formula) -> Node {
        if let Some(known) = self.known.get(&formula) {
            return *known;
        }
        let goes_on = match &formula {
            Formula::Constant(_) | Formula::Atom(..) => false,
            Formula::Weak(..) | Formula::Release(..) => true,
            Formula::Next(a) => self.goes_on(*a),
            Formula::Until(a, b) => self.goes_on(*a) || self.goes_on(*b),
            Formula::And(list) | Formula::Or(list) => list.iter().any(|a| self.goes_on(*a)),
        };
        let node = Node(self.nodes.len() as u32);
        self.nodes.push(formula.clone());
        self.goes_on.push(goes_on);
        self.known.insert(formula, node);
        node
    }

    /// The formula of a node.
    pub fn formula(&self, node: Node) -> &Formula {
        &self.nodes[node.0 as usize]
    }

    /// Whether it can be kept by going on.
    pub(super) fn goes_on(&self, node: Node) -> bool {
        self.goes_on[node.0 as usize]
    }

    /// True or false.
    pub fn constant(&mut self, value: bool) -> Node {
        self.node(Formula::Constant(value))
    }

    /// Some day.
    pub fn eventually(&mut self, a: Node) -> Node {
        let all = self.constant(true);
        self.node(Formula::Until(all, a))
    }

    /// In every step.
    pub fn always(&mut self, a: Node) -> Node {
        let never = self.constant(false);
        self.node(Formula::Release(never, a))
    }

    /// If the first, then the second.
    pub fn implies(&mut self, a: Node, b: Node) -> Node {
        let denied = self.not(a);
        self.node(Formula::Or(vec![denied, b]))
    }

    /// The negation. The recursion is as deep as the formula.
    pub fn not(&mut self, a: Node) -> Node {
        let formula = match self.formula(a).clone() {
            Formula::Constant(value) => Formula::Constant(!value),
            Formula::Atom(atom, value) => Formula::Atom(atom, !value),
            Formula::And(list) => Formula::Or(list.into_iter().map(|b| self.not(b)).collect()),
            Formula::Or(list) => Formula::And(list.into_iter().map(|b| self.not(b)).collect()),
            Formula::Next(b) => Formula::Next(self.not(b)),
            Formula::Until(b, c) => Formula::Release(self.not(b), self.not(c)),
            Formula::Release(b, c) => Formula::Until(self.not(b), self.not(c)),
            // !(b W c) = !c U (!b & !c)
            Formula::Weak(b, c) => {
                let (b, c) = (self.not(b), self.not(c));
                Formula::Until(c, self.node(Formula::And(vec![b, c])))
            }
        };
        self.node(formula)
    }
}
