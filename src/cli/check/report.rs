//! `--report`: the result of a check as a page.

use super::assembly::Assembly;
use super::document::{ContractEntry, Document, LineEntry, MachineEntry, PlayEntry, SkillsEntry};
use super::recipe_page;
use super::table::{Mark, by_severity, in_words, line_verdict, summary_of_verdicts, term};
use super::{changes, explained, flow, grounds};
use crate::contract::line::{Line, NodeKind, Supply};
use crate::contract::machine::{Component, Machine};
use crate::contract::{Contract, Definition, picture as machine_picture};
use crate::diagnostics::codes;
use crate::diagnostics::json::Finding;
use crate::engine::lines::LineVerdict;
use crate::engine::machine::{ClosedVerdict, RefinementVerdict};
use crate::engine::pipeline::{CheckedContract, Examination, Verdict};
use crate::engine::words::{ALWAYS_HOLDS, DischargeEntry, DischargeRuleName};
use crate::gr1::{Formula, Specification};
use crate::line::picture as line_picture;
use crate::report::html::contract::Rank;
use crate::report::html::parts::{
    Origin, count, drawing, figure, figures, findings, formula, links, names, origin, section,
    table, table_of, tile,
};
use crate::report::html::terms::{self, terms as terms_in};
use crate::report::html::{self, contract as parts};
use crate::source::SourceMap;
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// Returns the page. It is the same for the same result.
pub(super) fn page(assembly: &Assembly<'_>, document: &Document, of: &Origin<'_>) -> String {
    let main = main(assembly, document, of);
    let terms = terms_in(&main);
    // First what was asked about: a line stands before its machines, and these before their
    // contracts.
    let sections = [
        ("results", "Results", true),
        ("lines", "Lines", !document.lines.is_empty()),
        ("machines", "Machines", !document.machines.is_empty()),
        ("skills", "Skills", !document.skills.is_empty()),
        (
            recipe_page::ID,
            recipe_page::TITLE,
            recipe_page::is_shown(document),
        ),
        ("contracts", "Contracts", !document.contracts.is_empty()),
        (terms::LINK.0, terms::LINK.1, !terms.0.is_empty()),
        ("model", "Files", true),
    ];
    let shown = sections.iter().filter(|(.., is_there)| *is_there);
    let title = title(document);
    let body = html! {
        header {
            h1 { (title) }
            p { "A contract says what a controller may expect of its plant (assumptions) and what it has to do (guarantees). It is realizable if some controller keeps all guarantees as long as the assumptions hold; otherwise the report shows how the plant wins. A proof holds for every controller that keeps the contracts, unless it says something else." }
            p.hint { "In each step, a controller has to keep its guarantees unless the plant has broken an assumption in this step or before (strict semantics of Bloem et al., 2012)." }
            (links(shown.map(|(id, name, _)| (*id, *name))))
        }
        main {
            (main)
            (terms)
            // The findings are with what they are about.
            (origin("Files", &Origin { findings: &[], ..*of }, &[], &html! {}))
        }
    };
    html::document(&html::Document {
        title: &title,
        style: "",
        body: &body,
        data: None,
        script: "",
    })
}

/// What the page says about the result.
fn main(assembly: &Assembly<'_>, document: &Document, of: &Origin<'_>) -> Markup {
    html! {
        (tiles(document))
        (section("results", "Results", &results(document)))
        @if !document.findings.is_empty() {
            (section("findings", "Findings outside all declarations", &findings(of.sources, &document.findings)))
        }
        @if !document.lines.is_empty() {
            (section("lines", "Lines", &html! {
                @for (number, entry) in document.lines.iter().enumerate() { (line(assembly, document, number, entry)) }
            }))
        }
        @if !document.machines.is_empty() {
            (section("machines", "Machines", &html! {
                @for (number, entry) in document.machines.iter().enumerate() { (machine(assembly, document, number, entry)) }
            }))
        }
        @if !document.skills.is_empty() {
            (section("skills", "Skills", &html! {
                @for (number, entry) in document.skills.iter().enumerate() { (skills(number, entry, of.sources)) }
            }))
        }
        @if recipe_page::is_shown(document) {
            (section(recipe_page::ID, recipe_page::TITLE, &recipe_page::section(document, of.sources)))
        }
        @if !document.contracts.is_empty() {
            (section("contracts", "Contracts", &html! {
                @for (number, entry) in document.contracts.iter().enumerate() { (contract(assembly, number, entry, of.sources)) }
            }))
        }
    }
}

