//! Decision diagrams over whole inputs, with intervals on the edges: a canonical form for the
//! behavior of a state.
//!
//! The transitions of a state form one diagram. Each inner node tests one input; each leaf holds
//! the output and the next state, or marks the inputs as don't-care. Equal behavior is always the
//! same node, so minimization only compares node numbers, and reading a diagram back gives disjoint
//! cubes in a fixed order.

use super::{Cube, Port, Test};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Number of the root node of a diagram.
pub type Ref = u32;

/// A leaf: output and next state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Leaf {
    /// Number of the output valuation.
    pub output: u32,
    /// Next state, or block of states during minimization.
    pub to: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Node {
    /// Don't-care: these inputs break an assumption.
    DontCare,
    Leaf(Leaf),
    /// Tests an input. Each edge covers the values up to its bound, starting after the bound of the
    /// previous edge.
    Test {
        input: u32,
        edges: Vec<(i64, Ref)>,
    },
}

/// A store of the diagrams of a machine.
#[derive(Debug)]
pub struct Diagrams {
    domains: Vec<(i64, i64)>,
    nodes: Vec<Node>,
    numbers: FxHashMap<Node, Ref>,
}

/// The diagram that is don't-care everywhere.
pub const DONT_CARE: Ref = 0;

impl Diagrams {
    /// Creates a store without diagrams, for these inputs.
    pub fn new(inputs: &[Port]) -> Self {
        let domains = inputs.iter().map(|p| (p.domain.low(), p.domain.high()));
        Self {
            domains: domains.collect(),
            nodes: vec![Node::DontCare],
            numbers: FxHashMap::from_iter([(Node::DontCare, DONT_CARE)]),
        }
    }

    fn intern(&mut self, node: Node) -> Ref {
        if let Some(number) = self.numbers.get(&node) {
            return *number;
        }
        let number = self.nodes.len() as Ref;
        self.nodes.push(node.clone());
        self.numbers.insert(node, number);
        number
    }

    /// Returns the node with these edges; merges adjacent edges to the same child.
    fn test(&mut self, input: u32, edges: Vec<(i64, Ref)>) -> Ref {
        let mut merged: Vec<(i64, Ref)> = Vec::with_capacity(edges.len());
        for (high, child) in edges {
            match merged.last_mut() {
                Some(last) if last.1 == child => last.0 = high,
                _ => merged.push((high, child)),
            }
        }
        if let [(_, only)] = merged[..] {
            return only;
        }
        self.intern(Node::Test {
            input,
            edges: merged,
        })
    }

    /// Returns the diagram with `leaf` on the cube and don't-care elsewhere.
    pub fn cube(&mut self, cube: &Cube, leaf: Leaf) -> Ref {
        let mut result = self.intern(Node::Leaf(leaf));
        for test in cube.0.iter().rev() {
            let (low, high) = self.domains[test.input];
            let mut edges = Vec::with_capacity(3);
            if test.low > low {
                edges.push((test.low - 1, DONT_CARE));
            }
            edges.push((test.high.min(high), result));
            if test.high < high {
                edges.push((high, DONT_CARE));
            }
            result = self.test(test.input as u32, edges);
        }
        result
    }

    /// Returns the input that a node tests, and the node's edges; `u32::MAX` and no edges if the
    /// node tests no input.
    fn edges(&self, node: Ref) -> (u32, &[(i64, Ref)]) {
        match &self.nodes[node as usize] {
            Node::Test { input, edges } => (*input, edges),
            _ => (u32::MAX, &[]),
        }
    }

