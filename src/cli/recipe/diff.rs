//! `linewright recipe diff`: which recipes two layouts can make.

use super::least::Least;
use super::schedule::{number, value};
use super::{aligned, print_result, stations};
use crate::cli::console::{Failed, schema};
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract::recipe::{Layout, Realization, Recipe};
use crate::engine::files::LoadedFiles;
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::{self, Aim};
use crate::recipe::plan::Objective;
use crate::recipe::realize::Outcome;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

/// The arguments of `recipe diff`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe diff examples/pad/parallel.lw Pad Six
    linewright recipe diff examples/pad/six.lw Pad Six --format json
    linewright recipe diff examples/pad/parallel.lw Pad Six --least transfers

    $ linewright recipe diff examples/pad/six.lw Six Pad

Every recipe of the file and of its imports is tried on both layouts, for one product. The exit \
code is 1 if the second layout cannot make a recipe that the first can, or needs more steps (or \
time, energy or transfers), and 3 if this was not decided.")]
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
    /// What is compared, in the worst case over the outcomes of the tests
    #[arg(long, value_enum, default_value = "steps", value_name = "WHAT")]
    pub least: Least,
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
    /// What is compared.
    least: Least,
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
    /// The best plan that was found on the first layout; absent if there is none, or this was not
    /// decided.
    #[serde(skip_serializing_if = "Option::is_none")]
    first: Option<LeastValue>,
    /// The same on the second layout.
    #[serde(skip_serializing_if = "Option::is_none")]
    second: Option<LeastValue>,
    /// What the second layout changes.
    change: RecipeChange,
}

/// The value of the best plan that was found.
#[derive(JsonSchema, Serialize)]
struct LeastValue {
    /// In the worst case over the outcomes of the tests: steps, seconds, joules or transfers.
    value: f64,
    /// No plan has a smaller value.
    lower_bound: f64,
}

/// What the second layout changes for a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum RecipeChange {
    /// Only the second layout can make it.
    Gained,
    /// Only the first layout can make it.
    Lost,
    /// It needs less: fewer steps, less time or energy, or fewer transfers.
    Less,
    /// It needs more.
    More,
    /// It needs as much.
    Same,
    /// Neither can make it.
    Neither,
    /// A search reached its limits.
    NotDecided,
}

impl RecipeChange {
    fn words(self, least: Least) -> &'static str {
        match (self, least) {
            (Self::Gained, _) => "gained",
            (Self::Lost, _) => "lost",
            (Self::Less, Least::Steps) => "shorter",
            (Self::More, Least::Steps) => "longer",
            (Self::Less, Least::Time) => "faster",
            (Self::More, Least::Time) => "slower",
            (Self::Less, _) => "less",
            (Self::More, _) => "more",
            (Self::Same, _) => "the same",
            (Self::Neither, _) => "neither can make it",
            (Self::NotDecided, _) => "not decided",
        }
    }
}

/// How a layout makes a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Makes {
    /// The value of the best plan that was found, and a lower bound of all.
    With {
        value: i64,
        lower_bound: i64,
    },
    Not,
    Unknown,
}

impl Makes {
    fn value(self, objective: Objective) -> Option<LeastValue> {
        match self {
            Self::With { value, lower_bound } => Some(LeastValue {
                value: number(objective, value),
                lower_bound: number(objective, lower_bound),
            }),
            Self::Not | Self::Unknown => None,
        }
    }

