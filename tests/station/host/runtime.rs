//! Mutants of the C shared by all libraries, `ffi/step.c` and `ffi/runtime.c`: the host detects
//! them.
//!
//! The text is changed in one place at a time by purely syntactic rules: an operator, a constant, a
//! condition, a statement. Each mutant becomes a library by `cc -O0`, and the host goes through the
//! plans of a few machines until one of them fails. A host that hangs or crashes has also detected
//! it. A surviving mutant is judged once more by the other tests of the host: with all generations
//! used up, under the address and undefined behavior sanitizers, and `runtime.c` under the thread
//! sanitizer. A sample runs with the other tests; all of them with
//!
//!     LINEWRIGHT_MUTANTS=all cargo test --test station every_mutant_of_the_runtime -- --nocapture
//!
//! With `step.c` or `runtime.c, lw_create` for `all`, only those of this file or function run; with
//! `known`, those that are known to survive. These are in `runtime_known.txt` with the reason: a
//! surviving mutant that is missing there fails the test, and so does a row whose mutant is
//! detected or no longer exists.

use super::corners;
use super::machines::{Subject, as_functions, fixtures, named};
use super::programs::{Host, PASSED, Prepared};
use super::sanitizers;
use crate::differential::Random;
use linewright::station::{Package, Toolchain};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Additional time for a mutant, beside twenty times that of the host on the unchanged library.
const PATIENCE: Duration = Duration::from_secs(5);

/// The same with all generations used up.
const LONG_PATIENCE: Duration = Duration::from_mins(4);

/// Number of mutants in the sample of the gate. `LINEWRIGHT_MUTANTS` overrides it.
const SAMPLE: usize = 6;

/// Number of calls with which the host uses up all generations, and one with which its threads meet
/// under a sanitizer, where every call takes long.
const MANY_CALLS: u64 = 300_000;
const THREADED_CALLS: u64 = 8_000;

/// The machine for slow tests.
const SMALL: &str = "Belt3";

/// The first generation: a random one, the two lowest, the highest.
const FIRST_GENERATIONS: [&str; 4] = [
    "chosen / LW_SLOTS % LW_GENERATIONS",
    "0",
    "1",
    "LW_GENERATIONS - 1",
];

/// Mutants that are known to survive, one per row.
const KNOWN: &str = include_str!("runtime_known.txt");

/// One change.
#[derive(Debug, Clone)]
struct Mutant {
    file: &'static str,
    /// Range of replaced bytes.
    at: Range<usize>,
    by: String,
}

/// The files that are changed.
fn files() -> [(&'static str, &'static str); 2] {
    [
        ("step.c", include_str!("../../../ffi/step.c")),
        ("runtime.c", include_str!("../../../ffi/runtime.c")),
    ]
}

/// The text with everything but code blanked: comments, strings, characters, directives.
fn code_of(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut code = bytes.to_vec();
    let mut i = 0;
    let mut line_begins = true;
    while i < bytes.len() {
        let from = i;
        match bytes[i] {
            b'/' if bytes[i..].starts_with(b"/*") => {
                i = text[i..].find("*/").map_or(bytes.len(), |n| i + n + 2);
            }
            b'#' if line_begins => {
                // Including the lines joined to it by a backslash.
                while i < bytes.len() && (bytes[i] != b'\n' || bytes[i - 1] == b'\\') {
                    i += 1;
                }
            }
            quote @ (b'"' | b'\'') => {
                i += 1;
                while bytes[i] != quote {
                    i += if bytes[i] == b'\\' { 2 } else { 1 };
                }
                i += 1;
            }
            byte => {
                line_begins = byte == b'\n' || line_begins && byte == b' ';
                i += 1;
                continue;
            }
        }
        for byte in &mut code[from..i] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    }
    code
}

const OPERATORS: [(&str, &str); 12] = [
    ("<=", "<"),
    (">=", ">"),
    ("==", "!="),
    ("!=", "=="),
    ("&&", "||"),
    ("||", "&&"),
    (" < ", " <= "),
    (" > ", " >= "),
    (" + ", " - "),
    (" - ", " + "),
    (" * ", " / "),
    (" % ", " / "),
];

