//! Dependencies as stated in ARCHITECTURE.md. Cargo excludes cycles; this lists the dependencies
//! that each crate may have, and within a crate of several modules the order in which these may
//! import each other. Sources are read as text; comments and strings do not count.

use super::support::files_below;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The crates below the command line with the crates that each uses.
const CRATES: [(&str, &[&str]); 14] = [
    ("core", &[]),
    ("recipe", &[]),
    ("b2mml", &["recipe"]),
    ("automata", &["core"]),
    ("syntax", &["core"]),
    ("language", &["automata", "core", "recipe", "syntax"]),
    ("interchange", &["automata", "core", "syntax"]),
    ("solver", &["core"]),
    ("algebra", &["core", "language", "solver"]),
    ("station", &["algebra", "core", "language", "solver"]),
    (
        "line",
        &["algebra", "core", "language", "solver", "station"],
    ),
    ("report", &["core", "language", "line", "solver"]),
    ("log", &["language", "line"]),
    (
        "engine",
        &[
            "algebra",
            "b2mml",
            "core",
            "interchange",
            "language",
            "line",
            "recipe",
            "solver",
            "station",
        ],
    ),
];

/// Crates of several modules, where a module may use those before it.
const ORDER: [(&str, &[&str]); 4] = [
    (
        "core",
        &[
            "deadline",
            "source",
            "diagnostics",
            "drawing",
            "rename",
            "taxonomy",
            "gr1",
        ],
    ),
    (
        "automata",
        &[
            "bound",
            "search",
            "partition",
            "dfa",
            "regex",
            "eliminate",
            "symbolic",
            "derivative",
            "antichain",
            "ltl",
        ],
    ),
    ("language", &["order", "contract"]),
    ("solver", &["symbolic", "game", "mealy"]),
];

/// Files below the first may not name the second, though its crate is available; the third are
/// exceptions.
const FORBIDDEN: [(&str, &str, &[&str]); 3] = [
    // Code that prints Linewright's language needs its words.
    (
        "crates/interchange/src",
        "linewright_syntax",
        &["crates/interchange/src/contract.rs"],
    ),
    // A play uses formulas and controllers, whatever language they came from.
    ("crates/engine/src/play", "linewright_language", &[]),
    ("crates/solver/src/mealy", "biodivine_lib_bdd", &[]),
];

/// Packages that only these crates may use.
const CONFINED: [(&str, &[&str]); 4] = [
    ("biodivine-lib-bdd", &["solver"]),
    ("pest", &["syntax"]),
    ("libloading", &["station"]),
    ("minijinja", &["station"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Violations in the imports of one file, whose path is relative to the root.
fn violations(path: &Path, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let code = without_comments_and_strings(text);
    for (folder, name, except) in FORBIDDEN {
        let excepted = except.iter().any(|file| path == Path::new(file));
        if path.starts_with(folder) && !excepted && identifiers(&code).any(|word| word == name) {
            found.push(format!("{}: may not use `{name}`", path.display()));
        }
    }
    for (name, order) in ORDER {
        let Ok(inner) = path.strip_prefix(format!("crates/{name}/src")) else {
            continue;
        };
        if inner == Path::new("lib.rs") {
            continue;
        }
        let module = module_of(inner);
        let Some(place) = order.iter().position(|m| *m == module) else {
            let message = format!("{}: `{module}` has no place in the order", path.display());
            found.push(message);
            continue;
        };
        for used in used_modules(inner, &code) {
            if order[place + 1..].contains(&used.as_str()) {
                let message = format!("{}: `{module}` may not use `{used}`", path.display());
                found.push(message);
            }
        }
    }
    found
}

fn module_of(path: &Path) -> String {
    let first = path.iter().next().unwrap_or_default().to_string_lossy();
    first.strip_suffix(".rs").unwrap_or(&first).to_owned()
}

/// The first names after `crate::`, and after as many `super::` as lead to the root of the crate.
fn used_modules(path: &Path, code: &str) -> Vec<String> {
    let mut used = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let before = code[..at].chars().next_back();
        if before.is_none_or(|c| !c.is_alphanumeric() && c != '_') {
            used.extend(names(&code[at + "crate::".len()..]));
        }
    }
    // `super` in an inner module counts from there; only unindented code certainly belongs to the
    // file itself.
    let depth = path.iter().count() - usize::from(path.ends_with("mod.rs"));
    for line_start in std::iter::once(0).chain(code.match_indices('\n').map(|(i, _)| i + 1)) {
        let line = &code[line_start..];
        let line = line.strip_prefix("pub ").unwrap_or(line);
        let Some(mut rest) = line.strip_prefix("use ") else {
            continue;
        };
        let mut supers = 0;
        while let Some(inner) = rest.strip_prefix("super::") {
            supers += 1;
            rest = inner;
        }
        if supers == depth {
            used.extend(names(rest));
        }
    }
    used
}

/// The first name of a path, or the first name of each in braces.
fn names(rest: &str) -> Vec<String> {
    let word = |s: &str| -> String {
        let s = s.trim_start();
        s.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let Some(group) = rest.trim_start().strip_prefix('{') else {
        return vec![word(rest)];
    };
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                found.push(word(&group[start..i]));
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                found.push(word(&group[start..i]));
                start = i + 1;
            }
            _ => {}
        }
    }
    found
}

