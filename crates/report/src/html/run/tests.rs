//! The figures that a page shows are those of the run.

use super::data::tests::Columns;
use super::*;
use linewright_core::source::SourceMap;
use linewright_language::contract::load;
use linewright_line::log::{EventKind, Log, Observer, Observers};
use linewright_line::{Options, Plant};
use std::sync::Arc;

const BOTTLING: &str = include_str!("../../../../../examples/bottling/line.lw");

const CONVEYORS: &str = "line Conveyors {
    part A
    part B from 2 A
    source feed: A every exponential(4 s)
    conveyor belt places 6 pitch 0.5 m speed 0.25 m/s power 200 W
    station join { takes uniform(3 s, 9 s) power 1 kW idle power 50 W
        failures mtbf 2 min mttr 30 s scrap }
    buffer rack capacity 3 shelf life 20 s
    station test { takes exponential(8 s) }
    sink out
    route A: feed -> belt -> join
    route B: join -> rack -> test -> out
    shift 0 h to 1 h break 0.5 h to 0.6 h
}";

/// A run with its recorder and its log.
struct Recorded {
    line: Arc<Line>,
    sources: SourceMap,
    trace: Trace,
    recorder: Recorder,
    log: Log,
}

fn recorded(text: &str, options: Options) -> Recorded {
    let files = [("line.lw".to_owned(), text.to_owned())];
    let (mut library, findings) = load(&files, &|_, _| Err("there is no other file".to_owned()));
    assert!(findings.is_empty(), "{findings:?}");
    let line = Arc::new(library.lines.remove(0));
    let mut plant = Plant::new(Arc::clone(&line), BTreeMap::new(), options).unwrap();
    let (mut recorder, mut log) = (Recorder::new(&line), Log::default());
    let seed = plant.seed();
    let mut observers = Observers(vec![&mut recorder as &mut dyn Observer, &mut log]);
    let trace = plant.run_observed(seed, Some(&mut observers));
    Recorded {
        line,
        sources: library.sources,
        trace,
        recorder,
        log,
    }
}

fn runs() -> Vec<Recorded> {
    let hours = |until: f64, warm_up: f64| Options {
        until: Some(until * 3600.0),
        warm_up: warm_up * 3600.0,
        ..Options::default()
    };
    vec![
        recorded(BOTTLING, hours(24.0, 0.0)),
        recorded(BOTTLING, hours(12.0, 7.0)),
        recorded(CONVEYORS, hours(1.5, 0.0)),
        recorded(CONVEYORS, hours(0.9, 0.2)),
    ]
}

impl Recorded {
    fn page(&self) -> Page<'_> {
        static NO_NUMBERS: BTreeMap<&str, &str> = BTreeMap::new();
        Page {
            line: &self.line,
            traces: std::slice::from_ref(&self.trace),
            intervals: None,
            recorder: &self.recorder,
            comparisons: &[],
            set: &NO_NUMBERS,
            origin: Origin {
                command: "linewright run line.lw",
                version: "0",
                sources: &self.sources,
                findings: &self.trace.findings,
            },
        }
    }

    fn written(&self) -> String {
        page(&self.page())
    }
}

fn assert_near(a: f64, b: f64, what: &str) {
    assert!(
        (a - b).abs() <= 1e-6 * b.abs().max(1.0),
        "{what}: {a} and {b}"
    );
}

/// Mean of a curve over the time from `start` to its end. `start` may lie within a bin, of which
/// only the mean is known, so this is not exact unless `start` is 0.
fn mean(curve: &series::Curve, start: f64) -> f64 {
    let area: f64 = curve
        .means
        .iter()
        .enumerate()
        .map(|(bin, mean)| {
            let from = (bin as f64 * curve.width).max(start);
            let to = ((bin + 1) as f64 * curve.width).min(curve.end);
            mean * (to - from).max(0.0)
        })
        .sum();
    area / (curve.end - start)
}

