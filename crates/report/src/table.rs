//! A run as text for a terminal that is 100 columns wide. The tables of estimates are in
//! `intervals.rs`.

use super::Intervals;
use super::columns::{columns, percent, small};
use super::energy::{EnergyUnit, energy};
use super::intervals::{batch_means, measures, replicated, requirements_of_all};
use linewright_language::contract::line::{Comparison, Line};
use linewright_line::trace::{End, Oee, WaitKind, clock, duration};
use linewright_line::{Bottleneck, Candidate, Trace};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Returns a run as text that ends with a line break. If there are `intervals`, the requirements
/// are judged by them, and a table of estimates is added. All other tables show `trace`.
pub fn table(line: &Line, trace: &Trace, intervals: Option<Intervals<'_>>) -> String {
    let mut out = String::new();
    if let Some(Intervals::Replications(replications)) = intervals
        && let [first, _, ..] = replications.seeds[..]
    {
        let _ = writeln!(out, "  {:<12} seed {first}; all seeds are below", "run");
    }
    summary(&mut out, line, trace, intervals);
    products(&mut out, line, trace);
    stations(&mut out, trace);
    equipment(&mut out, trace);
    conveyors(&mut out, trace);
    buffers(&mut out, trace);
    machines(&mut out, trace);
    match intervals {
        Some(Intervals::Replications(replications)) => {
            requirements_of_all(&mut out, line, &replications.requirements);
            replicated(&mut out, replications);
        }
        Some(Intervals::Batches(batches)) => {
            requirements_of_all(&mut out, line, &batches.requirements);
            batch_means(&mut out, batches);
        }
        None => requirements(&mut out, line, trace),
    }
    out
}

/// Returns the numbers that were set for a run, one per line, for the head of its table.
pub fn settings(set: &BTreeMap<&str, &str>) -> String {
    let mut out = String::new();
    for (name, value) in set {
        let _ = writeln!(out, "  {:<12} {name} = {value}", "set");
    }
    out
}

fn summary(out: &mut String, line: &Line, trace: &Trace, intervals: Option<Intervals<'_>>) {
    let ending = match trace.end {
        End::Products => "",
        End::Time => " (the end time was reached)",
        End::Blocked => " (the line can no longer advance)",
        End::NoProgress => " (the line makes no progress)",
        End::PartLost => " (a conveyor lost a part)",
        End::GaveUp => " (the time limit was reached)",
    };
    let mut row = |label: &str, text: String| {
        let _ = writeln!(out, "  {label:<12} {text}");
    };
    let verb = if trace.stored == trace.products && trace.stored > 0 {
        "stored"
    } else {
        "finished"
    };
    row(
        "products",
        format!("{} {verb}{ending}", counted_products(line, trace)),
    );
    let makespan = (trace.products > 0).then(|| duration(trace.makespan));
    row("makespan", makespan.unwrap_or_else(|| "-".to_owned()));
    let how = if trace.warm_up_found {
        " (by MSER-5)".to_owned()
    } else if trace.warm_up_products > 0 {
        let wanted = trace.warm_up_products;
        let plural = if wanted == 1 { "" } else { "s" };
        format!(" (until {wanted} product{plural})")
    } else {
        String::new()
    };
    let (least, most) = match intervals {
        Some(Intervals::Replications(replications)) => replications.warm_up,
        _ => (trace.warm_up, trace.warm_up),
    };
    let warm_up = if most > least {
        format!(
            "; warm-up {}{how}, in all runs {} to {}, not counted",
            duration(trace.warm_up),
            duration(least),
            duration(most)
        )
    } else if trace.warm_up > 0.0 {
        format!("; warm-up {}{how}, not counted", duration(trace.warm_up))
    } else if trace.warm_up_found {
        format!("; no warm-up{how}")
    } else {
        String::new()
    };
    if (trace.seconds - trace.makespan).abs() >= 0.5 || !warm_up.is_empty() {
        row("simulated", duration(trace.seconds) + &warm_up);
    }
    let on_shift = trace.throughput_on_shift.map_or(String::new(), |rate| {
        format!("; {rate:.2} an hour on shift")
    });
    row(
        "throughput",
        format!("{:.2} an hour{on_shift}", trace.throughput_per_hour),
    );
    if trace.products > 0 {
        let t = trace.lead_time;
        row(
            "lead time",
            format!(
                "mean {}, median {}, 95th percentile {}, maximum {}",
                duration(t.mean),
                duration(t.p50),
                duration(t.p95),
                duration(t.max)
            ),
        );
    }
    row(
        "WIP",
        format!(
            "mean {:.2} parts, maximum {}",
            trace.wip.mean, trace.wip.max
        ),
    );
    row("bottleneck", bottleneck(&trace.bottleneck));
    let per_product = if trace.products > 0 && trace.joules > 0.0 {
        let each = energy(trace.joules / trace.products as f64);
        format!("; {each} a product")
    } else {
        String::new()
    };
    row("energy", energy(trace.joules) + &per_product);
    let parts = trace.parts;
    row(
        "parts",
        format!(
            "{}{} entered: {} finished, {} rejected, {} joined into others, {} still in the line",
            if parts.before > 0 {
                format!("{} there before, ", parts.before)
            } else {
                String::new()
            },
            parts.entered,
            parts.finished,
            parts.rejected,
            parts.consumed,
            parts.in_progress
        ),
    );
    row(
        "rejected",
        if trace.rejects.is_empty() {
            "none".to_owned()
        } else {
            let each = |r: &linewright_line::trace::Reject| {
                let name = line.parts.get(r.part).map_or("?", |p| &p.name);
                format!("{} {name} ({} ordered again)", r.count, r.reordered)
            };
            trace
                .rejects
                .iter()
                .map(each)
                .collect::<Vec<_>>()
                .join(", ")
        },
    );
    if trace.yields.first_pass < trace.yields.finished || trace.yields.scrapped > 0 {
        row(
            "quality",
            format!(
                "first-pass yield {}, scrap {}",
                percent(trace.yields.first_pass_yield()),
                percent(trace.yields.scrap_ratio())
            ),
        );
    }
    row(
        "violations",
        if trace.violation_count == 0 {
            "none".to_owned()
        } else {
            trace.violation_count.to_string()
        },
    );
    for violation in trace.violations.iter().take(10) {
        let node = line.nodes.get(violation.node).map_or("?", |n| &n.name);
        let part = violation.part.map_or(String::new(), |(number, kind)| {
            let name = line.parts.get(kind).map_or("part", |p| &p.name);
            format!(", {name} {number}")
        });
        row(
            "",
            format!(
                "{} {node}{part}: {}",
                clock(violation.time),
                violation.rule.as_ref().unwrap_or(&violation.message)
            ),
        );
    }
    if trace.violation_count > 10 {
        row("", format!("and {} more", trace.violation_count - 10));
    }
}

