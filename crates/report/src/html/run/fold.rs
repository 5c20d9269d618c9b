//! Folds a picture that is laid out from left to right into rows, as lines of text are.
//!
//! It is cut between layers, where few links cross. A link from row to row leaves its box on the
//! right, goes through the gap between the rows, and enters its box from the left. If there are
//! rows between the two, it passes them on the left.

use linewright_core::drawing::layers::{PlacedLink, Placement, Point, Size};
use std::fmt::Write as _;

/// Width in SVG units beyond which a picture is folded.
const ROW_WIDTH: f64 = 1000.0;

/// Distance between rows, in SVG units, without the links between them.
const ROW_GAP: f64 = 26.0;

/// Distance between links that lead from row to row, and from a box to such a link.
const LANE: f64 = 9.0;

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

/// Folds a placement. `sizes` are those of the boxes, `links` the boxes that are linked, both in
/// the order of the placement.
pub(super) fn fold(placed: Placement, sizes: &[Size], links: &[(usize, usize)]) -> Placement {
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
    let placed_links = placed
        .links
        .into_iter()
        .zip(links)
        .map(|(link, &(from, to))| {
            let points = if in_row[from] == in_row[to] {
                let points = link.points.iter();
                points.map(|at| rows[in_row[from]].moved(*at)).collect()
            } else {
                between_rows((from, to), &boxes, sizes, &in_row, &rows, &mut lanes)
            };
            PlacedLink {
                points,
                label: None,
            }
        });
    let links = placed_links.collect();
    measured(boxes, links, sizes)
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
fn cuts(placed: &Placement, sizes: &[Size], links: &[(usize, usize)]) -> Vec<f64> {
    let width = placed.size.width;
    let count = (width / ROW_WIDTH).ceil() as usize;
    let gaps = gaps(placed, sizes);
    let crossings = |x: f64| {
        let is_left = |node: usize| placed.boxes[node].x < x;
        links
            .iter()
            .filter(|(from, to)| is_left(*from) != is_left(*to))
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
    links: &[(usize, usize)],
    in_row: &[usize],
    cuts: &[f64],
) -> Vec<Row> {
    let between = links
        .iter()
        .filter(|(from, to)| in_row[*from] != in_row[*to]);
    let gap = ROW_GAP + between.count() as f64 * LANE;
    let mut cursor = 0.0;
    (0..=cuts.len())
        .map(|row| {
            let boxes = placed.boxes.iter().zip(sizes).zip(in_row);
            let boxes = boxes.filter(|(_, of)| **of == row);
            let boxes = boxes
                .flat_map(|((at, size), _)| [at.y - size.height / 2.0, at.y + size.height / 2.0]);
            let inside = placed.links.iter().zip(links);
            let inside =
                inside.filter(|(_, (from, to))| in_row[*from] == row && in_row[*to] == row);
            let points = inside.flat_map(|(link, _)| link.points.iter().map(|at| at.y));
            let (top, bottom) = boxes
                .chain(points)
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
            cursor = of.bottom + gap;
            of
        })
        .collect()
}

/// The corners of a link from row to row. `lanes` has the width that is used up already: in each
/// gap below a row, and last on the left.
fn between_rows(
    (from, to): (usize, usize),
    boxes: &[Point],
    sizes: &[Size],
    in_row: &[usize],
    rows: &[Row],
    lanes: &mut [f64],
) -> Vec<Point> {
    let (a, b) = (in_row[from], in_row[to]);
    // Downwards, it passes the gap below its row and the one above the other; upwards, vice versa.
    let (first, second) = if a < b { (a, b - 1) } else { (a - 1, b) };
    let mut lane = |gap: usize| {
        lanes[gap] += LANE;
        lanes[gap]
    };
    let first_y = rows[first].bottom + ROW_GAP / 2.0 + lane(first);
    let right = boxes[from].x + sizes[from].width / 2.0;
    let left = boxes[to].x - sizes[to].width / 2.0;
    let out = free(right, 1.0, in_row[from], boxes, sizes, in_row);
    let back = free(left, -1.0, in_row[to], boxes, sizes, in_row);
    let mut corners = vec![(right, boxes[from].y), (out, boxes[from].y), (out, first_y)];
    if first == second {
        corners.push((back, first_y));
    } else {
        let second_y = rows[second].bottom + ROW_GAP / 2.0 + lane(second);
        let side = -20.0 - lane(rows.len());
        corners.extend([(side, first_y), (side, second_y), (back, second_y)]);
    }
    corners.extend([(back, boxes[to].y), (left, boxes[to].y)]);
    corners.into_iter().map(|(x, y)| Point { x, y }).collect()
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
    let mut x = from + direction * LANE;
    // Each box pushes it on at most once.
    for _ in boxes {
        let in_the_way = boxes
            .iter()
            .zip(sizes)
            .zip(in_row)
            .find(|((at, size), of)| {
                **of == row && (at.x - x).abs() < size.width / 2.0 + LANE - 0.5
            });
        let Some(((at, size), _)) = in_the_way else {
            break;
        };
        x = at.x + direction * (size.width / 2.0 + LANE);
    }
    x
}

/// Shifts everything so that it begins at 0, and measures it.
fn measured(mut boxes: Vec<Point>, mut links: Vec<PlacedLink>, sizes: &[Size]) -> Placement {
    let corners = boxes.iter().zip(sizes).flat_map(|(at, size)| {
        let (x, y) = (size.width / 2.0, size.height / 2.0);
        [
            Point {
                x: at.x - x,
                y: at.y - y,
            },
            Point {
                x: at.x + x,
                y: at.y + y,
            },
        ]
    });
    let all: Vec<Point> = corners
        .chain(links.iter().flat_map(|link| link.points.clone()))
        .collect();
    let low = |of: fn(&Point) -> f64| all.iter().map(of).fold(f64::INFINITY, f64::min);
    let high = |of: fn(&Point) -> f64| all.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    let (left, top) = (low(|p| p.x), low(|p| p.y));
    let size = Size {
        width: high(|p| p.x) - left,
        height: high(|p| p.y) - top,
    };
    let points = links.iter_mut().flat_map(|link| &mut link.points);
    for point in boxes.iter_mut().chain(points) {
        point.x -= left;
        point.y -= top;
    }
    Placement { size, boxes, links }
}

/// A polyline with rounded corners, as the data of an SVG path.
pub(super) fn rounded(points: &[Point]) -> String {
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
    use super::super::picture::unlabeled;
    use super::*;
    use linewright_core::drawing::layers::{Direction, Spacing, place};

    fn chain(count: usize, more: &[(usize, usize)]) -> (Placement, Vec<Size>, Vec<(usize, usize)>) {
        let sizes = vec![
            Size {
                width: 80.0,
                height: 50.0
            };
            count
        ];
        let mut links: Vec<(usize, usize)> = (1..count).map(|to| (to - 1, to)).collect();
        links.extend(more);
        let spacing = Spacing {
            boxes: 20.0,
            links: 10.0,
            layers: 40.0,
        };
        (
            place(&sizes, &unlabeled(&links), Direction::Right, spacing),
            sizes,
            links,
        )
    }

    #[test]
    fn a_long_chain_has_rows_in_which_no_box_meets_another() {
        let (placed, sizes, links) = chain(30, &[(25, 3), (12, 14), (0, 29)]);
        let folded = fold(placed, &sizes, &links);
        assert!(folded.size.width <= ROW_WIDTH + 400.0, "{:?}", folded.size);
        for (index, a) in folded.boxes.iter().enumerate() {
            for b in &folded.boxes[index + 1..] {
                assert!((a.x - b.x).abs() >= 80.0 || (a.y - b.y).abs() >= 50.0);
            }
        }
        for (link, (from, to)) in folded.links.iter().zip(&links) {
            let (first, last) = (link.points[0], link.points[link.points.len() - 1]);
            assert!((first.x - folded.boxes[*from].x).abs() <= 40.1);
            assert!((last.x - folded.boxes[*to].x).abs() <= 40.1);
        }
    }

    #[test]
    fn a_short_line_stays_as_it_is() {
        let (placed, sizes, links) = chain(4, &[]);
        assert_eq!(fold(placed.clone(), &sizes, &links), placed);
    }
}
