//! The book in `docs`: every page is in its table of contents, every link leads somewhere, every
//! construct of the grammar has a section, and what is generated is up to date
//! (`INSTA_UPDATE=always` writes it anew).

use super::support;
use super::support::files_below;
use clap::{Command, CommandFactory as _};
use linewright::diagnostics::{codes, explanations};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The pages of the book, relative to `docs`.
fn pages() -> BTreeSet<PathBuf> {
    let docs = root().join("docs");
    let files = files_below(&docs, &["md"]);
    let relative = files.iter().filter_map(|f| f.strip_prefix(&docs).ok());
    relative.map(Path::to_owned).collect()
}

/// The targets of links and images outside of code, with the number of their line.
fn links(text: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        fenced ^= line.trim_start().starts_with("```");
        if fenced {
            continue;
        }
        let without_code = line.split('`').step_by(2);
        for piece in without_code.flat_map(|text| text.split("](").skip(1)) {
            found.extend(piece.split_once(')').map(|(target, _)| (number, target)));
        }
    }
    found
}

/// The anchors of a page's headings, as the code host and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut fenced = false;
    let mut found = BTreeSet::new();
    for line in text.lines() {
        fenced ^= line.trim_start().starts_with("```");
        let heading = line.trim_start_matches('#');
        if fenced || heading.len() == line.len() {
            continue;
        }
        let words = heading.trim().to_lowercase();
        let kept = words.chars().filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        });
        found.insert(kept.collect());
    }
    found
}

#[test]
fn the_table_of_contents_is_complete() {
    let summary = read(&root().join("docs/SUMMARY.md"));
    let listed: BTreeSet<PathBuf> = links(&summary)
        .into_iter()
        .map(|(_, target)| PathBuf::from(target))
        .collect();
    let mut pages = pages();
    pages.remove(Path::new("SUMMARY.md"));
    assert_eq!(listed, pages);
}

/// The words of a report are explained, although they are no constructs: by the tables of the
/// constructs that they belong to.
#[test]
fn the_words_of_a_report_are_explained() {
    for (word, construct) in [
        ("lead_time", "requirement"),
        ("throughput", "requirement"),
        ("busy", "requirement"),
        ("busy", "station"),
        ("blocked", "station"),
        ("starved", "station"),
    ] {
        let output = support::linewright(root(), &["explain", word]);
        assert!(output.status.success(), "{word}");
        let heading = format!("## `{construct}`");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains(&heading), "{word}: {text}");
    }
}

/// The tables in `contracts/README.md` list every contract and every machine of the library with
/// its import.
#[test]
fn the_table_of_the_library_is_complete() {
    let folder = root().join("contracts");
    let table = read(&folder.join("README.md"));
    let listed: BTreeSet<(String, String)> = table
        .lines()
        .filter_map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let name = cells.get(1)?.strip_prefix('`')?.strip_suffix('`')?;
            let import = cells.get(2)?.strip_prefix('`')?.strip_suffix('`')?;
            Some((name.to_owned(), import.to_owned()))
        })
        .collect();
    let mut declared = BTreeSet::new();
    for path in files_below(&folder, &["lw"]) {
        let place = path.strip_prefix(&folder).expect("it is below the folder");
        let place = place.with_extension("");
        let parts = place.iter().map(|part| part.to_string_lossy());
        let import = parts.fold("std".to_owned(), |all, part| format!("{all}.{part}"));
        let text = read(&path);
        let mut add = |keyword: &str| {
            let lines = text.lines();
            let lines = lines.map(|line| line.strip_prefix("moore ").unwrap_or(line));
            for rest in lines.filter_map(|line| line.strip_prefix(keyword)) {
                let name = rest.split(|c: char| !c.is_alphanumeric()).next();
                declared.insert((name.unwrap_or_default().to_owned(), import.clone()));
            }
        };
        // Other contracts in the file of a machine simulate its plant.
        if text.lines().any(|line| line.starts_with("machine ")) {
            add("machine ");
        } else {
            add("contract ");
        }
    }
    assert_eq!(listed, declared);
}

