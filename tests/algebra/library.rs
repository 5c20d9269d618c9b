//! The bundled library: scripts, sentences and rules of each contract.
//!
//! Each contract has a script beside it, which tells a good cycle and a disturbance. Its comment
//! says what the machine never does, with a formula that every controller keeps. Each of its rules
//! matters: without a guarantee some controller may do more, and without an assumption no
//! controller exists. A contract promises less than in the last version only if the library has a
//! new major version.

use crate::support::{files_below, linewright, root};
use linewright::algebra::join::{Member, Sharing, join};
use linewright::algebra::refine::refine;
use linewright::contract;
use linewright::game::{Limits, Outcome, solve};
use linewright::gr1::Specification;
use linewright::syntax::is_reserved;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A contract of the library, cut into statements.
struct Entry {
    /// Below `contracts`: `joining/press_fit.lw`.
    path: PathBuf,
    /// The imports, the comment and the first lines of the contract.
    head: String,
    /// The statements, in order.
    statements: Vec<String>,
    /// The comment as one line.
    comment: String,
}

impl Entry {
    fn read(path: PathBuf, text: &str) -> Option<Self> {
        let lines: Vec<&str> = text.lines().collect();
        let is_contract =
            |line: &&str| line.starts_with("contract ") || line.starts_with("moore contract ");
        let first = lines.iter().position(is_contract)?;
        let open = first + lines[first..].iter().position(|line| line.ends_with('{'))?;
        let comment = lines[..first].iter().filter_map(|l| l.strip_prefix("///"));
        let comment: Vec<&str> = comment.map(str::trim).collect();
        let mut statements: Vec<String> = Vec::new();
        for line in lines[open + 1..].iter().take_while(|line| **line != "}") {
            // What goes on below is further in, since the file is formatted.
            if line.starts_with("    ") && !line.starts_with("     ") {
                statements.push((*line).to_owned());
            } else if let (false, Some(last)) = (line.is_empty(), statements.last_mut()) {
                last.push('\n');
                last.push_str(line);
            }
        }
        Some(Self {
            path,
            head: lines[..=open].join("\n"),
            statements,
            comment: comment.join(" "),
        })
    }

    /// The text with these statements.
    fn with<'a>(&self, statements: impl IntoIterator<Item = &'a str>) -> String {
        let statements: Vec<&str> = statements.into_iter().collect();
        format!("{}\n{}\n}}\n", self.head, statements.join("\n"))
    }

    fn statements(&self) -> impl Iterator<Item = &str> {
        self.statements.iter().map(String::as_str)
    }

    /// The text without one statement.
    fn without(&self, index: usize) -> String {
        self.with(
            self.statements()
                .enumerate()
                .filter_map(|(i, statement)| (i != index).then_some(statement)),
        )
    }

    /// The text with another statement in this place.
    fn replaced(&self, index: usize, by: &str) -> String {
        let statements = self.statements().enumerate();
        self.with(statements.map(|(i, statement)| if i == index { by } else { statement }))
    }

    /// The places and names of the statements of a kind, `assume` or `guarantee`.
    fn named<'a>(&'a self, word: &'a str) -> impl Iterator<Item = (usize, &'a str)> {
        let statements = self.statements().enumerate();
        statements.filter_map(move |(index, statement)| {
            let rest = statement.trim_start().strip_prefix(word)?;
            let (name, _) = rest.split_once(':')?;
            Some((index, name.trim()))
        })
    }

    /// The sentences "Never ...: `FORMULA`." of the comment, with their formulas.
    fn sentences(&self) -> Vec<(&str, &str)> {
        let mut found = Vec::new();
        let mut rest = self.comment.as_str();
        while let Some(start) = rest.find("Never ") {
            rest = &rest[start..];
            let Some((sentence, after)) = rest.split_once('`') else {
                break;
            };
            let (formula, after) = after.split_once('`').expect("a formula ends");
            if let Some(sentence) = sentence.trim_end().strip_suffix(':') {
                found.push((sentence, formula));
            }
            rest = after;
        }
        found
    }

    /// The text of a contract that guarantees nothing but the formula of a sentence.
    fn claim(&self, formula: &str) -> String {
        let claim = format!("    guarantee claim: {formula}");
        let others = self.statements();
        let others = others.filter(|statement| !statement.starts_with("    guarantee"));
        self.with(others.chain([claim.as_str()]))
    }

    /// The path of the script.
    fn script(&self) -> PathBuf {
        library().join(self.path.with_extension("step"))
    }
}

