//! Decision diagrams over whole inputs, with intervals on the edges: the behavior of a state in
//! canonical form.
//!
//! A state's transitions as one diagram: each inner node tests one input; each leaf gives the
//! output and the next state, or marks the inputs as don't-care. Equal behavior is the same node,
//! so minimization compares numbers, and reading a diagram back gives disjoint cubes in a fixed
//! order.

use super::{Cube, Port, Test};
use std::collections::{BTreeMap, HashMap};

/// The number of a diagram.
pub type Ref = u32;

/// Action of a leaf: number of the output, and the next state or block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Leaf {
    /// Number of the output.
    pub output: u32,
    /// Next state or block.
    pub to: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Node {
    /// These inputs break an assumption.
    Nothing,
    Leaf(Leaf),
    /// Tests an input; each edge covers values up to its bound, starting after the previous edge.
    Ask {
        input: u32,
        edges: Vec<(i64, Ref)>,
    },
}

/// All diagrams of a machine.
#[derive(Debug)]
pub struct Diagrams {
    domains: Vec<(i64, i64)>,
    nodes: Vec<Node>,
    numbers: HashMap<Node, Ref>,
}

/// The diagram that is don't-care everywhere.
pub const NOTHING: Ref = 0;

impl Diagrams {
    /// Creates an empty store.
    pub fn new(inputs: &[Port]) -> Self {
        let domains = inputs.iter().map(|p| (p.domain.low(), p.domain.high()));
        Self {
            domains: domains.collect(),
            nodes: vec![Node::Nothing],
            numbers: HashMap::from([(Node::Nothing, NOTHING)]),
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

    fn ask(&mut self, input: u32, edges: Vec<(i64, Ref)>) -> Ref {
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
        self.intern(Node::Ask {
            input,
            edges: merged,
        })
    }

    /// The leaf on one cube, don't-care elsewhere.
    pub fn cube(&mut self, cube: &Cube, leaf: Leaf) -> Ref {
        let mut result = self.intern(Node::Leaf(leaf));
        for test in cube.0.iter().rev() {
            let (low, high) = self.domains[test.input];
            let mut edges = Vec::with_capacity(3);
            if test.low > low {
                edges.push((test.low - 1, NOTHING));
            }
            edges.push((test.high.min(high), result));
            if test.high < high {
                edges.push((high, NOTHING));
            }
            result = self.ask(test.input as u32, edges);
        }
        result
    }

    /// The first tested input of a diagram and its edges; a constant tests none.
    fn edges(&self, node: Ref) -> (u32, &[(i64, Ref)]) {
        match &self.nodes[node as usize] {
            Node::Ask { input, edges } => (*input, edges),
            _ => (u32::MAX, &[]),
        }
    }

    /// Combines both: where one is don't-care, the other. Where both are leaves, `join` decides; if
    /// it returns `None`, there is a conflict, and the result is `None`. `steps` is decremented at
    /// every node, and the result is also `None` when it reaches 0.
    pub fn overlay(
        &mut self,
        a: Ref,
        b: Ref,
        join: &mut impl FnMut(Leaf, Leaf) -> Option<Leaf>,
        seen: &mut HashMap<(Ref, Ref), Ref>,
        steps: &mut u64,
    ) -> Option<Ref> {
        if a == NOTHING || a == b {
            return Some(b);
        }
        if b == NOTHING {
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
            self.ask(input, edges)
        };
        seen.insert((a, b), result);
        Some(result)
    }

    /// Changes every leaf of a diagram.
    pub fn relabel(
        &mut self,
        node: Ref,
        change: &impl Fn(Leaf) -> Leaf,
        seen: &mut HashMap<Ref, Ref>,
    ) -> Ref {
        if let Some(known) = seen.get(&node) {
            return *known;
        }
        let result = match self.nodes[node as usize].clone() {
            Node::Nothing => NOTHING,
            Node::Leaf(leaf) => self.intern(Node::Leaf(change(leaf))),
            Node::Ask { input, edges } => {
                let edges = edges
                    .into_iter()
                    .map(|(high, child)| (high, self.relabel(child, change, seen)))
                    .collect();
                self.ask(input, edges)
            }
        };
        seen.insert(node, result);
        result
    }

    /// Every leaf with its cubes, in the order of its first occurrence.
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
            Node::Nothing => {}
            Node::Leaf(leaf) => {
                let known = cubes.entry(*leaf).or_default();
                if known.is_empty() {
                    order.push(*leaf);
                }
                known.push(Cube(path.clone()));
            }
            Node::Ask { input, edges } => {
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

    /// Number of cubes in a diagram.
    pub fn cubes(&self, node: Ref, seen: &mut HashMap<Ref, u64>) -> u64 {
        match &self.nodes[node as usize] {
            Node::Nothing => 0,
            Node::Leaf(_) => 1,
            Node::Ask { edges, .. } => {
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

    /// Calls `visit` for every leaf, in order, once each.
    pub fn leaves(&self, node: Ref, visit: &mut impl FnMut(Leaf)) {
        let mut seen = std::collections::HashSet::new();
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            if !seen.insert(node) {
                continue;
            }
            match &self.nodes[node as usize] {
                Node::Nothing => {}
                Node::Leaf(leaf) => visit(*leaf),
                Node::Ask { edges, .. } => stack.extend(edges.iter().rev().map(|e| e.1)),
            }
        }
    }
}