#[test]
fn the_figures_are_those_of_the_run() {
    for run in runs() {
        let (trace, recorder) = (&run.trace, &run.recorder);
        assert_near(recorder.end, trace.seconds, "end");
        assert_near(recorder.counting, trace.warm_up, "warm-up");
        let columns = recorder.lead_times.columns();
        let counted = columns.counts.iter().sum::<u64>() + columns.beyond;
        assert_eq!(counted, trace.products);
        let joules: f64 = recorder.joules.iter().flatten().sum();
        assert_near(joules, trace.joules, "joules");
        for station in &trace.stations {
            let left = recorder
                .flow
                .iter()
                .filter(|((from, _), _)| *from == station.node);
            let left: u64 = left.flat_map(|(_, counts)| counts).sum();
            assert!(left.abs_diff(station.processed) <= 1, "{}", station.name);
        }
        if trace.warm_up <= 0.0 {
            assert_near(mean(&recorder.units(), 0.0), trace.wip.mean, "WIP");
            let types = 0..run.line.parts.len();
            let by_type = types.map(|kind| mean(&recorder.units_of(kind), 0.0));
            assert_near(by_type.sum(), trace.wip.mean, "WIP by part type");
            let (rates, width) = recorder.throughput();
            let products = rates.iter().enumerate().map(|(bin, rate)| {
                let (start, stop) = charts::span(bin, rates.len(), width, recorder.end);
                rate * (stop - start) / 3600.0
            });
            assert_near(
                products.sum(),
                trace.products as f64,
                "throughput over time",
            );
            for buffer in &trace.buffers {
                let curve = recorder.buffer(buffer.node).unwrap();
                assert_near(mean(&curve, 0.0), buffer.length, &buffer.name);
                assert_eq!(curve.maxima.iter().max(), Some(&(buffer.longest as i64)));
            }
            let (watts, width) = recorder.power();
            let all: f64 = watts
                .iter()
                .enumerate()
                .map(|(bin, watts)| watts * (recorder.end - bin as f64 * width).min(width))
                .sum();
            assert_near(all, trace.joules, "power over time");
        }
    }
}

fn for_hours(hours: f64) -> Options {
    Options {
        until: Some(hours * 3600.0),
        ..Options::default()
    }
}

fn assert_contains(text: &str, all: &[&str]) {
    for wanted in all {
        assert!(text.contains(wanted), "{wanted}");
    }
}

/// The filler is starved for an eighth of its time on shift, so it is the supply that limits the
/// line. Products and rejects have their names, durations their units, and times their weekdays.
#[test]
fn the_conclusion_is_in_words() {
    let text = recorded(BOTTLING, for_hours(24.0)).written();
    assert_contains(
        &text,
        &[
            "1 d simulated",
            "In this one run, the line made 294 products (189 WaterPallet, 105 JuicePallet), 12.2 an hour (17.3 on shift); half of them were in it for at most 6 min 28 s. The supply from water and juice limits the line first: filler waits for parts for 11.9 % of its time on shift. All requirements hold. No station or conveyor has a contract that could be violated. One run has no confidence interval: add <code class=\"option\">--replications 10</code> to get one.",
            "189 WaterPallet, 105 JuicePallet; 21 Water, 14 Juice rejected",
            "availability 69.6 % (busy share of its time on shift)",
            "Availability is that of ISO 22400-2: actual production time divided by planned busy time",
            "filler off shift: 29.2 %",
            ">Mon</text>",
            ">12:00</text>",
            "<td class=\"verdict good\">holds</td>",
            "rejected parts &lt;= 1,000",
            "Each column is 2 min wide.",
            "Products an hour, in bins of 30 min.",
            "the mean of each 5 min</li>",
            "up to the maximum in this time</li>",
            "on an arrow: a part that has just moved",
        ],
    );
    assert!(!text.contains("idle</"));
}

/// With replications, every figure of the conclusion and of the tiles is of all runs.
#[test]
fn the_conclusion_of_replications_is_of_all_runs() {
    let run = recorded(BOTTLING, for_hours(24.0));
    let mut plant = Plant::new(Arc::clone(&run.line), BTreeMap::new(), for_hours(24.0)).unwrap();
    let (traces, replications) = plant.replicate(3);
    let page_of_runs = Page {
        traces: &traces,
        intervals: Some(Intervals::Replications(&replications)),
        ..run.page()
    };
    let text = page(&page_of_runs);
    let mean = |value: fn(&Trace) -> f64| traces.iter().map(value).sum::<f64>() / 3.0;
    let median = linewright_line::trace::duration_in_units(mean(|trace| trace.lead_time.p50));
    let products: Vec<f64> = traces.iter().map(|trace| trace.products as f64).collect();
    let products = linewright_line::Estimate::of(&products).unwrap();
    let products = crate::html::numbers::rounded(products.mean, products.half_width.unwrap());
    assert_contains(
        &text,
        &[
            "In 3 runs, the line made ",
            &format!("products an hour; the mean of the runs' median lead times is {median}."),
            "In all of them, the supply from water and juice, for which filler waits, limits the line.",
            &format!("<dd>{products}</dd>"),
            "mean of 3 runs, ± ",
            "no station or conveyor has a contract, in 3 runs",
            ">Replications</a>",
        ],
    );
    assert!(!text.contains("One run has no"));
}

