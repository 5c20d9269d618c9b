//! A graph drawn in layers, as it is.

use super::Graph;
use super::canvas::{Canvas, FRAME, STATE_FONT, Shape, box_size, label_size};
use super::fold::place_in_rows;
use super::layers::{
    Direction, Frame, Link, Placement, Point, SIDE, Size, Spacing, place_in_frames,
};
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
        let placement = place_in_rows(&boxes, &links, SPACING);
        return drawn(graph, &Placed { placement, boxes }, Shape::Route);
    }
    let down = placed(graph, Direction::Down);
    let right = placed(graph, Direction::Right);
    let is_better = |a: &Placed, b: &Placed| {
        let over = |p: &Placed| (p.placement.size.width - limit).max(0.0);
        let area = |p: &Placed| p.placement.size.width * p.placement.size.height;
        (over(a), area(a)) < (over(b), area(b))
    };
    let placed = if is_better(&right, &down) {
        right
    } else {
        down
    };
    drawn(graph, &placed, Shape::Arrow)
}

/// A graph that has been placed.
struct Placed {
    placement: Placement,
    /// Size of each box.
    boxes: Vec<Size>,
}

/// Draws a graph that has been placed, with arrows of a kind.
fn drawn(graph: &Graph, placed: &Placed, arrow: fn(Vec<Point>) -> Shape) -> Canvas {
    let placement = &placed.placement;
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
        let at = title_at(number, text_size(&frame.title), graph, placed);
        canvas.lines(at, title, STATE_FONT, true);
    }
    let boxes = placement.boxes.iter().zip(&placed.boxes);
    for (number, (state, (at, size))) in graph.states.iter().zip(boxes).enumerate() {
        canvas.labeled_box(*at, *size, state, graph.style(number));
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
fn title_at(number: usize, size: Size, graph: &Graph, placed: &Placed) -> Point {
    let placement = &placed.placement;
    let frame = &placement.frames[number];
    let boxes = placement.boxes.iter().copied();
    let mut taken: Vec<(Point, Size)> = boxes.zip(placed.boxes.iter().copied()).collect();
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

/// Distance between the ends of the links of a crowded box, and the number of links on a side from
/// which on it is crowded.
const PITCH: f64 = 14.0;
const MANY: usize = 4;

/// Places a graph in layers. Boxes such as the components of a machine grow with the number of the
/// links on their sides, so that one can follow each of them.
fn placed(graph: &Graph, direction: Direction) -> Placed {
    let (mut boxes, links) = measured(graph);
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
    let place =
        |boxes: &[Size]| place_in_frames(boxes, &links, (&frames, &frame_of), direction, SPACING);
    let mut placement = place(&boxes);
    let is_automaton = graph.styles.is_empty();
    if !is_automaton && grow(&mut boxes, &links, &placement, direction) {
        placement = place(&boxes);
    }
    Placed { placement, boxes }
}

/// Enlarges the boxes that are crowded; returns whether there are any.
fn grow(boxes: &mut [Size], links: &[Link], placement: &Placement, direction: Direction) -> bool {
    // The numbers of links before and behind each box.
    let mut ends = vec![[0_usize; 2]; boxes.len()];
    for (link, placed) in links.iter().zip(&placement.links) {
        if link.from == link.to {
            continue;
        }
        let [Some(first), Some(last)] = [placed.points.first(), placed.points.last()] else {
            continue;
        };
        for (of, at) in [(link.from, first), (link.to, last)] {
            let center = placement.boxes[of];
            let is_behind = match direction {
                Direction::Down => at.y > center.y,
                Direction::Right => at.x > center.x,
            };
            ends[of][usize::from(is_behind)] += 1;
        }
    }
    let mut has_grown = false;
    for (size, [before, behind]) in boxes.iter_mut().zip(ends) {
        let count = before.max(behind);
        let side = match direction {
            Direction::Down => &mut size.width,
            Direction::Right => &mut size.height,
        };
        let wanted = count as f64 * PITCH / SIDE;
        if count > MANY && wanted > *side {
            *side = wanted;
            has_grown = true;
        }
    }
    has_grown
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

#[cfg(test)]
mod tests {
    use super::super::{BoxStyle, Edge};
    use super::*;

    /// A coordinator with a wire to each of its components, and one back.
    fn star(components: usize, style: BoxStyle) -> Graph {
        let edge = |from, to| Edge {
            from: Some(from),
            to,
            label: vec!["command".to_owned()],
        };
        let links = (1..=components).flat_map(|to| [edge(0, to), edge(to, 0)]);
        let is_automaton = style == BoxStyle::State;
        Graph {
            states: (0..=components).map(|n| vec![format!("box {n}")]).collect(),
            edges: links.collect(),
            styles: vec![style; if is_automaton { 0 } else { components + 1 }],
            ..Graph::default()
        }
    }

    /// The least distance between the ends of two links on a side of the first box.
    fn distance(graph: &Graph, direction: Direction) -> f64 {
        let placed = placed(graph, direction);
        let links = graph.edges.iter().zip(&placed.placement.links);
        let ends = links.filter_map(|(edge, link)| match edge.from {
            Some(0) => link.points.first(),
            _ => link.points.last(),
        });
        let side = |at: &Point| match direction {
            Direction::Down => (at.y, at.x),
            Direction::Right => (at.x, at.y),
        };
        let mut ends: Vec<(f64, f64)> = ends.map(side).collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let pairs = ends
            .windows(2)
            .filter(|pair| (pair[0].0 - pair[1].0).abs() < 0.1);
        pairs.fold(f64::MAX, |least, pair| least.min(pair[1].1 - pair[0].1))
    }

    #[test]
    fn a_box_grows_with_the_number_of_its_links() {
        for direction in [Direction::Down, Direction::Right] {
            let busy = distance(&star(10, BoxStyle::Block), direction);
            assert!(busy > PITCH - 0.1, "{busy}");
            let automaton = distance(&star(10, BoxStyle::State), direction);
            assert!(automaton < PITCH, "{automaton}");
            // Few links leave a box as small as its label.
            let graph = star(1, BoxStyle::Block);
            assert_eq!(placed(&graph, direction).boxes, measured(&graph).0);
        }
    }
}
