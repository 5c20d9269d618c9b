//! Charts as SVG: bars of shares, curves over time, histograms, intervals.
//!
//! Colours and patterns are classes of the style sheet, so that they follow the reader's scheme.

use super::moments::Moments;
use super::series::{Columns, Curve};
use crate::html::numbers::{count, figure, marks, rounded};
use linewright_line::trace::duration_in_units;
use maud::{Markup, PreEscaped, html};
use std::fmt::Write as _;

const WIDTH: f64 = 860.0;
const LEFT: f64 = 56.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 30.0;

/// A part of a bar.
pub(super) struct Piece {
    /// Classes of the style sheet that give its colour and pattern.
    pub class: String,
    /// Length, in the unit of the bar.
    pub value: f64,
    /// What the tooltip says.
    pub title: String,
}

/// A bar of pieces.
pub(super) struct Bar {
    pub name: String,
    pub pieces: Vec<Piece>,
    /// Text at the end of the bar.
    pub total: String,
}

/// Bars of pieces, one below the other. `max` is the value of the full width.
pub(super) fn bars(label: &str, bars: &[Bar], max: f64) -> Markup {
    const ROW: f64 = 26.0;
    let longest = bars
        .iter()
        .map(|bar| bar.name.chars().count())
        .max()
        .unwrap_or(0);
    let left = (longest as f64 * 7.2 + 12.0).clamp(60.0, 260.0);
    let totals = bars
        .iter()
        .map(|bar| bar.total.chars().count())
        .max()
        .unwrap_or(0);
    let right = totals as f64 * 7.2 + 12.0;
    let scale = (WIDTH - left - right) / max.max(f64::MIN_POSITIVE);
    let height = bars.len() as f64 * ROW + 4.0;
    html! {
        svg.chart viewBox=(format!("0 0 {WIDTH} {height}")) role="img" aria-label=(label) {
            @for (row, bar) in bars.iter().enumerate() {
                @let y = row as f64 * ROW + 2.0;
                text.name x=(left - 8.0) y=(y + 16.0) text-anchor="end" { (bar.name) }
                @for (start, piece) in starts(&bar.pieces) {
                    rect class=(&piece.class) x=(number(left + start * scale)) y=(y) width=(number(piece.value * scale)) height=(ROW - 4.0) {
                        title { (piece.title) }
                    }
                }
                @let end = bar.pieces.iter().map(|piece| piece.value).sum::<f64>();
                text x=(number(left + end * scale + 6.0)) y=(y + 16.0) { (bar.total) }
            }
        }
    }
}

/// The pieces of a bar with the values at which they begin.
fn starts(pieces: &[Piece]) -> impl Iterator<Item = (f64, &Piece)> {
    let begins = pieces.iter().scan(0.0, |end, piece| {
        let start = *end;
        *end += piece.value;
        Some(start)
    });
    begins.zip(pieces).filter(|(_, piece)| piece.value > 0.0)
}

/// The axis of time that the timeline of the stations and all charts over time share, so that they
/// can be compared from top to bottom.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeAxis {
    /// Where time 0 is, in SVG units.
    left: f64,
    /// End of the run in seconds.
    end: f64,
    /// End of the warm-up in seconds.
    warm_up: f64,
    moments: Moments,
}

impl TimeAxis {
    /// Leaves room on the left for the names of the stations.
    pub fn new<'a>(
        names: impl Iterator<Item = &'a str>,
        end: f64,
        warm_up: f64,
        moments: Moments,
    ) -> Self {
        let longest = names.map(|name| name.chars().count()).max().unwrap_or(0);
        let left = (longest as f64 * 6.6 + 16.0).clamp(LEFT, 165.0);
        Self {
            left,
            end,
            warm_up,
            moments,
        }
    }

    /// Room on the left and on the right, as shares of the width.
    pub fn margins(self) -> [f64; 2] {
        [self.left / WIDTH, RIGHT / WIDTH]
    }

    fn frame(self, max: f64) -> Frame {
        Frame {
            left: self.left,
            top: TOP,
            height: 170.0,
            seconds: self.end,
            max,
            moments: self.moments,
        }
    }
}

/// A frame with axes: time to the right, a number upwards.
struct Frame {
    left: f64,
    /// Room above the highest value.
    top: f64,
    height: f64,
    seconds: f64,
    max: f64,
    moments: Moments,
}

impl Frame {
    fn x(&self, time: f64) -> f64 {
        self.left + (WIDTH - self.left - RIGHT) * time / self.seconds.max(f64::MIN_POSITIVE)
    }

    fn y(&self, value: f64) -> f64 {
        let room = self.height - self.top - BOTTOM;
        self.top + room * (1.0 - value / self.max.max(f64::MIN_POSITIVE))
    }

