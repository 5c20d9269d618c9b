//! The closed composition of synthesized controllers: compared with an independent exploration of
//! all states, on random machines and the laboratory's, and with modified controllers.

mod brute;
mod contradictory;

use crate::random::Random;
use brute::{Brute, Found};
use linewright::algebra::closed::{ClosedComposition, FailureKind, Verdict, replay};
use linewright::algebra::machine::{COMPLETES, of_machine};
use linewright::algebra::proof::{self, DischargeRule};
use linewright::algebra::system::{ContractSide, FormulaRef};
use linewright::contract;
use linewright::contract::machine::Machine;
use linewright::engine::files::{self, StandardLibrary};
use linewright::game::{self, Limits, Outcome};
use linewright::gr1::{Domain, FormulaKind};
use linewright::mealy::{self, Cube, Guard, Test, Transition, extract::extract};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// A random index below `bound`.
fn pick(random: &mut Random, bound: usize) -> usize {
    random.below(bound as u64) as usize
}

/// A verdict in the terms of the exploration. Checks that the controllers produce every run in it.
fn shown(closed: &ClosedComposition<'_>, verdict: &Verdict) -> Found {
    let mut found = Found {
        completes: true,
        states: closed
            .count_states(&Limits::default())
            .expect("no limit")
            .round() as usize,
        ..Found::default()
    };
    for open in &verdict.open {
        assert_eq!(replay::check_open(closed, open), Ok(()));
        let at = open.what;
        if let Some(part) = at.component {
            let formula = &closed.system.components[part].assumptions.list(at.kind)[at.index];
            found.open.insert((part, formula.name.clone()));
            continue;
        }
        let formula = &closed.claim.goal.list(at.kind)[at.index];
        if formula.name == COMPLETES {
            found.completes = false;
        } else {
            found.broken.insert(formula.name.clone());
        }
    }
    for stuck in &verdict.stuck {
        assert_eq!(replay::check_stuck(closed, stuck), Ok(()));
        found.stuck.insert(stuck.component);
    }
    for misrun in &verdict.operation_failures {
        assert_eq!(replay::check_operation_failure(closed, misrun), Ok(()));
        match &misrun.why {
            FailureKind::NeverBegins(_) => found.never.insert(misrun.operation),
            FailureKind::Order(_) => found.order.insert(misrun.operation),
            FailureKind::Endless(_) => found.endless.insert(misrun.operation),
        };
    }
    assert_eq!(verdict.undecided, []);
    assert_eq!(verdict.undecided_operations, [0; 0]);
    found
}

/// Both answers for a machine with these tables.
#[track_caller]
fn compared(machine: &Machine, controllers: &[mealy::Controller], what: &str) -> Found {
    let controllers: Vec<&mealy::Controller> = controllers.iter().collect();
    let tables: Vec<&mealy::Machine> = controllers
        .iter()
        .map(|c| c.machine().expect("a table"))
        .collect();
    let closed = ClosedComposition::of_machine(machine, &controllers);
    let verdict = closed.decide(&Limits::default()).expect("no limit");
    let brute = Brute {
        machine,
        tables: &tables,
        closed: &closed,
    };
    let explored = brute.explore().expect("few states");
    assert_eq!(shown(&closed, &verdict), explored, "{what}");
    explored
}

// ---- random machines ----------------------------------------------------------------------------

const LEAD: &[&str] = &[
    "assume served: always eventually (c = 0 or e)",
    "assume first: job = x",
    "assume calm: always (c = 0 -> not next e)",
    "assume next_one: always (done -> next job = y)",
    "assume settled: always (c = 1 -> next job = job)",
];
const FIRST: &[&str] = &[
    "assume held: always (c = 1 and not a -> next c = 1)",
    "assume rest: c != 2",
    "assume asked: always eventually c = 1",
    "assume both: always (s or c != 2)",
];
const SECOND: &[&str] = &[
    "assume apart: always (a -> c != 2)",
    "assume again: always eventually not a",
    "assume slow: always (c = 2 -> next c != 1)",
];
const RULES: &[&str] = &[
    "guarantee one: always not (act.a and bct.b)",
    "guarantee on: always (act.a -> next not bct.b)",
];

