//! `linewright recipe diff`: which recipes two layouts can make.

use super::{aligned, print_result};
use crate::cli::console::{Failed, schema};
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract::recipe::{Layout, Recipe};
use crate::engine::files::LoadedFiles;
use crate::engine::recipes;
use crate::recipe::realize::{Outcome, SearchLimits};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// The arguments of `recipe diff`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe diff examples/pad/parallel.lw Pad Six
    linewright recipe diff examples/pad/six.lw Pad Six --format json

    $ linewright recipe diff examples/pad/six.lw Six Pad

Every recipe of the file and of its imports is tried on both layouts. The exit code is 1 if the \
second layout cannot make a recipe that the first can, or needs more steps, and 3 if this was not \
decided.")]
pub struct Arguments {
    /// The file with the layouts and recipes
    #[arg(value_name = "FILE")]
    pub file: String,
    /// One layout
    #[arg(value_name = "A")]
    pub first: String,
    /// The other layout
    #[arg(value_name = "B")]
    pub second: String,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "recipe-diff",
    "Which recipes two layouts can make: `recipe diff`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The name of one layout.
    first: String,
    /// The name of the other layout.
    second: String,
    /// The recipes.
    recipes: Vec<RecipeComparison>,
}

/// A recipe.
#[derive(JsonSchema, Serialize)]
struct RecipeComparison {
    /// The name of the recipe.
    name: String,
    /// The number of steps on the first layout, in the worst case; absent if it cannot be made, or
    /// this was not decided.
    #[serde(skip_serializing_if = "Option::is_none")]
    first: Option<u32>,
    /// The same on the second layout.
    #[serde(skip_serializing_if = "Option::is_none")]
    second: Option<u32>,
    /// What the second layout changes.
    change: RecipeChange,
}

/// What the second layout changes for a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum RecipeChange {
    /// Only the second layout can make it.
    Gained,
    /// Only the first layout can make it.
    Lost,
    /// It needs fewer steps.
    Shorter,
    /// It needs more steps.
    Longer,
    /// It needs the same number of steps.
    Same,
    /// Neither can make it.
    Neither,
    /// A search reached its limits.
    NotDecided,
}

impl fmt::Display for RecipeChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gained => "gained",
            Self::Lost => "lost",
            Self::Shorter => "shorter",
            Self::Longer => "longer",
            Self::Same => "the same",
            Self::Neither => "neither can make it",
            Self::NotDecided => "not decided",
        })
    }
}

/// The number of steps with which a layout makes a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Steps {
    /// This many in the worst case; `false` if fewer could suffice.
    Number(u32, bool),
    None,
    Unknown,
}

impl Steps {
    fn number(self) -> Option<u32> {
        match self {
            Self::Number(number, _) => Some(number),
            Self::None | Self::Unknown => None,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let selection = Selection {
        path: arguments.file.clone(),
        name: None,
    };
    let loaded = match selection.load(DOCUMENT.name, options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let first = layout(&loaded, &arguments.first, &arguments.file)?;
    let second = layout(&loaded, &arguments.second, &arguments.file)?;
    let limits = recipes::search_limits(options.effort);
    let mut entries = Vec::new();
    for recipe in &loaded.library.recipes {
        let on_first = steps(first, recipe, limits);
        let on_second = steps(second, recipe, limits);
        entries.push(RecipeComparison {
            name: recipe.model.name.clone(),
            first: on_first.number(),
            second: on_second.number(),
            change: change(on_first, on_second),
        });
    }
    let has = |change: RecipeChange| entries.iter().any(|e| e.change == change);
    let is_worse = has(RecipeChange::Lost) || has(RecipeChange::Longer);
    let code = if has(RecipeChange::NotDecided) {
        ExitCode::GaveUp
    } else if is_worse {
        ExitCode::Findings
    } else {
        ExitCode::Success
    };
    let document = Document {
        schema: schema(DOCUMENT.name),
        first: arguments.first.clone(),
        second: arguments.second.clone(),
        recipes: entries,
    };
    print_result(&document, || text(&document), options)?;
    Ok(code)
}

/// The layout with this name.
fn layout<'l>(loaded: &'l LoadedFiles, name: &str, path: &str) -> anyhow::Result<&'l Layout> {
    let mut layouts = loaded.library.layouts.iter();
    if let Some(found) = layouts.find(|l| l.model.name == name) {
        return Ok(found);
    }
    let known = loaded.library.layouts.iter().map(|l| l.model.name.as_str());
    let known: Vec<&str> = known.collect();
    if known.is_empty() {
        anyhow::bail!("{path} has no layouts");
    }
    anyhow::bail!("{path} has no layout `{name}`: it has {}", known.join(", "))
}

fn steps(layout: &Layout, recipe: &Recipe, limits: SearchLimits) -> Steps {
    // A test that names a resource of another layout cannot be performed here.
    let misfits = recipe.model.problems_on(&layout.model);
    if misfits.iter().any(|p| !p.is_warning()) {
        return Steps::None;
    }
    let outcome = recipes::attempt(layout, recipe, limits).unwrap_or_else(|fault| fault.raise());
    match outcome {
        Outcome::Realizable(controller) => {
            Steps::Number(controller.worst_case, controller.is_least)
        }
        Outcome::Unrealizable(_) => Steps::None,
        Outcome::GaveUp(_) => Steps::Unknown,
    }
}

fn change(first: Steps, second: Steps) -> RecipeChange {
    match (first, second) {
        (Steps::None, Steps::None) => RecipeChange::Neither,
        (Steps::None, Steps::Number(..)) => RecipeChange::Gained,
        (Steps::Number(..), Steps::None) => RecipeChange::Lost,
        (Steps::Number(a, true), Steps::Number(b, true)) => match b.cmp(&a) {
            std::cmp::Ordering::Less => RecipeChange::Shorter,
            std::cmp::Ordering::Equal => RecipeChange::Same,
            std::cmp::Ordering::Greater => RecipeChange::Longer,
        },
        // A search reached its limits, or fewer steps could suffice.
        _ => RecipeChange::NotDecided,
    }
}

fn text(document: &Document) -> String {
    let shown = |steps: Option<u32>| steps.map_or("-".to_owned(), |n| n.to_string());
    let mut rows = vec![[
        "recipe".to_owned(),
        document.first.clone(),
        document.second.clone(),
        String::new(),
    ]];
    for recipe in &document.recipes {
        rows.push([
            recipe.name.clone(),
            shown(recipe.first),
            shown(recipe.second),
            recipe.change.to_string(),
        ]);
    }
    aligned(&rows, &[1, 2])
}
