//! `FILE[::NAME]`: selects a set of rules, and some of its rules.

use super::Choice;
use super::early_exit::{EarlyExit, Outcome};
use crate::cli::console::schema;
use crate::cli::options::GlobalOptions;
use crate::cli::select::Selection;
use crate::diagnostics::{Diagnostic, nearest};
use crate::engine::files::{self, LoadedFiles};
use crate::order::fsm::MOST_CALLS;
use crate::order::supervisor::Options;
use crate::order::{Level, Skills};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// A set of rules, chosen from a file.
pub struct RuleSelection {
    /// The library loaded with it.
    pub loaded: LoadedFiles,
    /// The skills with the selected rules.
    pub skills: Skills,
    /// Level at which they are kept, and the limits of the command.
    pub options: Options,
}

/// Common head of these commands' documents.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Head {
    schema: String,
    /// The name of the set of skills.
    skills: String,
    /// How much is forbidden.
    #[schemars(extend("enum" = ["arbitrary", "valid", "reasonable"]))]
    level: &'static str,
}

impl Head {
    /// The head of a command's document for these skills at this level.
    pub fn of(command: &str, skills: &Skills, level: Level) -> Self {
        Self {
            schema: schema(command),
            skills: skills.name.clone(),
            level: level.word(),
        }
    }
}

impl RuleSelection {
    /// Prints the finding that prevents an answer.
    pub fn failed(&self, command: &str, finding: Diagnostic, options: &GlobalOptions) -> Outcome {
        let findings = [finding];
        let console = options.console();
        console.failed(command, &self.loaded.library.sources, &findings)?;
        Ok(options.exit_code(&findings))
    }
}

/// Loads the selected set of rules. Errors in the file are printed as this command's.
pub fn choose(
    command: &str,
    selection: &Selection,
    choice: &Choice,
    options: &GlobalOptions,
) -> Result<RuleSelection, EarlyExit> {
    let loaded = selection
        .load_alone(command, options)?
        .map_err(EarlyExit::Reported)?;
    let describe = |s: &Arc<Skills>| (s.name.clone(), s.span);
    let named: Vec<_> = loaded.library.skills.iter().map(describe).collect();
    let picked = selection.pick(&loaded, "set of skills", &named, |(n, s)| (n, *s))?;
    let [(name, span)] = picked.as_slice() else {
        let names: Vec<&str> = picked.iter().map(|(n, _)| n.as_str()).collect();
        return Err(EarlyExit::Failed(anyhow::anyhow!(
            "{path} declares several sets of skills: write one of {} behind {path}::",
            names.join(", "),
            path = selection.path
        )));
    };
    let skills = loaded
        .library
        .skills
        .iter()
        .find(|s| s.name == *name && s.span == *span)
        .expect("it was picked from these");
    let skills = with_rules(skills, choice)?;
    let options = choice.options(options);
    Ok(RuleSelection {
        loaded,
        skills,
        options,
    })
}

/// Restricts the skills to the selected rules.
fn with_rules(skills: &Skills, choice: &Choice) -> anyhow::Result<Skills> {
    let names: Vec<&str> = skills.rules.iter().map(|r| r.name.as_str()).collect();
    for name in choice.rules.iter().chain(&choice.no_rules) {
        if !names.contains(&name.as_str()) {
            let instead = match nearest(name, names.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if names.is_empty() => "there are none".to_owned(),
                None => format!("they are {}", names.join(", ")),
            };
            anyhow::bail!("`{}` has no rule `{name}`: {instead}", skills.name);
        }
    }
    for name in &choice.rules {
        let rule = skills.rules.iter().find(|r| r.name == *name);
        if let Some(rule) = rule.filter(|r| r.level > choice.level.level()) {
            anyhow::bail!(
                "the rule `{name}` is kept at the level {word} only: ask for it with --level {word}",
                word = rule.level.word()
            );
        }
    }
    let kept = (0..names.len()).filter(|r| {
        let is_in = |list: &[String]| list.iter().any(|n| n == names[*r]);
        (choice.rules.is_empty() || is_in(&choice.rules)) && !is_in(&choice.no_rules)
    });
    Ok(skills.with_rules(&kept.collect::<Vec<_>>()))
}

/// Finds the files of rules beside a program.
pub fn beside(program: &str) -> anyhow::Result<Selection> {
    let folder = match Path::new(program).parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|e| e.path()) {
        let is_contract = path.extension().is_some_and(|e| e == "lw");
        let text = if is_contract {
            files::read(&path).ok()
        } else {
            None
        };
        // Only a quick filter: the file is fully parsed afterwards.
        if text.is_some_and(|t| t.split(['\n', '\r']).any(|l| l.starts_with("skills "))) {
            found.push(path.to_string_lossy().into_owned());
        }
    }
    found.sort();
    match found.as_slice() {
        [only] => Ok(Selection {
            path: only.strip_prefix("./").unwrap_or(only).to_owned(),
            name: None,
        }),
        [] => anyhow::bail!(
            "no .lw file beside {program} declares skills: say which rules are meant with --rules FILE"
        ),
        several => anyhow::bail!(
            "several files beside {program} declare skills ({}): say which rules are meant with --rules FILE",
            several.join(", ")
        ),
    }
}

/// Note that calls of more skills at once than these are omitted because there would be too many.
pub fn report_cut(calls: &[u64], options: &GlobalOptions) -> anyhow::Result<()> {
    let most = calls.iter().map(|c| c.count_ones()).max().unwrap_or(0);
    options.console().remark(&format!(
        "only calls of up to {most} skills at once are in it: all larger ones would be more than {MOST_CALLS}\n"
    ))?;
    Ok(())
}

/// Additional help for a command whose calls have many skills at once.
pub fn fewer_at_once(most: u8) -> Option<&'static str> {
    (most > 1).then_some("fewer skills at once (--at-once N)")
}