    fn text(self, objective: Objective) -> String {
        match self {
            Self::With {
                value: found,
                lower_bound,
            } => {
                let text = value(objective, found);
                if found == lower_bound {
                    return text;
                }
                format!("{text} (at least {})", value(objective, lower_bound))
            }
            Self::Not => "-".to_owned(),
            Self::Unknown => "?".to_owned(),
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
    let mut layouts = vec![first.clone(), second.clone()];
    let aim = Aim {
        objective: arguments.least.into(),
        factor: options.effort,
        as_plan: false,
    };
    if matches!(arguments.least, Least::Time | Least::Energy) {
        layouts = match stations::timed(&loaded, &[first, second], DOCUMENT.name, options)? {
            Ok((timed, _)) => timed,
            Err(code) => return Ok(code),
        };
    }
    let heads = [&arguments.first, &arguments.second];
    let mut rows = vec![["recipe", heads[0], heads[1], ""].map(str::to_owned)];
    let mut entries = Vec::new();
    for recipe in &loaded.library.recipes {
        let name = recipe.model.name.clone();
        let [first, second] =
            [&layouts[0], &layouts[1]].map(|layout| makes(&loaded, layout, recipe, aim));
        let change = change(first, second);
        rows.push([
            name.clone(),
            first.text(aim.objective),
            second.text(aim.objective),
            change.words(arguments.least).to_owned(),
        ]);
        entries.push(RecipeComparison {
            name,
            first: first.value(aim.objective),
            second: second.value(aim.objective),
            change,
        });
    }
    let document = Document {
        schema: schema(DOCUMENT.name),
        least: arguments.least,
        first: arguments.first.clone(),
        second: arguments.second.clone(),
        recipes: entries,
    };
    let has = |change: RecipeChange| document.recipes.iter().any(|e| e.change == change);
    let code = if has(RecipeChange::NotDecided) {
        ExitCode::GaveUp
    } else if has(RecipeChange::Lost) || has(RecipeChange::More) {
        ExitCode::Findings
    } else {
        ExitCode::Success
    };
    print_result(&document, || aligned(&rows, &[1, 2]), options)?;
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

/// Searches for the best plan of one product.
fn makes(loaded: &LoadedFiles, layout: &Layout, recipe: &Recipe, aim: Aim) -> Makes {
    // A test that names a resource of another layout cannot be performed here.
    let misfits = recipe.model.problems_on(&layout.model);
    if misfits.iter().any(|p| !p.is_warning()) {
        return Makes::Not;
    }
    if aim.objective == Objective::Steps {
        let outcome =
            recipes::attempt(layout, recipe, aim.factor).unwrap_or_else(|fault| fault.raise());
        return match outcome {
            Outcome::Realizable(controller) => {
                let value = i64::from(controller.worst_case);
                let lower_bound = if controller.is_least { value } else { 0 };
                Makes::With { value, lower_bound }
            }
            Outcome::Unrealizable(_) => Makes::Not,
            Outcome::GaveUp(_) => Makes::Unknown,
        };
    }
    let realization = Realization::of(recipe, layout);
    let decision = recipes::plan_on(layout, &loaded.library, &realization, aim);
    match (decision.verdict, decision.solution.as_ref()) {
        (_, Some(solution)) => match solution.plan() {
            Some(plan) => Makes::With {
                value: plan.value,
                lower_bound: plan.lower_bound,
            },
            None => Makes::Unknown,
        },
        (Verdict::Unrealizable, _) => Makes::Not,
        _ => Makes::Unknown,
    }
}

fn change(first: Makes, second: Makes) -> RecipeChange {
    match (first, second) {
        (Makes::Not, Makes::Not) => RecipeChange::Neither,
        (Makes::Not, Makes::With { .. }) => RecipeChange::Gained,
        (Makes::With { .. }, Makes::Not) => RecipeChange::Lost,
        (
            Makes::With {
                value: a,
                lower_bound: least_a,
            },
            Makes::With {
                value: b,
                lower_bound: least_b,
            },
        ) => {
            if b < least_a {
                RecipeChange::Less
            } else if a < least_b {
                RecipeChange::More
            } else if a == least_a && b == least_b && a == b {
                RecipeChange::Same
            } else {
                // Better plans could exist.
                RecipeChange::NotDecided
            }
        }
        // A search reached its limits.
        _ => RecipeChange::NotDecided,
    }
}
