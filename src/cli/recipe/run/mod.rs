//! `linewright recipe run`: the cell makes its products once.

mod coordinator;
mod result;

pub use coordinator::Coordinator;
pub use result::DOCUMENT;

use super::schedule::{self, View};
use super::{plan, print_result, stations, subject};
use crate::b2mml::{Performance, write};
use crate::cli::build::default_folder;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::select::Selection;
use crate::contract::recipe::{Layout, Realization};
use crate::contract::set::Setting;
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::files::LoadedFiles;
use crate::engine::output;
use crate::engine::pipeline::Verdict;
use crate::engine::recipes::run::{FixedTest, Tests, coordinate, run as carry_out};
use crate::engine::recipes::stations::Stations;
use crate::engine::recipes::{self, Aim, Solution, words};
use crate::engine::simulation::SimulationOptions;
use crate::event_log::Epoch;
use crate::line::Options;
use crate::recipe::model::{Demand, Recipe};
use crate::recipe::plan::Objective;
use crate::recipe::run::Run;
use clap::{Args, ValueEnum};
use result::Made;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;

/// The arguments of `recipe run`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe run examples/pad/times.lw
    linewright recipe run examples/pad/times.lw --test b=d --seed 7
    linewright recipe run examples/pad/hinge.lw --execution lockstep
    linewright recipe run examples/pad/hinge.lw --execution lockstep --coordinator controller
    linewright recipe run examples/cell/cell.lw --gantt cell.svg

The run follows the plan with least time (timed) or least steps (lockstep). With --coordinator \
controller, the synthesized controller (see `synth`) commands the resources, vector by vector: the \
next vector begins when all resources have ended. In lockstep it has least steps in the worst case, \
like the plan; timed, it takes the sum of the longest durations, which is at least the least time of \
a plan if everything takes as long as planned. It coordinates one product.

A resource that is a machine does its work with the machine's station library, which is compiled \
first; other resources take the times of the layout. The outcome of a test is drawn from the random \
seed, all outcomes with the same probability, unless --test gives it.

The exit code is 1 if a library returns an error, or a resource had to wait in a state where it may \
not: because an operation took longer than planned or, with a controller, because another resource \
of the vector takes longer. The second can happen even without libraries.")]
pub struct Arguments {
    /// The file, and a recipe or layout of one of its statements `realize`
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// How transitions are executed
    #[arg(long, value_enum, default_value = "timed", value_name = "HOW")]
    pub execution: How,
    /// What coordinates the resources
    #[arg(long, value_enum, default_value = "plan", value_name = "WHAT")]
    pub coordinator: Coordinator,
    /// Random seed for the outcomes of tests
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// In this state of the recipe, go on to that one (repeatable)
    #[arg(long = "test", value_name = "STATE=STATE")]
    pub tests: Vec<FixedTest>,
    /// Draw the run as a Gantt chart (SVG; only timed)
    #[arg(long, value_name = "FILE")]
    pub gantt: Option<PathBuf>,
    /// Write what was done as an operations performance in B2MML 7.0.1 (only timed)
    #[arg(long, value_name = "FILE")]
    pub performance: Option<PathBuf>,
    /// Date and time (UTC) at which the run starts, for --performance
    #[arg(
        long,
        value_name = "DATE",
        default_value = "2026-01-05",
        requires = "performance"
    )]
    pub epoch: Epoch,
    /// Set a number of the layout for this run (repeatable)
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub settings: Vec<Setting>,
    /// Folder of the station libraries [default: .linewright next to the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compile again even if nothing has changed
    #[arg(long)]
    pub rebuild: bool,
}

/// How transitions are executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// In steps that all resources take together.
    Lockstep,
    /// Each transition takes its own time.
    Timed,
}

