//! `times 3`: one station of the file that stands for several of the line.

use crate::contract::line::{Choice, Line, Node, NodeKind, Route};
use std::collections::BTreeMap;
use std::ops::Range;

/// Replaces each station with `times n` by `n` stations, `capper[1]` to `capper[n]`. A route to
/// such a station becomes a choice of the first free one, and a route from it starts at each of
/// them. In a choice that was written, the stations take the place of the one; by probability, they
/// share its probability equally.
pub(super) fn expand(line: &mut Line, times: &BTreeMap<usize, usize>) {
    if times.is_empty() {
        return;
    }
    // By node of the file: the nodes that it stands for.
    let mut copies: Vec<Range<usize>> = Vec::new();
    let mut nodes = Vec::new();
    for (index, node) in line.nodes.drain(..).enumerate() {
        let first = nodes.len();
        match times.get(&index) {
            None => nodes.push(node),
            Some(count) => nodes.extend((1..=*count).map(|number| Node {
                name: format!("{}[{number}]", node.name),
                ..node.clone()
            })),
        }
        copies.push(first..nodes.len());
    }
    for node in &mut nodes {
        if let NodeKind::Sink {
            reorder: Some(source),
            ..
        } = &mut node.kind
        {
            *source = copies[*source].start;
        }
    }
    line.nodes = nodes;
    for requirement in &mut line.requirements {
        let nodes = &mut requirement.metric.nodes;
        if !Range::is_empty(nodes) {
            *nodes = copies[nodes.start].clone();
        }
    }
    expand_routes(line, &copies);
}

fn expand_routes(line: &mut Line, copies: &[Range<usize>]) {
    let written = std::mem::take(&mut line.routes);
    let choices = std::mem::take(&mut line.choices);
    let mut start = 0;
    while start < written.len() {
        let first = &written[start];
        let alike = |r: &&Route| r.choice == first.choice;
        let count = match first.choice {
            None => 1,
            Some(_) => written[start..].iter().take_while(alike).count(),
        };
        let way = &written[start..start + count];
        start += count;
        let targets: Vec<(usize, &Route)> = way
            .iter()
            .flat_map(|route| copies[route.to].clone().map(move |to| (to, route)))
            .collect();
        let choice = match first.choice.map(|choice| &choices[choice]) {
            _ if targets.len() == 1 => None,
            None => Some(Choice::FirstFree),
            Some(Choice::Probability { shares }) => {
                let each = way.iter().zip(shares).flat_map(|(route, share)| {
                    let count = copies[route.to].len();
                    std::iter::repeat_n(share / count as f64, count)
                });
                Some(Choice::Probability {
                    shares: each.collect(),
                })
            }
            Some(choice) => Some(choice.clone()),
        };
        for from in copies[first.from].clone() {
            let choice = choice.clone().map(|choice| {
                line.choices.push(choice);
                line.choices.len() - 1
            });
            line.routes.extend(targets.iter().map(|(to, route)| Route {
                from,
                to: *to,
                choice,
                ..(*route).clone()
            }));
        }
    }
}
