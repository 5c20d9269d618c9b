//! Runs of a line, and failures in them that a proof excludes.

use crate::models::{Logged, RunLogged};
use linewright::contract::line::{Line, NodeKind, Supply};
use linewright::contract::machine::Machine;
use linewright::contract::{Library, load};
use linewright::engine::machines::{MachinePlan, of_line};
use linewright::engine::pipeline::{Jobs, Settings};
use linewright::game::{Heuristics, KernelChoice, Limits};
use linewright::line::{End, Options, Plant, Trace};
use linewright::mealy;
use linewright::station::Controller;
use linewright::station::interpret::Interpreter;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Number of products ordered.
pub const PARTS: u64 = 5;
/// Seconds in which each line here can make them several times over.
pub const SECONDS: f64 = 5_000.0;
/// Factors by which a run that has not made them is extended before it counts as a failure, if at
/// most this many events have happened in it: times may be a million times a property, but a line
/// in which much happens and nothing is made has failed.
const LONGER: [(f64, u64); 2] = [(10.0, u64::MAX), (20_000.0, 20_000)];

/// Number of products that long runs have made.
pub static MADE_IN_LONG_RUNS: AtomicU64 = AtomicU64::new(0);

/// Number of products of the long run of each line; `None` if there are no long runs.
fn parts_of_long_runs() -> Option<u64> {
    let given = std::env::var("LINEWRIGHT_ATTACK_PARTS").ok();
    given.map(|text| text.parse().expect("a number of products"))
}

/// Something that must not happen in a proved line.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Failure {
    /// `violation`, `blocked`, `lost`, `missing` or `never`.
    pub kind: &'static str,
    /// What a premise would have to name: the station, the rule, the type.
    pub names: BTreeSet<String>,
    pub said: String,
}

/// The lines of a file, with controllers for their machines.
pub struct World {
    pub library: Library,
    controllers: Vec<(Arc<Machine>, Arc<Vec<mealy::Controller>>)>,
}

/// Reads imports of the bundled library and of files beside.
fn read_import(wanted: &str, from: &str) -> Result<(String, String), String> {
    let root = crate::support::root();
    let path = match wanted.strip_prefix("std.") {
        Some(inner) => root.join("contracts").join(inner.replace('.', "/") + ".lw"),
        None => Path::new(from).parent().unwrap_or(root).join(wanted),
    };
    let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
    Ok((path.to_string_lossy().into_owned(), text))
}

impl World {
    /// Synthesizes the controllers of all machines in the file's lines, each once.
    pub fn new(name: &str, text: &str) -> Self {
        let (library, _) = load(&[(name.to_owned(), text.to_owned())], &read_import);
        let mut jobs = Jobs::default();
        let mut machines: Vec<&Arc<Machine>> = Vec::new();
        for machine in library.lines.iter().flat_map(of_line) {
            if !machines.iter().any(|m| Arc::ptr_eq(m, machine)) {
                machines.push(machine);
            }
        }
        let planned: Vec<MachinePlan<'_>> = machines
            .iter()
            .map(|m| MachinePlan::new(m, &mut jobs))
            .collect();
        let settings = Settings {
            limits: Limits::default(),
            kernel: KernelChoice::Automatic,
            heuristics: Heuristics::default(),
            cache: None,
            announcer: None,
        };
        let checked = jobs.run(&settings, &indicatif::ProgressBar::hidden());
        let mut controllers = Vec::new();
        for (machine, plan) in machines.iter().zip(&planned) {
            if let Some(controlled) = plan.controlled(&checked) {
                let own = controlled.controllers.into_iter().cloned().collect();
                controllers.push((Arc::clone(machine), Arc::new(own)));
            }
        }
        Self {
            library,
            controllers,
        }
    }

    pub fn line(&self, name: &str) -> Option<&Line> {
        self.library.lines.iter().find(|l| l.name == name)
    }

    /// A plant for the line; `None` if a machine has no controller, or the runner refuses the line.
    pub fn plant(&self, line: &Line, options: Options) -> Option<Plant> {
        let mut controllers: BTreeMap<usize, Box<dyn Controller>> = BTreeMap::new();
        for (at, node) in line.nodes.iter().enumerate() {
            let Some(machine) = node.machine() else {
                continue;
            };
            let own = self
                .controllers
                .iter()
                .find(|(m, _)| Arc::ptr_eq(m, machine))?;
            let interpreter = Interpreter::new(Arc::clone(machine), Arc::clone(&own.1));
            controllers.insert(at, Box::new(interpreter));
        }
        Plant::new(Arc::new(line.clone()), controllers, options).ok()
    }

    /// The failures with the first of these seeds that has any. `None` if the line cannot be run.
    pub fn failures(&self, line: &Line, seeds: &[u64]) -> Option<BTreeSet<Failure>> {
        let mut failures = BTreeSet::new();
        let mut seconds = SECONDS;
        for &seed in seeds {
            let mut trace = self.run(line, seed, Some(PARTS), SECONDS)?;
            let mut found = failures_of(line, &trace);
            for (times, most_events) in LONGER {
                let is_late = found.iter().any(|f| f.kind == "missing");
                if !is_late || trace.events > most_events {
                    break;
                }
                failures.extend(found.into_iter().filter(|f| f.kind != "missing"));
                trace = self.run(line, seed, Some(PARTS), SECONDS * times)?;
                seconds = f64::max(seconds, SECONDS * times);
                found = failures_of(line, &trace);
            }
            failures.extend(found);
            if !failures.is_empty() {
                return Some(failures);
            }
        }
        if let Some(parts) = parts_of_long_runs() {
            let trace = self.run_long(line, seeds[0], parts)?;
            MADE_IN_LONG_RUNS.fetch_add(trace.products, Ordering::Relaxed);
            failures.extend(failures_of(line, &trace));
        }
        // With a time limit only, every type has to come through.
        let trace = self.run(line, seeds[0], None, seconds)?;
        failures.extend(failures_of(line, &trace));
        failures.extend(never_through(line, &trace));
        Some(failures)
    }

