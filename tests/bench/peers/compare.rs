//! Selection of files and tools, and their order.

use crate::instances;
use crate::measure::{self, End, Run};
use crate::table;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

const USAGE: &str = "\
cargo bench --bench peers -- [FILTER...] [OPTION...]

FILTER is a part of a file's path; without one, a selection of a few minutes is taken.

  --runs N         runs of each tool on each file, whose median is shown [3]
  --timeout S      seconds by the clock after which our own run is ended [120]; another tool is
                   given ten times our time, at least a minute
  --each           a row for each file of a large folder too, not only their sum
  --options TEXT   further options for our own `check`, with blanks between them

LINEWRIGHT_GR1C, LINEWRIGHT_SLUGS, LINEWRIGHT_SPECTRA: the programs; LINEWRIGHT_SPECTRA_OPTIONS: options of the last one,
where `|` separates alternatives, the fastest of which counts; LINEWRIGHT_SPECS: the folder of specifications
[../shared/bench/specs]; LINEWRIGHT_PROGRAM: our own program, where it is not to be the one just built";

/// Default selection without a filter. A name that ends in a slash is a whole folder.
const SELECTION: [&str; 11] = [
    "anzu/genbuf5.",
    "anzu/genbuf10.",
    "anzu/genbuf20.",
    "anzu/genbuf40.",
    "anzu/amba2.",
    "anzu/amba3.",
    "anzu/amba4.",
    "synt15/synt15_4.",
    "synt15/synt15_8.",
    "syntech15/",
    "spectra-language/",
];

/// Extensions of specifications.
const ENDINGS: [&str; 5] = ["slugsin", "spc", "spectra", "structuredslugs", "tlsf"];

/// Minimum number of seconds by the clock that another tool is given.
const LEAST_LIMIT: f64 = 60.0;

/// Number of files in a folder above which only their sum is shown.
const LARGE: usize = 10;

/// Another tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Peer {
    Gr1c,
    Slugs,
    Spectra,
}

impl Peer {
    const ALL: [Self; 3] = [Self::Gr1c, Self::Slugs, Self::Spectra];

    const fn name(self) -> &'static str {
        match self {
            Self::Gr1c => "gr1c",
            Self::Slugs => "slugs",
            Self::Spectra => "Spectra",
        }
    }

    /// Environment variable with its path.
    const fn variable(self) -> &'static str {
        match self {
            Self::Gr1c => "LINEWRIGHT_GR1C",
            Self::Slugs => "LINEWRIGHT_SLUGS",
            Self::Spectra => "LINEWRIGHT_SPECTRA",
        }
    }

    /// Extension of its specifications.
    const fn ending(self) -> &'static str {
        match self {
            Self::Gr1c => "spc",
            Self::Slugs => "slugsin",
            Self::Spectra => "spectra",
        }
    }

    /// Options that make it decide realizability only, with alternatives. slugs does so by default.
    fn options(self) -> Vec<Vec<OsString>> {
        let text = match self {
            Self::Gr1c => "-r".to_owned(),
            Self::Slugs => String::new(),
            Self::Spectra => std::env::var("LINEWRIGHT_SPECTRA_OPTIONS").unwrap_or_default(),
        };
        let alternatives = text.split('|');
        alternatives
            .map(|one| one.split_whitespace().map(OsString::from).collect())
            .collect()
    }

    /// From gr1c's exit code, and from the output of the others.
    fn verdict(self, run: &Run) -> Verdict {
        match (self, run.end) {
            (_, End::TimedOut) => Verdict::TimedOut,
            (Self::Gr1c, End::Exit(0)) => Verdict::Realizable,
            (Self::Gr1c, End::Exit(3)) => Verdict::Unrealizable,
            (Self::Slugs, End::Exit(0)) if run.words.contains("is realizable") => {
                Verdict::Realizable
            }
            (Self::Slugs, End::Exit(0)) if run.words.contains("is unrealizable") => {
                Verdict::Unrealizable
            }
            (Self::Spectra, End::Exit(_)) if run.text.contains("unrealizable") => {
                Verdict::Unrealizable
            }
            (Self::Spectra, End::Exit(_)) if run.text.contains("realizable") => Verdict::Realizable,
            (_, End::Exit(_)) => Verdict::Refused,
            (_, End::Killed) => Verdict::Killed,
        }
    }
}

/// A tool's verdict on a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Realizable,
    Unrealizable,
    Refused,
    GaveUp,
    TimedOut,
    Killed,
}

impl Verdict {
    pub const fn word(self) -> &'static str {
        match self {
            Self::Realizable => "realizable",
            Self::Unrealizable => "unrealizable",
            Self::Refused => "refused",
            Self::GaveUp => "gave up",
            Self::TimedOut => "out of time",
            Self::Killed => "killed",
        }
    }

    pub const fn is_decided(self) -> bool {
        matches!(self, Self::Realizable | Self::Unrealizable)
    }
}

