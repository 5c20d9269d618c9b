//! Assembles the document from the results for contracts and machines.

use super::document::{
    ComponentEntry, ContractEntry, Document, LineEntry, MachineEntry, PremiseEntry,
    RealizationEntry, SkillsEntry, SkillsVerdict, Summary, Validity, WorkEntry,
};
use super::explained;
use super::view::FileView;
use crate::cli::console::schema;
use crate::cli::outline::{Declaration, Kind};
use crate::contract::machine::Machine;
use crate::contract::{Contract, TaxonomyCode};
use crate::diagnostics::{Diagnostic, Severity, codes, has_errors, json};
use crate::engine::files::LoadedFiles;
use crate::engine::findings::lost;
use crate::engine::internal;
use crate::engine::judgement;
use crate::engine::lines;
use crate::engine::machine::{self, MachineContext, MachineProof, StateCount};
use crate::engine::machines::{self, MachinePlan};
use crate::engine::pipeline::{CheckedContract, Examination, Jobs, Verdict};
use crate::engine::prover::Prover;
use crate::gr1::{Specification, VarId};
use crate::interchange::Format;
use crate::source::Span;
use indicatif::ProgressBar;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use std::path::Path;

/// The data from which the document is assembled.
pub(super) struct Assembly<'a> {
    pub(super) loaded: &'a LoadedFiles,
    pub(super) files: &'a [FileView<'a>],
    pub(super) contracts: &'a [(&'a Contract, usize)],
    pub(super) machines: &'a [MachinePlan<'a>],
    /// Machines to which lines give arguments other than the defaults, each with the place of the
    /// first such line.
    pub(super) instances: &'a [(Span, MachinePlan<'a>)],
    pub(super) jobs: &'a Jobs,
    pub(super) checked: &'a [CheckedContract],
    pub(super) prover: Prover<'a>,
    /// Progress over machines and lines, whose proofs take longest.
    pub(super) progress: &'a ProgressBar,
    /// Whether to compute the tables that take longer than the verdict.
    pub(super) verbose: bool,
    /// Whether to count the states of closed compositions.
    pub(super) state_count: StateCount,
    pub(super) timing: bool,
    pub(super) statistics: bool,
}

/// The entry of a machine, a line or a realization.
enum ProvedEntry {
    Machine(MachineEntry),
    Line(LineEntry),
    Realization(RealizationEntry),
}

