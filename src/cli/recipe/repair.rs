//! `linewright recipe repair`: the smallest changes of a layout that make a recipe possible.

use super::{print_result, subject};
use crate::cli::console::{Failed, count, schema};
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract::recipe::{Layout, Realization};
use crate::engine::files::LoadedFiles;
use crate::engine::internal::Fault;
use crate::engine::recipes::{self, words};
use crate::game::BudgetFactor;
use crate::recipe::model;
use crate::recipe::realize::SearchLimits;
use crate::recipe::repair::{self, Change, Repairs};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// Maximum number of repairs in the text.
const MAX_SHOWN: usize = 40;

/// Part of the limits that each search may use.
const SHARE: usize = 20;

/// The arguments of `recipe repair`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe repair examples/pad/missing-route.lw
    linewright recipe repair examples/pad/parallel.lw --only operations,duplicates
    linewright recipe repair examples/pad/missing-route.lw --only routes --changes 2 --format json

The sets of the least size are listed, and all of them: the search tries each change that could be \
used. The exit code is 0 if there is a repair, 1 if there is none of this size, and 3 if searches \
reached their limits.")]
pub struct Arguments {
    /// The file, and a recipe or layout of its statements `realize` [default: all statements]
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// Maximum number of changes in a repair
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=4))]
    pub changes: u8,
    /// Kinds of changes to try (comma-separated) [default: all]
    #[arg(long, value_enum, value_name = "KIND", value_delimiter = ',')]
    pub only: Vec<ChangeKind>,
}

/// Kind of a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChangeKind {
    /// A transport has another route.
    Routes,
    /// A resource has room for one part more.
    Capacities,
    /// A resource performs another operation, from any of its states to any.
    Operations,
    /// There is a second resource like another, with its routes.
    Duplicates,
}

impl ChangeKind {
    const ALL: [Self; 4] = [
        Self::Routes,
        Self::Capacities,
        Self::Operations,
        Self::Duplicates,
    ];

    fn of(change: &Change) -> Self {
        match change {
            Change::Route { .. } | Change::Connection { .. } => Self::Routes,
            Change::Capacity { .. } => Self::Capacities,
            Change::Operation { .. } => Self::Operations,
            Change::Duplicate { .. } => Self::Duplicates,
        }
    }

    fn candidates(self, layout: &model::Layout, recipe: &model::Recipe) -> Vec<Change> {
        match self {
            Self::Routes => [repair::routes(layout), repair::connections(layout)].concat(),
            Self::Capacities => repair::capacities(layout),
            Self::Operations => repair::operations(layout, recipe),
            Self::Duplicates => repair::duplicates(layout),
        }
    }
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "recipe-repair",
    "The smallest changes of a layout that make a recipe possible: `recipe repair`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The statements `realize`.
    realizations: Vec<RepairEntry>,
}

/// A statement `realize` with its repairs.
#[derive(JsonSchema, Serialize)]
struct RepairEntry {
    /// The statement without its first word: `Hinge on Pad`.
    name: String,
    /// The file with the statement.
    file: String,
    /// Whether there is a repair, or none is needed.
    outcome: RepairOutcome,
    /// All sets of changes of the least size that make the recipe possible.
    repairs: Vec<Vec<LayoutChange>>,
    /// Whether no repair of this size or less was missed because a search reached its limits.
    is_complete: bool,
    /// The number of searches.
    searches: usize,
}

/// Result of the search for repairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum RepairOutcome {
    /// The recipe can be made as it is.
    NotNeeded,
    /// There are repairs.
    Repaired,
    /// There are none of the size asked for.
    None,
    /// None were found, but some searches reached their limits, or several products are wanted.
    NotDecided,
}

