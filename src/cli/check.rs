//! `linewright check`: the consistency of every contract, machine and line found.

use super::console::{Console, schema};
use super::controller::Wish;
use super::exit::ExitCode;
use super::files::{self, Loaded, StandardLibrary};
use super::libraries;
use super::machines::Planned;
use super::options::{Format, GlobalOptions};
use super::outline::{self, Declaration, Kind};
use super::output;
use super::pipeline::{CheckedContract, Goal, Jobs, Verdict};
use super::proof;
use super::statistics::Statistics;
use crate::contract::{Contract, TaxonomyCode};
use crate::diagnostics::{Diagnostic, Severity, codes, has_errors, json, sarif};
use crate::gr1::{Specification, VarId};
use crate::interchange::inquiries;
use crate::source::{FileId, SourceMap};
use crate::station::composition::By;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

mod table;

/// The arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright check contracts/
    linewright check --format short contracts/handling/turn.lw
    linewright check --stats --proof turn.proof.json contracts/handling/turn.lw
    linewright check examples/other-tools/arbiter.spc examples/other-tools/arbiter.slugsin

A contract is realizable when a controller exists that keeps its guarantees for as long as the plant \
keeps the assumptions (safety first, strictly). Each such controller is synthesized and verified, but \
not written; for a large contract that no machine uses, only the verdict is given. What is known of a contract \
that has not changed is not worked out again (see --no-cache).

Files of gr1c (.spc) and slugs (.slugsin, .structuredslugs) are read by their ending; for these only the \
verdict is given.")]
pub struct Arguments {
    /// Files (.lw, .spc, .slugsin, .structuredslugs), or folders that are searched for .lw files [default: ./contracts, or else the bundled library]
    #[arg(value_name = "PATH")]
    pub paths: Vec<String>,
    /// Also say what each verdict took: kernel, times by phase, nodes, iterations, orders of the variables
    #[arg(long)]
    pub stats: bool,
    /// Write down why the contract is realizable, in a form that others can check
    #[arg(
        long,
        value_name = "FILE",
        long_help = "Write down why the contract is realizable: the ranking of the winning region, as JSON that others \
                     can check; docs/proof.md says how. There must be exactly one contract"
    )]
    pub proof: Option<PathBuf>,
}

/// The JSON document.
#[derive(Debug, Serialize)]
struct Document {
    schema: String,
    semantics: &'static str,
    contracts: Vec<ContractEntry>,
    machines: Vec<MachineEntry>,
    lines: Vec<LineEntry>,
    /// Findings that belong to no declaration.
    findings: Vec<json::Finding>,
    summary: Summary,
}

#[derive(Debug, Serialize)]
struct ContractEntry {
    name: String,
    file: String,
    /// For a specification of another tool: its format, by the ending of its files.
    #[serde(skip_serializing_if = "Option::is_none")]
    format: Option<&'static str>,
    codes: Vec<String>,
    verdict: &'static str,
    findings: Vec<json::Finding>,
    core: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_bits: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output_bits: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    states: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_nodes: Option<u64>,
    /// With `--stats`.
    #[serde(skip_serializing_if = "Option::is_none")]
    statistics: Option<Statistics>,
    /// The kernel, for people; in JSON it is among the statistics.
    #[serde(skip)]
    kernel: String,
    /// Whether only the verdict was asked for, since the game is large.
    #[serde(skip)]
    verdict_only: bool,
}

#[derive(Debug, Serialize)]
struct MachineEntry {
    name: String,
    file: String,
    codes: Vec<String>,
    verdict: &'static str,
    components: Vec<ComponentEntry>,
    /// How each assumption of a component is met, where the composition was checked.
    discharges: Vec<DischargeEntry>,
    findings: Vec<json::Finding>,
}

#[derive(Debug, Serialize)]
struct ComponentEntry {
    name: String,
    contract: String,
    verdict: &'static str,
}

#[derive(Debug, Serialize)]
struct DischargeEntry {
    component: String,
    assumption: String,
    by: String,
}

#[derive(Debug, Serialize)]
struct LineEntry {
    name: String,
    file: String,
    /// `valid` or `invalid`.
    verdict: &'static str,
    findings: Vec<json::Finding>,
}

#[derive(Debug, Default, Serialize)]
struct Summary {
    realizable: usize,
    unrealizable: usize,
    gave_up: usize,
    invalid: usize,
    findings: usize,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let settings = options.settings();
    let loaded = files::load(
        &arguments.paths,
        &StandardLibrary::new(options.library.clone()),
    );
    let files = FileView::all(&loaded);