/// What was checked: a line, if there is only one; else the kinds of declarations.
fn title(document: &Document) -> String {
    match (document.lines.as_slice(), document.contracts.as_slice()) {
        ([line], _) => format!("Check of {}", line.name),
        ([], [contract]) => format!("Check of {}", contract.name),
        _ => "Check of contracts".to_owned(),
    }
}

fn tiles(document: &Document) -> Markup {
    let summary = &document.summary;
    let proved = |line: &&LineEntry| line.proof == Some(LineVerdict::Proved);
    let lines = document.lines.len();
    let fit = |machine: &&MachineEntry| machine.verdict == Verdict::Realizable;
    html! {
        dl.tiles {
            @if lines > 0 {
                (tile("Lines", &figures(lines), &format!("{} proved", figures(document.lines.iter().filter(proved).count()))))
            }
            @if !document.machines.is_empty() {
                (tile("Machines", &figures(document.machines.len()), &format!("{} realizable", figures(document.machines.iter().filter(fit).count()))))
            }
            (tile("Contracts", &figures(document.contracts.len()), &summary_of_verdicts(summary)))
            (tile("Findings", &figures(summary.findings), &by_severity(all_findings(document))))
        }
    }
}

/// All findings of the document.
fn all_findings(document: &Document) -> impl Iterator<Item = &Finding> {
    let lines = document.lines.iter().map(|entry| &entry.findings);
    let machines = document.machines.iter().map(|entry| &entry.findings);
    let skills = document.skills.iter().map(|entry| &entry.findings);
    let layouts = document.layouts.iter().map(|entry| &entry.findings);
    let recipes = document.recipes.iter().map(|entry| &entry.findings);
    let realizations = document.realizations.iter().map(|entry| &entry.findings);
    let contracts = document.contracts.iter().map(|entry| &entry.findings);
    let outside = std::iter::once(&document.findings);
    let all = lines.chain(machines).chain(skills).chain(layouts);
    let all = all.chain(recipes).chain(realizations).chain(contracts);
    all.chain(outside).flatten()
}

/// A declaration in the table of results.
pub(super) struct Row<'a> {
    pub(super) id: String,
    pub(super) name: &'a str,
    pub(super) kind: &'static str,
    pub(super) mark: Mark,
    pub(super) verdict: String,
    pub(super) details: String,
    pub(super) file: &'a str,
    pub(super) findings: &'a [Finding],
}

/// A table of everything that was checked, with links to the details.
fn results(document: &Document) -> Markup {
    let mut rows: Vec<Row<'_>> = Vec::new();
    for (number, l) in document.lines.iter().enumerate() {
        rows.push(Row {
            id: id("line", number),
            name: &l.name,
            kind: "line",
            mark: Mark::of_line(l),
            verdict: in_words(l.verdict),
            details: proof_in_words(l).to_owned(),
            file: &l.file,
            findings: &l.findings,
        });
    }
    for (number, m) in document.machines.iter().enumerate() {
        rows.push(Row {
            id: id("machine", number),
            name: &m.name,
            kind: "machine",
            mark: m.verdict.into(),
            verdict: in_words(m.verdict),
            details: count(m.components.len(), "component"),
            file: &m.file,
            findings: &m.findings,
        });
    }
    for (number, s) in document.skills.iter().enumerate() {
        rows.push(Row {
            id: id("skills", number),
            name: &s.name,
            kind: "skills",
            mark: s.verdict.into(),
            verdict: in_words(s.verdict),
            details: format!("{}, {}", count(s.skills, "skill"), count(s.rules, "rule")),
            file: &s.file,
            findings: &s.findings,
        });
    }
    rows.extend(recipe_page::rows(document));
    for (number, c) in document.contracts.iter().enumerate() {
        rows.push(Row {
            id: id("contract", number),
            name: &c.name,
            kind: "contract",
            mark: c.verdict.into(),
            verdict: in_words(c.verdict),
            details: terms(&c.codes),
            file: &c.file,
            findings: &c.findings,
        });
    }
    let has_details = rows.iter().any(|row| !row.details.is_empty());
    let mut headings = vec!["Name", "Kind", "Verdict"];
    headings.extend(has_details.then_some("Details"));
    headings.extend(["File", "Findings"]);
    let codes = document.contracts.iter().flat_map(|c| &c.codes);
    html! {
        (table_of("Results", &headings, &html! {
            @for row in &rows { tr {
                th scope="row" { a href=(format!("#{}", row.id)) { (row.name) } }
                td { (row.kind) }
                td.(row.mark.with(row.findings).class()) { (row.verdict) }
                @if has_details { td { (row.details) } }
                td { (row.file) }
                td.counts { @match by_severity(row.findings).as_str() { "" => "none", counts => (counts) } }
            } }
        }))
        @if let Some(standards) = parts::standards(codes.map(String::as_str)) { p.hint { (standards) } }
    }
}