impl Assembly<'_> {
    /// Returns the document, and all findings in it, each once.
    pub(super) fn document(&self) -> (Document, Vec<Diagnostic>) {
        let sources = &self.loaded.library.sources;
        let mut document = Document {
            schema: schema("check"),
            occasion: None,
            semantics: "strict",
            contracts: Vec::new(),
            skills: Vec::new(),
            layouts: Vec::new(),
            recipes: Vec::new(),
            realizations: Vec::new(),
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
        let mut proved = self.proved().into_iter();
        for file in self.files {
            loose.extend(file.outside());
            for declaration in &file.declarations {
                let mut findings = file.within(declaration);
                if self.is_omitted(declaration) && findings.is_empty() {
                    continue;
                }
                match declaration.kind {
                    Kind::Contract => {
                        let name = &declaration.name;
                        let doing = || format!("explaining the contract `{name}`");
                        let shown = internal::caught(doing, || {
                            self.contract(file, declaration, &mut findings)
                        });
                        let entry = shown.unwrap_or_else(|fault| {
                            findings.push(fault.finding(Some(declaration.extent)));
                            ContractEntry {
                                name: name.clone(),
                                verdict: Verdict::InternalError,
                                findings: json::findings(sources, &findings),
                                ..invalid_file(file.name)
                            }
                        });
                        document.contracts.push(entry);
                    }
                    Kind::Machine | Kind::Line | Kind::Realize => {
                        let (entry, found) = proved.next().expect("every one has an entry");
                        findings = found;
                        match entry {
                            ProvedEntry::Machine(entry) => document.machines.push(entry),
                            ProvedEntry::Line(entry) => document.lines.push(entry),
                            ProvedEntry::Realization(entry) => document.realizations.push(entry),
                        }
                    }
                    Kind::Skills => {
                        let entry = self.skills(file, declaration, &mut findings);
                        document.skills.push(entry);
                    }
                    Kind::Layout => {
                        document
                            .layouts
                            .push(self.layout(file, declaration, &findings));
                    }
                    Kind::Recipe => {
                        document
                            .recipes
                            .push(self.recipe(file, declaration, &findings));
                    }
                }
                all.extend(findings);
            }
            // If the file has no declaration, an entry for the file itself shows that it is
            // invalid.
            if file.broken && file.declarations.is_empty() {
                document.contracts.push(invalid_file(file.name));
            }
        }
        self.progress.finish_and_clear();
        self.invalidate_lines(&mut document);
        for path in &self.loaded.unreadable {
            document.contracts.push(invalid_file(path));
        }
        document.findings = json::findings(sources, &loose);
        all.extend(loose);
        for entry in &document.contracts {
            let count = match entry.verdict {
                Verdict::Realizable => &mut document.summary.realizable,
                Verdict::Unrealizable => &mut document.summary.unrealizable,
                Verdict::GaveUp => &mut document.summary.gave_up,
                Verdict::InternalError => &mut document.summary.internal_error,
                Verdict::Invalid => &mut document.summary.invalid,
            };
            *count += 1;
        }
        document.summary.findings = all.len();
        (document, all)
    }

    /// The contract with this name in this file, and its result if it was checked.
    pub(super) fn contract_of(
        &self,
        file: &str,
        name: &str,
    ) -> Option<(&Contract, Option<&CheckedContract>)> {
        let library = &self.loaded.library;
        let mut contracts = library.contracts.iter();
        let contract =
            contracts.find(|c| c.name == name && library.sources.file(c.span.file).name == file)?;
        let mut jobs = self.contracts.iter();
        let job = jobs.find(|(known, _)| std::ptr::eq(*known, contract));
        Some((contract, job.map(|(_, job)| &self.checked[*job])))
    }

    /// Proves the machines and lines, and decides what can be made, in parallel. Returns their
    /// entries and findings in the order of the declarations.
    fn proved(&self) -> Vec<(ProvedEntry, Vec<Diagnostic>)> {
        let declarations = self.files.iter().flat_map(|file| {
            let declarations = file.declarations.iter();
            declarations.map(move |declaration| (file, declaration))
        });
        let claims: Vec<_> = declarations
            .filter(|(_, d)| matches!(d.kind, Kind::Machine | Kind::Line | Kind::Realize))
            .collect();
        let prove = |(file, declaration): (&FileView<'_>, &Declaration)| {
            let mut findings = file.within(declaration);
            self.begin(&declaration.name);
            let entry = match declaration.kind {
                Kind::Machine => {
                    ProvedEntry::Machine(self.machine(file, declaration, &mut findings))
                }
                Kind::Realize => {
                    ProvedEntry::Realization(self.realization(file, declaration, &mut findings))
                }
                _ => ProvedEntry::Line(self.line(file, declaration, &mut findings)),
            };
            (entry, findings)
        };
        claims.into_par_iter().map(prove).collect()
    }

    /// Shows which proof is running.
    fn begin(&self, name: &str) {
        self.progress.set_message(name.to_owned());
        self.progress.inc(1);
    }

    /// Whether a declaration is a contract that was imported only to be refined.
    fn is_omitted(&self, declaration: &Declaration) -> bool {
        let mut contracts = self.loaded.library.contracts.iter();
        declaration.kind == Kind::Contract
            && contracts
                .any(|c| declaration.holds(c.span) && super::is_only_refined(self.loaded, c))
    }

    /// Replaces the verdict on each line with a machine that is invalid, unrealizable or failed,
    /// and removes the line's proof.
    fn invalidate_lines(&self, document: &mut Document) {
        let Document {
            machines, lines, ..
        } = document;
        let broken = [Verdict::Invalid, Verdict::Unrealizable];
        let failed = [Verdict::InternalError];
        let has = |verdicts: &[Verdict], name: &str| {
            machines
                .iter()
                .any(|m| m.name == name && verdicts.contains(&m.verdict))
        };
        for model in &self.loaded.library.lines {
            let of_line = machines::of_line(model);
            let verdict = if of_line.iter().any(|m| has(&failed, &m.name)) {
                Validity::InternalError
            } else if of_line.iter().any(|m| has(&broken, &m.name)) {
                Validity::Invalid
            } else {
                continue;
            };
            for entry in lines.iter_mut().filter(|l| l.name == model.name) {
                entry.verdict = verdict;
                entry.proof = None;
                entry.premises.clear();
                entry.undecided.clear();
                entry.discharges.clear();
            }
        }
    }

    /// Creates the entry of a contract; adds the findings of the pipeline to those of its text.
    fn contract(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &mut Vec<Diagnostic>,
    ) -> ContractEntry {
        let sources = &self.loaded.library.sources;
        let mut known = self.loaded.library.contracts.iter();
        let contract = known.find(|c| declaration.holds(c.span));
        let result = self
            .contracts
            .iter()
            .find(|(c, _)| declaration.holds(c.span))
            .map(|(_, job)| &self.checked[*job]);
        if let Some(result) = result {
            let mistakes = findings.clone();
            let others = result.findings.iter();
            let others = others.filter(|f| !is_consequence(f, &mistakes));
            findings.extend(others.cloned());
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
        let format = self.loaded.foreign(file.id).map(|f| f.reading.format);
        let shown =
            result.and_then(|r| Some((&*contract?.specification, r.explanation.as_deref()?)));
        ContractEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            format: format.map(Format::ending),
            codes: contract.map(|c| texts(&c.codes)).unwrap_or_default(),
            verdict: result.map_or(Verdict::Invalid, |r| r.verdict),
            findings: json::findings(sources, findings),
            core: result.map(|r| r.core.clone()).unwrap_or_default(),
            matters: shown
                .map(|(s, e)| lost::relevant_assumptions(s, e))
                .unwrap_or_default(),
            play: shown.and_then(|(s, e)| Some(explained::play(s, e.play.as_ref()?))),
            suggestions: shown
                .and_then(|(s, e)| Some(lost::suggestions(s, format, e.advice.as_ref()?)))
                .unwrap_or_default(),
            counterstrategy: shown
                .and_then(|(_, e)| Some(explained::counterstrategy(e.counterstrategy.as_ref()?))),
            well_separation: result
                .and_then(|r| Some(explained::well_separation(r.environment.as_ref()?))),
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
            examination: result
                .map(|r| r.examination)
                .filter(|examination| *examination != Examination::Complete),
        }
    }

    fn skills(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &mut Vec<Diagnostic>,
    ) -> SkillsEntry {
        let sound = !file.broken && !has_errors(findings);
        let mut known = self.loaded.library.skills.iter();
        let skills = known.find(|s| sound && declaration.holds(s.span));
        let until = self.prover.limits().deadline;
        let examined = skills.map(|s| judgement::skills(s, until));
        let verdict = match &examined {
            Some(examined) if is_failed(examined) => SkillsVerdict::InternalError,
            Some(examined) if has_errors(examined) => SkillsVerdict::Contradictory,
            Some(examined) if examined.iter().any(|f| f.code == codes::TOO_LARGE) => {
                SkillsVerdict::GaveUp
            }
            Some(_) => SkillsVerdict::Consistent,
            None => SkillsVerdict::Invalid,
        };
        findings.extend(examined.unwrap_or_default());
        SkillsEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            verdict,
            skills: skills.map_or(0, |s| s.skills.len()),
            rules: skills.map_or(0, |s| s.rules.len()),
            findings: json::findings(&self.loaded.library.sources, findings),
        }
    }

    fn line(
        &self,
        file: &FileView<'_>,
        declaration: &Declaration,
        findings: &mut Vec<Diagnostic>,
    ) -> LineEntry {
        let sound = !file.broken && !has_errors(findings);
        let mut known = self.loaded.library.lines.iter();
        let line = known.find(|l| sound && declaration.holds(l.span));
        let controlled = |machine: &Machine| {
            let alike = |p: &&MachinePlan<'_>| machines::is_alike(p.machine, machine);
            let instances = self.instances.iter().map(|(_, planned)| planned);
            let mut known = self.machines.iter().chain(instances);
            known.find(alike)?.controlled(self.checked)
        };
        // A line that is not in the library has an error, perhaps only in one of its machines.
        let mut fits = line.is_some();
        let mut gave_up = false;
        if let Some(line) = line {
            let own = self.instances.iter().filter(|(of, _)| *of == line.span);
            for found in own.map(|(_, planned)| self.instance_findings(planned)) {
                let mut errors = found.iter().filter(|f| f.severity == Severity::Error);
                gave_up |= errors.clone().any(|f| f.code == codes::GAVE_UP);
                fits &= errors.all(|f| f.code == codes::GAVE_UP);
                findings.extend(found);
            }
        }
        let failed = is_failed(findings);
        let proof = line.map(|line| {
            let doing = || format!("proving the line `{}`", line.name);
            internal::caught(doing, || {
                lines::examine(line, controlled, self.prover, self.verbose)
            })
        });
        let verdict = proof.as_ref().and_then(|p| Some(p.as_ref().ok()?.verdict));
        let proof = proof
            .unwrap_or_else(|| Ok(lines::Proof::default()))
            .unwrap_or_else(|fault| lines::Proof {
                findings: vec![fault.finding(line.map(|l| l.span))],
                ..lines::Proof::default()
            });
        let failed = failed || is_failed(&proof.findings);
        if proof.routes_decided {
            findings.retain(|f| !line.is_some_and(|line| lines::is_route_warning(f, line)));
        }
        findings.extend(proof.findings);
        LineEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            verdict: match (failed, sound && fits) {
                (true, _) => Validity::InternalError,
                (false, true) if gave_up => Validity::GaveUp,
                (false, true) => Validity::Valid,
                (false, false) => Validity::Invalid,
            },
            proof: verdict.filter(|_| fits && !gave_up),
            premises: proof.premises.into_iter().map(PremiseEntry::from).collect(),
            not_controlled: line.map_or_else(Vec::new, |line| {
                let stations = line.stations_without_machine();
                stations.map(|node| node.name.clone()).collect()
            }),
            undecided: proof.undecided,
            work: line.map_or_else(Vec::new, |line| {
                let times = proof.work_times.iter();
                times.map(|time| WorkEntry::new(line, time)).collect()
            }),
            discharges: proof.discharges,
            findings: json::findings(&self.loaded.library.sources, findings),
        }
    }

    /// Findings about a machine with the arguments that a line gives it.
    fn instance_findings(&self, planned: &MachinePlan<'_>) -> Vec<Diagnostic> {
        // Warnings are already reported for the machine with its default arguments.
        let mut found = planned.findings(self.jobs, self.checked);
        found.retain(|f| f.severity == Severity::Error);
        if let Some(controlled) = planned.controlled(self.checked) {
            found.extend(judgement::findings(&controlled, self.prover));
        }
        found
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
        let proved = planned
            .and_then(|p| p.controlled(self.checked))
            .map(|c| {
                let (name, span) = (&c.machine.name, c.machine.span);
                let doing = || format!("checking the machine `{name}`");
                let context = if machines::is_only_inner(c.machine, &self.loaded.library) {
                    MachineContext::Within
                } else {
                    MachineContext::Alone
                };
                let proved = internal::caught(doing, || {
                    machine::prove_machine(&c, context, self.prover, self.state_count)
                });
                proved.unwrap_or_else(|fault| MachineProof {
                    findings: vec![fault.finding(Some(span))],
                    ..MachineProof::default()
                })
            })
            .unwrap_or_default();
        let fits = !has_errors(&proved.findings);
        let failed = is_failed(&proved.findings);
        findings.extend(proved.findings);
        let verdict = match planned {
            _ if failed => Verdict::InternalError,
            Some(planned) if fits => planned.verdict(self.checked),
            _ => Verdict::Invalid,
        };
        MachineEntry {
            name: declaration.name.clone(),
            file: file.name.to_owned(),
            codes: planned.map(|p| texts(&p.machine.codes)).unwrap_or_default(),
            verdict,
            components: planned
                .map(|p| {
                    let components = p.machine.components.iter().zip(&p.jobs);
                    components
                        .map(|(c, job)| ComponentEntry {
                            name: c.name.clone(),
                            contract: c.contract.clone(),
                            verdict: self.checked[*job].verdict,
                        })
                        .collect()
                })
                .unwrap_or_default(),
            discharges: proved.discharges,
            closed: proved.closed,
            refines: proved.refines,
            findings: json::findings(&self.loaded.library.sources, findings),
        }
    }
}