    // A machine's actions are looked at in the form that `build` gives them.
    let mut jobs = Jobs::examining()
        .wishing(Wish {
            functions: true,
            ..Wish::default()
        })
        .ranking(arguments.proof.is_some());
    let library = &loaded.library;
    let contracts: Vec<(&Contract, usize)> = library
        .contracts
        .iter()
        .filter(|c| view(&files, c.span.file).is_some_and(|f| f.is_sound(c.span)))
        .map(|c| match loaded.foreign(c.span.file) {
            Some(foreign) => {
                let inquiries = inquiries(&foreign.reading);
                let job = jobs.add_foreign(&c.specification, c.span, Goal::Verdict, inquiries);
                (c, job)
            }
            None => (c, jobs.add_for(Goal::Small, &c.specification, c.span)),
        })
        .collect();
    let machines: Vec<Planned<'_>> = library
        .machines
        .iter()
        .filter(|m| view(&files, m.span.file).is_some_and(|f| f.is_sound(m.span)))
        .map(|m| Planned::new(m, &mut jobs))
        .collect();
    let checked = jobs.run(&settings, &console.progress(jobs.len(), "checking"))?;

    let report = Assembly {
        loaded: &loaded,
        files: &files,
        contracts: &contracts,
        machines: &machines,
        jobs: &jobs,
        checked: &checked,
        timing: !options.no_timing,
        statistics: arguments.stats,
    }
    .document();
    let (mut document, mut findings) = report;
    if let Some(path) = &arguments.proof {
        let own = contracts.iter().filter(|(c, _)| {
            loaded
                .roots
                .contains(&library.sources.file(c.span.file).name)
        });
        let own: Vec<_> = own.map(|(c, job)| (*c, &checked[*job])).collect();
        // Where there is no contract because of mistakes, these are what there is to say.
        let found = if own.is_empty() && has_errors(&findings) {
            Vec::new()
        } else {
            write_proof(path, &own)?
        };
        document
            .findings
            .extend(json::findings(&library.sources, &found));
        document.summary.findings += found.len();
        findings.extend(found);
    }
    print(
        console,
        &loaded.library.sources,
        &document,
        &findings,
        options,
    )?;

    let verdicts = document
        .contracts
        .iter()
        .map(|c| match c.verdict {
            "unrealizable" | "invalid" => ExitCode::Findings,
            "gave_up" => ExitCode::GaveUp,
            _ => ExitCode::Success,
        })
        .fold(ExitCode::Success, ExitCode::and);
    Ok(options
        .exit_code(&findings)
        .and(verdicts)
        .and(loaded.exit_code()))
}

/// Writes the proof of the only contract; the findings say why there is none.
fn write_proof(
    path: &Path,
    contracts: &[(&Contract, &CheckedContract)],
) -> anyhow::Result<Vec<Diagnostic>> {
    let [(contract, checked)] = contracts else {
        anyhow::bail!(
            "--proof is for a single contract, and there are {}: give a file with one",
            contracts.len()
        );
    };
    let name = &contract.name;
    let note = |text: String| {
        let mut note = Diagnostic::error(codes::UNREALIZABLE, contract.span, text);
        note.severity = Severity::Note;
        note
    };
    Ok(match (&checked.ranking, checked.verdict) {
        (Some(ranking), _) => {
            let text = proof::to_text(&contract.specification, ranking);
            output::write(path, &text).err().map(|f| *f).into_iter().collect()
        }
        (None, Verdict::Unrealizable) => vec![
            note(format!("there is no proof for `{name}` in {}", path.display())).with_help(
                "a proof can only be written of a realizable contract as yet; the guarantees that clash are named above",
            ),
        ],
        // Its own finding says why there is no verdict.
        (None, _) => Vec::new(),
    })
}

fn print(
    console: Console,
    sources: &SourceMap,
    document: &Document,
    findings: &[Diagnostic],
    options: &GlobalOptions,
) -> anyhow::Result<()> {
    match options.format {
        Format::Json => console.document(document),
        Format::Sarif => console.document(&sarif::document(sources, findings)),
        Format::Short => {
            let verdicts = table::short(document);
            console.result(&(console.render(sources, findings) + &verdicts))
        }
        Format::Human => {
            let table = table::human(document, options.verbose);
            console.result(&(console.render(sources, findings) + &table))
        }
    }
}

/// One file, with what is declared in it and what was found in it while loading.
struct FileView<'a> {
    id: FileId,
    name: &'a str,
    declarations: Vec<Declaration>,
    findings: Vec<&'a Diagnostic>,
    /// It does not parse, or something outside all declarations is wrong: then nothing in it can be relied on.
    broken: bool,
}

