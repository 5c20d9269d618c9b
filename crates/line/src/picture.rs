//! The drawing of a line: its places, and its routes with what decides between them.

use crate::trace::duration_in_units;
use linewright_core::drawing::{BoxStyle, Edge, Graph, svg};
use linewright_core::source::SourceMap;
use linewright_language::contract::MAX_SECONDS;
use linewright_language::contract::distribution::Distribution;
use linewright_language::contract::line::{Choice, Line, NodeKind, Route, Station, Supply};
use std::collections::BTreeMap;

/// Returns the drawing of a line as SVG. `sources` have the line's file.
pub fn to_svg(line: &Line, sources: &SourceMap) -> String {
    svg::render_rows(&line.name, &to_graph(line, sources))
}

/// Returns the places of a line as blocks, and its routes as edges, all those between two places as
/// one.
pub fn to_graph(line: &Line, sources: &SourceMap) -> Graph {
    let mut routes: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (number, route) in line.routes.iter().enumerate() {
        let ends = (route.from, route.to);
        routes.entry(ends).or_default().push(number);
    }
    // In the order of the routes, so that the parts' ways are from left to right.
    let mut bundles: Vec<((usize, usize), Vec<usize>)> = routes.into_iter().collect();
    bundles.sort_by_key(|(_, routes)| routes[0]);
    let edges = bundles.iter().map(|((from, to), routes)| Edge {
        from: Some(*from),
        to: *to,
        label: label(line, sources, routes),
    });
    let nodes = line.nodes.iter();
    Graph {
        states: nodes
            .map(|node| described(line, &node.name, &node.kind))
            .collect(),
        styles: line.nodes.iter().map(|node| style(&node.kind)).collect(),
        edges: edges.collect(),
        ..Graph::default()
    }
}

fn style(kind: &NodeKind) -> BoxStyle {
    match kind {
        NodeKind::Source { .. } | NodeKind::Sink { .. } | NodeKind::Store { .. } => {
            BoxStyle::Terminal
        }
        NodeKind::Station(_) => BoxStyle::Block,
        NodeKind::Buffer { .. } => BoxStyle::State,
        NodeKind::Conveyor { places, .. } => BoxStyle::Conveyor(*places),
    }
}

/// The name of a place, and what it is.
fn described(line: &Line, name: &str, kind: &NodeKind) -> Vec<String> {
    let mut label = vec![name.to_owned()];
    match kind {
        NodeKind::Source { part, supply, most } => {
            label.push(format!("{} of {}", kind.word(), line.parts[*part].name));
            label.push(match supply {
                Supply::Every { interval, .. } if interval.is_zero() => "never empty".to_owned(),
                Supply::Every { interval, .. } => format!("every {}", time(interval)),
                Supply::At { instants } => match instants.len() {
                    1 => "at 1 time".to_owned(),
                    count => format!("at {count} times"),
                },
                Supply::OnOrder => "on order".to_owned(),
            });
            label.extend(most.map(|most| format!("at most {most} in the line")));
        }
        NodeKind::Sink { reorder, .. } => {
            label.push(kind.description());
            label
                .extend(reorder.map(|source| format!("reorders from {}", line.nodes[source].name)));
        }
        NodeKind::Station(station) => match &station.machine {
            Some(machine) => label.push(format!("machine {}", machine.name)),
            None => label.push(work(station).unwrap_or_else(|| kind.description())),
        },
        NodeKind::Conveyor { belt, .. } => {
            label.push(kind.description());
            label.extend(
                belt.as_ref()
                    .map(|belt| format!("machine {}", belt.machine.name)),
            );
        }
        NodeKind::Store { .. } | NodeKind::Buffer { .. } => label.push(kind.description()),
    }
    label
}

/// How long the work of a station without a machine takes; `None` if no time is given.
fn work(station: &Station) -> Option<String> {
    let mut times = station.tasks.iter().filter_map(|task| task.time.as_ref());
    let first = times.next()?;
    Some(if times.all(|other| other == first) {
        format!("takes {}", time(first))
    } else {
        "time by part type".to_owned()
    })
}