/// Whether the findings show an internal error.
fn is_failed(findings: &[Diagnostic]) -> bool {
    findings.iter().any(|f| f.code == codes::INTERNAL)
}

/// Whether a finding is merely a consequence of a mistake in the text of the same formula.
fn is_consequence(finding: &Diagnostic, mistakes: &[Diagnostic]) -> bool {
    let is_vacuous = [codes::UNBREAKABLE, codes::CONDITION_NEVER_HOLDS].contains(&finding.code);
    let is_cause =
        |f: &Diagnostic| [codes::COMPARISON_DECIDED, codes::NEXT_BOTH_SIDES].contains(&f.code);
    let within = |f: &Diagnostic| match (finding.span, f.span) {
        (Some(formula), Some(mistake)) => formula.contains(mistake) || mistake.contains(formula),
        _ => false,
    };
    is_vacuous && mistakes.iter().any(|f| is_cause(f) && within(f))
}

/// Creates an entry for a file that cannot be read, or is invalid and has no declarations.
fn invalid_file(file: &str) -> ContractEntry {
    let stem = Path::new(file).file_stem();
    ContractEntry {
        name: stem.map_or(file.to_owned(), |s| s.to_string_lossy().into_owned()),
        file: file.to_owned(),
        format: None,
        codes: Vec::new(),
        verdict: Verdict::Invalid,
        findings: Vec::new(),
        core: Vec::new(),
        matters: Vec::new(),
        play: None,
        suggestions: Vec::new(),
        counterstrategy: None,
        well_separation: None,
        input_bits: None,
        output_bits: None,
        states: None,
        seconds: None,
        peak_nodes: None,
        statistics: None,
        kernel: String::new(),
        examination: None,
    }
}

fn texts(codes: &[TaxonomyCode]) -> Vec<String> {
    codes.iter().map(|c| c.text.clone()).collect()
}

/// Number of bits for these variables.
fn bits(specification: &Specification, variables: impl Iterator<Item = VarId>) -> u32 {
    variables
        .map(|v| specification.variable(v).domain.size())
        .map(|size| u64::BITS - size.saturating_sub(1).leading_zeros())
        .sum()
}