fn some(random: &mut Random, of: &[&str]) -> String {
    let kept: Vec<&str> = of.iter().copied().filter(|_| random.chance(35)).collect();
    kept.join("\n")
}

fn text(random: &mut Random) -> String {
    let (lead, first, second) = (
        some(random, LEAD),
        some(random, FIRST),
        some(random, SECOND),
    );
    let rules = some(random, RULES);
    let script = ["true", "false, true", "true, true, false"][pick(random, 3)];
    let x = ["act", "act, bct", "bct"][pick(random, 3)];
    let y = ["act", "bct, act", "bct"][pick(random, 3)];
    format!(
        "
moore contract Lead {{ input job: {{none, x, y}} input e: bool output c: 0..2 output done: bool {lead}
    guarantee g: always (done -> c < 3) }}
contract First {{ input c: 0..2 input s: bool output a: bool {first} guarantee g: always (a -> c < 3) }}
contract Second {{ input c: 0..2 input a: bool output b: bool {second} guarantee g: always (b -> c < 3) }}
machine M {{
    signal s: bool = {script}
    coordinator lead: Lead {{ job = operation e = if lead.c = 1 then act.a else lead.c = 2 and bct.b }}
    action act: First when lead.c = 1 {{ c = lead.c }}
    action bct: Second when lead.c = 2 {{ c = lead.c a = act.a }}
    operation x: {x}
    operation y: {y}
    done lead.done
    {rules}
}}
"
    )
}

fn load(text: &str) -> Machine {
    let files = [("m.lw".to_owned(), text.to_owned())];
    let (library, findings) = contract::load(&files, &|_, _| Err("no imports".to_owned()));
    let shown: Vec<_> = findings.iter().map(|f| (f.code.id, &f.message)).collect();
    assert_eq!(library.machines.len(), 1, "{shown:?}\n{text}");
    library.machines[0].clone()
}

/// A table over the ports of a component. Some inputs have no row.
fn table(random: &mut Random, machine: &Machine, component: usize, gaps: u64) -> mealy::Controller {
    let specification = &machine.components[component].specification;
    let port = |v| {
        let variable = specification.variable(v);
        mealy::Port {
            name: variable.name.clone(),
            domain: variable.domain.clone(),
            unit: String::new(),
            internal: variable.internal,
        }
    };
    let inputs: Vec<mealy::Port> = specification.inputs().map(port).collect();
    let outputs: Vec<mealy::Port> = specification.outputs().map(port).collect();
    let moore = specification.timing == linewright::gr1::Timing::Moore;
    let count = 1 + pick(random, 4);
    let mut letters: Vec<Vec<i64>> = vec![Vec::new()];
    for port in &inputs {
        let values = port.domain.low()..=port.domain.high();
        letters = letters
            .into_iter()
            .flat_map(|l| values.clone().map(move |v| [l.clone(), vec![v]].concat()))
            .collect();
    }
    let rows = |random: &mut Random| -> Vec<Transition> {
        let answer = |random: &mut Random| -> Vec<i64> {
            let value = |d: &Domain, r: &mut Random| d.low() + r.below(d.size()) as i64;
            outputs.iter().map(|p| value(&p.domain, random)).collect()
        };
        let spoken = answer(random);
        let mut rows = Vec::new();
        for letter in &letters {
            if random.chance(gaps) {
                continue;
            }
            let tests = letter.iter().enumerate().map(|(input, value)| Test {
                input,
                low: *value,
                high: *value,
            });
            rows.push(Transition {
                guard: Guard(vec![Cube(tests.collect())]),
                output: if moore {
                    spoken.clone()
                } else {
                    answer(random)
                },
                to: pick(random, count),
            });
        }
        rows
    };
    let initial = rows(random);
    let states = (0..count).map(|_| rows(random)).collect();
    mealy::Machine {
        name: specification.name.clone(),
        timing: specification.timing,
        inputs,
        outputs,
        initial,
        states,
        goals: Vec::new(),
    }
    .into()
}