/// Parts that a station refused have a column of their own, and do not end its waiting.
#[test]
fn refused_parts_are_told_apart() {
    let mut run = recorded(BOTTLING, for_hours(8.0));
    assert!(!run.written().contains(">Refused</th>"));
    let station = &run.trace.stations[0];
    assert!(station.waits.iter().any(|wait| wait.share >= 0.005));
    let name = station.name.clone();
    run.recorder.refused[station.node] = 3;
    assert_contains(
        &run.written(),
        &[
            ">Refused</th>",
            &format!("A station that refuses a part goes on waiting: {name} refused 3 parts."),
            ", apart from those that it refused</td>",
            "none: given by its times</td>",
            "A station without a machine is given by its times in the model",
        ],
    );
}

/// The line as it is and two variants, in one chart and one table.
#[test]
fn variants_are_side_by_side() {
    let replicated = |filling: &str| {
        let text = BOTTLING.replace("triangular(2 s, 2.2 s, 3 s)", filling);
        let run = recorded(&text, for_hours(8.0));
        let mut plant = Plant::new(Arc::clone(&run.line), BTreeMap::new(), for_hours(8.0)).unwrap();
        (plant.replicate(3), run)
    };
    let ((traces, replications), run) = replicated("triangular(2 s, 2.2 s, 3 s)");
    let others = ["constant(2 s)", "constant(4 s)"].map(|filling| replicated(filling).0.0);
    let differences = others
        .each_ref()
        .map(|other| linewright_line::comparison::compare(&traces, other));
    let variants = ["fast", "slow"].map(|name| Variant {
        name: name.to_owned(),
        speeds: [("filler".to_owned(), 1.25)].into(),
        ..Variant::default()
    });
    let compared: Vec<Compared<'_>> = (0..2)
        .map(|number| Compared {
            variant: &variants[number],
            traces: &others[number],
            comparisons: &differences[number],
        })
        .collect();
    let text = page(&Page {
        traces: &traces,
        intervals: Some(Intervals::Replications(&replications)),
        comparisons: &compared,
        ..run.page()
    });
    let of_measure = |line: &str| {
        format!("<th scope=\"row\">throughput per hour</th><td>{line}</td><td class=\"number\">")
    };
    assert_contains(
        &text,
        &[
            "<strong>fast</strong>: what if filler works 25 % faster?",
            ">throughput per hour, fast</text>",
            ">throughput per hour, slow</text>",
            &of_measure("as it is"),
            &of_measure("fast"),
            &of_measure("slow"),
            "Where the time goes, slow",
            "</ul><h3>Where the time goes, fast",
            "<th scope=\"row\">mean lead time</th>",
        ],
    );
    // A mean has as many decimal places as its difference from the line as it is.
    let (_, row) = text.split_once(&of_measure("fast")).unwrap();
    let words = row.split(|c: char| !c.is_ascii_digit() && c != '.');
    let decimals = words.filter_map(|word| Some(word.split_once('.')?.1.len()));
    let decimals: Vec<usize> = decimals.take(4).collect();
    assert!(
        decimals[0] >= 1 && decimals.iter().all(|of| *of == decimals[0]),
        "{decimals:?}"
    );
}

#[test]
fn a_line_of_one_product_names_it() {
    let text = "line L { part P source s: P every 5 s station a { takes 1 s } station b { takes 1 s } sink out
        route P: s -> a, b route P: a -> out route P: b -> out limit 3000 products }";
    let text = recorded(text, Options::default()).written();
    assert_contains(
        &text,
        &[
            "the line made 3,000 P, ",
            "<dd>3,000</dd>",
            "of type P; none rejected",
            "The supply from s limits the line: no part had to wait there.",
            "b not used: 100.0 %",
        ],
    );
    // Without a calendar, time is that since the start.
    assert!(text.contains(">1 h</text>") && !text.contains(">Mon</text>"));
}

