//! The catalogue of the bundled library in `docs/library`: a page for each contract, with its
//! comment, its interface, its states, a good cycle as a timing diagram, and contracts that fit
//! beside it. All of it is generated (`INSTA_UPDATE=always` writes it anew).
//!
//! The commands of the pages are run with those of the other pages (`readme.rs`).

use super::drawings::{Drawing, loaded};
use super::support;
use super::support::files_below;
use linewright::contract::Contract;
use linewright::taxonomy;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Maximum number of states that are drawn one by one, if the contract has phases.
const MAX_STATES: usize = 12;

/// A contract of the library.
struct Entry {
    /// Below `contracts`, without the ending: `joining/press_fit`.
    place: String,
    text: String,
    contract: Contract,
}

/// A machine of the library.
struct Machine {
    name: String,
    /// Below `contracts`, without the ending.
    place: String,
    /// The contracts of its components.
    uses: Vec<String>,
    /// The first sentence of its comment.
    summary: String,
}

/// The text of the files below `contracts`, by their places without the ending.
fn texts() -> BTreeMap<String, String> {
    let folder = support::root().join("contracts");
    let texts = files_below(&folder, &["lw"]).into_iter().map(|path| {
        let place = path.strip_prefix(&folder).expect("it is below the folder");
        let place = place
            .with_extension("")
            .to_string_lossy()
            .replace('\\', "/");
        (place, std::fs::read_to_string(&path).expect("a text"))
    });
    texts.collect()
}

/// The contracts with a script, in the order of their places.
fn entries(texts: &BTreeMap<String, String>) -> Vec<Entry> {
    let with_script = texts.iter().filter(|(place, _)| {
        let script = Path::new("contracts").join(place).with_extension("step");
        support::root().join(script).is_file()
    });
    let entries = with_script.map(|(place, text)| {
        let path = Path::new("contracts").join(place).with_extension("lw");
        let (library, _) = loaded(&support::root().join(path));
        let contract = library.contracts.into_iter().next_back();
        Entry {
            place: place.clone(),
            text: text.clone(),
            contract: contract.expect("the file declares a contract"),
        }
    });
    entries.collect()
}

/// The machines, in the order of their places.
fn machines(texts: &BTreeMap<String, String>) -> Vec<Machine> {
    let with_machine = texts
        .iter()
        .filter(|(_, text)| text.lines().any(|line| line.starts_with("machine ")));
    let machines = with_machine.flat_map(|(place, _)| {
        let path = Path::new("contracts").join(place).with_extension("lw");
        let (library, _) = loaded(&support::root().join(path));
        let machines = library.machines.into_iter();
        machines.map(|machine| {
            let words = machine.doc.lines().collect::<Vec<_>>().join(" ");
            let end = words.find(". ").map_or(words.len(), |end| end + 1);
            let components = machine.components.iter();
            Machine {
                name: machine.name.clone(),
                place: place.clone(),
                uses: components.map(|c| c.contract.clone()).collect(),
                summary: words[..end].to_owned(),
            }
        })
    });
    machines.collect()
}

/// What a file of the library is imported as.
fn import(place: &str) -> String {
    format!("std.{}", place.replace('/', "."))
}

impl Entry {
    fn name(&self) -> &str {
        &self.contract.name
    }

    /// The path of the contract in the repository.
    fn file(&self) -> String {
        format!("contracts/{}.lw", self.place)
    }

    /// The last part of the place: `press_fit`.
    fn stem(&self) -> &str {
        self.place.rsplit('/').next().unwrap_or(&self.place)
    }

    fn group(&self) -> &str {
        self.place.split('/').next().unwrap_or_default()
    }

    /// The declarations of signals: what each is, the names, and the type.
    fn signals(&self) -> Vec<(&str, Vec<&str>, &str)> {
        let mut found = Vec::new();
        for line in self.text.lines().filter_map(|l| l.strip_prefix("    ")) {
            for kind in ["input", "output", "internal"] {
                let rest = line
                    .strip_prefix(kind)
                    .and_then(|rest| rest.strip_prefix(' '));
                if let Some((names, domain)) = rest.and_then(|rest| rest.split_once(": ")) {
                    found.push((kind, names.split(", ").collect(), domain));
                }
            }
        }
        found
    }