/// The text with comments and the content of strings blanked; lines keep their numbers.
fn without_comments_and_strings(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = raw_string(rest) {
            length
        } else if c == '"' {
            let mut escaped = false;
            let end = rest[1..].find(|c: char| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            });
            end.map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("'\"'") || rest.starts_with("'\\\"'") {
            rest[1..].find('\'').map_or(1, |end| end + 2)
        } else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        code.extend(rest[..length].chars().filter(|c| *c == '\n'));
        rest = &rest[length..];
    }
    code
}

/// The length of a raw string `r"..."` or `r#"..."#` at the beginning of the text.
fn raw_string(text: &str) -> Option<usize> {
    let inner = text.strip_prefix('r')?;
    let hashes = inner.len() - inner.trim_start_matches('#').len();
    inner[hashes..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(hashes));
    let open = 1 + hashes + 1;
    text[open..].find(&end).map(|at| open + at + end.len())
}

/// The dependencies of a manifest, without those of tests.
fn dependencies(manifest: &str) -> Vec<&str> {
    let section = manifest
        .split("\n[")
        .find(|s| s.starts_with("dependencies]"));
    let lines = section.unwrap_or_default().lines().skip(1);
    lines
        .filter_map(|l| l.split_once('.').map(|(name, _)| name))
        .collect()
}

#[test]
fn crates_use_what_they_may() {
    let mut folders: Vec<String> = std::fs::read_dir(root().join("crates"))
        .expect("a folder")
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    folders.sort();
    let mut known = CRATES.map(|(name, _)| name);
    known.sort_unstable();
    assert_eq!(folders, known);
    for (name, allowed) in CRATES {
        let manifest = root().join("crates").join(name).join("Cargo.toml");
        let manifest = std::fs::read_to_string(manifest).expect("a text");
        let all = dependencies(&manifest);
        let ours: Vec<&str> = all
            .iter()
            .filter_map(|d| d.strip_prefix("linewright-"))
            .collect();
        assert_eq!(ours, allowed, "{name}");
        for (package, crates) in CONFINED {
            assert!(
                !all.contains(&package) || crates.contains(&name),
                "`{name}` may not use `{package}`"
            );
        }
    }
}

/// The sources of the program and of its crates, as paths relative to the root.
fn all_sources() -> Vec<PathBuf> {
    let mut files = files_below(&root().join("src"), &["rs"]);
    for (name, _) in CRATES {
        let folder = root().join("crates").join(name).join("src");
        files.extend(files_below(&folder, &["rs"]));
    }
    let relative = |f: PathBuf| f.strip_prefix(root()).expect("it lies within").to_owned();
    files.into_iter().map(relative).collect()
}

#[test]
fn modules_use_only_those_before_them() {
    let files = all_sources();
    let mut report = String::new();
    for path in &files {
        let text = std::fs::read_to_string(root().join(path)).expect("sources are UTF-8");
        for violation in violations(path, &text) {
            let _ = writeln!(report, "{violation}");
        }
    }
    assert!(files.len() > 400, "only {} files were found", files.len());
    assert!(report.is_empty(), "{report}");
}

/// Files that may use clocks, and the reason why none of them determines a verdict, a finding or a
/// table.
const CLOCKS: [(&str, &str); 15] = [
    ("crates/core/src/deadline.rs", "`--timeout`"),
    ("src/cli/options.rs", "when a command began"),
    ("crates/solver/src/game/set_up.rs", "seconds for `--stats`"),
    ("crates/solver/src/game/solver.rs", "seconds for `--stats`"),
    ("crates/engine/src/controller.rs", "seconds for `--stats`"),
    (
        "crates/engine/src/pipeline/announce.rs",
        "announcements on standard error",
    ),
    (
        "crates/engine/src/pipeline/task.rs",
        "seconds for the summary",
    ),
    ("crates/engine/src/simulation.rs", "seconds for the summary"),
    ("crates/engine/src/worker.rs", "a test of it"),
    ("crates/solver/src/symbolic/tests.rs", "tests of it"),
    (
        "crates/station/src/toolchain/trial.rs",
        "a compiler that hangs",
    ),
    (
        "crates/station/src/toolchain/work.rs",
        "which folders of killed builds are old",
    ),
    ("crates/engine/src/cache.rs", "which files are oldest"),
    ("src/cli/check/watch.rs", "when a file was changed"),
    ("src/cli/run/progress.rs", "how often a line is drawn"),
];

/// The code that watches files independently.
const WATCHES: &str = "src/cli/check/watch/";

/// Constructs with parallel threads in which the first result could determine the outcome.
const RACES: [&str; 5] = [
    "find_any",
    "find_map_any",
    "position_any",
    "try_for_each",
    "try_reduce",
];

/// The words of a source that are names.
fn identifiers(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !c.is_alphanumeric() && c != '_')
}