#[test]
fn random_machines_are_decided_as_by_hand() {
    let mut random = Random::new(2026);
    let mut seen = [0; 8];
    let rounds = 600;
    for round in 0..rounds {
        let text = text(&mut random);
        let machine = load(&text);
        let gaps = [0, 0, 2, 10][pick(&mut random, 4)];
        let controllers: Vec<mealy::Controller> = (0..machine.components.len())
            .map(|c| table(&mut random, &machine, c, gaps))
            .collect();
        let found = compared(&machine, &controllers, &format!("round {round}: {text}"));
        let is = [
            !found.open.is_empty(),
            !found.broken.is_empty(),
            !found.stuck.is_empty(),
            !found.never.is_empty(),
            !found.order.is_empty(),
            !found.endless.is_empty(),
            !found.completes,
            found.completes,
        ];
        for (count, is) in seen.iter_mut().zip(is) {
            *count += usize::from(is);
        }
    }
    println!(
        "{rounds} machines; open, broken, stuck, never, order, endless, incomplete, complete: {seen:?}"
    );
    assert!(seen.iter().all(|n| *n > 20 && *n < rounds - 20), "{seen:?}");
}

/// Justice that nothing meets, by component: on the run on which nothing ever happens (`c = 0`,
/// nothing is done, the call stays the same) each of these stays false. Some are about outside
/// values, alone or combined with others.
const UNMET: [&[&str]; 3] = [
    &[
        "job = none",
        "job = y",
        "e",
        "job = y or e",
        "job = y and c = 0",
    ],
    &[
        "c = 1",
        "s and c = 1",
        "c = 2 and not s",
        "not (s or c = 0)",
    ],
    &["a", "a and s", "c = 2", "s and (a or c = 1)"],
];

/// A machine in which the assumption `unmet` of a component is never met. The other assumptions
/// allow that run.
fn unmet(random: &mut Random, component: usize, formula: &str) -> String {
    let mut own = [
        some(random, &LEAD[1..]),
        some(random, &FIRST[..1]),
        some(random, &[SECOND[2]]),
    ];
    let _ = write!(
        own[component],
        "\nassume unmet: always eventually ({formula})"
    );
    let [lead, first, second] = own;
    let script = ["true", "false, true", "true, true, false"][pick(random, 3)];
    format!(
        "
moore contract Lead {{ input job: {{none, x, y}} input e: bool output c: 0..2 output done: bool {lead}
    guarantee g: always (done -> c < 3) }}
contract First {{ input c: 0..2 input s: bool output a: bool {first} guarantee g: always (a -> c < 3) }}
contract Second {{ input c: 0..2 input a: bool input s: bool output b: bool {second} guarantee g: always (b -> c < 3) }}
machine M {{
    signal s: bool = {script}
    coordinator lead: Lead {{ job = operation e = if lead.c = 1 then act.a else lead.c = 2 and bct.b }}
    action act: First when lead.c = 1 {{ c = lead.c }}
    action bct: Second when lead.c = 2 {{ c = lead.c a = act.a }}
    operation x: act
    operation y: act, bct
    done lead.done
}}
"
    )
}