fn library() -> PathBuf {
    root().join("contracts")
}

/// The texts of all files, with their paths below `contracts`, in order.
fn texts() -> Vec<(PathBuf, String)> {
    let texts = files_below(&library(), &["lw"]).into_iter().map(|path| {
        let text = std::fs::read_to_string(&path).expect("text");
        let below = path.strip_prefix(library()).expect("a file of the library");
        (below.to_owned(), text)
    });
    texts.collect()
}

/// Whether a file declares a machine. Contracts beside it simulate the plant.
fn has_machine(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("machine "))
}

/// All contracts, in order of their paths.
fn entries() -> Vec<Entry> {
    let contracts = texts().into_iter().filter(|(_, text)| !has_machine(text));
    let found = contracts.filter_map(|(path, text)| Entry::read(path, &text));
    let found: Vec<Entry> = found.collect();
    assert!(found.len() >= 80, "only {} contracts", found.len());
    found
}

/// The texts of the files with machines, with their paths below `contracts`.
fn machines() -> Vec<(PathBuf, String)> {
    let texts = texts().into_iter();
    texts.filter(|(_, text)| has_machine(text)).collect()
}

/// The contract with this text in the place of an entry; `None` if it has errors.
fn specification(entry: &Entry, text: &str) -> Option<Arc<Specification>> {
    let file = library().join(&entry.path);
    let files = [(file.display().to_string(), text.to_owned())];
    let (library, _) = contract::load(&files, &|to, from| {
        let folder = Path::new(from).parent().unwrap_or(Path::new(""));
        let path = folder.join(to);
        let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
        Ok((path.display().to_string(), text))
    });
    let contract = library.contracts.into_iter().next_back()?;
    Some(contract.specification)
}

/// Whether every controller of `new` is one of `old`.
fn refines(new: &Specification, old: &Specification) -> bool {
    let member = |specification, name: &str| Member {
        specification,
        name: name.to_owned(),
        renamings: Vec::new(),
    };
    let members = [member(old, "old"), member(new, "new")];
    let system = join(&members, Sharing::SeveralViews).expect("the same ports");
    let refinement = refine(&system, 1, 0, &Limits::default()).expect("no limit");
    refinement.holds()
}

fn is_realizable(specification: &Specification) -> bool {
    matches!(
        solve(specification, &Limits::default()),
        Outcome::Realizable(_)
    )
}

/// Whether the formulas of all sentences follow from the guarantees of this text.
fn keeps_sentences(entry: &Entry, text: &str) -> bool {
    let new = specification(entry, text).expect("a contract");
    let mut sentences = entry.sentences().into_iter();
    sentences.all(|(_, formula)| {
        let old = specification(entry, &entry.claim(formula));
        refines(&new, &old.expect("a formula"))
    })
}

