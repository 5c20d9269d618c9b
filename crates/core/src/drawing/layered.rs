//! A graph drawn in layers, as it is.

use super::Graph;
use super::canvas::{Canvas, FRAME, STATE_FONT, Shape, box_size, label_size};
use super::fold::place_in_rows;
use super::layers::{Direction, Frame, Link, Placement, Point, Size, Spacing, place_in_frames};
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

/// The way in which a graph is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// From top to bottom or from left to right, whichever fits better.
    Layers,
    /// From left to right, folded into rows; without frames.
    Rows,
}

/// Draws a graph, in layers in the direction in which it fits better into a width in SVG units.
pub(super) fn draw(graph: &Graph, form: Form, limit: f64) -> Canvas {
    if form == Form::Rows {
        let (boxes, links) = measured(graph);
        return drawn(graph, &place_in_rows(&boxes, &links, SPACING), Shape::Route);
    }
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
    drawn(graph, &placement, Shape::Arrow)
}

/// Draws a graph that has been placed, with arrows of a kind.
fn drawn(graph: &Graph, placement: &Placement, arrow: fn(Vec<Point>) -> Shape) -> Canvas {
    let mut canvas = Canvas {
        size: placement.size,
        shapes: Vec::new(),
    };
    for frame in &placement.frames {
        canvas.rectangle(frame.center, frame.size, FRAME);
    }
    // All arrows are below all labels.
    for link in &placement.links {
        canvas.shapes.push(arrow(link.points.clone()));
    }
    for (edge, link) in graph.edges.iter().zip(&placement.links) {
        if let Some(at) = link.label {
            canvas.label(at, &edge.label);
        }
    }
    for (frame, placed) in graph.frames.iter().zip(&placement.frames) {
        let title = std::slice::from_ref(&frame.title);
        canvas.lines(placed.title, title, STATE_FONT, true);
    }
    for (number, (state, at)) in graph.states.iter().zip(&placement.boxes).enumerate() {
        canvas.labeled_box(*at, state, graph.style(number));
    }
    let start = placement.boxes.get(graph.states.len());
    canvas.shapes.extend(start.map(|at| Shape::Dot(*at)));
    canvas
}

/// Places a graph in layers.
fn placed(graph: &Graph, direction: Direction) -> Placement {
    let (boxes, links) = measured(graph);
    let mut frame_of = vec![None; boxes.len()];
    for (number, frame) in graph.frames.iter().enumerate() {
        for state in &frame.states {
            frame_of[*state] = Some(number);
        }
    }
    let frames = graph.frames.iter().map(|frame| Frame {
        title: text::size(std::slice::from_ref(&frame.title), STATE_FONT, true),
        parent: frame.parent,
    });
    let frames: Vec<Frame> = frames.collect();
    place_in_frames(&boxes, &links, (&frames, &frame_of), direction, SPACING)
}

/// The sizes of the boxes and the links of a graph. The dot is the last box.
fn measured(graph: &Graph) -> (Vec<Size>, Vec<Link>) {
    let states = graph.states.iter().enumerate();
    let mut boxes: Vec<Size> = states
        .map(|(number, label)| box_size(label, graph.style(number)))
        .collect();
    if graph.edges.iter().any(|edge| edge.from.is_none()) {
        boxes.push(START);
    }
    let links = graph.edges.iter().map(|edge| Link {
        from: edge.from.unwrap_or(graph.states.len()),
        to: edge.to,
        label: label_size(&edge.label),
    });
    (boxes, links.collect())
}
