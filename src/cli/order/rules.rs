//! Selects a set of skills from a file, and some of its rules.

use super::Choice;
use super::early_exit::{EarlyExit, Outcome};
use crate::cli::console::schema;
use crate::cli::options::GlobalOptions;
use crate::cli::select::Selection;
use crate::diagnostics::{Diagnostic, nearest};
use crate::engine::files::{self, LoadedFiles};
use crate::order::fsm::MAX_CALLS;
use crate::order::supervisor::Options;
use crate::order::{Level, Skills};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// A set of skills with the selected rules.
pub struct RuleSelection {
    /// The loaded files.
    pub loaded: LoadedFiles,
    /// The skills with the selected rules.
    pub skills: Skills,
    /// Level of refusal, and other options of supervisors.
    pub options: Options,
}

/// First fields of the documents of most `order` commands.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Head {
    schema: String,
    /// The name of the set of skills.
    skills: String,
    /// Which calls are refused.
    #[schemars(extend("enum" = ["arbitrary", "valid", "reasonable"]))]
    level: &'static str,
}

impl Head {
    /// Creates the first fields of a command's document.
    pub fn of(command: &str, skills: &Skills, level: Level) -> Self {
        Self {
            schema: schema(command),
            skills: skills.name.clone(),
            level: level.keyword(),
        }
    }
}

impl RuleSelection {
    /// Prints the finding that prevents a result, and returns the exit code.
    pub fn failed(&self, command: &str, finding: Diagnostic, options: &GlobalOptions) -> Outcome {
        let findings = [finding];
        let console = options.console();
        console.failed(command, &self.loaded.library.sources, &findings)?;
        Ok(options.exit_code(&findings))
    }
}

/// Loads the selected set of skills, and restricts it to the chosen rules. Errors in the files are
/// printed as findings of this command.
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
            "{path} declares several sets of skills: write `{path}::NAME`, where NAME is one of {}",
            names.join(", "),
            path = selection.path
        )));
    };
    let skills = loaded
        .library
        .skills
        .iter()
        .find(|s| s.name == *name && s.span == *span)
        .expect("the selection is one of these sets");
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
                None if names.is_empty() => "it has no rules".to_owned(),
                None => format!("its rules are {}", names.join(", ")),
            };
            anyhow::bail!("`{}` has no rule `{name}`: {instead}", skills.name);
        }
    }
    for name in &choice.rules {
        let rule = skills.rules.iter().find(|r| r.name == *name);
        if let Some(rule) = rule.filter(|r| r.level > choice.level.level()) {
            anyhow::bail!(
                "the rule `{name}` applies at the level {word} only: use --level {word}",
                word = rule.level.keyword()
            );
        }
    }
    let kept = (0..names.len()).filter(|r| {
        let is_in = |list: &[String]| list.iter().any(|n| n == names[*r]);
        (choice.rules.is_empty() || is_in(&choice.rules)) && !is_in(&choice.no_rules)
    });
    Ok(skills.with_rules(&kept.collect::<Vec<_>>()))
}

/// Finds the `.lw` file that declares skills in the folder of a program. Fails unless there is
/// exactly one.
pub fn find_next_to(program: &str) -> anyhow::Result<Selection> {
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
            "no .lw file next to {program} declares skills: give the rules with --rules FILE"
        ),
        several => anyhow::bail!(
            "several files next to {program} declare skills ({}): choose one with --rules FILE",
            several.join(", ")
        ),
    }
}

/// Prints a remark that calls of more skills at once are omitted, since there would be too many.
pub fn report_omitted_calls(calls: &[u64], options: &GlobalOptions) -> anyhow::Result<()> {
    let max = calls.iter().map(|c| c.count_ones()).max().unwrap_or(0);
    options.console().remark(&format!(
        "limited to calls of at most {max} skills at once: with more skills at once, there would be more than {MAX_CALLS} calls\n"
    ))?;
    Ok(())
}

/// Additional help for a command that can be limited to fewer skills at once.
pub fn fewer_at_once(max: u8) -> Option<&'static str> {
    (max > 1).then_some("fewer skills at once (--at-once N)")
}