impl<'a> FileView<'a> {
    fn all(loaded: &'a Loaded) -> Vec<Self> {
        let sources = &loaded.library.sources;
        sources
            .files()
            .map(|(id, file)| {
                let declarations = match loaded.foreign(id) {
                    Some(foreign) => vec![Declaration {
                        kind: Kind::Contract,
                        name: foreign.name.clone(),
                        extent: foreign.reading.span,
                    }],
                    None => outline::declarations(sources, id),
                };
                let findings: Vec<&Diagnostic> = loaded
                    .findings
                    .iter()
                    .filter(|f| f.span.is_some_and(|s| s.file == id))
                    .collect();
                let broken = findings.iter().any(|f| {
                    let inside = |d: &Declaration| f.span.is_some_and(|s| d.holds(s));
                    has_errors(std::slice::from_ref(*f))
                        && (f.code.id < codes::NAME_UNKNOWN.id || !declarations.iter().any(inside))
                });
                Self {
                    id,
                    name: &file.name,
                    declarations,
                    findings,
                    broken,
                }
            })
            .collect()
    }

    /// Whether what is declared at this place has no errors.
    fn is_sound(&self, name: crate::source::Span) -> bool {
        let declaration = self.declarations.iter().find(|d| d.holds(name));
        !self.broken && declaration.is_some_and(|d| !has_errors(&self.within(d)))
    }

    /// The findings within a declaration.
    fn within(&self, declaration: &Declaration) -> Vec<Diagnostic> {
        self.findings
            .iter()
            .filter(|f| f.span.is_some_and(|s| declaration.holds(s)))
            .map(|f| (*f).clone())
            .collect()
    }

    /// The findings outside all declarations.
    fn outside(&self) -> Vec<Diagnostic> {
        let inside = |f: &&&Diagnostic| {
            f.span
                .is_some_and(|s| self.declarations.iter().any(|d| d.holds(s)))
        };
        let outside = self.findings.iter().filter(|f| !inside(f));
        outside.map(|f| (*f).clone()).collect()
    }
}

fn view<'a, 'b>(files: &'b [FileView<'a>], id: FileId) -> Option<&'b FileView<'a>> {
    files.iter().find(|f| f.id == id)
}

/// All that the document is made from.
struct Assembly<'a> {
    loaded: &'a Loaded,
    files: &'a [FileView<'a>],
    contracts: &'a [(&'a Contract, usize)],
    machines: &'a [Planned<'a>],
    jobs: &'a Jobs,
    checked: &'a [CheckedContract],
    timing: bool,
    statistics: bool,
}

