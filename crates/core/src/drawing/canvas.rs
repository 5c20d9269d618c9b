//! What a picture consists of, and its form as SVG text.

use super::BoxStyle;
use super::fold::rounded;
use super::layers::{Point, Size};
use super::text::{self, LINE};
use std::fmt::Write as _;

/// Font size of states and titles, in SVG units.
pub(super) const STATE_FONT: f64 = 13.0;

/// Font size of labels, legends and tables, in SVG units.
pub(super) const LABEL_FONT: f64 = 11.0;

/// Margin around the document, in SVG units.
pub(super) const MARGIN: f64 = 10.0;

/// Distance between the two borders of a double border, in SVG units.
const DOUBLE: f64 = 3.0;

/// Height of the marks of a conveyor, and the most places that have marks.
const MARKS: f64 = 10.0;
const MAX_MARKS: u32 = 60;

/// Style of a mark between the places of a conveyor.
const MARK: &str = "fill=\"dimgray\"";

/// Style of the frame around some of the states.
pub(super) const FRAME: &str =
    "rx=\"8\" fill=\"whitesmoke\" stroke=\"dimgray\" stroke-dasharray=\"6 4\"";

/// Style of the background of a label, where the line of its own link is interrupted.
const BACKGROUND: &str = "fill=\"white\" fill-opacity=\"0.85\"";

/// Style of a text that can be on lines of other links.
const HALO: &str =
    " stroke=\"white\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"";

/// Style of the frame of a region.
pub(super) const REGION: &str =
    "rx=\"8\" fill=\"none\" stroke=\"dimgray\" stroke-dasharray=\"4 3\"";

/// Style of a cell of a matrix that is not empty.
pub(super) const CELL: &str = "fill=\"aliceblue\" stroke=\"silver\"";

/// The part of a text that is at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
}

/// One line of text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Text {
    /// A point of the base line.
    pub at: Point,
    pub anchor: Anchor,
    /// Font size in SVG units.
    pub font: f64,
    pub is_bold: bool,
    /// Whether it has a white border, so that it can be read on lines.
    pub has_halo: bool,
    pub content: String,
}