/// `vdi:Drehen Rotating, +1 more code`: the first code with its English term, and how many more
/// there are.
fn terms(codes: &[String]) -> String {
    let Some((first, more)) = codes.split_first() else {
        return String::new();
    };
    let term = term(std::slice::from_ref(first));
    match more.len() {
        0 => term,
        number => format!("{term}, +{}", count(number, "more code")),
    }
}

/// The anchor of a declaration. Several files can declare the same name.
pub(super) fn id(kind: &str, number: usize) -> String {
    format!("{kind}-{}", number + 1)
}

/// The frame of a declaration: its name, file and verdict.
pub(super) fn declaration(
    id: &str,
    (name, file): (&str, &str),
    mark: Mark,
    verdict: &str,
    found: &[Finding],
    inside: &Markup,
) -> Markup {
    let counts = by_severity(found);
    html! {
        article id=(id) {
            h3 { (name) " " span.verdict.(mark.with(found).class()) { (verdict) } }
            p.place { (file) @if !counts.is_empty() { "; " (counts) } }
            (inside)
        }
    }
}

fn contract(
    assembly: &Assembly<'_>,
    number: usize,
    entry: &ContractEntry,
    sources: &SourceMap,
) -> Markup {
    let known = assembly.contract_of(&entry.file, &entry.name);
    let mut found = entry.findings.clone();
    for finding in &mut found {
        // Its help lists the changes that are shown above it.
        if finding.code == codes::UNREALIZABLE.id && !entry.suggestions.is_empty() {
            finding.help = None;
        }
    }
    let inside = html! {
        @if let Some((contract, checked)) = known {
            (parts::description(contract))
            (verdict_on_contract(contract, checked, entry, sources))
        }
        (findings(sources, &found))
        @if let Some((contract, _)) = known {
            details {
                summary { "Interface and rules" }
                (parts::parameters(contract))
                (parts::interface(&contract.specification, Rank::Declaration))
                (parts::rules(&contract.specification, assembly.loaded.library.definitions_of(contract), sources, Rank::Declaration))
            }
        }
    };
    declaration(
        &id("contract", number),
        (&entry.name, &entry.file),
        entry.verdict.into(),
        &in_words(entry.verdict),
        &entry.findings,
        &inside,
    )
}

/// What the verdict means for this contract, and why the plant wins if it does.
fn verdict_on_contract(
    contract: &Contract,
    checked: Option<&CheckedContract>,
    entry: &ContractEntry,
    sources: &SourceMap,
) -> Markup {
    let specification = &contract.specification;
    let explanation = checked.and_then(|c| c.explanation.as_ref());
    let play = explanation.and_then(|e| e.play.as_ref());
    let advice = explanation.and_then(|e| e.advice.as_ref());
    html! {
        @if let Some(states) = entry.states {
            p { "A controller with " (count(states, "state")) ", not counting the start before step 0, keeps all guarantees as long as the plant keeps the assumptions; it was verified." }
        }
        @match entry.examination {
            Some(Examination::VerdictOnly) => {
                p { "Only the verdict was computed, because the contract is large." }
            }
            Some(Examination::Partial) => {
                p { "It was not examined completely within the work limit, so findings can be missing." }
            }
            Some(Examination::Complete) | None => {}
        }
        @if !entry.core.is_empty() {
            h4 { "Guarantees that clash" }
            (named_rules(&entry.core, specification.guarantees.all(), sources))
        }
        @if !entry.matters.is_empty() {
            h4 { "Assumptions that matter" }
            p { "Each of them matters: if it is left out, a smaller set of guarantees already clashes." }
            (named_rules(&entry.matters, specification.assumptions.all(), sources))
        }
        @if let (Some(play), Some(shown)) = (play, &entry.play) {
            h4 { "A play that the plant wins" }
            p { (ending(shown)) }
            (parts::play(
                &format!("a play that the plant wins against {}", contract.name),
                specification,
                &explained::steps(specification, play),
                shown.repeats_from,
            ))
        }
        @if let (false, Some(advice)) = (entry.suggestions.is_empty(), advice) { (changes::section(contract, advice, entry)) }
        @if let Some(counter) = &entry.counterstrategy {
            p { "The strategy by which the plant wins (the counterstrategy) has " (count(counter.states, "state")) ". The command " code { "linewright synth --counterstrategy --report FILE" } " shows it." }
        }
    }
}

