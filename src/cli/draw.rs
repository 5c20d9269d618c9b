//! `linewright draw`: writes drawings of controllers, machines, lines and skill sets.

use super::exit::ExitCode;
use super::options::GlobalOptions;
use super::order::LevelName;
use super::pictures;
use super::results::{Results, file_name};
use super::select::Selection;
use super::synth::{counterstrategy, request};
use crate::contract::Contract;
use crate::contract::picture as machine_picture;
use crate::diagnostics::{Diagnostic, codes};
use crate::drawing::svg;
use crate::engine::controller::ExtractionOptions;
use crate::engine::files::LoadedFiles;
use crate::engine::pipeline::{CheckedContract, Jobs, Verdict};
use crate::gr1::Specification;
use crate::line::picture as line_picture;
use crate::mealy;
use crate::order::picture::regions;
use crate::order::supervisor::Options;
use crate::order::{Serialisation, Skills};
use crate::source::Span;
use clap::Args;
use std::path::PathBuf;

/// The end of the help.
const EXAMPLES: &str = "Examples:
    linewright draw contracts/handling/turn.lw > turn.svg
    linewright draw examples/transfer/cell.lw --out drawings
    linewright draw examples/ice-lab/line.lw::IceLab > line.svg
    linewright draw contracts/handling/turn.lw::Turn --around S6 --steps 2 > turn.svg
    linewright draw contracts/separating/grind.lw --by phase > phases.svg

A contract is drawn as the states of its controller, an unrealizable one as those of its \
counterstrategy, a machine as its components with their wires, a line as its places with their \
routes, and a skill set as the automata of its components and rules. A drawing is at most 1,600 \
units wide. What is too large for one is shown as an outline or a table, and a controller with too \
many states to be listed is not drawn (LW204).";

/// The arguments of `draw`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = pictures::below(EXAMPLES, pictures::DRAW))]
pub struct Arguments {
    /// File, and optionally one of its contracts, machines, lines or skill sets [default: all of
    /// them]
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// Output folder; if omitted, a single drawing is printed to standard output
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Draw only this state of a controller and the states close to it
    #[arg(long, value_name = "STATE")]
    pub around: Option<String>,
    /// Number of edges from the state of --around to the farthest states drawn
    #[arg(long, value_name = "N", default_value_t = 1, requires = "around", value_parser = clap::value_parser!(u8).range(1..))]
    pub steps: u8,
    /// Draw the values of this output, and which value may follow which, instead of the states of a
    /// controller (repeatable, or separated by commas)
    #[arg(
        long,
        value_name = "OUTPUT",
        value_delimiter = ',',
        conflicts_with = "around"
    )]
    pub by: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    options.refuse_sarif("a drawing")?;
    let selection = &arguments.selection;
    let loaded = match selection.load_alone("draw", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let library = &loaded.library;
    let contracts = selection.find(&loaded, &library.contracts, |c| (&c.name, c.span));
    let machines = selection.find(&loaded, &library.machines, |m| (&m.name, m.span));
    let lines = selection.find(&loaded, &library.lines, |l| (&l.name, l.span));
    let skills = selection.find(&loaded, &library.skills, |s| (&s.name, s.span));
    let others = machines.len() + lines.len() + skills.len();
    let count = contracts.len() + others;
    if count == 0 {
        anyhow::bail!(nothing_to_draw(selection, &loaded));
    }
    if arguments.around.is_some() && (others > 0 || contracts.len() != 1) {
        anyhow::bail!("--around needs one contract: write FILE::NAME with the name of a contract");
    }
    if !arguments.by.is_empty() && (others > 0 || contracts.len() != 1) {
        anyhow::bail!("--by needs one contract: write FILE::NAME with the name of a contract");
    }
    let out = arguments.out.as_deref();
    Results::check_count(count, out)?;

    let mut findings = loaded.findings.clone();
    let mut written = Results::default();
    for (contract, checked) in controllers(&contracts, &loaded, options) {
        if let Some((name, machine)) = automaton(contract, &checked, &mut findings) {
            let is_own = checked.verdict == Verdict::Realizable;
            let specification = Some(&*contract.specification).filter(|_| is_own);
            let text = match &arguments.around {
                None if !arguments.by.is_empty() => of_outputs(machine, &arguments.by)?,
                None => mealy::picture::to_svg(machine, specification),
                Some(state) => around(machine, specification, state, arguments.steps.into())?,
            };
            let files = vec![(file_name(&name, "svg"), text)];
            findings.extend(written.add(&contract.name, contract.span, files));
        }
    }
    let mut add = |name: &str, span: Span, text: String| {
        let files = vec![(file_name(name, "svg"), text)];
        findings.extend(written.add(name, span, files));
    };
    for machine in machines {
        add(
            &machine.name,
            machine.span,
            machine_picture::to_svg(machine),
        );
    }
    for line in lines {
        let text = line_picture::to_svg(line, &library.sources);
        add(&line.name, line.span, text);
    }
    let mut not_drawn = Vec::new();
    for set in skills {
        match automata(set, options) {
            Ok(text) => add(&set.name, set.span, text),
            Err(finding) => not_drawn.push(*finding),
        }
    }
    findings.extend(not_drawn);
    written.finish("draw", out, &loaded, findings, options)
}

