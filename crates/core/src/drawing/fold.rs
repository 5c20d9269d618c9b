//! Folds a picture that is laid out from left to right into rows, as lines of text are.
//!
//! It is cut between layers, where few links cross. A link from row to row leaves its box on the
//! right, goes through the gap between the rows, and enters its box from the left. If there are
//! rows between the two, it passes them on the left. Its label is in the gap, on a lane of its own.

use super::layers::{
    Direction, Link, PlacedLink, Placement, Point, Size, Spacing, moved_to_origin, place,
};
use std::cmp::Ordering;
use std::fmt::Write as _;

/// Width in SVG units beyond which a picture is folded.
const ROW_WIDTH: f64 = 1000.0;

/// Distance between rows, in SVG units, without the links between them.
const ROW_GAP: f64 = 26.0;

/// Distance between links that lead from row to row, and from a box to such a link.
const LANE: f64 = 9.0;

/// Distance from the left of a box to such a link, in SVG units: the heads of arrows are there.
const ARROWS: f64 = 18.0;

/// How far a cut may be from its best place, in SVG units, to save the crossing of a link.
const CROSSING: f64 = 60.0;

/// A row of a folded picture.
#[derive(Debug, Clone, Copy)]
struct Row {
    /// What is subtracted from `x`.
    start: f64,
    /// What is added to `y`.
    shift: f64,
    /// Lowest point of the boxes and links in it, after the shift.
    bottom: f64,
}

/// Places boxes of these sizes from left to right, as [`place`] does, and folds the picture into
/// rows if it is wide.
pub fn place_in_rows(sizes: &[Size], links: &[Link], spacing: Spacing) -> Placement {
    let placed = place(sizes, links, Direction::Right, spacing);
    fold(placed, sizes, links)
}

/// Folds a placement. `sizes` are those of the boxes, and `links` are what was placed.
fn fold(placed: Placement, sizes: &[Size], links: &[Link]) -> Placement {
    let cuts = cuts(&placed, sizes, links);
    if cuts.is_empty() {
        return placed;
    }
    let in_row: Vec<usize> = placed
        .boxes
        .iter()
        .map(|at| cuts.iter().filter(|cut| **cut < at.x).count())
        .collect();
    let rows = rows(&placed, sizes, links, &in_row, &cuts);
    let boxes: Vec<Point> = placed
        .boxes
        .iter()
        .zip(&in_row)
        .map(|(at, row)| rows[*row].moved(*at))
        .collect();
    let mut lanes = vec![0.0; rows.len() + 1];
    let placed_links = placed.links.into_iter().zip(links).map(|(placed, link)| {
        let (from, to) = (in_row[link.from], in_row[link.to]);
        match gaps_of(from, to) {
            None => PlacedLink {
                points: placed
                    .points
                    .iter()
                    .map(|at| rows[from].moved(*at))
                    .collect(),
                label: placed.label.map(|at| rows[from].moved(at)),
            },
            Some(gaps) => between_rows((link, gaps), &boxes, sizes, &in_row, &rows, &mut lanes),
        }
    });
    let placement = Placement {
        size: Size::default(),
        links: placed_links.collect(),
        boxes,
        frames: Vec::new(),
    };
    moved_to_origin(sizes, links, placement)
}

/// Height of the lane of a link from row to row: there is room for its label.
fn lane_height(link: &Link) -> f64 {
    LANE.max(link.label.height)
}

impl Row {
    fn moved(&self, at: Point) -> Point {
        Point {
            x: at.x - self.start,
            y: at.y + self.shift,
        }
    }
}

/// Where a placement is cut: `x` of each cut, ascending.
fn cuts(placed: &Placement, sizes: &[Size], links: &[Link]) -> Vec<f64> {
    let width = placed.size.width;
    let count = (width / ROW_WIDTH).ceil() as usize;
    let gaps = gaps(placed, sizes);
    let crossings = |x: f64| {
        let is_left = |node: usize| placed.boxes[node].x < x;
        links
            .iter()
            .filter(|link| is_left(link.from) != is_left(link.to))
            .count()
    };
    let mut cuts: Vec<f64> = (1..count)
        .filter_map(|cut| {
            let best = width * cut as f64 / count as f64;
            let cost = |x: &f64| (x - best).abs() + CROSSING * crossings(*x) as f64;
            gaps.iter()
                .copied()
                .min_by(|a, b| cost(a).total_cmp(&cost(b)))
        })
        .collect();
    cuts.dedup();
    cuts
}

/// Middles of the gaps between layers.
fn gaps(placed: &Placement, sizes: &[Size]) -> Vec<f64> {
    let boxes = placed.boxes.iter().zip(sizes);
    let mut spans: Vec<(f64, f64)> = boxes
        .map(|(at, size)| (at.x - size.width / 2.0, at.x + size.width / 2.0))
        .collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut gaps = Vec::new();
    let mut end = f64::INFINITY;
    for (left, right) in spans {
        if left > end {
            gaps.push(f64::midpoint(end, left));
        }
        end = if end.is_finite() {
            end.max(right)
        } else {
            right
        };
    }
    gaps
}

