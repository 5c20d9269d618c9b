//! `linewright din`: looks up entries of the taxonomies, and lists the codes that have contracts.

use super::console::schema;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use crate::cli::console::Failed;
use crate::cli::schema::{Described, form};
use crate::contract::Library;
use crate::diagnostics::has_errors;
use crate::engine::files::{self, StandardLibrary};
use crate::taxonomy::{self, Entry, Standard, Taxonomy, taxonomy};
use clap::{Args, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The arguments of `din`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Subcommand with its arguments.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show one process or function
    #[command(after_help = "Example:\n    linewright din show din:4.3.1")]
    Show {
        /// Code with its standard, such as din:4.3.1 or vdi:Drehen
        code: String,
    },
    /// Find codes by a German or English word
    #[command(after_help = "Example:\n    linewright din search fraesen")]
    Search {
        /// Part of a term; case and the spelling of umlauts do not matter
        word: String,
    },
    /// Print a standard, or the part below a code, as a tree
    #[command(after_help = "Example:\n    linewright din tree din:4.3")]
    Tree {
        /// Code with its standard, such as din:4.3; if omitted, both standards are printed
        code: Option<String>,
    },
    /// List the groups of both standards with their contracts, and what is missing
    #[command(after_help = "Example:\n    linewright din coverage")]
    Coverage {
        /// Files or folders [default: ./contracts, or else the bundled library]
        #[arg(value_name = "PATH")]
        paths: Vec<String>,
    },
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    if !matches!(arguments.command, Command::Coverage { .. }) {
        options.refuse_sarif("the taxonomy")?;
    }
    let taxonomy = taxonomy();
    let console = options.console();
    match &arguments.command {
        Command::Show { code } => {
            let entry = find(code)?;
            if is_json(options) {
                console.document(&Entries::new([entry]))?;
            } else {
                console.result(&show(taxonomy, entry))?;
            }
        }
        Command::Search { word } => {
            let found = taxonomy.search(word);
            if is_json(options) {
                console.document(&Entries::new(found))?;
            } else {
                console.result(&list(&found))?;
                if found.is_empty() {
                    console.remark(&format!("no term contains `{word}`\n"))?;
                }
            }
        }
        Command::Tree { code } => {
            let roots = match code {
                Some(code) => vec![find(code)?],
                None => taxonomy.roots().collect(),
            };
            if is_json(options) {
                let mut entries = Vec::new();
                for root in roots {
                    add_tree(taxonomy, root, &mut entries);
                }
                console.document(&Entries::new(entries))?;
            } else {
                let mut text = String::new();
                for root in roots {
                    let _ = writeln!(text, "{}", root.describe());
                    branches(taxonomy, root, "", &mut text);
                }
                console.result(&text)?;
            }
        }
        Command::Coverage { paths } => return coverage(paths, options),
    }
    Ok(ExitCode::Success)
}

fn is_json(options: &GlobalOptions) -> bool {
    options.format == Format::Json
}

fn find(code: &str) -> anyhow::Result<&'static Entry> {
    taxonomy::lookup(code)
        .map_err(|help| anyhow::anyhow!("`{code}` is not a code of DIN 8580 or VDI 2860: {help}"))
}

fn show(taxonomy: &Taxonomy, entry: &Entry) -> String {
    let mut text = String::new();
    let path = taxonomy.path(entry);
    let above: Vec<&str> = path[..path.len() - 1]
        .iter()
        .map(|e| e.english.as_str())
        .collect();
    let children: Vec<String> = taxonomy.children(entry).map(Entry::describe).collect();
    let standard = match entry.edition.as_str() {
        "" => entry.standard.title().to_owned(),
        edition => format!("{}, edition {edition}", entry.standard.title()),
    };
    let _ = writeln!(text, "{}", entry.describe());
    for (name, value) in [
        ("standard", standard),
        ("within", above.join(" > ")),
        ("note", entry.note.clone()),
        ("source", entry.source.clone()),
        ("confidence", entry.confidence.clone()),
        ("below", children.join("\n              ")),
    ] {
        if !value.is_empty() {
            let _ = writeln!(text, "  {name:<10}  {value}");
        }
    }
    text
}

