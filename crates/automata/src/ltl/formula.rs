//! Formulas over numbered atoms.

use std::collections::BTreeMap;

/// A node of [`Formulas`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(u32);

/// A formula over numbered atoms, in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Formula {
    /// True or false.
    Constant(bool),
    /// An atom, or its negation.
    Atom(usize, bool),
    /// Conjunction.
    And(Vec<Node>),
    /// Disjunction.
    Or(Vec<Node>),
    /// Holds from the next step on.
    Next(Node),
    /// The first holds until the second, which must occur.
    Until(Node, Node),
    /// The first holds until the second, or for ever.
    Weak(Node, Node),
    /// The second holds up to and including the step of the first, or for ever.
    Release(Node, Node),
}

/// Formulas with shared equal subformulas.
#[derive(Debug, Default)]
pub struct Formulas {
    nodes: Vec<Formula>,
    known: BTreeMap<Formula, Node>,
    /// Whether each node can be kept for ever, that is, contains a `weak` or a `release`.
    goes_on: Vec<bool>,
}

impl Formulas {
    /// Returns the node of a formula.
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

    /// Returns the formula of a node.
    pub fn formula(&self, node: Node) -> &Formula {
        &self.nodes[node.0 as usize]
    }

    /// Returns whether the node can be kept for ever.
    pub(super) fn goes_on(&self, node: Node) -> bool {
        self.goes_on[node.0 as usize]
    }

    /// Returns true or false.
    pub fn constant(&mut self, value: bool) -> Node {
        self.node(Formula::Constant(value))
    }

    /// Returns "eventually `a`".
    pub fn eventually(&mut self, a: Node) -> Node {
        let all = self.constant(true);
        self.node(Formula::Until(all, a))
    }

    /// Returns "always `a`".
    pub fn always(&mut self, a: Node) -> Node {
        let never = self.constant(false);
        self.node(Formula::Release(never, a))
    }

    /// Returns "`a` implies `b`".
    pub fn implies(&mut self, a: Node, b: Node) -> Node {
        let denied = self.not(a);
        self.node(Formula::Or(vec![denied, b]))
    }

    /// Returns the negation. The recursion is as deep as the formula.
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
