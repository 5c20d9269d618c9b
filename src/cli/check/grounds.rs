//! What the proofs of machines and lines rest on: premises, each with its place.

use super::document::{Document, LineEntry, MachineEntry};
use crate::contract::line::Line;
use crate::contract::machine::Machine;
use crate::engine::files::LoadedFiles;
use crate::engine::machine::RefinementVerdict;
use crate::engine::machines;
use crate::engine::words::{ALWAYS_HOLDS, DischargeEntry, DischargeRuleName};
use crate::report::html::parts::{formula, names, table_of};
use crate::source::{SourceMap, Span};
use maud::{Markup, html};

/// A premise of a proof.
struct Premise {
    name: String,
    /// The formula in the notation of contracts, or a sentence.
    says: Says,
    kind: &'static str,
    /// The proof that rests on it.
    proof: String,
    /// What it rests on; empty if nothing is known of it.
    by: String,
    place: Option<Span>,
}

/// What a premise says.
enum Says {
    Formula(String),
    Words(String),
}

/// The premises of the proof of a machine.
pub(super) fn of_machine(
    entry: &MachineEntry,
    machine: Option<&Machine>,
    document: &Document,
    sources: &SourceMap,
) -> Markup {
    html! {
        (refinements([entry], document))
        (shown(&machine_premises(entry, machine, ""), sources))
    }
}

/// The premises of the proof of a line, with those of its machines.
pub(super) fn of_line(
    entry: &LineEntry,
    line: Option<&Line>,
    document: &Document,
    loaded: &LoadedFiles,
) -> Markup {
    let sources = &loaded.library.sources;
    let place = |name: &str| {
        let mut nodes = line?.nodes.iter();
        nodes.find(|node| node.name == name).map(|node| node.span)
    };
    let mut premises: Vec<Premise> = Vec::new();
    premises.extend(entry.premises.iter().map(|premise| Premise {
        name: premise.name.clone(),
        says: Says::Words(premise.text.clone()),
        kind: "assumed about the surroundings of the line",
        proof: entry.name.clone(),
        by: String::new(),
        place: Some(premise.place),
    }));
    premises.extend(entry.not_controlled.iter().map(|station| Premise {
        name: format!("work_of_{station}_ends"),
        says: Says::Words(format!("the work of {station} always ends")),
        kind: "assumed, because the station is given by its times and has no controller",
        proof: entry.name.clone(),
        by: String::new(),
        place: place(station),
    }));
    let outside = entry.discharges.iter().filter(|d| kind(d).is_some());
    premises.extend(outside.map(|discharge| Premise {
        name: named("", discharge),
        says: Says::Words(String::new()),
        kind: kind(discharge).unwrap_or_default(),
        proof: entry.name.clone(),
        by: rests_on(discharge).to_owned(),
        place: place(&discharge.component),
    }));
    let of_line: Vec<&str> = line.map_or(Vec::new(), |line| {
        let machines = machines::of_line(line).into_iter();
        machines.map(|machine| machine.name.as_str()).collect()
    });
    let known = document.machines.iter();
    let known = known.filter(|machine| of_line.contains(&machine.name.as_str()));
    for machine in known.clone() {
        let declared = declared(machine, loaded);
        premises.extend(machine_premises(machine, declared, &machine.name));
    }
    html! {
        (refinements(known, document))
        (shown(&premises, sources))
    }
}

/// The machine of an entry.
pub(super) fn declared<'a>(entry: &MachineEntry, loaded: &'a LoadedFiles) -> Option<&'a Machine> {
    let library = &loaded.library;
    let mut machines = library.machines.iter();
    machines.find(|machine| {
        machine.name == entry.name && library.sources.file(machine.span.file).name == entry.file
    })
}

