//! A run as a JSON document of the schema `linewright/run/1`.
//!
//! Seconds and rates have six decimal places, energies nine. Shares have six decimal places and are
//! rounded so that they still sum to 1.

use super::Intervals;
use linewright_language::contract::line::Line;
use linewright_language::contract::metric::{Measure, MeasureUnit};
use linewright_line::estimates::{Estimated, Subject};
use linewright_line::metric::JOULES_PER_KWH;
use linewright_line::trace::{
    ByState, LeadTime, Oee, OverTime, SourceStatistics, StationStatistics, WaitKind, WorkTime,
};
use linewright_line::{
    Batches, Bottleneck, Estimate, ReplicatedRequirement, Replications, Trace, Verdict,
};
use serde_json::{Value, json};

/// JSON Schema of the document.
pub const RUN_SCHEMA: &str = include_str!("run.schema.json");

/// Returns the JSON document of a run. If `wall_seconds` is `None` (`--no-timing`), the document
/// has no field of this name. If there are `intervals`, the document also contains estimates over
/// all replications or batches, and judges the requirements over all of them. Everything else
/// describes `trace`: with replications, the run with the first seed.
pub fn json(
    line: &Line,
    trace: &Trace,
    intervals: Option<Intervals<'_>>,
    wall_seconds: Option<f64>,
) -> Value {
    let part_name = |part: usize| line.parts.get(part).map(|p| p.name.as_str());
    let node_name = |node: usize| line.nodes.get(node).map(|n| n.name.as_str());
    let stations: Vec<Value> = trace
        .stations
        .iter()
        .map(|station| {
            let shares = rounded(&station.shares);
            json!({
                "name": station.name,
                "machine": station.machine,
                "processed": station.processed,
                "busy": shares.busy,
                "starved": shares.starved,
                "blocked": shares.blocked,
                "failed": shares.failed,
                "idle": shares.idle,
                "setup": shares.setup,
                "busy_seconds": round(station.busy_seconds, 6),
                "energy_kwh": kwh(station.joules),
                "energy_by_state_kwh": energy_by_state(&station.joules_by_state),
                "work": station.work_time.map(|work| work_time(work, station.machine.is_some())),
                "oee": station.oee.as_ref().map(oee),
                "scrapped": station.scrapped,
                "blocked_by": waits(station, WaitKind::Blocked),
                "starved_by": waits(station, WaitKind::Starved),
            })
        })
        .collect();
    let conveyors: Vec<Value> = trace
        .conveyors
        .iter()
        .map(|conveyor| {
            json!({
                "name": conveyor.name,
                "machine": conveyor.machine,
                "carried": conveyor.carried,
                "mean_length": round(conveyor.length, 6),
                "max_length": conveyor.longest,
                "moving_seconds": round(conveyor.moving_seconds, 6),
                "energy_kwh": kwh(conveyor.joules),
                "energy_by_state_kwh": {
                    "moving": kwh((conveyor.joules - conveyor.standing_joules).max(0.0)),
                    "standing": kwh(conveyor.standing_joules),
                },
            })
        })
        .collect();
    let buffers: Vec<Value> = trace
        .buffers
        .iter()
        .map(|buffer| {
            json!({
                "name": buffer.name,
                "passed": buffer.passed,
                "mean_length": round(buffer.length, 6),
                "max_length": buffer.longest,
                "full": round(buffer.full, 6),
                "mean_wait_seconds": round(buffer.wait, 6),
                "max_wait_seconds": round(buffer.longest_wait, 6),
                "expired": buffer.expired,
            })
        })
        .collect();
    let machines: Vec<Value> = trace
        .machines
        .iter()
        .map(|machine| {
            json!({
                "name": machine.name,
                "busy_seconds": round(machine.busy_seconds, 6),
                "energy_kwh": kwh(machine.joules),
            })
        })
        .collect();
    let rejects: Vec<Value> = trace
        .rejects
        .iter()
        .map(|reject| {
            json!({
                "part": part_name(reject.part),
                "count": reject.count,
                "reordered": reject.reordered,
            })
        })
        .collect();
    let violations: Vec<Value> = trace
        .violations
        .iter()
        .map(|violation| {
            json!({
                "time": round(violation.time, 6),
                "station": node_name(violation.node),
                "rule": violation.rule,
                "code": violation.code as i32,
                "message": violation.message,
                "part": violation.part.and_then(|(_, part)| part_name(part)),
                "part_number": violation.part.map(|(number, _)| number),
            })
        })
        .collect();
    let requirements: Vec<Value> = match intervals {
        Some(Intervals::Replications(replications)) => {
            let requirements = replications.requirements.iter();
            let seed = |run: usize| replications.seeds.get(run).copied();
            requirements
                .map(|r| replicated_requirement(r, seed(r.worst)))
                .collect()
        }
        Some(Intervals::Batches(batches)) => {
            let requirements = batches.requirements.iter().zip(&batches.lags_1);
            requirements
                .map(|(r, lag_1)| batch_requirement(r, *lag_1))
                .collect()
        }
        None => trace
            .requirements
            .iter()
            .map(|r| requirement(&r.name, r.verdict(), r.value))
            .collect(),
    };
    let mut document = json!({
        "schema": "linewright/run/1",
        "line": line.name,
        "seed": trace.seed,
        "end": trace.end.word(),
        "simulated_seconds": round(trace.seconds, 6),
        "warm_up_seconds": round(trace.warm_up, 6),
        "makespan_seconds": round(trace.makespan, 6),
        "events": trace.events,
        "product": line.products.first().and_then(|part| part_name(*part)),
        "products": trace.products,
        "stored": trace.stored,
        "parts": {
            "before": trace.parts.before,
            "entered": trace.parts.entered,
            "finished": trace.parts.finished,
            "rejected": trace.parts.rejected,
            "consumed": trace.parts.consumed,
            "in_progress": trace.parts.in_progress,
        },
        "rejects": rejects,
        "first_pass_yield": trace.yields.first_pass_yield().map(|share| round(share, 6)),
        "scrap_ratio": trace.yields.scrap_ratio().map(|share| round(share, 6)),
        "throughput_per_hour": round(trace.throughput_per_hour, 6),
        "throughput_per_hour_on_shift": trace.throughput_on_shift.map(|rate| round(rate, 6)),
        "wip": {
            "mean": round(trace.wip.mean, 6),
            "max": trace.wip.max,
            "over_time": trace.wip_over_time.as_ref().map(over_time),
        },
        "lead_time": lead_time(trace.lead_time),
        "energy_kwh": kwh(trace.joules),
        "energy_per_product_kwh": (trace.products > 0)
            .then(|| round(trace.joules / JOULES_PER_KWH / trace.products as f64, 12)),
        "bottleneck": trace.bottleneck.station().map(|station| station.name.as_str()),
        "limited_by": limited_by(&trace.bottleneck),
        "sources": trace.sources.iter().map(source).collect::<Vec<_>>(),
        "stations": stations,
        "conveyors": conveyors,
        "buffers": buffers,
        "machines": machines,
        "violations": violations,
        "violation_count": trace.violation_count,
        "requirements": requirements,
    });
    if trace.warm_up_products > 0 {
        document["warm_up_products"] = trace.warm_up_products.into();
    }
    if let Value::Object(fields) = &mut document {
        if let Some(seconds) = wall_seconds {
            fields.insert("wall_seconds".to_owned(), round(seconds, 6).into());
        }
        if !trace.by_type.is_empty() {
            let products = trace.by_type.iter().map(|product| {
                json!({
                    "part": part_name(product.part),
                    "products": product.products,
                    "throughput_per_hour": round(product.throughput_per_hour, 6),
                    "lead_time": lead_time(product.lead_time),
                })
            });
            let products: Vec<Value> = products.collect();
            fields.insert("products_by_type".to_owned(), products.into());
        }
        match intervals {
            Some(Intervals::Replications(replications)) => {
                fields.insert("replications".to_owned(), replicated(line, replications));
            }
            Some(Intervals::Batches(batches)) => {
                fields.insert("batches".to_owned(), batch_means(line, batches));
            }
            None => {}
        }
    }
    document
}

