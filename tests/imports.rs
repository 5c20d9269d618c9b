//! The order of module imports, as ARCHITECTURE.md states it: a module uses only those before it, and some of them not
//! even those. The sources are read as text; comments and strings do not count.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A module may use those before it.
const ORDER: [&str; 19] = [
    "source",
    "diagnostics",
    "drawing",
    "taxonomy",
    "syntax",
    "gr1",
    "interchange",
    "order",
    "contract",
    "symbolic",
    "game",
    "mealy",
    "algebra",
    "play",
    "station",
    "line",
    "report",
    "engine",
    "cli",
];

/// Pairs (module, used module) that the order would allow, and the design does not: the solver side knows only
/// specifications, so that other languages can be put before it, and those know nothing of ours.
const FORBIDDEN: [(&str, &str); 11] = [
    ("gr1", "syntax"),
    ("interchange", "taxonomy"),
    ("interchange", "syntax"),
    ("symbolic", "syntax"),
    ("symbolic", "contract"),
    ("game", "syntax"),
    ("game", "contract"),
    ("mealy", "syntax"),
    ("mealy", "contract"),
    ("play", "syntax"),
    ("play", "contract"),
];

/// Files that may use a module all the same: what prints our language has to know its words.
const EXCEPT: [(&str, &str); 1] = [("interchange/contract.rs", "syntax")];

/// Packages that only these modules may name.
const CONFINED: [(&str, &[&str]); 2] = [
    ("biodivine_lib_bdd", &["symbolic", "game"]),
    ("libloading", &["station"]),
];

/// What is wrong with the imports of one file, whose path is relative to `src`.
fn violations(path: &Path, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let module = module_of(path);
    let Some(place) = ORDER.iter().position(|m| *m == module) else {
        return vec![format!(
            "{}: `{module}` has no place in the order",
            path.display()
        )];
    };
    let code = without_comments_and_strings(text);
    for used in used_modules(path, &code) {
        let Some(other) = ORDER.iter().position(|m| *m == used) else {
            continue;
        };
        let forbidden = FORBIDDEN.contains(&(module.as_str(), used.as_str()))
            && !EXCEPT
                .iter()
                .any(|(file, m)| path == Path::new(file) && used == *m);
        if other > place || forbidden {
            found.push(format!(
                "{}: `{module}` may not use `{used}`",
                path.display()
            ));
        }
    }
    for (package, modules) in CONFINED {
        if code.contains(package) && !modules.contains(&module.as_str()) {
            found.push(format!(
                "{}: `{module}` may not use `{package}`",
                path.display()
            ));
        }
    }
    found
}

fn module_of(path: &Path) -> String {
    let first = path.iter().next().unwrap_or_default().to_string_lossy();
    first.strip_suffix(".rs").unwrap_or(&first).to_owned()
}

/// The first names behind `crate::`, and behind as many `super::` as lead to the root of the crate.
fn used_modules(path: &Path, code: &str) -> Vec<String> {
    let mut used = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let before = code[..at].chars().next_back();
        if before.is_none_or(|c| !c.is_alphanumeric() && c != '_') {
            used.extend(names(&code[at + "crate::".len()..]));
        }
    }
    // `super` in an inner module counts from there; only what stands at the left margin is surely the file's own.
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

/// The text with comments and the inside of strings blanked; lines stay where they are.
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

fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("src can be read") {
        let path = entry.expect("src can be read").path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
}

#[test]
fn modules_use_only_those_before_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut report = String::new();
    let mut seen = 0;
    for file in &files {
        let path = file.strip_prefix(&src).expect("it lies within");
        if path == Path::new("lib.rs") || path == Path::new("main.rs") {
            continue;
        }
        seen += 1;
        let text = std::fs::read_to_string(file).expect("sources are UTF-8");
        for violation in violations(path, &text) {
            let _ = writeln!(report, "{violation}");
        }
    }
    assert!(seen >= ORDER.len(), "only {seen} files were found");
    assert!(report.is_empty(), "{report}");
}

/// Files that may know of clocks, and why none of them decides what a verdict, a finding or a table says.
const CLOCKS: [(&str, &str); 18] = [
    (
        "symbolic/limits.rs",
        "`--timeout`, for everything below `cli`",
    ),
    ("symbolic/tests.rs", "tests of it"),
    ("order/bound.rs", "`--timeout`, for orders of skills"),
    ("line/mod.rs", "`--timeout`, for runs"),
    ("line/plant/mod.rs", "`--timeout`, for runs"),
    ("game/set_up.rs", "seconds for `--stats`"),
    ("game/solver.rs", "seconds for `--stats`"),
    ("station/toolchain/trial.rs", "a compiler that hangs"),
    (
        "station/toolchain/work.rs",
        "which folders of killed builds are old",
    ),
    ("cli/options.rs", "`--timeout` itself"),
    ("engine/worker.rs", "waits for `--timeout` and for Ctrl-C"),
    (
        "engine/pipeline/task.rs",
        "hands `--timeout` on; seconds for the summary",
    ),
    ("engine/controller.rs", "seconds for `--stats`"),
    ("cli/run.rs", "`--timeout`; seconds for the summary"),
    ("cli/build.rs", "`--timeout`, for compilers"),
    ("station/toolchain/mod.rs", "`--timeout`, for compilers"),
    ("engine/cache.rs", "which files are oldest"),
    ("cli/check/watch.rs", "when a file was changed"),
];