/// A product that is finished at the very end of the run is in the last bin of the throughput.
#[test]
fn the_last_product_is_in_the_throughput() {
    let text = "line L { part P source s: P every 5 s station a { takes 5 s } sink out
        route P: s -> a -> out limit 301 products }";
    let run = recorded(text, Options::default());
    assert_near(
        run.trace.makespan,
        run.recorder.end,
        "time of the last product",
    );
    let (rates, width) = run.recorder.throughput();
    let end = run.recorder.end;
    let spans = (0..rates.len()).map(|bin| charts::span(bin, rates.len(), width, end));
    let products = spans.zip(&rates);
    let products = products.map(|((start, stop), rate)| rate * (stop - start) / 3600.0);
    assert_near(products.sum(), 301.0, "products");
    // 1505 s in bins of 60 s: the last 5 s belong to the bin before them.
    assert_eq!((rates.len(), width), (25, 60.0));
    assert_contains(
        &run.written(),
        &["in bins of 1 min. The last one is 1 min 5 s long."],
    );
}

/// A line whose parts leave it, but are no products, has no bottleneck, in all places.
#[test]
fn a_line_without_products_says_what_left_it() {
    let text = "line L { part P part Q product P source s: Q every 5 s source t: P every 2 h
        station a { takes 1 s } station b { takes 2 h } sink out
        route Q: s -> a -> out route P: t -> b -> out }";
    let run = recorded(text, for_hours(1.0));
    let finished = run.recorder.balance(1).finished;
    let text = run.written();
    assert_contains(
        &text,
        &[&format!(
            "The line made no product in this one run; other parts that left it: {finished} Q."
        )],
    );
    assert_eq!(text.matches("none: no product was made").count(), 2);
}

/// Parts that came to a sink for rejects and parts that were taken out elsewhere add up to the
/// rejected parts of the tiles and the requirements.
#[test]
fn rejected_parts_are_the_same_everywhere() {
    let run = recorded(BOTTLING, for_hours(24.0));
    let rejected: u64 = run.trace.rejects.iter().map(|reject| reject.count).sum();
    let types = 0..run.line.parts.len();
    let balances = types.map(|kind| run.recorder.balance(kind));
    let [to_sink, elsewhere] = balances.fold([0, 0], |[to_sink, elsewhere], balance| {
        [to_sink + balance.rejected, elsewhere + balance.scrapped]
    });
    assert_eq!(to_sink + elsewhere, rejected);
    assert_contains(
        &run.written(),
        &[
            ">Rejected</th>",
            &format!(
                "<td class=\"number\">{rejected}</td><td class=\"number\">{to_sink}</td><td class=\"number\">{elsewhere}</td>"
            ),
        ],
    );
}

/// What entered the line is what left it or is still there, for each type; flow into a sink for
/// rejects and parts taken out elsewhere are apart.
#[test]
fn the_flow_sums_up_to_what_was_created() {
    for run in runs() {
        let types = 0..run.line.parts.len();
        let balances: Vec<_> = types.map(|kind| run.recorder.balance(kind)).collect();
        let sum = |of: fn(&recorder::Balance) -> u64| balances.iter().map(of).sum::<u64>();
        for balance in &balances {
            assert_eq!(
                balance.before + balance.entered,
                balance.finished
                    + balance.rejected
                    + balance.scrapped
                    + balance.joined
                    + balance.remaining
            );
        }
        let parts = run.trace.parts;
        assert_eq!(sum(|of| of.before), parts.before);
        assert_eq!(sum(|of| of.entered), parts.entered);
        assert_eq!(sum(|of| of.finished), parts.finished);
        assert_eq!(sum(|of| of.rejected + of.scrapped), parts.rejected);
        assert_eq!(sum(|of| of.joined), parts.consumed);
        assert_eq!(sum(|of| of.remaining), parts.in_progress);
        let taken_out: u64 = run.recorder.scrapped.values().flatten().sum();
        assert_eq!(taken_out, sum(|of| of.scrapped));
    }
    let text = recorded(BOTTLING, for_hours(24.0)).written();
    assert_contains(
        &text,
        &[
            ">camera to scrap</text>",
            ">taken out at labeller</text>",
            "<title>camera to scrap: ",
            "<td>taken out: scrapped, expired or refused</td>",
            "<h3>First-pass yield</h3>",
            "parts that were only bought and joined do not count",
            "A joined part is a new part: what a station does to it is no rework",
        ],
    );
}