/// How a play ends, in words.
fn ending(play: &PlayEntry) -> Markup {
    html! {
        @if let Some(goal) = &play.never {
            "The play repeats for ever"
            @if let Some(step) = play.repeats_from { " from step " (step) " on" }
            ", without meeting " code { (goal) } "."
        } @else if play.clash.is_empty() {
            "The machine has no move in the last step."
        } @else {
            "In the last step, no answer of the machine keeps "
            @for (index, rule) in play.clash.iter().enumerate() {
                @if index > 0 { (if index + 1 == play.clash.len() { " and " } else { ", " }) }
                code { (rule) }
            }
            "."
        }
    }
}

/// Rules by name, each with its formula and place.
fn named_rules<'a>(
    names: &[String],
    formulas: impl Iterator<Item = &'a Formula>,
    sources: &SourceMap,
) -> Markup {
    let formulas: Vec<&Formula> = formulas.collect();
    let of = |name: &str| formulas.iter().find(|f| f.name == name);
    table_of(
        "Rules",
        &["Rule", "Formula", "Place"],
        &html! {
            @for name in names { tr {
                th scope="row" { (name) }
                @if let Some(formula) = of(name) {
                    td { (self::formula(&formula.text)) }
                    td { (sources.file(formula.span.file).name) ":" (sources.start(formula.span).line) }
                } @else { td {} td {} }
            } }
        },
    )
}

fn skills(number: usize, entry: &SkillsEntry, sources: &SourceMap) -> Markup {
    let inside = html! {
        p { (count(entry.skills, "skill")) ", " (count(entry.rules, "rule")) "." }
        (findings(sources, &entry.findings))
    };
    declaration(
        &id("skills", number),
        (&entry.name, &entry.file),
        entry.verdict.into(),
        &in_words(entry.verdict),
        &entry.findings,
        &inside,
    )
}

fn machine(
    assembly: &Assembly<'_>,
    document: &Document,
    number: usize,
    entry: &MachineEntry,
) -> Markup {
    let sources = &assembly.loaded.library.sources;
    let known = grounds::declared(entry, assembly.loaded);
    let inputs = |name: &str| {
        let mut components = known?.components.iter();
        components.find(|c| c.name == name)
    };
    let inside = html! {
        @if let Some(known) = known {
            (drawing(&machine_picture::to_svg(known), &format!("Components of {} with their wires", entry.name)))
        }
        (table_of("Components", &["Component", "Contract", "Verdict", "Inputs and what they get"], &html! {
            @for c in &entry.components { tr {
                th scope="row" { (c.name) }
                td { (c.contract) }
                td { (in_words(c.verdict)) }
                td { @if let (Some(machine), Some(component)) = (known, inputs(&c.name)) {
                    (wiring(machine, component))
                } }
            } }
        }))
        p.hint { "An input that is not named gets the signal of the same name." }
        @if let Some(closed) = &entry.closed {
            p {
                "The controllers that were synthesized were also examined together: " (match closed.verdict {
                    ClosedVerdict::Holds => "they meet all obligations",
                    ClosedVerdict::Broken => "a run violates an obligation",
                    ClosedVerdict::Open => "some obligation is undecided, because a component is represented by its contract",
                    ClosedVerdict::GaveUp => "the obligations were not decided within the limits",
                })
                @if let Some(states) = closed.states { "; their composition has " (figure(states as f64)) " reachable states (combinations of the values of all signals, the states of the controllers and the progress of the operation)" }
                "."
            }
        }
        (grounds::of_machine(entry, known, document, sources))
        (discharges(&entry.discharges, false))
        @for refined in &entry.refines {
            h4 { "Refinement of " (refined.contract) }
            p { (match refined.verdict {
                RefinementVerdict::Refined => "The machine keeps this contract.",
                RefinementVerdict::Broken => "The machine does not keep this contract; it meets these obligations (they are discharged).",
                RefinementVerdict::GaveUp => "Whether the machine keeps this contract was not decided within the limits.",
            }) }
            @if let Some(specification) = known.and_then(|machine| specification_of(machine, &refined.contract)) {
                details {
                    summary { "Interface and rules of " (refined.contract) }
                    (parts::interface(specification, Rank::Declaration))
                    (parts::rules(specification, definitions_of(assembly, &refined.contract), sources, Rank::Declaration))
                }
            }
            (discharges(&refined.discharges, false))
        }
        (findings(sources, &entry.findings))
    };
    declaration(
        &id("machine", number),
        (&entry.name, &entry.file),
        entry.verdict.into(),
        &in_words(entry.verdict),
        &entry.findings,
        &inside,
    )
}