/// Words that begin a declaration.
const TYPES: [&str; 18] = [
    "int",
    "int32_t",
    "int64_t",
    "uint32_t",
    "uint64_t",
    "const",
    "double",
    "static",
    "char",
    "size_t",
    "typedef",
    "lw_slot",
    "lw_error",
    "lw_state",
    "lw_handle",
    "lw_service",
    "lw_text",
    "LW_",
];

/// Every mutant of a file.
fn mutants(file: &'static str, text: &str) -> Vec<Mutant> {
    let code = code_of(text);
    let code = std::str::from_utf8(&code).expect("only whole texts were blanked");
    let mut found = Vec::new();
    let mut add = |at: Range<usize>, by: String| found.push(Mutant { file, at, by });
    let mut i = 0;
    while i < code.len() {
        let rest = &code[i..];
        let operator = OPERATORS.iter().find(|(from, _)| rest.starts_with(from));
        if let Some((from, to)) = operator {
            add(i..i + from.len(), (*to).to_owned());
            i += from.len() - usize::from(from.ends_with(' '));
            continue;
        }
        let before = code[..i].bytes().next_back().unwrap_or(b' ');
        let word_goes_on = before.is_ascii_alphanumeric() || before == b'_' || before == b'.';
        if rest.as_bytes()[0].is_ascii_digit() && !word_goes_on {
            let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
            let next = rest.as_bytes().get(digits);
            // Hexadecimal and real numbers, and the sizes of arrays, are not changed.
            let plain = next.is_none_or(|b| !b.is_ascii_alphanumeric() && *b != b'.');
            if let (true, Ok(value)) = (plain, rest[..digits].parse::<u32>())
                && !code[i + digits..].starts_with("];")
            {
                add(i..i + digits, (value + 1).to_string());
                if value > 0 {
                    add(i..i + digits, (value - 1).to_string());
                }
            }
            i += digits;
            continue;
        }
        for word in ["if (", "while ("] {
            if rest.starts_with(word) && !word_goes_on {
                let open = i + word.len();
                if let Some(close) = closing(code, open) {
                    add(open..close, format!("!({})", &text[open..close]));
                }
            }
        }
        i += 1;
        while !code.is_char_boundary(i) {
            i += 1;
        }
    }
    // A statement on its own line.
    let mut begin = 0;
    for line in code.split_inclusive('\n') {
        let statement = line.trim();
        let at = begin + line.len() - line.trim_start().len();
        begin += line.len();
        // `(void)x;` marks something as unused.
        let declares =
            statement.starts_with("(void)") || TYPES.iter().any(|ty| statement.starts_with(ty));
        let whole = statement.ends_with(';') && line.starts_with("    ") && !declares;
        let balanced = statement.matches('(').count() == statement.matches(')').count();
        let begun =
            statement.starts_with(|c: char| c.is_ascii_alphabetic() || c == '*' || c == '(');
        // A continuation of the previous line is not a separate statement.
        let goes_on = code[..at].trim_end().ends_with([';', '{', '}', ')', ':']);
        if whole && balanced && begun && goes_on {
            add(at..at + statement.len(), ";".to_owned());
        }
    }
    found
}

/// Position of the bracket that closes the one before `open`.
fn closing(code: &str, open: usize) -> Option<usize> {
    let mut depth = 1;
    for (i, c) in code[open..].char_indices() {
        depth += match c {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        if depth == 0 {
            return Some(open + i);
        }
    }
    None
}

impl Mutant {
    fn of(&self, text: &str) -> String {
        format!(
            "{}{}{}",
            &text[..self.at.start],
            self.by,
            &text[self.at.end..]
        )
    }

    /// Number of its line.
    fn line(&self, text: &str) -> usize {
        text[..self.at.start].matches('\n').count() + 1
    }

    /// The function, the line in it, and the change, as at the beginning of the rows of known
    /// mutants. Not necessarily unique.
    fn describe(&self, text: &str) -> String {
        let number = self.line(text);
        let line = text.lines().nth(number - 1).unwrap_or_default().trim();
        format!(
            "{}, {}: {line} | `{}` -> `{}`",
            self.file,
            function_at(text, number),
            &text[self.at.clone()],
            self.by
        )
    }
}

/// The function or declaration that contains a line: the name in the last unindented line.
fn function_at(text: &str, number: usize) -> &str {
    let lines: Vec<&str> = text.lines().take(number).collect();
    let heads = |line: &&&str| line.starts_with(|c: char| c.is_ascii_alphabetic());
    let head = lines.iter().rev().find(heads).unwrap_or(&"");
    let name = head.split(['(', '{', '=', '[', ';']).next();
    let name = name.unwrap_or_default().split_whitespace().next_back();
    name.unwrap_or_default().trim_start_matches('*')
}

/// A machine's C with the shared files inlined, one of which may be changed.
fn inlined(package: &Package, c_source: &str, mutant: Option<&Mutant>) -> String {
    let mut out = String::new();
    for line in c_source.lines() {
        let included = line
            .strip_prefix("#include \"")
            .and_then(|l| l.strip_suffix(".c\""));
        let Some(name) = included.map(|stem| format!("{stem}.c")) else {
            out.push_str(line);
            out.push('\n');
            continue;
        };
        let files = package.files();
        let (_, text) = files
            .iter()
            .find(|(n, _)| *n == name)
            .expect("a file of the package");
        let changed = mutant.filter(|m| m.file == name).map(|m| m.of(text));
        out.push_str(&inlined(
            package,
            changed.as_deref().unwrap_or(text),
            mutant,
        ));
    }
    out
}

/// Outcome of a mutant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// It is not valid C.
    Refused,
    /// The host detected it, on one of the machines.
    Killed,
    /// The host detected it with more calls or a sanitizer.
    KilledLater,
    Lives,
}

