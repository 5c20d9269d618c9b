//! A controller, or a counterstrategy, as a page in which one can walk through it.

mod data;

use super::contract::Rank;
use super::parts::{self, Origin, figures, links, section, table_of, tile};
use super::{Document, contract as of_contract, document, terms};
use linewright_core::gr1::{Owner, Specification, Timing, show_value};
use linewright_language::contract::{Contract, Definition};
use linewright_solver::mealy::{Controller, Machine, Port, picture};
use maud::{Markup, PreEscaped, html};

/// Maximum number of states in the table of states.
const MAX_LISTED: usize = 500;

/// What a page shows.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The contract.
    pub contract: &'a Contract,
    /// The definitions that its rules use.
    pub definitions: &'a [Definition],
    /// Who answers the reader's moves.
    pub opponent: Opponent<'a>,
    /// Where the result comes from.
    pub origin: Origin<'a>,
}

/// Who answers the reader's moves.
#[derive(Debug, Clone, Copy)]
pub enum Opponent<'a> {
    /// A controller: the reader plays the plant.
    Controller(&'a Controller),
    /// A counterstrategy: the reader plays the machine.
    Counterstrategy(&'a Machine),
}

impl<'a> Opponent<'a> {
    fn machine(self) -> Option<&'a Machine> {
        match self {
            Self::Controller(controller) => controller.machine(),
            Self::Counterstrategy(machine) => Some(machine),
        }
    }

    fn timing(self) -> Timing {
        match self {
            Self::Controller(controller) => controller.timing(),
            Self::Counterstrategy(machine) => machine.timing,
        }
    }

    /// The side that the reader plays.
    fn reader(self) -> Owner {
        match self {
            Self::Controller(_) => Owner::Environment,
            Self::Counterstrategy(_) => Owner::System,
        }
    }
}

/// Returns the page. It is the same for the same controller.
pub fn page(page: &Page<'_>) -> String {
    let Page {
        contract, opponent, ..
    } = *page;
    let (what, reader) = match opponent {
        Opponent::Controller(_) => ("Controller", "plant"),
        Opponent::Counterstrategy(_) => ("Counterstrategy", "machine"),
    };
    let title = format!("{what} of {}", contract.name);
    let machine = opponent.machine();
    let main = html! {
        (tiles(opponent))
        (section("walk", "Walk", &walk(opponent, reader)))
        @if let Some(machine) = machine { (section("states", "States", &states(opponent, machine, goals(page)))) }
        (section("contract", "Contract", &html! {
            (of_contract::parameters(contract))
            (of_contract::interface(&contract.specification, Rank::Section))
            (of_contract::rules(&contract.specification, page.definitions, page.origin.sources, Rank::Section))
        }))
    };
    let terms = terms::terms(&html! { (of_contract::description(contract)) (main) });
    let sections = [
        ("walk", "Walk", true),
        ("states", "States", machine.is_some()),
        ("contract", "Contract", true),
        (terms::LINK.0, terms::LINK.1, !terms.0.is_empty()),
        ("model", "Files", true),
    ];
    let shown = sections.iter().filter(|(.., is_there)| *is_there);
    let body = html! {
        header {
            h1 { (title) }
            (of_contract::description(contract))
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
        style: include_str!("walk.css"),
        body: &body,
        data: Some(&data::json(page)),
        script: include_str!("walk.js"),
    })
}

