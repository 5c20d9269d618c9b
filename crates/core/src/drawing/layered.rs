//! A graph drawn in layers, as it is.

use super::Graph;
use super::canvas::{BACKGROUND, Canvas, LABEL_FONT, STATE, STATE_FONT, Shape};
use super::layers::{Direction, Link, Placement, Size, Spacing, place};
use super::text;

/// Size of the dot from which the edges to the initial states begin.
const START: Size = Size {
    width: 10.0,
    height: 10.0,
};

const SPACING: Spacing = Spacing {
    boxes: 24.0,
    links: 14.0,
    layers: 28.0,
};

/// Draws a graph in the direction in which it fits better into a width in SVG units.
pub(super) fn draw(graph: &Graph, limit: f64) -> Canvas {
    let down = placed(graph, Direction::Down);
    let right = placed(graph, Direction::Right);
    let is_better = |a: &Placement, b: &Placement| {
        let over = |p: &Placement| (p.size.width - limit).max(0.0);
        let area = |p: &Placement| p.size.width * p.size.height;
        (over(a), area(a)) < (over(b), area(b))
    };
    let placement = if is_better(&right, &down) {
        right
    } else {
        down
    };
    let mut canvas = Canvas {
        size: placement.size,
        shapes: Vec::new(),
    };
    for (edge, link) in graph.edges.iter().zip(&placement.links) {
        canvas.shapes.push(Shape::Arrow(link.points.clone()));
        if let Some(at) = link.label {
            let size = text::size(&edge.label, LABEL_FONT, false);
            let inner = Size {
                width: size.width - 12.0,
                height: size.height - 8.0,
            };
            canvas.rectangle(at, inner, BACKGROUND);
            canvas.lines(at, &edge.label, LABEL_FONT, false);
        }
    }
    // All arrows are below all labels.
    canvas
        .shapes
        .sort_by_key(|shape| !matches!(shape, Shape::Arrow(_)));
    for (state, at) in graph.states.iter().zip(&placement.boxes) {
        canvas.rectangle(*at, text::size(state, STATE_FONT, true), STATE);
        canvas.lines(*at, state, STATE_FONT, true);
    }
    let start = placement.boxes.get(graph.states.len());
    canvas.shapes.extend(start.map(|at| Shape::Dot(*at)));
    canvas
}

/// Places a graph. The dot is the last box.
fn placed(graph: &Graph, direction: Direction) -> Placement {
    let states = graph.states.iter();
    let mut boxes: Vec<Size> = states
        .map(|label| text::size(label, STATE_FONT, true))
        .collect();
    if graph.edges.iter().any(|edge| edge.from.is_none()) {
        boxes.push(START);
    }
    let links = graph.edges.iter().map(|edge| Link {
        from: edge.from.unwrap_or(graph.states.len()),
        to: edge.to,
        label: if edge.label.is_empty() {
            Size::default()
        } else {
            text::size(&edge.label, LABEL_FONT, false)
        },
    });
    place(&boxes, &links.collect::<Vec<_>>(), direction, SPACING)
}
