//! From contracts to loaded libraries, for the laboratory's whole line: cost of a first and a
//! second run, and where the time goes.
//!
//! The first table is of the program as a user runs it, `run examples/ice-lab/line.lw --parts 50`,
//! with user and system time of the process and everything it starts (above all the C compiler). It
//! includes the 50 products, so it is an upper bound for getting from contracts to loaded
//! libraries. The times come from the shell's `times`: finished children, on every Unix, without an
//! unsafe call of `getrusage`. The other tables measure each stage inside this process, one after
//! the other on one core.

use criterion::{Criterion, criterion_group};
use linewright::contract::machine::Machine;
use linewright::engine::files::{self, LoadedFiles, StandardLibrary};
use linewright::engine::machines::of_line;
use linewright::game::{Limits, Outcome, WonGame, solve};
use linewright::gr1::Specification;
use linewright::mealy::{self, extract::extract, verify::verify};
use linewright::station::Package;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

const LINE: &str = "examples/ice-lab/line.lw";

/// Time of the paper's tool for its library of actions: the sum of its table's rows.
const PAPER_SECONDS: f64 = 7.1;

/// Number of runs whose median is shown.
const RUNS: usize = 5;

/// Seconds of one run.
struct Cost {
    user: f64,
    system: f64,
    clock: f64,
}

/// Runs the line with its libraries in `folder`.
fn run(folder: &Path) -> Cost {
    let command = r#""$@" > /dev/null || exit; times"#;
    let out = folder.display().to_string();
    let program = env!("CARGO_BIN_EXE_linewright");
    let arguments = ["-c", command, "sh", program, "run", LINE, "--parts", "50"];
    let begin = Instant::now();
    let output = Command::new("sh")
        .args(arguments)
        .args(["--out", &out])
        .env("LINEWRIGHT_CACHE", "off")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("sh starts");
    let clock = begin.elapsed().as_secs_f64();
    let text = String::from_utf8_lossy(&output.stdout);
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "the line runs: {words}");
    // The shell's own times, then those of its children.
    let children = text.lines().nth(1).expect("two lines");
    let mut seconds = children.split_whitespace().map(seconds);
    let mut next = || seconds.next().expect("user and system");
    Cost {
        user: next(),
        system: next(),
        clock,
    }
}

/// `1m2.345s` in seconds.
fn seconds(text: &str) -> f64 {
    let (minutes, rest) = text.split_once('m').expect("minutes");
    let number = |t: &str| t.parse::<f64>().expect("a number");
    number(minutes) * 60.0 + number(rest.trim_end_matches('s'))
}

fn libraries(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let ending = std::env::consts::DLL_EXTENSION;
    let own = entries.filter(|e| e.path().extension().is_some_and(|x| x == ending));
    own.count()
}

fn median(costs: &[Cost], of: impl Fn(&Cost) -> f64) -> f64 {
    let mut values: Vec<f64> = costs.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The first table.
fn whole_runs() {
    let (mut first, mut second) = (Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let folder = tempfile::tempdir().expect("a folder");
        first.push(run(folder.path()));
        assert_eq!(libraries(folder.path()), 5, "one library a machine");
        let built = std::fs::metadata(folder.path()).expect("it is there");
        let built = built.modified().expect("a time");
        second.push(run(folder.path()));
        let now = std::fs::metadata(folder.path()).expect("it is there");
        let now = now.modified().expect("a time");
        assert_eq!(built, now, "nothing was built in the second run");
    }
    println!(
        "From contracts to loaded libraries and 50 products, median of {RUNS} runs, in seconds:\n"
    );
    println!("                                   user  system    user + system   by the clock");
    let row = |name: &str, costs: &[Cost]| {
        let (user, system) = (median(costs, |c| c.user), median(costs, |c| c.system));
        let (all, clock) = (
            median(costs, |c| c.user + c.system),
            median(costs, |c| c.clock),
        );
        println!("{name:33} {user:5.2}   {system:5.2}            {all:5.2}          {clock:5.2}");
    };
    row("empty build folder", &first);
    row("second run, no compiler", &second);
    println!("the paper's tool (contracts only)                          {PAPER_SECONDS:.1}\n");
}

/// Results of the stages for the whole line.
struct Stages {
    loaded: LoadedFiles,
    machines: Vec<Arc<Machine>>,
    /// Every contract with its arguments, once.
    specifications: Vec<Arc<Specification>>,
    won: Vec<WonGame>,
    controllers: Vec<mealy::Machine>,
}

fn load() -> LoadedFiles {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(LINE);
    files::load(&[file.display().to_string()], &StandardLibrary::default())
}

fn win(specification: &Specification) -> WonGame {
    match solve(specification, &Limits::default()) {
        Outcome::Realizable(won) => won,
        _ => panic!("{} is realizable", specification.name),
    }
}

impl Stages {
    fn new() -> Self {
        let loaded = load();
        let machines: Vec<Arc<Machine>> = of_line(&loaded.library.lines[0])
            .into_iter()
            .map(Arc::clone)
            .collect();
        let mut specifications: Vec<Arc<Specification>> = Vec::new();
        for component in machines.iter().flat_map(|m| &m.components) {
            if !specifications.contains(&component.specification) {
                specifications.push(Arc::clone(&component.specification));
            }
        }
        let won: Vec<WonGame> = specifications.iter().map(|s| win(s)).collect();
        let controllers = specifications.iter().zip(&won);
        let controllers = controllers
            .map(|(s, w)| extract(s, w, &Limits::default()).expect("no limit"))
            .collect();
        Self {
            loaded,
            machines,
            specifications,
            won,
            controllers,
        }
    }

    /// The controllers of a machine's components.
    fn controllers(&self, machine: &Machine) -> Vec<mealy::Controller> {
        let index = |s: &Arc<Specification>| {
            let place = self.specifications.iter().position(|o| o == s);
            place.expect("every component's contract is among them")
        };
        let components = machine.components.iter();
        components
            .map(|c| self.controllers[index(&c.specification)].clone().into())
            .collect()
    }
}

fn by_stage(criterion: &mut Criterion) {
    let stages = Stages::new();
    let limits = Limits::default();
    println!(
        "{} files, {} machines, {} contracts",
        stages.loaded.library.sources.files().count(),
        stages.machines.len(),
        stages.specifications.len()
    );
    let mut group = criterion.benchmark_group("pipeline");
    group.bench_function("load", |b| b.iter(load));
    group.bench_function("solve", |b| {
        b.iter(|| {
            let won = stages.specifications.iter().map(|s| win(s));
            won.collect::<Vec<_>>()
        });
    });
    let pairs = || stages.specifications.iter().zip(&stages.won);
    group.bench_function("extract", |b| {
        b.iter(|| {
            let machines = pairs().map(|(s, w)| extract(s, w, &limits));
            machines.collect::<Vec<_>>()
        });
    });
    group.bench_function("verify", |b| {
        b.iter(|| {
            for (s, m) in stages.specifications.iter().zip(&stages.controllers) {
                assert_eq!(verify(s, m, &limits), Ok(Ok(())));
            }
        });
    });
    let controlled: Vec<_> = stages
        .machines
        .iter()
        .map(|m| (m, stages.controllers(m)))
        .collect();
    group.bench_function("emit", |b| {
        b.iter(|| {
            let packages = controlled.iter().map(|(m, c)| Package::emit(m, c));
            packages.collect::<Vec<_>>()
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = by_stage
}

fn main() {
    // `cargo test --benches` only checks that it runs.
    if !std::env::args().any(|a| a == "--test" || a == "--list") {
        whole_runs();
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}
