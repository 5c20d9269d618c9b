//! A play, step by step, as a page.

use super::contract::Rank;
use super::parts::{self, Origin, links, section, table, tile};
use super::{Document, contract as of_contract, document, terms};
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
    /// The side that the commands played.
    pub person: Owner,
    /// Where the commands came from, as the subject of a sentence: `A person`.
    pub player: &'a str,
    /// The plays that a reset ended, and the last one: values of all variables in each step.
    pub plays: &'a [&'a [Vec<i64>]],
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
    let title = match page.plays.len() {
        0 | 1 => format!("A play of {name}"),
        plays => format!("{plays} plays of {name}"),
    };
    let (person, other) = match page.person {
        Owner::Environment => ("plant", "controller"),
        Owner::System => ("machine", "counterstrategy"),
    };
    let main = html! {
        dl.tiles {
            (tile("Steps", &parts::figures(page.plays.iter().map(|steps| steps.len()).sum()), &in_plays(page)))
            (tile("Commands", &parts::figures(page.commands.len()), "moves, and commands such as expect, undo and reset"))
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
            (of_contract::parameters(page.contract))
            (of_contract::interface(&page.contract.specification, Rank::Section))
            (of_contract::rules(&page.contract.specification, page.definitions, page.origin.sources, Rank::Section))
        }))
    };
    let terms = terms::terms(&html! { (of_contract::description(page.contract)) (main) });
    let sections = [
        ("steps", "Steps", true),
        ("commands", "Commands", true),
        ("contract", "Contract", true),
        (terms::LINK.0, terms::LINK.1, !terms.0.is_empty()),
        ("model", "Files", true),
    ];
    let shown = sections.iter().filter(|(.., is_there)| *is_there);
    let body = html! {
        header {
            h1 { (title) }
            (of_contract::description(page.contract))
            p { (page.player) " played the " (person) " against the " (other) "." }
            (links(shown.map(|(id, name, _)| (*id, *name))))
        }
        main {
            (main)
            (terms)
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

/// What the number of steps counts.
fn in_plays(page: &Page<'_>) -> String {
    let has_undone = page.commands.iter().any(|(line, _)| is_undo(line));
    let undone = if has_undone {
        "; steps that were taken back do not count"
    } else {
        ""
    };
    match page.plays {
        [] | [_] => undone.trim_start_matches("; ").to_owned(),
        [earlier @ .., last] => {
            let numbers: Vec<String> = earlier.iter().map(|play| play.len().to_string()).collect();
            format!(
                "in {} plays of {} and {} steps{undone}",
                page.plays.len(),
                numbers.join(", "),
                last.len()
            )
        }
    }
}

fn is_undo(command: &str) -> bool {
    command.split_whitespace().next() == Some("undo")
}

fn steps(page: &Page<'_>) -> Markup {
    if page.plays.iter().all(|steps| steps.is_empty()) {
        return html! { p { "No step was made." } };
    }
    let [only] = page.plays else {
        return html! {
            p { "The command " code { "reset" } " ended a play, and the next one began with step 0." }
            @for (number, steps) in page.plays.iter().enumerate() {
                h3 { "Play " (number + 1) }
                @if steps.is_empty() { p { "No step was made." } } @else {
                    (play(page, steps, &format!("play {} of {}", number + 1, page.contract.name)))
                }
            }
        };
    };
    play(page, only, &format!("a play of {}", page.contract.name))
}

/// A play as a timing diagram, with the values of each step below it.
fn play(page: &Page<'_>, steps: &[Vec<i64>], title: &str) -> Markup {
    let specification = &*page.contract.specification;
    let values: Vec<Vec<Option<i64>>> = steps
        .iter()
        .map(|step| step.iter().copied().map(Some).collect())
        .collect();
    html! {
        (of_contract::play(title, specification, &values, None))
        details {
            summary { "Show each step with its values" }
            @if steps.len() > MAX_LISTED { p.hint { "The first " (MAX_LISTED) " of " (steps.len()) " steps." } }
            (table(&["Step", "Inputs", "Outputs"], &steps.iter().take(MAX_LISTED).enumerate().map(|(number, step)| {
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

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_language::contract::load;

    #[test]
    fn each_play_is_shown() {
        let text = "contract Lamp {
    input asked: bool
    output lit: bool
    guarantee follows: always (lit <-> asked)
}
";
        let files = [("lamp.lw".to_owned(), text.to_owned())];
        let (library, findings) = load(&files, &|_, _| Err("no other file".to_owned()));
        assert!(findings.is_empty(), "{findings:?}");
        let contract = &library.contracts[0];
        let steps = vec![vec![1, 1], vec![0, 0], vec![1, 1]];
        let written = |plays: &[&[Vec<i64>]]| {
            page(&Page {
                contract,
                definitions: &[],
                person: Owner::Environment,
                player: "The script lamp.txt",
                plays,
                commands: &[],
                over: None,
                origin: Origin {
                    command: "linewright step lamp.lw --script lamp.txt",
                    version: "0",
                    sources: &library.sources,
                    findings: &[],
                },
            })
        };
        let two = written(&[&steps, &steps[..2]]);
        for wanted in [
            "The script lamp.txt played the plant against the controller.",
            "<dd>5</dd><dd class=\"note\">in 2 plays of 3 and 2 steps</dd>",
            "<h1>2 plays of Lamp</h1>",
            "<h3>Play 1</h3>",
            "<h3>Play 2</h3>",
        ] {
            assert!(two.contains(wanted), "{wanted}");
        }
        let one = written(&[&steps]);
        assert!(one.contains("<dd>3</dd>") && !one.contains("Play 1"));
    }
}