/// A part of a picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// A rectangle, with its upper left corner.
    Rectangle(Point, Size, &'static str),
    /// A rectangle that says what it is when it is pointed at.
    Titled(Point, Size, &'static str, String),
    /// Straight lines between points.
    Line(Vec<Point>, &'static str),
    /// The smooth curve of an arrow along these points.
    Arrow(Vec<Point>),
    /// An arrow along these points with rounded corners.
    Route(Vec<Point>),
    /// The dot from which the edges to the initial states begin.
    Dot(Point),
    Text(Text),
}

/// Shapes, in the order in which they cover each other, and the size that they fill from 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Canvas {
    pub size: Size,
    pub shapes: Vec<Shape>,
}

impl Canvas {
    /// Adds a rectangle around its center.
    pub fn rectangle(&mut self, center: Point, size: Size, style: &'static str) {
        let corner = Point {
            x: center.x - size.width / 2.0,
            y: center.y - size.height / 2.0,
        };
        self.shapes.push(Shape::Rectangle(corner, size, style));
    }

    /// Adds a box with its label, around its center. It is at least as large as [`box_size`].
    pub fn labeled_box(&mut self, center: Point, size: Size, label: &[String], style: BoxStyle) {
        let attributes = match style {
            BoxStyle::State => "class=\"state\" rx=\"8\" fill=\"aliceblue\" stroke=\"black\"",
            BoxStyle::Coordinator => "fill=\"lemonchiffon\" stroke=\"black\"",
            BoxStyle::Block | BoxStyle::Conveyor(_) => "fill=\"aliceblue\" stroke=\"black\"",
            BoxStyle::Observer => "fill=\"white\" stroke=\"black\" stroke-dasharray=\"4 3\"",
            BoxStyle::Terminal => "rx=\"14\" fill=\"white\" stroke=\"dimgray\"",
        };
        self.rectangle(center, size, attributes);
        let mut middle = center;
        if style == BoxStyle::Coordinator {
            let inner = Size {
                width: size.width - 2.0 * DOUBLE,
                height: size.height - 2.0 * DOUBLE,
            };
            self.rectangle(center, inner, "fill=\"none\" stroke=\"black\"");
        }
        if let BoxStyle::Conveyor(places) = style {
            middle.y -= MARKS / 2.0;
            let (left, bottom) = (center.x - size.width / 2.0, center.y + size.height / 2.0);
            let places = places.clamp(1, MAX_MARKS);
            for mark in 1..places {
                let x = left + size.width * f64::from(mark) / f64::from(places);
                let at = Point {
                    x,
                    y: bottom - MARKS / 2.0,
                };
                let size = Size {
                    width: 1.0,
                    height: MARKS,
                };
                self.rectangle(at, size, MARK);
            }
        }
        self.lines(middle, label, STATE_FONT, true);
    }

    /// Adds the background of the label of a link around its center.
    pub fn background(&mut self, center: Point, label: &[String]) {
        self.rectangle(center, background_size(label), BACKGROUND);
    }

    /// Adds the label of a link around its center, without its background.
    pub fn label(&mut self, center: Point, label: &[String]) {
        self.texts(center, label, LABEL_FONT, (false, true));
    }

    /// Adds lines around a center. If the text has a heading, that is its first line.
    pub fn lines(&mut self, center: Point, lines: &[String], font: f64, has_heading: bool) {
        self.texts(center, lines, font, (has_heading, false));
    }

    fn texts(
        &mut self,
        center: Point,
        lines: &[String],
        font: f64,
        (has_heading, has_halo): (bool, bool),
    ) {
        let first = center.y - (lines.len() as f64 - 1.0) * LINE / 2.0 * font + 0.35 * font;
        // An empty line only separates others.
        let shown = lines
            .iter()
            .enumerate()
            .filter(|(_, line)| !line.is_empty());
        for (index, line) in shown {
            self.shapes.push(Shape::Text(Text {
                at: Point {
                    x: center.x,
                    y: first + index as f64 * LINE * font,
                },
                anchor: Anchor::Middle,
                font,
                is_bold: has_heading && index == 0,
                has_halo,
                content: line.clone(),
            }));
        }
    }

    /// Adds a line of a legend or a table, and enlarges the canvas for it.
    pub fn write(&mut self, x: f64, base: f64, is_bold: bool, content: &str) {
        self.write_in(LABEL_FONT, Point { x, y: base }, is_bold, content);
    }

    /// Adds a line of text in a font size, and enlarges the canvas for it.
    pub fn write_in(&mut self, font: f64, at: Point, is_bold: bool, content: &str) {
        let width = text::width(content, font, is_bold);
        self.size.width = self.size.width.max(at.x + width);
        self.size.height = self.size.height.max(at.y + 0.3 * font);
        self.shapes.push(Shape::Text(Text {
            at,
            anchor: Anchor::Start,
            font,
            is_bold,
            has_halo: false,
            content: content.to_owned(),
        }));
    }

    /// Adds another canvas at a place, and enlarges this one for it.
    pub fn add(&mut self, at: Point, other: Self) {
        let moved = |point: Point| Point {
            x: point.x + at.x,
            y: point.y + at.y,
        };
        self.size.width = self.size.width.max(at.x + other.size.width);
        self.size.height = self.size.height.max(at.y + other.size.height);
        self.shapes
            .extend(other.shapes.into_iter().map(|shape| match shape {
                Shape::Rectangle(corner, size, style) => {
                    Shape::Rectangle(moved(corner), size, style)
                }
                Shape::Titled(corner, size, style, title) => {
                    Shape::Titled(moved(corner), size, style, title)
                }
                Shape::Line(points, style) => {
                    Shape::Line(points.into_iter().map(moved).collect(), style)
                }
                Shape::Arrow(points) => Shape::Arrow(points.into_iter().map(moved).collect()),
                Shape::Route(points) => Shape::Route(points.into_iter().map(moved).collect()),
                Shape::Dot(center) => Shape::Dot(moved(center)),
                Shape::Text(text) => Shape::Text(Text {
                    at: moved(text.at),
                    ..text
                }),
            }));
    }

    /// Adds another canvas below what is there.
    pub fn add_below(&mut self, gap: f64, other: Self) {
        let y = if self.size.height > 0.0 {
            self.size.height + gap
        } else {
            0.0
        };
        self.add(Point { x: 0.0, y }, other);
    }

    /// Returns the SVG document.
    pub fn document(&self, title: &str) -> String {
        let width = self.size.width + 2.0 * MARGIN;
        let height = self.size.height + 2.0 * MARGIN;
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"-{MARGIN} -{MARGIN} {width:.0} {height:.0}\" \
             font-family=\"Helvetica, Arial, sans-serif\" text-anchor=\"middle\">\n<title>{}</title>\n\
             <defs><marker id=\"head\" markerWidth=\"9\" markerHeight=\"7\" refX=\"9\" refY=\"3.5\" orient=\"auto\">\
             <polygon points=\"0 0, 9 3.5, 0 7\" fill=\"dimgray\"/></marker></defs>\n\
             <rect x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width:.0}\" height=\"{height:.0}\" fill=\"white\"/>\n",
            escape(title),
        );
        for shape in &self.shapes {
            write_shape(&mut text, shape);
        }
        text.push_str("</svg>\n");
        text
    }
}

