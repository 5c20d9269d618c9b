//! `linewright recipe topology`: the states in which the resources of a layout can be together.

use super::print_result;
use crate::cli::console::{Failed, schema};
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract::recipe::Layout;
use crate::diagnostics::{Diagnostic, codes};
use crate::drawing::{Edge, Graph, dot, svg};
use crate::engine::output;
use crate::engine::recipes::words;
use crate::recipe::model::{self, Action};
use crate::recipe::topology::{self, TopologyError};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Maximum number of transitions in a drawing.
const MAX_DRAWN: u64 = 20_000;

/// The arguments of `recipe topology`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright recipe topology examples/pad/ten.lw
    linewright recipe topology examples/pad/hinge.lw --format json
    linewright recipe topology examples/pad/hinge.lw --emit dot --out pad.dot

The topology is the reachable synchronous product of the resources, without parts. Its size grows \
exponentially with the number of resources; `check` and `recipe plan` do not need it.")]
pub struct Arguments {
    /// The file, and a layout in it [default: all layouts of the file]
    #[arg(value_name = "FILE[::LAYOUT]")]
    pub selection: Selection,
    /// Output form [default: table, or json with --format json]
    #[arg(long, value_enum, value_name = "FORM")]
    pub emit: Option<Emit>,
    /// Give up when there are more states
    #[arg(long, value_name = "N", default_value_t = 1 << 21)]
    pub max_states: usize,
    /// Output file [default: standard output]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Output form of a topology.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// Number of states and transitions, as text.
    Table,
    /// The same as a JSON document.
    Json,
    /// All states and transitions, for Graphviz.
    Dot,
    /// SVG drawing.
    Svg,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "recipe-topology",
    "The size of the topology of layouts: `recipe topology`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The layouts.
    layouts: Vec<TopologyEntry>,
}

