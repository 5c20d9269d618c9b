//! `linewright recipe plan`: how the resources of a layout make a recipe.

use super::assumed::Planned;
use super::documents::add_documents;
use super::least::Least;
use super::repair::LayoutChange;
use super::schedule::{self, ProductsPlan, View};
use super::{print_result, subject};
use crate::cli::console::{Failed, count, schema};
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::results::Results;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract::recipe::Realization;
use crate::contract::set::Setting;
use crate::diagnostics::{Diagnostic, json};
use crate::drawing::gantt;
use crate::engine::files::LoadedFiles;
use crate::engine::output;
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::{Aim, Solution, words};
use crate::recipe::controller::{Controller, Leg, Move, Position, Subject};
use crate::recipe::model::{Layout, Recipe, Resource};
use crate::recipe::plan::{Objective, Plan};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The arguments of `recipe plan`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe plan examples/pad/hinge.lw
    linewright recipe plan examples/pad/six.lw::Six --format json
    linewright recipe plan examples/pad/hinge.lw --set r3.holds=3
    linewright recipe plan examples/pad/times.lw --least time --gantt hinge.svg
    linewright recipe plan examples/pad/hinge.lw --emit b2mml --out documents

A plan of one product with least steps has a list of steps for each transition of the recipe. In a \
step, each resource takes one transition or waits: `r3: glue(p)(p)` is an operation, and \
`r3 => r5: p` a part that r5 takes from r3. Other plans are tables of what begins and ends when, \
with a part for each outcome of a test. The plan holds whatever the outcomes of the tests, and a \
replay has verified it. A number in the layout has a name such as r3.holds, r3.glue.time or \
r5.r1.r2.time.

Of a plan that is not proved the least possible, a lower bound says how far it can be from that: \
--effort 10 lets the search for a better one look at ten times as many plans. The exit code is 1 \
if the products cannot be made, even with --assume, and 3 if this was not decided.

B2MML documents have the name of the statement and what they hold: Hinge-on-Pad.equipment.xml is \
the layout, definition.xml the recipe, workflow.xml the same as a graph if it has choices or loops, \
and schedule.xml the plan, which is one of one product with least steps.")]
pub struct Arguments {
    /// The file, and a recipe or layout of its statements `realize` [default: all statements]
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// What the plan has least of, in the worst case over the outcomes of the tests
    #[arg(long, value_enum, default_value = "steps", value_name = "WHAT")]
    pub least: Least,
    /// Draw the plan as Gantt charts, one for each way through its tests (SVG; not with least
    /// steps)
    #[arg(long, value_name = "FILE")]
    pub gantt: Option<PathBuf>,
    /// If a product cannot be made, plan as if resources performed up to N operations that they
    /// lack, and say which; these take no time
    #[arg(long, value_name = "N", conflicts_with = "emit", value_parser = clap::value_parser!(u8).range(1..=4))]
    pub assume: Option<u8>,
    /// Set a number of the layout for this plan (repeatable)
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub settings: Vec<Setting>,
    /// Write files instead of the text
    #[arg(long, value_enum, value_name = "FORM", requires = "out")]
    pub emit: Option<Emit>,
    /// Output folder of the files
    #[arg(long, value_name = "DIR", requires = "emit")]
    pub out: Option<PathBuf>,
}

/// A form of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// Layout, recipe and plan as documents in B2MML 7.0.1
    B2mml,
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
    /// The operations that the layout lacks and the plan assumes; only with `--assume`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    assumed: Vec<LayoutChange>,
    /// If realizable, for one product with least steps: the plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<RecipePlan>,
    /// If realizable, for several products, or with least time, energy or transfers: the plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    schedule: Option<ProductsPlan>,
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