/// A host with a sanitizer, and machines for it.
struct Sanitized {
    host: Host,
    prepared: Vec<Prepared>,
    calls: u64,
}

impl Sanitized {
    fn new(host: Host, subjects: &[Subject], calls: u64) -> Self {
        let court = Self {
            host,
            prepared: subjects.iter().map(Prepared::new).collect(),
            calls,
        };
        assert!(!court.notices(None), "the text is right as it is");
        court
    }

    fn notices(&self, mutant: Option<&Mutant>) -> bool {
        // `runtime.c` does not use the functions.
        let one = mutant.is_some_and(|m| m.file == "runtime.c");
        let mut prepared = self.prepared.iter().take(if one { 1 } else { usize::MAX });
        prepared.any(|prepared| {
            let Some(library) = library(&self.host.toolchain, prepared, mutant) else {
                return true;
            };
            let start = sanitizers::start;
            let finished = (self.host).run_through(prepared, &library, self.calls, start);
            let _ = std::fs::remove_file(&library);
            !finished.success || finished.last_line() != PASSED
        })
    }
}

/// A machine by which mutants are judged.
struct Judge {
    prepared: Prepared,
    patience: Duration,
    /// The library of the unchanged text.
    original: Vec<u8>,
}

struct Court {
    toolchain: Toolchain,
    subjects: Vec<Judge>,
    address: OnceLock<Option<Sanitized>>,
    thread: OnceLock<Option<Sanitized>>,
}

fn library(toolchain: &Toolchain, prepared: &Prepared, mutant: Option<&Mutant>) -> Option<PathBuf> {
    let mut package = prepared.package.clone();
    package.c_source = inlined(&prepared.package, &prepared.package.c_source, mutant);
    package
        .hash
        .push_str(&mutant.map_or(String::new(), |m| format!("{m:?}")));
    let built = toolchain.build(&package, prepared.folder(), false);
    built.ok().map(|b| b.path)
}

/// Whether the host passes on a library.
fn passes(prepared: &Prepared, library: &Path, calls: u64, patience: Duration) -> bool {
    let finished = Host::native().run_within(prepared, library, calls, patience);
    finished.success && finished.last_line() == PASSED
}

