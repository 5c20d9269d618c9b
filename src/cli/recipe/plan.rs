//! `linewright recipe plan`: how the resources of a layout make a recipe.

use super::{print_result, subject};
use crate::cli::console::{Failed, count, schema};
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract::recipe::Realization;
use crate::contract::set::Setting;
use crate::diagnostics::{Diagnostic, json};
use crate::engine::files::LoadedFiles;
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::{self, Decision, words};
use crate::recipe::controller::{Controller, Leg, Move, Position, Subject, Vector};
use crate::recipe::model::{Layout, Recipe};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// The arguments of `recipe plan`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe plan examples/pad/hinge.lw
    linewright recipe plan examples/pad/six.lw::Six --format json
    linewright recipe plan examples/pad/hinge.lw --set r3.holds=3

A plan has a list of steps for each transition of the recipe. In a step, each resource takes one \
transition or waits: `r3: glue(p)(p)` is an operation, and `r3 => r5: p` a part that r5 takes from \
r3. The plan holds whatever the outcomes of the tests, and a replay has verified it. A number in \
the layout has a name such as r3.holds, r3.glue.time or r5.r1.r2.time.")]
pub struct Arguments {
    /// The file, and a recipe or layout of its statements `realize` [default: all statements]
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// What the plan has least of, in the worst case over the outcomes of the tests
    #[arg(long, value_enum, default_value = "steps", value_name = "WHAT")]
    pub least: Least,
    /// Set a number of the layout for this plan (repeatable)
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub settings: Vec<Setting>,
}

/// What a plan has least of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Least {
    /// Steps that resources take together.
    Steps,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "recipe-plan",
    "How the resources of a layout make a recipe: `recipe plan`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// What the plans have least of.
    least: Least,
    /// The statements `realize`, with their plans.
    plans: Vec<PlanEntry>,
}

/// A statement `realize` with its plan.
#[derive(JsonSchema, Serialize)]
struct PlanEntry {
    /// The statement without its first word: `Hinge on Pad`.
    name: String,
    /// The file with the statement.
    file: String,
    /// Whether the products can be made, whatever the outcomes of the tests.
    verdict: Verdict,
    /// If realizable: the plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<RecipePlan>,
    /// Why it cannot be made, or was not decided.
    findings: Vec<json::Finding>,
}

/// A plan.
#[derive(JsonSchema, Serialize)]
struct RecipePlan {
    /// The number of steps until an end of the recipe or of its loop, in the worst case over the
    /// outcomes of the tests.
    worst_case: u32,
    /// Whether no plan has fewer.
    is_least: bool,
    /// Whether a replay with other code has confirmed the plan. Only such plans are printed.
    verified: bool,
    /// The names of the resources.
    resources: Vec<String>,
    /// The positions of the recipe. It starts in the first.
    positions: Vec<PositionEntry>,
}

/// A state of the recipe with the states and parts of the resources.
#[derive(JsonSchema, Serialize)]
struct PositionEntry {
    /// The state of the recipe.
    state: String,
    /// The state of each resource.
    resource_states: Vec<String>,
    /// The parts that each resource holds.
    parts: Vec<Vec<String>>,
    /// The transitions of the recipe that leave the state.
    legs: Vec<LegEntry>,
}

/// A transition of the recipe with what the resources do.
#[derive(JsonSchema, Serialize)]
struct LegEntry {
    /// The transition: `b -> c when visionOk(h2)`.
    transition: String,
    /// The vectors (steps that resources take together) in their order; resources that wait are
    /// left out.
    vectors: Vec<Vec<MoveEntry>>,
    /// The index of the position that it leads to.
    to: usize,
}

/// What one resource does in a vector.
#[derive(JsonSchema, Serialize)]
struct MoveEntry {
    /// The resource.
    resource: String,
    /// The state that it leaves.
    from: String,
    /// What it does: `glue`, `internal turn`, `in:3` or `out:3`.
    action: String,
    /// The state that it enters.
    to: String,
    /// For an operation of the recipe: the operation with its parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    operation: Option<String>,
    /// For a transfer: the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let selection = &arguments.selection;
    let loaded = subject::load(selection, &arguments.settings, DOCUMENT.name, options)?;
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let limits = recipes::limits(options.effort);
    let decided: Vec<(&Realization, Decision)> = (subject::realizations(selection, &loaded)?)
        .into_iter()
        .map(|r| (r, recipes::decide(&loaded.library, r, limits)))
        .collect();
    let findings: Vec<Diagnostic> = (decided.iter())
        .flat_map(|(_, d)| d.findings.iter().cloned())
        .collect();
    let document = Document {
        schema: schema(DOCUMENT.name),
        least: arguments.least,
        plans: decided.iter().map(|(r, d)| entry(&loaded, r, d)).collect(),
    };
    let sources = &loaded.library.sources;
    let console = options.console();
    print_result(
        &document,
        || {
            let plans = decided.iter().map(|(r, d)| text(&loaded, r, d));
            let plans: Vec<String> = plans.collect();
            console.render(sources, &findings) + &plans.join("\n")
        },
        options,
    )?;
    let verdicts = decided.iter().map(|(_, d)| ExitCode::from(d.verdict));
    Ok(verdicts.fold(options.exit_code(&findings), ExitCode::and))
}