/// Linewright's verdict, from the document printed by `check --format json`.
fn own_verdict(run: &Run) -> Verdict {
    match run.end {
        End::TimedOut => return Verdict::TimedOut,
        End::Killed => return Verdict::Killed,
        End::Exit(_) => {}
    }
    let document: serde_json::Value = serde_json::from_str(&run.text).unwrap_or_default();
    let count = |what: &str| document["summary"][what].as_u64().unwrap_or(0);
    // Every supported format has one contract per file.
    if count("unrealizable") > 0 {
        Verdict::Unrealizable
    } else if count("gave_up") > 0 {
        Verdict::GaveUp
    } else if count("realizable") > 0 {
        Verdict::Realizable
    } else {
        Verdict::Refused
    }
}

/// Cost of one tool on one file, over all runs.
#[derive(Debug, Clone, Copy)]
pub struct Figures {
    pub verdict: Verdict,
    /// The median.
    pub seconds: f64,
    /// The largest.
    pub mebibytes: f64,
}

fn figures(runs: &[(Verdict, Run)]) -> Figures {
    let mut seconds: Vec<f64> = runs.iter().map(|(_, r)| r.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let memory = runs.iter().map(|(_, r)| r.mebibytes);
    // A run without a verdict ended the series: it is the last one.
    let verdict = runs[runs.len() - 1].0;
    Figures {
        verdict,
        seconds: seconds[seconds.len() / 2],
        mebibytes: memory.fold(0.0, f64::max),
    }
}

/// One file, or the sum of several.
#[derive(Debug, Clone)]
pub struct Row {
    pub name: String,
    /// Of `check --verdict-only`, which does what the other tool does.
    pub ours: Figures,
    /// Of `check`, with its examinations and explanations.
    pub whole: Figures,
    pub theirs: Option<Figures>,
}

struct Options {
    filters: Vec<String>,
    runs: usize,
    limit: Duration,
    each: bool,
    check: Vec<OsString>,
}

fn options(arguments: &[OsString]) -> Result<Options, String> {
    let mut options = Options {
        filters: Vec::new(),
        runs: 3,
        limit: Duration::from_mins(2),
        each: false,
        check: Vec::new(),
    };
    let mut arguments = arguments.iter().map(|a| a.to_string_lossy());
    while let Some(argument) = arguments.next() {
        let mut value = || {
            let value = arguments.next();
            value.ok_or_else(|| format!("{argument} needs a value"))
        };
        match &*argument {
            // Passed by Cargo itself.
            "--bench" => {}
            "--each" => options.each = true,
            "--runs" => {
                let runs = value()?.parse().ok().filter(|n| *n > 0);
                options.runs = runs.ok_or("--runs needs a number from 1")?;
            }
            "--timeout" => {
                let seconds = value()?.parse().ok();
                let seconds = seconds.filter(|s| (0.001..1e6).contains(s));
                options.limit =
                    Duration::from_secs_f64(seconds.ok_or("--timeout needs a number of seconds")?);
            }
            "--options" => {
                let text = value()?;
                options.check = text.split_whitespace().map(OsString::from).collect();
            }
            other if other.starts_with('-') => return Err(format!("{other} is no option")),
            filter => options.filters.push(filter.to_owned()),
        }
    }
    Ok(options)
}

/// A specification to be measured.
struct Subject {
    /// Path relative to the folder of specifications.
    name: String,
    /// Extension, without the dot.
    ending: String,
    file: PathBuf,
}

/// The specifications below a folder.
fn specifications(root: &Path) -> Vec<Subject> {
    fn visit(root: &Path, folder: &Path, found: &mut Vec<Subject>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                visit(root, &path, found);
                continue;
            }
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            if ENDINGS.contains(&&*ending) {
                let name = path.strip_prefix(root).unwrap_or(&path);
                let parts: Vec<_> = name.iter().map(|p| p.to_string_lossy()).collect();
                found.push(Subject {
                    name: parts.join("/"),
                    ending: ending.into_owned(),
                    file: path.clone(),
                });
            }
        }
    }
    let mut found = Vec::new();
    visit(root, root, &mut found);
    found
}

/// The generated specifications that the filters select, written to `folder`.
fn generated(folder: &Path, filters: &[String]) -> Result<Vec<Subject>, String> {
    let mut found = Vec::new();
    for (name, ending, text) in instances::all() {
        let name = format!("generated/{name}.{ending}");
        if !filters.iter().any(|f| name.contains(f.as_str())) {
            continue;
        }
        let file = folder.join(name.rsplit('/').next().unwrap_or(&name));
        std::fs::write(&file, text()).map_err(|e| format!("{}: {e}", file.display()))?;
        found.push(Subject {
            name,
            ending: ending.to_owned(),
            file,
        });
    }
    Ok(found)
}