    /// One run to this many products, within a billion seconds and two minutes of the wall clock.
    fn run_long(&self, line: &Line, seed: u64, parts: u64) -> Option<Trace> {
        let options = Options {
            seed,
            parts: Some(parts),
            until: Some(1e9),
            deadline: linewright::deadline::Deadline::from_now(Duration::from_mins(2)),
            ..Options::default()
        };
        Some(self.plant(line, options)?.run())
    }

    /// One run. For a line with a shift only the working time counts.
    pub fn run(&self, line: &Line, seed: u64, parts: Option<u64>, seconds: f64) -> Option<Logged> {
        let off = line.calendar.as_ref().map_or(0.0, |calendar| {
            const WEEK: f64 = 7.0 * 86_400.0;
            WEEK * (1.0 + (seconds / calendar.worked_until(WEEK)).ceil())
        });
        let options = Options {
            seed,
            parts,
            until: Some(seconds + off),
            deadline: linewright::deadline::Deadline::from_now(Duration::from_secs(20)),
            ..Options::default()
        };
        let mut plant = self.plant(line, options)?;
        if parts.is_none() {
            return Some(plant.run_logged());
        }
        let trace = plant.run();
        Some(Logged {
            trace,
            log: Vec::new(),
        })
    }
}

fn names<'a>(words: impl IntoIterator<Item = &'a str>) -> BTreeSet<String> {
    words.into_iter().map(str::to_owned).collect()
}

fn failures_of(line: &Line, trace: &Trace) -> Vec<Failure> {
    let mut failures = Vec::new();
    for violation in &trace.violations {
        let mut about = names([line.nodes[violation.node].name.as_str()]);
        about.extend(
            violation
                .part
                .map(|(_, kind)| line.parts[kind].name.clone()),
        );
        about.extend(violation.rule.clone());
        let said = general(&format!("{:?}: {}", violation.code, violation.message));
        failures.push(Failure {
            kind: "violation",
            names: about,
            said,
        });
    }
    let said = || {
        let texts: Vec<_> = trace.findings.iter().map(|f| f.message.as_str()).collect();
        general(texts.last().unwrap_or(&""))
    };
    let product = || names([line.parts[line.products[0]].name.as_str()]);
    // A refused part is not made either, and may be missing elsewhere: that counts as one failure.
    let refused = !trace.violations.is_empty();
    match trace.end {
        End::PartLost => failures.push(Failure {
            kind: "lost",
            names: product(),
            said: said(),
        }),
        _ if refused => {}
        End::Blocked if in_a_circle(trace) || !is_bounded(line, trace) => failures.push(Failure {
            kind: "blocked",
            names: product(),
            said: said(),
        }),
        End::Time if trace.products < PARTS && !is_bounded(line, trace) => failures.push(Failure {
            kind: "missing",
            names: product(),
            said: format!("fewer than {PARTS} products"),
        }),
        _ => {}
    }
    failures
}

fn in_a_circle(trace: &Trace) -> bool {
    let mut helps = trace.findings.iter().flat_map(|f| &f.help);
    helps.any(|h| h.contains("circle"))
}

/// Whether the line need not make as many products as are ordered: supplies end, or scrap is not
/// ordered again.
fn is_bounded(line: &Line, trace: &Trace) -> bool {
    let ends = |kind: &NodeKind| match kind {
        NodeKind::Source { supply, .. } => matches!(
            supply,
            Supply::Every { limit: Some(_), .. } | Supply::At { .. }
        ),
        NodeKind::Store { stock } => !stock.is_empty(),
        _ => false,
    };
    let scrap = trace.rejects.iter().any(|r| r.reordered < r.count);
    line.nodes.iter().any(|n| ends(&n.kind)) || scrap
}

/// Types with an endless source, of which none came through.
fn never_through(line: &Line, trace: &Logged) -> Vec<Failure> {
    use linewright::line::log::EventKind;
    if trace.end != End::Time || !trace.violations.is_empty() {
        return Vec::new();
    }
    let through: BTreeSet<usize> = trace
        .log
        .iter()
        .filter(|e| {
            matches!(
                e.what,
                EventKind::Finished | EventKind::Rejected | EventKind::Consumed
            )
        })
        .filter_map(|e| Some(e.part?.1))
        .collect();
    let mut failures = Vec::new();
    for node in &line.nodes {
        let NodeKind::Source { part, supply, .. } = &node.kind else {
            continue;
        };
        // Orders are for the product; types that are not in it may have none.
        let is_in = |product: &usize| {
            let mut bill = line.parts[*product].bill.iter();
            part == product || bill.any(|(component, _)| component == part)
        };
        let ordered = line.products.iter().any(is_in);
        let endless = match supply {
            Supply::OnOrder => ordered,
            Supply::Every { limit, .. } => limit.is_none(),
            Supply::At { .. } => false,
        };
        if endless && !through.contains(part) && !is_bounded(line, trace) {
            let name = &line.parts[*part].name;
            failures.push(Failure {
                kind: "never",
                names: names([name.as_str()]),
                said: format!("no {name} comes through"),
            });
        }
    }
    failures
}

/// A text without its numbers, so that the same failure in another run is recognized.
fn general(text: &str) -> String {
    let mut general = String::new();
    for c in text.chars() {
        if !c.is_ascii_digit() {
            general.push(c);
        } else if !general.ends_with('N') {
            general.push('N');
        }
    }
    general
}