/// A requirement that was judged by one value.
fn requirement(name: &str, verdict: Verdict, value: Option<f64>) -> Value {
    json!({
        "name": name,
        "holds": verdict == Verdict::Holds,
        "verdict": verdict.word(),
        "value": value.map(|value| round(value, 9)),
    })
}

/// A requirement that was judged over several runs. `seed` is that of the worst run.
fn replicated_requirement(r: &ReplicatedRequirement, seed: Option<u64>) -> Value {
    json!({
        "name": r.name,
        "holds": r.verdict == Verdict::Holds,
        "verdict": r.verdict.word(),
        "more_replications": r.more(),
        "value": r.value.map(|value| round(value.mean, 9)),
        "low": low(r.value, 9),
        "high": high(r.value, 9),
        "held_in": r.held_in,
        "replications": r.runs,
        "worst": {
            "seed": seed,
            "value": r.worst_value.map(|value| round(value, 9)),
        },
    })
}

/// A requirement that was judged over the batches of a run, or by the whole run.
fn batch_requirement(r: &ReplicatedRequirement, lag_1: Option<f64>) -> Value {
    if r.runs == 1 {
        return requirement(&r.name, r.verdict, r.worst_value);
    }
    json!({
        "name": r.name,
        "holds": r.verdict == Verdict::Holds,
        "verdict": r.verdict.word(),
        "times_as_long": r.times_as_long().map(|times| round(times, 6)),
        "value": r.value.map(|value| round(value.mean, 9)),
        "low": low(r.value, 9),
        "high": high(r.value, 9),
        "lag_1": lag_1.map(|lag_1| round(lag_1, 6)),
        "held_in": r.held_in,
        "batches": r.runs,
        "worst": {
            "batch": r.worst + 1,
            "value": r.worst_value.map(|value| round(value, 9)),
        },
    })
}

