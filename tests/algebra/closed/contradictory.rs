//! Contradictory assumptions: the verdict on the controllers together, compared with the
//! interpreter.
//!
//! A controller that answers first has no outputs where its assumptions contradict each other: no
//! inputs keep them. The interpreter reports an error of the call, the verdict a stuck machine; in
//! both it precedes everything else in that step.

use super::{load, pick, synthesized_as_far_as_can_be};
use crate::random::Random;
use linewright::algebra::closed::{ClosedComposition, Verdict, replay};
use linewright::algebra::proof::Refutation;
use linewright::contract::machine::{Machine, PlantSource};
use linewright::game::Limits;
use linewright::mealy::{self, Cube, Guard, Transition};
use linewright::station::interpret::Interpreter;
use linewright::station::{Controller as _, ErrorCode};
use std::sync::Arc;

/// Contradictions at the start, from the start on, or after some event; none at the end of the
/// list.
const CONTRADICTORY: &[&str] = &[
    "assume never: (not s and s)",
    "assume dark: always not s assume light: always s",
    "assume asked: always r assume unasked: always not r",
    "assume both: always (f -> next s and not next s)",
    "assume dark: always (r -> not s) assume lights_up: always (r -> next r and next s)",
    "assume up: always (r -> next x = 1) assume down: always (f -> next x = 2)",
    "assume gone: always (r -> next x > 2)",
    "",
    "",
    "",
    "",
    "",
];
const ASSUMPTIONS: &[&str] = &[
    "assume held: always (r and not f -> next r)",
    "assume still: always (r and next r -> next x = x)",
    "assume small: always x < 2",
    "assume off: always (not r -> not s)",
    "assume again: always eventually (s or not r)",
];
const GUARANTEES: &[&str] = &[
    "guarantee moves: always (r -> f or next y != y)",
    "guarantee ends: always eventually (not r or f)",
    "guarantee rests: always (not r -> next not f)",
    "guarantee first: not f",
];

fn some(random: &mut Random, of: &[&str], percent: u64) -> String {
    let kept: Vec<&str> = of
        .iter()
        .copied()
        .filter(|_| random.chance(percent))
        .collect();
    kept.join("\n")
}

fn contract(random: &mut Random, name: &str) -> String {
    let moore = ["moore ", "moore ", ""][pick(random, 3)];
    let contradictory = CONTRADICTORY[pick(random, CONTRADICTORY.len())];
    let assumptions = some(random, ASSUMPTIONS, 12);
    let guarantees = some(random, GUARANTEES, 60);
    format!(
        "{moore}contract {name} {{ input r, s: bool input x: 0..2 output f: bool output y: 0..1\n\
         {contradictory}\n{assumptions}\n{guarantees}\nguarantee any: always (f -> y < 2) }}\n"
    )
}

fn text(random: &mut Random) -> String {
    let (one, two) = (contract(random, "One"), contract(random, "Two"));
    let script = ["true", "false, true", "true, true, false"][pick(random, 3)];
    let signal = |random: &mut Random| ["sg", "x = 2", "false", "not lead.c"][pick(random, 4)];
    let (s, t) = (signal(random), signal(random));
    let seen = ["x", "a.y", "0"][pick(random, 3)];
    format!(
        "moore contract Lead {{ input job, da, db: bool output c, d, done: bool\n\
         guarantee start: not c and not d and not done\n\
         guarantee one: always (next c <-> (job and not c and not d and not done) or (c and not da))\n\
         guarantee two: always (next d <-> (c and da) or (d and not db))\n\
         guarantee end: always (next done <-> d and db) }}\n\
         {one}{two}\
         machine M {{\n\
         property p: 0..2 = 0\n\
         abstract x: 0..2 = p\n\
         signal sg: bool = {script}\n\
         coordinator lead: Lead {{ job = operation != none da = a.f db = b.f }}\n\
         action a: One when lead.c {{ r = lead.c s = {s} x = x }}\n\
         action b: Two when lead.d {{ r = lead.d s = {t} x = {seen} }}\n\
         operation go: a, b\n\
         done lead.done\n\
         }}\n"
    )
}

/// Steps the interpreter along a run, and expects it to refuse the last step; returns the error.
fn refused(
    machine: &Machine,
    controllers: &[mealy::Controller],
    run: &[Vec<i64>],
) -> linewright::station::CallError {
    let mut interpreter =
        Interpreter::new(Arc::new(machine.clone()), Arc::new(controllers.to_vec()));
    let plant = machine.plant.len();
    let wires = machine.wire_count();
    let mut outputs = vec![0; wires - plant];
    let (last, before) = run.split_last().expect("a step");
    for (at, step) in before.iter().enumerate() {
        let made = interpreter.step(&step[..plant], &mut outputs);
        assert_eq!(made, Ok(()), "step {at}");
        assert_eq!(outputs, &step[plant..wires], "step {at}");
    }
    let refused = interpreter.step(&last[..plant], &mut outputs);
    refused.expect_err("the last step is refused")
}

/// Runs operations at random; returns what is refused, and whether in the first step of a call.
fn runs(
    random: &mut Random,
    machine: &Machine,
    controllers: &[mealy::Controller],
) -> Vec<(bool, linewright::station::CallError)> {
    let mut found = Vec::new();
    for _ in 0..6 {
        let mut interpreter =
            Interpreter::new(Arc::new(machine.clone()), Arc::new(controllers.to_vec()));
        let mut outputs = vec![0; machine.wire_count() - machine.plant.len()];
        'calls: for _ in 0..4 {
            let value = pick(random, 3) as f64;
            for step in 0..20 {
                let plant = machine.plant.iter().map(|p| match &p.source {
                    PlantSource::Operation => machine.operations[0].value,
                    PlantSource::Signal { script } => script[step % script.len()],
                    PlantSource::Property(expr) => expr.eval(&[value], &[]).round() as i64,
                });
                let plant: Vec<i64> = plant.collect();
                if let Err(error) = interpreter.step(&plant, &mut outputs) {
                    found.push((step == 0, error));
                    break 'calls;
                }
                let wires: Vec<i64> = plant.iter().chain(&outputs).copied().collect();
                let done = machine.done.as_ref().expect("an operation ends");
                if linewright::gr1::eval::holds(done, &wires, &[]) {
                    break;
                }
            }
        }
    }
    found
}

