//! Premises: what the proof of a line takes for granted about the world around it.

use super::{Calls, orders};
use crate::abstraction::Shape;
use crate::abstraction::words::an;
use linewright_core::source::Span;
use linewright_language::contract::MAX_SECONDS;
use linewright_language::contract::distribution::Distribution;
use linewright_language::contract::line::{BufferOrder, Line, NodeKind, Station, Supply};
use linewright_language::contract::machine::{Between, InterruptedWork};

/// A premise of a proof that the line itself does not establish.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Premise {
    /// Name, such as `stock_of_Brick_at_warehouse`.
    pub name: String,
    /// In words, such as `the stock of Brick at warehouse does not run out`.
    pub text: String,
    /// Place of the declaration that it is about.
    pub span: Span,
}

impl Premise {
    /// Whether the other premise says the same.
    fn is_same(&self, other: &Self) -> bool {
        (&self.name, &self.text) == (&other.name, &other.text)
    }
}

/// The premises of a line. `line` is as the user wrote it, and `calls` is the result of exploring
/// its calls.
pub fn premises(line: &Line, calls: &Calls) -> Vec<Premise> {
    let mut found = Vec::new();
    let continued = orders::needed(&calls.simplified(line));
    for (node, declared) in line.nodes.iter().enumerate() {
        let (name, span) = (&declared.name, declared.span);
        match &declared.kind {
            NodeKind::Buffer { order, .. } if *order != BufferOrder::FirstIn => {
                found.push(Premise {
                    name: format!("every_part_leaves_{name}"),
                    text: format!(
                        "no part stays in {name} for ever because others overtake it there"
                    ),
                    span,
                });
            }
            NodeKind::Station(station) if can_restart_for_ever(station) => found.push(Premise {
                name: format!("work_ends_at_{name}"),
                text: format!(
                    "work at {name}, which begins again after a failure, ends before the next one in the end"
                ),
                span,
            }),
            NodeKind::Store { .. } => stock(line, calls, node, &mut found),
            NodeKind::Source {
                supply: Supply::Every { limit: Some(n), .. },
                ..
            } => found.push(Premise {
                name: format!("more_from_{name}"),
                text: format!("{name} continues beyond its limit of {n}"),
                span,
            }),
            NodeKind::Source {
                supply: Supply::At { instants },
                ..
            } => found.push(Premise {
                name: format!("more_from_{name}"),
                text: format!(
                    "{name} continues beyond the {} rows of its table",
                    instants.len()
                ),
                span,
            }),
            NodeKind::Source {
                part,
                supply: Supply::OnOrder,
                ..
            } => {
                let lost = lost(line, calls, node, *part);
                let reason = lost.or_else(|| continued.get(&node).cloned());
                found.extend(reason.map(|reason| Premise {
                    name: format!("more_orders_for_{name}"),
                    text: format!("{name} gets further orders: {reason}"),
                    span,
                }));
            }
            _ => {}
        }
    }
    add_losses(line, &mut found);
    for (index, route) in line.routes.iter().enumerate() {
        if calls.taken[index] && !calls.by_chance[index] {
            let kind = &line.parts[route.part].name;
            let from = &line.nodes[route.from].name;
            let way = line.first_of_way(index)..line.end_of_way(index);
            let ends = line.routes[way]
                .iter()
                .map(|r| line.nodes[r.to].name.as_str());
            let ends: Vec<&str> = ends.collect();
            let (to, to_name) = (ends.join(" or "), ends.join("_or_"));
            let premise = Premise {
                name: format!("{from}_sends_{kind}_to_{to_name}"),
                text: format!(
                    "as long as {kind} parts leave {from}, one of them eventually goes to {to}"
                ),
                span: route.span,
            };
            if !found.iter().any(|known| known.is_same(&premise)) {
                found.push(premise);
            }
        }
    }
    found
}

