//! Places boxes and their links in layers, so that most links lead the same way and few of them
//! cross: the method of Sugiyama, Tagawa and Toda ("Methods for visual understanding of
//! hierarchical system structures", 1981), by the package dagre. It assigns layers by a network
//! simplex (Gansner and others, "A technique for drawing directed graphs", 1993) and coordinates by
//! the method of Brandes and Köpf (2002). Labels take part in the placement like boxes, so they
//! overlap neither boxes nor each other.

use dagre::graph::{Graph, GraphOptions};
use dagre::{EdgeLabel, LayoutOptions, NodeLabel, RankDir};
use std::collections::BTreeMap;

/// Width and height in SVG units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Size {
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

/// A point in SVG units. `y` grows downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Distance from the left.
    pub x: f64,
    /// Distance from the top.
    pub y: f64,
}

/// A link between two boxes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Index of the box where it begins.
    pub from: usize,
    /// Index of the box where it ends; the same as `from` for a loop.
    pub to: usize,
    /// Size of its label; 0 by 0 without one.
    pub label: Size,
}

/// The way in which the layers follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From top to bottom.
    Down,
    /// From left to right.
    Right,
}

/// Where boxes and links are. All coordinates lie between 0 and `size`.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Size of the whole.
    pub size: Size,
    /// Center of each box.
    pub boxes: Vec<Point>,
    /// Each link.
    pub links: Vec<PlacedLink>,
    /// Each frame.
    pub frames: Vec<PlacedFrame>,
}

/// A frame around boxes and other frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Size of its title.
    pub title: Size,
    /// Index of the frame around it.
    pub parent: Option<usize>,
}

/// Where a frame is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedFrame {
    /// Its center.
    pub center: Point,
    /// Its size.
    pub size: Size,
    /// Center of its title, which is inside.
    pub title: Point,
}

/// Where a link is.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedLink {
    /// Its bends, from the border of one box to that of the other; at least two points.
    pub points: Vec<Point>,
    /// Center of its label; `None` if it has none.
    pub label: Option<Point>,
}

/// Distances between what is placed, in SVG units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// Between boxes of one layer.
    pub boxes: f64,
    /// Between links, and between a link and a box, in one layer.
    pub links: f64,
    /// Between layers.
    pub layers: f64,
}

/// Places boxes of these sizes. The same input gives the same placement. Takes some milliseconds
/// for a hundred boxes and links; the time grows with the square of their number, or faster.
pub fn place(boxes: &[Size], links: &[Link], direction: Direction, spacing: Spacing) -> Placement {
    place_in_frames(boxes, links, (&[], &[]), direction, spacing)
}