/// Compares the findings with the interpreter; returns the number of silent components.
fn agrees(
    random: &mut Random,
    machine: &Machine,
    controllers: &[mealy::Controller],
    closed: &ClosedComposition<'_>,
    verdict: &Verdict,
) -> usize {
    let mut silent = 0;
    for stuck in &verdict.stuck {
        assert!(stuck.silent, "tables that were verified have no gaps");
        assert_eq!(replay::check_stuck(closed, stuck), Ok(()));
        let error = refused(machine, controllers, &stuck.trace);
        let name = &machine.components[stuck.component].name;
        let wanted =
            format!("{name}: its assumptions contradict each other here: no inputs keep them");
        assert_eq!((error.code, error.message), (ErrorCode::Assumption, wanted));
        let why = closed.contradiction(stuck, &Limits::default());
        let why = why.expect("no limit");
        assert!(!why.is_empty());
        println!(
            "{name}: {:?}",
            why.iter().map(|f| &f.name).collect::<Vec<_>>()
        );
        silent += 1;
    }
    for open in &verdict.open {
        let (Some(part), Refutation::Trace(run)) = (open.what.component, &open.why) else {
            continue;
        };
        let error = refused(machine, controllers, run);
        let name = &machine.components[part].name;
        assert_eq!(error.code, ErrorCode::Assumption);
        assert!(error.message.starts_with(&format!("{name}: ")), "{error:?}");
    }
    let found = runs(random, machine, controllers);
    for (first, error) in &found {
        assert_eq!(error.code, ErrorCode::Assumption, "{error:?}");
        let safe = verdict
            .open
            .iter()
            .all(|o| matches!(o.why, Refutation::Lasso(_)));
        if verdict.stuck.is_empty() && safe {
            assert!(first, "only the caller breaks something: {error:?}");
        }
    }
    silent
}

#[test]
fn contradictory_assumptions_are_decided_as_they_run() {
    let mut random = Random::new(24);
    let (mut looked_at, mut sound, mut silent) = (0, 0, 0);
    for _ in 0..150 {
        let text = text(&mut random);
        let machine = load(&text);
        let Some(controllers) = synthesized_as_far_as_can_be(&machine) else {
            continue;
        };
        let references: Vec<&mealy::Controller> = controllers.iter().collect();
        let closed = ClosedComposition::of_machine(&machine, &references);
        let verdict = closed.decide(&Limits::default()).expect("no limit");
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            agrees(&mut random, &machine, &controllers, &closed, &verdict)
        }));
        silent += outcome.unwrap_or_else(|_| panic!("of this machine: {text}\n{verdict:?}"));
        looked_at += 1;
        sound += usize::from(!verdict.is_broken());
    }
    println!("{looked_at} machines, {sound} sound, {silent} silent");
    assert!(looked_at > 100 && sound > 5 && silent > 12);
}

/// A state without a row that is reached during a call. Minimization would merge it with any other
/// state, so the table is handmade.
#[test]
fn a_contradiction_that_comes_later_is_found_after_its_run() {
    let text = "
moore contract Lead { input job, da: bool output c, done: bool
    guarantee start: not c and not done
    guarantee one: always (next c <-> (job and not c and not done) or (c and not da))
    guarantee end: always (next done <-> c and da) }
moore contract One { input r, s: bool output f: bool
    assume often: always eventually s
    assume up: always (f -> next s)
    assume down: always (f -> not next s)
    guarantee first: not f }
machine M {
    signal sg: bool = false, true
    coordinator lead: Lead { job = operation != none da = a.f }
    action a: One when lead.c { r = lead.c s = sg }
    operation go: a
    done lead.done
}
";
    let machine = load(text);
    let mut controllers = synthesized_as_far_as_can_be(&machine).expect("realizable contracts");
    let row = |output: i64, to: usize| Transition {
        guard: Guard(vec![Cube(Vec::new())]),
        output: vec![output],
        to,
    };
    let mut table = controllers[1].machine().expect("a table").clone();
    table.initial = vec![row(0, 0)];
    table.states = vec![vec![row(1, 1)], Vec::new()];
    let specification = &machine.components[1].specification;
    let verified = mealy::verify::verify(specification, &table, &Limits::default());
    assert!(matches!(verified, Ok(Ok(()))), "{verified:?}");
    controllers[1] = table.into();
    let references: Vec<&mealy::Controller> = controllers.iter().collect();
    let closed = ClosedComposition::of_machine(&machine, &references);
    let verdict = closed.decide(&Limits::default()).expect("no limit");
    let [stuck] = verdict.stuck.as_slice() else {
        panic!("{verdict:?}");
    };
    assert_eq!((stuck.component, stuck.trace.len()), (1, 3));
    let why = closed.contradiction(stuck, &Limits::default());
    let why = why.expect("no limit");
    let names: Vec<&str> = why.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["up", "down"]);
    let mut random = Random::new(1);
    assert_eq!(
        agrees(&mut random, &machine, &controllers, &closed, &verdict),
        1
    );
}