#[test]
fn a_script_tells_a_good_cycle_and_a_disturbance() {
    for entry in entries() {
        let path = entry.path.display();
        let script = std::fs::read_to_string(entry.script());
        let script = script.unwrap_or_else(|e| panic!("the script of {path}: {e}"));
        let expects = script.lines().filter(|line| line.starts_with("expect "));
        assert!(expects.count() >= 6, "{path} expects little");
        assert!(
            script.lines().any(|line| line == "reset"),
            "{path} has no disturbance"
        );
        let file = library().join(&entry.path).display().to_string();
        let script = entry.script().display().to_string();
        let output = linewright(root(), &["step", &file, "--script", &script]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{path}: {errors}");
    }
}

#[test]
fn what_a_machine_never_does_no_controller_does() {
    for entry in entries() {
        let path = entry.path.display();
        let sentences = entry.sentences();
        assert!(
            (2..=6).contains(&sentences.len()),
            "{path} has {} sentences that begin with `Never`",
            sentences.len()
        );
        let whole = specification(&entry, &entry.with(entry.statements())).expect("a contract");
        for (sentence, formula) in sentences {
            let claim = specification(&entry, &entry.claim(formula));
            let claim = claim.unwrap_or_else(|| panic!("{path}: `{formula}` is no formula"));
            assert!(refines(&whole, &claim), "{path}: {sentence}: {formula}");
        }
    }
}

/// Whether the comment says why an assumption is here that could be left out.
fn is_kept(entry: &Entry, name: &str) -> bool {
    let named = format!("`{name}`");
    entry.comment.split(['.', ':', ';']).any(|sentence| {
        sentence.contains(&named)
            && (sentence.contains(" is here because ") || sentence.contains(" are here because "))
    })
}

#[test]
fn every_guarantee_matters() {
    let mut idle = Vec::new();
    for entry in entries() {
        let whole = specification(&entry, &entry.with(entry.statements())).expect("a contract");
        for (index, name) in entry.named("guarantee") {
            let rest = specification(&entry, &entry.without(index)).expect("a contract");
            if refines(&rest, &whole) {
                idle.push(format!("{}: {name}", entry.path.display()));
            }
        }
    }
    assert!(idle.is_empty(), "the others imply:\n{}", idle.join("\n"));
}

#[test]
fn every_assumption_matters_or_the_comment_says_why_it_is_kept() {
    let mut idle = Vec::new();
    for entry in entries() {
        for (index, name) in entry.named("assume") {
            let rest = specification(&entry, &entry.without(index)).expect("a contract");
            if !is_kept(&entry, name) && is_realizable(&rest) {
                idle.push(format!("{}: {name}", entry.path.display()));
            }
        }
    }
    assert!(idle.is_empty(), "not needed:\n{}", idle.join("\n"));
}

/// A contract with one guarantee left out or weakened, or with a condition negated.
struct Mutant {
    name: String,
    text: String,
}

fn mutants(entry: &Entry) -> Vec<Mutant> {
    let mut found = Vec::new();
    for (index, name) in entry.named("guarantee") {
        let statement = &entry.statements[index];
        found.push(Mutant {
            name: format!("without {name}"),
            text: entry.without(index),
        });
        let Some((before, inside)) = statement.split_once("always (") else {
            continue;
        };
        for arrow in [" -> ", " <-> "] {
            let Some((condition, rest)) = inside.split_once(arrow) else {
                continue;
            };
            if !is_balanced(condition) || condition.contains("->") {
                continue;
            }
            found.push(Mutant {
                name: format!("condition of {name} negated"),
                text: entry.replaced(
                    index,
                    &format!("{before}always (not ({condition}){arrow}{rest}"),
                ),
            });
            let Some(effect) = rest.strip_suffix(')').filter(|_| arrow == " <-> ") else {
                continue;
            };
            assert!(is_balanced(effect), "{statement}");
            found.push(Mutant {
                name: format!("{name} with -> for <->"),
                text: entry.replaced(index, &format!("{before}always ({condition} -> {rest}")),
            });
            found.push(Mutant {
                name: format!("{name} with <- for <->"),
                text: entry.replaced(
                    index,
                    &format!("{before}always (({effect}) -> {condition})"),
                ),
            });
        }
        if let Some((most, last)) = statement.rsplit_once(" and ")
            && most.contains(" -> ")
            && !last[..last.len() - 1].contains(['(', ')'])
        {
            found.push(Mutant {
                name: format!("{name} without its last part"),
                text: entry.replaced(index, &format!("{most})")),
            });
        }
    }
    found
}

fn is_balanced(text: &str) -> bool {
    let depth = text.chars().try_fold(0_i32, |depth, c| match c {
        '(' => Some(depth + 1),
        ')' => Some(depth - 1).filter(|depth| *depth >= 0),
        _ => Some(depth),
    });
    depth == Some(0)
}

/// A contract as text without its comments and its code, in which each name is a number: that of
/// its first appearance.
fn with_numbers_for_names(entry: &Entry) -> String {
    let lines: Vec<&str> = entry.head.lines().collect();
    let start = lines.iter().position(|line| line.contains("contract "));
    let head = lines[start.expect("a contract")..].join("\n");
    let head = head.split(" implements ").next().unwrap_or_default();
    let statements = entry.statements();
    let lines = [head].into_iter().chain(statements).flat_map(str::lines);
    let lines = lines.map(|line| line.split("//").next().unwrap_or_default());
    let text: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    let text = text.join(" ");
    let mut numbers = BTreeMap::new();
    let mut shown = String::new();
    let mut rest = text.as_str();
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end.max(first.len_utf8()));
        if (first.is_alphabetic() || first == '_') && !is_reserved(piece) {
            let next = numbers.len();
            let number = numbers.entry(piece).or_insert(next);
            shown.push('n');
            shown.push_str(&number.to_string());
        } else {
            shown.push_str(piece);
        }
        rest = after;
    }
    shown
}

