//! The sections of a page, from top to bottom.

mod evidence;
mod intervals;
mod operation;
mod quantities;
mod summary;

use super::picture::Picture;
use super::{Page, state_class};
use evidence::{model, violations};
use intervals::{comparison, replications};
use linewright_line::Trace;
use linewright_line::log::Activity;
use maud::{Markup, html};
use operation::{animation, stations, timeline};
use quantities::{energy, flow, lead_times, queues};
use summary::{header, requirements, tiles};

/// States of a station with their names, in the order of the bars.
const STATES: [(Activity, &str); 6] = [
    (Activity::Busy, "busy"),
    (Activity::Setup, "setup"),
    (Activity::Failed, "failed"),
    (Activity::Blocked, "blocked"),
    (Activity::Starved, "starved"),
    (Activity::Idle, "idle"),
];

pub(super) fn all(page: &Page<'_>, picture: &Picture) -> Markup {
    html! {
        (header(page))
        main {
            (tiles(page))
            (animation(page, picture))
            (requirements(page))
            (replications(page))
            (comparison(page))
            (stations(page))
            (timeline(page))
            (queues(page))
            (lead_times(page))
            (energy(page))
            (flow(page, picture))
            (violations(page))
            (model(page))
        }
    }
}

/// A section with its heading.
fn section(id: &str, heading: &str, inside: &Markup) -> Markup {
    html! {
        section id=(id) aria-labelledby=(format!("{id}-heading")) {
            h2 id=(format!("{id}-heading")) { (heading) }
            (inside)
        }
    }
}

/// A table behind a chart.
fn behind(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        details {
            summary { "Show as a table" }
            (table(headings, rows))
        }
    }
}

/// A table. The first column names the rows; others that hold numbers are aligned on the right.
fn table(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    let is_number = |column: usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(column));
        cells.all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
    };
    let class = |column: usize| (column > 0 && is_number(column)).then_some("number");
    html! {
        div.scroll tabindex="0" role="group" aria-label="Table" {
            table {
                thead { tr { @for (column, heading) in headings.iter().enumerate() {
                    th scope="col" class=[class(column)] { (heading) }
                } } }
                tbody { @for row in rows { tr { @for (column, cell) in row.iter().enumerate() {
                    @if column == 0 { th scope="row" { (cell) } } @else { td class=[class(column)] { (cell) } }
                } } } }
            }
        }
    }
}

fn first<'a>(page: &Page<'a>) -> &'a Trace {
    &page.traces[0]
}

fn legend() -> Markup {
    html! {
        ul.legend aria-label="States" { @for (state, name) in STATES {
            li { svg.key viewBox="0 0 16 16" aria-hidden="true" { rect class=(state_class(state)) width="16" height="16" {} } (name) }
        } }
    }
}