/// The specifications that no peer reads, converted by `synth --emit` to what each of them reads.
/// Those that cannot be converted are left out: they have a row of our own alone.
fn converted(folder: &Path, subjects: &[Subject]) -> Result<Vec<Subject>, String> {
    let mut found = Vec::new();
    for subject in subjects {
        if Peer::ALL.iter().any(|p| p.ending() == subject.ending) {
            continue;
        }
        for ending in Peer::ALL.map(Peer::ending) {
            let output = std::process::Command::new(program())
                .args(["synth", "--emit", ending])
                .arg(&subject.file)
                .output()
                .map_err(|e| format!("{}: {e}", subject.name))?;
            if output.stdout.is_empty() {
                continue;
            }
            let name = format!("{}.{ending}", subject.name);
            let file = folder.join(name.replace('/', "-"));
            std::fs::write(&file, output.stdout).map_err(|e| format!("{}: {e}", file.display()))?;
            found.push(Subject {
                name,
                ending: ending.to_owned(),
                file,
            });
        }
    }
    Ok(found)
}

/// Our own program.
fn program() -> OsString {
    let built = || env!("CARGO_BIN_EXE_linewright").into();
    std::env::var_os("LINEWRIGHT_PROGRAM").unwrap_or_else(built)
}

/// Whether the filters select it.
fn selected(name: &str, filters: &[String]) -> bool {
    if filters.is_empty() {
        SELECTION.iter().any(|s| name.starts_with(s))
    } else {
        filters.iter().any(|f| name.contains(f.as_str()))
    }
}

pub fn main(arguments: &[OsString]) -> ExitCode {
    // `cargo test --benches` only checks that it runs. `cargo bench` always passes `--bench`.
    if !arguments.iter().any(|a| a == "--bench") {
        println!("peers: nothing is measured but by `cargo bench`");
        return ExitCode::SUCCESS;
    }
    if arguments.iter().any(|a| a == "--help" || a == "-h") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    match options(arguments).and_then(|options| compare(&options)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("{why}\n\n{USAGE}");
            ExitCode::from(2)
        }
    }
}

/// Measures and prints; returns whether all verdicts agree.
fn compare(options: &Options) -> Result<bool, String> {
    let root = match std::env::var_os("LINEWRIGHT_SPECS") {
        Some(root) => PathBuf::from(root),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bench/specs"),
    };
    let mut subjects = specifications(&root);
    if subjects.is_empty() {
        println!(
            "only generated specifications: LINEWRIGHT_SPECS names a folder of published ones"
        );
    }
    subjects.retain(|s| selected(&s.name, &options.filters));
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    subjects.extend(generated(folder.path(), &options.filters)?);
    subjects.extend(converted(folder.path(), &subjects)?);
    // `genbuf5` before `genbuf10`.
    subjects.sort_by_cached_key(|s| table::natural(&s.name));
    let mut peers: BTreeMap<Peer, PathBuf> = BTreeMap::new();
    for peer in Peer::ALL {
        let Some(path) = std::env::var_os(peer.variable()) else {
            let (name, variable) = (peer.name(), peer.variable());
            println!(
                "{name} is not at hand ({variable} names the program): our own figures stand alone"
            );
            continue;
        };
        let path = PathBuf::from(path);
        if !path.is_file() {
            return Err(format!(
                "{}: {} is no file",
                peer.variable(),
                path.display()
            ));
        }
        peers.insert(peer, path);
    }

    let mut agree = true;
    let mut slower = Vec::new();
    for ending in ENDINGS {
        let peer = peers.iter().find(|(p, _)| p.ending() == ending);
        let peer = peer.map(|(p, path)| (*p, path.as_path()));
        let mut rows: Vec<Row> = Vec::new();
        for subject in subjects.iter().filter(|s| s.ending == ending) {
            let row = measured(subject, peer, options)?;
            eprintln!("{}", table::line(&row));
            if let Some(theirs) = row.theirs {
                let decided = row.ours.verdict.is_decided() && theirs.verdict.is_decided();
                if decided && row.ours.verdict != theirs.verdict {
                    agree = false;
                    println!("{}: VERDICTS DIFFER", row.name);
                }
                if is_slower(&row.ours, &theirs) {
                    slower.push(table::line(&row));
                }
            }
            rows.push(row);
        }
        if !rows.is_empty() {
            let name = peer.map(|(p, _)| p.name());
            println!();
            table::print(&summed(rows, options.each, ending), name, options.limit);
        }
    }
    println!(
        "\nfiles on which another tool is faster by more than 20 % and 0.05 s, or takes more than a second but less than twice our time: {}",
        slower.len()
    );
    for line in slower {
        println!("    {line}");
    }
    Ok(agree)
}