#[test]
fn no_link_is_dead() {
    let mut dead = String::new();
    let book = root().join("docs").canonicalize().expect("docs");
    let mut texts = files_below(&book, &["md"]);
    texts.extend(support::files_named("README.md"));
    texts.extend(["ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|f| root().join(f)));
    for path in texts {
        let text = read(&path);
        for (line, target) in links(&text) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let to = if file.is_empty() {
                path.clone()
            } else {
                path.parent().expect("a folder").join(file)
            };
            // The book has no pages of other folders, so such a link would be dead in its HTML.
            let leaves_the_book =
                path.starts_with(&book) && !to.canonicalize().is_ok_and(|to| to.starts_with(&book));
            let is_page = to.extension().is_some_and(|e| e == "md");
            let lives = to.exists()
                && !leaves_the_book
                && (anchor.is_empty() || !is_page || anchors(&read(&to)).contains(anchor));
            if !lives {
                let _ = writeln!(dead, "{}:{line}: {target}", path.display());
            }
        }
    }
    assert!(dead.is_empty(), "{dead}");
}

/// Compares a generated page, or writes it where `INSTA_UPDATE` says so.
fn is_up_to_date(page: &str, text: &str) {
    let path = root().join("docs/reference").join(page);
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(&path, text).expect("the page can be written");
    }
    assert!(
        read(&path) == text,
        "docs/reference/{page} is not what is generated: run INSTA_UPDATE=always cargo test --test program -- book"
    );
}

#[test]
fn the_commands_are_up_to_date() {
    fn page(command: &Command, name: &str, level: usize, text: &mut String) {
        let mut shown = command
            .clone()
            .bin_name(name.to_owned())
            .term_width(100)
            .color(clap::ColorChoice::Never);
        // What every command takes is said once.
        for global in linewright::cli::Arguments::command().get_arguments() {
            let id = global.get_id().clone();
            if name != "linewright" && shown.get_arguments().any(|a| *a.get_id() == id) {
                shown = shown.mut_arg(id, |argument| argument.hide(true));
            }
        }
        let help = shown.render_long_help().to_string();
        let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
        let help = lines.join("\n");
        let marks = "#".repeat(level);
        let _ = write!(
            text,
            "{marks} `{name}`\n\n```text\n{}\n```\n\n",
            help.trim_end()
        );
        for subcommand in command.get_subcommands().filter(|c| c.get_name() != "help") {
            let name = format!("{name} {}", subcommand.get_name());
            page(subcommand, &name, 2, text);
        }
    }
    let mut text = "# Commands\n\nGenerated from the program's help. Options that every command \
                    takes are listed once, under `linewright`.\n\n"
        .to_owned();
    page(
        &linewright::cli::Arguments::command(),
        "linewright",
        2,
        &mut text,
    );
    is_up_to_date("commands.md", &format!("{}\n", text.trim_end()));
}

#[test]
fn the_findings_are_up_to_date() {
    let mut index =
        "# Findings\n\nGenerated from the program. `linewright explain LW203` prints the \
                     page of a finding in the terminal.\n"
            .to_owned();
    for group in codes::GROUPS {
        let file = format!("findings/{}.md", group.pattern);
        let _ = write!(index, "\n## {}: {}\n\n", group.pattern, group.title);
        index.push_str("| code | finding |\n|---|---|\n");
        let mut text = format!("# {}: {}\n", group.pattern, group.title);
        for code in group.codes() {
            let _ = writeln!(index, "| [{}]({file}) | {} |", code.id, code.title);
            text.push('\n');
            let mut fenced = false;
            for line in explanations::page(code).expect("a page").lines() {
                fenced ^= line.starts_with("```");
                let mark = if line.starts_with('#') && !fenced {
                    "#"
                } else {
                    ""
                };
                let _ = writeln!(text, "{mark}{line}");
            }
        }
        is_up_to_date(&file, &text);
    }
    is_up_to_date("findings.md", &index);
}

/// The type of a schema in a few words.
fn type_of(schema: &serde_json::Value) -> String {
    let alternatives = schema["anyOf"].as_array().or(schema["oneOf"].as_array());
    if let Some(reference) = schema["$ref"].as_str() {
        let name = reference.rsplit('/').next().unwrap_or_default();
        format!("[`{name}`](#{})", name.to_lowercase())
    } else if let Some(value) = schema.get("const") {
        format!("`{value}`")
    } else if let Some(alternatives) = alternatives {
        let types: BTreeSet<String> = alternatives.iter().map(type_of).collect();
        types.into_iter().collect::<Vec<_>>().join(" or ")
    } else if schema["type"] == "array" {
        format!("array of {}", type_of(&schema["items"]))
    } else if let Some(types) = schema["type"].as_array() {
        let types: Vec<&str> = types.iter().filter_map(|t| t.as_str()).collect();
        types.join(" or ")
    } else {
        schema["type"].as_str().unwrap_or("any value").to_owned()
    }
}