fn tiles(opponent: Opponent<'_>) -> Markup {
    let (own, other) = match opponent.reader() {
        Owner::Environment => ("outputs", "inputs"),
        Owner::System => ("inputs", "outputs"),
    };
    let (kind, order) = match opponent.timing() {
        Timing::Mealy => (
            "Mealy",
            format!("in each step, its {own} answer the {other} of the same step"),
        ),
        Timing::Moore => (
            "Moore",
            format!("in each step, it sets its {own} before it knows the {other}"),
        ),
    };
    html! {
        dl.tiles {
            @match opponent {
                Opponent::Controller(Controller::Functions(functions)) => {
                    (tile("Goals", &figures(functions.controls.goals.len()), "a goal is pursued until it is reached"))
                    (tile("Modes", &figures(functions.mode_count()), "of all goals"))
                    (tile("Decisions", &figures(functions.controls.diagram.nodes.len()), "of its functions, which compute the outputs bit by bit"))
                }
                _ => @if let Some(machine) = opponent.machine() {
                    (tile("States", &figures(machine.states.len()), ""))
                    (tile("Transitions", &figures(machine.transition_count()), &format!("{} of them lead from the start to a state", figures(machine.initial.len()))))
                }
            }
            (tile("Kind", kind, &order))
            (tile("Verified", "yes", "against the contract, independently of the synthesis"))
        }
    }
}

/// The controls of the walk; the script fills them.
fn walk(opponent: Opponent<'_>, reader: &str) -> Markup {
    let (answers, rules) = match opponent.reader() {
        Owner::Environment => ("controller", "assumptions"),
        Owner::System => ("counterstrategy", "guarantees"),
    };
    html! {
        p { "You are the " (reader) ": choose values and make a step; the " (answers) " answers. A move that breaks one of the " (rules) " is refused, with the rule." }
        div.walk {
            form #moves {
                fieldset { legend #role { "Your move" } div #own {} }
                div.controls {
                    button #step type="submit" { "Step" }
                    button #random type="button" { "Random move" }
                    button #undo type="button" { "Back" }
                    button #reset type="button" { "Start again" }
                }
            }
            div {
                h3 #now { "Before step 0" }
                dl #answer {}
                div #status role="status" {}
            }
        }
        @if opponent.machine().is_some() {
            h3 { "Moves from here" }
            div #choices.scroll tabindex="0" role="group" aria-label="Moves from here" {}
        }
        details {
            summary { "Why does the " (answers) " not do something else?" }
            p { "Choose other values for its answer to the last move, to see which rules they would break." }
            div #others {}
            div #why role="status" {}
        }
        h3 { "Steps so far" }
        div #history.scroll tabindex="0" role="group" aria-label="Steps so far" {}
    }
}

/// The specification whose goals the states work for; a counterstrategy has none.
fn goals<'a>(page: &Page<'a>) -> Option<&'a Specification> {
    matches!(page.opponent, Opponent::Controller(_)).then_some(&*page.contract.specification)
}

/// The state diagram, and the states as a table.
fn states(
    opponent: Opponent<'_>,
    machine: &Machine,
    specification: Option<&Specification>,
) -> Markup {
    let rows = rows_of_transitions(machine);
    html! {
        div.controls role="group" aria-label="Size of the state diagram" {
            button #larger type="button" { "Larger" }
            button #smaller type="button" { "Smaller" }
            button #whole type="button" { "Fit to the page" }
            button #wide type="button" { "Fit the width" }
            button #natural type="button" { "As drawn" }
            span #scale role="status" {}
        }
        p #keys.hint { "With the diagram in focus, the keys + and - change its size, 0 fits it to the page, w to its width, 1 shows it as drawn, and the arrow keys move it. It follows the walk: the current state is golden." }
        div #diagram.scroll tabindex="0" role="group" aria-label="State diagram" aria-describedby="keys" { (PreEscaped(picture::to_svg(machine, specification))) }
        (notation(opponent, specification))
        details {
            summary { "All transitions as a table" }
            @if machine.states.len() > MAX_LISTED { p.hint { "Those of the first " (MAX_LISTED) " states." } }
            (table_of("Transitions", &["State", "Condition", "Answer", "Next state"], &html! {
                @for [from, condition, answer, to] in &rows { tr {
                    th scope="row" { (from) }
                    td { (parts::unbroken(condition)) }
                    td { (answer) }
                    td { (to) }
                } }
            }))
        }
    }
}