/// The number of products, with the name of the type or the number of each type:
/// `120 (80 Bottle, 40 Can)`.
fn counted_products(line: &Line, trace: &Trace) -> String {
    let total = trace.products;
    let name = |part: usize| line.parts.get(part).map_or("product", |p| &p.name);
    if let Some(product) = line.only_product() {
        return format!("{total} {}", name(product));
    }
    let each = trace.by_type.iter();
    let each = each.map(|product| format!("{} {}", product.products, name(product.part)));
    format!("{total} ({})", each.collect::<Vec<_>>().join(", "))
}

fn products(out: &mut String, line: &Line, trace: &Trace) {
    let rows = trace.by_type.iter().map(|product| {
        let times = product.lead_time;
        let times = [times.mean, times.p50, times.p95, times.max];
        let lead_time = times.map(|seconds| {
            if product.products > 0 {
                duration(seconds)
            } else {
                "-".to_owned()
            }
        });
        [
            line.parts
                .get(product.part)
                .map_or("?", |p| &p.name)
                .to_owned(),
            product.products.to_string(),
            format!("{:.2}", product.throughput_per_hour),
        ]
        .into_iter()
        .chain(lead_time)
        .collect()
    });
    columns(
        out,
        &[
            "product",
            "finished",
            "an hour",
            "mean lead time",
            "median",
            "95th percentile",
            "maximum",
        ],
        &rows.collect::<Vec<_>>(),
    );
}

fn stations(out: &mut String, trace: &Trace) {
    let unit = unit_of(trace.stations.iter().map(|station| station.joules));
    let rows = trace.stations.iter().map(|station| {
        let shares = station.shares.figures();
        [
            station.name.clone(),
            station
                .machine
                .clone()
                .unwrap_or_else(|| "not controlled".to_owned()),
            station.processed.to_string(),
            duration(station.busy_seconds),
            in_unit(station.joules, unit),
        ]
        .into_iter()
        .chain(shares.map(|share| format!("{:.1} %", share * 100.0)))
        .collect()
    });
    columns(
        out,
        &[
            "station",
            "machine",
            "parts",
            "time",
            unit.symbol(),
            "busy",
            "starved",
            "blocked",
            "failed",
            "idle",
            "setup",
        ],
        &rows.collect::<Vec<_>>(),
    );
}