/// What a component waits for and nothing brings about is open: no proof meets it, and none passes
/// it on to the machine's caller, be it a plant or a line. The same for controllers: those that do
/// nothing leave it unmet.
#[test]
fn justice_that_nobody_meets_is_neither_proved_nor_handed_on() {
    let mut random = Random::new(24);
    let mut outside = 0;
    for round in 0..60 {
        let component = round % 3;
        let formulas = UNMET[component];
        let formula = formulas[pick(&mut random, formulas.len())];
        let text = unmet(&mut random, component, formula);
        let machine = load(&text);
        let (system, claim) = of_machine(&machine);
        let mut assumed = system.components[component].assumptions.justice.iter();
        let index = assumed.position(|f| f.name == "unmet");
        let unmet = FormulaRef {
            component: Some(component),
            half: ContractSide::Assumptions,
            kind: FormulaKind::Justice,
            index: index.expect("it is assumed"),
        };
        let is_it = |at: &FormulaRef| *at == unmet;
        let expr = &system.components[component].assumptions.justice[unmet.index].expr;
        expr.for_each_var(&mut |v, _| outside += usize::from(system.driver(v).is_none()));
        for proof in [
            proof::prove(&system, &claim, &Limits::default()).expect("no limit"),
            proof::decide(&system, &claim, &Limits::default()).expect("no limit"),
            proof::decide_stepwise(&system, &claim, &Limits::default()).expect("no limit"),
        ] {
            assert!(!proof.holds(), "{text}");
            let met = proof.discharges.iter().find(|d| is_it(&d.what));
            assert_eq!(met, None, "{text}");
            assert!(proof.open.iter().any(|o| is_it(&o.what)), "{text}");
            let handed_on = proof.discharges.iter().filter(|d| {
                d.rule == DischargeRule::Exported && d.what.kind == FormulaKind::Justice
            });
            assert_eq!(handed_on.count(), 0, "{text}");
        }
        let idle: Vec<mealy::Controller> = (0..machine.components.len())
            .map(|c| idle(&mut random, &machine, c))
            .collect();
        let idle: Vec<&mealy::Controller> = idle.iter().collect();
        let closed = ClosedComposition::of_machine(&machine, &idle);
        let verdict = closed.decide(&Limits::default()).expect("no limit");
        assert!(!verdict.met.iter().any(|(at, _)| is_it(at)), "{text}");
        assert!(verdict.open.iter().any(|o| is_it(&o.what)), "{text}");
    }
    assert!(
        outside > 25,
        "only {outside} refer to what comes from outside"
    );
}

/// A controller that always answers 0.
fn idle(random: &mut Random, machine: &Machine, component: usize) -> mealy::Controller {
    let table = table(random, machine, component, 0);
    let mut table = table.machine().expect("a table").clone();
    for row in table
        .states
        .iter_mut()
        .chain([&mut table.initial])
        .flatten()
    {
        row.output.fill(0);
    }
    table.into()
}

// ---- the laboratory's machines ------------------------------------------------------------------

fn machine(file: &str) -> Machine {
    let path = format!("{}/examples/{file}.lw", env!("CARGO_MANIFEST_DIR"));
    let loaded = files::load(&[path], &StandardLibrary::default());
    loaded.library.machines[0].clone()
}

/// The controllers, if all contracts are realizable.
fn synthesized_as_far_as_can_be(machine: &Machine) -> Option<Vec<mealy::Controller>> {
    let limits = Limits::default();
    let components = machine.components.iter();
    let controllers = components.map(|c| {
        let Outcome::Realizable(won) = game::solve(&c.specification, &limits) else {
            return None;
        };
        let table = extract(&c.specification, &won, &limits).expect("a table");
        let verified = mealy::verify::verify(&c.specification, &table, &limits);
        assert!(matches!(verified, Ok(Ok(()))), "{verified:?}");
        Some(table.into())
    });
    controllers.collect()
}

fn synthesized(machine: &Machine) -> Vec<mealy::Controller> {
    let limits = Limits::default();
    let components = machine.components.iter();
    let controllers = components.map(|c| {
        let Outcome::Realizable(won) = game::solve(&c.specification, &limits) else {
            panic!("{} is not realizable", c.name);
        };
        extract(&c.specification, &won, &limits)
            .expect("a table")
            .into()
    });
    controllers.collect()
}

#[test]
fn the_small_machines_of_the_laboratory_hold() {
    for file in ["printer", "milling", "camera", "belt"] {
        let machine = machine(&format!("ice-lab/{file}"));
        let found = compared(&machine, &synthesized(&machine), file);
        let sound = Found {
            completes: true,
            states: found.states,
            ..Found::default()
        };
        assert_eq!(found, sound, "{file}");
    }
}

/// Guarantees by component, from which justice of the others can be proved.
const HELP: [&[&str]; 3] = [
    &[
        "guarantee turns: always (next c = (c + 1) mod 3)",
        "guarantee asks: always eventually c = 1",
        "guarantee rests: always eventually c = 0",
        "guarantee ends: always (done <-> c = 2)",
        "guarantee finishes: always eventually done",
    ],
    &[
        "guarantee answers: always (a <-> c = 1)",
        "guarantee acts: always eventually a",
        "guarantee waits: always eventually not a",
    ],
    &[
        "guarantee follows: always (b <-> c = 2)",
        "guarantee acts: always eventually b",
    ],
];

