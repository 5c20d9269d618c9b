//! Gantt charts: what each resource does when, as SVG.

use super::canvas::{Anchor, Canvas, LABEL_FONT, MARGIN, STATE_FONT, Shape, Text};
use super::layers::{Point, Size};
use super::svg::PAGE_WIDTH;
use super::text::{self, fitting};

/// Distance between two rows, and height of a bar, in SVG units.
const ROW: f64 = 34.0;
const BAR: f64 = 24.0;

/// Height of the title of a chart, of the texts of the axis, and of the text of an instant, in SVG
/// units.
const TITLE: f64 = 22.0;
const AXIS: f64 = 18.0;
const INSTANT: f64 = 16.0;

/// Distance between two charts, in SVG units.
const GAP: f64 = 26.0;

/// Distance between the edge of a bar and its label, in SVG units.
const PADDING: f64 = 4.0;

const RULE: &str = "stroke=\"gainsboro\" stroke-width=\"1\" fill=\"none\"";
const TEST: &str = "stroke=\"dimgray\" stroke-width=\"1.2\" stroke-dasharray=\"5 3\" fill=\"none\"";
const LINK: &str = "class=\"link\" stroke=\"dimgray\" stroke-width=\"1.2\" fill=\"none\"";
const CRITICAL_LINK: &str =
    "class=\"link critical\" stroke=\"firebrick\" stroke-width=\"2.5\" fill=\"none\"";
const LEGEND: &str = "rx=\"2\" fill=\"white\" stroke=\"firebrick\" stroke-width=\"2.5\"";

/// Charts with the same axis, one below the other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gantt {
    /// End of the axis, which begins at 0.
    pub end: f64,
    /// Marks of the axis with their texts.
    pub marks: Vec<(f64, String)>,
    /// The charts.
    pub charts: Vec<GanttChart>,
}

/// What the resources do in one course of events.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GanttChart {
    /// Title.
    pub title: String,
    /// Rows: the name of each resource, and its bars.
    pub rows: Vec<(String, Vec<GanttBar>)>,
    /// What goes from one row to another.
    pub links: Vec<GanttLink>,
    /// Instants that concern all rows, such as tests, with their texts.
    pub instants: Vec<(f64, String)>,
}

/// What a resource does for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct GanttBar {
    /// Begin and end.
    pub time: [f64; 2],
    /// What is done, short; it is cut off if the bar is too narrow.
    pub label: String,
    /// What is done, in full: the bar has it as its title.
    pub description: String,
    /// What kind of work it is.
    pub kind: BarKind,
    /// Whether it is on the critical path.
    pub is_critical: bool,
}

/// Kind of the work of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarKind {
    /// An operation on parts.
    Operation,
    /// Part of a transfer.
    Transfer,
    /// An operation of the resource's own.
    Internal,
}

impl GanttBar {
    fn style(&self) -> &'static str {
        match (self.kind, self.is_critical) {
            (BarKind::Operation, false) => {
                "class=\"operation\" rx=\"2\" fill=\"lightsteelblue\" stroke=\"black\""
            }
            (BarKind::Operation, true) => {
                "class=\"operation critical\" rx=\"2\" fill=\"lightsteelblue\" stroke=\"firebrick\" stroke-width=\"2.5\""
            }
            (BarKind::Transfer, false) => {
                "class=\"transfer\" rx=\"2\" fill=\"aliceblue\" stroke=\"dimgray\""
            }
            (BarKind::Transfer, true) => {
                "class=\"transfer critical\" rx=\"2\" fill=\"aliceblue\" stroke=\"firebrick\" stroke-width=\"2.5\""
            }
            (BarKind::Internal, false) => {
                "class=\"internal\" rx=\"2\" fill=\"whitesmoke\" stroke=\"dimgray\" stroke-dasharray=\"3 3\""
            }
            (BarKind::Internal, true) => {
                "class=\"internal critical\" rx=\"2\" fill=\"whitesmoke\" stroke=\"firebrick\" stroke-width=\"2.5\""
            }
        }
    }
}

/// What goes from one row to another at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct GanttLink {
    /// When.
    pub at: f64,
    /// Indices of the two rows.
    pub rows: [usize; 2],
    /// Whether it is on the critical path.
    pub is_critical: bool,
}

/// Draws the charts and returns the SVG document, which is 1,600 units wide. Bars without a length
/// are not drawn; links without a length are.
pub fn render(name: &str, gantt: &Gantt) -> String {
    picture(gantt, PAGE_WIDTH - 2.0 * MARGIN).document(name)
}