/// Whether another tool decides a file faster by more than 20 % and 0.05 s, or takes more than a
/// second but less than twice our time.
fn is_slower(ours: &Figures, theirs: &Figures) -> bool {
    let difference = ours.seconds - theirs.seconds;
    let is_faster = difference > 0.05 && difference > 0.2 * theirs.seconds;
    let is_near = theirs.seconds > 1.0 && ours.seconds > theirs.seconds / 2.0;
    theirs.verdict.is_decided() && (!ours.verdict.is_decided() || is_faster || is_near)
}

/// Runs all tools on one file in turns. A tool without a verdict is not run again.
fn measured(
    subject: &Subject,
    peer: Option<(Peer, &Path)>,
    options: &Options,
) -> Result<Row, String> {
    let mut ours: Vec<OsString> = vec![program()];
    ours.extend(["check", "--no-cache", "--format", "json"].map(OsString::from));
    ours.extend(options.check.iter().cloned());
    ours.push(subject.file.clone().into());
    let mut quick = ours.clone();
    quick.push("--verdict-only".into());
    let alternatives = peer.map_or_else(Vec::new, |(p, _)| p.options());
    let mut own = Vec::<(Verdict, Run)>::new();
    let mut whole = Vec::<(Verdict, Run)>::new();
    let mut others: Vec<Vec<(Verdict, Run)>> = vec![Vec::new(); alternatives.len()];
    let again = |runs: &[(Verdict, Run)]| runs.last().is_none_or(|(v, _)| v.is_decided());
    for _ in 0..options.runs {
        for (words, runs) in [(&quick, &mut own), (&ours, &mut whole)] {
            if again(runs) {
                let run = measure::run(words, options.limit)?;
                runs.push((own_verdict(&run), run));
            }
        }
        let limit = 10.0 * figures(&own).seconds;
        let limit = Duration::from_secs_f64(limit.max(LEAST_LIMIT));
        for (words, other) in alternatives.iter().zip(&mut others) {
            if let Some((peer, program)) = peer
                && again(other)
            {
                let mut theirs = vec![program.as_os_str().to_owned()];
                theirs.extend(words.iter().cloned());
                theirs.push(subject.file.clone().into());
                let run = measure::run(&theirs, limit)?;
                other.push((peer.verdict(&run), run));
            }
        }
    }
    let others = others.iter().map(|runs| figures(runs));
    let key = |f: &Figures| (!f.verdict.is_decided(), f.seconds);
    Ok(Row {
        name: subject.name.clone(),
        ours: figures(&own),
        whole: figures(&whole),
        theirs: others.min_by(|a, b| {
            let ((a, x), (b, y)) = (key(a), key(b));
            a.cmp(&b).then(x.total_cmp(&y))
        }),
    })
}

/// Replaces the rows of large folders by their sum, or appends the sum.
fn summed(rows: Vec<Row>, each: bool, ending: &str) -> Vec<Row> {
    let folder = |row: &Row| {
        let folder = row.name.rsplit_once('/');
        folder.map_or(String::new(), |(folder, _)| folder.to_owned())
    };
    let mut folders: Vec<(String, Vec<Row>)> = Vec::new();
    for row in rows {
        match folders.last_mut() {
            Some((name, rows)) if *name == folder(&row) => rows.push(row),
            _ => folders.push((folder(&row), vec![row])),
        }
    }
    let mut result = Vec::new();
    for (folder, rows) in folders {
        if rows.len() <= LARGE {
            result.extend(rows);
            continue;
        }
        let theirs: Option<Vec<Figures>> = rows.iter().map(|r| r.theirs).collect();
        let of = |one: fn(&Row) -> Figures| added(&rows.iter().map(one).collect::<Vec<_>>());
        let sum = Row {
            name: format!("{folder}: all {} .{ending}", rows.len()),
            ours: of(|r| r.ours),
            whole: of(|r| r.whole),
            theirs: theirs.map(|t| added(&t)),
        };
        if each {
            result.extend(rows);
        }
        result.push(sum);
    }
    result
}

/// Sums times, and takes the maximum memory; decided if all are.
fn added(figures: &[Figures]) -> Figures {
    let odd = figures.iter().find(|f| !f.verdict.is_decided());
    let unrealizable = figures
        .iter()
        .find(|f| f.verdict == Verdict::Unrealizable)
        .map_or(Verdict::Realizable, |f| f.verdict);
    Figures {
        verdict: odd.map_or(unrealizable, |f| f.verdict),
        seconds: figures.iter().map(|f| f.seconds).sum(),
        mebibytes: figures.iter().map(|f| f.mebibytes).fold(0.0, f64::max),
    }
}
