//! The order of segments, from their dependencies.
//!
//! Without dependencies, segments follow each other as they stand. `AfterEnd` moves a segment
//! behind another, `AtStart` joins it with another to one step. `PossibleParallel` and
//! `NotInParallel` are kept by any sequence. Every other dependency is a finding, since steps have
//! no overlaps.

use super::source::Source;
use crate::finding::{Rule, quoted};
use crate::xml::Element;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Returns the segments in groups that are carried out together, in their order. Elements of a
/// group are in the order of the document.
///
/// Takes time proportional to the segments and their dependencies, but for a logarithmic factor.
pub(super) fn groups(source: &mut Source<'_, '_>, segments: &[Element]) -> Vec<Vec<Element>> {
    let mut numbers: FxHashMap<String, usize> = FxHashMap::default();
    for (number, segment) in segments.iter().enumerate() {
        let id = source.id(*segment);
        let message = format!("two segments have the identifier {}", quoted(&id));
        if *numbers.entry(id).or_insert(number) != number {
            source.add(*segment, Rule::Reference, message);
        }
    }
    let mut sets = Sets::new(segments.len());
    let (mut edges, mut apart) = (Vec::new(), Vec::new());
    for (number, segment) in segments.iter().enumerate() {
        for dependency in source.children(*segment, "SegmentDependency") {
            source.id(dependency);
            let kind = source.code(dependency, "Dependency");
            let kind = kind.map(|(text, _)| text).unwrap_or_default();
            for other in ["DependencyFactor", "ProductSegmentID", "ProcessSegmentID"] {
                if let Some(found) = source.child(dependency, other) {
                    let message = format!("a dependency with {} is not read", quoted(other));
                    source.add(found, Rule::Meaning, message);
                }
            }
            for on in source.children(dependency, "SegmentID") {
                let id = source.name(on);
                let Some(on_number) = numbers.get(&id).copied() else {
                    let message = format!("there is no segment {} beside this", quoted(&id));
                    source.add(on, Rule::Reference, message);
                    continue;
                };
                match kind.as_str() {
                    "AfterEnd" => edges.push((on_number, number)),
                    "AtStart" => sets.join(on_number, number),
                    "NotInParallel" => apart.push((on_number, number, on)),
                    "PossibleParallel" => {}
                    other => {
                        let message = format!("the dependency {} is not read", quoted(other));
                        source.add(dependency, Rule::Meaning, message);
                    }
                }
            }
        }
    }
    for (one, other, at) in apart {
        if sets.first(one) == sets.first(other) {
            source.add(at, Rule::Meaning, "the segments also begin together");
        }
    }
    sorted(source, segments, &mut sets, &edges)
}

/// Sorts sets of segments by edges between them. Of those that could be next, the first of the
/// document is.
fn sorted(
    source: &mut Source<'_, '_>,
    segments: &[Element],
    sets: &mut Sets,
    edges: &[(usize, usize)],
) -> Vec<Vec<Element>> {
    let count = segments.len();
    let mut members: Vec<Vec<Element>> = vec![Vec::new(); count];
    for (number, segment) in segments.iter().enumerate() {
        members[sets.first(number)].push(*segment);
    }
    let (mut following, mut waits) = (vec![Vec::new(); count], vec![0_usize; count]);
    for (before, after) in edges {
        let (before, after) = (sets.first(*before), sets.first(*after));
        following[before].push(after);
        waits[after] += 1;
    }
    let ready = (0..count).filter(|n| !members[*n].is_empty() && waits[*n] == 0);
    let mut ready: BinaryHeap<Reverse<usize>> = ready.map(Reverse).collect();
    let mut order = Vec::new();
    while let Some(Reverse(next)) = ready.pop() {
        order.push(std::mem::take(&mut members[next]));
        for after in &following[next] {
            waits[*after] -= 1;
            if waits[*after] == 0 {
                ready.push(Reverse(*after));
            }
        }
    }
    if let Some(stuck) = members.iter().find_map(|m| m.first()) {
        let message = "the dependencies of this segment form a circle";
        source.add(*stuck, Rule::Meaning, message);
    }
    order
}

/// Disjoint sets of numbers. The representative of a set is its smallest number.
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn first(&mut self, number: usize) -> usize {
        let mut number = number;
        while self.0[number] != number {
            self.0[number] = self.0[self.0[number]];
            number = self.0[number];
        }
        number
    }

    fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.first(one), self.first(other));
        self.0[one.max(other)] = one.min(other);
    }
}