fn list(entries: &[&Entry]) -> String {
    let codes: Vec<String> = entries.iter().map(|e| e.full_code()).collect();
    let width = codes.iter().map(|c| c.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for (entry, code) in entries.iter().zip(codes) {
        let _ = writeln!(text, "{code:<width$}  {} ({})", entry.german, entry.english);
    }
    text
}

fn branches(taxonomy: &Taxonomy, entry: &Entry, indent: &str, text: &mut String) {
    let children: Vec<&Entry> = taxonomy.children(entry).collect();
    for (i, child) in children.iter().enumerate() {
        let last = i + 1 == children.len();
        let (branch, space) = if last {
            ("└── ", "    ")
        } else {
            ("├── ", "│   ")
        };
        let _ = writeln!(text, "{indent}{branch}{}", child.describe());
        branches(taxonomy, child, &format!("{indent}{space}"), text);
    }
}

/// Adds an entry and all its descendants.
fn add_tree<'a>(taxonomy: &'a Taxonomy, entry: &'a Entry, entries: &mut Vec<&'a Entry>) {
    entries.push(entry);
    for child in taxonomy.children(entry) {
        add_tree(taxonomy, child, entries);
    }
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "din",
    "Entries of DIN 8580 and VDI 2860, or which of them have contracts",
    &[
        form::<Entries<'_>>,
        form::<CoverageDocument>,
        form::<Failed>,
    ],
);

/// The JSON document of `din show`, `din search` and `din tree`.
#[derive(JsonSchema, Serialize)]
struct Entries<'a> {
    schema: String,
    /// The entries.
    entries: Vec<EntryDocument<'a>>,
}

/// An entry of a taxonomy.
#[derive(JsonSchema, Serialize)]
struct EntryDocument<'a> {
    /// The code with its prefix, such as `din:3.2.1` or `vdi:Drehen`.
    code: String,
    /// The title of the standard.
    standard: &'a str,
    /// The German term.
    german: &'a str,
    /// The English term.
    english: &'a str,
    /// The code of the parent entry; null at the top.
    parent: Option<String>,
    /// The edition of the standard; empty if unknown.
    edition: &'a str,
    /// The confidence in the entry.
    confidence: &'a str,
    /// The source of the entry.
    source: &'a str,
    /// A remark; can be empty.
    note: &'a str,
}

impl<'a> Entries<'a> {
    fn new(entries: impl IntoIterator<Item = &'a Entry>) -> Self {
        let entries = entries.into_iter().map(|e| EntryDocument {
            code: e.full_code(),
            standard: e.standard.title(),
            german: &e.german,
            english: &e.english,
            parent: e
                .parent
                .as_ref()
                .map(|p| format!("{}:{p}", e.standard.prefix())),
            edition: &e.edition,
            confidence: &e.confidence,
            source: &e.source,
            note: &e.note,
        });
        Self {
            schema: schema("din"),
            entries: entries.collect(),
        }
    }
}

/// The JSON document of `din coverage`.
#[derive(JsonSchema, Serialize)]
struct CoverageDocument {
    schema: String,
    /// The standards.
    standards: Vec<StandardCoverage>,
}

/// The codes of a standard that have contracts.
#[derive(JsonSchema, Serialize)]
struct StandardCoverage {
    /// The title of the standard.
    standard: &'static str,
    /// The number of codes in the standard.
    codes: usize,
    /// The codes that have an implementation.
    covered: Vec<CoveredCode>,
    /// The groups of DIN 8580, or the functions of VDI 2860 below its five sub-functions, each with
    /// what implements it or a code below it: nothing if that is missing.
    groups: Vec<CoveredCode>,
}

/// A code with its implementations.
#[derive(JsonSchema, Serialize)]
struct CoveredCode {
    /// The code with its prefix.
    code: String,
    /// The German term.
    german: String,
    /// The English term.
    english: String,
    /// The contracts, machines and operations that implement it.
    implemented_by: Vec<String>,
}

/// The number of entries from the top of a standard to a group of DIN 8580 or a function of VDI
/// 2860.
fn group_depth(standard: Standard) -> usize {
    match standard {
        Standard::Din8580 => 2,
        Standard::Vdi2860 => 3,
    }
}