    /// Whether it declares this signal.
    fn has(&self, kind: &str, name: &str, domain: &str) -> bool {
        let mut signals = self.signals().into_iter();
        signals.any(|(k, names, d)| k == kind && names.contains(&name) && d == domain)
    }

    /// The output that says that the requested work is finished.
    fn done(&self) -> Option<&str> {
        let mut outputs = self
            .signals()
            .into_iter()
            .filter(|(kind, _, domain)| *kind == "output" && *domain == "bool");
        outputs.find_map(|(_, names, _)| names.into_iter().find(|n| n.ends_with("_done")))
    }

    /// The parameters as they are declared: name, range and default.
    fn parameters(&self) -> Vec<(String, String, String)> {
        let head = self.text.split_once(&format!("contract {}", self.name()));
        let list = head.and_then(|(_, rest)| rest.strip_prefix('('));
        let Some((list, _)) = list.and_then(|list| list.split_once(") implements")) else {
            return Vec::new();
        };
        let list = list.split_whitespace().collect::<Vec<_>>().join(" ");
        let mut depth = 0;
        let parts = list.split(|c: char| {
            depth += i32::from("([{".contains(c)) - i32::from(")]}".contains(c));
            c == ',' && depth == 0
        });
        let parameters = parts.map(|part| {
            let (name, rest) = part.split_once(':').expect("a parameter has a range");
            let (range, default) = rest.rsplit_once(" = ").unwrap_or((rest, ""));
            [name, range, default]
                .map(|text| text.trim().to_owned())
                .into()
        });
        parameters.collect()
    }

    /// The comment as Markdown: its sentences with "Never" become a list.
    fn comment(&self) -> String {
        let mut text = String::new();
        let mut is_item = false;
        for line in self.contract.doc.lines() {
            if line.starts_with("Never ") {
                is_item = true;
                text.push_str("- ");
            } else if line.is_empty() {
                is_item = false;
            } else if is_item {
                text.push_str("  ");
            }
            text.push_str(line);
            text.push('\n');
        }
        text
    }
}

/// Draws a contract; by its phases if it has many states.
fn states(entry: &Entry) -> (String, bool) {
    let draw = |more: &[&str]| {
        let file = entry.file();
        let arguments: Vec<&str> = ["draw", &file].iter().chain(more).copied().collect();
        let output = support::linewright(support::root(), &arguments);
        let printed = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{file}: {printed}");
        String::from_utf8(output.stdout).expect("text")
    };
    let has_phases = entry
        .signals()
        .iter()
        .any(|(kind, names, _)| *kind == "output" && names.contains(&"phase"));
    let all = draw(&[]);
    let texts = Drawing::read(&all).texts;
    let is_large = texts
        .iter()
        .any(|(text, _)| text == &format!("S{MAX_STATES}"));
    if is_large && has_phases {
        (draw(&["--by", "phase"]), true)
    } else {
        (all, false)
    }
}

/// The timing diagram of the good cycle: the script up to its first `reset`.
fn cycle(entry: &Entry) -> String {
    let script = support::root().join(entry.file()).with_extension("step");
    let script = std::fs::read_to_string(script).expect("a script");
    let good = script.lines().take_while(|line| *line != "reset");
    let mut good: Vec<&str> = good.collect();
    good.push("save cycle.svg\n");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("cycle.txt"), good.join("\n")).expect("a script");
    let file = support::root().join(entry.file());
    let file = file.to_string_lossy().into_owned();
    let arguments = ["step", &file, "--script", "cycle.txt"];
    let played = support::linewright(folder.path(), &arguments);
    assert!(played.status.success(), "{}", entry.place);
    std::fs::read_to_string(folder.path().join("cycle.svg")).expect("the drawing")
}

