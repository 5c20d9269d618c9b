//! Formulas of linear temporal logic over numbered atoms.

use std::collections::BTreeMap;

/// Reference to a formula in [`Formulas`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(u32);

/// A formula over numbered atoms, in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Formula {
    /// True or false.
    Constant(bool),
    /// An atom if the flag is `true`, its negation if it is `false`.
    Atom(usize, bool),
    /// Conjunction.
    And(Vec<Node>),
    /// Disjunction.
    Or(Vec<Node>),
    /// The operand holds in the next step.
    Next(Node),
    /// The first operand holds until the second one does, and the second one has to hold
    /// eventually.
    Until(Node, Node),
    /// The first operand holds until the second one does, or for ever.
    Weak(Node, Node),
    /// The second operand holds up to and including the step in which the first one does, or for
    /// ever.
    Release(Node, Node),
}

/// Store of formulas in which equal subformulas are shared.
#[derive(Debug, Default)]
pub struct Formulas {
    nodes: Vec<Formula>,
    known: BTreeMap<Formula, Node>,
    /// Whether each node contains a `weak` or a `release`, so that it can remain as an obligation
    /// for ever.
    can_hold_forever: Vec<bool>,
}

impl Formulas {
    /// Returns the node of a formula, which is added if it is new.
    pub fn node(&mut self, formula: Formula) -> Node {
        if let Some(known) = self.known.get(&formula) {
            return *known;
        }
        let can_hold_forever = match &formula {
            Formula::Constant(_) | Formula::Atom(..) => false,
            Formula::Weak(..) | Formula::Release(..) => true,
            Formula::Next(a) => self.can_hold_forever(*a),
            Formula::Until(a, b) => self.can_hold_forever(*a) || self.can_hold_forever(*b),
            Formula::And(list) | Formula::Or(list) => {
                list.iter().any(|a| self.can_hold_forever(*a))
            }
        };
        let node = Node(self.nodes.len() as u32);
        self.nodes.push(formula.clone());
        self.can_hold_forever.push(can_hold_forever);
        self.known.insert(formula, node);
        node
    }

    /// Returns the formula of a node.
    pub fn formula(&self, node: Node) -> &Formula {
        &self.nodes[node.0 as usize]
    }

    /// Returns whether the node contains a `weak` or a `release`.
    pub(super) fn can_hold_forever(&self, node: Node) -> bool {
        self.can_hold_forever[node.0 as usize]
    }

    /// Returns the constant `true` or `false`.
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
        let negated = self.not(a);
        self.node(Formula::Or(vec![negated, b]))
    }

    /// Returns the negation, in negation normal form. The recursion is as deep as the formula.
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
