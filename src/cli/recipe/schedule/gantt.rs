//! A plan as Gantt charts: one for each way through its tests.

use super::quantity::{NANOSECONDS, instant, value};
use super::{Happening, Outcome, Section, View};
use crate::drawing::gantt::{BarKind, Gantt, GanttBar, GanttChart, GanttLink};
use crate::recipe::plan::{Entry, EntrySubject, Next, Objective};
use crate::report::html::parts::time_marks;

/// Maximum number of charts.
const MAX_CHARTS: usize = 60;
/// Number of marks of the axis.
const MARKS: usize = 10;

/// A way through the tests of a position: its sections, and when it ends.
struct Way<'v, 'p> {
    sections: Vec<&'v Section<'p>>,
    end: i64,
}

/// Returns the charts of a plan with times, and how many more there would be. If there are too
/// many, each position has the one that takes longest.
pub(in crate::cli::recipe) fn chart(title: &str, view: &View<'_>) -> (Gantt, usize) {
    let sections = view.sections();
    let mut ways: Vec<Way<'_, '_>> = sections.iter().filter_map(|s| way(&sections, s)).collect();
    if ways.len() > MAX_CHARTS {
        let mut longest: Vec<Way<'_, '_>> = Vec::new();
        for way in ways {
            match longest.last_mut() {
                Some(last) if last.sections[0].position == way.sections[0].position => {
                    if way.end > last.end {
                        *last = way;
                    }
                }
                _ => longest.push(way),
            }
        }
        ways = longest;
    }
    let left_out = ways.len().saturating_sub(MAX_CHARTS);
    ways.truncate(MAX_CHARTS);
    let end = seconds(ways.iter().map(|way| way.end).max().unwrap_or(0));
    let gantt = Gantt {
        end,
        marks: time_marks(end, MARKS),
        charts: ways.iter().map(|way| one(title, view, way)).collect(),
    };
    (gantt, left_out)
}

fn seconds(nanoseconds: i64) -> f64 {
    nanoseconds as f64 / NANOSECONDS
}

/// Returns the way that ends with a section, if no test follows it.
fn way<'v, 'p>(all: &'v [Section<'p>], last: &'v Section<'p>) -> Option<Way<'v, 'p>> {
    let end = match &last.schedule.then {
        Next::End { time } | Next::Goto { time, .. } => *time,
        Next::Test { .. } => return None,
    };
    let before = all
        .iter()
        .filter(|s| s.position == last.position && last.outcomes.starts_with(&s.outcomes));
    Some(Way {
        sections: before.collect(),
        end,
    })
}

fn one(title: &str, view: &View<'_>, way: &Way<'_, '_>) -> GanttChart {
    let resources = view.layout.resources.iter();
    let mut chart = GanttChart {
        title: heading(title, view, way),
        rows: resources.map(|r| (r.name.clone(), Vec::new())).collect(),
        ..GanttChart::default()
    };
    for section in &way.sections {
        for happening in view.happenings(section) {
            for entry in happening.entries {
                let bar = bar(view, section, &happening, entry);
                chart.rows[entry.resource].1.push(bar);
            }
            if let [a, b] = happening.entries
                && matches!(a.subject, EntrySubject::Part(_))
            {
                let (giver, taker) = if view.gives(a) { (a, b) } else { (b, a) };
                chart.links.push(GanttLink {
                    at: seconds(taker.start),
                    rows: [giver.resource, taker.resource],
                    is_critical: happening.is_critical,
                });
            }
        }
        if let Some(outcome) = section.begins {
            chart
                .instants
                .push((seconds(outcome.time), view.outcome(outcome)));
        }
    }
    chart
}

fn heading(title: &str, view: &View<'_>, way: &Way<'_, '_>) -> String {
    let outcome = |outcome: Outcome| view.outcome(outcome);
    let outcomes = way.sections.iter().filter_map(|s| s.begins.map(outcome));
    let outcomes: Vec<String> = outcomes.collect();
    let time = value(Objective::Time, way.end);
    let mut heading = title.to_owned();
    if view.plan.positions.len() > 1 {
        heading = format!("{heading}, {}", way.sections[0].number);
    }
    if outcomes.is_empty() {
        format!("{heading}: {time}")
    } else {
        format!("{heading}: {time} ({})", outcomes.join("; "))
    }
}

fn bar(
    view: &View<'_>,
    section: &Section<'_>,
    happening: &Happening<'_>,
    entry: &Entry,
) -> GanttBar {
    let kind = match &entry.subject {
        EntrySubject::Operation { .. } => BarKind::Operation,
        EntrySubject::Part(_) => BarKind::Transfer,
        EntrySubject::Internal => BarKind::Internal,
    };
    let what = &happening.what;
    // The operation without its parts.
    let short = what.split('(').next().unwrap_or(what);
    let number = |product: usize| format!("{}: ", product + 1);
    let is_one_of_many = view.plan.products.len() > 1;
    let number = happening.product.filter(|_| is_one_of_many).map(number);
    GanttBar {
        time: [seconds(entry.start), seconds(entry.end)],
        label: number.unwrap_or_default() + short,
        description: format!(
            "{}{}: {what}, {} to {}",
            happening
                .product
                .map(|p| view.of_product(p))
                .unwrap_or_default(),
            happening.resource,
            instant(entry.start),
            instant(entry.end)
        ),
        kind,
        is_critical: view.is_critical(section, entry),
    }
}