/// Proofs count their work, so that a verdict does not depend on the load of the computer. A clock
/// is read only for `--timeout`, for files, or to report durations.
#[test]
fn no_clock_and_no_race_decides() {
    let mut report = String::new();
    let mut with_clocks = Vec::new();
    for file in all_sources() {
        let path = file.to_string_lossy().replace('\\', "/");
        let text = std::fs::read_to_string(root().join(&file)).expect("sources are UTF-8");
        let code = without_comments_and_strings(&text);
        let clocks = ["Instant", "SystemTime", "Duration"];
        if identifiers(&code).any(|word| clocks.contains(&word)) {
            let known = CLOCKS.iter().any(|(known, _)| *known == path);
            if !known && !path.starts_with(WATCHES) {
                let _ = writeln!(report, "{path}: a clock; count work instead (`Budget`)");
            }
            with_clocks.push(path.clone());
        }
        let parallel = identifiers(&code).any(|word| word == "rayon");
        let races = identifiers(&code).filter(|word| parallel && RACES.contains(word));
        for word in races {
            let _ = writeln!(report, "{path}: `{word}`: which thread is first decides");
        }
    }
    for (known, _) in CLOCKS {
        if !with_clocks.iter().any(|path| path == known) {
            let _ = writeln!(report, "{known} has no clock any more");
        }
    }
    assert!(report.is_empty(), "{report}");
}

/// The checker itself: each of these must be found.
#[test]
fn violations_are_found() {
    for (path, text, wanted) in [
        (
            "crates/language/src/order/mod.rs",
            "use crate::contract::Library;",
            "`order` may not use `contract`",
        ),
        (
            "crates/solver/src/game/solve.rs",
            "fn f(x: crate::mealy::Machine) {}",
            "`game` may not use `mealy`",
        ),
        (
            "crates/core/src/drawing/svg.rs",
            "use crate::{\n    source::{FileId, Span},\n    gr1,\n};",
            "`drawing` may not use `gr1`",
        ),
        (
            "crates/core/src/source/mod.rs",
            "use super::diagnostics::Code;",
            "`source` may not use `diagnostics`",
        ),
        (
            "crates/solver/src/game/a/b.rs",
            "pub use super::super::super::mealy;",
            "`game` may not use `mealy`",
        ),
        (
            "crates/engine/src/play/mod.rs",
            "use linewright_language::contract;",
            "may not use `linewright_language`",
        ),
        (
            "crates/core/src/new/mod.rs",
            "",
            "`new` has no place in the order",
        ),
        (
            "crates/core/src/source/mod.rs",
            "const Q: char = '\"'; use crate::gr1; // \"",
            "`source` may not use `gr1`",
        ),
    ] {
        let found = violations(Path::new(path), text);
        assert_eq!(found.len(), 1, "{path}: {text}: {found:?}");
        assert!(found[0].ends_with(wanted), "{found:?}");
    }
}

#[test]
fn what_is_allowed_is_not_found() {
    for (path, text) in [
        (
            "src/cli/mod.rs",
            "use crate::{contract, game::Limits, line};",
        ),
        (
            "crates/solver/src/game/mod.rs",
            "use crate::symbolic::Kernel;\nuse biodivine_lib_bdd::Bdd;",
        ),
        (
            "crates/core/src/source/mod.rs",
            "//! See [`crate::gr1`].\n/* crate::gr1 */ const T: &str = \"crate::gr1\";",
        ),
        (
            "crates/core/src/source/mod.rs",
            "const T: &str = r#\"crate::gr1 \"quoted\" crate::taxonomy\"#;",
        ),
        (
            "crates/language/src/order/rule.rs",
            "mod tests { use super::super::contract; }",
        ),
        (
            "crates/core/src/gr1/mod.rs",
            "macro_rules! m { () => { $crate::gr1 } }",
        ),
    ] {
        assert_eq!(
            violations(Path::new(path), text),
            Vec::<String>::new(),
            "{text}"
        );
    }
}

/// Everything at the root is named in the README, so that no scratch file stays there.
#[test]
fn what_lies_at_the_root_is_named() {
    let read = |name: &str| std::fs::read_to_string(root().join(name)).expect("a text");
    let texts = [read("README.md"), read("CONTRIBUTING.md")];
    let entries = std::fs::read_dir(root()).expect("a folder");
    let mut unnamed = Vec::new();
    for entry in entries.map(|e| e.expect("an entry")) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = entry.path().is_dir();
        let named = [
            format!("`{name}`"),
            format!("({name})"),
            format!("`{name}/`"),
        ];
        // Folders outside the repository vary: `target`, an editor's, a user's.
        let is_ours = !name.starts_with('.') && !is_folder && name != "README.md";
        let is_named = |text: &String| named.iter().any(|n| text.contains(n));
        if is_ours && !texts.iter().any(is_named) {
            unnamed.push(name);
        }
    }
    assert!(
        unnamed.is_empty(),
        "neither README.md nor CONTRIBUTING.md names {unnamed:?}"
    );
}
