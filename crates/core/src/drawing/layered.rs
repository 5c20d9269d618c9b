//! A graph drawn in layers, as it is.

use super::Graph;
use super::canvas::{
    Canvas, FRAME, STATE_FONT, Shape, background_size, box_size, flattened, label_size,
};
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
        let mut placed = Placed { placement, boxes };
        settle_labels(graph, &mut placed, false);
        return drawn(graph, &placed, Shape::Route);
    }
    let down = placed(graph, Direction::Down);
    let right = placed(graph, Direction::Right);
    let is_better = |a: &Placed, b: &Placed| {
        let over = |p: &Placed| (p.placement.size.width - limit).max(0.0);
        let area = |p: &Placed| p.placement.size.width * p.placement.size.height;
        (over(a), area(a)) < (over(b), area(b))
    };
    let mut placed = if is_better(&right, &down) {
        right
    } else {
        down
    };
    settle_labels(graph, &mut placed, true);
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
    // A label interrupts its own arrow, and other arrows only if it cannot be avoided.
    for number in order_of_links(graph, placement) {
        let link = &placement.links[number];
        canvas.shapes.push(arrow(link.points.clone()));
        if let Some(at) = link.label {
            canvas.background(at, &graph.edges[number].label);
        }
    }
    // All arrows are below the texts of all labels.
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

/// Moves labels that links of others lead through along their own links, or loops' labels a little,
/// to where the fewest do.
fn settle_labels(graph: &Graph, placed: &mut Placed, is_curved: bool) {
    let placement = &placed.placement;
    let ways = placement.links.iter().map(|link| {
        let points = if is_curved {
            flattened(&link.points)
        } else {
            link.points.clone()
        };
        Way::new(points_along(&points).collect())
    });
    let ways: Vec<Way> = ways.collect();
    let boxes = placement.boxes.iter().copied();
    let mut taken: Vec<(Point, Size)> = boxes.zip(placed.boxes.iter().copied()).collect();
    let frames = graph.frames.iter().zip(&placement.frames);
    taken.extend(frames.map(|(frame, of)| (of.title, text_size(&frame.title))));
    let whole = placement.size;
    let mut labels: Vec<Option<(Point, Size)>> = graph
        .edges
        .iter()
        .zip(&placement.links)
        .map(|(edge, link)| Some((link.label?, background_size(&edge.label))))
        .collect();
    for number in 0..labels.len() {
        let Some((at, size)) = labels[number] else {
            continue;
        };
        let crossed = |at: Point| {
            let others = ways.iter().enumerate();
            let others = others.filter(|(other, _)| *other != number);
            others
                .filter(|(_, way)| way.leads_through(at, size))
                .count()
        };
        let now = crossed(at);
        if now == 0 {
            continue;
        }
        let is_free = |at: Point| {
            let half = Size {
                width: size.width / 2.0,
                height: size.height / 2.0,
            };
            let is_inside = at.x >= half.width
                && at.y >= half.height
                && at.x + half.width <= whole.width
                && at.y + half.height <= whole.height;
            let labels = labels.iter().enumerate();
            let labels = labels.filter(|(other, _)| *other != number);
            let labels = labels.filter_map(|(_, label)| *label);
            let mut others = taken.iter().copied().chain(labels);
            is_inside
                && others.all(|(other, other_size)| {
                    (at.x - other.x).abs() >= half.width + other_size.width / 2.0 + CLEAR
                        || (at.y - other.y).abs() >= half.height + other_size.height / 2.0 + CLEAR
                })
        };
        let edge = &graph.edges[number];
        let candidates: Vec<Point> = if edge.from == Some(edge.to) {
            around(at)
        } else {
            ways[number].points.clone()
        };
        let distance = |to: Point| (to.x - at.x).hypot(to.y - at.y);
        let best = candidates
            .into_iter()
            .filter(|to| is_free(*to))
            .map(|to| (crossed(to), distance(to), to))
            .min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        if let Some((_, _, to)) = best.filter(|(count, ..)| *count < now) {
            labels[number] = Some((to, size));
        }
    }
    for (link, label) in placed.placement.links.iter_mut().zip(labels) {
        link.label = label.map(|(at, _)| at);
    }
}

/// Distance between a label that was moved and what is beside it, in SVG units.
const CLEAR: f64 = 3.0;

/// Points along a link, and the frame around them.
struct Way {
    points: Vec<Point>,
    least: Point,
    greatest: Point,
}

impl Way {
    fn new(points: Vec<Point>) -> Self {
        let all = |start: f64, pick: fn(f64, f64) -> f64| Point {
            x: points.iter().map(|at| at.x).fold(start, pick),
            y: points.iter().map(|at| at.y).fold(start, pick),
        };
        Self {
            least: all(f64::INFINITY, f64::min),
            greatest: all(f64::NEG_INFINITY, f64::max),
            points,
        }
    }