/// A duration in a few words.
fn time(distribution: &Distribution) -> String {
    let (least, greatest) = (distribution.least(), distribution.greatest());
    let mean = match *distribution {
        Distribution::Normal { mean, .. }
        | Distribution::Lognormal { mean, .. }
        | Distribution::Exponential { mean }
        | Distribution::Erlang { mean, .. } => Some(mean),
        Distribution::Gamma { shape, scale } => Some(shape * scale),
        _ => None,
    };
    match mean {
        _ if least >= greatest => duration_in_units(least),
        _ if greatest < MAX_SECONDS => format!(
            "{} to {}",
            duration_in_units(least),
            duration_in_units(greatest)
        ),
        Some(mean) => format!("{} on average", duration_in_units(mean)),
        None => "a random time".to_owned(),
    }
}

/// The label of routes between the same two places: what decides that a part takes them. Part types
/// are named if there are several at the first place and this differs between them.
fn label(line: &Line, sources: &SourceMap, routes: &[usize]) -> Vec<String> {
    let from = line.routes[routes[0]].from;
    let leaving = line.routes.iter().filter(|route| route.from == from);
    let mut parts: Vec<usize> = leaving.map(|route| route.part).collect();
    parts.sort_unstable();
    parts.dedup();
    // Part types with the same conditions, in the order of the routes.
    let mut by_part: Vec<(usize, Vec<String>)> = Vec::new();
    for number in routes {
        let part = line.routes[*number].part;
        let text = condition(line, sources, *number);
        match by_part.iter_mut().find(|(known, _)| *known == part) {
            Some((_, texts)) if texts.contains(&text) => {}
            Some((_, texts)) => texts.push(text),
            None => by_part.push((part, vec![text])),
        }
    }
    let mut groups: Vec<(Vec<usize>, Vec<String>)> = Vec::new();
    for (part, texts) in by_part {
        match groups.iter_mut().find(|(_, known)| *known == texts) {
            Some((parts, _)) => parts.push(part),
            None => groups.push((vec![part], texts)),
        }
    }
    let mut lines = Vec::new();
    for (own, texts) in groups {
        let names = if own.len() < parts.len() {
            let names = own.iter().map(|part| line.parts[*part].name.as_str());
            names.collect::<Vec<_>>().join(", ")
        } else {
            String::new()
        };
        for text in texts {
            lines.push(match (names.as_str(), text.as_str()) {
                (names, "") => names.to_owned(),
                ("", text) => text.to_owned(),
                (names, text) => format!("{names}: {text}"),
            });
        }
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// What decides that a part takes a route; empty if it always does.
fn condition(line: &Line, sources: &SourceMap, number: usize) -> String {
    let route = &line.routes[number];
    let alike = |other: &&Route| (other.from, other.part) == (route.from, route.part);
    let mut text = match route.condition_span {
        Some(span) => format!("when {}", one_line(sources.text(span))),
        None if line
            .routes
            .iter()
            .filter(alike)
            .any(|r| r.condition.is_some()) =>
        {
            "otherwise".to_owned()
        }
        None => String::new(),
    };
    let choice = route.choice.map(|choice| match &line.choices[choice] {
        Choice::FirstFree => "first free".to_owned(),
        Choice::ShortestQueue => "shortest queue".to_owned(),
        Choice::RoundRobin => "round robin".to_owned(),
        Choice::Probability { shares } => {
            let share = shares[number - line.first_of_way(number)] * 100.0;
            // Three digits show what matters; `5 %` has none after the point.
            format!("{} %", (share * 1000.0).round() / 1000.0)
        }
    });
    if let Some(choice) = choice {
        if !text.is_empty() {
            text.push_str(", ");
        }
        text.push_str(&choice);
    }
    text
}

/// A text with single spaces in place of line breaks.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