/// The specification of a contract that a machine refines.
fn specification_of<'a>(machine: &'a Machine, contract: &str) -> Option<&'a Specification> {
    let mut refined = machine.refines.iter();
    let refined = refined.find(|refined| refined.contract == contract)?;
    Some(&refined.specification)
}

/// The definitions of the rules of a contract that a machine refines.
fn definitions_of<'a>(assembly: &'a Assembly<'_>, contract: &str) -> &'a [Definition] {
    let library = &assembly.loaded.library;
    let known = library.contracts.iter().find(|c| c.name == contract);
    known.map_or(&[], |contract| library.definitions_of(contract))
}

/// How each assumption is met, what this rests on, and what the rules say that are named: in words
/// for a line, which has no text for them.
fn discharges(discharges: &[DischargeEntry], in_words: bool) -> Markup {
    if discharges.is_empty() {
        return html! {};
    }
    // Not as formulas: these words would be listed as terms that the page uses.
    let words = ["always", "never", "responds", "precedes"];
    let mut formulas = discharges.iter().flat_map(|d| &d.formulas);
    let has_first = !in_words && formulas.any(|of| !words.iter().any(|w| of.text.contains(w)));
    let mut formulas = discharges.iter().flat_map(|d| &d.formulas);
    let has_facts = formulas.any(|of| is_fact(&of.name));
    html! {
        details {
            summary { "How each of " (figures(discharges.len())) " assumptions and guarantees is met (discharged)" }
            (table_of("Discharges", &["Assumption or guarantee", "Why it holds", "Rests on"], &html! {
                @for d in discharges { tr {
                    th scope="row" { (names(&format!("{}: {}", d.component, d.assumption))) }
                    td { (argument(d)) }
                    td { (names(grounds::rests_on(d))) }
                } }
            }))
            p { "What the rules say that are named above" @if has_first { " (an assumption or guarantee without \"always\", \"never\", \"responds\" or \"precedes\" is about step 0)" } ":" }
            @if has_facts { p.hint { "Rules named \"signal ...\", \"... is held\" and \"... is known\" are declared in the machine's file: they say what the inputs from the plant, the part and the operation do, in every step. An assumption that follows from these rules alone is listed as assumed about the environment." } }
            (table_of("Rules", &["Rule", "What it says"], &html! {
                @for (name, text) in what_rules_say(discharges) { tr {
                    th scope="row" { (names(&name)) }
                    td { @if in_words { (text) } @else { (formula(text)) } }
                } }
            }))
        }
    }
}

/// Whether a rule of this name is a fact that the machine's file declares.
fn is_fact(name: &str) -> bool {
    name.starts_with("signal ") || name.ends_with(" is held") || name.ends_with(" is known")
}