    /// Lines at the marks of the vertical axis, of a class of the style sheet.
    fn grid(&self, class: &str) -> Markup {
        html! {
            @for mark in marks(self.max, 4) {
                line class=(class) x1=(self.left) x2=(WIDTH - RIGHT) y1=(number(self.y(mark))) y2=(number(self.y(mark))) {}
            }
        }
    }

    fn draw(&self, label: &str, warm_up: f64, inside: &Markup) -> Markup {
        let (left, height) = (self.left, self.height);
        html! {
            svg.chart viewBox=(format!("0 0 {WIDTH} {height}")) role="img" aria-label=(label) {
                @if warm_up > 0.0 {
                    rect.warmup x=(left) y=(self.top) width=(number(self.x(warm_up) - left)) height=(height - self.top - BOTTOM) {
                        title { "Warm-up: not counted" }
                    }
                }
                (self.grid("grid"))
                @for mark in marks(self.max, 4) {
                    text x=(left - 6.0) y=(number(self.y(mark) + 4.0)) text-anchor="end" { (figure(mark)) }
                }
                @for (time, text) in self.moments.marks(self.seconds, 8) {
                    @let is_last = self.x(time) > WIDTH - 2.0 * RIGHT;
                    text x=(number(if is_last { WIDTH } else { self.x(time) })) y=(height - 8.0) text-anchor=(if is_last { "end" } else { "middle" }) { (text) }
                }
                (inside)
            }
        }
    }
}

/// A number of parts over time: the mean of each bin as a line, and an area up to its maximum. Time
/// before the end of the warm-up is marked, and so is the `capacity`.
pub(super) fn curve(label: &str, curve: &Curve, axis: TimeAxis, capacity: Option<u32>) -> Markup {
    let highest = curve.maxima.iter().copied().max().unwrap_or(0) as f64;
    let frame = axis.frame(highest.max(capacity.map_or(1.0, f64::from)));
    let maxima: Vec<f64> = curve.maxima.iter().map(|max| *max as f64).collect();
    let area = stairs(&frame, &maxima, curve.width, curve.end);
    let mean = stairs(&frame, &curve.means, curve.width, curve.end);
    let (left, bottom, right) = (frame.x(0.0), frame.y(0.0), frame.x(curve.end));
    let inside = html! {
        path.area d=(format!("M{left:.1} {bottom:.1}{area}L{right:.1} {bottom:.1}Z")) {}
        (frame.grid("over"))
        @if let Some(capacity) = capacity {
            // Just above its value, where the area of a full buffer ends.
            @let y = number(frame.y(f64::from(capacity)) - 2.0);
            line.halo x1=(axis.left) x2=(WIDTH - RIGHT) y1=(y) y2=(y) {}
            line.capacity x1=(axis.left) x2=(WIDTH - RIGHT) y1=(y) y2=(y) {
                title { "Capacity: " (capacity) }
            }
        }
        path.line d=(format!("M{}", &mean[1..])) {}
    };
    frame.draw(label, axis.warm_up, &inside)
}

/// A quantity over time: the mean of each bin, which is `width` seconds wide, apart from the last.
pub(super) fn rate(label: &str, values: &[f64], width: f64, axis: TimeAxis) -> Markup {
    let frame = axis.frame(values.iter().copied().fold(0.0, f64::max));
    let line = stairs(&frame, values, width, axis.end);
    let (left, bottom, right) = (frame.x(0.0), frame.y(0.0), frame.x(axis.end));
    let inside = html! {
        path.area d=(format!("M{left:.1} {bottom:.1}{line}L{right:.1} {bottom:.1}Z")) {}
        (frame.grid("over"))
        path.line d=(format!("M{}", &line[1..])) {}
    };
    frame.draw(label, axis.warm_up, &inside)
}

/// The times at which a bin begins and ends, in seconds. The last one ends at `end`, whether it is
/// shorter or longer than the others.
pub(super) fn span(bin: usize, count: usize, width: f64, end: f64) -> (f64, f64) {
    let start = bin as f64 * width;
    let stop = if bin + 1 < count { start + width } else { end };
    (start, stop)
}

/// A line of stairs, as path data that begins with `L`. A stair is as wide as a bin.
fn stairs(frame: &Frame, values: &[f64], width: f64, end: f64) -> String {
    let mut data = String::new();
    for (bin, value) in values.iter().enumerate() {
        let (start, stop) = span(bin, values.len(), width, end);
        let (x, right, y) = (frame.x(start), frame.x(stop), frame.y(*value));
        // Writing to a string cannot fail.
        let _ = write!(data, "L{x:.1} {y:.1}H{right:.1}");
    }
    if data.is_empty() {
        data.push_str("L0 0");
    }
    data
}

