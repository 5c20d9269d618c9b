//! Timing diagrams: the values of signals over steps, as SVG.

use super::canvas::{Anchor, Canvas, MARGIN, STATE_FONT as FONT, Shape, Text};
use super::layers::{Point, Size};
use super::svg::PAGE_WIDTH;
use super::text::{self, fitting};

/// Height of a signal, in SVG units.
const HEIGHT: f64 = 30.0;

/// Distance between two signals, in SVG units.
const ROW: f64 = 46.0;

/// Height of the line with the title of a group, in SVG units.
const TITLE: f64 = 30.0;

/// Height of the line with the numbers of the steps, in SVG units.
const HEADING: f64 = 20.0;

/// Distance between two parts of a diagram that is too wide, in SVG units.
const GAP: f64 = 18.0;

/// Least and greatest width of a step, in SVG units.
const STEP: [f64; 2] = [40.0, 150.0];

/// Room for the last line between steps, in SVG units.
const BORDER: f64 = 1.0;

/// Width of the edges at which a word begins and ends, in SVG units.
const SLOPE: f64 = 4.0;

const WAVE: &str = "stroke=\"black\" stroke-width=\"2\" fill=\"none\"";
const HIGH: &str = "fill=\"lightsteelblue\" fill-opacity=\"0.45\"";
const BASE: &str = "stroke=\"gray\" stroke-width=\"1\" fill=\"none\"";
const WORD: &str = "stroke=\"black\" stroke-width=\"1.1\" fill=\"aliceblue\"";
const UNKNOWN: &str =
    "stroke=\"dimgray\" stroke-width=\"1.1\" fill=\"whitesmoke\" stroke-dasharray=\"3 3\"";
const RULE: &str = "stroke=\"gainsboro\" stroke-width=\"1\" fill=\"none\"";
const REPEATED: &str = "fill=\"lemonchiffon\"";

/// A timing diagram.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TimingDiagram {
    /// Groups of signals with their titles, such as inputs and outputs.
    pub groups: Vec<(String, Vec<Signal>)>,
    /// Number of the first step.
    pub first: usize,
    /// Number of steps.
    pub steps: usize,
    /// Index of the step from which on the steps repeat for ever.
    pub repeats_from: Option<usize>,
}

/// The values of a signal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signal {
    /// Name of the signal.
    pub name: String,
    /// Value in each step.
    pub values: Vec<Level>,
}

/// The value of a signal in a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Level {
    /// A Boolean value.
    Bit(bool),
    /// Any other value, as text.
    Word(String),
    /// No value.
    Unknown,
}

/// Draws a timing diagram and returns the SVG document. It is at most 1,600 units wide: if there
/// are more steps than fit, the diagram goes on below.
pub fn render(name: &str, diagram: &TimingDiagram) -> String {
    picture(diagram, PAGE_WIDTH - 2.0 * MARGIN).document(name)
}

fn picture(diagram: &TimingDiagram, limit: f64) -> Canvas {
    let signals = || diagram.groups.iter().flat_map(|(_, signals)| signals);
    let names = signals().map(|signal| text::width(&signal.name, FONT, false));
    let titles = diagram.groups.iter();
    let titles = titles.map(|(title, _)| text::width(title, FONT, true));
    let left = (names.chain(titles).fold(0.0, f64::max) + 12.0).min(limit / 2.0);
    let room = signals()
        .flat_map(|signal| runs(&signal.values))
        .map(|(level, from, to)| {
            let Level::Word(word) = level else { return 0.0 };
            (text::width(word, FONT, false) + 2.0 * SLOPE + 6.0) / (to - from) as f64
        });
    let step = room.fold(STEP[0], f64::max).min(STEP[1]);
    let in_row = (((limit - left - BORDER) / step).floor() as usize).max(1);
    let mut canvas = Canvas::default();
    let mut from = 0;
    while from < diagram.steps {
        let to = (from + in_row).min(diagram.steps);
        let part = Part {
            diagram,
            from,
            to,
            left,
            step,
        };
        canvas.add_below(GAP, part.drawn());
        from = to;
    }
    if let Some(from) = diagram.repeats_from.filter(|from| *from < diagram.steps) {
        let (from, last) = (diagram.first + from, diagram.first + diagram.steps - 1);
        let steps = if from == last {
            format!("Step {from} repeats for ever.")
        } else {
            format!("Steps {from} to {last} repeat for ever.")
        };
        let base = canvas.size.height + FONT + 6.0;
        canvas.write_in(FONT, Point { x: 0.0, y: base }, false, &steps);
    }
    canvas
}

/// Runs of equal values: value, first index, index after the last.
fn runs(values: &[Level]) -> Vec<(&Level, usize, usize)> {
    let mut from = 0;
    let chunks = values.chunk_by(|a, b| a == b).map(|chunk| {
        let start = from;
        from += chunk.len();
        (&chunk[0], start, from)
    });
    chunks.collect()
}