/// Places boxes as [`place`] does, some of them in frames: `frames` has these, and the index of the
/// innermost frame of each box. The title of a frame is placed in it like a box, so that nothing
/// overlaps it.
pub fn place_in_frames(
    boxes: &[Size],
    links: &[Link],
    (frames, frame_of): (&[Frame], &[Option<usize>]),
    direction: Direction,
    spacing: Spacing,
) -> Placement {
    let mut graph: Graph<NodeLabel, EdgeLabel> = Graph::with_options(GraphOptions {
        directed: true,
        multigraph: true,
        compound: !frames.is_empty(),
    });
    // Names of one length keep their order in every sorted container.
    let name = |index: usize| format!("{index:08}");
    let frame_name = |index: usize| format!("frame {index:08}");
    let all: Vec<Size> = boxes
        .iter()
        .copied()
        .chain(frames.iter().map(|frame| frame.title))
        .collect();
    for (index, size) in all.iter().enumerate() {
        let label = NodeLabel {
            width: size.width,
            height: size.height,
            ..NodeLabel::default()
        };
        graph.set_node(name(index), Some(label));
    }
    for (index, link) in links.iter().enumerate() {
        let label = EdgeLabel {
            width: link.label.width,
            height: link.label.height,
            labelpos: dagre::layout::types::LabelPos::Center,
            ..EdgeLabel::default()
        };
        let (from, to, number) = (name(link.from), name(link.to), name(index));
        graph.set_edge(from, to, Some(label), Some(&number));
    }
    for (index, frame) in frames.iter().enumerate() {
        graph.set_node(frame_name(index), Some(NodeLabel::default()));
        if let Some(parent) = frame.parent {
            graph.set_parent(&frame_name(index), Some(&frame_name(parent)));
        }
        graph.set_parent(&name(boxes.len() + index), Some(&frame_name(index)));
    }
    for (index, frame) in frame_of.iter().enumerate() {
        if let Some(frame) = frame {
            graph.set_parent(&name(index), Some(&frame_name(*frame)));
        }
    }
    let options = LayoutOptions {
        rankdir: match direction {
            Direction::Down => RankDir::TB,
            Direction::Right => RankDir::LR,
        },
        nodesep: spacing.boxes,
        edgesep: spacing.links,
        ranksep: spacing.layers,
        ..LayoutOptions::default()
    };
    dagre::layout(&mut graph, Some(options));

    let center = |name: &str| {
        let placed = graph.node(name);
        let x = placed.and_then(|placed| placed.x).unwrap_or(0.0);
        let y = placed.and_then(|placed| placed.y).unwrap_or(0.0);
        Point { x, y }
    };
    let centers: Vec<Point> = (0..boxes.len()).map(|b| center(&name(b))).collect();
    let placed_frames = (0..frames.len()).map(|index| {
        let placed = graph.node(&frame_name(index));
        PlacedFrame {
            center: center(&frame_name(index)),
            size: placed.map_or(Size::default(), |placed| Size {
                width: placed.width,
                height: placed.height,
            }),
            title: center(&name(boxes.len() + index)),
        }
    });
    let placed_frames: Vec<PlacedFrame> = placed_frames.collect();
    let edge = |index: usize| {
        let link = &links[index];
        graph.edge(&name(link.from), &name(link.to), Some(&name(index)))
    };
    let ways = links.iter().enumerate().map(|(index, link)| {
        let points = edge(index).map_or(&[][..], |edge| &edge.points);
        if points.len() < 2 {
            return vec![centers[link.from], centers[link.to]];
        }
        points.iter().map(|p| Point { x: p.x, y: p.y }).collect()
    });
    let mut ways: Vec<Vec<Point>> = ways.collect();
    spread_ends(&mut ways, links, (&centers, boxes), direction);
    let placed_links = links
        .iter()
        .zip(ways)
        .enumerate()
        .map(|(index, (link, points))| {
            let has_label = link.label.width > 0.0;
            let label = edge(index).and_then(|edge| {
                Some(Point {
                    x: edge.x?,
                    y: edge.y?,
                })
            });
            let label = label.filter(|_| has_label);
            PlacedLink {
                points: through_label(points, label, link.label, direction),
                label,
            }
        });
    let mut placed_links: Vec<PlacedLink> = placed_links.collect();
    place_loops(
        boxes,
        links,
        &centers,
        direction,
        spacing,
        &mut placed_links,
    );
    let placement = Placement {
        size: Size::default(),
        boxes: centers,
        links: placed_links,
        frames: placed_frames,
    };
    moved_to_origin(boxes, links, placement)
}

/// The part of a side on which links end, in proportion to it: not at the corners.
pub(super) const SIDE: f64 = 0.7;

/// One of the two ends of a link.
struct LinkEnd {
    /// Where the link goes on, along the layer.
    next: f64,
    /// Index of the link.
    number: usize,
    /// Whether the link ends here, and does not begin.
    is_end: bool,
}

