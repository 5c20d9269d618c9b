//! A graph as an SVG picture: laid out by layout-rs, drawn by our own backend.
//!
//! layout-rs's own backend writes its styles in the order of a hash map, draws edge labels without
//! a background, and supports only Times as its font.

use super::{Graph, Region};
use layout::core::base::Orientation;
use layout::core::color::Color;
use layout::core::format::{ClipHandle, RenderBackend};
use layout::core::geometry::Point;
use layout::core::style::{LineStyleKind, StyleAttr};
use layout::std_shapes::shapes::{Arrow, Element, LineEndKind, ShapeKind};
use layout::topo::layout::VisualGraph;
use std::fmt::Write as _;

const STATE_FONT: usize = 13;
const EDGE_FONT: usize = 11;

/// Distance between regions, and padding inside a region, in SVG units.
const GAP: f64 = 12.;

/// Draws a graph and returns the SVG document.
pub fn render(name: &str, graph: &Graph) -> String {
    let mut canvas = Canvas::default();
    place(graph).do_it(false, false, false, &mut canvas);
    canvas.finish(name)
}

/// Draws regions side by side, each in a frame with its title.
pub fn render_regions(name: &str, regions: &[Region]) -> String {
    let mut whole = Canvas::default();
    let mut right = 0.;
    for region in regions {
        let mut canvas = Canvas::default();
        place(&region.graph).do_it(false, false, false, &mut canvas);
        let title = text_size(std::slice::from_ref(&region.title), STATE_FONT);
        let width = (canvas.width - canvas.left).max(title.x) + 2. * GAP;
        let height = canvas.height + title.y + GAP;
        let (x, y) = (right + GAP - canvas.left, title.y);
        let _ = write!(
            whole.shapes,
            "<rect x=\"{right:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"8\" fill=\"none\" stroke=\"dimgray\" \
             stroke-dasharray=\"4 3\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{STATE_FONT}\" font-weight=\"bold\">{}</text>\n\
             <g transform=\"translate({x:.1} {y:.1})\">\n{}{}</g>\n",
            right + width / 2.,
            title.y - 8.,
            escape(&region.title),
            canvas.arrows,
            canvas.shapes
        );
        whole.cover(Point::new(right, 0.), Point::new(right + width, height));
        right += width + GAP;
    }
    whole.finish(name)
}

/// Converts the graph to the layout package's type.
fn place(graph: &Graph) -> VisualGraph {
    let mut visual = VisualGraph::new(Orientation::TopToBottom);
    let state = StyleAttr::new(
        Color::fast("black"),
        1,
        Some(Color::fast("aliceblue")),
        8,
        STATE_FONT,
    );
    let ink = StyleAttr::new(Color::fast("dimgray"), 1, None, 0, EDGE_FONT);
    let start = Element::create(
        ShapeKind::new_circle(""),
        StyleAttr::new(Color::fast("black"), 1, Some(Color::fast("black")), 0, 1),
        Orientation::TopToBottom,
        Point::new(10., 10.),
    );
    let start = visual.add_node(start);
    let mut handles = Vec::new();
    for label in &graph.states {
        let size = text_size(label, STATE_FONT);
        let shape = ShapeKind::new_box(&label.join("\n"));
        let element = Element::create(shape, state.clone(), Orientation::TopToBottom, size);
        handles.push(visual.add_node(element));
    }
    for edge in &graph.edges {
        let arrow = Arrow::new(
            LineEndKind::None,
            LineEndKind::Arrow,
            LineStyleKind::Normal,
            &edge.label.join("\n"),
            &ink,
            &None,
            &None,
        );
        visual.add_edge(
            arrow,
            edge.from.map_or(start, |s| handles[s]),
            handles[edge.to],
        );
    }
    visual
}

/// Estimates the size of a text with these lines, including a margin.
fn text_size(lines: &[String], font: usize) -> Point {
    let longest = lines.iter().map(|l| l.chars().count()).max().unwrap_or(0);
    let (width, height) = (longest.max(2) as f64 * 0.58, lines.len() as f64 * 1.2);
    Point::new(width * font as f64 + 16., height * font as f64 + 12.)
}

/// Collects the drawing: lines below, boxes and texts above them.
#[derive(Default)]
struct Canvas {
    arrows: String,
    shapes: String,
    width: f64,
    height: f64,
    left: f64,
}

impl Canvas {
    fn cover(&mut self, low: Point, high: Point) {
        self.left = self.left.min(low.x);
        self.width = self.width.max(high.x);
        self.height = self.height.max(high.y);
    }