/// A command that shows that two contracts fit, and what it prints. `wires` are the ports that get
/// other names. Ports of the first contract that have a name of the second are renamed, too; but
/// both may read the same sensor.
fn fits(first: &Entry, second: &Entry, wires: &[(&Entry, &str, &str)]) -> String {
    let mut command = format!("linewright compat {} {}", first.file(), second.file());
    let mut rename = |entry: &Entry, port: &str, name: &str| {
        let _ = write!(command, " --rename {}.{port}={name}", entry.name());
    };
    for (entry, port, name) in wires {
        rename(entry, port, name);
    }
    let is_wired = |entry: &Entry, port: &str| {
        let mut wires = wires.iter();
        wires.any(|(other, name, _)| other.place == entry.place && *name == port)
    };
    for (kind, names, domain) in first.signals() {
        for name in names.into_iter().filter(|name| !is_wired(first, name)) {
            let is_sensor = kind == "input" && name != "requested";
            let shares = is_sensor && second.has(kind, name, domain);
            let mut others = second.signals().into_iter();
            let is_taken = others.any(|(_, names, _)| names.contains(&name));
            if is_taken && !shares && !is_wired(second, name) && wires.iter().all(|w| w.2 != name) {
                rename(first, name, &format!("{}_{name}", first.stem()));
            }
        }
    }
    let names = format!("{} and {}", first.name(), second.name());
    format!(
        "```console\n$ {command}\n{names}: some environment can keep their assumptions, whatever happens within the guarantees.\n```\n"
    )
}

/// A link from the page of one contract to that of another.
fn link(from: &Entry, to: &Entry) -> String {
    let page = if from.group() == to.group() {
        format!("{}.md", to.stem())
    } else {
        format!("../{}.md", to.place)
    };
    format!("[`{}`]({page})", to.name())
}

/// What fits beside a contract: coordinators that can lead it, what shares its command, and what
/// gives it a signal.
fn neighbours(entry: &Entry, entries: &[Entry], machines: &[Machine]) -> String {
    let mut text = String::new();
    let own = machines
        .iter()
        .filter(|machine| machine.uses.contains(&entry.contract.name));
    let own: Vec<String> = own
        .map(|machine| format!("`{}` (`import {}`)", machine.name, import(&machine.place)))
        .collect();
    if !own.is_empty() {
        let _ = writeln!(
            text,
            "Machines of the library that use it: {}.\n",
            own.join(", ")
        );
    }
    if let Some(done) = entry.done()
        && entry.has("input", "requested", "bool")
        && entry.group() != "coordination"
    {
        let leads = |other: &&Entry| {
            other.has("output", "command", "bool") && other.has("input", "executed", "bool")
        };
        for other in entries.iter().filter(leads) {
            let _ = writeln!(text, "{} can lead it:\n", link(entry, other));
            let wires = [(entry, "requested", "command"), (entry, done, "executed")];
            text.push_str(&fits(other, entry, &wires));
            text.push('\n');
        }
    }
    let shares = |other: &&Entry| {
        other.place != entry.place
            && entry.has("input", "command", "Command")
            && other.has("input", "command", "Command")
    };
    let partners: Vec<&Entry> = entries.iter().filter(shares).collect();
    if let Some(first) = partners.first() {
        let links: Vec<String> = partners.iter().map(|other| link(entry, other)).collect();
        let _ = writeln!(
            text,
            "It shares `command` with the other actions of a manipulator: {}. For example:\n",
            links.join(", ")
        );
        text.push_str(&fits(entry, first, &[]));
        text.push('\n');
    }
    let clamps = |other: &&Entry| other.place == "handling/clamp";
    if entry.has("input", "clamped", "bool")
        && let Some(clamp) = entries.iter().find(clamps)
    {
        let _ = writeln!(text, "{} gives it `clamped`:\n", link(entry, clamp));
        let wires = [(clamp, "clamp_done", "clamped")];
        text.push_str(&fits(clamp, entry, &wires));
        text.push('\n');
    }
    text
}