/// Two contracts that differ in nothing but names would be one, with a parameter.
#[test]
fn no_two_contracts_differ_in_names_only() {
    let mut seen: BTreeMap<String, PathBuf> = BTreeMap::new();
    for entry in entries() {
        let text = with_numbers_for_names(&entry);
        if let Some(other) = seen.insert(text, entry.path.clone()) {
            let (one, other) = (entry.path.display(), other.display());
            panic!("{one} is {other} with other names");
        }
    }
}

/// What becomes of a mutant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// It has no controller.
    Unrealizable,
    /// A sentence no longer follows, or the script fails.
    Caught,
    Survives,
}

fn fate(entry: &Entry, specification: &Specification, text: &str) -> Fate {
    if !is_realizable(specification) {
        return Fate::Unrealizable;
    }
    if !keeps_sentences(entry, text) {
        return Fate::Caught;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join(&entry.path);
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
    std::fs::create_dir_all(folder.path().join("common")).expect("a folder");
    for shared in std::fs::read_dir(library().join("common")).expect("a folder") {
        let shared = shared.expect("an entry");
        let to = folder.path().join("common").join(shared.file_name());
        std::fs::copy(shared.path(), to).expect("a copy");
    }
    std::fs::write(&file, text).expect("a file");
    let script = entry.script().display().to_string();
    let file = file.display().to_string();
    let output = linewright(folder.path(), &["step", &file, "--script", &script]);
    if output.status.success() {
        Fate::Survives
    } else {
        Fate::Caught
    }
}

/// The mutants that are known to survive, one a row: `path: mutant | reason`.
const SURVIVORS: &str = include_str!("../fixtures/library_survivors.txt");

/// The mutants in that list, as `path: mutant`.
fn listed_survivors() -> BTreeSet<&'static str> {
    let rows = SURVIVORS.lines();
    let rows = rows.filter(|row| !row.is_empty() && !row.starts_with('#'));
    let mut listed = BTreeSet::new();
    for row in rows {
        let (mutant, reason) = row.split_once(" | ").expect("a mutant and a reason");
        let (kind, why) = reason.split_once(": ").expect("a kind of reason");
        let is_known = ["equivalent", "unnoticed"].contains(&kind);
        assert!(is_known && !why.is_empty(), "no reason: {row}");
        assert!(listed.insert(mutant), "listed twice: {row}");
    }
    listed
}

/// Every tenth mutant; all of them with `LINEWRIGHT_MUTANTS=all`.
#[test]
fn mutants_are_caught() {
    let all = std::env::var("LINEWRIGHT_MUTANTS").is_ok_and(|which| which == "all");
    let step = if all { 1 } else { 10 };
    let listed = listed_survivors();
    let (mut number, mut tried, mut unrealizable) = (0, 0, 0);
    let mut survivors = BTreeSet::new();
    for entry in entries() {
        for mutant in mutants(&entry) {
            number += 1;
            if number % step != 0 {
                continue;
            }
            // A mutant that is no contract shows nothing.
            let Some(specification) = specification(&entry, &mutant.text) else {
                continue;
            };
            tried += 1;
            match fate(&entry, &specification, &mutant.text) {
                Fate::Unrealizable => unrealizable += 1,
                Fate::Caught => {}
                Fate::Survives => {
                    survivors.insert(format!("{}: {}", entry.path.display(), mutant.name));
                }
            }
        }
    }
    let caught = tried - survivors.len();
    println!(
        "{tried} mutants tried; {caught} caught, {unrealizable} of these unrealizable; {} listed",
        listed.len()
    );
    let is_new = |survivor: &&String| !listed.contains(survivor.as_str());
    let new: Vec<&String> = survivors.iter().filter(is_new).collect();
    assert!(new.is_empty(), "not in library_survivors.txt: {new:#?}");
    assert!(tried >= 100);
    if all {
        let stale = listed.iter().filter(|listed| !survivors.contains(**listed));
        let stale: Vec<&&str> = stale.collect();
        assert!(
            stale.is_empty(),
            "caught or gone, but in library_survivors.txt: {stale:#?}"
        );
        assert!(caught * 20 >= tried * 19, "{caught} of {tried} are caught");
    }
}

