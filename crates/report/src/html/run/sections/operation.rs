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
        @if trace.violation_count > 0 { p.hint { "Red below the slider: the violations. Those that are close together are one bar." } }
        div.scroll.picture tabindex="0" role="group" aria-label="Picture" { (picture.draw(page.line, page.recorder)) }
        p #status role="status" { "Point at a place, or move the focus to it, to see what it does." }
        (frames())
        (parts_legend(page, &html! {
            li { svg.key viewBox="-8 -8 16 16" aria-hidden="true" { g.moving { (part_shape(0)) } } "on an arrow: a part that has just moved" }
        }))
        p.hint { "A part goes from place to place in no time, so every part is drawn in a place. The figure at the bottom of a place counts all parts there; a station with fewer than two parts shows none. In a sink it counts the parts taken so far, in a source the parts delivered; a store has both, \"in\" and \"out\". Of more than 14 parts in a place, 10 are drawn, and a number such as +5 stands for the others; a conveyor shows all. While the run plays, a copy on the arrow shows the way of a part that has just moved. Parts are numbered in the order in which they were made, over all types." }
        svg width="0" height="0" aria-hidden="true" { defs {
            @for index in 0..page.line.parts.len() { g id=(format!("part{index}")) { (part_shape(index)) } }
            (patterns())
        } }
    };
    section_of_first(page, "line-section", "The line", &inside)
}

/// The legend of the frames by which the picture shows the states of stations.
fn frames() -> Markup {
    html! {
        ul.legend aria-label="Frames of stations" {
            @for (state, name) in STATES {
                li { svg.key.long viewBox="0 0 28 16" aria-hidden="true" { rect.frame.(state_class(state)) x="2" y="2" width="24" height="12" {} } (name) }
            }
        }
    }
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
    let has_refused = stations.iter().any(|of| refused(page, of) > 0);
    let is_uncontrolled = stations.iter().any(|of| of.machine.is_none());
    let work: Vec<Vec<String>> = stations
        .iter()
        .map(|station| {
            let mut row = vec![
                station.name.clone(),
                station
                    .machine
                    .clone()
                    .unwrap_or_else(|| "none: given by its times".to_owned()),
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
            row.extend(has_refused.then(|| count(refused(page, station))));
            row
        })
        .collect();
    let mut of_work = vec![
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
    of_work.extend(has_refused.then_some("Refused"));
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
            let is_starved = wait.kind == WaitKind::Starved;
            let apart = if is_starved && refused(page, station) > 0 {
                ", apart from those that it refused"
            } else {
                ""
            };
            let has_other = wait.station.is_some()
                || stations.iter().any(|other| {
                    [other.name.as_str(), declared_name(&other.name)].contains(&wait.place.as_str())
                });
            let of_other = |share: f64| {
                if has_other {
                    percent(share)
                } else {
                    "-".to_owned()
                }
            };
            vec![
                station.name.clone(),
                format!("{kind} {}{behind}{apart}", wait.place),
                percent(wait.share),
                of_other(wait.failed),
                of_other(wait.off_shift),
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
            @if is_uncontrolled { p.hint { "A station without a machine is given by its times in the model: it has no contract, and no controller." } }
            @if stations.iter().any(|of| of.work_time.is_none() || of.oee.is_none()) { p.hint { "There is a dash if the station finished no work, or if its work takes no time." } }
            p.hint { (OF_OEE) }
            p.hint { "Scrapped are the parts that were rejected because of the station. " (CHARGED) " A part on which no station has worked counts at none." @if has_refused { " Refused are the parts that came to the station and were taken out there at once, because its contract does not allow them." } }
        }
        @if !waits.is_empty() {
            h3 { "What the stations waited for" }
            p { "Causes of at least 0.5 % of a station's time. All shares are of all its counted time. The last two columns are about the station that the second column names last; there is a dash if it names none." }
            @if has_refused { p { "A station that refuses a part goes on waiting: " (refusing(page)) "." } }
            (table(&["Station", "It was", "Share", "of it, while the other station had failed", "of it, while the other station was off shift"], &waits))
        }
        h3 { "Bottleneck" }
        p { (limit_of_run(first(page))) "." }
        (losses(page))
    };
    section_of_first(page, "stations", "Where the time goes", &inside)
}

/// What the columns of the OEE are.
const OF_OEE: &str = "OEE is the product of availability, effectiveness and quality. Availability is that of ISO 22400-2: actual production time divided by planned busy time, that is, the busy share of the time on shift. So setup, failures, starving and blocking lower it. It is not the technical availability, which only failures lower. Effectiveness is the share of the busy time that was not lost; work is lost if it begins again after a failure. Quality is the share of a station's parts that were not rejected because of it; a part that had to be reworked counts as good.";

/// At which station a rejected part counts.
const CHARGED: &str = "A rejected part counts at the station that made it defective, or else at the last one that worked on it.";

/// Number of parts that a station refused.
fn refused(page: &Page<'_>, station: &StationStatistics) -> u64 {
    page.recorder.refused[station.node]
}

/// The stations that refused parts, with the numbers of these.
fn refusing(page: &Page<'_>) -> String {
    let stations = first(page).stations.iter();
    let stations = stations.filter(|station| refused(page, station) > 0);
    let each = stations.map(|station| {
        let number = refused(page, station);
        let parts = if number == 1 { "part" } else { "parts" };
        format!("{} refused {} {parts}", station.name, count(number))
    });
    each.collect::<Vec<_>>().join(", ")
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
    }
}

/// What stations do at the end of a shift; `None` if there are no shifts.
fn at_the_end_of_shifts(page: &Page<'_>) -> Option<&'static str> {
    let line = page.line;
    let calendars = (0..line.nodes.len()).filter_map(|node| line.calendar_of(node));
    let shifts = calendars.flat_map(|calendar| &calendar.shifts);
    let finish: Vec<bool> = shifts.map(|shift| shift.finishes_work).collect();
    if finish.is_empty() {
        return None;
    }
    Some(if finish.iter().all(|finishes| *finishes) {
        "When a shift or the work before a break ends, a station finishes the part that it has begun; until then it is busy. Conveyors and buffers go on, so parts can still arrive off shift."
    } else if finish.iter().any(|finishes| *finishes) {
        "When a shift or the work before a break ends, a station finishes the part that it has begun, if the shift is declared with finish work; until then it is busy. Otherwise the work goes on in the next shift. Conveyors and buffers go on, so parts can still arrive off shift."
    } else {
        "When a shift or the work before a break ends, the work on a part is interrupted; it goes on in the next shift. Conveyors and buffers go on, so parts can still arrive off shift."
    })
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
        @if let Some(sentence) = at_the_end_of_shifts(page) { p { (sentence) } }
        p { "Drag to move, turn the wheel or press + and − to zoom, 0 to see all. A click sets the time of the picture above. Where states are too short to be seen, the height of each color is its share." }
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
            li { svg.key viewBox="0 0 16 16" aria-hidden="true" { rect.refusal y="2" width="16" height="12" {} } "refused several times, with the number" }
        } }))
        @if has_refusals { p.hint { "A station or conveyor refuses a part, or a command, if its contract does not allow it. This takes no time, so it is a mark on the row and not a state. Marks that would overlap are one bar." @if page.recorder.has_more_refusals() { " Later refusals are not marked." } } }
    };
    section_of_first(page, "timeline", "Timeline of the stations", &inside)
}