fn page(entry: &Entry, entries: &[Entry], machines: &[Machine], by_phase: bool) -> String {
    let contract = &entry.contract;
    let mut text = format!("# `{}`\n\n", entry.name());
    let _ = writeln!(text, "`import {}`\n", import(&entry.place));
    for code in &contract.codes {
        let term = taxonomy::find(&code.text).map_or("", |entry| &entry.english);
        let _ = writeln!(text, "Implements `{}`: {term}.\n", code.text);
    }
    let _ = writeln!(text, "{}", entry.comment());
    let parameters = entry.parameters();
    if !parameters.is_empty() {
        text.push_str("## Parameters\n\n| parameter | range | default |\n|---|---|---|\n");
        for (name, range, default) in parameters {
            let _ = writeln!(text, "| `{name}` | `{range}` | `{default}` |");
        }
        text.push('\n');
    }
    text.push_str("## Interface\n\n| | signal | values |\n|---|---|---|\n");
    for (kind, names, domain) in entry.signals() {
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(text, "| {kind} | {} | `{domain}` |", names.join(", "));
    }
    let stem = entry.stem();
    let (command, drawn) = if by_phase {
        let drawn = "The phases of its controller, and which may follow which";
        (" --by phase", drawn)
    } else {
        ("", "The states of its controller")
    };
    let file = entry.file();
    let _ = writeln!(
        text,
        "\n## States\n\n{drawn} (`linewright draw {file}{command}`):\n\n![{drawn}]({stem}.svg)\n"
    );
    let _ = writeln!(
        text,
        "## A good cycle\n\nThe first part of its script, `contracts/{}.step`:\n\n![Timing diagram of a good cycle]({stem}.cycle.svg)\n",
        entry.place
    );
    let neighbours = neighbours(entry, entries, machines);
    if !neighbours.is_empty() {
        let _ = write!(text, "## What fits beside it\n\n{neighbours}");
    }
    let start = entry.text.find("contract ").expect("a contract");
    let start = entry.text[..start].rfind('\n').map_or(0, |end| end + 1);
    let _ = write!(text, "## Text\n\n```text\n{}```\n", &entry.text[start..]);
    text
}

/// The summaries in the tables of `contracts/README.md`: for each heading, the rows below it with
/// the import and what the contract does.
fn summaries() -> Vec<(String, BTreeMap<String, String>)> {
    let readme = support::root().join("contracts/README.md");
    let readme = std::fs::read_to_string(readme).expect("a text");
    let mut found: Vec<(String, BTreeMap<String, String>)> = Vec::new();
    for line in readme.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            found.push((heading.to_owned(), BTreeMap::new()));
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        if let ([_, _, import, summary, _], Some((_, rows))) = (cells.as_slice(), found.last_mut())
            && let Some(import) = import.strip_prefix("`std.")
        {
            let place = import.trim_end_matches('`').replace('.', "/");
            rows.insert(place, (*summary).to_owned());
        }
    }
    found.retain(|(_, rows)| !rows.is_empty());
    found
}

/// The page of a group: its contracts and its machines.
fn group_page(
    heading: &str,
    rows: &BTreeMap<String, String>,
    entries: &[Entry],
    machines: &[&Machine],
) -> String {
    let mut text = format!("# {heading}\n\n| contract | what it does |\n|---|---|\n");
    for (place, summary) in rows {
        if let Some(entry) = entries.iter().find(|entry| entry.place == *place) {
            let (name, stem) = (entry.name(), entry.stem());
            let _ = writeln!(text, "| [`{name}`]({stem}.md) | {summary} |");
        }
    }
    if !machines.is_empty() {
        text.push_str("\n## Machines\n\n| machine | import | what it is |\n|---|---|---|\n");
        for machine in machines {
            let (name, summary) = (&machine.name, &machine.summary);
            let _ = writeln!(
                text,
                "| `{name}` | `{}` | {summary} |",
                import(&machine.place)
            );
        }
    }
    text
}

const FIRST_PAGE: &str = "\
# The library

The program has a library of contracts of manufacturing actions. Each has a page here, with its text,
its interface, the states of its controller, a good cycle as a timing diagram, and contracts that fit
beside it. The page of a group lists its machines, too. `linewright din search WORD` finds the code of
a process, and `linewright din coverage` the contracts for each code.