/// A change of a layout.
#[derive(Clone, JsonSchema, Serialize)]
pub(super) struct LayoutChange {
    /// What is added.
    kind: ChangeKind,
    /// The resource that changes, or of which there is a second one.
    resource: String,
    /// The change in the words of the language.
    pub(super) text: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let selection = &arguments.selection;
    let loaded = match subject::load(selection, &[], DOCUMENT.name, options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let mut document = Document {
        schema: schema(DOCUMENT.name),
        realizations: Vec::new(),
    };
    for realization in subject::realizations(selection, &loaded)? {
        let entry = examine(&loaded, realization, arguments, options);
        document.realizations.push(entry);
    }
    print_result(&document, || text(&document, arguments.changes), options)?;
    let codes = document.realizations.iter().map(|r| match r.outcome {
        RepairOutcome::NotNeeded | RepairOutcome::Repaired => ExitCode::Success,
        RepairOutcome::None => ExitCode::Findings,
        RepairOutcome::NotDecided => ExitCode::GaveUp,
    });
    Ok(codes.fold(ExitCode::Success, ExitCode::and))
}

fn examine(
    loaded: &LoadedFiles,
    realization: &Realization,
    arguments: &Arguments,
    options: &GlobalOptions,
) -> RepairEntry {
    let sources = &loaded.library.sources;
    let mut entry = RepairEntry {
        name: words::title(realization),
        file: sources.file(realization.span.file).name.clone(),
        outcome: RepairOutcome::NotDecided,
        repairs: Vec::new(),
        is_complete: false,
        searches: 0,
    };
    let (Some(layout), Some(recipe)) = subject::models(loaded, realization) else {
        return entry;
    };
    let kinds = ChangeKind::ALL.into_iter();
    let kinds = kinds.filter(|k| arguments.only.is_empty() || arguments.only.contains(k));
    let kinds: Vec<ChangeKind> = kinds.collect();
    let models = (&layout.model, &recipe.model);
    let (found, searches) = smallest(models, &kinds, arguments.changes, options.effort)
        .unwrap_or_else(|problems| unreported(&entry.name, &problems).raise());
    entry.searches = searches;
    entry.is_complete = found.is_complete;
    entry.outcome = match found.sets.first() {
        Some(set) if set.is_empty() => RepairOutcome::NotNeeded,
        Some(_) => RepairOutcome::Repaired,
        None if found.is_complete => RepairOutcome::None,
        None => RepairOutcome::NotDecided,
    };
    if entry.outcome == RepairOutcome::Repaired {
        let sets = found.sets.iter();
        let changes = sets.map(|set| set.iter().map(|c| change(layout, c)).collect());
        entry.repairs = changes.collect();
    }
    entry
}

/// Finds all sets of changes of the least size, up to `most`, that make a recipe possible on a
/// layout. Returns the number of searches, too.
///
/// # Errors
/// All problems of the models, if any of them is more than a warning.
pub(super) fn smallest(
    (layout, recipe): (&model::Layout, &model::Recipe),
    kinds: &[ChangeKind],
    most: u8,
    effort: BudgetFactor,
) -> Result<(Repairs, usize), Vec<model::Problem>> {
    let kinds = kinds.iter();
    let candidates: Vec<Change> = kinds
        .flat_map(|kind| kind.candidates(layout, recipe))
        .collect();
    let SearchLimits { nodes, vectors } = recipes::search_limits(effort);
    let limits = SearchLimits {
        nodes: nodes / SHARE,
        vectors: vectors / SHARE,
    };
    let (mut found, mut searches) = (Repairs::default(), 0);
    for size in 0..=usize::from(most) {
        found = repair::repairs(layout, recipe, &candidates, size, limits)?;
        searches += found.searches;
        if !found.sets.is_empty() {
            break;
        }
    }
    Ok((found, searches))
}

/// The fault of problems that the resolver should have reported.
pub(super) fn unreported(name: &str, problems: &[model::Problem]) -> Fault {
    let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
    Fault::detected(format!("repairing {name}"), problems.join("; "))
}

pub(super) fn change(layout: &Layout, change: &Change) -> LayoutChange {
    let is_transport = |name: &str| {
        let at = layout.model.resource(name);
        at.is_some_and(|at| layout.resources[at].is_transport)
    };
    let resource = match change {
        Change::Route { resource, .. }
        | Change::Connection { resource, .. }
        | Change::Capacity { resource }
        | Change::Operation { resource, .. }
        | Change::Duplicate { resource } => resource.clone(),
    };
    LayoutChange {
        kind: ChangeKind::of(change),
        resource,
        text: words::change(&layout.model, &is_transport, change),
    }
}

fn text(document: &Document, most: u8) -> String {
    let mut text = String::new();
    for (number, entry) in document.realizations.iter().enumerate() {
        if number > 0 {
            text.push('\n');
        }
        let name = &entry.name;
        let changes = count(usize::from(most), "change");
        let size = entry.repairs.first().map_or(0, Vec::len);
        let _ = match entry.outcome {
            RepairOutcome::NotNeeded => writeln!(text, "{name}: can be made as it is"),
            RepairOutcome::None => writeln!(
                text,
                "{name}: cannot be made, and no set of at most {changes} makes it possible"
            ),
            RepairOutcome::NotDecided => writeln!(text, "{name}: not decided"),
            RepairOutcome::Repaired => writeln!(
                text,
                "{name}: cannot be made; {} of {} would be enough",
                count(entry.repairs.len(), "repair"),
                count(size, "change")
            ),
        };
        for set in entry.repairs.iter().take(MAX_SHOWN) {
            let changes: Vec<&str> = set.iter().map(|c| c.text.as_str()).collect();
            let _ = writeln!(text, "    {}", changes.join("   and   "));
        }
        let more = entry.repairs.len().saturating_sub(MAX_SHOWN);
        if more > 0 {
            let _ = writeln!(text, "    and {more} more (--format json lists them)");
        }
        if !entry.is_complete && entry.outcome == RepairOutcome::Repaired {
            let _ = writeln!(text, "    perhaps more: some searches reached their limits");
        }
    }
    text
}