/// Guarantees of [`HELP`] with which a machine can be proved, unless it assumes too much.
const NEEDED: [&str; 4] = ["ends", "finishes", "answers", "follows"];

/// A machine with some of [`HELP`]; if it `is_easy`, with all that are [`NEEDED`] and few
/// assumptions.
fn helped(random: &mut Random, is_easy: bool) -> String {
    let mut helped = text(random);
    if is_easy {
        let lines = helped.lines();
        let kept = lines.filter(|line| !line.starts_with("assume") || random.chance(20));
        helped = kept.fold(String::new(), |text, line| text + line + "\n");
    }
    let weak = ["done -> c < 3", "a -> c < 3", "b -> c < 3"];
    for (weak, help) in weak.iter().zip(HELP) {
        let kept: Vec<&str> = help
            .iter()
            .copied()
            .filter(|line| {
                let needed = NEEDED
                    .iter()
                    .any(|n| line.starts_with(&format!("guarantee {n}:")));
                random.chance(35) || (is_easy && needed)
            })
            .collect();
        let weak = format!("guarantee g: always ({weak})");
        helped = helped.replace(&weak, &format!("{weak}\n{}", kept.join("\n")));
    }
    helped
}

/// What of a verdict can be seen from outside.
fn met(verdict: &Verdict) -> BTreeSet<String> {
    let met = verdict.met.iter();
    met.map(|(at, _)| format!("{at:?}")).collect()
}

/// What was proved from the contracts is not decided again: whoever decides it again comes to the
/// same verdict.
#[test]
fn what_is_proved_changes_no_verdict() {
    let mut random = Random::new(27);
    let limits = Limits::default();
    let (mut decided, mut known, mut open, mut whole) = (0, 0, 0, 0);
    while decided < 400 {
        let text = helped(&mut random, decided % 4 > 0);
        let machine = load(&text);
        let Some(controllers) = synthesized_as_far_as_can_be(&machine) else {
            continue;
        };
        decided += 1;
        let controllers: Vec<&mealy::Controller> = controllers.iter().collect();
        let (system, claim) = of_machine(&machine);
        let proof = proof::decide_stepwise(&system, &claim, &limits).expect("no limit");
        let closed = || ClosedComposition::of_machine(&machine, &controllers);
        let knowing = closed().knowing(&proof);
        known += knowing.known.justice.len();
        whole += usize::from(knowing.known.safety);
        let again = closed().decide(&limits).expect("no limit");
        let (closed, verdict) = (closed(), knowing.decide(&limits).expect("no limit"));
        assert_eq!(shown(&closed, &verdict), shown(&closed, &again), "{text}");
        assert_eq!(met(&verdict), met(&again), "{text}");
        open += usize::from(again.is_broken());
    }
    println!(
        "{decided} machines, {known} formulas known, {whole} machines proved, {open} with errors"
    );
    assert!(
        known > 50 && open > 20 && whole > 20,
        "{known} known, {whole} proved, {open} open"
    );
}

/// The same for the machines of the library, most of which are proved from their contracts.
#[test]
fn what_is_proved_changes_no_verdict_on_the_machines_of_the_library() {
    let limits = Limits::default();
    let directory = format!("{}/contracts", env!("CARGO_MANIFEST_DIR"));
    let loaded = files::load(&[directory], &StandardLibrary::default());
    let (mut decided, mut proved) = (0, 0);
    for machine in &loaded.library.machines {
        // Inner machines are proved over other wires than those of the composition.
        if machine.layers.abstraction.is_some() {
            continue;
        }
        let controllers = synthesized(machine);
        let controllers: Vec<&mealy::Controller> = controllers.iter().collect();
        let (system, claim) = of_machine(machine);
        let proof = proof::decide_stepwise(&system, &claim, &limits).expect("no limit");
        proved += usize::from(proof.holds());
        let closed = || ClosedComposition::of_machine(machine, &controllers);
        let again = closed().decide(&limits).expect("no limit");
        let verdict = closed().knowing(&proof).decide(&limits).expect("no limit");
        assert_eq!(met(&verdict), met(&again), "{}", machine.name);
        let errors = |verdict: Verdict| Verdict {
            met: Vec::new(),
            ..verdict
        };
        assert_eq!(errors(verdict), errors(again), "{}", machine.name);
        decided += 1;
    }
    println!("{decided} machines, {proved} of them proved");
    assert!(
        proved > 20,
        "only {proved} of {decided} machines are proved"
    );
}