/// Spreads the ends of links over the sides of their boxes that face the neighboring layers, in the
/// order in which the links go on. From the other sides, a steep link would cross the next boxes of
/// the same layer. `ways` has the points of each link; loops stay as they are.
fn spread_ends(
    ways: &mut [Vec<Point>],
    links: &[Link],
    (centers, sizes): (&[Point], &[Size]),
    direction: Direction,
) {
    // `along` runs from layer to layer, `across` along a layer.
    let split = |at: Point| match direction {
        Direction::Down => (at.y, at.x),
        Direction::Right => (at.x, at.y),
    };
    // By box and side: the links that end there.
    let mut sides: BTreeMap<(usize, bool), Vec<LinkEnd>> = BTreeMap::new();
    for (number, (way, link)) in ways.iter().zip(links).enumerate() {
        let &[_, second, ..] = way.as_slice() else {
            continue;
        };
        let before_last = way[way.len() - 2];
        for (of, next, is_end) in [(link.from, second, false), (link.to, before_last, true)] {
            let ((along, across), (center, _)) = (split(next), split(centers[of]));
            let half = match direction {
                Direction::Down => sizes[of].height / 2.0,
                Direction::Right => sizes[of].width / 2.0,
            };
            if link.from != link.to && (along - center).abs() > half {
                let side = sides.entry((of, along > center)).or_default();
                side.push(LinkEnd {
                    next: across,
                    number,
                    is_end,
                });
            }
        }
    }
    for ((of, is_far), mut ends) in sides {
        ends.sort_by(|a, b| a.next.total_cmp(&b.next).then(a.number.cmp(&b.number)));
        let count = ends.len() as f64;
        let Size { width, height } = sizes[of];
        let sign = if is_far { 0.5 } else { -0.5 };
        for (index, link_end) in ends.into_iter().enumerate() {
            let LinkEnd {
                next,
                number,
                is_end,
            } = link_end;
            let share = ((index as f64 + 0.5) / count - 0.5) * SIDE;
            let way = &mut ways[number];
            let place = if is_end { way.len() - 1 } else { 0 };
            let (_, center) = split(centers[of]);
            // The only link of a side leads straight on, as far as the side allows it.
            let offset = |side: f64| match count {
                1.0 => (next - center).clamp(-SIDE * side / 2.0, SIDE * side / 2.0),
                _ => share * side,
            };
            way[place] = match direction {
                Direction::Down => Point {
                    x: center + offset(width),
                    y: centers[of].y + sign * height,
                },
                Direction::Right => Point {
                    x: centers[of].x + sign * width,
                    y: center + offset(height),
                },
            };
        }
    }
}

/// Makes a link straight where it passes its label, so that a smooth curve passes its center.
fn through_label(
    points: Vec<Point>,
    label: Option<Point>,
    size: Size,
    direction: Direction,
) -> Vec<Point> {
    let is_label = |at: &Point| {
        label.is_some_and(|label| (label.x - at.x).abs() < 0.1 && (label.y - at.y).abs() < 0.1)
    };
    let Some(index) = points.iter().position(is_label) else {
        return points;
    };
    let center = points[index];
    let shifted = |part: f64| match direction {
        Direction::Down => Point {
            y: center.y + part * size.height,
            ..center
        },
        Direction::Right => Point {
            x: center.x + part * size.width,
            ..center
        },
    };
    // Links that lead back have their points in the other order.
    let before = if index == 0 {
        center
    } else {
        points[index - 1]
    };
    let is_back = match direction {
        Direction::Down => before.y > center.y,
        Direction::Right => before.x > center.x,
    };
    let half = if is_back { -0.5 } else { 0.5 };
    let mut result = points;
    result.splice(index..=index, [shifted(-half), center, shifted(half)]);
    result
}

/// Distance between a loop and its label, and between the loops of one box, in SVG units.
const LOOP_DISTANCE: f64 = 4.0;

/// Moves the labels of loops to their box, and leads the loops through the gap between them, in
/// place of the way of dagre, which ends behind the middle of the label. A further loop of the
/// same box goes round the labels of those before it.
fn place_loops(
    boxes: &[Size],
    links: &[Link],
    centers: &[Point],
    direction: Direction,
    spacing: Spacing,
    placed: &mut [PlacedLink],
) {
    // Dagre places the labels of loops beside the box in its layer, with nothing between them.
    // `across` runs along the layer.
    let across_along = |x: f64, y: f64| match direction {
        Direction::Down => (x, y),
        Direction::Right => (y, x),
    };
    let point = |across: f64, along: f64| {
        let (x, y) = across_along(across, along);
        Point { x, y }
    };
    let gap = f64::midpoint(spacing.boxes, spacing.links);
    for (index, center) in centers.iter().enumerate() {
        let is_own = |number: &usize| links[*number].from == index && links[*number].to == index;
        let middle = |number: usize| {
            let link = &placed[number];
            let inner = link.points.get(link.points.len() / 2);
            let at = link.label.or(inner.copied()).unwrap_or(*center);
            across_along(at.x, at.y).0
        };
        let loops = (0..links.len()).filter(is_own);
        let mut loops: Vec<(f64, usize)> = loops.map(|number| (middle(number), number)).collect();
        loops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (half_width, half_height) =
            across_along(boxes[index].width / 2.0, boxes[index].height / 2.0);
        let (at, along) = across_along(center.x, center.y);
        let border = at + half_width;
        let mut end_of_last = border;
        let mut reach = half_height / 2.0;
        for (count, (middle, number)) in loops.into_iter().enumerate() {
            let label = links[number].label;
            let (width, height) = across_along(label.width, label.height);
            let middle = middle.min(end_of_last + gap + width / 2.0);
            end_of_last = middle + width / 2.0;
            if let Some(label) = &mut placed[number].label {
                *label = point(middle, across_along(label.x, label.y).1);
            }
            let end = middle - width / 2.0 - LOOP_DISTANCE;
            let start = (half_height / 2.0 + count as f64 * LOOP_DISTANCE).min(half_height * 0.9);
            let mut points = vec![point(border, along - start)];
            if reach > start {
                points.push(point(border + LOOP_DISTANCE, along - reach));
            }
            points.push(point(end, along - reach));
            points.push(point(end, along + reach));
            if reach > start {
                points.push(point(border + LOOP_DISTANCE, along + reach));
            }
            points.push(point(border, along + start));
            placed[number].points = points;
            reach = reach.max(height / 2.0) + LOOP_DISTANCE;
        }
    }
}