impl Court {
    fn new() -> Self {
        let toolchain = Toolchain::host().with_flags(&[
            "-std=c99",
            "-shared",
            "-fPIC",
            "-O0",
            "-w",
            "-fvisibility=hidden",
            "-ffp-contract=off",
        ]);
        let mut subjects = vec![corners::edges(), as_functions(&corners::edges())];
        let plain = ["Jammed", SMALL];
        subjects.extend(fixtures().into_iter().filter(|s| plain.contains(&s.name())));
        subjects.extend([
            corners::blocked(),
            corners::hurried(3),
            corners::hurried(4),
            corners::hurried(5),
            corners::faulty(),
            corners::odd(),
            corners::lonely(),
        ]);
        // Functions of a large machine.
        subjects.push(as_functions(&named("QualityCheck")));
        // Actions that run more than once in an operation.
        subjects.push(named("AssemblyCell"));
        // It is built before the time is measured.
        let _ = Host::native();
        let measured = |subject: &Subject| {
            let begin = Instant::now();
            let prepared = Prepared::new(subject);
            println!(
                "{}: {:.2} s for the plan",
                subject.name(),
                begin.elapsed().as_secs_f64()
            );
            let library = library(&toolchain, &prepared, None).expect("the text is C");
            let begin = Instant::now();
            let right = passes(&prepared, &library, 0, super::programs::PATIENCE);
            assert!(right, "{}: the text is right as it is", subject.name());
            let patience = PATIENCE + 20 * begin.elapsed();
            println!("{}: {:.2} s", subject.name(), begin.elapsed().as_secs_f64());
            let original = std::fs::read(&library).expect("the library");
            Judge {
                prepared,
                patience,
                original,
            }
        };
        let (_, runtime) = files()[1];
        assert!(runtime.contains(FIRST_GENERATIONS[0]), "it is replaced");
        Self {
            subjects: subjects.iter().map(measured).collect(),
            toolchain,
            address: OnceLock::new(),
            thread: OnceLock::new(),
        }
    }

    fn judge(&self, mutant: &Mutant) -> Fate {
        let mut differs = false;
        for judge in &self.subjects {
            let Some(library) = library(&self.toolchain, &judge.prepared, Some(mutant)) else {
                return Fate::Refused;
            };
            // What does not compile here, or compiles to the same, need not be run.
            let same = std::fs::read(&library).is_ok_and(|bytes| bytes == judge.original);
            differs |= !same;
            let passed = same || passes(&judge.prepared, &library, 0, judge.patience);
            let _ = std::fs::remove_file(&library);
            if !passed {
                return Fate::Killed;
            }
        }
        if differs && self.notices_later(mutant) {
            Fate::KilledLater
        } else {
            Fate::Lives
        }
    }

    /// The slow tests.
    fn notices_later(&self, mutant: &Mutant) -> bool {
        if mutant.file == "runtime.c" {
            let threads = self.thread.get_or_init(|| {
                let host = sanitizers::host("host-mutants-tsan", "tsan", &[])?;
                let belt = fixtures().into_iter().filter(|s| s.name() == SMALL);
                Some(Sanitized::new(
                    host,
                    &belt.collect::<Vec<_>>(),
                    THREADED_CALLS,
                ))
            });
            if threads.as_ref().is_some_and(|t| t.notices(Some(mutant))) {
                return true;
            }
            // Twice: if all libraries begin at one generation, some get equal handles by chance.
            let lasts = |first| (0..2).any(|_| self.lasts(mutant, first));
            if !FIRST_GENERATIONS.into_iter().all(lasts) {
                return true;
            }
        }
        let addresses = self.address.get_or_init(|| {
            let undefined = ["-fsanitize=undefined"];
            let host = sanitizers::host("host-mutants-asan", "asan", &undefined)?;
            let subjects = [corners::edges(), corners::odd()];
            Some(Sanitized::new(host, &subjects, 0))
        });
        addresses.as_ref().is_some_and(|a| a.notices(Some(mutant)))
    }

    /// Whether a library whose generations begin there passes until all are used up.
    fn lasts(&self, mutant: &Mutant, first: &str) -> bool {
        let mut judges = self.subjects.iter();
        let small = judges.find(|judge| judge.prepared.subject.name() == SMALL);
        let prepared = &small.expect("the small machine").prepared;
        let mut package = prepared.package.clone();
        let source = inlined(&package, &package.c_source, Some(mutant));
        package.c_source = source.replace(FIRST_GENERATIONS[0], first);
        package.hash = format!("{}{first}{mutant:?}", package.hash);
        // As shipped, which is many times as fast.
        let toolchain = &Host::native().toolchain;
        let built = toolchain.build(&package, prepared.folder(), false);
        let library = built.expect("it was C").path;
        let passed = passes(prepared, &library, MANY_CALLS, LONG_PATIENCE);
        let _ = std::fs::remove_file(&library);
        passed
    }
}