/// What one resource does.
#[derive(JsonSchema, Serialize)]
pub(super) struct MoveEntry {
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

impl MoveEntry {
    /// Describes a transition of a resource, with its operation of a recipe or its part.
    pub(super) fn new(
        resource: &Resource,
        transition: usize,
        operation: Option<String>,
        part: Option<String>,
    ) -> Self {
        let taken = &resource.transitions[transition];
        Self {
            resource: resource.name.clone(),
            from: taken.from.clone(),
            action: words::action(&taken.action),
            to: taken.to.clone(),
            operation,
            part,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let selection = &arguments.selection;
    anyhow::ensure!(
        arguments.gantt.is_none() || arguments.least != Least::Steps,
        "--gantt shows times, and steps have none: add `--least time`, `energy` or `transfers`"
    );
    let objective = Objective::from(arguments.least);
    let loaded = match objective {
        Objective::Time | Objective::Energy => subject::load_timed,
        Objective::Steps | Objective::Transfers => subject::load,
    };
    let loaded = loaded(selection, &arguments.settings, DOCUMENT.name, options)?;
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let selected = subject::realizations(selection, &loaded)?;
    anyhow::ensure!(
        arguments.gantt.is_none() || selected.len() == 1,
        "--gantt draws one plan, but {} statements are selected: write FILE::NAME",
        selected.len()
    );
    anyhow::ensure!(
        arguments.emit.is_none()
            || objective == Objective::Steps && selected.iter().all(|r| r.is_single()),
        "--emit b2mml writes plans of one product with least steps: select one with FILE::NAME, without `--least`"
    );
    let aim = Aim {
        objective,
        factor: options.effort,
        as_plan: false,
    };
    let decided: Vec<Planned<'_>> = selected
        .into_iter()
        .map(|r| Planned::new(&loaded, r, aim, arguments.assume.unwrap_or(0)))
        .collect();
    let findings: Vec<Diagnostic> = (decided.iter())
        .flat_map(|planned| planned.decision.findings.iter().cloned())
        .collect();
    let verdicts = decided
        .iter()
        .map(|planned| ExitCode::from(planned.decision.verdict));
    let code = verdicts.fold(options.exit_code(&findings), ExitCode::and);
    if arguments.emit == Some(Emit::B2mml) {
        let out = arguments.out.as_deref();
        return Ok(code.and(write_documents(&loaded, &decided, findings, out, options)?));
    }
    let document = Document {
        schema: schema(DOCUMENT.name),
        least: arguments.least,
        plans: decided
            .iter()
            .map(|planned| entry(&loaded, planned))
            .collect(),
    };
    let sources = &loaded.library.sources;
    let console = options.console();
    print_result(
        &document,
        || {
            let plans = decided.iter().map(|planned| text(&loaded, planned));
            let plans: Vec<String> = plans.collect();
            console.render(sources, &findings) + &plans.join("\n")
        },
        options,
    )?;
    if let (Some(path), [planned]) = (&arguments.gantt, decided.as_slice())
        && let Some(view) = view(&loaded, planned)
        && let Some(failed) = draw(path, planned.realization, &view, &loaded, options)?
    {
        return Ok(failed);
    }
    Ok(code)
}

/// Writes the documents of all plans into a folder.
fn write_documents(
    loaded: &LoadedFiles,
    decided: &[Planned<'_>],
    mut findings: Vec<Diagnostic>,
    out: Option<&Path>,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let mut results = Results::default();
    for planned in decided {
        let (realization, decision) = (planned.realization, &planned.decision);
        let finding = add_documents(loaded, realization, decision, &mut results);
        findings.extend(finding);
    }
    results.finish(DOCUMENT.name, out, loaded, findings, options)
}

/// Returns the plan of a statement with its models, if it has one with a schedule.
fn view<'l>(loaded: &'l LoadedFiles, planned: &'l Planned<'_>) -> Option<View<'l>> {
    let plan: &Plan = planned.decision.solution.as_ref()?.plan()?;
    let (layout, _) = planned.models(loaded);
    let recipes = subject::recipes(loaded, planned.realization);
    let recipes = recipes.into_iter().map(|r| &r.model).collect();
    Some(View::new(plan, &layout?.model, recipes))
}

/// Writes the Gantt charts of a plan; if this fails, says why and returns the exit code.
pub(super) fn draw(
    path: &Path,
    realization: &Realization,
    view: &View<'_>,
    loaded: &LoadedFiles,
    options: &GlobalOptions,
) -> anyhow::Result<Option<ExitCode>> {
    let title = words::title(realization);
    let (charts, left_out) = schedule::chart(&title, view);
    let console = options.console();
    if let Err(finding) = output::write(path, &gantt::render(&title, &charts), &loaded.places) {
        console.findings(&loaded.library.sources, std::slice::from_ref(&*finding))?;
        return Ok(Some(options.exit_code(&[*finding])));
    }
    console.remark(&format!("wrote {}\n", path.display()))?;
    if left_out > 0 {
        let number = charts.charts.len();
        console.remark(&format!(
            "it shows the first {number} charts of {}\n",
            number + left_out
        ))?;
    }
    Ok(None)
}

fn entry(loaded: &LoadedFiles, planned: &Planned<'_>) -> PlanEntry {
    let sources = &loaded.library.sources;
    let (realization, decision) = (planned.realization, &planned.decision);
    PlanEntry {
        name: words::title(realization),
        file: sources.file(realization.span.file).name.clone(),
        verdict: decision.verdict,
        assumed: planned.assumed.clone(),
        plan: controlled(loaded, planned).map(|(l, r, c)| plan(l, r, c)),
        schedule: view(loaded, planned).map(|view| ProductsPlan::new(&view)),
        findings: json::findings(sources, &decision.findings),
    }
}

/// Returns the controller of a statement with its models, if it has one.
fn controlled<'l>(
    loaded: &'l LoadedFiles,
    planned: &'l Planned<'_>,
) -> Option<(&'l Layout, &'l Recipe, &'l Controller)> {
    let Some(Solution::Controller(controller)) = &planned.decision.solution else {
        return None;
    };
    let (layout, recipe) = planned.models(loaded);
    Some((&layout?.model, &recipe?.model, controller))
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

fn vectors(layout: &Layout, recipe: &Recipe, leg: &Leg) -> Vec<Vec<MoveEntry>> {
    let shown = words::numbered(leg).map(|(step, vector)| {
        let calls = (recipe.transitions[leg.transition].steps.get(step))
            .map_or(&[][..], |s| s.operations.as_slice());
        let shown = |m: &Move| {
            let operation = match &m.subject {
                Subject::Operation(number) => calls.get(*number).map(words::call),
                _ => None,
            };
            let part = match &m.subject {
                Subject::Part(part) => Some(part.clone()),
                _ => None,
            };
            MoveEntry::new(&layout.resources[m.resource], m.transition, operation, part)
        };
        vector.moves.iter().map(shown).collect()
    });
    shown.collect()
}

fn text(loaded: &LoadedFiles, planned: &Planned<'_>) -> String {
    let mut text = String::new();
    if !planned.assumed.is_empty() {
        let title = words::title(planned.realization);
        let assumed: Vec<&str> = planned.assumed.iter().map(|c| c.text.as_str()).collect();
        let _ = writeln!(
            text,
            "{title} cannot be made on the layout as it is; this plan assumes {}",
            assumed.join(", ")
        );
    }
    text += &plan_text(loaded, planned);
    text
}

fn plan_text(loaded: &LoadedFiles, planned: &Planned<'_>) -> String {
    let title = words::title(planned.realization);
    if let Some(view) = view(loaded, planned) {
        return schedule::text(&title, &view);
    }
    let Some((layout, recipe, controller)) = controlled(loaded, planned) else {
        let verdict = match planned.decision.verdict {
            Verdict::Unrealizable => "cannot be made",
            _ => "not decided",
        };
        return format!("{title}: {verdict}\n");
    };
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
            for (at, (step, vector)) in words::numbered(leg).enumerate() {
                let moves = words::vector(layout, recipe, leg.transition, step, vector);
                let _ = writeln!(text, "{:>4}  {}", at + 1, moves.join("; "));
            }
        }
    }
    text
}
