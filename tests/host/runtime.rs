//! Mutants of the C that every library shares, `ffi/step.c` and `ffi/runtime.c`: the host notices them.
//!
//! The text is changed in one place at a time by rules that know nothing of what it does: an operator, a constant, a condition, a
//! statement. Each mutant becomes a library by `cc -O0`, and the host goes through the plans of a few machines until one of them
//! fails. A host that hangs or crashes has noticed as well. A sample runs with the other tests; all of them with
//!
//!     LINEWRIGHT_MUTANTS=all cargo test --test host every_mutant_of_the_runtime -- --nocapture
//!
//! Those that live have to stand in [`EQUIVALENT`] with the reason.

use crate::differential::Random;
use crate::machines::{Subject, as_functions, fixtures, named};
use crate::programs::{Host, PASSED, Prepared};
use linewright::station::{Package, Toolchain};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Longer than the host needs, many times over.
const PATIENCE: Duration = Duration::from_mins(1);

/// Mutants in the sample of the gate. `LINEWRIGHT_MUTANTS` may name another number.
const SAMPLE: usize = 6;

/// Mutants that no call can show: what the line has, what becomes of it, and why.
const EQUIVALENT: [(&str, &str, &str); 9] = [
    (
        "if (error->pieces < LW_PIECES) {",
        "` < ` -> ` <= `",
        "no error has as many pieces",
    ),
    (
        "while (length > 0 && ((unsigned char)name[length]",
        "`0` -> `1`",
        "a name that begins with half a character is no text",
    ),
    (
        "while (length > 0 && ((unsigned char)name[length]",
        "` > ` -> ` >= `",
        "likewise",
    ),
    (
        "uint64_t rest = value < 0 ?",
        "` < ` -> ` <= `",
        "the negative of 0 is 0",
    ),
    ("out->text[0] = '\\0';", "", "a text is read by its length"),
    (
        "after->started = 1;",
        "`1` -> `2`",
        "it is only asked whether it is 0",
    ),
    (
        "job->running[index] = 1;",
        "`1` -> `2`",
        "it is only asked whether it is 0",
    ),
    (
        "while (out->length > 0 && (",
        "` > ` -> ` >= `",
        "no more is taken back than was written",
    ),
    (
        "int at = (int)sizeof digits - 1;",
        "",
        "more or less room than needed; too little is for the address sanitizer",
    ),
];

/// Mutants that live and are not equivalent: what the line has, what becomes of it, and what would notice it. Each is a plan that is missing.
const UNNOTICED: [(&str, &str, &str); 2] = [
    (
        "&& (after[i] < lw_property_ranges[i].low ||",
        "` < ` -> ` <= `",
        "an operation that writes the lowest value of a range",
    ),
    (
        "shifted[2 * i + 1] = 0;",
        "` * ` -> ` / `",
        "functions with several goals, whose shifted outputs are computed anew",
    ),
];

/// One change.
#[derive(Debug, Clone)]
struct Mutant {
    file: &'static str,
    /// Bytes that are replaced.
    at: Range<usize>,
    by: String,
}

/// The files that are changed.
fn files() -> [(&'static str, &'static str); 2] {
    [
        ("step.c", include_str!("../../ffi/step.c")),
        ("runtime.c", include_str!("../../ffi/runtime.c")),
    ]
}

/// The text with everything that is no code as blanks: comments, texts, characters, directives.
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
                // With the lines that a backslash joins to it.
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
            // Hexadecimal and real numbers, and the sizes of arrays, stay as they are.
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
    // A statement on a line of its own.
    let mut begin = 0;
    for line in code.split_inclusive('\n') {
        let statement = line.trim();
        let at = begin + line.len() - line.trim_start().len();
        begin += line.len();
        // `(void)x;` says that something is not used.
        let declares =
            statement.starts_with("(void)") || TYPES.iter().any(|ty| statement.starts_with(ty));
        let whole = statement.ends_with(';') && line.starts_with("    ") && !declares;
        let balanced = statement.matches('(').count() == statement.matches(')').count();
        let begun =
            statement.starts_with(|c: char| c.is_ascii_alphabetic() || c == '*' || c == '(');
        // What goes on from the line before is no statement of its own.
        let goes_on = code[..at].trim_end().ends_with([';', '{', '}', ')', ':']);
        if whole && balanced && begun && goes_on {
            add(at..at + statement.len(), ";".to_owned());
        }
    }
    found
}

/// Where the bracket that was opened before `open` is closed.
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

    /// The line, its number, and the change.
    fn describe(&self, text: &str) -> (usize, String, String) {
        let number = text[..self.at.start].matches('\n').count() + 1;
        let line = text.lines().nth(number - 1).unwrap_or_default().trim();
        let change = format!("`{}` -> `{}`", &text[self.at.clone()], self.by);
        (number, line.to_owned(), change)
    }
}

