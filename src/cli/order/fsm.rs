//! `linewright order fsm`: the automaton of the rules.

use super::early_exit::{EarlyExit, Outcome};
use super::{Choice, rules};
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::select::Selection;
use crate::drawing::{Region, dot, svg};
use crate::engine::output;
use crate::order::Skills;
use crate::order::fsm::{self, Fsm};
use crate::order::picture::{graph, names, regions};
use crate::order::supervisor::Options;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Maximum number of skills at once without `--at-once`; otherwise the number of components.
const ALL_AT_ONCE: u8 = 64;

/// The arguments of `order fsm`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order fsm examples/pick-and-place/unit.lw
    linewright order fsm examples/pick-and-place/unit.lw --rule trays --paper
    linewright order fsm examples/pick-and-place/unit.lw --by-component --emit svg --out unit.svg

There is one transition between two states, however many calls lead from the one to the other. A call of several skills at once is left \
out where some of them alone lead to the same state.")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// How it is printed [default: table, or json with --format json]
    #[arg(long, value_enum, value_name = "FORM")]
    pub emit: Option<Emit>,
    /// Each component and each rule by itself, side by side, and not all of them together
    #[arg(long)]
    pub by_component: bool,
    /// Call so many skills at once at most [default: one of each component]
    #[arg(long, value_name = "N", default_value_t = ALL_AT_ONCE, hide_default_value = true, value_parser = clap::value_parser!(u8).range(1..=64))]
    pub at_once: u8,
    /// The file to write; without it, standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Which rules are kept.
    #[command(flatten)]
    pub choice: Choice,
}

/// How an automaton is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// A table for a person.
    Table,
    /// A document with a schema.
    Json,
    /// Graphviz.
    Dot,
    /// A picture.
    Svg,
}

#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    serialisation: &'static str,
    paper: bool,
    rules: Vec<String>,
    components: Vec<ComponentEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    automaton: Option<AutomatonEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    regions: Option<Vec<RegionEntry>>,
}

#[derive(Serialize)]
struct ComponentEntry {
    name: String,
    situations: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    initial: Option<String>,
    skills: Vec<SkillEntry>,
}

#[derive(Serialize)]
struct SkillEntry {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    effect: Option<String>,
}

#[derive(Serialize)]
struct AutomatonEntry {
    initial: usize,
    states: Vec<StateEntry>,
    transitions: Vec<TransitionEntry>,
}

#[derive(Serialize)]
struct StateEntry {
    situation: Vec<String>,
    complete: bool,
}

#[derive(Serialize)]
struct TransitionEntry {
    from: usize,
    to: usize,
    calls: Vec<Vec<String>>,
}

#[derive(Serialize)]
struct RegionEntry {
    name: String,
    states: Vec<Vec<String>>,
    initial: Vec<usize>,
    transitions: Vec<RegionTransition>,
}

#[derive(Serialize)]
struct RegionTransition {
    from: usize,
    to: usize,
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
    let kept = chosen.options;
    let at_once = usize::from(arguments.at_once);
    let mut is_cut = None;
    let text = if arguments.by_component {
        regions(skills, kept).map(|r| side_by_side(skills, kept, &r, emit))
    } else {
        Fsm::of(skills, kept, at_once).map(|f| {
            is_cut = fsm::is_cut(&f.calls, skills, at_once).then(|| f.calls.clone());
            flat(skills, kept, &f, emit)
        })
    };
    let besides = (!arguments.by_component)
        .then_some("fewer skills at once (--at-once N), or each rule by itself (--by-component)");
    let text = text.map_err(EarlyExit::gave_up(besides))?;
    let console = options.console();
    if let Some(calls) = is_cut {
        let masks: Vec<u64> = calls.iter().map(|c| c.0).collect();
        rules::told_cut(&masks, options)?;
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
        Emit::Dot => dot::of(&skills.name, &graph(skills, fsm)),
        Emit::Svg => svg::of(&skills.name, &graph(skills, fsm)),
        Emit::Json => json(&Document {
            automaton: Some(automaton(skills, fsm)),
            ..document(skills, options)
        }),
        Emit::Table => table(skills, options, fsm),
    }
}

fn side_by_side(skills: &Skills, options: Options, regions: &[Region], emit: Emit) -> String {
    match emit {
        Emit::Dot => dot::of_regions(&skills.name, regions),
        Emit::Svg => svg::of_regions(&skills.name, regions),
        Emit::Json => json(&Document {
            regions: Some(regions.iter().map(region).collect()),
            ..document(skills, options)
        }),
        Emit::Table => region_table(regions),
    }
}

fn json(document: &Document) -> String {
    let text = serde_json::to_string_pretty(document);
    text.expect("a document of texts and numbers; please report this") + "\n"
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
        calls: names(skills, &t.calls),
    });
    AutomatonEntry {
        initial: 0,
        states: states.collect(),
        transitions: transitions.collect(),
    }
}

fn region(region: &Region) -> RegionEntry {
    let graph = &region.graph;
    let begins = graph.edges.iter().filter(|e| e.from.is_none());
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
        initial: begins.map(|e| e.to).collect(),
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
        options.level.word(),
        fsm.states.len(),
        transitions.len()
    );
    for (number, state) in fsm.states.iter().enumerate() {
        let _ = writeln!(text, "S{number}  {}", skills.situation(&state.situation));
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
            let begins = region
                .graph
                .edges
                .iter()
                .any(|e| e.from.is_none() && e.to == number);
            let mark = if begins { "*" } else { " " };
            let _ = writeln!(text, "  {mark} {}", label.join(", "));
            for edge in region.graph.edges.iter().filter(|e| e.from == Some(number)) {
                let to = &region.graph.states[edge.to][0];
                let _ = writeln!(text, "      -> {to}  {}", edge.label.join(", "));
            }
        }
    }
    text
}