/// Height of a name above a histogram.
const NAME: f64 = 15.0;

/// The name of a marked line, above a histogram.
#[derive(Debug, Clone, PartialEq)]
struct LineName<'a> {
    name: &'a str,
    x: f64,
    /// Row from the top on, in which the line begins.
    row: usize,
    /// Whether the name is on the left of the line.
    is_left: bool,
}

/// Places the names of lines in rows above a chart, so that no line goes through a name: each line
/// begins in the row of its name.
fn line_names<'a>(lines: &[(&'a str, f64)]) -> Vec<LineName<'a>> {
    let mut sorted = lines.to_vec();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    // From the right: names that have no room on the right are on the left of their lines, in the
    // upper rows. All lines on the left of these begin below.
    let mut limit = WIDTH;
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for (name, x) in sorted.into_iter().rev() {
        let width = name.chars().count() as f64 * 7.0 + 8.0;
        if x + width > limit {
            limit = x;
            left.push((name, x, true));
        } else {
            right.push((name, x, false));
        }
    }
    let rows = left.into_iter().chain(right.into_iter().rev()).enumerate();
    let rows = rows.map(|(row, (name, x, is_left))| LineName {
        name,
        x,
        row,
        is_left,
    });
    rows.collect()
}

/// How often times fall into classes. `upwards` says what is counted; `lines` are marked with their
/// names.
pub(super) fn histogram(
    label: &str,
    columns: &Columns,
    upwards: &str,
    lines: &[(&str, f64)],
) -> Markup {
    let Columns { width, counts, .. } = columns;
    let highest = counts.iter().copied().max().unwrap_or(0) as f64;
    let step = marks(highest, 4).get(1).copied().unwrap_or(1.0);
    let seconds = width * counts.len() as f64;
    let lines = lines.iter().filter(|(_, at)| *at <= seconds);
    let top = TOP + NAME * lines.clone().count() as f64;
    let frame = Frame {
        left: LEFT,
        top,
        height: 178.0 + top,
        seconds,
        max: (highest / step).ceil() * step,
        moments: Moments::Elapsed,
    };
    let middle = frame.y(frame.max / 2.0);
    let lines: Vec<(&str, f64)> = lines.map(|(name, at)| (*name, frame.x(*at))).collect();
    let inside = html! {
        text x="12" y=(number(middle)) transform=(format!("rotate(-90 12 {middle:.1})")) text-anchor="middle" { (upwards) }
        @for (class, number_of) in counts.iter().enumerate() {
            @let start = class as f64 * width;
            @let (x, y) = (frame.x(start), frame.y(*number_of as f64));
            rect.column x=(number(x)) y=(number(y)) width=(number((frame.x(start + width) - x - 1.0).max(0.5))) height=(number(frame.y(0.0) - y)) {
                title { (duration_in_units(start)) " to " (duration_in_units(start + width)) ": " (count(*number_of)) }
            }
        }
        @for line in line_names(&lines) {
            @let base = TOP + NAME * line.row as f64;
            line.mark x1=(number(line.x)) x2=(number(line.x)) y1=(number(base - 9.0)) y2=(number(frame.y(0.0))) {}
            text x=(number(if line.is_left { line.x - 4.0 } else { line.x + 4.0 })) y=(number(base)) text-anchor=(if line.is_left { "end" } else { "start" }) { (line.name) }
        }
    };
    frame.draw(label, 0.0, &inside)
}

/// An interval, and the values that it was estimated from, as shares of a base: 0.1 is 10 % more.
pub(super) struct Range {
    pub name: String,
    pub low: f64,
    pub mean: f64,
    pub high: f64,
    pub values: Vec<f64>,
    /// What stands below the interval.
    pub text: String,
}

