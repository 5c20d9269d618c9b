//! A play, step by step, as a page.

use super::contract::Rank;
use super::parts::{self, Origin, links, section, table, tile};
use super::{Document, contract as of_contract, document};
use linewright_core::gr1::{Owner, VarId};
use linewright_language::contract::{Contract, Definition};
use maud::{Markup, html};

/// Maximum number of steps in the table of steps.
const MAX_LISTED: usize = 2000;

/// What a page shows.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The contract.
    pub contract: &'a Contract,
    /// The definitions that its rules use.
    pub definitions: &'a [Definition],
    /// The side that the person played.
    pub person: Owner,
    /// Values of all variables in each step.
    pub steps: &'a [Vec<i64>],
    /// The commands, each with what was answered.
    pub commands: &'a [(String, String)],
    /// Why the play is over; `None` if it is not.
    pub over: Option<&'a str>,
    /// Where the result comes from.
    pub origin: Origin<'a>,
}

/// Returns the page. It is the same for the same play.
pub fn page(page: &Page<'_>) -> String {
    let name = &page.contract.name;
    let title = format!("A play of {name}");
    let (person, other) = match page.person {
        Owner::Environment => ("plant", "controller"),
        Owner::System => ("machine", "counterstrategy"),
    };
    let sections = [
        ("steps", "Steps"),
        ("commands", "Commands"),
        ("contract", "Contract"),
        ("model", "Files"),
    ];
    let body = html! {
        header {
            h1 { (title) }
            (of_contract::description(page.contract))
            p { "A person played the " (person) " against the " (other) "." }
            (links(sections))
        }
        main {
            dl.tiles {
                (tile("Steps", &parts::figures(page.steps.len()), ""))
                (tile("Commands", &parts::figures(page.commands.len()), ""))
            }
            @if let Some(over) = page.over { div.finding { pre tabindex="0" { (over.trim_end()) } } }
            (section("steps", "Steps", &steps(page)))
            (section("commands", "Commands", &html! {
                @for (command, answer) in page.commands {
                    p { code { "> " (command) } }
                    @if answer.is_empty() && command.starts_with("expect") { p { "as expected" } }
                    @if !answer.is_empty() { pre tabindex="0" { (answer.trim_end()) } }
                }
            }))
            (section("contract", "Contract", &html! {
                (of_contract::interface(&page.contract.specification, Rank::Section))
                (of_contract::rules(&page.contract.specification, page.definitions, page.origin.sources, Rank::Section))
            }))
            (parts::origin("Files", &page.origin, &[], &html! {}))
        }
    };
    document(&Document {
        title: &title,
        style: "",
        body: &body,
        data: None,
        script: "",
    })
}

fn steps(page: &Page<'_>) -> Markup {
    let specification = &*page.contract.specification;
    if page.steps.is_empty() {
        return html! { p { "No step was made." } };
    }
    let values: Vec<Vec<Option<i64>>> = page
        .steps
        .iter()
        .map(|step| step.iter().copied().map(Some).collect())
        .collect();
    let title = format!("a play of {}", page.contract.name);
    html! {
        (of_contract::play(&title, specification, &values, None))
        details {
            summary { "Show each step with its values" }
            @if page.steps.len() > MAX_LISTED { p.hint { "The first " (MAX_LISTED) " of " (page.steps.len()) " steps." } }
            (table(&["Step", "Inputs", "Outputs"], &page.steps.iter().take(MAX_LISTED).enumerate().map(|(number, step)| {
                let listed = |owner: Owner| {
                    let variables = specification.variables.iter().enumerate();
                    let shown = variables.filter(|(index, v)| v.owner == owner && !specification.is_auxiliary(VarId(*index as u32)));
                    let shown = shown.map(|(index, v)| format!("{} = {}", v.name, v.show(step[index])));
                    shown.collect::<Vec<_>>().join(", ")
                };
                vec![number.to_string(), listed(Owner::Environment), listed(Owner::System)]
            }).collect::<Vec<_>>()))
        }
    }
}
