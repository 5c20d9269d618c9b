//! Inputs to damage: a copy of all files in the tree that the program reads, in the folders that
//! imports expect.

use crate::support;
use std::path::{Path, PathBuf};

/// Extensions of files that the program reads.
const ENDINGS: [&str; 6] = ["lw", "spc", "slugsin", "structuredslugs", "spectra", "tlsf"];
/// Maximum size of files: longer ones take time in a solver, and no other path through the readers.
const MOST_BYTES: usize = 24_000;

/// An initial file.
pub struct Seed {
    /// Path of the copy, relative to the copied tree.
    pub path: PathBuf,
    pub text: String,
}

impl Seed {
    pub fn is_foreign(&self) -> bool {
        self.path.extension().is_none_or(|e| e != "lw")
    }

    /// The names declared with a word such as `machine`.
    pub fn declared(text: &str, word: &str) -> Vec<String> {
        let lines = text.lines().map(str::trim_start);
        let after = lines.filter_map(|l| {
            let l = l.strip_prefix("moore ").unwrap_or(l);
            l.strip_prefix(word)?.strip_prefix(' ')
        });
        let name = |rest: &str| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect::<String>()
        };
        after.map(name).filter(|n| !n.is_empty()).collect()
    }
}

/// Copies contracts, examples, cases, the snippets of the README and `../shared/found` (if it
/// exists) below `tree`, and returns them.
pub fn copied_to(tree: &Path) -> Vec<Seed> {
    let root = support::root();
    let mut seeds = Vec::new();
    for folder in [
        "contracts",
        "examples",
        "tests/cases",
        "tests/fixtures",
        "tests/interchange/spectra",
        "tests/interchange/tlsf",
    ] {
        collect(&root.join(folder), Path::new(folder), &mut seeds);
    }
    let found = support::found();
    if let Some(found) = found {
        collect(&found, Path::new("found"), &mut seeds);
    }
    for (name, text) in snippets(&root.join("README.md")) {
        let path = Path::new("readme").join(name);
        seeds.push(Seed { path, text });
    }
    seeds.sort_by(|a, b| a.path.cmp(&b.path));
    for seed in &seeds {
        let path = tree.join(&seed.path);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(&path, &seed.text).expect("a copy");
    }
    seeds.retain(|s| s.text.len() <= MOST_BYTES);
    seeds
}

fn collect(folder: &Path, name: &Path, seeds: &mut Vec<Seed>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let Some(file) = path.file_name() else {
            continue;
        };
        if path.is_dir() {
            collect(&path, &name.join(file), seeds);
        } else if path
            .extension()
            .is_some_and(|e| ENDINGS.iter().any(|known| e == *known))
            && let Ok(text) = std::fs::read_to_string(&path)
        {
            let path = name.join(file);
            seeds.push(Seed { path, text });
        }
    }
}

/// The blocks of a text that are files: ```` ```lw name.lw ````.
fn snippets(path: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(path).expect("the README");
    let mut found: Vec<(String, String)> = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if inside && line == "```" {
            inside = false;
        } else if inside {
            let (_, block) = found.last_mut().expect("a block");
            block.push_str(line);
            block.push('\n');
        } else if let Some(name) = line.strip_prefix("```lw") {
            inside = true;
            let name = name.trim();
            let name = if name.is_empty() {
                format!("block{}.lw", found.len())
            } else {
                name.replace('/', "_")
            };
            found.push((name, String::new()));
        }
    }
    found
}