#[test]
fn the_columns_for_the_script_are_those_of_the_log() {
    for run in runs() {
        let picture = Picture::new(&run.line);
        let columns = Columns::read(&data::json(&run.page(), &picture));
        let tick = packed::tick(run.recorder.end);
        let mut moves = columns.moves.iter();
        for entry in &run.log.entries {
            let is_move = matches!(
                entry.what,
                EventKind::Entered
                    | EventKind::Left
                    | EventKind::Consumed
                    | EventKind::Finished
                    | EventKind::Rejected
                    | EventKind::Place(_)
            );
            if is_move {
                let (time, part) = moves.next().unwrap();
                assert!((time - entry.time).abs() <= tick);
                assert_eq!(Some(*part), entry.part.map(|(number, _)| number));
            }
        }
        assert!(moves.next().is_none());
        // The violations, as times of refusals.
        for (node, times) in run.recorder.refusals.iter().enumerate() {
            let of_log = run.log.violations.iter().filter(|v| v.node == node);
            let mut of_log: Vec<f64> = of_log.map(|violation| violation.time).collect();
            of_log.dedup();
            assert_eq!(*times, of_log);
        }
        // The time in each state, up to the rounding of each change.
        for station in &run.trace.stations {
            let states = columns.states[station.node].as_ref().unwrap();
            let seconds = |name: &str| {
                let ends = states.iter().skip(1).map(|(time, _)| *time);
                let ends = ends.chain([run.recorder.end]);
                let of = states
                    .iter()
                    .zip(ends)
                    .filter(|((_, state), _)| state == name);
                let counted = of.map(|((start, _), end)| end - start.max(run.recorder.counting));
                counted.map(|seconds| seconds.max(0.0)).sum::<f64>()
            };
            let all = run.trace.seconds - run.trace.warm_up;
            for (name, share) in [
                ("busy", station.shares.busy),
                ("setup", station.shares.setup),
                ("blocked", station.shares.blocked),
                ("failed", station.shares.failed),
            ] {
                let allowed = tick * states.len() as f64 + 1e-6;
                let difference = (seconds(name) - share * all).abs();
                assert!(
                    difference <= allowed,
                    "{} {name}: {difference}",
                    station.name
                );
            }
        }
    }
}

/// A week has more changes of state than the timeline has room for. After them, it shows their
/// shares, so that each row goes to the end.
#[test]
fn the_timeline_of_a_long_run_goes_to_its_end() {
    let run = recorded(BOTTLING, for_hours(7.0 * 24.0));
    let end = run.recorder.states_end.expect("more changes than room");
    assert!(end < run.recorder.end / 2.0);
    for station in &run.trace.stations {
        let (bins, width) = run.recorder.later_states(station.node).unwrap();
        let seconds: f64 = bins.iter().flatten().sum();
        assert_near(seconds, run.recorder.end - end, &station.name);
        let first = (end / width) as usize;
        assert!(
            bins[..first]
                .iter()
                .flatten()
                .all(|seconds| *seconds == 0.0)
        );
        assert!(
            bins[first..]
                .iter()
                .all(|bin| bin.iter().sum::<f64>() > 0.0)
        );
    }
    let text = run.written();
    assert!(text.len() < 2_000_000, "{} bytes", text.len());
    assert_contains(
        &text,
        &["too many changes: the rows show the shares of the states in each 30 min."],
    );
}

#[test]
fn a_page_asks_no_network_and_is_small() {
    for run in runs() {
        let text = run.written();
        assert_eq!(text, run.written());
        assert!(text.len() < 2_000_000, "{} bytes", text.len());
        for word in ["src=", "@import", "url(http", "fetch(", "XMLHttpRequest"] {
            assert!(!text.contains(word), "{word}");
        }
        let hosts =
            text.matches("http").count() - text.matches("http://www.w3.org/2000/svg").count();
        assert_eq!(hosts, 0);
    }
}

#[test]
fn text_of_the_model_cannot_end_the_script() {
    let text = "/// </script><b> & \"quotes\"\nline X {\n part P\n source s: P every 1 s\n sink out\n route P: s -> out\n}";
    let run = recorded(
        text,
        Options {
            until: Some(10.0),
            ..Options::default()
        },
    );
    let text = run.written();
    assert_eq!(text.matches("</script>").count(), 2);
    assert!(text.contains("&lt;/script&gt;&lt;b&gt; &amp; "));
}