    /// Whether the link leads through a rectangle around a center.
    fn leads_through(&self, at: Point, size: Size) -> bool {
        let (wide, high) = (size.width / 2.0, size.height / 2.0);
        if at.x + wide < self.least.x
            || at.x - wide > self.greatest.x
            || at.y + high < self.least.y
            || at.y - high > self.greatest.y
        {
            return false;
        }
        let is_near = |of: &Point| (of.x - at.x).abs() <= wide && (of.y - at.y).abs() <= high;
        self.points.iter().any(is_near)
    }
}

/// Places around a point, for the label of a loop.
fn around(at: Point) -> Vec<Point> {
    let steps = || (-4..=4).map(|step| f64::from(step) * STEP);
    let across = steps().filter(|x| *x >= 0.0);
    let places = across.flat_map(|x| {
        steps().map(move |y| Point {
            x: at.x + x,
            y: at.y + y,
        })
    });
    places.collect()
}

/// The order in which links are drawn: one comes before those that lead over its label, as far as
/// possible.
fn order_of_links(graph: &Graph, placement: &Placement) -> Vec<usize> {
    let links = &placement.links;
    let leads_over = |over: usize, number: usize| {
        let Some(label) = links[number].label else {
            return false;
        };
        let size = background_size(&graph.edges[number].label);
        let is_near = |at: Point| {
            (at.x - label.x).abs() <= size.width / 2.0
                && (at.y - label.y).abs() <= size.height / 2.0
        };
        over != number && points_along(&links[over].points).any(is_near)
    };
    // By link: those that lead over its label.
    let mut after: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    let mut before = vec![0_usize; links.len()];
    for (number, after) in after.iter_mut().enumerate() {
        for over in (0..links.len()).filter(|over| leads_over(*over, number)) {
            after.push(over);
            before[over] += 1;
        }
    }
    let mut left: Vec<usize> = (0..links.len()).collect();
    let mut order = Vec::with_capacity(links.len());
    while let Some(place) = (0..left.len()).min_by_key(|place| before[left[*place]]) {
        let number = left.remove(place);
        for over in &after[number] {
            before[*over] -= 1;
        }
        order.push(number);
    }
    order
}

/// Points along straight pieces, at most a [`STEP`] apart.
fn points_along(points: &[Point]) -> impl Iterator<Item = Point> + '_ {
    points.windows(2).flat_map(|piece| {
        let (from, to) = (piece[0], piece[1]);
        let count = ((to.x - from.x).hypot(to.y - from.y) / STEP).ceil();
        (0..=count as usize).map(move |step| {
            let part = step as f64 / count.max(1.0);
            Point {
                x: from.x + (to.x - from.x) * part,
                y: from.y + (to.y - from.y) * part,
            }
        })
    })
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
        taken.extend(points_along(&link.points).map(|at| (at, Size::default())));
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
    if !is_automaton {
        straighten(&links, &mut placement, direction);
    }
    Placed { placement, boxes }
}

/// How far the links at a crowded side lead straight away from the box, and where they then bend;
/// at most these parts of the way to the next layer.
const STRAIGHT: [f64; 2] = [12.0, 24.0];
const STRAIGHT_PARTS: [f64; 2] = [0.4, 0.8];

/// Lets the links at the crowded sides of boxes end at right angles to them: steep ones would lie
/// on one another, with their heads.
fn straighten(links: &[Link], placement: &mut Placement, direction: Direction) {
    let ends = link_ends(links, placement, direction);
    for (number, link) in links.iter().enumerate() {
        let sides = sides_of(link, &placement.links[number].points, placement, direction);
        let Some(sides) = sides else { continue };
        let is_crowded = |end: usize| {
            let (of, is_behind) = sides[end];
            ends[of][usize::from(is_behind)] > MANY
        };
        // The points at which a link is straight, and bends, from its end on.
        let straight = |end: Point, next: Point, is_behind: bool| {
            let gap = match direction {
                Direction::Down => (next.y - end.y).abs(),
                Direction::Right => (next.x - end.x).abs(),
            };
            let sign = if is_behind { 1.0 } else { -1.0 };
            [0, 1].map(|bend| {
                let distance = sign * STRAIGHT[bend].min(STRAIGHT_PARTS[bend] * gap);
                match direction {
                    Direction::Down => Point {
                        y: end.y + distance,
                        ..end
                    },
                    Direction::Right => Point {
                        x: end.x + distance,
                        ..end
                    },
                }
            })
        };
        let crowded = [is_crowded(0), is_crowded(1)];
        let points = &mut placement.links[number].points;
        let last = points.len();
        if crowded[1] {
            let [near, far] = straight(points[last - 1], points[last - 2], sides[1].1);
            points.splice(last - 1..last - 1, [far, near]);
        }
        if crowded[0] {
            let bends = straight(points[0], points[1], sides[0].1);
            points.splice(1..1, bends);
        }
    }
}

