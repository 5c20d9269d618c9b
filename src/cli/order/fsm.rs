//! `linewright order fsm`: prints the automaton of the rules.

use super::early_exit::{EarlyExit, Outcome};
use super::{Choice, rules};
use crate::cli::console::Failed;
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::drawing::{Region, dot, svg};
use crate::engine::output;
use crate::order::Skills;
use crate::order::fsm::{self, Fsm};
use crate::order::picture::{call_names, graph, regions};
use crate::order::supervisor::Options;
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Default of `--at-once`: no restriction.
const ALL_AT_ONCE: u8 = 64;

/// The arguments of `order fsm`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order fsm examples/pick-and-place/unit.lw
    linewright order fsm examples/pick-and-place/unit.lw --rule trays --paper
    linewright order fsm examples/pick-and-place/unit.lw --by-component --emit svg --out unit.svg

Two states have one transition between them, however many calls lead from one to the other. A \
call of several skills at once is omitted if calling only some of them leads to the same state.")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// Output form [default: table, or json with --format json]
    #[arg(long, value_enum, value_name = "FORM")]
    pub emit: Option<Emit>,
    /// Print one automaton for each component and each rule, instead of their product
    #[arg(long)]
    pub by_component: bool,
    /// Maximum number of skills called at once [default: one per component]
    #[arg(long, value_name = "N", default_value_t = ALL_AT_ONCE, hide_default_value = true, value_parser = clap::value_parser!(u8).range(1..=64))]
    pub at_once: u8,
    /// Output file [default: standard output]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Selection of rules.
    #[command(flatten)]
    pub choice: Choice,
}

/// Output form of an automaton.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// Table.
    Table,
    /// JSON document.
    Json,
    /// Graphviz.
    Dot,
    /// SVG drawing.
    Svg,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-fsm",
    "The automaton of the rules: `order fsm`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    /// Whether some or every order of skills called at once has to be allowed.
    #[schemars(extend("enum" = ["some", "every"]))]
    serialisation: &'static str,
    /// Whether exactly the transitions that the published model deletes are deleted.
    paper: bool,
    /// The names of the rules that are applied.
    rules: Vec<String>,
    /// The components.
    components: Vec<ComponentEntry>,
    /// The automaton of all rules; absent with `--by-component`.
    #[serde(skip_serializing_if = "Option::is_none")]
    automaton: Option<AutomatonEntry>,
    /// An automaton for each component and each rule, with `--by-component`.
    #[serde(skip_serializing_if = "Option::is_none")]
    regions: Option<Vec<RegionEntry>>,
}

/// A component.
#[derive(JsonSchema, Serialize)]
struct ComponentEntry {
    /// The name of the component.
    name: String,
    /// The situations of the component.
    situations: Vec<String>,
    /// The initial situation.
    #[serde(skip_serializing_if = "Option::is_none")]
    initial: Option<String>,
    /// The skills of the component.
    skills: Vec<SkillEntry>,
}

/// A skill.
#[derive(JsonSchema, Serialize)]
struct SkillEntry {
    /// The name of the skill.
    name: String,
    /// The situation to which the skill leads.
    #[serde(skip_serializing_if = "Option::is_none")]
    effect: Option<String>,
}

/// An automaton.
#[derive(JsonSchema, Serialize)]
struct AutomatonEntry {
    /// The index of the initial state.
    initial: usize,
    /// The states.
    states: Vec<StateEntry>,
    /// The transitions, at most one from each state to each other state.
    transitions: Vec<TransitionEntry>,
}

/// A state.
#[derive(JsonSchema, Serialize)]
struct StateEntry {
    /// The situation of each component.
    situation: Vec<String>,
    /// Whether a program can end here.
    complete: bool,
}

/// A transition.
#[derive(JsonSchema, Serialize)]
struct TransitionEntry {
    /// The index of the state that the transition leaves.
    from: usize,
    /// The index of the state that the transition enters.
    to: usize,
    /// The calls that take the transition, each as the skills called at once.
    calls: Vec<Vec<String>>,
}

/// The automaton of a component or a rule.
#[derive(JsonSchema, Serialize)]
struct RegionEntry {
    /// The name of the component or the rule.
    name: String,
    /// The labels of the states.
    states: Vec<Vec<String>>,
    /// The indices of the initial states.
    initial: Vec<usize>,
    /// The transitions.
    transitions: Vec<RegionTransition>,
}

/// A transition of a region.
#[derive(JsonSchema, Serialize)]
struct RegionTransition {
    /// The index of the state that the transition leaves.
    from: usize,
    /// The index of the state that the transition enters.
    to: usize,
    /// The skills that take the transition.
    label: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    let command = "order-fsm";
    let chosen = rules::choose(command, &arguments.rules, &arguments.choice, options)?;
    let emit = arguments.emit.unwrap_or(match options.format {
        Format::Json => Emit::Json,
        Format::Human | Format::Short | Format::Sarif => Emit::Table,
    });
    let skills = &chosen.skills;
    let supervision = chosen.options;
    let at_once = usize::from(arguments.at_once);
    let mut is_truncated = None;
    let text = if arguments.by_component {
        regions(skills, supervision).map(|r| side_by_side(skills, supervision, &r, emit))
    } else {
        Fsm::of(skills, supervision, at_once).map(|f| {
            is_truncated = fsm::is_truncated(&f.calls, skills, at_once).then(|| f.calls.clone());
            flat(skills, supervision, &f, emit)
        })
    };
    let also_helps = (!arguments.by_component).then_some(
        "fewer skills at once (--at-once N), or one automaton per rule (--by-component)",
    );
    let text = text.map_err(EarlyExit::gave_up(also_helps))?;
    let console = options.console();
    if let Some(calls) = is_truncated {
        let masks: Vec<u64> = calls.iter().map(|c| c.0).collect();
        rules::report_omitted_calls(&masks, options)?;
    }
    match &arguments.out {
        None => console.result(&text)?,
        Some(path) => match output::write(path, &text, &chosen.loaded.places) {
            Ok(()) => console.remark(&format!("wrote {}\n", path.display()))?,
            Err(finding) => return chosen.failed(command, *finding, options),
        },
    }
    Ok(ExitCode::Success)
}