/// Some steps of a diagram, which fit beside each other.
struct Part<'a> {
    diagram: &'a TimingDiagram,
    from: usize,
    to: usize,
    /// Where the first step begins.
    left: f64,
    /// Width of a step.
    step: f64,
}

impl Part<'_> {
    fn drawn(&self) -> Canvas {
        let titles = self
            .diagram
            .groups
            .iter()
            .filter(|(title, _)| !title.is_empty());
        let signals = self.diagram.groups.iter().map(|(_, signals)| signals.len());
        let rows = signals.sum::<usize>();
        let mut canvas = Canvas {
            size: Size {
                width: self.x(self.to) + BORDER,
                height: HEADING + titles.count() as f64 * TITLE + rows as f64 * ROW,
            },
            shapes: Vec::new(),
        };
        self.grid(&mut canvas);
        let mut y = HEADING;
        for (title, signals) in &self.diagram.groups {
            if !title.is_empty() {
                let base = Point {
                    x: 0.0,
                    y: y + TITLE / 2.0 + 4.0,
                };
                canvas.write_in(FONT, base, true, title);
                y += TITLE;
            }
            for signal in signals {
                let base = Point {
                    x: 0.0,
                    y: y + ROW / 2.0 + 4.0,
                };
                canvas.write_in(
                    FONT,
                    base,
                    false,
                    &fitting(&signal.name, self.left, (FONT, false)),
                );
                self.signal(&mut canvas, y + (ROW - HEIGHT) / 2.0, signal);
                y += ROW;
            }
        }
        canvas
    }

    fn x(&self, step: usize) -> f64 {
        self.left + (step - self.from) as f64 * self.step
    }

    /// Lines between the steps with their numbers; steps that repeat have a background.
    fn grid(&self, canvas: &mut Canvas) {
        let bottom = canvas.size.height;
        if let Some(repeated) = self.diagram.repeats_from.filter(|from| *from < self.to) {
            let x = self.x(repeated.max(self.from));
            let size = Size {
                width: self.x(self.to) - x,
                height: bottom,
            };
            canvas
                .shapes
                .push(Shape::Rectangle(Point { x, y: 0.0 }, size, REPEATED));
        }
        // A number has room if it is narrower than the steps that it stands for.
        let widest = text::width(&(self.diagram.first + self.to).to_string(), FONT, false);
        let each = ((widest + 6.0) / self.step).ceil().max(1.0) as usize;
        for step in self.from..=self.to {
            let x = self.x(step);
            let line = vec![Point { x, y: HEADING }, Point { x, y: bottom }];
            canvas.shapes.push(Shape::Line(line, RULE));
            if step < self.to && (step - self.from).is_multiple_of(each) {
                canvas.shapes.push(Shape::Text(Text {
                    at: Point {
                        x: x + self.step / 2.0,
                        y: HEADING - 6.0,
                    },
                    anchor: Anchor::Middle,
                    font: FONT,
                    is_bold: false,
                    has_halo: false,
                    content: (self.diagram.first + step).to_string(),
                }));
            }
        }
    }

    /// Draws a signal between `top` and `top + HEIGHT`. Bits have a line at the low level in all
    /// steps, and the high level is filled down to it.
    fn signal(&self, canvas: &mut Canvas, top: f64, signal: &Signal) {
        let values = signal.values.get(self.from..self.to).unwrap_or_default();
        self.base(canvas, top, values);
        let mut wave: Vec<Point> = Vec::new();
        for (level, from, to) in runs(values) {
            let [left, right] = [from, to].map(|step| self.x(self.from + step));
            if let Level::Bit(is_high) = level {
                let y = if *is_high { top } else { top + HEIGHT };
                wave.extend([Point { x: left, y }, Point { x: right, y }]);
                continue;
            }
            finish(canvas, &mut wave);
            let middle = top + HEIGHT / 2.0;
            let style = if *level == Level::Unknown {
                UNKNOWN
            } else {
                WORD
            };
            let outline = [
                (left, middle),
                (left + SLOPE, top),
                (right - SLOPE, top),
                (right, middle),
                (right - SLOPE, top + HEIGHT),
                (left + SLOPE, top + HEIGHT),
                (left, middle),
            ];
            let outline = outline.map(|(x, y)| Point { x, y }).to_vec();
            canvas.shapes.push(Shape::Line(outline, style));
            let word = match level {
                Level::Word(word) => Some(word.as_str()),
                Level::Unknown => Some("?"),
                Level::Bit(_) => None,
            };
            if let Some(word) = word {
                let center = Point {
                    x: f64::midpoint(left, right),
                    y: middle,
                };
                let word = fitting(word, right - left - 2.0 * SLOPE, (FONT, false));
                canvas.lines(center, &[word], FONT, false);
            }
        }
        finish(canvas, &mut wave);
    }

    /// Draws what is behind the wave of a signal: the low level, and what is below the high one.
    fn base(&self, canvas: &mut Canvas, top: f64, values: &[Level]) {
        for (level, from, to) in runs(values) {
            if *level == Level::Bit(true) {
                let [left, right] = [from, to].map(|step| self.x(self.from + step));
                let size = Size {
                    width: right - left,
                    height: HEIGHT,
                };
                let corner = Point { x: left, y: top };
                canvas.shapes.push(Shape::Rectangle(corner, size, HIGH));
            }
        }
        if values.iter().any(|level| matches!(level, Level::Bit(_))) {
            let [left, right] = [self.from, self.to].map(|step| self.x(step));
            let line = [left, right].map(|x| Point { x, y: top + HEIGHT }).to_vec();
            canvas.shapes.push(Shape::Line(line, BASE));
        }
    }
}