/// Size of a box with this label.
pub(super) fn box_size(label: &[String], style: BoxStyle) -> Size {
    let text = text::size(label, STATE_FONT, true);
    match style {
        BoxStyle::State | BoxStyle::Block | BoxStyle::Observer | BoxStyle::Terminal => text,
        BoxStyle::Coordinator => Size {
            width: text.width + 2.0 * DOUBLE,
            height: text.height + 2.0 * DOUBLE,
        },
        BoxStyle::Conveyor(places) => Size {
            width: text.width.max((f64::from(places) * 9.0).clamp(90.0, 220.0)),
            height: text.height + MARKS,
        },
    }
}

/// Size of the background of the label of a link.
pub(super) fn background_size(label: &[String]) -> Size {
    let size = text::size(label, LABEL_FONT, false);
    Size {
        width: size.width - 12.0,
        height: size.height - 8.0,
    }
}

/// Size of the label of a link; 0 by 0 without one.
pub(super) fn label_size(label: &[String]) -> Size {
    if label.is_empty() {
        return Size::default();
    }
    text::size(label, LABEL_FONT, false)
}

/// Writes an arrow along the data of an SVG path.
fn write_arrow(output: &mut String, data: &str) -> std::fmt::Result {
    writeln!(
        output,
        "<path d=\"{data}\" fill=\"none\" stroke=\"dimgray\" marker-end=\"url(#head)\"/>"
    )
}

fn write_shape(output: &mut String, shape: &Shape) {
    // Writing to a string cannot fail.
    let _ = match shape {
        Shape::Rectangle(Point { x, y }, Size { width, height }, style) => writeln!(
            output,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {style}/>"
        ),
        Shape::Titled(Point { x, y }, Size { width, height }, style, title) => writeln!(
            output,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" {style}><title>{}</title></rect>",
            escape(title)
        ),
        Shape::Line(points, style) => {
            let points = points.iter().map(|Point { x, y }| format!("{x:.1},{y:.1}"));
            let points = points.collect::<Vec<_>>().join(" ");
            writeln!(output, "<polyline points=\"{points}\" {style}/>")
        }
        Shape::Arrow(points) => write_arrow(output, &curve(points)),
        Shape::Route(points) => write_arrow(output, &rounded(points)),
        Shape::Dot(Point { x, y }) => {
            writeln!(output, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>")
        }
        Shape::Text(text) => {
            let anchor = match text.anchor {
                Anchor::Start => " text-anchor=\"start\"",
                Anchor::Middle => "",
            };
            let weight = if text.is_bold {
                " font-weight=\"bold\""
            } else {
                ""
            };
            let halo = if text.has_halo { HALO } else { "" };
            // A wider font in place of Helvetica is squeezed, so that texts never overlap.
            let width = text::width(&text.content, text.font, text.is_bold);
            let length = if text.content.is_ascii() && width > 0.0 {
                format!(" textLength=\"{width:.1}\" lengthAdjust=\"spacingAndGlyphs\"")
            } else {
                String::new()
            };
            writeln!(
                output,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{}\"{weight}{anchor}{halo}{length}>{}</text>",
                text.at.x,
                text.at.y,
                text.font,
                escape(&text.content)
            )
        }
    };
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

/// Points along the smooth curve of an arrow along a polyline, close enough for straight pieces
/// between them.
pub(super) fn flattened(points: &[Point]) -> Vec<Point> {
    /// Number of pieces of each arc.
    const PIECES: u32 = 8;
    let mut flat: Vec<Point> = points.first().copied().into_iter().collect();
    for (index, control) in points.iter().enumerate().skip(1) {
        let (Some(from), Some(next)) = (flat.last().copied(), points.get(index + 1)) else {
            flat.push(*control);
            break;
        };
        let is_last = index + 2 == points.len();
        let end = if is_last {
            *next
        } else {
            Point {
                x: f64::midpoint(control.x, next.x),
                y: f64::midpoint(control.y, next.y),
            }
        };
        flat.extend((1..=PIECES).map(|piece| {
            let part = f64::from(piece) / f64::from(PIECES);
            let rest = 1.0 - part;
            let at = |from: f64, control: f64, end: f64| {
                rest * rest * from + 2.0 * rest * part * control + part * part * end
            };
            Point {
                x: at(from.x, control.x, end.x),
                y: at(from.y, control.y, end.y),
            }
        }));
        if is_last {
            break;
        }
    }
    flat
}

/// Replaces the characters that have a meaning in XML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