/// The rows of known mutants: place and change, and the reason.
fn known() -> BTreeMap<&'static str, &'static str> {
    let mut known = BTreeMap::new();
    let rows = KNOWN
        .lines()
        .filter(|l| !l.is_empty() && !l.starts_with('#'));
    for row in rows {
        let (mutant, reason) = row.rsplit_once(" | ").expect("a reason");
        let judged = ["equivalent: ", "unnoticed: "];
        assert!(judged.iter().any(|j| reason.starts_with(j)), "{row}");
        assert_eq!(known.insert(mutant, reason), None, "twice: {row}");
    }
    known
}

/// Every mutant of the files with the text of its file and its unique description.
fn all_mutants() -> Vec<(Mutant, &'static str, String)> {
    let mut described: Vec<(Mutant, &str, String)> = Vec::new();
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for (file, text) in files() {
        let found = mutants(file, text);
        println!("{file}: {} mutants", found.len());
        for mutant in found {
            let what = mutant.describe(text);
            let time = times.entry(what.clone()).or_default();
            *time += 1;
            let what = match *time {
                1 => what,
                n => format!("{what} #{n}"),
            };
            described.push((mutant, text, what));
        }
    }
    described
}

#[test]
fn every_mutant_of_the_runtime_is_noticed() {
    let wish = std::env::var("LINEWRIGHT_MUTANTS").unwrap_or_default();
    let sample = match wish.as_str() {
        "" => Some(SAMPLE),
        number => number.parse().ok(),
    };
    let known = known();
    let mut chosen = all_mutants();
    let made: BTreeSet<&str> = chosen.iter().map(|(_, _, what)| what.as_str()).collect();
    let gone: Vec<&str> = known
        .keys()
        .copied()
        .filter(|k| !made.contains(k))
        .collect();
    assert!(gone.is_empty(), "no such mutants any more: {gone:#?}");
    if let Some(sample) = sample {
        // `runtime.c` is only for the long form.
        chosen.retain(|(m, _, what)| m.file == "step.c" && !known.contains_key(what.as_str()));
        let mut random = Random(24);
        while chosen.len() > sample {
            chosen.swap_remove(random.below(chosen.len() as u64) as usize);
        }
    } else if wish == "known" {
        chosen.retain(|(_, _, what)| known.contains_key(what.as_str()));
    } else if wish != "all" {
        chosen.retain(|(_, _, what)| what.starts_with(&wish));
    }
    let court = Court::new();
    let fates = judged(&court, &chosen, if sample.is_some() { 1 } else { 2 });
    let count = |fate: Fate| fates.iter().filter(|f| **f == fate).count();
    let mut alive = Vec::new();
    let mut stale = Vec::new();
    let (mut equivalent, mut unnoticed) = (0, 0);
    for ((_, _, what), fate) in chosen.iter().zip(&fates) {
        match (fate, known.get(what.as_str())) {
            (Fate::Lives, None) => alive.push(what),
            (Fate::Lives, Some(reason)) if reason.starts_with("equivalent") => equivalent += 1,
            (Fate::Lives, Some(_)) => unnoticed += 1,
            (_, Some(_)) => stale.push(what),
            (_, None) => {}
        }
    }
    println!(
        "{} made; {} killed, {} with more calls or a sanitizer, {} are no C; {equivalent} are equivalent, {unnoticed} unnoticed, {} live",
        chosen.len(),
        count(Fate::Killed),
        count(Fate::KilledLater),
        count(Fate::Refused),
        alive.len()
    );
    assert!(alive.is_empty(), "not in runtime_known.txt: {alive:#?}");
    assert!(
        stale.is_empty(),
        "noticed, but in runtime_known.txt: {stale:#?}"
    );
    assert!(sample.is_none() || count(Fate::Killed) > 0);
}

/// The outcome of each mutant.
fn judged(court: &Court, chosen: &[(Mutant, &str, String)], workers: usize) -> Vec<Fate> {
    let next = AtomicUsize::new(0);
    let fates = Mutex::new(vec![Fate::Refused; chosen.len()]);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some((mutant, text, what)) = chosen.get(number) else {
                break;
            };
            let fate = court.judge(mutant);
            let said = match fate {
                Fate::Lives => "lives",
                Fate::KilledLater => "killed later",
                Fate::Refused => "no C",
                Fate::Killed => "",
            };
            if !said.is_empty() {
                println!("{said}: {}: {what}", mutant.line(text));
            }
            fates.lock().unwrap_or_else(PoisonError::into_inner)[number] = fate;
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(work);
        }
    });
    fates.into_inner().unwrap_or_else(PoisonError::into_inner)
}