/// A machine's C with the shared files in it, of which one may be changed.
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

/// What a mutant came to.
enum Fate {
    /// It is no C.
    Refused,
    /// The host noticed, on one of the machines.
    Killed,
    Lives,
}

struct Court {
    toolchain: Toolchain,
    subjects: Vec<Prepared>,
}

impl Court {
    fn new() -> Self {
        // One of them is the manipulator with one more property.
        let mut subjects: Vec<Subject> = fixtures();
        subjects.retain(|s| s.name() != "Manipulator");
        // Functions over numbers that begin below 0, and over those of a large machine.
        subjects.push(as_functions(&subjects[1]));
        subjects.push(as_functions(&named("QualityCheck")));
        // Actions that run more than once in an operation.
        subjects.push(named("AssemblyCell"));
        Self {
            toolchain: Toolchain::host().with_flags(&[
                "-std=c99",
                "-shared",
                "-fPIC",
                "-O0",
                "-w",
                "-fvisibility=hidden",
                "-ffp-contract=off",
            ]),
            subjects: subjects.iter().map(Prepared::new).collect(),
        }
    }

    fn library(&self, prepared: &Prepared, mutant: Option<&Mutant>) -> Option<PathBuf> {
        let mut package = prepared.package.clone();
        package.c_source = inlined(&prepared.package, &prepared.package.c_source, mutant);
        package
            .hash
            .push_str(&mutant.map_or(String::new(), |m| format!("{m:?}")));
        let built = self.toolchain.build(&package, prepared.folder(), false);
        built.ok().map(|b| b.path)
    }

    fn judge(&self, mutant: &Mutant) -> Fate {
        for (number, prepared) in self.subjects.iter().enumerate() {
            let Some(library) = self.library(prepared, Some(mutant)) else {
                // What only one of the machines has may be no C in that one.
                if number + 1 == self.subjects.len() {
                    return Fate::Refused;
                }
                continue;
            };
            let passed = passes(prepared, &library);
            let _ = std::fs::remove_file(&library);
            if !passed {
                return Fate::Killed;
            }
        }
        Fate::Lives
    }
}

/// Whether the host has nothing to say against a library.
fn passes(prepared: &Prepared, library: &Path) -> bool {
    let finished = Host::native().run_within(prepared, library, 0, PATIENCE);
    finished.success && finished.last_line() == PASSED
}

fn is_among(list: &[(&str, &str, &str)], line: &str, change: &str) -> bool {
    let known =
        |&(text, part, _): &(&str, &str, &str)| line.contains(text) && change.contains(part);
    list.iter().any(known)
}

#[test]
fn every_mutant_of_the_runtime_is_noticed() {
    let wish = std::env::var("LINEWRIGHT_MUTANTS").unwrap_or_default();
    let all = wish == "all";
    let sample = wish.parse().unwrap_or(SAMPLE);
    let court = Court::new();
    for prepared in &court.subjects {
        let library = court
            .library(prepared, None)
            .expect("the text is right as it is");
        assert!(passes(prepared, &library), "{}", prepared.subject.name());
    }
    let mut chosen: Vec<(Mutant, &str)> = Vec::new();
    for (file, text) in files() {
        let found = mutants(file, text);
        println!("{file}: {} mutants", found.len());
        // `runtime.c` is for the long form alone: its locks are for the thread sanitizer.
        if all || file == "step.c" {
            chosen.extend(found.into_iter().map(|m| (m, text)));
        }
    }
    if !all {
        let mut random = Random(24);
        chosen.retain(|(m, text)| {
            let (_, line, change) = m.describe(text);
            !is_among(&EQUIVALENT, &line, &change)
        });
        while chosen.len() > sample {
            chosen.swap_remove(random.below(chosen.len() as u64) as usize);
        }
    }
    let (mut killed, mut refused, mut equivalent) = (0, 0, 0);
    let mut alive = Vec::new();
    for (mutant, text) in &chosen {
        let (number, line, change) = mutant.describe(text);
        match court.judge(mutant) {
            Fate::Refused => refused += 1,
            Fate::Killed => killed += 1,
            Fate::Lives if is_among(&EQUIVALENT, &line, &change) => equivalent += 1,
            Fate::Lives if is_among(&UNNOTICED, &line, &change) => {
                println!(
                    "not noticed yet: {}:{number} {change} in `{line}`",
                    mutant.file
                );
            }
            Fate::Lives => {
                println!("lives: {}:{number} {change} in `{line}`", mutant.file);
                alive.push(format!("{}:{number} {change}", mutant.file));
            }
        }
    }
    println!(
        "{killed} killed, {refused} are no C, {equivalent} are equivalent, {} live",
        alive.len()
    );
    assert!(alive.is_empty(), "{alive:#?}");
    assert!(killed > 0);
}