#[test]
fn the_assembly_cell_holds() {
    let machine = machine("ice-lab/cell");
    let controllers = synthesized(&machine);
    let controllers: Vec<&mealy::Controller> = controllers.iter().collect();
    let closed = ClosedComposition::of_machine(&machine, &controllers);
    let verdict = closed.decide(&Limits::default()).expect("no limit");
    assert!(verdict.holds(), "{verdict:?}");
    let states = closed.count_states(&Limits::default()).expect("no limit");
    println!("{states} states");
    assert!(states > 1_000.0);
}

/// A table with one row left out, or with another output or next state in one place.
fn mutant(random: &mut Random, table: &mealy::Machine) -> mealy::Machine {
    let mut changed = table.clone();
    let states = table.states.len();
    let at = pick(random, states + 1);
    let change = pick(random, 3);
    let moore = table.timing == linewright::gr1::Timing::Moore;
    let rows = match changed.states.get_mut(at) {
        Some(rows) => rows,
        None => &mut changed.initial,
    };
    if rows.is_empty() {
        return changed;
    }
    let place = pick(random, rows.len());
    match change {
        0 => {
            rows.remove(place);
        }
        1 => {
            let output = pick(random, table.outputs.len());
            let domain = &table.outputs[output].domain;
            let value = domain.low() + random.below(domain.size()) as i64;
            // A table that answers first gives the same in all rows of a state.
            let places = if moore {
                0..rows.len()
            } else {
                place..place + 1
            };
            for row in &mut rows[places] {
                row.output[output] = value;
            }
        }
        _ => rows[place].to = pick(random, states),
    }
    changed
}

#[test]
fn controllers_that_were_changed_are_refuted_or_harmless() {
    let mut random = Random::new(7);
    let mut lines = BTreeSet::new();
    let (mut refuted, mut harmless) = (0, 0);
    for file in ["printer", "milling", "camera", "belt"] {
        let machine = machine(&format!("ice-lab/{file}"));
        let controllers = synthesized(&machine);
        for round in 0..60 {
            let mut changed = controllers.clone();
            let component = pick(&mut random, changed.len());
            let table = changed[component].machine().expect("a table");
            let other = mutant(&mut random, table);
            if other == *table {
                continue;
            }
            changed[component] = other.into();
            let found = compared(&machine, &changed, &format!("{file}, mutant {round}"));
            let sound = Found {
                completes: true,
                states: found.states,
                ..Found::default()
            };
            if found == sound {
                harmless += 1;
            } else {
                refuted += 1;
            }
        }
        lines.insert(file);
    }
    println!("{refuted} changed controllers refuted, {harmless} harmless");
    assert_eq!(lines.len(), 4);
    assert!(refuted > 60 && harmless > 5, "{refuted}, {harmless}");
}

/// For the assembly cell too, a refutation comes with a run that the modified controllers produce.
#[test]
fn a_changed_controller_of_the_assembly_cell_is_refuted() {
    let machine = machine("ice-lab/cell");
    let mut controllers = synthesized(&machine);
    // The left arm's gripper never reports that it holds something.
    let mut table = controllers[1].machine().expect("a table").clone();
    let said = table.outputs.iter().position(|p| p.name == "pick_executed");
    let said = said.expect("an output");
    for row in table.states.iter_mut().flatten() {
        row.output[said] = 0;
    }
    controllers[1] = table.into();
    let controllers: Vec<&mealy::Controller> = controllers.iter().collect();
    let closed = ClosedComposition::of_machine(&machine, &controllers);
    let verdict = closed.decide(&Limits::default()).expect("no limit");
    assert!(verdict.is_broken());
    let found = shown(&closed, &verdict);
    assert!(!found.completes, "{found:?}");
}