fn flat(skills: &Skills, options: Options, fsm: &Fsm, emit: Emit) -> String {
    match emit {
        Emit::Dot => dot::render(&skills.name, &graph(skills, fsm)),
        Emit::Svg => svg::render(&skills.name, &graph(skills, fsm)),
        Emit::Json => json(&Document {
            automaton: Some(automaton(skills, fsm)),
            ..document(skills, options)
        }),
        Emit::Table => table(skills, options, fsm),
    }
}

fn side_by_side(skills: &Skills, options: Options, regions: &[Region], emit: Emit) -> String {
    match emit {
        Emit::Dot => dot::render_regions(&skills.name, regions),
        Emit::Svg => svg::render_regions(&skills.name, regions),
        Emit::Json => json(&Document {
            regions: Some(regions.iter().map(region).collect()),
            ..document(skills, options)
        }),
        Emit::Table => region_table(regions),
    }
}

fn json(document: &Document) -> String {
    let text = serde_json::to_string_pretty(document);
    text.expect("a document could not be written as JSON; please report this") + "\n"
}

fn document(skills: &Skills, options: Options) -> Document {
    let components = skills.components.iter().enumerate().map(|(c, component)| {
        let own = skills.skills.iter().filter(|s| s.component == c);
        ComponentEntry {
            name: component.name.clone(),
            situations: component.situations.clone(),
            initial: component.situations.get(component.initial).cloned(),
            skills: own
                .map(|s| SkillEntry {
                    name: s.name.clone(),
                    effect: s.effect.map(|e| component.situations[e].clone()),
                })
                .collect(),
        }
    });
    let rules = skills.rules.iter().filter(|r| r.level <= options.level);
    Document {
        head: rules::Head::of("order-fsm", skills, options.level),
        serialisation: match options.serialisation {
            crate::order::Serialisation::Every => "every",
            crate::order::Serialisation::Some => "some",
        },
        paper: options.paper,
        rules: rules.map(|r| r.name.clone()).collect(),
        components: components.collect(),
        automaton: None,
        regions: None,
    }
}

fn automaton(skills: &Skills, fsm: &Fsm) -> AutomatonEntry {
    let states = fsm.states.iter().enumerate().map(|(number, state)| {
        let components = skills.components.iter().zip(&state.situation);
        let situation = components.filter_map(|(c, s)| c.situations.get(*s).cloned());
        StateEntry {
            situation: situation.collect(),
            complete: fsm.dfa.is_complete(number as u32),
        }
    });
    let transitions = fsm.transitions().into_iter().map(|t| TransitionEntry {
        from: t.from,
        to: t.to,
        calls: call_names(skills, &t.calls),
    });
    AutomatonEntry {
        initial: 0,
        states: states.collect(),
        transitions: transitions.collect(),
    }
}

fn region(region: &Region) -> RegionEntry {
    let graph = &region.graph;
    let initial_edges = graph.edges.iter().filter(|e| e.from.is_none());
    let transitions = graph.edges.iter().filter_map(|e| {
        Some(RegionTransition {
            from: e.from?,
            to: e.to,
            label: e.label.clone(),
        })
    });
    RegionEntry {
        name: region.title.clone(),
        states: graph.states.clone(),
        initial: initial_edges.map(|e| e.to).collect(),
        transitions: transitions.collect(),
    }
}

fn table(skills: &Skills, options: Options, fsm: &Fsm) -> String {
    let transitions = fsm.transitions();
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}, {}: {} states, {} transitions",
        skills.name,
        options.level.keyword(),
        fsm.states.len(),
        transitions.len()
    );
    for (number, state) in fsm.states.iter().enumerate() {
        let _ = writeln!(
            text,
            "S{number}  {}",
            skills.situation_text(&state.situation)
        );
        for t in transitions.iter().filter(|t| t.from == number) {
            let calls: Vec<String> = t.calls.iter().map(|c| c.text(skills)).collect();
            let _ = writeln!(text, "    -> S{:<3} {}", t.to, calls.join(", "));
        }
    }
    text
}

fn region_table(regions: &[Region]) -> String {
    let mut text = String::new();
    for region in regions {
        let _ = writeln!(text, "{}", region.title);
        for (number, label) in region.graph.states.iter().enumerate() {
            let is_initial = region
                .graph
                .edges
                .iter()
                .any(|e| e.from.is_none() && e.to == number);
            let mark = if is_initial { "*" } else { " " };
            let _ = writeln!(text, "  {mark} {}", label.join(", "));
            for edge in region.graph.edges.iter().filter(|e| e.from == Some(number)) {
                let to = &region.graph.states[edge.to][0];
                let _ = writeln!(text, "      -> {to}  {}", edge.label.join(", "));
            }
        }
    }
    text
}