    /// Combines two diagrams: where one is don't-care, the result is the other; where both have a
    /// leaf, `join` decides. Returns `None` if `join` returns `None`, or if `steps` is used up.
    /// `steps` is decremented for every visited pair of nodes.
    pub fn overlay(
        &mut self,
        a: Ref,
        b: Ref,
        join: &mut impl FnMut(Leaf, Leaf) -> Option<Leaf>,
        seen: &mut FxHashMap<(Ref, Ref), Ref>,
        steps: &mut u64,
    ) -> Option<Ref> {
        if a == DONT_CARE || a == b {
            return Some(b);
        }
        if b == DONT_CARE {
            return Some(a);
        }
        if let Some(known) = seen.get(&(a, b)) {
            return Some(*known);
        }
        *steps = steps.checked_sub(1)?;
        let pair = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let result = if let (Node::Leaf(x), Node::Leaf(y)) = pair {
            let leaf = join(*x, *y)?;
            self.intern(Node::Leaf(leaf))
        } else {
            let ((first, _), (second, _)) = (self.edges(a), self.edges(b));
            let input = first.min(second);
            let high = self.domains[input as usize].1;
            let pick = |(asked, edges): (u32, &[(i64, Ref)]), whole: Ref| {
                if asked == input {
                    edges.to_vec()
                } else {
                    vec![(high, whole)]
                }
            };
            let (left, right) = (pick(self.edges(a), a), pick(self.edges(b), b));
            let (mut i, mut k) = (0, 0);
            let mut edges = Vec::new();
            while i < left.len() && k < right.len() {
                let bound = left[i].0.min(right[k].0);
                edges.push((
                    bound,
                    self.overlay(left[i].1, right[k].1, join, seen, steps)?,
                ));
                i += usize::from(left[i].0 == bound);
                k += usize::from(right[k].0 == bound);
            }
            self.test(input, edges)
        };
        seen.insert((a, b), result);
        Some(result)
    }

    /// Applies `change` to every leaf of a diagram.
    pub fn relabel(
        &mut self,
        node: Ref,
        change: &impl Fn(Leaf) -> Leaf,
        seen: &mut FxHashMap<Ref, Ref>,
    ) -> Ref {
        if let Some(known) = seen.get(&node) {
            return *known;
        }
        let result = match self.nodes[node as usize].clone() {
            Node::DontCare => DONT_CARE,
            Node::Leaf(leaf) => self.intern(Node::Leaf(change(leaf))),
            Node::Test { input, edges } => {
                let edges = edges
                    .into_iter()
                    .map(|(high, child)| (high, self.relabel(child, change, seen)))
                    .collect();
                self.test(input, edges)
            }
        };
        seen.insert(node, result);
        result
    }

    /// Returns every leaf with its cubes, in the order of the leaf's first occurrence.
    pub fn read(&self, node: Ref) -> Vec<(Leaf, Vec<Cube>)> {
        let mut order = Vec::new();
        let mut cubes: BTreeMap<Leaf, Vec<Cube>> = BTreeMap::new();
        self.walk(node, &mut Vec::new(), &mut order, &mut cubes);
        let take = |leaf: Leaf| (leaf, cubes.get(&leaf).cloned().unwrap_or_default());
        order.into_iter().map(take).collect()
    }

    fn walk(
        &self,
        node: Ref,
        path: &mut Vec<Test>,
        order: &mut Vec<Leaf>,
        cubes: &mut BTreeMap<Leaf, Vec<Cube>>,
    ) {
        match &self.nodes[node as usize] {
            Node::DontCare => {}
            Node::Leaf(leaf) => {
                let known = cubes.entry(*leaf).or_default();
                if known.is_empty() {
                    order.push(*leaf);
                }
                known.push(Cube(path.clone()));
            }
            Node::Test { input, edges } => {
                let input = *input as usize;
                let mut low = self.domains[input].0;
                for (high, child) in edges {
                    path.push(Test {
                        input,
                        low,
                        high: *high,
                    });
                    self.walk(*child, path, order, cubes);
                    path.pop();
                    low = high + 1;
                }
            }
        }
    }

    /// Returns the number of cubes of a diagram.
    pub fn cubes(&self, node: Ref, seen: &mut FxHashMap<Ref, u64>) -> u64 {
        match &self.nodes[node as usize] {
            Node::DontCare => 0,
            Node::Leaf(_) => 1,
            Node::Test { edges, .. } => {
                if let Some(known) = seen.get(&node) {
                    return *known;
                }
                let sum = edges
                    .iter()
                    .fold(0u64, |sum, e| sum.saturating_add(self.cubes(e.1, seen)));
                seen.insert(node, sum);
                sum
            }
        }
    }

    /// Calls `visit` once for every leaf, in no particular order.
    pub fn leaves(&self, node: Ref, visit: &mut impl FnMut(Leaf)) {
        let mut seen = std::collections::HashSet::new();
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            if !seen.insert(node) {
                continue;
            }
            match &self.nodes[node as usize] {
                Node::DontCare => {}
                Node::Leaf(leaf) => visit(*leaf),
                Node::Test { edges, .. } => stack.extend(edges.iter().rev().map(|e| e.1)),
            }
        }
    }
}