fn batch_means(line: &Line, batches: &Batches) -> Value {
    let mut document = json!({
        "count": batches.count,
        "seconds": batches.seconds.map(|seconds| round(seconds, 6)),
        "confidence": 0.95,
        "critical_lag_1": round(batches.critical_lag_1, 6),
        "measures": measures(line, &batches.measures),
    });
    for e in &batches.estimates {
        let (name, places) = match e.measure {
            Measure::Throughput => ("throughput_per_hour", 6),
            Measure::LeadTime => ("lead_time_seconds", 6),
            Measure::LeadTimePercentile => ("lead_time_p95_seconds", 6),
            Measure::Energy => ("energy_kwh", 9),
            _ => (e.measure.info().name, 6),
        };
        document[name] = estimate(e.value, places).map_or(Value::Null, |mut value| {
            value["lag_1"] = json!(e.lag_1.map(|lag_1| round(lag_1, 6)));
            value
        });
    }
    document
}

fn lead_time(times: LeadTime) -> Value {
    json!({
        "mean": round(times.mean, 6),
        "p50": round(times.p50, 6),
        "p95": round(times.p95, 6),
        "max": round(times.max, 6),
    })
}

/// The mean time of the work on a part; only a machine's is divided.
fn work_time(work: WorkTime, is_machine: bool) -> Value {
    let divided = |seconds: f64| is_machine.then(|| round(seconds, 6));
    json!({
        "seconds": round(work.seconds, 6),
        "action_seconds": divided(work.action_seconds()),
        "control_seconds": divided(work.control_seconds),
    })
}

/// The causes of the blocked or of the starved time of a station.
fn waits(station: &StationStatistics, kind: WaitKind) -> Value {
    let causes = station.waits.iter().filter(|wait| wait.kind == kind);
    causes
        .map(|wait| {
            let mut cause = json!({
                "place": wait.place,
                "share": round(wait.share, 6),
                "failed": round(wait.failed, 6),
                "off_shift": round(wait.off_shift, 6),
            });
            if kind == WaitKind::Blocked {
                cause["station"] = json!(wait.station);
            }
            cause
        })
        .collect()
}

fn oee(oee: &Oee) -> Value {
    json!({
        "index": round(oee.index(), 6),
        "availability": round(oee.availability, 6),
        "effectiveness": round(oee.effectiveness, 6),
        "quality": round(oee.quality, 6),
    })
}

fn limited_by(bottleneck: &Bottleneck) -> Value {
    let (kind, places): (&str, Vec<&str>) = match bottleneck {
        Bottleneck::Nothing => ("nothing", Vec::new()),
        Bottleneck::Station(station) => ("station", vec![&station.name]),
        Bottleneck::Source { names, .. } => ("source", names.iter().map(String::as_str).collect()),
        Bottleneck::Undecided(stations) => (
            "undecided",
            stations.iter().map(|s| s.name.as_str()).collect(),
        ),
        Bottleneck::Deadlock(deadlock) => (
            "deadlock",
            deadlock.places.iter().map(String::as_str).collect(),
        ),
    };
    let since = match bottleneck {
        Bottleneck::Deadlock(deadlock) => Some(round(deadlock.since, 6)),
        _ => None,
    };
    let mut document = json!({ "kind": kind, "places": places });
    if let Some(since) = since {
        document["since_seconds"] = json!(since);
    }
    document
}

fn source(source: &SourceStatistics) -> Value {
    json!({
        "name": source.name,
        "passed": source.passed,
        "blocked": round(source.blocked, 6),
        "lost": round(source.lost, 6),
    })
}

fn replicated(line: &Line, replications: &Replications) -> Value {
    json!({
        "count": replications.seeds.len(),
        "seeds": replications.seeds,
        "warm_up_seconds": {
            "least": round(replications.warm_up.0, 6),
            "greatest": round(replications.warm_up.1, 6),
        },
        "confidence": 0.95,
        "throughput_per_hour": estimate(replications.throughput_per_hour, 6),
        "makespan_seconds": estimate(replications.makespan, 6),
        "lead_time_seconds": estimate(replications.lead_time, 6),
        "lead_time_p95_seconds": estimate(replications.lead_time_p95, 6),
        "wip": estimate(replications.wip, 6),
        "energy_kwh": estimate(replications.energy_kwh, 9),
        "measures": measures(line, &replications.measures),
    })
}