/// What looks after files of its own accord.
const WATCHES: &str = "cli/check/watch/";

/// Where threads work side by side, the first one to find something must not decide.
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

/// Proofs count their work, so that a verdict does not depend on how busy the computer is. A clock is only read where it is about
/// `--timeout`, about files or about what took how long.
#[test]
fn no_clock_and_no_race_decides() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut report = String::new();
    let mut with_clocks = Vec::new();
    for file in &files {
        let path = file.strip_prefix(&src).expect("it lies within");
        let path = path.to_string_lossy().replace('\\', "/");
        let text = std::fs::read_to_string(file).expect("sources are UTF-8");
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

#[test]
fn every_module_has_a_place_in_the_order() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    let text = text.expect("src/lib.rs can be read");
    let modules = text.lines().filter_map(|l| l.strip_prefix("pub mod "));
    let mut modules: Vec<&str> = modules.map(|m| m.trim_end_matches(';')).collect();
    let mut order = ORDER.to_vec();
    modules.sort_unstable();
    order.sort_unstable();
    assert_eq!(modules, order);
}

/// The checker itself: each of these must be found.
#[test]
fn violations_are_found() {
    for (path, text, wanted) in [
        (
            "gr1/mod.rs",
            "use crate::contract::Library;",
            "`gr1` may not use `contract`",
        ),
        (
            "gr1/mod.rs",
            "use crate::syntax::Ast;",
            "`gr1` may not use `syntax`",
        ),
        (
            "game/solve.rs",
            "fn f(x: crate::contract::Contract) {}",
            "`game` may not use `contract`",
        ),
        (
            "mealy/svg.rs",
            "use crate::{\n    gr1::{Expr, Domain},\n    syntax,\n};",
            "`mealy` may not use `syntax`",
        ),
        (
            "source/mod.rs",
            "use super::diagnostics::Code;",
            "`source` may not use `diagnostics`",
        ),
        (
            "game/a/b.rs",
            "pub use super::super::super::line;",
            "`game` may not use `line`",
        ),
        (
            "taxonomy.rs",
            "use super::cli::main;",
            "`taxonomy` may not use `cli`",
        ),
        (
            "line/mod.rs",
            "use biodivine_lib_bdd::Bdd;",
            "`line` may not use `biodivine_lib_bdd`",
        ),
        ("new/mod.rs", "", "`new` has no place in the order"),
        (
            "gr1/mod.rs",
            "const Q: char = '\"'; use crate::cli; // \"",
            "`gr1` may not use `cli`",
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
        ("cli/mod.rs", "use crate::{contract, game::Limits, line};"),
        (
            "game/mod.rs",
            "use crate::gr1::Specification;\nuse biodivine_lib_bdd::Bdd;",
        ),
        (
            "gr1/mod.rs",
            "//! See [`crate::contract`].\n/* crate::cli */ const T: &str = \"crate::cli\";",
        ),
        (
            "gr1/mod.rs",
            "const T: &str = r#\"crate::cli \"quoted\" crate::line\"#;",
        ),
        (
            "contract/machine.rs",
            "mod tests { use super::super::line; }",
        ),
        ("gr1/mod.rs", "macro_rules! m { () => { $crate::gr1 } }"),
    ] {
        assert_eq!(
            violations(Path::new(path), text),
            Vec::<String>::new(),
            "{text}"
        );
    }
}

/// Whatever lies at the root is named in the README, so that no scratch file stays there.
#[test]
fn the_readme_names_what_lies_at_the_root() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).expect("a text");
    let entries = std::fs::read_dir(root).expect("a folder");
    let mut unnamed = Vec::new();
    for entry in entries.map(|e| e.expect("an entry")) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = entry.path().is_dir();
        let named = [
            format!("`{name}`"),
            format!("({name})"),
            format!("`{name}/`"),
        ];
        // Folders that are not in the repository come and go: `target`, an editor's, a user's.
        let is_ours = !name.starts_with('.') && !is_folder && name != "README.md";
        if is_ours && !named.iter().any(|n| readme.contains(n)) {
            unnamed.push(name);
        }
    }
    assert!(unnamed.is_empty(), "README.md does not name {unnamed:?}");
}