/// The last version of the library: its number in the first line, then each file below its path.
fn last_version() -> PathBuf {
    root().join("tests/fixtures/library.txt")
}

/// What stands before the path of a file in that text.
const FILE: &str = "=== ";

/// The version of the library, which its page states.
fn version() -> String {
    let page = std::fs::read_to_string(library().join("README.md")).expect("a page");
    let line = page.lines().find_map(|line| line.strip_prefix("Version "));
    let version = line.expect("the page states the version");
    version.trim_end_matches('.').to_owned()
}

fn major(version: &str) -> &str {
    version.split('.').next().unwrap_or(version)
}

/// All files of the library that are text of the language, as one text.
fn as_text() -> String {
    let mut text = format!("{}\n", version());
    let mut files: Vec<PathBuf> = entries().into_iter().map(|entry| entry.path).collect();
    let shared = std::fs::read_dir(library().join("common")).expect("a folder");
    files.extend(shared.map(|entry| Path::new("common").join(entry.expect("a file").file_name())));
    files.sort();
    for file in files {
        text.push_str(FILE);
        text.push_str(&file.to_string_lossy());
        text.push('\n');
        text.push_str(&std::fs::read_to_string(library().join(file)).expect("text"));
    }
    text
}

/// With `LINEWRIGHT_NEW_VERSION=1`, keeps the library as its last version instead.
#[test]
fn a_contract_promises_less_only_in_a_new_major_version() {
    if std::env::var_os("LINEWRIGHT_NEW_VERSION").is_some() {
        std::fs::write(last_version(), as_text()).expect("a file");
        return;
    }
    let text = std::fs::read_to_string(last_version()).expect("the last version");
    let (last, files) = text.split_once('\n').expect("a version");
    let folder = tempfile::tempdir().expect("a folder");
    let mut file: Option<std::fs::File> = None;
    for line in files.lines() {
        if let Some(path) = line.strip_prefix(FILE) {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            file = Some(std::fs::File::create(path).expect("a file"));
        } else {
            let file = file.as_mut().expect("a path comes first");
            writeln!(file, "{line}").expect("a line");
        }
    }
    let old = folder.path().display().to_string();
    let new = library().display().to_string();
    let output = linewright(root(), &["refine", &old, &new, "--format", "short"]);
    let shown = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() || major(last) != major(&version()),
        "the library is still version {}, but a contract promises less than in {last}:\n{shown}",
        version()
    );
}

/// Each time, power and failure of a machine says where its figure comes from.
#[test]
fn each_figure_of_a_machine_names_its_source() {
    let is_figure = |line: &str| {
        let mut words = line.split_whitespace();
        let (first, second) = (words.next(), words.next());
        let is_binding = second == Some("=");
        let is_statement = matches!(first, Some("step" | "power" | "idle" | "time" | "failures"));
        is_statement && !is_binding
    };
    for (path, text) in machines() {
        let path = path.display();
        let figures = text.lines().filter(|line| is_figure(line));
        let figures: Vec<&str> = figures.collect();
        assert!(!figures.is_empty(), "{path}");
        for line in figures {
            let source = line.split_once("// ").map(|(_, source)| source.trim());
            assert!(source.is_some_and(|s| !s.is_empty()), "{path}: {line}");
        }
        // A conveyor's failures are given in the line.
        let fails = text.contains("\n    failures ");
        assert!(fails || text.contains("import \"convey.lw\""), "{path}");
    }
}

/// Each handling contract and each main group of DIN 8580 has a machine.
#[test]
fn handling_and_each_main_group_have_machines() {
    let machines = machines();
    for entry in entries() {
        if let Ok(file) = entry.path.strip_prefix("handling") {
            let import = format!("\"{}\"\n", file.display());
            let uses = machines.iter().any(|(_, text)| text.contains(&import));
            assert!(uses, "no machine uses {import}");
        }
    }
    let groups = [
        "primary_shaping",
        "forming",
        "separating",
        "joining",
        "coating",
        "changing_properties",
    ];
    for group in groups {
        let has = machines.iter().any(|(path, _)| path.starts_with(group));
        assert!(has, "{group} has no machine");
    }
}
