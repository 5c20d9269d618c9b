//! What the stations do: the picture that plays the run, shares of states, and the timeline.

use super::super::charts::{Bar, Piece};
use super::super::moments::Moments;
use super::super::picture::Picture;
use super::super::{Page, charts, state_class};
use super::summary::limit_of_run;
use super::{
    STATES, first, idle_name, legend, legend_with, part_shape, parts_legend, section_of_first,
};
use crate::html::numbers::{count, percent};
use crate::html::parts::table;
use linewright_language::contract::line::declared_name;
use linewright_line::log::Activity;
use linewright_line::trace::{StationStatistics, WaitKind, duration_in_units};
use maud::{Markup, html};

pub(super) fn animation(page: &Page<'_>, picture: &Picture) -> Markup {
    let trace = first(page);
    let inside = html! {
        div.controls role="group" aria-label="Playback" {
            button #play type="button" aria-pressed="false" { "Play" }
            button #back type="button" aria-label="Previous event" { "◀ Event" }
            button #forward type="button" aria-label="Next event" { "Event ▶" }
            label { "Speed " select #speed {} }
            @if trace.violation_count > 0 { button #violation type="button" { "Next violation" } }
            output #clock for="time" { "0:00:00" }
        }
        div.axis {
            input #time type="range" min="0" max="1000" value="0" step="any" aria-label="Time of the run";
            svg #marks viewBox="0 0 1000 10" preserveAspectRatio="none" aria-hidden="true" {}
        }
        p.hint #cut {}
        @if trace.violation_count > 0 { p.hint { "Red marks below the slider: violations." } }
        div.scroll.picture tabindex="0" role="group" aria-label="Picture" { (picture.draw(page.line, page.recorder)) }
        p #status role="status" { "Point at a place, or move the focus to it, to see what it does." }
        (legend())
        (parts_legend(page, &html! {
            li { svg.key viewBox="-8 -8 16 16" aria-hidden="true" { g.moving { (part_shape(0)) } } "pale: where a part has just come from" }
        }))
        p.hint { "A part goes from place to place in no time, so every part is drawn in a place, and the number in a place is that of the parts there. In a sink, it is that of the parts that it has taken so far. Of more than 14, some are drawn and the rest is a number. While the run plays, a pale copy on the arrow shows the way of a part that has just moved." }
        svg width="0" height="0" aria-hidden="true" { defs {
            @for index in 0..page.line.parts.len() { g id=(format!("part{index}")) { (part_shape(index)) } }
            (patterns())
        } }
    };
    section_of_first(page, "line-section", "The line", &inside)
}

/// Patterns by which states can be distinguished without colours.
fn patterns() -> Markup {
    let lines = [
        ("blocked-pattern", "M0 8L8 0M-2 2L2 -2M6 10L10 6"),
        ("failed-pattern", "M0 0L8 8M0 8L8 0"),
        ("setup-pattern", "M2 0V8M6 0V8"),
        ("starved-pattern", "M0 4H8"),
    ];
    html! {
        @for (id, path) in lines {
            pattern id=(id) width="8" height="8" patternUnits="userSpaceOnUse" {
                rect.ground width="8" height="8" {}
                path.hatch d=(path) {}
            }
        }
    }
}

/// The name of one of the [`STATES`] of a station.
fn name_of(station: &StationStatistics, state: Activity, name: &'static str) -> &'static str {
    if state == Activity::Idle {
        idle_name(station)
    } else {
        name
    }
}

/// Shares of a station's time in the order of [`STATES`].
fn of_states(station: &StationStatistics) -> [f64; 6] {
    let shares = &station.shares;
    [
        shares.busy,
        shares.setup,
        shares.failed,
        shares.blocked,
        shares.starved,
        shares.idle,
    ]
}

/// What the bars of [`shares`] are.
pub(super) const OF_SHARES: &str =
    "Shares of all counted time, off shift included; at the end of each bar is its busy share.";

pub(super) fn shares(stations: &[StationStatistics]) -> Markup {
    let bars: Vec<Bar> = stations
        .iter()
        .map(|station| Bar {
            name: station.name.clone(),
            pieces: of_states(station)
                .into_iter()
                .zip(STATES)
                .map(|(value, (state, name))| Piece {
                    class: state_class(state).to_owned(),
                    value,
                    title: format!(
                        "{} {}: {}",
                        station.name,
                        name_of(station, state, name),
                        percent(value)
                    ),
                })
                .collect(),
            total: percent(station.shares.busy),
        })
        .collect();
    charts::bars("Shares of the time of each station", &bars, 1.0)
}

pub(super) fn stations(page: &Page<'_>) -> Markup {
    let stations = &first(page).stations;
    if stations.is_empty() {
        return html! {};
    }
    let times: Vec<Vec<String>> = stations
        .iter()
        .map(|station| {
            let shares = of_states(station).map(percent);
            std::iter::once(station.name.clone())
                .chain(shares)
                .collect()
        })
        .collect();
    let mut of_times = vec!["Station"];
    of_times.extend(STATES.map(|(_, name)| name));
    let work: Vec<Vec<String>> = stations
        .iter()
        .map(|station| {
            let mut row = vec![
                station.name.clone(),
                station
                    .machine
                    .clone()
                    .unwrap_or_else(|| "not controlled".to_owned()),
                count(station.processed),
                station
                    .work_time
                    .map_or("-".to_owned(), |work| duration_in_units(work.seconds)),
            ];
            row.extend(match &station.oee {
                Some(oee) => [
                    oee.index(),
                    oee.availability,
                    oee.effectiveness,
                    oee.quality,
                ]
                .map(percent),
                None => ["-"; 4].map(str::to_owned),
            });
            row.push(count(station.scrapped));
            row
        })
        .collect();
    let of_work = [
        "Station",
        "Machine",
        "Processed",
        "Work time per part",
        "OEE",
        "Availability (ISO 22400-2)",
        "Effectiveness",
        "Quality",
        "Scrapped",
    ];
    let waits: Vec<Vec<String>> = stations
        .iter()
        .flat_map(|station| station.waits.iter().map(move |wait| (station, wait)))
        .filter(|(_, wait)| wait.share >= 0.005)
        .map(|(station, wait)| {
            let kind = match wait.kind {
                WaitKind::Blocked => "blocked by",
                WaitKind::Starved => "starved of parts from",
            };
            let behind = wait.station.as_ref().filter(|name| **name != wait.place);
            let behind = behind.map_or(String::new(), |name| format!(", before {name}"));
            vec![
                station.name.clone(),
                format!("{kind} {}{behind}", wait.place),
                percent(wait.share),
                percent(wait.failed),
                percent(wait.off_shift),
            ]
        })
        .collect();
    let inside = html! {
        p { (OF_SHARES) }
        (shares(stations))
        (legend())
        details {
            summary { "Show as tables" }
            (table(&of_times, &times))
            (table(&of_work, &work))
        }
        @if !waits.is_empty() {
            h3 { "What the stations waited for" }
            p { "Causes of at least 0.5 % of a station's time. All shares are of all its counted time. The other station is the last one that the second column names." }
            (table(&["Station", "It was", "Share", "of it, while the other station had failed", "of it, while the other station was off shift"], &waits))
        }
        h3 { "Bottleneck" }
        p { (limit_of_run(first(page))) "." }
        (losses(page))
    };
    section_of_first(page, "stations", "Where the time goes", &inside)
}

/// The time of the busiest station by state, in shares and as a duration.
fn losses(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let Some(candidate) = trace.bottleneck.busiest() else {
        return html! {};
    };
    let mut stations = trace.stations.iter();
    let Some(station) = stations.find(|s| declared_name(&s.name) == candidate.name) else {
        return html! {};
    };
    let counted = trace.seconds - trace.warm_up;
    let idle = station.shares.idle;
    let has_time_off = idle > 0.0 && idle < 1.0;
    let rows = of_states(station).into_iter().zip(STATES);
    let rows = rows.map(|(share, (state, name))| {
        let on_shift = match state {
            Activity::Idle => "-".to_owned(),
            _ => percent(share / (1.0 - idle)),
        };
        [name_of(station, state, name).to_owned(), percent(share)]
            .into_iter()
            .chain(has_time_off.then_some(on_shift))
            .chain([duration_in_units(share * counted)])
            .collect()
    });
    let mut headings = vec!["State", "Share of all time"];
    headings.extend(has_time_off.then_some("Share of time on shift"));
    headings.push("Time");
    html! {
        p { "The time of " (station.name) " by state" @if has_time_off { "; the bottleneck is judged by shares of the time on shift" } ":" }
        (table(&headings, &rows.collect::<Vec<_>>()))
        p.hint { "OEE is the product of availability, effectiveness and quality. Availability is that of ISO 22400-2: actual production time by planned busy time, that is, the busy share of the time on shift. So setup, failures, starving and blocking lower it. It is not the technical availability, which only failures lower. Effectiveness is the planned time of the work done by the time in work: it is less than 100 % if work began again after failures. Quality is the share of a station's parts that were not rejected because of it; a part that had to be reworked counts as good. A rejected part counts against the station that made it defective, or else against the last one that worked on it." }
    }
}

pub(super) fn timeline(page: &Page<'_>) -> Markup {
    if first(page).stations.is_empty() {
        return html! {};
    }
    let later = page.recorder.states_end.and_then(|end| {
        let node = first(page).stations.first()?.node;
        let (_, width) = page.recorder.later_states(node)?;
        let end = Moments::of(page.line).instant(end);
        Some((end, duration_in_units(width)))
    });
    let has_refusals = page.recorder.refusals.iter().any(|times| !times.is_empty());
    let inside = html! {
        p { "Drag to move, turn the wheel or press + and − to zoom, 0 to see all. A click sets the time of the picture above. Where states are too short to be seen, the height of each colour is its share." }
        @if let Some((end, width)) = later {
            p { "From " (end) " on, there were too many changes: the rows show the shares of the states in each " (width) "." }
        }
        div.controls role="group" aria-label="Zoom" {
            button #zoom-in type="button" { "Zoom in" }
            button #zoom-out type="button" { "Zoom out" }
            button #zoom-all type="button" { "All" }
            output #window {}
        }
        div.timeline {
            canvas #gantt tabindex="0" role="img" aria-label="States of the stations over time. Shares are in the table of the section before." {}
            div #cursor {}
        }
        (legend_with(&html! { @if has_refusals {
            li { svg.key viewBox="0 0 16 16" aria-hidden="true" { path.refusal d="M2 2H14L8 14Z" {} } "refused" }
        } }))
        @if has_refusals { p.hint { "A station or conveyor refuses a part, or a command, if its contract does not allow it. This takes no time, so it is a mark on the row and not a state." @if page.recorder.has_more_refusals() { " Later refusals are not marked." } } }
    };
    section_of_first(page, "timeline", "Timeline of the stations", &inside)
}