fn picture(gantt: &Gantt, limit: f64) -> Canvas {
    let names = (gantt.charts.iter()).flat_map(|chart| &chart.rows);
    let names = names.map(|(name, _)| text::width(name, STATE_FONT, false));
    let left = (names.fold(0.0, f64::max) + 12.0).min(limit / 3.0);
    // The last mark has its text in the middle below it.
    let last = gantt
        .marks
        .last()
        .map_or(0.0, |(_, mark)| text::width(mark, LABEL_FONT, false));
    let scale = Scale {
        left,
        right: limit - (last / 2.0).max(4.0),
        unit: (limit - (last / 2.0).max(4.0) - left) / gantt.end.max(f64::MIN_POSITIVE),
        limit,
    };
    let mut canvas = Canvas::default();
    for chart in &gantt.charts {
        canvas.add_below(GAP, drawn(chart, &gantt.marks, &scale));
    }
    let bars = gantt
        .charts
        .iter()
        .flat_map(|c| c.rows.iter().flat_map(|row| &row.1));
    if bars.clone().any(|bar| bar.is_critical) {
        canvas.add_below(GAP / 2.0, legend(left));
    }
    canvas
}

/// How times become places.
struct Scale {
    left: f64,
    right: f64,
    /// SVG units for each unit of time.
    unit: f64,
    /// Width of the whole picture.
    limit: f64,
}

impl Scale {
    fn x(&self, time: f64) -> f64 {
        self.left + time * self.unit
    }
}

fn drawn(chart: &GanttChart, marks: &[(f64, String)], scale: &Scale) -> Canvas {
    let axis = TITLE + chart.instants.len() as f64 * INSTANT;
    let top = axis + AXIS;
    let bottom = top + chart.rows.len() as f64 * ROW;
    let mut canvas = Canvas {
        size: Size {
            width: scale.limit,
            height: bottom,
        },
        shapes: Vec::new(),
    };
    let title = Point {
        x: 0.0,
        y: TITLE - 8.0,
    };
    canvas.write_in(
        STATE_FONT,
        title,
        true,
        &fitting(&chart.title, scale.limit, (STATE_FONT, true)),
    );
    rules(&mut canvas, marks, scale, [top, bottom]);
    for (number, (name, bars)) in chart.rows.iter().enumerate() {
        let middle = top + (number as f64 + 0.5) * ROW;
        let base = Point {
            x: 0.0,
            y: middle + 0.35 * STATE_FONT,
        };
        let name = fitting(name, scale.left - 6.0, (STATE_FONT, false));
        canvas.write_in(STATE_FONT, base, false, &name);
        for bar in bars.iter().filter(|bar| bar.time[1] > bar.time[0]) {
            self::bar(&mut canvas, bar, middle, scale);
        }
    }
    for link in &chart.links {
        let [from, to] = link.rows.map(|row| top + (row as f64 + 0.5) * ROW);
        let x = scale.x(link.at);
        let style = if link.is_critical {
            CRITICAL_LINK
        } else {
            LINK
        };
        let half = if to > from { BAR / 2.0 } else { -BAR / 2.0 };
        let ends = [from + half, to - half];
        // The head points to the row that takes.
        let head = if to > from { -5.0 } else { 5.0 };
        canvas
            .shapes
            .push(Shape::Line(ends.map(|y| Point { x, y }).to_vec(), style));
        let side = |dx: f64| Point {
            x: x + dx,
            y: ends[1] + head,
        };
        let tip = Point { x, y: ends[1] };
        canvas
            .shapes
            .push(Shape::Line(vec![side(-3.0), tip, side(3.0)], style));
    }
    for (number, (at, what)) in chart.instants.iter().enumerate() {
        let x = scale.x(*at);
        let y = TITLE + (number as f64 + 0.7) * INSTANT;
        let line = vec![Point { x, y: y - 4.0 }, Point { x, y: bottom }];
        canvas.shapes.push(Shape::Line(line, TEST));
        // The text is beside the line, on the side where there is room.
        let what = fitting(what, scale.limit, (LABEL_FONT, false));
        let width = text::width(&what, LABEL_FONT, false);
        let beside = if x + PADDING + width <= scale.limit {
            x + PADDING
        } else {
            (x - PADDING - width).max(0.0)
        };
        canvas.write_in(LABEL_FONT, Point { x: beside, y }, false, &what);
    }
    canvas
}