/// A standard's groups with what implements them, then codes above the groups, then what is
/// missing.
fn coverage_text(standard: &StandardCoverage, taxonomy: &Taxonomy) -> String {
    let is_done = |group: &&CoveredCode| !group.implemented_by.is_empty();
    let what = match standard.groups.first() {
        Some(group) if group.code.starts_with("din:") => "groups",
        _ => "functions",
    };
    let mut text = format!(
        "{}: {} of {} {what} have contracts\n",
        standard.standard,
        standard.groups.iter().filter(is_done).count(),
        standard.groups.len()
    );
    let is_within = |code: &str| {
        let path = taxonomy.find(code).map(|e| taxonomy.path(e));
        path.is_some_and(|path| path.len() >= group_depth(path[0].standard))
    };
    let above = standard.covered.iter().filter(|c| !is_within(&c.code));
    let rows: Vec<&CoveredCode> = above
        .chain(standard.groups.iter().filter(is_done))
        .collect();
    let names: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {}", row.code, row.english))
        .collect();
    let width = names.iter().map(|name| name.chars().count()).max();
    for (name, row) in names.iter().zip(rows) {
        let width = width.unwrap_or(0);
        let by = row.implemented_by.join(", ");
        let _ = writeln!(text, "  {name:<width$}  {by}");
    }
    let mut missing = standard
        .groups
        .iter()
        .filter(|group| !is_done(group))
        .peekable();
    if missing.peek().is_some() {
        let _ = writeln!(text, "  missing:");
    }
    for group in missing {
        let _ = writeln!(text, "    {} {}", group.code, group.english);
    }
    text
}

fn coverage(paths: &[String], options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let loaded = files::load(paths, &StandardLibrary::new(options.library.clone()));
    let sources = &loaded.library.sources;
    if has_errors(&loaded.findings) {
        console.failed("din", sources, &loaded.findings)?;
        return Ok(options.exit_code(&loaded.findings));
    }
    let covered = implementations(&loaded.library);
    let taxonomy = taxonomy();
    let covered_code = |e: &Entry, implemented_by: Vec<String>| CoveredCode {
        code: e.full_code(),
        german: e.german.clone(),
        english: e.english.clone(),
        implemented_by,
    };
    let standards = [Standard::Din8580, Standard::Vdi2860].map(|standard| {
        let entries = || taxonomy.entries().iter().filter(|e| e.standard == standard);
        let groups = entries().filter(|e| taxonomy.path(e).len() == group_depth(standard));
        StandardCoverage {
            standard: standard.title(),
            codes: entries().count(),
            covered: entries()
                .filter_map(|e| Some(covered_code(e, covered.get(&e.full_code())?.clone())))
                .collect(),
            groups: groups
                .map(|group| {
                    let below = entries().filter(|e| taxonomy.path(e).contains(&group));
                    let by = below.filter_map(|e| covered.get(&e.full_code())).flatten();
                    let mut by: Vec<String> = by.cloned().collect();
                    let mut seen = BTreeSet::new();
                    by.retain(|name| seen.insert(name.clone()));
                    covered_code(group, by)
                })
                .collect(),
        }
    });
    if is_json(options) {
        console.document(&CoverageDocument {
            schema: schema("din"),
            standards: standards.into(),
        })?;
        return Ok(options.exit_code(&loaded.findings));
    }
    let mut text = String::new();
    for standard in &standards {
        let _ = write!(text, "{}", coverage_text(standard, taxonomy));
    }
    console.result(&text)?;
    console.findings(sources, &loaded.findings)?;
    Ok(options.exit_code(&loaded.findings))
}

/// Names of the contracts, machines, and operations of machines that implement each code.
fn implementations(library: &Library) -> BTreeMap<String, Vec<String>> {
    let mut by_code: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let contracts = library.contracts.iter().map(|c| (c.name.clone(), &c.codes));
    let machines = library.machines.iter().flat_map(|m| {
        let operations = m.operations.iter();
        std::iter::once((m.name.clone(), &m.codes))
            .chain(operations.map(|o| (format!("{}.{}", m.name, o.name), &o.codes)))
    });
    for (name, codes) in contracts.chain(machines) {
        for code in codes {
            // Codes are spelled as in the taxonomy: contracts can write umlauts and case
            // differently.
            let Some(entry) = taxonomy().find(&code.text) else {
                continue;
            };
            let names = by_code.entry(entry.full_code()).or_default();
            if !names.contains(&name) {
                names.push(name.clone());
            }
        }
    }
    by_code
}