/// The box at each end of a link, and whether the end is behind its center; `None` for a loop.
fn sides_of(
    link: &Link,
    points: &[Point],
    placement: &Placement,
    direction: Direction,
) -> Option<[(usize, bool); 2]> {
    if link.from == link.to {
        return None;
    }
    let ends = [(link.from, points.first()?), (link.to, points.last()?)];
    Some(ends.map(|(of, at)| {
        let center = placement.boxes[of];
        let is_behind = match direction {
            Direction::Down => at.y > center.y,
            Direction::Right => at.x > center.x,
        };
        (of, is_behind)
    }))
}

/// By box: the numbers of the links that end before and behind its center.
fn link_ends(links: &[Link], placement: &Placement, direction: Direction) -> Vec<[usize; 2]> {
    let mut ends = vec![[0_usize; 2]; placement.boxes.len()];
    let placed = links.iter().zip(&placement.links);
    let sides = placed.filter_map(|(link, of)| sides_of(link, &of.points, placement, direction));
    for (of, is_behind) in sides.flatten() {
        ends[of][usize::from(is_behind)] += 1;
    }
    ends
}

/// Enlarges the boxes that are crowded; returns whether there are any.
fn grow(boxes: &mut [Size], links: &[Link], placement: &Placement, direction: Direction) -> bool {
    let ends = link_ends(links, placement, direction);
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
    use super::super::layers::PlacedLink;
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
    fn links_of_a_crowded_box_end_at_right_angles() {
        let graph = star(10, BoxStyle::Block);
        let placed = placed(&graph, Direction::Right);
        for (edge, link) in graph.edges.iter().zip(&placed.placement.links) {
            let count = link.points.len();
            let (end, next) = match edge.from {
                Some(0) => (link.points[0], link.points[1]),
                _ => (link.points[count - 1], link.points[count - 2]),
            };
            assert!((end.y - next.y).abs() < 0.1 && (end.x - next.x).abs() > 1.0);
        }
    }

    #[test]
    fn a_label_does_not_interrupt_the_links_of_others() {
        let edge = |from, to, label: &str| Edge {
            from: Some(from),
            to,
            label: vec![label.to_owned()],
        };
        let graph = Graph {
            states: vec![vec!["a".to_owned()], vec!["b".to_owned()]],
            edges: vec![edge(0, 1, "over"), edge(0, 1, "under")],
            ..Graph::default()
        };
        let point = |x, y| Point { x, y };
        let link = |points: &[Point], label| PlacedLink {
            points: points.to_vec(),
            label: Some(label),
        };
        let placement = Placement {
            size: Size::default(),
            boxes: Vec::new(),
            // The first leads through the label of the second.
            links: vec![
                link(&[point(0.0, 0.0), point(100.0, 0.0)], point(20.0, 0.0)),
                link(&[point(80.0, -50.0), point(80.0, 50.0)], point(80.0, 0.0)),
            ],
            frames: Vec::new(),
        };
        assert_eq!(order_of_links(&graph, &placement), [1, 0]);
    }

    #[test]
    fn a_label_makes_way_for_the_links_of_others() {
        let edge = |label: &[&str]| Edge {
            from: Some(0),
            to: 1,
            label: label.iter().map(|line| (*line).to_owned()).collect(),
        };
        let graph = Graph {
            states: vec![vec!["a".to_owned()], vec!["b".to_owned()]],
            edges: vec![edge(&["crossed"]), edge(&[])],
            ..Graph::default()
        };
        let point = |x, y| Point { x, y };
        let link = |points: &[Point], label| PlacedLink {
            points: points.to_vec(),
            label,
        };
        let size = Size {
            width: 300.0,
            height: 100.0,
        };
        for is_curved in [false, true] {
            let mut placed = Placed {
                placement: Placement {
                    size,
                    boxes: vec![point(10.0, 50.0), point(290.0, 50.0)],
                    links: vec![
                        link(
                            &[point(20.0, 50.0), point(280.0, 50.0)],
                            Some(point(150.0, 50.0)),
                        ),
                        link(&[point(150.0, 0.0), point(150.0, 100.0)], None),
                    ],
                    frames: Vec::new(),
                },
                boxes: vec![START; 2],
            };
            settle_labels(&graph, &mut placed, is_curved);
            let label = placed.placement.links[0].label.expect("a label");
            let width = background_size(&graph.edges[0].label).width;
            assert!((label.x - 150.0).abs() > width / 2.0);
            assert!((label.y - 50.0).abs() < 1e-9);
            assert!((label.x - 150.0).abs() < width / 2.0 + 2.0 * STEP);
            let settled = placed.placement.links.clone();
            settle_labels(&graph, &mut placed, is_curved);
            assert_eq!(placed.placement.links, settled);
        }
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