/// The premises of a machine's proof. `owner` comes before each name; empty for none.
fn machine_premises(entry: &MachineEntry, machine: Option<&Machine>, owner: &str) -> Vec<Premise> {
    let own = entry.discharges.iter();
    let own = own.map(|discharge| (entry.name.clone(), discharge));
    let refined = entry.refines.iter().flat_map(|refined| {
        let proof = format!("{} refines {}", entry.name, refined.contract);
        let discharges = refined.discharges.iter();
        discharges.map(move |discharge| (proof.clone(), discharge))
    });
    let outside = own.chain(refined);
    let outside = outside.filter_map(|(proof, d)| Some((proof, d, kind(d)?)));
    let premises = outside.map(|(proof, discharge, kind)| {
        let formula = machine.and_then(|machine| {
            let mut components = machine.components.iter();
            let component = components.find(|c| c.name == discharge.component)?;
            let mut formulas = component.specification.assumptions.all();
            formulas.find(|formula| formula.name == discharge.assumption)
        });
        Premise {
            name: named(owner, discharge),
            says: match formula {
                Some(formula) => Says::Formula(formula.text.clone()),
                None => Says::Words(String::new()),
            },
            kind,
            proof,
            by: rests_on(discharge).to_owned(),
            place: formula.map(|formula| formula.span),
        }
    });
    premises.collect()
}

fn named(owner: &str, discharge: &DischargeEntry) -> String {
    let name = format!("{}: {}", discharge.component, discharge.assumption);
    match owner {
        "" => name,
        owner => format!("{owner}, {name}"),
    }
}

/// How a page says that an assumption is passed on to the caller of a machine.
pub(super) const LEFT_TO_CALLER: &str =
    "left to the caller: the check of a line reports each call that breaks it";

/// What an obligation rests on, apart from the caller; empty if nothing is known of it.
pub(super) fn rests_on(discharge: &DischargeEntry) -> &str {
    match discharge.rule {
        DischargeRuleName::Exported => "",
        _ => &discharge.by,
    }
}

/// What kind of premise an obligation is; `None` if the proof shows it.
fn kind(discharge: &DischargeEntry) -> Option<&'static str> {
    match discharge.rule {
        _ if discharge.by == ALWAYS_HOLDS => None,
        DischargeRuleName::Environment => Some("assumed about the environment"),
        DischargeRuleName::Exported => Some(LEFT_TO_CALLER),
        DischargeRuleName::Controllers => Some(
            "true of the controllers that were synthesized, not of all that keep the contracts",
        ),
        DischargeRuleName::Induction | DischargeRuleName::Justice => None,
    }
}

fn shown(premises: &[Premise], sources: &SourceMap) -> Markup {
    if premises.is_empty() {
        return html! {};
    }
    let place = |span: Span| {
        let file = &sources.file(span.file).name;
        format!("{file}:{}", sources.start(span).line)
    };
    let are_several = premises.iter().any(|of| of.proof != premises[0].proof);
    let mut headings = vec!["Premise", "What it says", "Why the proof may use it"];
    headings.extend(are_several.then_some("In the proof of"));
    headings.push("Place");
    html! {
        h4 { "What the proof rests on" }
        p { "The proof holds provided that these premises do, and that every controller keeps its contract." }
        @if are_several { p { "The same assumption can be a premise of several proofs, each time for a reason of its own." } }
        (table_of("Premises", &headings, &html! {
            @for premise in premises { tr {
                th scope="row" { (names(&premise.name)) }
                td { @match &premise.says {
                    Says::Formula(text) => (formula(text)),
                    Says::Words(words) => (words),
                } }
                td { (premise.kind) @if !premise.by.is_empty() { ": " (names(&premise.by)) } }
                @if are_several { td { (premise.proof) } }
                td { @if let Some(span) = premise.place { (place(span)) } }
            } }
        }))
    }
}

/// What it means that machines refine contracts, and whether they do.
fn refinements<'a>(
    machines: impl IntoIterator<Item = &'a MachineEntry>,
    document: &Document,
) -> Markup {
    let pairs = machines.into_iter().flat_map(|machine| {
        let refined = machine.refines.iter();
        refined.map(|refined| (&machine.name, refined))
    });
    let is_listed = |contract: &str| document.contracts.iter().any(|c| c.name == contract);
    html! {
        @for (machine, refined) in pairs { p {
            (refined.contract) " is a contract of the machine " (machine) " as a whole."
            @if !is_listed(&refined.contract) { " No component has it, so it is not among the contracts of this page." }
            " " (match refined.verdict {
                RefinementVerdict::Refined => "It is proved that the components together keep it, as long as its assumptions hold.",
                RefinementVerdict::Broken => "It is not proved that the components together keep it; the findings say why.",
                RefinementVerdict::GaveUp => "Whether the components together keep it was not decided within the limits.",
            })
        } }
    }
}