/// Draws the levels of bits that were collected.
fn finish(canvas: &mut Canvas, wave: &mut Vec<Point>) {
    if !wave.is_empty() {
        canvas.shapes.push(Shape::Line(std::mem::take(wave), WAVE));
    }
}

#[cfg(test)]
mod tests {
    use super::super::svg::tests::{faults, texts};
    use super::*;
    use proptest::prelude::*;

    const LIMIT: f64 = 1580.0;

    fn signal(name: &str, values: Vec<Level>) -> Signal {
        Signal {
            name: name.to_owned(),
            values,
        }
    }

    fn timing(signals: Vec<Signal>, steps: usize, repeats_from: Option<usize>) -> TimingDiagram {
        TimingDiagram {
            groups: vec![("Inputs".to_owned(), signals)],
            first: 0,
            steps,
            repeats_from,
        }
    }

    #[test]
    fn equal_words_are_one_box_and_bits_one_wave() {
        let word = |text: &str| Level::Word(text.to_owned());
        let command = signal("command", vec![word("none"), word("turn"), word("turn")]);
        let bits = [false, true, true].map(Level::Bit);
        let canvas = picture(
            &timing(vec![command, signal("done", bits.to_vec())], 3, Some(1)),
            LIMIT,
        );
        assert_eq!(faults(&canvas), [""; 0]);
        let texts = texts(&canvas);
        assert_eq!(texts.iter().filter(|text| **text == "turn").count(), 1);
        assert!(texts.contains(&"Steps 1 to 2 repeat for ever."));
        let waves = canvas.shapes.iter();
        assert_eq!(
            waves.filter(|s| matches!(s, Shape::Line(_, WAVE))).count(),
            1
        );
    }

    #[test]
    fn bits_have_a_line_at_the_low_level_and_words_have_none() {
        let word = signal("command", vec![Level::Word("none".to_owned()); 3]);
        let bits = [false, true, false].map(Level::Bit).to_vec();
        let canvas = picture(&timing(vec![word, signal("done", bits)], 3, None), LIMIT);
        let lines = |style: &str| {
            let shapes = canvas.shapes.iter();
            let lines = shapes.filter_map(|shape| match shape {
                Shape::Line(points, of) if *of == style => Some(points.clone()),
                _ => None,
            });
            lines.collect::<Vec<_>>()
        };
        let ([base], [wave]) = (
            lines(BASE).try_into().expect("one"),
            lines(WAVE).try_into().expect("one"),
        );
        let (base, wave): (Vec<Point>, Vec<Point>) = (base, wave);
        assert_eq!(base, [wave[0], *wave.last().expect("a wave")]);
        let high = |shape: &&Shape| matches!(shape, Shape::Rectangle(corner, size, HIGH) if *corner == wave[2] && (size.width - STEP[0]).abs() < 0.1);
        assert_eq!(canvas.shapes.iter().filter(high).count(), 1);
    }

    #[test]
    fn a_long_diagram_goes_on_below() {
        let bits: Vec<Level> = (0..200).map(|step| Level::Bit(step % 3 == 0)).collect();
        let canvas = picture(&timing(vec![signal("done", bits)], 200, None), LIMIT);
        assert!(canvas.size.width <= LIMIT);
        assert_eq!(faults(&canvas), [""; 0]);
        let names = texts(&canvas);
        assert!(names.iter().filter(|text| **text == "done").count() > 1);
        assert!(names.contains(&"199"));
    }

    fn any_level() -> impl Strategy<Value = Level> {
        prop_oneof![
            any::<bool>().prop_map(Level::Bit),
            "[a-zW ]{0,40}".prop_map(Level::Word),
            Just(Level::Unknown),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn no_text_is_on_a_text(
            signals in prop::collection::vec(("[a-zW]{1,60}", prop::collection::vec(any_level(), 90)), 1..5),
            steps in 1_usize..90,
            repeats in prop::option::of(0_usize..90),
        ) {
            let signals = signals.into_iter().map(|(name, mut values)| {
                values.truncate(steps);
                signal(&name, values)
            });
            let canvas = picture(&timing(signals.collect(), steps, repeats), LIMIT);
            prop_assert!(canvas.size.width <= LIMIT);
            prop_assert_eq!(faults(&canvas), [""; 0]);
        }
    }
}
