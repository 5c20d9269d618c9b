//! What is shown of a run: text and JSON.

use super::{Coordinator, How};
use crate::cli::console::{Failed, count, schema};
use crate::cli::recipe::aligned;
use crate::cli::recipe::schedule::{self, ScheduleSection, TimeUnit, View};
use crate::cli::schema::{Described, form};
use crate::contract::recipe::{Layout, Realization};
use crate::diagnostics::{Diagnostic, json};
use crate::engine::files::LoadedFiles;
use crate::engine::recipes::run::MAX_POSITIONS;
use crate::engine::recipes::stations::machine_of;
use crate::engine::recipes::words;
use crate::recipe::plan::{Execution, Objective, Plan};
use crate::recipe::run::Run;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "recipe-run",
    "A run of a recipe on a layout: `recipe run`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
pub(super) struct Document {
    schema: String,
    /// The statement without its first word: `Hinge on Pad`.
    name: String,
    /// The file with the statement.
    file: String,
    /// How the transitions were executed.
    execution: How,
    /// What coordinated the resources.
    coordinator: Coordinator,
    /// Random seed for the outcomes of tests.
    seed: u64,
    /// Whether all products are finished. If not, the recipe has a loop that was still going on.
    is_finished: bool,
    /// When the run ended.
    makespan: f64,
    /// What the plan takes in the worst case over the outcomes of the tests. A controller may make
    /// the product with times for which no plan was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    planned: Option<f64>,
    /// Unit of all times.
    time_unit: TimeUnit,
    /// Electrical energy in J; only timed.
    #[serde(skip_serializing_if = "Option::is_none")]
    energy: Option<f64>,
    /// The recipe of each product. Product 1 is the first.
    products: Vec<String>,
    /// The resources.
    resources: Vec<ResourceEntry>,
    /// What happened: the schedule, divided at each test.
    sections: Vec<ScheduleSection>,
    /// Errors of station libraries, and resources that waited where they may not.
    findings: Vec<json::Finding>,
}

/// A resource in a run.
#[derive(JsonSchema, Serialize)]
struct ResourceEntry {
    /// The name of the resource.
    name: String,
    /// The machine whose station library did the work, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    machine: Option<String>,
    /// How long its transitions took.
    busy: f64,
}

/// A run that has ended, with all that is shown of it.
pub(super) struct Made<'r> {
    pub loaded: &'r LoadedFiles,
    pub realization: &'r Realization,
    pub layout: &'r Layout,
    pub plan: &'r Plan,
    /// Value of the plan, if one was found.
    pub planned: Option<u64>,
    pub run: &'r Run,
    pub how: How,
    pub coordinator: Coordinator,
    pub view: View<'r>,
}

impl Made<'_> {
    /// Returns the document.
    pub fn document(&self, seed: u64, findings: &[Diagnostic]) -> Document {
        let library = &self.loaded.library;
        let number = |time: i64| schedule::number(self.how.objective(), time);
        let resources = self.layout.model.resources.iter();
        let busy = self.run.busy(self.layout.model.resources.len());
        let name = |demand: &usize| self.view.recipes[*demand].name.clone();
        Document {
            schema: schema(DOCUMENT.name),
            name: words::title(self.realization),
            file: library
                .sources
                .file(self.realization.span.file)
                .name
                .clone(),
            execution: self.how,
            coordinator: self.coordinator,
            seed,
            is_finished: self.run.is_finished,
            makespan: number(self.run.time),
            planned: self.planned.map(|value| number(value as i64)),
            time_unit: match self.run.execution {
                Execution::Lockstep => TimeUnit::Steps,
                Execution::Timed => TimeUnit::Seconds,
            },
            energy: self.energy(),
            products: self.plan.products.iter().map(name).collect(),
            resources: (resources.zip(&self.layout.resources).zip(busy))
                .map(|((resource, info), busy)| ResourceEntry {
                    name: resource.name.clone(),
                    machine: machine_of(library, info).map(|m| m.name.clone()),
                    busy: number(busy),
                })
                .collect(),
            sections: schedule::sections(&self.view),
            findings: json::findings(&library.sources, findings),
        }
    }

    /// Electrical energy in J.
    fn energy(&self) -> Option<f64> {
        let is_timed = self.run.execution == Execution::Timed;
        is_timed.then(|| schedule::number(Objective::Energy, self.run.energy))
    }

    /// Returns the text.
    pub fn text(&self) -> String {
        let value = |time: i64| schedule::value(self.how.objective(), time);
        let how = match self.how {
            How::Lockstep => "in lockstep",
            How::Timed => "timed",
        };
        let by = match self.coordinator {
            Coordinator::Plan => "",
            Coordinator::Controller => ", by the controller",
        };
        let planned = self.planned.map_or_else(
            || "no plan was found with these times".to_owned(),
            |planned| format!("planned {} in the worst case", value(planned as i64)),
        );
        let mut text = format!(
            "{}, {how}{by}: {}; {planned}\n",
            words::title(self.realization),
            value(self.run.time),
        );
        if self.energy().is_some_and(|joules| joules > 0.0) {
            let energy = schedule::value(Objective::Energy, self.run.energy);
            let _ = writeln!(text, "electrical energy {energy}");
        }
        if !self.run.is_finished {
            let _ = writeln!(
                text,
                "ended after {}, in a loop of the recipe",
                count(MAX_POSITIONS, "position")
            );
        }
        text += &schedule::tables(&self.view);
        text + &self.table()
    }

    /// How busy each resource was.
    fn table(&self) -> String {
        let busy = self.run.busy(self.layout.model.resources.len());
        let resources = self
            .layout
            .model
            .resources
            .iter()
            .zip(&self.layout.resources);
        let mut rows = vec![["resource", "busy", "", "machine"].map(str::to_owned)];
        for ((resource, info), busy) in resources.zip(busy) {
            let share = busy as f64 / self.run.time.max(1) as f64;
            let machine = machine_of(&self.loaded.library, info);
            rows.push([
                resource.name.clone(),
                schedule::value(self.how.objective(), busy),
                format!("{:.0} %", share * 100.0),
                machine.map_or_else(String::new, |m| m.name.clone()),
            ]);
        }
        format!("\n{}", aligned(&rows, &[1, 2]))
    }
}