impl How {
    fn objective(self) -> Objective {
        match self {
            Self::Lockstep => Objective::Steps,
            Self::Timed => Objective::Time,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let (selection, how) = (&arguments.selection, arguments.execution);
    let times = match (&arguments.gantt, &arguments.performance) {
        (Some(_), _) => Some("--gantt"),
        (None, Some(_)) => Some("--performance"),
        (None, None) => None,
    };
    if let Some(option) = times.filter(|_| how == How::Lockstep) {
        anyhow::bail!(
            "{option} shows times, and steps have none: leave out `--execution lockstep`"
        );
    }
    let console = options.console();
    let loaded = subject::load(selection, &arguments.settings, DOCUMENT.name, options)?;
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let sources = &loaded.library.sources;
    let realization = one(selection, &loaded)?;
    let recipes: Vec<&Recipe> = subject::recipes(&loaded, realization)
        .into_iter()
        .map(|r| &r.model)
        .collect();
    coordinator::check(arguments.coordinator, realization)?;
    let tests = tests(arguments, &recipes)?;
    let (Some(layout), _) = subject::models(&loaded, realization) else {
        anyhow::bail!("the layout `{}` cannot be used", realization.layout);
    };
    let timed = stations::timed(&loaded, &[layout], DOCUMENT.name, options)?;
    let (timed, synthesis) = match timed {
        Ok((mut timed, synthesis)) => (timed.remove(0), synthesis),
        Err(code) => return Ok(code),
    };
    let aim = Aim {
        objective: how.objective(),
        factor: options.effort,
        as_plan: true,
    };
    let decision = recipes::plan_on(&timed, &loaded.library, realization, aim);
    let failed = |verdict: Verdict, findings: &[Diagnostic]| {
        console.failed(DOCUMENT.name, sources, findings)?;
        Ok(options.exit_code(findings).and(verdict.into()))
    };
    let planned = decision.solution.as_ref().map(Solution::value);
    let plan = match (decision.solution, arguments.coordinator) {
        (Some(Solution::Plan(plan)), _) => Some(plan),
        (_, Coordinator::Controller) if how == How::Timed => {
            coordinator::start(&timed, &loaded.library, realization, aim)
        }
        _ => None,
    };
    let Some(plan) = &plan else {
        return failed(decision.verdict, &decision.findings);
    };
    let controller = match arguments.coordinator {
        Coordinator::Plan => None,
        Coordinator::Controller => {
            let made =
                coordinator::controller(&timed, &loaded.library, realization, options.effort);
            match made {
                Ok(made) => Some(made),
                Err((verdict, findings)) => return failed(verdict, &findings),
            }
        }
    };
    let default = default_folder(&selection.path);
    let folder = arguments.out.as_deref().unwrap_or(&default);
    let simulation = SimulationOptions {
        options: Options {
            deadline: options.settings().limits.deadline,
            ..Options::default()
        },
        rebuild: arguments.rebuild,
        ..SimulationOptions::default()
    };
    let built = Stations::new(&loaded.library, layout, &synthesis, folder, &simulation);
    let demands: Vec<Demand> = (realization.recipes.iter().zip(&recipes))
        .map(|(wanted, recipe)| Demand::new((*recipe).clone(), wanted.count as usize))
        .collect();
    let made = built.and_then(|mut stations| {
        let (model, stations) = (&timed.model, &mut stations);
        let made = match &controller {
            None => carry_out(model, &demands, plan, stations, &tests),
            Some(machine) => coordinate(
                model,
                recipes[0],
                machine,
                plan.execution(),
                stations,
                &tests,
            ),
        };
        made.map_err(|e| vec![*e])
    });
    let made = match made {
        Ok(made) => made,
        Err(findings) => {
            console.failed(DOCUMENT.name, sources, &findings)?;
            return Ok(options.exit_code(&findings));
        }
    };
    let findings: Vec<Diagnostic> = overruns(layout, &made, arguments.coordinator);
    let shown = made.as_plan(plan);
    let result = Made {
        loaded: &loaded,
        realization,
        layout,
        plan,
        planned,
        run: &made,
        how,
        coordinator: arguments.coordinator,
        view: View::of_run(&shown, &timed.model, recipes),
    };
    print_result(
        &result.document(arguments.seed, &findings),
        || result.text() + &console.render(sources, &findings),
        options,
    )?;
    if let Some(path) = &arguments.gantt
        && let Some(failed) = plan::draw(path, realization, &result.view, &loaded, options)?
    {
        return Ok(failed);
    }
    if let Some(path) = &arguments.performance {
        let performance = Performance::of(
            &words::title(realization),
            &layout.model,
            &demands,
            &made,
            arguments.epoch.seconds(),
        );
        let text = write::performance(&performance)?;
        if let Err(finding) = output::write(path, &text, &loaded.places) {
            console.findings(sources, std::slice::from_ref(&*finding))?;
            return Ok(options.exit_code(&[*finding]));
        }
        console.remark(&format!("wrote {}\n", path.display()))?;
    }
    Ok(options.exit_code(&findings))
}

/// Returns the selected statement.
fn one<'l>(selection: &Selection, loaded: &'l LoadedFiles) -> anyhow::Result<&'l Realization> {
    let selected = subject::realizations(selection, loaded)?;
    let [realization] = selected.as_slice() else {
        let titles: Vec<String> = selected.iter().map(|r| words::title(r)).collect();
        anyhow::bail!(
            "one statement is run at a time, but these are selected: {}; write {}::NAME",
            titles.join("; "),
            selection.path
        );
    };
    Ok(realization)
}

/// Returns how the tests end.
fn tests(arguments: &Arguments, recipes: &[&Recipe]) -> anyhow::Result<Tests> {
    for test in &arguments.tests {
        if recipes.iter().any(|r| test.is_of(r)) {
            continue;
        }
        let mut known: Vec<String> = Vec::new();
        for recipe in recipes {
            for from in &recipe.states {
                let leaving = recipe.transitions.iter().filter(|t| t.from == *from);
                let leaving: Vec<String> = leaving.map(|t| format!("{from}={}", t.to)).collect();
                if leaving.len() > 1 {
                    known.extend(leaving);
                }
            }
        }
        let instead = if known.is_empty() {
            "the recipe has no tests".to_owned()
        } else {
            format!("its tests are {}", known.join(", "))
        };
        anyhow::bail!(
            "no transition leads from `{}` to `{}`: {instead}",
            test.from,
            test.to
        );
    }
    Ok(Tests {
        seed: arguments.seed,
        fixed: arguments.tests.clone(),
    })
}

/// The findings about resources that waited where they may not.
fn overruns(layout: &Layout, run: &Run, coordinator: Coordinator) -> Vec<Diagnostic> {
    let help = match coordinator {
        Coordinator::Plan => {
            "an operation took longer than planned: give the layout the longer time, or let the resource wait there with `nop`"
        }
        Coordinator::Controller => {
            "another resource of the vector takes longer: let the resource wait there with `nop`, or leave out `--coordinator controller`"
        }
    };
    let found = run.overruns.iter().map(|overrun| {
        let resource = &layout.model.resources[overrun.resource];
        let info = &layout.resources[overrun.resource];
        let state = &resource.states[overrun.state].name;
        Diagnostic::error(
            codes::RECIPE_WAIT,
            info.states[overrun.state],
            format!(
                "`{}` waited from {} to {} in `{state}`, where it may not",
                resource.name,
                schedule::instant(overrun.from),
                schedule::instant(overrun.to)
            ),
        )
        .with_help(help)
    });
    found.collect()
}