/// Shifts everything so that it begins at 0, and measures it.
pub(super) fn moved_to_origin(
    sizes: &[Size],
    links: &[Link],
    mut placement: Placement,
) -> Placement {
    let mut low = Point {
        x: f64::INFINITY,
        y: f64::INFINITY,
    };
    let mut high = Point {
        x: f64::NEG_INFINITY,
        y: f64::NEG_INFINITY,
    };
    let mut cover = |at: &Point, size: Size| {
        low.x = low.x.min(at.x - size.width / 2.0);
        low.y = low.y.min(at.y - size.height / 2.0);
        high.x = high.x.max(at.x + size.width / 2.0);
        high.y = high.y.max(at.y + size.height / 2.0);
    };
    for (at, size) in placement.boxes.iter().zip(sizes) {
        cover(at, *size);
    }
    for frame in &placement.frames {
        cover(&frame.center, frame.size);
    }
    for (link, declared) in placement.links.iter().zip(links) {
        for point in &link.points {
            cover(point, Size::default());
        }
        if let Some(label) = &link.label {
            cover(label, declared.label);
        }
    }
    if low.x > high.x {
        return placement;
    }
    let shift = |point: &mut Point| {
        point.x -= low.x;
        point.y -= low.y;
    };
    placement.boxes.iter_mut().for_each(shift);
    for frame in &mut placement.frames {
        shift(&mut frame.center);
        shift(&mut frame.title);
    }
    for link in &mut placement.links {
        link.points.iter_mut().for_each(shift);
        link.label.iter_mut().for_each(shift);
    }
    placement.size = Size {
        width: high.x - low.x,
        height: high.y - low.y,
    };
    placement
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOX: Size = Size {
        width: 40.0,
        height: 20.0,
    };
    const SPACING: Spacing = Spacing {
        boxes: 20.0,
        links: 10.0,
        layers: 30.0,
    };

    fn link(from: usize, to: usize) -> Link {
        Link {
            from,
            to,
            label: Size::default(),
        }
    }

    #[test]
    fn a_chain_is_a_row_of_layers() {
        let links = [link(0, 1), link(1, 2)];
        let down = place(&[BOX; 3], &links, Direction::Down, SPACING);
        assert!((down.size.width - 40.0).abs() < 1e-9);
        assert!(down.boxes[0].y < down.boxes[1].y && down.boxes[1].y < down.boxes[2].y);
        let right = place(&[BOX; 3], &links, Direction::Right, SPACING);
        assert!((right.size.height - 20.0).abs() < 1e-9);
        assert!(right.boxes[0].x < right.boxes[1].x && right.boxes[1].x < right.boxes[2].x);
    }

    #[test]
    fn loops_cycles_and_parallel_links_are_placed() {
        let label = Size {
            width: 60.0,
            height: 15.0,
        };
        let mut links = vec![link(0, 1), link(1, 0), link(0, 1), link(1, 1)];
        for link in &mut links {
            link.label = label;
        }
        let placed = place(&[BOX; 2], &links, Direction::Down, SPACING);
        for link in &placed.links {
            assert!(link.points.len() >= 3);
            let at = link.label.unwrap();
            assert!(at.x >= 30.0 && at.x + 30.0 <= placed.size.width + 1e-9);
        }
    }

    #[test]
    fn nothing_is_placed_without_boxes() {
        let placed = place(&[], &[], Direction::Down, SPACING);
        assert_eq!(placed.size, Size::default());
    }

    /// Returns what is wrong with a placement: a label or a box on another one, something outside.
    fn faults(boxes: &[Size], links: &[Link], placed: &Placement) -> Vec<String> {
        let boxes = boxes.iter().zip(&placed.boxes).enumerate();
        let mut frames: Vec<(String, Size, Point)> = boxes
            .map(|(index, (size, at))| (format!("box {index}"), *size, *at))
            .collect();
        for (index, (link, placed)) in links.iter().zip(&placed.links).enumerate() {
            let name = format!("label {index}");
            frames.extend(placed.label.map(|at| (name, link.label, at)));
        }
        let mut faults = Vec::new();
        for (index, (name, size, at)) in frames.iter().enumerate() {
            if !is_inside(*size, *at, placed.size) {
                faults.push(format!("{name} is outside"));
            }
            for (other, other_size, other_at) in &frames[index + 1..] {
                let x = (at.x - other_at.x).abs() - f64::midpoint(size.width, other_size.width);
                let y = (at.y - other_at.y).abs() - f64::midpoint(size.height, other_size.height);
                if x < -TOLERANCE && y < -TOLERANCE {
                    faults.push(format!("{name} is on {other}"));
                }
            }
        }
        for (index, (link, declared)) in placed.links.iter().zip(links).enumerate() {
            let x = |at: &Point| at.x;
            let y = |at: &Point| at.y;
            let is_clear = |label: Point| {
                let size = declared.label;
                misses(&link.points, x, label.x, size.width)
                    || misses(&link.points, y, label.y, size.height)
            };
            let is_on = |label: Point| {
                let near = |at: &Point| (at.x - label.x).abs() + (at.y - label.y).abs() < 0.2;
                link.points.iter().any(near)
            };
            if declared.from != declared.to && !link.label.is_none_or(is_on) {
                faults.push(format!("label {index} is off its link"));
            }
            if declared.from == declared.to && !link.label.is_none_or(is_clear) {
                faults.push(format!("loop {index} is behind its label"));
            }
            let is_in = |at: &Point| is_inside(Size::default(), *at, placed.size);
            if !link.points.iter().all(is_in) {
                faults.push(format!("link {index} is outside"));
            }
        }
        faults
    }

    /// Whether all points lie on one side of a label, in one coordinate.
    fn misses(points: &[Point], of: fn(&Point) -> f64, middle: f64, size: f64) -> bool {
        points.iter().all(|at| of(at) < middle - size / 2.0)
            || points.iter().all(|at| of(at) > middle + size / 2.0)
    }

    /// Rounding error that is no overlap, in SVG units.
    const TOLERANCE: f64 = 1e-6;

    fn is_inside(size: Size, at: Point, whole: Size) -> bool {
        at.x - size.width / 2.0 >= -TOLERANCE
            && at.y - size.height / 2.0 >= -TOLERANCE
            && at.x + size.width / 2.0 <= whole.width + TOLERANCE
            && at.y + size.height / 2.0 <= whole.height + TOLERANCE
    }

    fn any_size() -> impl Strategy<Value = Size> {
        (20.0..200.0, 15.0..90.0).prop_map(|(width, height)| Size { width, height })
    }

    /// Boxes, and links among them: loops, parallel links, links with and without a label.
    fn any_graph() -> impl Strategy<Value = (Vec<Size>, Vec<Link>)> {
        prop::collection::vec(any_size(), 1..14).prop_flat_map(|boxes| {
            let count = boxes.len();
            let label = prop_oneof![1 => Just(Size::default()), 3 => any_size()];
            let link = (0..count, 0..count, label);
            let link = link.prop_map(|(from, to, label)| Link { from, to, label });
            (Just(boxes), prop::collection::vec(link, 0..30))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn nothing_overlaps_and_nothing_is_outside((boxes, links) in any_graph()) {
            for direction in [Direction::Down, Direction::Right] {
                let placed = place(&boxes, &links, direction, SPACING);
                let faults = faults(&boxes, &links, &placed);
                prop_assert!(faults.is_empty(), "{direction:?}: {faults:?}");
            }
        }
    }
}