fn rows(
    placed: &Placement,
    sizes: &[Size],
    links: &[Link],
    in_row: &[usize],
    cuts: &[f64],
) -> Vec<Row> {
    let mut gaps = vec![ROW_GAP; cuts.len() + 1];
    for link in links {
        if let Some((first, second)) = gaps_of(in_row[link.from], in_row[link.to]) {
            gaps[first] += lane_height(link);
            if second != first {
                gaps[second] += LANE;
            }
        }
    }
    let mut cursor = 0.0;
    (0..=cuts.len())
        .map(|row| {
            let boxes = placed.boxes.iter().zip(sizes).zip(in_row);
            let boxes = boxes.filter(|(_, of)| **of == row);
            let boxes = boxes
                .flat_map(|((at, size), _)| [at.y - size.height / 2.0, at.y + size.height / 2.0]);
            let inside = placed.links.iter().zip(links);
            let inside =
                inside.filter(|(_, link)| in_row[link.from] == row && in_row[link.to] == row);
            let extent = |(placed, link): (&PlacedLink, &Link)| {
                let half = link.label.height / 2.0;
                let label = placed.label.map(|at| [at.y - half, at.y + half]);
                let points = placed.points.iter().map(|at| at.y);
                points
                    .chain(label.into_iter().flatten())
                    .collect::<Vec<_>>()
            };
            let (top, bottom) = boxes
                .chain(inside.flat_map(extent))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
                    (low.min(y), high.max(y))
                });
            let shift = cursor - top;
            let start = if row == 0 { 0.0 } else { cuts[row - 1] };
            let of = Row {
                start,
                shift,
                bottom: bottom + shift,
            };
            cursor = of.bottom + gaps[row];
            of
        })
        .collect()
}

/// The gaps through which a link from row to row passes, by the rows above them: the one next to
/// its own row and the one next to the other row, which can be the same. `None` within a row.
fn gaps_of(from: usize, to: usize) -> Option<(usize, usize)> {
    match from.cmp(&to) {
        Ordering::Less => Some((from, to - 1)),
        Ordering::Equal => None,
        Ordering::Greater => Some((from - 1, to)),
    }
}

/// Where a link from row to row is, which passes through these gaps. `lanes` has the width that is
/// used up already: in each gap below a row, and last on the left.
fn between_rows(
    (link, (first, second)): (&Link, (usize, usize)),
    boxes: &[Point],
    sizes: &[Size],
    in_row: &[usize],
    rows: &[Row],
    lanes: &mut [f64],
) -> PlacedLink {
    let (from, to) = (link.from, link.to);
    let mut lane = |gap: usize, width: f64| {
        lanes[gap] += width;
        // Its middle: without a label, the end of the lane, so that the first one is off the row.
        lanes[gap] - (width - LANE) / 2.0
    };
    let first_y = rows[first].bottom + ROW_GAP / 2.0 + lane(first, lane_height(link));
    let right = boxes[from].x + sizes[from].width / 2.0;
    let left = boxes[to].x - sizes[to].width / 2.0;
    let out = free(right, 1.0, in_row[from], boxes, sizes, in_row);
    let back = free(left, -1.0, in_row[to], boxes, sizes, in_row);
    let mut corners = vec![(right, boxes[from].y), (out, boxes[from].y), (out, first_y)];
    if first == second {
        corners.push((back, first_y));
    } else {
        let second_y = rows[second].bottom + ROW_GAP / 2.0 + lane(second, LANE);
        let side = -20.0 - lane(rows.len(), LANE);
        corners.extend([(side, first_y), (side, second_y), (back, second_y)]);
    }
    corners.extend([(back, boxes[to].y), (left, boxes[to].y)]);
    let label = Point {
        x: f64::midpoint(out, corners[3].0),
        y: first_y,
    };
    PlacedLink {
        points: corners.into_iter().map(|(x, y)| Point { x, y }).collect(),
        label: Some(label).filter(|_| link.label.width > 0.0),
    }
}

/// The first `x` from here on, to the right (1) or to the left (-1), where no box of the row is
/// near.
fn free(
    from: f64,
    direction: f64,
    row: usize,
    boxes: &[Point],
    sizes: &[Size],
    in_row: &[usize],
) -> f64 {
    let mut x = from + if direction < 0.0 { -ARROWS } else { LANE };
    // Each box pushes it on at most once.
    for _ in boxes {
        let in_the_way = boxes
            .iter()
            .zip(sizes)
            .zip(in_row)
            .filter(|(_, of)| **of == row)
            .map(|((at, size), _)| {
                let half = size.width / 2.0;
                (at.x - half - ARROWS, at.x + half + LANE)
            })
            .find(|(start, end)| x > start + 0.5 && x < end - 0.5);
        let Some((start, end)) = in_the_way else {
            break;
        };
        x = if direction < 0.0 { start } else { end };
    }
    x
}

