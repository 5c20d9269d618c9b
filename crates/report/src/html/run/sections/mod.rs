//! The sections of a page, from top to bottom.

mod conclusion;
mod evidence;
mod intervals;
mod operation;
mod quantities;
mod summary;

use super::picture::Picture;
use super::{Page, state_class};
use crate::html::numbers::count;
use crate::html::parts::section_of;
use evidence::{model, violations};
use intervals::{comparison, replications};
use linewright_language::contract::line::Line;
use linewright_line::Trace;
use linewright_line::log::Activity;
use linewright_line::trace::StationStatistics;
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
    (Activity::Idle, "off shift or not used"),
];

/// What the last of the [`STATES`] means at a station: whether it was off shift, or whether no part
/// ever came.
fn idle_name(station: &StationStatistics) -> &'static str {
    if station.processed == 0 && station.shares.idle >= 1.0 {
        "not used"
    } else {
        "off shift"
    }
}

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

/// Whether a station or a conveyor has a contract.
fn has_contracts(line: &Line) -> bool {
    line.nodes.iter().any(|node| node.machine().is_some())
}

/// Whether a station is off shift at times.
fn has_shifts(line: &Line) -> bool {
    (0..line.nodes.len()).any(|node| line.calendar_of(node).is_some())
}

/// The stations that took no energy in the first run.
fn unpowered<'a>(page: &Page<'a>) -> Vec<&'a str> {
    let has_none = |node: usize| page.recorder.joules[node].iter().sum::<f64>() <= 0.0;
    let stations = first(page).stations.iter();
    stations
        .filter(|station| has_none(station.node))
        .map(|station| station.name.as_str())
        .collect()
}

/// Number of end products of each type, in the order of the line's part types.
fn made(line: &Line, trace: &Trace) -> Vec<(usize, u64)> {
    match line.only_product() {
        Some(product) => vec![(product, trace.products)],
        None => trace
            .by_type
            .iter()
            .map(|product| (product.part, product.products))
            .collect(),
    }
}

/// Numbers of parts as text: `50 Toy`, or `120 products (80 Bottle, 40 Can)`.
fn counted(line: &Line, numbers: &[(usize, u64)]) -> String {
    let each = numbers
        .iter()
        .map(|(kind, number)| format!("{} {}", count(*number), line.parts[*kind].name));
    let each = each.collect::<Vec<_>>().join(", ");
    if numbers.len() == 1 {
        return each;
    }
    let total = numbers.iter().map(|(_, number)| number).sum();
    format!("{} products ({each})", count(total))
}

fn first<'a>(page: &Page<'a>) -> &'a Trace {
    &page.traces[0]
}

/// A section about the first run, which its heading says if there are several.
fn section_of_first(page: &Page<'_>, id: &str, heading: &str, inside: &Markup) -> Markup {
    let note = match page.traces {
        [_] => None,
        [first, ..] => Some(format!(
            "run 1 of {}, random seed {}",
            page.traces.len(),
            first.seed
        )),
        [] => unreachable!("a page has a run; please report this"),
    };
    section_of(id, heading, note.as_deref(), inside)
}

fn legend() -> Markup {
    legend_with(&html! {})
}

/// The legend of the states, and more entries.
fn legend_with(more: &Markup) -> Markup {
    html! {
        ul.legend aria-label="States" {
            @for (state, name) in STATES {
                li { svg.key viewBox="0 0 16 16" aria-hidden="true" { rect class=(state_class(state)) width="16" height="16" {} } (name) }
            }
            (more)
        }
    }
}

/// The legend of the part types, and more entries.
fn parts_legend(page: &Page<'_>, more: &Markup) -> Markup {
    html! {
        ul.legend aria-label="Parts" {
            @for (index, part) in page.line.parts.iter().enumerate() {
                li { svg.key viewBox="-8 -8 16 16" aria-hidden="true" { (part_shape(index)) } (part.name) }
            }
            (more)
        }
    }
}

/// The shape of a part of this type: shape and colour tell types apart.
fn part_shape(index: usize) -> Markup {
    let class = part_class(index);
    html! {
        @match index % 4 {
            0 => circle class=(class) r="5" {},
            1 => rect class=(class) x="-4.5" y="-4.5" width="9" height="9" {},
            2 => path class=(class) d="M0 -6L6 4.5H-6Z" {},
            _ => path class=(class) d="M0 -6L6 0L0 6L-6 0Z" {},
        }
    }
}

/// The classes of the style sheet for a part of this type.
fn part_class(index: usize) -> String {
    format!("part part{}", index % 6)
}
