//! A graph as an SVG picture, in layers.

use super::layers::{Direction, Link, PlacedLink, Placement, Point, Size, Spacing, place};
use super::{Edge, Graph, Region, text};
use std::fmt::Write as _;

const STATE_FONT: f64 = 13.0;
const EDGE_FONT: f64 = 11.0;

/// Distance between regions, and padding inside a region, in SVG units.
const GAP: f64 = 12.0;

/// Width in SVG units up to which a drawing fits on a page.
const PAGE_WIDTH: f64 = 1600.0;

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

/// Draws a graph and returns the SVG document.
pub fn render(name: &str, graph: &Graph) -> String {
    let (placement, body) = drawn(graph);
    document(name, placement.size, &body)
}

/// Draws regions side by side, each in a frame with its title.
pub fn render_regions(name: &str, regions: &[Region]) -> String {
    let mut body = String::new();
    let mut whole = Size::default();
    for region in regions {
        let (placement, inside) = drawn(&region.graph);
        let title = text::size(std::slice::from_ref(&region.title), STATE_FONT, true);
        let frame = Size {
            width: placement.size.width.max(title.width) + 2.0 * GAP,
            height: placement.size.height + title.height + GAP,
        };
        let left = whole.width + if whole.width > 0.0 { GAP } else { 0.0 };
        // Writing to a string cannot fail.
        let _ = write!(
            body,
            "<rect x=\"{left:.1}\" y=\"0\" width=\"{:.1}\" height=\"{:.1}\" rx=\"8\" fill=\"none\" stroke=\"dimgray\" \
             stroke-dasharray=\"4 3\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{STATE_FONT}\" font-weight=\"bold\">{}</text>\n\
             <g transform=\"translate({:.1} {:.1})\">\n{inside}</g>\n",
            frame.width,
            frame.height,
            left + frame.width / 2.0,
            title.height - 8.0,
            escape(&region.title),
            left + (frame.width - placement.size.width) / 2.0,
            title.height,
        );
        whole.width = left + frame.width;
        whole.height = whole.height.max(frame.height);
    }
    document(name, whole, &body)
}

/// Places and draws a graph, in the direction in which it fits better.
fn drawn(graph: &Graph) -> (Placement, String) {
    let down = placed(graph, Direction::Down);
    let right = placed(graph, Direction::Right);
    let is_better = |a: &Placement, b: &Placement| {
        let over = |p: &Placement| (p.size.width - PAGE_WIDTH).max(0.0);
        let area = |p: &Placement| p.size.width * p.size.height;
        (over(a), area(a)) < (over(b), area(b))
    };
    let placement = if is_better(&right, &down) {
        right
    } else {
        down
    };
    let mut body = String::new();
    for link in &placement.links {
        draw_arrow(&mut body, link);
    }
    for (edge, link) in graph.edges.iter().zip(&placement.links) {
        if let Some(at) = link.label {
            draw_label(&mut body, at, edge);
        }
    }
    for (state, at) in graph.states.iter().zip(&placement.boxes) {
        draw_state(&mut body, *at, state);
    }
    if let Some(at) = placement.boxes.get(graph.states.len()) {
        let _ = writeln!(
            body,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\"/>",
            at.x, at.y
        );
    }
    (placement, body)
}

/// Places a graph. The dot is the last box.
fn placed(graph: &Graph, direction: Direction) -> Placement {
    let mut boxes: Vec<Size> = graph
        .states
        .iter()
        .map(|label| text::size(label, STATE_FONT, true))
        .collect();
    if graph.edges.iter().any(|edge| edge.from.is_none()) {
        boxes.push(START);
    }
    let links: Vec<Link> = graph
        .edges
        .iter()
        .map(|edge| Link {
            from: edge.from.unwrap_or(graph.states.len()),
            to: edge.to,
            label: if edge.label.is_empty() {
                Size::default()
            } else {
                text::size(&edge.label, EDGE_FONT, false)
            },
        })
        .collect();
    place(&boxes, &links, direction, SPACING)
}

fn draw_arrow(body: &mut String, link: &PlacedLink) {
    let _ = writeln!(
        body,
        "<path d=\"{}\" fill=\"none\" stroke=\"dimgray\" marker-end=\"url(#head)\"/>",
        curve(&link.points)
    );
}

/// A smooth curve along a polyline, as the data of an SVG path: it touches the middle of each inner
/// piece.
fn curve(points: &[Point]) -> String {
    let mut data = String::new();
    let Some((first, rest)) = points.split_first() else {
        return data;
    };
    let _ = write!(data, "M {:.1} {:.1}", first.x, first.y);
    for (index, point) in rest.iter().enumerate() {
        match rest.get(index + 1) {
            None => {
                let _ = write!(data, " L {:.1} {:.1}", point.x, point.y);
            }
            Some(next) => {
                let (x, y) = (
                    f64::midpoint(point.x, next.x),
                    f64::midpoint(point.y, next.y),
                );
                let is_last = index + 2 == rest.len();
                let (x, y) = if is_last { (next.x, next.y) } else { (x, y) };
                let _ = write!(data, " Q {:.1} {:.1} {x:.1} {y:.1}", point.x, point.y);
                if is_last {
                    break;
                }
            }
        }
    }
    data
}

fn draw_label(body: &mut String, at: Point, edge: &Edge) {
    let size = text::size(&edge.label, EDGE_FONT, false);
    // A background, so that lines behind the text do not cross it.
    let _ = writeln!(
        body,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"white\" fill-opacity=\"0.85\"/>",
        at.x - size.width / 2.0 + 6.0,
        at.y - size.height / 2.0 + 4.0,
        size.width - 12.0,
        size.height - 8.0
    );
    draw_text(body, at, &edge.label, EDGE_FONT, false);
}

fn draw_state(body: &mut String, at: Point, label: &[String]) {
    let size = text::size(label, STATE_FONT, true);
    let _ = writeln!(
        body,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"8\" fill=\"aliceblue\" stroke=\"black\"/>",
        at.x - size.width / 2.0,
        at.y - size.height / 2.0,
        size.width,
        size.height
    );
    draw_text(body, at, label, STATE_FONT, true);
}

/// Writes lines around a center. If the text has a heading, that is its first line.
fn draw_text(body: &mut String, at: Point, lines: &[String], font: f64, has_heading: bool) {
    let first = at.y - (lines.len() as f64 - 1.0) * 0.6 * font + 0.35 * font;
    for (index, line) in lines.iter().enumerate() {
        let weight = if has_heading && index == 0 {
            " font-weight=\"bold\""
        } else {
            ""
        };
        let _ = writeln!(
            body,
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{font}\"{weight}>{}</text>",
            at.x,
            first + index as f64 * 1.2 * font,
            escape(line)
        );
    }
}

fn document(title: &str, size: Size, body: &str) -> String {
    let (width, height) = (size.width + 20.0, size.height + 20.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"-10 -10 {width:.0} {height:.0}\">\n<title>{}</title>\n\
         <defs><marker id=\"head\" markerWidth=\"9\" markerHeight=\"7\" refX=\"9\" refY=\"3.5\" orient=\"auto\">\
         <polygon points=\"0 0, 9 3.5, 0 7\" fill=\"dimgray\"/></marker></defs>\n\
         <style>text {{ font-family: Helvetica, Arial, sans-serif; text-anchor: middle }}</style>\n\
         <rect x=\"-10\" y=\"-10\" width=\"{width:.0}\" height=\"{height:.0}\" fill=\"white\"/>\n{body}</svg>\n",
        escape(title),
    )
}

/// Replaces the characters that have a meaning in XML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