/// A layout.
#[derive(JsonSchema, Serialize)]
struct TopologyEntry {
    /// The name of the layout.
    name: String,
    /// The file that declares it.
    file: String,
    /// The number of resources, with each place of a transport.
    resources: usize,
    /// The number of states that the resources can reach together.
    states: usize,
    /// The number of transitions. Those that differ only in their operations count apart.
    transitions: u64,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let command = DOCUMENT.name;
    let loaded = match arguments.selection.load(command, options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let library = &loaded.library;
    let layouts = arguments
        .selection
        .pick(&loaded, "layout", &library.layouts, |l| {
            (&l.model.name, l.span)
        })?;
    let emit = arguments.emit.unwrap_or(match options.format {
        Format::Json => Emit::Json,
        Format::Human | Format::Short | Format::Sarif => Emit::Table,
    });
    let console = options.console();
    let failed = |finding: Diagnostic| -> anyhow::Result<ExitCode> {
        console.failed(command, &library.sources, std::slice::from_ref(&finding))?;
        Ok(options.exit_code(&[finding]))
    };
    let mut entries = Vec::new();
    for layout in &layouts {
        match topology::size(&layout.model, arguments.max_states) {
            Ok(size) => entries.push(TopologyEntry {
                name: layout.model.name.clone(),
                file: library.sources.file(layout.span.file).name.clone(),
                resources: layout.model.resources.len(),
                states: size.states,
                transitions: size.transitions,
            }),
            Err(error) => return failed(too_large(layout, &error)),
        }
    }
    let document = Document {
        schema: schema(command),
        layouts: entries,
    };
    let text = match emit {
        Emit::Table => table(&document),
        Emit::Json => {
            serde_json::to_string_pretty(&document)
                .expect("a document could not be written as JSON; please report this")
                + "\n"
        }
        Emit::Dot | Emit::Svg => {
            let [layout] = layouts.as_slice() else {
                anyhow::bail!("a drawing shows one layout: write FILE::LAYOUT");
            };
            let size = document.layouts[0].transitions;
            if size > MAX_DRAWN {
                return failed(undrawable(layout, size));
            }
            let graph = graph(&layout.model, arguments.max_states);
            let name = &layout.model.name;
            if emit == Emit::Dot {
                dot::render(name, &graph)
            } else {
                svg::render(name, &graph)
            }
        }
    };
    match &arguments.out {
        None if emit == Emit::Table => print_result(&document, || text, options)?,
        None => console.result(&text)?,
        Some(path) => match output::write(path, &text, &loaded.places) {
            Ok(()) => console.remark(&format!("wrote {}\n", path.display()))?,
            Err(finding) => return failed(*finding),
        },
    }
    Ok(ExitCode::Success)
}

fn too_large(layout: &Layout, error: &TopologyError) -> Diagnostic {
    let name = &layout.model.name;
    let message = format!("the topology of `{name}` is not counted: {error}");
    Diagnostic::error(codes::GAVE_UP, layout.span, message)
        .with_help("raise `--max-states`, or use `recipe plan`, which does not need the topology")
}

fn undrawable(layout: &Layout, transitions: u64) -> Diagnostic {
    let name = &layout.model.name;
    let message =
        format!("the topology of `{name}` is not drawn: it has {transitions} transitions");
    Diagnostic::error(codes::GAVE_UP, layout.span, message).with_help(format!(
        "draw a layout with fewer resources; at most {MAX_DRAWN} transitions are drawn"
    ))
}

fn table(document: &Document) -> String {
    let mut text = String::new();
    let width = |of: &dyn Fn(&TopologyEntry) -> String| {
        let widths = document.layouts.iter().map(|l| of(l).chars().count());
        widths.max().unwrap_or(0)
    };
    let name = width(&|l| l.name.clone());
    let resources = width(&|l| l.resources.to_string());
    let states = width(&|l| l.states.to_string());
    let transitions = width(&|l| l.transitions.to_string());
    for l in &document.layouts {
        let _ = writeln!(
            text,
            "{:name$}  {:>resources$} resources  {:>states$} states  {:>transitions$} transitions",
            l.name, l.resources, l.states, l.transitions
        );
    }
    text
}

/// The topology as a graph. Transitions between the same states are one edge.
fn graph(layout: &model::Layout, max_states: usize) -> Graph {
    let mut numbers: BTreeMap<Vec<u16>, usize> = BTreeMap::new();
    let mut states: Vec<Vec<String>> = Vec::new();
    let mut edges: BTreeMap<(usize, usize), Vec<String>> = BTreeMap::new();
    let mut number = |state: &[u16]| {
        if let Some(number) = numbers.get(state) {
            return *number;
        }
        let names =
            (layout.resources.iter().zip(state)).map(|(r, s)| r.states[*s as usize].name.as_str());
        states.push(vec![names.collect::<Vec<_>>().join(" ")]);
        numbers.insert(state.to_vec(), states.len() - 1);
        states.len() - 1
    };
    let explored = topology::explore(layout, max_states, |transition| {
        let from = number(transition.from);
        let to = number(transition.to);
        let label = label(layout, transition.taken);
        edges.entry((from, to)).or_default().push(label);
    });
    // The size is known to be within the limit.
    debug_assert!(explored.is_ok(), "the size was counted before");
    let start = Edge {
        from: None,
        to: 0,
        label: Vec::new(),
    };
    let edges = edges.into_iter().map(|((from, to), label)| Edge {
        from: Some(from),
        to,
        label,
    });
    Graph {
        states,
        edges: std::iter::once(start).chain(edges).collect(),
        ..Graph::default()
    }
}

/// What the resources do in a transition: `separate`, `r1 => r5`; `-` if all of them wait.
fn label(layout: &model::Layout, taken: &[Option<u16>]) -> String {
    let moving: Vec<(&str, &Action)> = (layout.resources.iter().zip(taken))
        .filter_map(|(r, t)| Some((r.name.as_str(), &r.transitions[(*t)? as usize].action)))
        .collect();
    let mut shown = Vec::new();
    for (name, action) in &moving {
        match action {
            Action::Operation(_) | Action::Internal(_) => shown.push(words::action(action)),
            Action::Out(label) => {
                let mut takers = moving.iter();
                let taker = takers.find(|(_, a)| matches!(a, Action::In(other) if other == label));
                shown.push(format!(
                    "{name} => {}",
                    taker.map_or("?", |(taker, _)| taker)
                ));
            }
            Action::In(_) => {}
        }
    }
    if shown.is_empty() {
        "-".to_owned()
    } else {
        shown.join(", ")
    }
}