impl Assembly<'_> {
    /// The document, and every finding in it once.
    fn document(&self) -> (Document, Vec<Diagnostic>) {
        let sources = &self.loaded.library.sources;
        let mut document = Document {
            schema: schema("check"),
            semantics: "strict",
            contracts: Vec::new(),
            machines: Vec::new(),
            lines: Vec::new(),
            findings: Vec::new(),
            summary: Summary::default(),
        };
        let mut all: Vec<Diagnostic> = Vec::new();
        let mut loose: Vec<Diagnostic> = self
            .loaded
            .findings
            .iter()
            .filter(|f| f.span.is_none())
            .cloned()
            .collect();
        for file in self.files {
            loose.extend(file.outside());
            for declaration in &file.declarations {
                let mut findings = file.within(declaration);
                match declaration.kind {
                    Kind::Contract => {
                        let entry = self.contract(file, declaration, &mut findings);
                        document.contracts.push(entry);
                    }
                    Kind::Machine => {
                        let entry = self.machine(file, declaration, &mut findings);
                        document.machines.push(entry);
                    }
                    Kind::Line => document.lines.push(LineEntry {
                        name: declaration.name.clone(),
                        file: file.name.to_owned(),
                        verdict: if file.broken || has_errors(&findings) {
                            "invalid"
                        } else {
                            "valid"
                        },
                        findings: json::findings(sources, &findings),
                    }),
                }
                all.extend(findings);
            }
            if file.broken && file.declarations.iter().all(|d| d.kind != Kind::Contract) {
                document.contracts.push(nameless(file.name));
            }
        }
        self.lines_of_invalid_machines(&mut document);
        for path in &self.loaded.unreadable {
            document.contracts.push(nameless(path));
        }
        document.findings = json::findings(sources, &loose);
        all.extend(loose);
        for entry in &document.contracts {
            let count = match entry.verdict {
                "realizable" => &mut document.summary.realizable,
                "unrealizable" => &mut document.summary.unrealizable,
                "gave_up" => &mut document.summary.gave_up,
                _ => &mut document.summary.invalid,
            };
            *count += 1;
        }
        document.summary.findings = all.len();
        (document, all)
    }

    /// A line is as valid as its machines.
    fn lines_of_invalid_machines(&self, document: &mut Document) {
        let Document {
            machines, lines, ..
        } = document;
        let broken = [Verdict::Invalid.word(), Verdict::Unrealizable.word()];
        let invalid = |name: &str| {
            machines
                .iter()
                .any(|m| m.name == name && broken.contains(&m.verdict))
        };
        for model in &self.loaded.library.lines {
            let affected = super::machines::of_line(model)
                .iter()
                .any(|m| invalid(&m.name));
            for entry in lines
                .iter_mut()
                .filter(|l| affected && l.name == model.name)
            {
                entry.verdict = "invalid";
            }
        }
    }

    /// The entry of a contract; the findings of its pipeline are added to those of its text.
    fn contract(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &mut Vec<Diagnostic>,
    ) -> ContractEntry {
        let sources = &self.loaded.library.sources;
        let known = self.loaded.library.contracts.iter();
        let contract = { known }.find(|c| declaration.holds(c.span));
        let result = self
            .contracts
            .iter()
            .find(|(c, _)| declaration.holds(c.span))
            .map(|(_, job)| &self.checked[*job]);
        if let Some(result) = result {
            findings.extend(result.findings.iter().cloned());
        }
        let bits = |inputs: bool| {
            contract.map(|c| {
                let s = &c.specification;
                if inputs {
                    bits(s, s.inputs())
                } else {
                    bits(s, s.outputs())
                }
            })
        };
        ContractEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            format: self
                .loaded
                .foreign(file.id)
                .map(|f| f.reading.format.ending()),
            codes: contract.map(|c| texts(&c.codes)).unwrap_or_default(),
            verdict: result.map_or(Verdict::Invalid, |r| r.verdict).word(),
            findings: json::findings(sources, findings),
            core: result.map(|r| r.core.clone()).unwrap_or_default(),
            input_bits: bits(true),
            output_bits: bits(false),
            states: result
                .and_then(|r| r.controller.as_ref()?.machine())
                .map(|m| m.states.len()),
            seconds: result.filter(|_| self.timing).map(|r| r.seconds),
            peak_nodes: result.filter(|_| self.timing).and_then(|r| r.peak_nodes),
            statistics: result
                .filter(|_| self.statistics)
                .map(|r| r.statistics.timed(self.timing)),
            kernel: result
                .map(|r| r.statistics.kernel.clone())
                .unwrap_or_default(),
            verdict_only: result.is_some_and(|r| r.left_out),
        }
    }

    fn machine(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &mut Vec<Diagnostic>,
    ) -> MachineEntry {
        let planned = self
            .machines
            .iter()
            .find(|p| declaration.holds(p.machine.span));
        if let Some(planned) = planned {
            findings.extend(planned.findings(self.jobs, self.checked));
        }
        let composition = planned
            .and_then(|p| p.controlled(self.checked))
            .map(|c| libraries::compose(&c))
            .unwrap_or_default();
        let fits = !has_errors(&composition.findings);
        findings.extend(composition.findings);
        let verdict = match planned {
            Some(planned) if fits => planned.verdict(self.checked),
            _ => Verdict::Invalid,
        };
        MachineEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            codes: planned.map(|p| texts(&p.machine.codes)).unwrap_or_default(),
            verdict: verdict.word(),
            components: planned
                .map(|p| {
                    let components = p.machine.components.iter().zip(&p.jobs);
                    components
                        .map(|(c, job)| ComponentEntry {
                            name: c.name.clone(),
                            contract: c.contract.clone(),
                            verdict: self.checked[*job].verdict.word(),
                        })
                        .collect()
                })
                .unwrap_or_default(),
            discharges: composition
                .discharges
                .into_iter()
                .map(|d| DischargeEntry {
                    by: match d.by {
                        By::Guarantee(name) => name,
                        By::Coordinator => "the coordinator's reachable states".to_owned(),
                        By::Plant => "what the machine's file fixes".to_owned(),
                        By::Line => "the line, checked at every call".to_owned(),
                    },
                    component: d.component,
                    assumption: d.assumption,
                })
                .collect(),
            findings: json::findings(&self.loaded.library.sources, findings),
        }
    }
}

/// The entry of a file that holds no contract anybody could name.
fn nameless(file: &str) -> ContractEntry {
    let stem = std::path::Path::new(file).file_stem();
    ContractEntry {
        name: stem.map_or(file.to_owned(), |s| s.to_string_lossy().into_owned()),
        file: file.to_owned(),
        format: None,
        codes: Vec::new(),
        verdict: Verdict::Invalid.word(),
        findings: Vec::new(),
        core: Vec::new(),
        input_bits: None,
        output_bits: None,
        states: None,
        seconds: None,
        peak_nodes: None,
        statistics: None,
        kernel: String::new(),
        verdict_only: false,
    }
}

fn texts(codes: &[TaxonomyCode]) -> Vec<String> {
    codes.iter().map(|c| c.text.clone()).collect()
}

/// How many bits these variables need.
fn bits(specification: &Specification, variables: impl Iterator<Item = VarId>) -> u32 {
    variables
        .map(|v| specification.variable(v).domain.size())
        .map(|size| u64::BITS - size.saturating_sub(1).leading_zeros())
        .sum()
}