/// The rules that are named in discharges, with their texts. The name of the owner is left out if
/// the rule says the same wherever it occurs.
fn what_rules_say(discharges: &[DischargeEntry]) -> Vec<(String, &str)> {
    let mut rules: BTreeMap<&str, BTreeMap<&str, BTreeSet<&str>>> = BTreeMap::new();
    for rule in discharges.iter().flat_map(|d| &d.formulas) {
        let texts = rules.entry(&rule.name).or_default();
        texts.entry(&rule.text).or_default().insert(&rule.owner);
    }
    let named = rules.into_iter().flat_map(|(name, texts)| {
        let are_several = texts.len() > 1;
        texts.into_iter().map(move |(text, owners)| {
            let owners: Vec<&str> = owners
                .into_iter()
                .filter(|owner| !owner.is_empty())
                .collect();
            if are_several && !owners.is_empty() {
                (format!("{}: {name}", owners.join(", ")), text)
            } else {
                (name.to_owned(), text)
            }
        })
    });
    named.collect()
}

/// Why an obligation holds, in plain words with the term of the field.
fn argument(discharge: &DischargeEntry) -> String {
    match (discharge.rule, discharge.turn) {
        _ if discharge.by == ALWAYS_HOLDS => "needs no premise".to_owned(),
        (DischargeRuleName::Environment, _) => "assumed about the environment".to_owned(),
        (DischargeRuleName::Exported, _) => grounds::LEFT_TO_CALLER.to_owned(),
        (DischargeRuleName::Induction, _) => {
            "shown for step 0 and from each step to the next, where the rule applies (induction)"
                .to_owned()
        }
        (DischargeRuleName::Justice, _) => "happens again and again (justice)".to_owned(),
        (DischargeRuleName::Controllers, _) => {
            "true of the controllers that were synthesized".to_owned()
        }
    }
}

/// What is proved of a line, in short.
fn proof_in_words(line: &LineEntry) -> &'static str {
    match line.proof {
        Some(LineVerdict::Proved) if !line.premises.is_empty() => "proved under premises",
        _ => line_verdict(line),
    }
}

fn line(assembly: &Assembly<'_>, document: &Document, number: usize, entry: &LineEntry) -> Markup {
    let work = entry.work.iter();
    let work = work.map(|w| {
        vec![
            w.station.clone(),
            w.part.clone(),
            flow::range(w.seconds),
            flow::range(w.action_seconds),
            flow::range(w.control_seconds),
        ]
    });
    let library = &assembly.loaded.library;
    let sources = &library.sources;
    let is_same = |l: &&Line| l.name == entry.name && sources.file(l.span.file).name == entry.file;
    let known = library.lines.iter().find(is_same);
    let inside = html! {
        @if let Some(known) = known {
            (drawing(&line_picture::to_svg(known, sources), &format!("Places of {} with their routes", entry.name)))
            (notes(known))
        }
        p { (match entry.proof {
            Some(LineVerdict::Proved) => "It is proved that the line has no deadlock and that every part keeps moving, in every order in which parts can come, whatever the times are.",
            Some(LineVerdict::Safe) => "It is proved that there is no global deadlock. Whether every part keeps moving was not decided.",
            Some(LineVerdict::Open) => "The proof that every part keeps moving failed; the findings say why.",
            Some(LineVerdict::GaveUp) => "The proof reached a limit: nothing is known.",
            None => "There is no proof, because the line cannot be run.",
        }) }
        @if entry.proof.is_some() { (grounds::of_line(entry, known, document, assembly.loaded)) }
        @if !entry.undecided.is_empty() {
            p { "Not decided:" }
            ul { @for goal in &entry.undecided { li { (goal) } } }
        }
        @if let Some(unused) = known.map(unused).filter(|unused| !unused.is_empty()) {
            p { "No route leads to or from " (unused.join(", ")) ", so it is not used." }
        }
        @if !entry.not_controlled.is_empty() {
            p { "These stations are given by their times. The proof takes for granted that their work ends: " (entry.not_controlled.join(", ")) "." }
        }
        @if let Some(slowest) = known.and_then(|line| flow::slowest(line, &entry.work)) {
            h4 { "Slowest station" }
            p { (slowest) }
            p.hint { "This bound counts the work alone: failures, setup, transport and calendars make the line slower." }
        }
        @if !entry.work.is_empty() {
            h4 { "Time of the work on a part, without failures" }
            p { "A range is over all values that a part can have, and all states in which it can find the machine. Actions: the time in which some action of the machine goes on. Control: the time of the steps in which none does, such as those in which the coordinator begins an action or notices its end; each takes as long as the " code { "step" } " of the machine. Both together are the work." }
            (table(&["Station", "Part", "Work", "Actions", "Control"], &work.collect::<Vec<_>>()))
        }
        (discharges(&entry.discharges, true))
        (findings(sources, &entry.findings))
    };
    let verdict = match proof_in_words(entry) {
        "" => in_words(entry.verdict),
        proof => format!("{}, {proof}", in_words(entry.verdict)),
    };
    declaration(
        &id("line", number),
        (&entry.name, &entry.file),
        Mark::of_line(entry),
        &verdict,
        &entry.findings,
        &inside,
    )
}

