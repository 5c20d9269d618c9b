//! The picture of a line: its places in layers along the routes.

use super::recorder::Recorder;
use super::state_class;
use crate::html::numbers::count;
use linewright_core::drawing::fold::{place_in_rows, rounded};
use linewright_core::drawing::layers::{Link, Placement, Size, Spacing};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_line::log::Activity;
use maud::{Markup, html};

const SPACING: Spacing = Spacing {
    boxes: 26.0,
    links: 16.0,
    layers: 44.0,
};

/// Distance around the picture, in SVG units.
const MARGIN: f64 = 24.0;

/// The picture of a line.
pub(super) struct Picture {
    placement: Placement,
    sizes: Vec<Size>,
    /// Pairs of nodes between which parts go, in the order of the placed links.
    pub links: Vec<(usize, usize)>,
}

impl Picture {
    /// Lays out a line from left to right, in several rows if it is long.
    pub fn new(line: &Line) -> Self {
        let sizes: Vec<Size> = line.nodes.iter().map(|n| size(&n.name, &n.kind)).collect();
        let mut links: Vec<(usize, usize)> = Vec::new();
        for route in &line.routes {
            if !links.contains(&(route.from, route.to)) {
                links.push((route.from, route.to));
            }
        }
        let placement = place_in_rows(&sizes, &unlabeled(&links), SPACING);
        Self {
            placement,
            sizes,
            links,
        }
    }

    /// Draws the picture, with the number of parts that went from node to node.
    pub fn draw(&self, line: &Line, recorder: &Recorder) -> Markup {
        let Size { width, height } = self.placement.size;
        let (width, height) = (width + 2.0 * MARGIN, height + 2.0 * MARGIN);
        let view = format!("{0:.0} {0:.0} {width:.0} {height:.0}", -MARGIN);
        html! {
            svg #line viewBox=(view) style=(format!("max-width:{:.0}px;min-width:{:.0}px", width * 1.25, width.min(1000.0) * 0.75)) role="group" aria-label="Picture of the line" {
                defs {
                    marker #arrow markerWidth="9" markerHeight="7" refX="8" refY="3.5" orient="auto" {
                        path d="M0 0L9 3.5L0 7z" {}
                    }
                }
                @for (index, link) in self.placement.links.iter().enumerate() {
                    @let (from, to) = self.links[index];
                    @let flow = recorder.flow(from, to);
                    path.link data-link=(index) d=(rounded(&link.points)) marker-end="url(#arrow)" {
                        title { (line.nodes[from].name) " to " (line.nodes[to].name) ": " (by_type(line, flow)) }
                    }
                }
                @for (index, node) in line.nodes.iter().enumerate() {
                    (self.node(index, &node.name, &node.kind))
                }
                g #units {}
            }
        }
    }

    fn node(&self, index: usize, name: &str, kind: &NodeKind) -> Markup {
        let (at, size) = (self.placement.boxes[index], self.sizes[index]);
        let (x, y) = (at.x - size.width / 2.0, at.y - size.height / 2.0);
        let rounding = match kind {
            NodeKind::Source { .. } | NodeKind::Sink { .. } | NodeKind::Store { .. } => 14.0,
            NodeKind::Station(_) => 5.0,
            _ => 0.0,
        };
        let class = match kind {
            NodeKind::Station(_) => format!("node station {}", state_class(Activity::Idle)),
            _ => "node".to_owned(),
        };
        html! {
            g class=(class) data-node=(index) tabindex="0" role="img" aria-label=(format!("{} {name}", kind.word()))
                transform=(format!("translate({x:.1} {y:.1})")) {
                rect.body width=(number(size.width)) height=(number(size.height)) rx=(rounding) {}
                @if let NodeKind::Conveyor { places, .. } = kind {
                    @for place in 1..(*places).min(60) {
                        @let at = size.width * f64::from(place) / f64::from((*places).min(60));
                        line.place x1=(number(at)) x2=(number(at)) y1=(number(size.height - 31.0)) y2=(number(size.height - 18.0)) {}
                    }
                }
                text x=(number(size.width / 2.0)) y="15" { (name) }
                text.note x=(number(size.width / 2.0)) y="28" { (note(kind)) }
                text.count x=(number(size.width / 2.0)) y=(number(size.height - 5.0)) {}
                text.more x=(number(size.width - 5.0)) y=(number(size.height - 20.0)) {}
            }
        }
    }
}

/// Numbers of parts of each type, as text: `12 Bottle, 3 Can`.
pub(super) fn by_type(line: &Line, numbers: &[u64]) -> String {
    let types = line.parts.iter().zip(numbers).filter(|(_, n)| **n > 0);
    let types = types.map(|(part, number)| format!("{} {}", count(*number), part.name));
    let types: Vec<String> = types.collect();
    if types.is_empty() {
        "none".to_owned()
    } else {
        types.join(", ")
    }
}

/// Links without labels between these boxes.
fn unlabeled(links: &[(usize, usize)]) -> Vec<Link> {
    let label = Size::default();
    let links = links.iter();
    links.map(|&(from, to)| Link { from, to, label }).collect()
}

fn number(value: f64) -> String {
    format!("{value:.1}")
}

/// Size of a place in the picture. There is room for its name, a note, and its parts.
fn size(name: &str, kind: &NodeKind) -> Size {
    let text = name.chars().count() as f64 * 7.2 + 16.0;
    let text = text.max(note(kind).chars().count() as f64 * 5.4 + 14.0);
    let least = match kind {
        NodeKind::Conveyor { places, .. } => (f64::from(*places) * 9.0).clamp(90.0, 220.0),
        NodeKind::Buffer { .. } => 84.0,
        // Two numbers of parts.
        NodeKind::Store { .. } => 112.0,
        _ => 72.0,
    };
    Size {
        width: text.max(least).ceil(),
        height: 62.0,
    }
}

/// What stands below the name of a place.
fn note(kind: &NodeKind) -> String {
    if let NodeKind::Station(station) = kind
        && let Some(machine) = &station.machine
    {
        return machine.name.clone();
    }
    kind.description()
}