/// Says that a file declares nothing with the selected name.
fn nothing_to_draw(selection: &Selection, loaded: &LoadedFiles) -> String {
    let library = &loaded.library;
    let contracts = library.contracts.iter().map(|c| c.name.as_str());
    let machines = library.machines.iter().map(|m| m.name.as_str());
    let lines = library.lines.iter().map(|l| l.name.as_str());
    let skills = library.skills.iter().map(|s| s.name.as_str());
    let names: Vec<&str> = contracts
        .chain(machines)
        .chain(lines)
        .chain(skills)
        .collect();
    let path = &selection.path;
    let instead = match names.as_slice() {
        [] => "give a file with a contract, a machine, a line or a skill set".to_owned(),
        names => format!(
            "write `{path}::NAME`, where NAME is one of {}",
            names.join(", ")
        ),
    };
    match &selection.name {
        Some(name) => format!("{path} has nothing to draw with the name `{name}`: {instead}"),
        None => format!("{path} declares nothing to draw itself: {instead}"),
    }
}

/// Synthesizes the controllers of contracts, as far as they can be drawn.
fn controllers<'c>(
    contracts: &[&'c Contract],
    loaded: &LoadedFiles,
    options: &GlobalOptions,
) -> Vec<(&'c Contract, CheckedContract)> {
    let mut jobs = Jobs::default().with_extraction(ExtractionOptions {
        drawn: true,
        ..ExtractionOptions::default()
    });
    let indices = contracts.iter().map(|c| request(&mut jobs, loaded, c));
    let indices: Vec<usize> = indices.collect();
    let progress = options.console().progress(jobs.len(), "synthesizing");
    let settings = options.announcing(&options.settings(), &progress);
    let checked = jobs.run(&settings, &progress);
    let contracts = contracts.iter().zip(indices);
    contracts
        .map(|(contract, index)| (*contract, checked[index].clone()))
        .collect()
}

/// The controller of a contract, or the counterstrategy if it is unrealizable, with a name for the
/// file. If there is none, adds findings with the reason.
fn automaton<'c>(
    contract: &Contract,
    checked: &'c CheckedContract,
    findings: &mut Vec<Diagnostic>,
) -> Option<(String, &'c mealy::Machine)> {
    if checked.verdict == Verdict::Unrealizable {
        let machine = counterstrategy(checked, contract.span, findings)?;
        let name = &contract.name;
        let message = format!("`{name}` is unrealizable, so its counterstrategy is drawn");
        let note = Diagnostic::note(codes::UNREALIZABLE, contract.span, message);
        findings.push(note.with_help(format!(
            "`linewright check` explains why `{name}` is unrealizable"
        )));
        return Some((format!("{name}.counterstrategy"), machine));
    }
    findings.extend(checked.findings_where_needed());
    let machine = checked.controller.as_ref()?.machine()?;
    Some((contract.name.clone(), machine))
}

/// Draws the part of a machine that is close to a state. The specification is that of a controller;
/// `None` for a counterstrategy.
fn around(
    machine: &mealy::Machine,
    specification: Option<&Specification>,
    state: &str,
    steps: usize,
) -> anyhow::Result<String> {
    let goals = specification.map_or(Vec::new(), mealy::picture::goals);
    let graph = mealy::picture::to_graph(machine, &goals);
    let named = |label: &Vec<String>| label.first().is_some_and(|name| name == state);
    let Some(center) = graph.states.iter().position(named) else {
        let last = graph.states.len().saturating_sub(1);
        anyhow::bail!(
            "`{}` has no state `{state}`: its states are S0 to S{last}",
            machine.name
        );
    };
    let title = format!("{}, around {state}", machine.name);
    Ok(svg::render(&title, &graph.around(center, steps)))
}

/// Draws the values of some outputs of a machine, and which may follow which.
fn of_outputs(machine: &mealy::Machine, names: &[String]) -> anyhow::Result<String> {
    let mut outputs = Vec::new();
    for name in names {
        let Some(output) = machine.outputs.iter().position(|port| port.name == *name) else {
            let known = machine.outputs.iter().map(|port| port.name.as_str());
            anyhow::bail!(
                "`{}` has no output `{name}`: its outputs are {}",
                machine.name,
                known.collect::<Vec<_>>().join(", ")
            );
        };
        outputs.push(output);
    }
    let title = format!("{}, by {}", machine.name, names.join(", "));
    let graph = mealy::picture::to_graph_of_outputs(machine, &outputs);
    Ok(svg::render(&title, &graph))
}

/// Draws the automata of the components and the rules of a skill set.
fn automata(skills: &Skills, options: &GlobalOptions) -> Result<String, Box<Diagnostic>> {
    let supervision = Options {
        level: LevelName::Valid.level(),
        serialisation: Serialisation::Every,
        paper: false,
        until: options.limits().deadline,
    };
    match regions(skills, supervision) {
        Ok(regions) => Ok(svg::render_regions(&skills.name, &regions)),
        Err(bound) => {
            let message = format!("`{}` is not drawn: {bound}", skills.name);
            let finding = Diagnostic::error(codes::GAVE_UP, skills.span, message);
            Err(Box::new(finding.with_help(
                "use `linewright order fsm`, with --rule NAME for a part of it",
            )))
        }
    }
}