/// Writes the mean time of the work on a part, and the overall equipment effectiveness.
fn equipment(out: &mut String, trace: &Trace) {
    let stations = trace.stations.iter();
    let rows = stations.filter_map(|station| {
        let work = station.work_time?;
        let split = |seconds: f64| {
            let machine = station.machine.as_ref();
            machine.map_or("-".to_owned(), |_| duration(seconds))
        };
        let factor = |value: fn(&Oee) -> f64| percent(station.oee.as_ref().map(value));
        Some(vec![
            station.name.clone(),
            duration(work.seconds),
            split(work.action_seconds()),
            split(work.control_seconds),
            factor(Oee::index),
            factor(|oee| oee.availability),
            factor(|oee| oee.effectiveness),
            factor(|oee| oee.quality),
        ])
    });
    columns(
        out,
        &[
            "station",
            "work a part",
            "actions",
            "control",
            "OEE",
            "availability",
            "effectiveness",
            "quality",
        ],
        &rows.collect::<Vec<_>>(),
    );
}

/// Returns what the table of a run leaves out, for its end: what each station waited for, its
/// energy by state, and all estimates. Ends with a line break, unless it is empty.
pub fn details(line: &Line, trace: &Trace, intervals: Option<Intervals<'_>>) -> String {
    let mut out = String::new();
    waits(&mut out, trace);
    energy_by_state(&mut out, trace);
    match intervals {
        Some(Intervals::Replications(replications)) => {
            measures(&mut out, line, &replications.measures, false);
        }
        Some(Intervals::Batches(batches)) => measures(&mut out, line, &batches.measures, true),
        None => {}
    }
    out
}

/// Writes the energy of each station by state, if any station uses energy.
fn energy_by_state(out: &mut String, trace: &Trace) {
    let stations = trace.stations.iter();
    let unit = unit_of(stations.clone().map(|station| station.joules));
    if stations.clone().all(|station| station.joules <= 0.0) {
        return;
    }
    let rows = stations.map(|station| {
        let states = station.joules_by_state.figures();
        let states = states.map(|joules| in_unit(joules, unit));
        std::iter::once(station.name.clone())
            .chain(states)
            .collect()
    });
    let title = format!("{} by state", unit.symbol());
    columns(
        out,
        &[
            &title, "busy", "starved", "blocked", "failed", "idle", "setup",
        ],
        &rows.collect::<Vec<_>>(),
    );
}

/// Writes what each station waited for; nothing if no station waited for 0.05 % of its time.
fn waits(out: &mut String, trace: &Trace) {
    let shown = |share: f64| {
        if share < 0.0005 {
            "-".to_owned()
        } else {
            percent(Some(share))
        }
    };
    let stations = trace.stations.iter();
    let rows = stations.flat_map(|station| {
        let waits = station.waits.iter().filter(|wait| wait.share >= 0.0005);
        waits.map(move |wait| {
            let behind = wait.station.as_ref().filter(|name| **name != wait.place);
            vec![
                station.name.clone(),
                match wait.kind {
                    WaitKind::Blocked => "blocked by",
                    WaitKind::Starved => "starved by",
                }
                .to_owned(),
                match behind {
                    Some(station) => format!("{}, before {station}", wait.place),
                    None => wait.place.clone(),
                },
                percent(Some(wait.share)),
                shown(wait.failed),
                shown(wait.off_shift),
            ]
        })
    });
    columns(
        out,
        &["station", "waits", "for", "share", "failed", "off shift"],
        &rows.collect::<Vec<_>>(),
    );
}

fn conveyors(out: &mut String, trace: &Trace) {
    let unit = unit_of(trace.conveyors.iter().map(|conveyor| conveyor.joules));
    let rows = trace.conveyors.iter().map(|conveyor| {
        vec![
            conveyor.name.clone(),
            conveyor.machine.clone().unwrap_or_else(|| "-".to_owned()),
            conveyor.carried.to_string(),
            format!("{:.2}", conveyor.length),
            conveyor.longest.to_string(),
            duration(conveyor.moving_seconds),
            in_unit(conveyor.joules, unit),
        ]
    });
    columns(
        out,
        &[
            "conveyor",
            "machine",
            "parts",
            "mean length",
            "maximum",
            "moving",
            unit.symbol(),
        ],
        &rows.collect::<Vec<_>>(),
    );
}