/// The rows of the table of transitions: first those from the start, which are taken in step 0,
/// then those of the first states.
fn rows_of_transitions(machine: &Machine) -> Vec<[String; 4]> {
    let initial = std::iter::once(("start".to_owned(), &machine.initial));
    let states = machine.states.iter().enumerate().take(MAX_LISTED);
    let states = states.map(|(number, list)| (format!("S{number}"), list));
    let rows = initial.chain(states).flat_map(|(from, transitions)| {
        transitions.iter().map(move |transition| {
            let ports = machine.outputs.iter().zip(&transition.output);
            let outputs: Vec<String> = ports
                .map(|(port, value)| assignment(port, *value))
                .collect();
            [
                from.clone(),
                machine.show_guard(&transition.guard),
                outputs.join(", "),
                format!("S{}", transition.to),
            ]
        })
    });
    rows.collect()
}

/// What the state diagram means.
fn notation(opponent: Opponent<'_>, specification: Option<&Specification>) -> Markup {
    let (reader, answers) = match opponent.reader() {
        Owner::Environment => (
            "your inputs",
            "the outputs with which the controller answers",
        ),
        Owner::System => (
            "your outputs",
            "the inputs with which the counterstrategy answers",
        ),
    };
    let entries = [
        (
            "condition / values",
            format!(
                "on an arrow: before the slash, the condition on {reader} for taking it; behind it, {answers}"
            ),
        ),
        (
            "empty line",
            "separates the ways to take an arrow that stands for several, each with its values".to_owned(),
        ),
        (
            "values in a state",
            "those on which all arrows to the state agree; they are not repeated on the arrows"
                .to_owned(),
        ),
        ("x, !x", "x is true, x is false".to_owned()),
        (
            "&, |",
            "and, or; an arrow with true is taken in all cases".to_owned(),
        ),
        (
            "dot",
            "the start, before step 0: the arrows from the dot lead to the states in which step 0 can end".to_owned(),
        ),
        (
            "single letter",
            "stands for a long condition, which is written out below the drawing".to_owned(),
        ),
    ];
    let goals = specification.map_or(Vec::new(), picture::goals);
    html! {
        details open {
            summary { "How to read the diagram" }
            dl.notation {
                @for (sign, meaning) in &entries { dt { (sign) } dd { (meaning) } }
                @if goals.len() > 1 {
                    dt { "frame, or for NAME" }
                    dd {
                        "states in which the controller works for that goal: a guarantee that has to come true again and again ("
                        (goals.join(", ")) ")"
                    }
                }
                dt { "golden state" }
                dd { "where the walk is" }
            }
        }
    }
}

fn assignment(port: &Port, value: i64) -> String {
    format!(
        "{} = {}",
        port.name,
        show_value(&port.domain, value, &port.unit)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::gr1::Domain;
    use linewright_solver::mealy::{Cube, Guard, Transition};

    #[test]
    fn all_transitions_are_in_the_table() {
        let transition = |to| Transition {
            guard: Guard(vec![Cube::default()]),
            output: vec![1],
            to,
        };
        let machine = Machine {
            name: "Lamp".to_owned(),
            timing: Timing::Mealy,
            inputs: Vec::new(),
            outputs: vec![Port {
                name: "lit".to_owned(),
                domain: Domain::Bool,
                unit: String::new(),
                internal: false,
            }],
            initial: vec![transition(0), transition(1)],
            states: vec![vec![transition(1)], vec![transition(0), transition(1)]],
            goals: Vec::new(),
        };
        let rows = rows_of_transitions(&machine);
        assert_eq!(rows.len(), machine.transition_count());
        let from: Vec<&str> = rows.iter().map(|[from, ..]| from.as_str()).collect();
        assert_eq!(from, ["start", "start", "S0", "S1", "S1"]);
    }
}