/// Draws the axis with its marks.
fn rules(canvas: &mut Canvas, marks: &[(f64, String)], scale: &Scale, [top, bottom]: [f64; 2]) {
    for (at, mark) in marks {
        let x = scale.x(*at);
        let line = vec![Point { x, y: top }, Point { x, y: bottom }];
        canvas.shapes.push(Shape::Line(line, RULE));
        canvas.shapes.push(Shape::Text(Text {
            at: Point { x, y: top - 5.0 },
            anchor: Anchor::Middle,
            font: LABEL_FONT,
            is_bold: false,
            has_halo: false,
            content: mark.clone(),
        }));
    }
    for y in [top, bottom] {
        let line = [scale.left, scale.right].map(|x| Point { x, y }).to_vec();
        canvas.shapes.push(Shape::Line(line, RULE));
    }
}

fn bar(canvas: &mut Canvas, bar: &GanttBar, middle: f64, scale: &Scale) {
    let [from, to] = bar.time.map(|time| scale.x(time));
    let corner = Point {
        x: from,
        y: middle - BAR / 2.0,
    };
    let size = Size {
        width: to - from,
        height: BAR,
    };
    let description = bar.description.clone();
    canvas
        .shapes
        .push(Shape::Titled(corner, size, bar.style(), description));
    let label = fitting(&bar.label, size.width - 2.0 * PADDING, (LABEL_FONT, false));
    if !label.is_empty() {
        let center = Point {
            x: f64::midpoint(from, to),
            y: middle,
        };
        canvas.lines(center, &[label], LABEL_FONT, false);
    }
}

/// Says how the critical path is drawn.
fn legend(left: f64) -> Canvas {
    let mut canvas = Canvas::default();
    let size = Size {
        width: 28.0,
        height: 12.0,
    };
    let corner = Point { x: left, y: 3.0 };
    canvas.shapes.push(Shape::Rectangle(corner, size, LEGEND));
    let at = Point {
        x: left + size.width + 8.0,
        y: 13.0,
    };
    canvas.write_in(LABEL_FONT, at, false, "critical path");
    canvas
}

#[cfg(test)]
mod tests {
    use super::super::svg::tests::{faults, texts};
    use super::*;
    use proptest::prelude::*;

    const LIMIT: f64 = 1580.0;

    fn bar(from: f64, to: f64, label: &str) -> GanttBar {
        GanttBar {
            time: [from, to],
            label: label.to_owned(),
            description: format!("{label}: {from} s to {to} s"),
            kind: BarKind::Operation,
            is_critical: from < 1.0,
        }
    }

    fn gantt(bars: Vec<GanttBar>) -> Gantt {
        Gantt {
            end: 40.0,
            marks: [0.0, 20.0, 40.0].map(|at| (at, format!("{at} s"))).to_vec(),
            charts: vec![GanttChart {
                title: "worst case".to_owned(),
                rows: vec![("press".to_owned(), bars), ("robot".to_owned(), Vec::new())],
                links: vec![GanttLink {
                    at: 10.0,
                    rows: [0, 1],
                    is_critical: false,
                }],
                instants: vec![(40.0, "isGood(p)".to_owned())],
            }],
        }
    }

    #[test]
    fn bars_are_as_long_as_their_times() {
        let bars = vec![
            bar(0.0, 10.0, "form"),
            bar(10.0, 30.0, "heat"),
            bar(30.0, 30.0, "open"),
        ];
        let canvas = picture(&gantt(bars), LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let widths: Vec<(f64, f64)> = (canvas.shapes.iter())
            .filter_map(|shape| match shape {
                Shape::Titled(corner, size, ..) => Some((corner.x, size.width)),
                _ => None,
            })
            .collect();
        let [(first, one), (second, two)] = widths[..] else {
            panic!("{widths:?}");
        };
        assert!((first + one - second).abs() < 1e-9 && (two - 2.0 * one).abs() < 1e-9);
        let texts = texts(&canvas);
        for text in [
            "form",
            "heat",
            "press",
            "40 s",
            "isGood(p)",
            "critical path",
        ] {
            assert!(texts.contains(&text), "{text}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn no_text_is_on_a_text(
            lengths in prop::collection::vec((0.0..4.0_f64, "[a-zW]{0,30}"), 0..10),
            title in "[a-zW ]{0,300}",
        ) {
            let mut at = 0.0;
            let bars = lengths.iter().map(|(length, label)| {
                at += length;
                bar(at - length, at, label)
            });
            let mut gantt = gantt(bars.collect());
            gantt.charts[0].title.clone_from(&title);
            gantt.charts[0].instants.push((at, title));
            prop_assert_eq!(faults(&picture(&gantt, LIMIT)), [""; 0]);
        }
    }
}