/// Whether work can take longer than any time between two failures after which it begins again. If
/// not, it ends with probability 1. The time of work that a controller determines has no bound
/// here.
fn can_restart_for_ever(station: &Station) -> bool {
    let times = station.tasks.iter().map(|task| task.time.as_ref());
    let longest = times
        .map(|time| time.map_or(MAX_SECONDS, Distribution::greatest))
        .fold(station.setup.greatest(), f64::max);
    let mut modes = station.failures.iter();
    modes.any(|mode| {
        let restarts = mode.interrupted == InterruptedWork::Restarts;
        match &mode.between {
            Between::Working(time) | Between::Calendar(time) => {
                restarts && time.greatest() < longest
            }
            Between::Parts(_) | Between::DrawnParts(_) => false,
        }
    })
}

/// Adds that each place which can lose parts passes on some of each type.
fn add_losses(line: &Line, found: &mut Vec<Premise>) {
    for (node, declared) in line.nodes.iter().enumerate() {
        if !line.can_lose_parts(node) {
            continue;
        }
        let from = &declared.name;
        for route in line.routes.iter().filter(|route| route.from == node) {
            let kind = &line.parts[route.part].name;
            let premise = Premise {
                name: format!("{from}_does_not_scrap_every_{kind}"),
                text: format!(
                    "as long as {kind} parts come to {from}, one of them eventually is not scrapped there"
                ),
                span: declared.span,
            };
            if !found.iter().any(|known| known.is_same(&premise)) {
                found.push(premise);
            }
        }
    }
}

/// Adds the premises of a store, one for each type of part that leaves it. If the type also arrives
/// there, the premise is that it arrives again and again. Otherwise, the premise is that the stock
/// does not run out.
fn stock(line: &Line, calls: &Calls, node: usize, found: &mut Vec<Premise>) {
    let (store, span) = (&line.nodes[node].name, line.nodes[node].span);
    for (part, kind) in line.parts.iter().enumerate() {
        let mut routes = line.routes.iter().zip(&calls.taken);
        if !routes.any(|(r, taken)| *taken && r.from == node && r.part == part) {
            continue;
        }
        let mut routes = line.routes.iter().zip(&calls.taken);
        let comes = routes.any(|(r, taken)| *taken && r.to == node && r.part == part);
        let kind = &kind.name;
        found.push(if comes {
            Premise {
                name: format!("more_{kind}_at_{store}"),
                text: format!("{store} receives another {kind} again and again"),
                span,
            }
        } else {
            Premise {
                name: format!("stock_of_{kind}_at_{store}"),
                text: format!("the stock of {kind} at {store} does not run out"),
                span,
            }
        });
    }
}

/// Says that a part from a source on order leaves the line, but not in a product, and is not
/// reordered; `None` if there is no such part. The source makes only as many parts as the requested
/// products need, so some product lacks it. With several types of products, orders have no end.
fn lost(line: &Line, calls: &Calls, source: usize, part: usize) -> Option<String> {
    let contents = Shape::contents(line);
    let product = line.only_product()?;
    if contents[product][part] == 0 {
        return None;
    }
    let name = &line.nodes[source].name;
    let mut routes = line.routes.iter();
    let scrapped =
        routes.find(|route| contents[route.part][part] > 0 && line.can_lose_parts(route.from));
    if let Some(route) = scrapped {
        let (kind, from) = (&line.parts[route.part].name, &line.nodes[route.from].name);
        return Some(format!("{} may be scrapped at {from}", an(kind)));
    }
    let leaves = |node: usize, kind: usize| {
        let mut routes = line.routes.iter();
        routes.any(|r| r.from == node && r.part == kind)
    };
    let routes = line.routes.iter().zip(&calls.taken);
    let mut taken = routes.filter(|(_, taken)| **taken).map(|(route, _)| route);
    let lost = taken.find(|route| {
        let contained = contents[route.part][part] > 0;
        contained
            && match &line.nodes[route.to].kind {
                NodeKind::Sink {
                    reject: true,
                    reorder,
                } => *reorder != Some(source),
                NodeKind::Sink { .. } => route.part != product,
                NodeKind::Store { .. } => route.part != product && !leaves(route.to, route.part),
                _ => false,
            }
    })?;
    let (kind, to) = (&line.parts[lost.part].name, &line.nodes[lost.to].name);
    Some(format!(
        "for {} that ends at {to}, no replacement is ordered from {name}",
        an(kind)
    ))
}