/// The estimates of all measures, one row each. The names are those of the requirements.
fn measures(line: &Line, measures: &[Estimated]) -> Value {
    let node_name = |node: usize| line.nodes.get(node).map(|node| node.name.as_str());
    let rows = measures.iter().map(|of| {
        let unit = of.subject.measure().info().unit;
        let places = match unit {
            MeasureUnit::KilowattHours => 12,
            _ => 9,
        };
        let mut row = json!({
            "name": of.subject.measure().info().name,
            "part": null,
            "place": null,
            "cause": null,
            "state": null,
            "unit": match unit {
                MeasureUnit::PerHour => "per_hour",
                MeasureUnit::Seconds => "seconds",
                MeasureUnit::KilowattHours => "kwh",
                MeasureUnit::Number => "number",
                MeasureUnit::Share => "share",
            },
            "mean": of.value.map(|value| round(value.mean, places)),
            "low": low(of.value, places),
            "high": high(of.value, places),
            "lag_1": of.lag_1.map(|lag_1| round(lag_1, 6)),
        });
        if let Some(Estimate { missing: 1.., .. }) = of.value {
            row["missing"] = json!(of.value.map(|value| value.missing));
        }
        match &of.subject {
            Subject::Metric(metric) => {
                row["name"] = json!(metric.name());
                let part = metric.product.and_then(|part| line.parts.get(part));
                row["part"] = json!(part.map(|part| part.name.as_str()));
                if !metric.nodes.is_empty() {
                    row["place"] = json!(line.names_of(&metric.nodes));
                }
            }
            Subject::Wait(cause) => {
                row["place"] = json!(node_name(cause.node));
                row["cause"] = json!({ "place": cause.place, "station": cause.station });
            }
            Subject::Energy { node, state } => {
                row["place"] = json!(node_name(*node));
                row["state"] = json!(state.info().name);
            }
        }
        row
    });
    rows.collect()
}

fn energy_by_state(joules: &ByState) -> Value {
    let states = ByState::STATES.iter().zip(joules.figures());
    let states = states.map(|(state, joules)| (state.info().name.to_owned(), json!(kwh(joules))));
    Value::Object(states.collect())
}

fn over_time(of: &OverTime) -> Value {
    let means = of.means.iter().map(|mean| round(*mean, 6));
    json!({
        "bin_seconds": of.bin_seconds,
        "means": means.collect::<Vec<_>>(),
    })
}

/// Returns an estimate with its confidence interval; `None` if nothing was measured.
pub(super) fn estimate(estimate: Option<Estimate>, places: i32) -> Option<Value> {
    let Estimate { mean, missing, .. } = estimate?;
    let mut value = json!({
        "mean": round(mean, places),
        "low": low(estimate, places),
        "high": high(estimate, places),
    });
    if missing > 0 {
        value["missing"] = json!(missing);
    }
    Some(value)
}

/// Returns the lower end of a confidence interval; `None` if there is none.
fn low(estimate: Option<Estimate>, places: i32) -> Option<f64> {
    let (low, _) = estimate?.interval()?;
    Some(round(low, places))
}

/// Returns the upper end of a confidence interval; `None` if there is none.
fn high(estimate: Option<Estimate>, places: i32) -> Option<f64> {
    let (_, high) = estimate?.interval()?;
    Some(round(high, places))
}

fn kwh(joules: f64) -> f64 {
    round(joules / JOULES_PER_KWH, 9)
}

/// Rounds to `places` decimal places; never returns minus zero.
pub(super) fn round(value: f64, places: i32) -> f64 {
    let scale = 10_f64.powi(places);
    let rounded = (value * scale).round() / scale;
    if rounded.is_finite() {
        rounded + 0.0
    } else {
        value
    }
}

/// Rounds shares to six decimal places so that they sum to 1: the largest share absorbs the
/// rounding error.
fn rounded(shares: &ByState) -> ByState {
    let mut millionths = shares.figures().map(|share| (share * 1e6).round() as i64);
    let rest = 1_000_000 - millionths.iter().sum::<i64>();
    if let Some(greatest) = millionths.iter_mut().max() {
        *greatest += rest;
    }
    let [busy, starved, blocked, failed, idle, setup] = millionths.map(|m| m as f64 / 1e6);
    ByState {
        busy,
        starved,
        blocked,
        failed,
        idle,
        setup,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_shares_sum_to_one() {
        let third = 1.0 / 3.0;
        let shares = rounded(&ByState {
            busy: third,
            starved: third,
            blocked: third,
            ..ByState::default()
        });
        let millionths = |share: f64| (share * 1e6).round() as i64;
        assert_eq!(
            millionths(shares.busy) + millionths(shares.starved) + millionths(shares.blocked),
            1_000_000
        );
    }

    #[test]
    fn no_minus_zero() {
        assert!(round(-1e-12, 6).is_sign_positive());
    }
}