/// Intervals, one below the other, on one scale: percent of the base of each.
pub(super) fn ranges(label: &str, ranges: &[Range]) -> Markup {
    /// Room for an interval and its text.
    const ROW: f64 = 44.0;
    /// Room for a row of dots above an interval.
    const DOTS: f64 = 5.0;
    /// Maximum number of rows of dots, so that few dots lie on one another.
    const MAX_ROWS: usize = 8;
    let dots = ranges.iter().map(|range| range.values.len()).max();
    let rows = dots.unwrap_or(0).min(MAX_ROWS);
    let above = DOTS * rows.saturating_sub(1) as f64;
    let lengths = ranges.iter().map(|range| range.name.chars().count());
    let names = (lengths.max().unwrap_or(0) as f64 * 6.6 + 16.0).clamp(210.0, 400.0);
    let bottom = ranges.len() as f64 * (ROW + above) + 4.0;
    let height = bottom + 24.0;
    let scale = Scale::of(ranges, names + 110.0, WIDTH - 110.0);
    html! {
        svg.chart viewBox=(format!("0 0 {WIDTH} {height}")) role="img" aria-label=(label) {
            @for mark in scale.marks() {
                line.grid x1=(number(scale.x(mark))) x2=(number(scale.x(mark))) y1="2" y2=(bottom) {}
                text x=(number(scale.x(mark))) y=(bottom + 16.0) text-anchor="middle" { (signed(mark, 0.0)) }
            }
            line.capacity x1=(number(scale.x(0.0))) x2=(number(scale.x(0.0))) y1="2" y2=(bottom) {}
            @for (row, range) in ranges.iter().enumerate() {
                @let y = row as f64 * (ROW + above) + above + 16.0;
                text.name x=(names) y=(y + 4.0) text-anchor="end" { (range.name) }
                line.interval x1=(number(scale.x(range.low))) x2=(number(scale.x(range.high))) y1=(y) y2=(y) {}
                @for (index, value) in range.values.iter().enumerate() {
                    circle.run cx=(number(scale.x(*value))) cy=(number(y - 11.0 - DOTS * (index % MAX_ROWS) as f64)) r="2.5" {}
                }
                circle.mean cx=(number(scale.x(range.mean))) cy=(y) r="4" {}
                // A short interval is seen by its ends, which are longer than the dot.
                @for end in [range.low, range.high] {
                    line.end x1=(number(scale.x(end))) x2=(number(scale.x(end))) y1=(y - 7.0) y2=(y + 7.0) {}
                }
                text x=(number(scale.x(range.mean))) y=(y + 20.0) text-anchor="middle" { (range.text) }
            }
        }
    }
}

/// A share as a percentage with its sign, with the digits that fit the half-width of its interval,
/// which is 0 if there is none.
pub(super) fn signed(share: f64, half_width: f64) -> String {
    let percent = rounded(share * 100.0, half_width * 100.0);
    if share > 0.0 && percent.bytes().any(|digit| (b'1'..=b'9').contains(&digit)) {
        format!("+{percent} %")
    } else {
        format!("{percent} %")
    }
}

/// A scale on which all of the ranges are seen, and 0.
struct Scale {
    low: f64,
    high: f64,
    left: f64,
    right: f64,
}

impl Scale {
    fn of(ranges: &[Range], left: f64, right: f64) -> Self {
        let all = ranges.iter().flat_map(|range| {
            let own = [range.low, range.high, range.mean, 0.0];
            own.into_iter().chain(range.values.iter().copied())
        });
        let (low, high) = all.fold((0.0_f64, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let widening = if high > low { 0.0 } else { 0.01 };
        let (low, high) = (low - widening, high + widening);
        let step = Self::step(low, high);
        // There is a mark at each end.
        Self {
            low: (low / step).floor() * step,
            high: (high / step).ceil() * step,
            left,
            right,
        }
    }

    /// Distance between two marks.
    fn step(low: f64, high: f64) -> f64 {
        marks(high - low, 6).get(1).copied().unwrap_or(0.01)
    }

    fn x(&self, value: f64) -> f64 {
        self.left + (self.right - self.left) * (value - self.low) / (self.high - self.low)
    }

    fn marks(&self) -> Vec<f64> {
        let step = Self::step(self.low, self.high);
        let first = (self.low / step - 1e-6).ceil() as i64;
        let last = (self.high / step + 1e-6).floor() as i64;
        (first..=last).map(|index| index as f64 * step).collect()
    }
}

fn number(value: f64) -> PreEscaped<String> {
    PreEscaped(format!("{value:.1}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_goes_through_the_name_of_another() {
        for xs in [
            [300.0, 303.0, 700.0],
            [303.0, 300.0, 830.0],
            [800.0, 810.0, 820.0],
            [840.0, 790.0, 843.0],
        ] {
            let names = ["median", "mean", "95th percentile"];
            let lines: Vec<(&str, f64)> = names.into_iter().zip(xs).collect();
            let placed = line_names(&lines);
            assert_eq!(placed.len(), 3);
            for of in &placed {
                let width = of.name.len() as f64 * 7.0 + 4.0;
                let (from, to) = if of.is_left {
                    (of.x - width, of.x)
                } else {
                    (of.x, of.x + width)
                };
                assert!(to <= WIDTH, "{of:?}");
                let crosses = |line: &LineName<'_>| {
                    line.row < of.row && line.x > from && line.x < to && line.name != of.name
                };
                assert!(!placed.iter().any(crosses), "{placed:?}");
            }
        }
    }
}