    fn finish(self, title: &str) -> String {
        let (left, width, height) = (
            self.left - 10.,
            self.width - self.left + 20.,
            self.height + 10.,
        );
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"{left:.0} 0 {width:.0} {height:.0}\">\n<title>{}</title>\n\
             <defs><marker id=\"head\" markerWidth=\"9\" markerHeight=\"7\" refX=\"9\" refY=\"3.5\" orient=\"auto\">\
             <polygon points=\"0 0, 9 3.5, 0 7\" fill=\"dimgray\"/></marker>\
             <marker id=\"tail\" markerWidth=\"9\" markerHeight=\"7\" refX=\"0\" refY=\"3.5\" orient=\"auto\">\
             <polygon points=\"9 0, 0 3.5, 9 7\" fill=\"dimgray\"/></marker></defs>\n\
             <style>text {{ font-family: Helvetica, Arial, sans-serif; text-anchor: middle }}</style>\n\
             <rect x=\"{left:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" fill=\"white\"/>\n{}{}</svg>\n",
            escape(title),
            self.arrows,
            self.shapes
        )
    }
}

impl RenderBackend for Canvas {
    fn draw_rect(
        &mut self,
        xy: Point,
        size: Point,
        look: &StyleAttr,
        _properties: Option<String>,
        _clip: Option<ClipHandle>,
    ) {
        self.cover(xy, xy.add(size));
        let fill = look
            .fill_color
            .map_or("none".to_owned(), |c| c.to_web_color());
        let _ = writeln!(
            self.shapes,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"{}\" fill=\"{fill}\" stroke=\"{}\"/>",
            xy.x,
            xy.y,
            size.x,
            size.y,
            look.rounded,
            look.line_color.to_web_color()
        );
    }

    fn draw_line(&mut self, start: Point, stop: Point, look: &StyleAttr, _: Option<String>) {
        self.cover(start, stop);
        let _ = writeln!(
            self.arrows,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{}\"/>",
            start.x,
            start.y,
            stop.x,
            stop.y,
            look.line_color.to_web_color()
        );
    }

    fn draw_circle(&mut self, xy: Point, size: Point, look: &StyleAttr, _: Option<String>) {
        self.cover(xy, xy.add(size));
        let _ = writeln!(
            self.shapes,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\" fill=\"{}\"/>",
            xy.x,
            xy.y,
            look.line_color.to_web_color()
        );
    }

    fn draw_text(&mut self, xy: Point, text: &str, look: &StyleAttr) {
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        if lines.is_empty() {
            return;
        }
        // For the label of a long edge, layout-rs does not pass on the style. Every text that does
        // not have the font size of a state is therefore the label of an edge.
        let state = look.font_size == STATE_FONT;
        let font_size = if state { STATE_FONT } else { EDGE_FONT };
        let font = font_size as f64;
        let size = text_size(&lines, font_size);
        let corner = Point::new(xy.x - size.x / 2., xy.y - size.y / 2.);
        self.cover(corner, corner.add(size));
        if !state {
            // A background, so that lines behind the text do not cross it.
            let _ = writeln!(
                self.shapes,
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"white\" fill-opacity=\"0.85\"/>",
                corner.x + 6.,
                corner.y + 4.,
                size.x - 12.,
                size.y - 8.
            );
        }
        let first = xy.y - (lines.len() as f64 - 1.) * 0.6 * font + 0.35 * font;
        for (i, line) in lines.iter().enumerate() {
            let weight = if state && i == 0 {
                " font-weight=\"bold\""
            } else {
                ""
            };
            let _ = writeln!(
                self.shapes,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{}\"{weight}>{}</text>",
                xy.x,
                first + i as f64 * 1.2 * font,
                font_size,
                escape(line)
            );
        }
    }

    fn draw_arrow(
        &mut self,
        path: &[(Point, Point)],
        _dashed: bool,
        head: (bool, bool),
        look: &StyleAttr,
        _properties: Option<String>,
        _text: &str,
    ) {
        let [(from, out), (into, to), rest @ ..] = path else {
            return;
        };
        for (a, b) in path {
            self.cover(*a, *a);
            self.cover(*b, *b);
        }
        let mut data = format!(
            "M {:.1} {:.1} C {:.1} {:.1}, {:.1} {:.1}, {:.1} {:.1}",
            from.x, from.y, out.x, out.y, into.x, into.y, to.x, to.y
        );
        for (control, to) in rest {
            let _ = write!(
                data,
                " S {:.1} {:.1}, {:.1} {:.1}",
                control.x, control.y, to.x, to.y
            );
        }
        let marker = match head {
            (true, _) => " marker-start=\"url(#tail)\"",
            (_, true) => " marker-end=\"url(#head)\"",
            _ => "",
        };
        let _ = writeln!(
            self.arrows,
            "<path d=\"{data}\" fill=\"none\" stroke=\"{}\"{marker}/>",
            look.line_color.to_web_color()
        );
    }

    fn create_clip(&mut self, _xy: Point, _size: Point, _rounded: usize) -> ClipHandle {
        0
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
