//! Parts that a place can lose: scrap after a failure, and parts that expire.
//!
//! Times are left out of the abstraction, so a part that is scrapped at some time is a part that
//! goes to a sink of its own. Such a sink always has room, so it makes no difference that the part
//! goes there only when its work ends. A part that expires while it waits to leave its buffer
//! counts as one that becomes ready only then.

use linewright_language::contract::line::{Line, Node, NodeKind, Route};
use linewright_language::contract::machine::RealExpr;
use std::borrow::Cow;

/// The last word of the name of a sink for what a place loses.
const SCRAP: &str = "scrap";

/// The line with a sink, and ways to it, for the parts that each place can lose. Whether a part
/// takes such a way is left open.
pub fn with_losses(line: &Line) -> Cow<'_, Line> {
    let losing: Vec<usize> = (0..line.nodes.len())
        .filter(|node| line.can_lose_parts(*node))
        .collect();
    if losing.is_empty() {
        return Cow::Borrowed(line);
    }
    let mut with = line.clone();
    for node in losing {
        let sink = with.nodes.len();
        with.nodes.push(Node {
            name: format!("{}.{SCRAP}", line.nodes[node].name),
            kind: NodeKind::Sink {
                reject: true,
                reorder: None,
            },
            span: line.nodes[node].span,
        });
        let mut kinds: Vec<usize> = Vec::new();
        let from_here = line.routes.iter().filter(|route| route.from == node);
        let lost = from_here.filter_map(|route| {
            let is_new = !kinds.contains(&route.part);
            kinds.push(route.part);
            is_new.then(|| Route {
                to: sink,
                condition: Some(RealExpr::Number(0.0)),
                choice: None,
                ..route.clone()
            })
        });
        let lost: Vec<Route> = lost.collect();
        with.routes.splice(0..0, lost);
    }
    Cow::Owned(with)
}

/// Whether a node takes what another one loses.
pub(super) fn is_loss(line: &Line, node: usize) -> bool {
    let mut routes = line.routes.iter().filter(|route| route.to == node);
    let name = &line.nodes[node].name;
    routes.any(|route| {
        let from = &line.nodes[route.from].name;
        *name == format!("{from}.{SCRAP}")
    })
}

/// A place whose losses have no way out of the line, which [`with_losses`] adds. A place without
/// routes has no parts to lose.
pub(super) fn untreated(line: &Line) -> Option<usize> {
    let mut nodes = 0..line.nodes.len();
    nodes.find(|&node| {
        let mut routes = line.routes.iter().filter(|route| route.from == node);
        let mut all = line.routes.iter();
        line.can_lose_parts(node)
            && all.any(|route| route.from == node || route.to == node)
            && !routes.any(|route| is_loss(line, route.to))
    })
}