#[test]
fn the_documents_are_up_to_date() {
    let folder = tempfile::tempdir().expect("a folder");
    let document = |arguments: &[&str]| -> serde_json::Value {
        let output = support::linewright(folder.path(), arguments);
        serde_json::from_slice(&output.stdout).expect("a document")
    };
    let mut text = "# JSON documents\n\nGenerated from the program. A call that is wrong in itself (an \
         unknown option, or a file without the line or machine that the command needs) prints an \
         error on standard error and no document; the exit code is 2. `linewright schema check` prints \
                    the whole JSON Schema (draft 2020-12) of a document. First come the fields of each \
                    document, then the [types](#types) that they use.\n"
        .to_owned();
    let mut types: BTreeMap<String, Vec<serde_json::Value>> = BTreeMap::new();
    let list = document(&["schema", "--format", "json"]);
    for entry in list["schemas"].as_array().expect("schemas") {
        let name = entry["name"].as_str().expect("a name");
        let schema = document(&["schema", name]);
        let _ = write!(
            text,
            "\n## `{name}`\n\n{}.\n",
            entry["title"].as_str().expect("a title")
        );
        let single = [schema.clone()];
        let forms = schema["anyOf"]
            .as_array()
            .map_or(&single[..], Vec::as_slice);
        let mut outermost = Vec::new();
        for (position, form) in forms.iter().enumerate() {
            let form = match form["$ref"].as_str() {
                Some(reference) => {
                    outermost.extend(reference.rsplit('/').next().map(str::to_owned));
                    schema.pointer(&reference[1..]).expect("a definition")
                }
                None => form,
            };
            // The title describes the first form.
            if position > 0 {
                let _ = write!(text, "\n{}\n", one_line(form));
            }
            text.push_str(&table_of_fields(form));
        }
        for (name, definition) in schema["$defs"].as_object().into_iter().flatten() {
            if !outermost.contains(name) {
                let known = types.entry(name.clone()).or_default();
                if !known.contains(definition) {
                    known.push(definition.clone());
                }
            }
        }
    }
    text.push_str("\n## Types\n\nThe types in these tables, in alphabetical order.\n");
    for (name, definitions) in types {
        for definition in definitions {
            let meaning = one_line(&definition);
            let _ = write!(text, "\n### `{name}`\n\n{meaning}\n");
            text.push_str(&table_of_fields(&definition));
            text.push_str(&table_of_values(&definition));
        }
    }
    is_up_to_date("json.md", &without_ambiguous_links(&text));
}

/// Removes links to headings that several types, or a type and a document, share.
fn without_ambiguous_links(text: &str) -> String {
    let mut headings: BTreeMap<String, usize> = BTreeMap::new();
    for line in text.lines().filter(|line| line.starts_with('#')) {
        let name = line.trim_start_matches('#').trim().trim_matches('`');
        *headings.entry(name.to_lowercase()).or_default() += 1;
    }
    let mut text = text.to_owned();
    for (anchor, _) in headings.into_iter().filter(|(_, count)| *count > 1) {
        while let Some(end) = text.find(&format!("`](#{anchor})")) {
            let start = text[..end].rfind("[`").expect("the link's beginning");
            text.replace_range(end + 1..end + anchor.len() + 5, "");
            text.remove(start);
        }
    }
    text
}

/// The description of a schema in one line of a table.
fn one_line(schema: &serde_json::Value) -> String {
    let description = schema["description"].as_str().unwrap_or_default();
    description.replace('\n', " ").replace('|', "\\|")
}

/// The fields of an object as a table; empty for other types.
fn table_of_fields(schema: &serde_json::Value) -> String {
    let Some(fields) = schema["properties"].as_object() else {
        return String::new();
    };
    let mut text = "\n| field | type | meaning |\n|---|---|---|\n".to_owned();
    for (field, schema) in fields {
        let _ = writeln!(
            text,
            "| `{field}` | {} | {} |",
            type_of(schema),
            one_line(schema)
        );
    }
    text
}

/// The values or alternatives of an enumeration as a table; empty for other types.
fn table_of_values(schema: &serde_json::Value) -> String {
    let alternatives = schema["oneOf"].as_array().or(schema["anyOf"].as_array());
    let values = schema["enum"].as_array();
    let mut rows = String::new();
    for alternative in alternatives.into_iter().flatten() {
        if let Some(fields) = alternative["properties"].as_object() {
            for (field, inner) in fields {
                let row = format!("`{{\"{field}\": ...}}`: {}", type_of(inner));
                let _ = writeln!(rows, "| {row} | {} |", one_line(alternative));
            }
        } else {
            let _ = writeln!(
                rows,
                "| {} | {} |",
                type_of(alternative),
                one_line(alternative)
            );
        }
    }
    for value in values.into_iter().flatten() {
        let _ = writeln!(rows, "| `{value}` | |");
    }
    if rows.is_empty() {
        rows
    } else {
        format!("\n| value | meaning |\n|---|---|\n{rows}")
    }
}