fn buffers(out: &mut String, trace: &Trace) {
    let expire = trace.buffers.iter().any(|buffer| buffer.expired > 0);
    let rows = trace.buffers.iter().map(|buffer| {
        let expired = expire.then(|| buffer.expired.to_string());
        [
            buffer.name.clone(),
            buffer.passed.to_string(),
            format!("{:.2}", buffer.length),
            buffer.longest.to_string(),
            format!("{:.1} %", buffer.full * 100.0),
            duration(buffer.wait),
            duration(buffer.longest_wait),
        ]
        .into_iter()
        .chain(expired)
        .collect()
    });
    let mut heads = vec![
        "buffer",
        "parts",
        "mean length",
        "maximum",
        "full",
        "mean wait",
        "longest wait",
    ];
    heads.extend(expire.then_some("expired"));
    columns(out, &heads, &rows.collect::<Vec<_>>());
}

fn machines(out: &mut String, trace: &Trace) {
    let unit = unit_of(trace.machines.iter().map(|machine| machine.joules));
    let rows = trace.machines.iter().map(|machine| {
        vec![
            machine.name.clone(),
            duration(machine.busy_seconds),
            in_unit(machine.joules, unit),
        ]
    });
    columns(
        out,
        &["by machine", "time", unit.symbol()],
        &rows.collect::<Vec<_>>(),
    );
}

fn requirements(out: &mut String, line: &Line, trace: &Trace) {
    let rows = trace
        .requirements
        .iter()
        .enumerate()
        .map(|(index, result)| {
            vec![
                result.name.clone(),
                result.verdict().word().to_owned(),
                required(line, index),
                result.value.map_or("-".to_owned(), small),
            ]
        });
    columns(
        out,
        &["requirement", "verdict", "required", "measured"],
        &rows.collect::<Vec<_>>(),
    );
}

/// Returns the condition of requirement number `index` of the line, such as `products >= 5`.
pub(super) fn required(line: &Line, index: usize) -> String {
    required_with(line, index, |bound| bound.to_string())
}

/// Returns the condition of requirement number `index` of the line, with its bound in the format of
/// `number`.
pub(super) fn required_with(line: &Line, index: usize, number: impl Fn(f64) -> String) -> String {
    line.requirements.get(index).map_or(String::new(), |r| {
        // Computed bounds are rounded, such as the third of an hour's parts.
        let rounded = (r.bound * 1000.0).round() / 1000.0;
        let bound = if rounded == 0.0 { r.bound } else { rounded };
        format!(
            "{} {} {}",
            line.label_of(&r.metric),
            sign(r.comparison),
            number(bound)
        )
    })
}

/// The unit of a column of energies: that of the greatest.
fn unit_of(joules: impl Iterator<Item = f64>) -> EnergyUnit {
    EnergyUnit::of(joules.fold(0.0, f64::max))
}

fn in_unit(joules: f64, unit: EnergyUnit) -> String {
    format!("{:.3}", joules / unit.joules())
}

/// Names what limits the throughput, with the evidence.
pub(super) fn bottleneck(bottleneck: &Bottleneck) -> String {
    // They differ if the station is off shift for a while.
    let time_of = |station: &Candidate| {
        if (station.engaged_on_shift - station.engaged).abs() > 1e-9 {
            "its time on shift"
        } else {
            "the time"
        }
    };
    let engaged = |station: &Candidate| {
        format!(
            "{} (busy, set up or failed {:.1} % of {})",
            station.name,
            station.engaged_on_shift * 100.0,
            time_of(station)
        )
    };
    match bottleneck {
        Bottleneck::Nothing => "none".to_owned(),
        Bottleneck::Station(station) => engaged(station),
        Bottleneck::Source {
            names,
            busiest,
            parts_wait,
        } => {
            let word = if names.len() == 1 {
                "source"
            } else {
                "sources"
            };
            let sources = names.join(" and ");
            match busiest {
                Some(station) if *parts_wait => format!(
                    "{word} {sources}: {} is starved {:.1} % of {}",
                    station.name,
                    station.starved_on_shift * 100.0,
                    time_of(station)
                ),
                Some(station) => format!(
                    "{word} {sources}, where parts do not wait; busiest: {}",
                    engaged(station)
                ),
                None => format!("{word} {sources}, where parts do not wait"),
            }
        }
        Bottleneck::Deadlock(deadlock) => format!(
            "undecided: deadlock of {} since {}",
            deadlock.listed(),
            clock(deadlock.since)
        ),
        Bottleneck::Undecided(stations) => {
            let stations: Vec<String> = stations.iter().map(engaged).collect();
            format!("undecided: {}", stations.join(", "))
        }
    }
}

fn sign(comparison: Comparison) -> &'static str {
    match comparison {
        Comparison::Lt => "<",
        Comparison::Le => "<=",
        Comparison::Eq => "=",
        Comparison::Ge => ">=",
        Comparison::Gt => ">",
    }
}