";

/// All that `docs/library` has to contain, by paths within it, and the part of the book's table of
/// contents.
fn catalogue() -> (BTreeMap<PathBuf, String>, String) {
    let texts = texts();
    let (entries, machines) = (entries(&texts), machines(&texts));
    let pages = entries.par_iter().flat_map(|entry| {
        let (states, by_phase) = states(entry);
        let cycle = cycle(entry);
        for drawing in [&states, &cycle] {
            assert_eq!(Drawing::read(drawing).faults(), [""; 0], "{}", entry.place);
        }
        let page = page(entry, &entries, &machines, by_phase);
        let path = |ending: &str| PathBuf::from(format!("{}{ending}", entry.place));
        [
            (path(".md"), page),
            (path(".svg"), states),
            (path(".cycle.svg"), cycle),
        ]
    });
    let mut files: BTreeMap<PathBuf, String> = pages.collect();
    let mut first = FIRST_PAGE.to_owned();
    let mut contents = "- [The library](library/index.md)\n".to_owned();
    for (heading, rows) in summaries() {
        let Some(group) = rows.keys().find_map(|place| place.split('/').next()) else {
            continue;
        };
        let belongs = |machine: &&Machine| machine.place.split('/').next() == Some(group);
        let group_machines: Vec<&Machine> = machines.iter().filter(belongs).collect();
        let page = group_page(&heading, &rows, &entries, &group_machines);
        files.insert(PathBuf::from(format!("{group}/index.md")), page);
        let own = entries.iter().filter(|entry| entry.group() == group);
        let own: Vec<&Entry> = own.collect();
        let _ = writeln!(
            first,
            "- [{heading}]({group}/index.md): {} contracts",
            own.len()
        );
        let _ = writeln!(contents, "  - [{heading}](library/{group}/index.md)");
        for entry in own {
            let _ = writeln!(
                contents,
                "    - [{}](library/{}.md)",
                entry.name(),
                entry.place
            );
        }
    }
    files.insert(PathBuf::from("index.md"), first);
    (files, contents)
}

#[test]
fn the_catalogue_is_up_to_date() {
    let (files, contents) = catalogue();
    let docs = support::root().join("docs");
    let folder = docs.join("library");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).expect("a text");
    let start = summary
        .find("- [The library]")
        .expect("a part for the library");
    let end = summary[start..]
        .find("\n\n")
        .map_or(summary.len(), |end| start + end + 1);
    let wanted = format!("{}{contents}{}", &summary[..start], &summary[end..]);
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        let _ = std::fs::remove_dir_all(&folder);
        for (path, text) in &files {
            let path = folder.join(path);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("the page can be written");
        }
        std::fs::write(docs.join("SUMMARY.md"), &wanted).expect("the page can be written");
    }
    let mut stale = Vec::new();
    for (path, text) in &files {
        let written = std::fs::read_to_string(folder.join(path)).unwrap_or_default();
        if written != *text {
            stale.push(path.display().to_string());
        }
    }
    for path in files_below(&folder, &["md", "svg"]) {
        let path = path.strip_prefix(&folder).expect("it is below the folder");
        if !files.contains_key(path) {
            stale.push(format!("{} is not generated", path.display()));
        }
    }
    if std::fs::read_to_string(docs.join("SUMMARY.md")).expect("a text") != wanted {
        stale.push("../SUMMARY.md".to_owned());
    }
    assert!(
        stale.is_empty(),
        "not what is generated in docs/library: {stale:?}; run INSTA_UPDATE=always cargo test --test program -- catalogue"
    );
}

/// Each file of the library can be imported by its name.
#[test]
fn each_import_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for place in texts().keys() {
        let path = folder.path().join("import.lw");
        std::fs::write(&path, format!("import {}\n", import(place))).expect("a file");
        let (_, findings) = loaded(&path);
        assert!(findings.is_empty(), "{place}: {findings:?}");
    }
}