/// A polyline with rounded corners, as the data of an SVG path.
pub fn rounded(points: &[Point]) -> String {
    const RADIUS: f64 = 12.0;
    let mut data = String::new();
    let Some(first) = points.first() else {
        return data;
    };
    // Writing to a string cannot fail.
    let _ = write!(data, "M{:.1} {:.1}", first.x, first.y);
    for corner in points.windows(3) {
        let [before, at, after] = [corner[0], corner[1], corner[2]];
        let toward = |other: Point| {
            let distance = (other.x - at.x).hypot(other.y - at.y).max(1e-9);
            let share = (RADIUS / distance).min(0.5);
            (
                at.x + (other.x - at.x) * share,
                at.y + (other.y - at.y) * share,
            )
        };
        let ((x, y), (to_x, to_y)) = (toward(before), toward(after));
        let _ = write!(
            data,
            "L{x:.1} {y:.1}Q{:.1} {:.1} {to_x:.1} {to_y:.1}",
            at.x, at.y
        );
    }
    if let [.., last] = points {
        let _ = write!(data, "L{:.1} {:.1}", last.x, last.y);
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Size = Size {
        width: 80.0,
        height: 50.0,
    };

    const SPACING: Spacing = Spacing {
        boxes: 20.0,
        links: 10.0,
        layers: 40.0,
    };

    /// A chain of boxes with more links, all of which have labels of this size.
    fn chain(count: usize, more: &[(usize, usize)], label: Size) -> (Vec<Size>, Vec<Link>) {
        let ends = (1..count)
            .map(|to| (to - 1, to))
            .chain(more.iter().copied());
        let links = ends.map(|(from, to)| Link { from, to, label });
        (vec![BOX; count], links.collect())
    }

    /// Whether two rectangles are apart, given by their centers and sizes.
    fn are_apart((a, first): (Point, Size), (b, second): (Point, Size)) -> bool {
        (a.x - b.x).abs() >= f64::midpoint(first.width, second.width) - 1e-6
            || (a.y - b.y).abs() >= f64::midpoint(first.height, second.height) - 1e-6
    }

    #[test]
    fn a_long_chain_has_rows_in_which_no_box_meets_another() {
        let (sizes, links) = chain(30, &[(25, 3), (12, 14), (0, 29)], Size::default());
        let folded = place_in_rows(&sizes, &links, SPACING);
        assert!(folded.size.width <= ROW_WIDTH + 400.0, "{:?}", folded.size);
        for (index, a) in folded.boxes.iter().enumerate() {
            for b in &folded.boxes[index + 1..] {
                assert!(are_apart((*a, BOX), (*b, BOX)));
            }
        }
        for (placed, link) in folded.links.iter().zip(&links) {
            let (first, last) = (placed.points[0], placed.points[placed.points.len() - 1]);
            assert!((first.x - folded.boxes[link.from].x).abs() <= 40.1);
            assert!((last.x - folded.boxes[link.to].x).abs() <= 40.1);
        }
    }

    #[test]
    fn labels_of_links_from_row_to_row_overlap_nothing() {
        let label = Size {
            width: 90.0,
            height: 40.0,
        };
        let (sizes, links) = chain(30, &[(25, 3), (12, 14), (0, 29), (20, 1)], label);
        let folded = place_in_rows(&sizes, &links, SPACING);
        let labels = folded.links.iter().filter_map(|link| link.label);
        let boxes = folded.boxes.iter().map(|at| (*at, BOX));
        let all: Vec<(Point, Size)> = labels.map(|at| (at, label)).chain(boxes).collect();
        assert_eq!(all.len(), 30 + links.len());
        for (index, (at, size)) in all.iter().enumerate() {
            assert!(at.x >= size.width / 2.0 - 1e-6 && at.y >= size.height / 2.0 - 1e-6);
            assert!(at.x + size.width / 2.0 <= folded.size.width + 1e-6);
            assert!(at.y + size.height / 2.0 <= folded.size.height + 1e-6);
            for other in &all[index + 1..] {
                assert!(are_apart((*at, *size), *other), "{at:?} {other:?}");
            }
        }
    }

    #[test]
    fn no_link_passes_through_the_heads_of_arrows() {
        let (sizes, links) = chain(30, &[(25, 3), (12, 14), (0, 29)], Size::default());
        let folded = place_in_rows(&sizes, &links, SPACING);
        for (index, link) in folded.links.iter().enumerate() {
            for pair in link
                .points
                .windows(2)
                .filter(|pair| (pair[0].x - pair[1].x).abs() < 0.1)
            {
                let (low, high) = (pair[0].y.min(pair[1].y), pair[0].y.max(pair[1].y));
                for (other, drawn) in folded.links.iter().enumerate() {
                    let tip = drawn.points[drawn.points.len() - 1];
                    let is_through = low < tip.y && tip.y < high;
                    let distance = tip.x - pair[0].x;
                    assert!(
                        other == index || !is_through || !(0.0..ARROWS - 1.0).contains(&distance)
                    );
                }
            }
        }
    }

    #[test]
    fn a_short_line_stays_as_it_is() {
        let (sizes, links) = chain(4, &[], Size::default());
        let placed = place(&sizes, &links, Direction::Right, SPACING);
        assert_eq!(place_in_rows(&sizes, &links, SPACING), placed);
    }
}
