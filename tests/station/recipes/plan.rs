//! The vectors of a machine in lockstep, compared with those of the plan, whose labels are spelled
//! here. Each test has the same outcome throughout a run.

use super::cells::Made;
use linewright::gr1::Domain;
use linewright_recipe::controller::{Move, Position, Subject};
use linewright_recipe::model::{Action, Guard};

/// Vectors after which a run of a loop is ended.
const MAX_VECTORS: usize = 60;

/// Maximum number of tests of which all combinations of outcomes are run.
const MAX_TESTS: usize = 6;

/// Compares all runs. Returns their number.
pub fn compare(made: &Made) -> usize {
    let count = made.built.tests.len();
    assert!(count <= MAX_TESTS);
    for outcomes in 0..1_u32 << count {
        let holds = |test: usize| outcomes >> test & 1 == 1;
        let plan = plan(made, &holds);
        let mut state = None;
        let inputs: Vec<i64> = [1]
            .into_iter()
            .chain((0..count).map(|test| i64::from(holds(test))))
            .collect();
        for vector in plan.iter().chain(&[None, None]).take(MAX_VECTORS) {
            let taken = made.built.machine.step(state, &inputs).expect("a step");
            state = Some(taken.to);
            let (finished, values) = taken.output.split_last().expect("outputs");
            assert_eq!(*finished == 1, vector.is_none(), "{:?}", made.recipe);
            for (at, value) in values.iter().enumerate() {
                let Domain::Enum { labels, .. } = &made.built.machine.outputs[at].domain else {
                    panic!("an output of a resource has labels");
                };
                let label = &labels[*value as usize];
                let m = vector.iter().flatten().find(|(m, _)| m.resource == at);
                let wanted = m.map_or("wait".to_owned(), |(m, needs)| spelled(made, m, needs));
                // A number after a label tells it from another one.
                let rest = label
                    .strip_prefix(&wanted)
                    .map(|r| r.trim_start_matches('_'));
                let is_same = rest.is_some_and(|rest| rest.chars().all(|c| c.is_ascii_digit()));
                assert!(is_same, "{label}, not {wanted}");
            }
        }
    }
    1 << count
}

/// A vector: moves with the parts that an operation needs and makes.
type Vector = Vec<(Move, (Vec<String>, Vec<String>))>;

/// The vectors until the recipe ends, or [`MAX_VECTORS`] of a loop.
fn plan(made: &Made, holds: &dyn Fn(usize) -> bool) -> Vec<Option<Vector>> {
    let mut vectors = Vec::new();
    let mut position = &made.controller.positions[0];
    while let Some(leg) = leg(made, position, holds) {
        let leg = &position.legs[leg];
        let steps = &made.recipe.transitions[leg.transition].steps;
        let mut performed = 0;
        for vector in &leg.vectors {
            let mut shown = Vec::new();
            for m in &vector.moves {
                let call = match &m.subject {
                    Subject::Operation(call) => {
                        let call = &steps[performed].operations[*call];
                        (call.inputs.clone(), call.outputs.clone())
                    }
                    _ => (Vec::new(), Vec::new()),
                };
                shown.push((m.clone(), call));
            }
            let is_operation = |m: &Move| matches!(m.subject, Subject::Operation(_));
            performed += usize::from(vector.moves.iter().any(is_operation));
            vectors.push(Some(shown));
        }
        if vectors.len() >= MAX_VECTORS {
            break;
        }
        position = &made.controller.positions[leg.to];
    }
    vectors
}

/// The leg that is taken, unless the recipe has ended.
fn leg(made: &Made, position: &Position, holds: &dyn Fn(usize) -> bool) -> Option<usize> {
    let guard = |leg: usize| &made.recipe.transitions[position.legs[leg].transition].guard;
    let legs = 0..position.legs.len();
    let taken = legs.clone().find(|leg| match guard(*leg) {
        Guard::Always => true,
        Guard::Otherwise => false,
        Guard::Test { name, inputs, .. } => {
            let mut tests = made.built.tests.iter();
            let test = tests.position(|t| t.name == *name && t.parts == *inputs);
            holds(test.expect("a test of the recipe"))
        }
    });
    taken.or_else(|| legs.clone().find(|leg| *guard(*leg) == Guard::Otherwise))
}

/// The label of a move, by the rules of the reference.
fn spelled(made: &Made, m: &Move, (needs, makes): &(Vec<String>, Vec<String>)) -> String {
    let resource = &made.layout.resources[m.resource];
    let taken = &resource.transitions[m.transition];
    let mut words = match &taken.action {
        Action::Operation(name) | Action::Internal(name) => vec![name.as_str()],
        Action::In(label) => vec!["in", label],
        Action::Out(label) => vec!["out", label],
    };
    if resource.capacity > 1 {
        match (&taken.action, &m.subject) {
            (Action::Out(_), Subject::Part(part)) => words.push(part),
            (Action::Operation(_), _) => words.extend(needs.iter().map(String::as_str)),
            _ => {}
        }
    }
    if let Action::Operation(name) = &taken.action {
        let steps = made.recipe.transitions.iter().flat_map(|t| &t.steps);
        let calls = steps.flat_map(|s| &s.operations);
        let mut others = calls.filter(|c| c.name == *name && c.inputs == *needs);
        if others.any(|c| c.outputs != *makes) {
            words.extend(makes.iter().map(String::as_str));
        }
    }
    let same = |t: &&linewright_recipe::model::Transition| t.action == taken.action;
    let is_ambiguous = resource.transitions.iter().filter(same).any(|a| {
        let mut others = resource.transitions.iter().filter(same);
        others.any(|b| a.from == b.from && a.to != b.to)
    });
    if is_ambiguous {
        words.extend(["to", &taken.to]);
    }
    words.join("_").replace(['@', '\'', '#'], "_")
}