/// The rules of a grammar in pest, each as its text without blanks and comments.
fn rules(grammar: &str) -> BTreeMap<String, String> {
    let mut rules: Vec<(String, String)> = Vec::new();
    for line in grammar.lines().filter(|l| !l.starts_with("//")) {
        let head = line.split_once('=').map(|(name, _)| name.trim_end());
        let begins = head.filter(|name| {
            let mut chars = name.chars();
            chars.all(|c| c.is_alphanumeric() || c == '_') && !name.is_empty()
        });
        if let Some(name) = begins {
            rules.push((name.to_owned(), String::new()));
        }
        if let Some((_, text)) = rules.last_mut() {
            text.extend(line.chars().filter(|c| !c.is_whitespace()));
        }
    }
    rules.into_iter().collect()
}

/// Whether a rule only lays text out, reports mistakes, or reads a keyword or a mark.
fn is_auxiliary(rule: &str) -> bool {
    const HELPERS: &str = "WHITESPACE COMMENT end id_start id_rest blank blanks nested piece \
        close_paren close_bracket close_brace open_brace open_bracket arrow dots colon equals \
        comma ampersand item_head item_head_word skills_head item_word skills_word contract_word \
        machine_word line_word component_word station_word layout_head \
        layout_word resource_word transport_word recipe_word state_arrow";
    ["k_", "bad_", "only_"].iter().any(|p| rule.starts_with(p))
        || HELPERS.split_whitespace().any(|helper| helper == rule)
}

#[test]
fn every_construct_has_a_section() {
    let grammar = rules(&read(&root().join("crates/syntax/src/lw.pest")));
    let mut wrong = String::new();
    let mut shown = BTreeSet::new();
    for path in files_below(&root().join("docs/reference/language"), &["md"]) {
        let text = read(&path);
        let blocks = text.split("```pest\n").skip(1);
        let blocks = blocks.filter_map(|b| b.split_once("\n```").map(|(block, _)| block));
        for (name, rule) in blocks.flat_map(rules) {
            if grammar.get(&name) != Some(&rule) {
                let _ = writeln!(wrong, "{}: {name} differs", path.display());
            }
            shown.insert(name);
        }
    }
    for name in grammar.keys() {
        if !shown.contains(name) && !is_auxiliary(name) {
            let _ = writeln!(wrong, "{name} has no section");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn everything_that_is_listed_is_explained() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |arguments: &[&str]| support::linewright(folder.path(), arguments);
    let list = run(&["explain", "--list", "--format", "json"]);
    let list: serde_json::Value = serde_json::from_slice(&list.stdout).expect("a document");
    let mut names: Vec<String> = Vec::new();
    for code in list["codes"].as_array().expect("codes") {
        names.extend(code["code"].as_str().map(str::to_owned));
    }
    for topic in list["topics"].as_array().expect("topics") {
        let name = topic["name"].as_str().expect("a name");
        let spans: Vec<&str> = name.split('`').skip(1).step_by(2).collect();
        names.extend(spans.iter().map(|s| (*s).to_owned()));
        names.extend(spans.is_empty().then(|| name.to_owned()));
    }
    assert!(names.len() > 150, "{}", names.len());
    for name in ["buffer", "shift", "LW408", "check", "order check", "mttr"] {
        names.push(name.to_owned());
    }
    for name in names {
        let output = run(&["explain", "--", &name]);
        assert!(output.status.success(), "{name}");
        assert!(output.stdout.len() > 100, "{name}");
    }
    let unknown = run(&["explain", "bufer"]);
    assert_eq!(unknown.status.code(), Some(2));
    let text = String::from_utf8_lossy(&unknown.stderr);
    assert!(text.contains("did you mean `buffer`?"), "{text}");
}

#[test]
fn links_and_anchors_are_read() {
    let text = "[a](b.md#c) `[no](code)`\n```\n[no](block)\n```\n![x](y.svg)\n";
    assert_eq!(links(text), [(1, "b.md#c"), (5, "y.svg")]);
    let anchors = anchors("# A `b`, c\n## D-e f\n```\n# no\n```\n");
    let wanted = ["a-b-c", "d-e-f"].map(str::to_owned);
    assert_eq!(anchors, BTreeSet::from(wanted));
}