fn entry(loaded: &LoadedFiles, realization: &Realization, decision: &Decision) -> PlanEntry {
    let sources = &loaded.library.sources;
    let plan = match (subject::models(loaded, realization), &decision.controller) {
        ((Some(layout), Some(recipe)), Some(controller)) => {
            Some(plan(&layout.model, &recipe.model, controller))
        }
        _ => None,
    };
    PlanEntry {
        name: words::title(realization),
        file: sources.file(realization.span.file).name.clone(),
        verdict: decision.verdict,
        plan,
        findings: json::findings(sources, &decision.findings),
    }
}

fn plan(layout: &Layout, recipe: &Recipe, controller: &Controller) -> RecipePlan {
    let position = |at: &Position| PositionEntry {
        state: recipe.states[at.recipe_state].clone(),
        resource_states: (layout.resources.iter().zip(&at.resource_states))
            .map(|(r, state)| r.states[*state].name.clone())
            .collect(),
        parts: at.parts.clone(),
        legs: (at.legs.iter())
            .map(|leg| LegEntry {
                transition: words::transition(&recipe.transitions[leg.transition]),
                vectors: vectors(layout, recipe, leg),
                to: leg.to,
            })
            .collect(),
    };
    RecipePlan {
        worst_case: controller.worst_case,
        is_least: controller.is_least,
        verified: true,
        resources: layout.resources.iter().map(|r| r.name.clone()).collect(),
        positions: controller.positions.iter().map(position).collect(),
    }
}

/// Returns the vectors of a leg, each with the number of the recipe's steps before it.
fn numbered(leg: &Leg) -> impl Iterator<Item = (usize, &Vector)> {
    let mut performed = 0;
    leg.vectors.iter().map(move |vector| {
        let step = performed;
        performed += usize::from(words::performs_step(vector));
        (step, vector)
    })
}

fn vectors(layout: &Layout, recipe: &Recipe, leg: &Leg) -> Vec<Vec<MoveEntry>> {
    let shown = numbered(leg).map(|(step, vector)| {
        let calls = (recipe.transitions[leg.transition].steps.get(step))
            .map_or(&[][..], |s| s.operations.as_slice());
        let shown = |m: &Move| {
            let resource = &layout.resources[m.resource];
            let taken = &resource.transitions[m.transition];
            MoveEntry {
                resource: resource.name.clone(),
                from: taken.from.clone(),
                action: words::action(&taken.action),
                to: taken.to.clone(),
                operation: match &m.subject {
                    Subject::Operation(number) => calls.get(*number).map(words::call),
                    _ => None,
                },
                part: match &m.subject {
                    Subject::Part(part) => Some(part.clone()),
                    _ => None,
                },
            }
        };
        vector.moves.iter().map(shown).collect()
    });
    shown.collect()
}

fn text(loaded: &LoadedFiles, realization: &Realization, decision: &Decision) -> String {
    let title = words::title(realization);
    let ((Some(layout), Some(recipe)), Some(controller)) =
        (subject::models(loaded, realization), &decision.controller)
    else {
        let verdict = match decision.verdict {
            Verdict::Unrealizable => "cannot be made",
            _ => "not decided",
        };
        return format!("{title}: {verdict}\n");
    };
    let (layout, recipe) = (&layout.model, &recipe.model);
    let steps = count(controller.worst_case as usize, "step");
    let bound = if controller.is_least {
        "the least possible"
    } else {
        "perhaps not the least possible"
    };
    let mut text = format!("{title}: {steps} in the worst case, {bound}\n");
    for (number, position) in controller.positions.iter().enumerate() {
        let state = position.recipe_state;
        let same = controller
            .positions
            .iter()
            .filter(|p| p.recipe_state == state);
        let is_one_of_many = same.count() > 1;
        for leg in &position.legs {
            let transition = words::transition(&recipe.transitions[leg.transition]);
            let which = if is_one_of_many {
                format!(" from position {number} to {}", leg.to)
            } else {
                String::new()
            };
            let steps = count(leg.vectors.len(), "step");
            let _ = writeln!(text, "\n{transition}{which}: {steps}");
            for (at, (step, vector)) in numbered(leg).enumerate() {
                let moves = words::vector(layout, recipe, leg.transition, step, vector);
                let _ = writeln!(text, "{:>4}  {}", at + 1, moves.join("; "));
            }
        }
    }
    text
}
