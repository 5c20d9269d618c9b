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
