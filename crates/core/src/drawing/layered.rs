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
    // A graph in rows has no frames.
    let frames = graph.frames.iter().zip(&placement.frames);
    for (number, (frame, _)) in frames.enumerate() {
        let title = std::slice::from_ref(&frame.title);
        let at = title_at(number, text_size(&frame.title), graph, placement);
        canvas.lines(at, title, STATE_FONT, true);
    }
    for (number, (state, at)) in graph.states.iter().zip(&placement.boxes).enumerate() {
        canvas.labeled_box(*at, state, graph.style(number));
    }
    let start = placement.boxes.get(graph.states.len());
    canvas.shapes.extend(start.map(|at| Shape::Dot(*at)));
    canvas
}

/// Distance between places for a title that are tried, and between points of a link that are
/// looked at, in SVG units.
const STEP: f64 = 5.0;

/// The center of the title of a frame: at the top of it where nothing is in the way, as far to the
/// left as possible; else the place that is reserved for it.
fn title_at(number: usize, size: Size, graph: &Graph, placement: &Placement) -> Point {
    let frame = &placement.frames[number];
    let mut taken: Vec<(Point, Size)> = Vec::new();
    let boxes = placement.boxes.iter().enumerate();
    taken.extend(boxes.map(|(state, at)| match graph.states.get(state) {
        Some(label) => (*at, box_size(label, graph.style(state))),
        None => (*at, START),
    }));
    for (edge, link) in graph.edges.iter().zip(&placement.links) {
        taken.extend(link.label.map(|at| (at, label_size(&edge.label))));
        for piece in link.points.windows(2) {
            let (from, to) = (piece[0], piece[1]);
            let count = ((to.x - from.x).hypot(to.y - from.y) / STEP).ceil();
            for step in 0..=count as usize {
                let part = step as f64 / count.max(1.0);
                let x = from.x + (to.x - from.x) * part;
                let y = from.y + (to.y - from.y) * part;
                taken.push((Point { x, y }, Size::default()));
            }
        }
    }
    for (other, placed) in placement.frames.iter().enumerate() {
        let is_inside =
            placed.size.width * placed.size.height < frame.size.width * frame.size.height;
        if other != number {
            taken.push((placed.title, text_size(&graph.frames[other].title)));
            taken.extend(is_inside.then_some((placed.center, placed.size)));
        }
    }
    let is_free = |at: &Point| {
        taken.iter().all(|(other, other_size)| {
            (at.x - other.x).abs() >= f64::midpoint(size.width, other_size.width)
                || (at.y - other.y).abs() >= f64::midpoint(size.height, other_size.height)
        })
    };
    let (left, top) = (
        frame.center.x - (frame.size.width - size.width) / 2.0,
        frame.center.y - (frame.size.height - size.height) / 2.0,
    );
    let count = ((frame.size.width - size.width) / STEP).max(0.0) as usize;
    let mut places = (0..=count).map(|step| Point {
        x: left + step as f64 * STEP,
        y: top,
    });
    places.find(is_free).unwrap_or(frame.title)
}

fn text_size(title: &str) -> Size {
    text::size(&[title.to_owned()], STATE_FONT, true)
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
        title: text_size(&frame.title),
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