/// What the words in the drawing of a line mean.
fn notes(line: &Line) -> Markup {
    let is_there = |what: fn(&NodeKind) -> bool| line.nodes.iter().any(|node| what(&node.kind));
    let on_order = |kind: &NodeKind| {
        matches!(
            kind,
            NodeKind::Source {
                supply: Supply::OnOrder,
                ..
            }
        )
    };
    let limited = |kind: &NodeKind| matches!(kind, NodeKind::Source { most: Some(_), .. });
    let reorders = |kind: &NodeKind| {
        matches!(
            kind,
            NodeKind::Sink {
                reorder: Some(_),
                ..
            }
        )
    };
    html! {
        @if is_there(on_order) || is_there(limited) || is_there(reorders) { p.hint {
            @if is_there(on_order) { "On order: the source makes the parts for the number of products that a run is to make; without such a number, or with several end products, it makes parts without end. " }
            @if is_there(limited) { "At most so many in the line: the source stops while that many parts of its type are in the line, also joined into others. " }
            @if is_there(reorders) { "Reorders from: for each rejected part, that source has to make a replacement." }
        } }
    }
}

/// Names of the places to and from which no route leads.
fn unused(line: &Line) -> Vec<&str> {
    let nodes = line.nodes.iter().enumerate();
    let unused = nodes.filter(|(number, _)| {
        let mut routes = line.routes.iter();
        !routes.any(|route| route.from == *number || route.to == *number)
    });
    unused.map(|(_, node)| node.name.as_str()).collect()
}

/// The inputs of a component that get something with another name, each with what it gets.
fn wiring(machine: &Machine, component: &Component) -> Markup {
    let wired = machine_picture::inputs(machine, component);
    html! {
        @for (number, (input, value)) in wired.iter().enumerate() {
            @if number > 0 { br; }
            (formula(input)) " gets " (formula(value))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::words::NamedFormula;

    #[test]
    fn codes_are_counted_in_words() {
        let codes = |codes: &[&str]| {
            let codes: Vec<String> = codes.iter().map(|code| (*code).to_owned()).collect();
            terms(&codes)
        };
        assert_eq!(codes(&[]), "");
        assert_eq!(codes(&["vdi:Drehen"]), "vdi:Drehen Rotating");
        assert_eq!(
            codes(&["vdi:Drehen", "din:4.1"]),
            "vdi:Drehen Rotating, +1 more code"
        );
    }

    #[test]
    fn rules_that_say_the_same_are_one() {
        let rule = |owner: &str, name: &str, text: &str| NamedFormula {
            owner: owner.to_owned(),
            name: name.to_owned(),
            text: text.to_owned(),
        };
        let entry = |formulas| DischargeEntry {
            component: String::new(),
            assumption: String::new(),
            rule: DischargeRuleName::Induction,
            turn: None,
            by: String::new(),
            formulas,
        };
        let entries = [
            entry(vec![
                rule("belt", "one_at_a_time", "one"),
                rule("cell", "takes_in_the_end", "if there is room"),
            ]),
            entry(vec![
                rule("cell", "one_at_a_time", "one"),
                rule("belt", "takes_in_the_end", "if it is not full"),
            ]),
        ];
        let wanted = [
            ("one_at_a_time".to_owned(), "one"),
            ("belt: takes_in_the_end".to_owned(), "if it is not full"),
            ("cell: takes_in_the_end".to_owned(), "if there is room"),
        ];
        assert_eq!(what_rules_say(&entries), wanted);
    }
}
