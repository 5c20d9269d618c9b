//! Causes that are found without a search. That they are exact is tested by the oracle, whose cells
//! have many of them.

mod support;

use linewright_recipe::model::{Action, Guard, Layout, Part, Recipe, RecipeTransition, Resource};
use linewright_recipe::realize::{Obstacle, Outcome, SearchLimits, realize};
use support::pad::{self, step};

fn obstacles(layout: &Layout, recipe: &Recipe) -> Vec<Obstacle> {
    match realize(layout, recipe, SearchLimits::default()) {
        Ok(Outcome::Unrealizable(refusal)) => refusal.obstacles,
        other => panic!("{other:?}"),
    }
}

fn operation(name: &str) -> Action {
    Action::Operation(name.to_owned())
}

/// Returns a layout with one resource that performs these operations in its only state.
fn single(operations: &[&str], capacity: usize) -> Layout {
    let mut resource = Resource::new("r", &["s"], &[]).holding(capacity);
    for name in operations {
        resource = resource.with("s", operation(name), "s");
    }
    Layout {
        name: "Single".to_owned(),
        resources: vec![resource],
    }
}

fn recipe(parts: &[&str], steps: Vec<linewright_recipe::model::Step>) -> Recipe {
    Recipe {
        name: "Simple".to_owned(),
        parts: parts.iter().map(|n| Part::new(n, n)).collect(),
        states: vec!["a".to_owned(), "b".to_owned()],
        start: "a".to_owned(),
        ends: vec!["b".to_owned()],
        leftover: parts.iter().map(|n| (*n).to_owned()).collect(),
        transitions: vec![RecipeTransition::new("a", "b", Guard::Always, steps)],
    }
}

#[test]
fn parallel_operations_need_resources_of_their_own() {
    assert_eq!(
        obstacles(&pad::five(), &pad::hinge(true)),
        [Obstacle::TooFewPerformers {
            transition: 0,
            step: 2,
            performers: vec![2],
        }]
    );
}

#[test]
fn a_missing_route_is_named_for_each_part_that_needs_it() {
    let mut layout = pad::five();
    layout.resources[4].transitions.retain(|t| t.from != "s3");
    let way = |step, part: &str| Obstacle::NoWay {
        transition: 0,
        step: Some(step),
        part: part.to_owned(),
        from: vec![2],
        to: vec![1],
    };
    assert_eq!(
        obstacles(&layout, &pad::hinge(false)),
        [way(4, "p"), way(4, "h")]
    );
}

#[test]
fn room_is_needed_for_what_an_operation_makes() {
    let mut layout = pad::five();
    layout.resources[1].capacity = 1;
    let room = |step| Obstacle::NoRoom {
        transition: 0,
        step,
        operation: 0,
        parts: 2,
    };
    assert_eq!(obstacles(&layout, &pad::hinge(false)), [room(1), room(4)]);
}

#[test]
fn a_part_that_was_used_up_is_not_there() {
    let layout = single(&["load", "turn", "use"], 2);
    let steps = vec![
        step(&[("load", &[], &["p"])]),
        step(&[("use", &["p"], &[])]),
        step(&[("turn", &["p"], &["p"])]),
    ];
    let expected = Obstacle::NoSource {
        transition: 0,
        step: 2,
        part: "p".to_owned(),
    };
    assert_eq!(obstacles(&layout, &recipe(&["p"], steps)), [expected]);
    // With two of them, one is left.
    let steps = vec![
        step(&[("load", &[], &["p"])]),
        step(&[("load", &[], &["p"])]),
        step(&[("use", &["p"], &[])]),
        step(&[("turn", &["p"], &["p"])]),
    ];
    let outcome = realize(&layout, &recipe(&["p"], steps), SearchLimits::default());
    assert!(matches!(outcome, Ok(Outcome::Realizable(_))));
}

/// The part is tested at a resource to which no way leads.
#[test]
fn a_test_needs_its_part_where_it_is_performed() {
    let mut layout = single(&["load", "use"], 1);
    layout.resources.push(Resource::new("camera", &["s"], &[]));
    let mut recipe = recipe(&["p"], vec![step(&[("load", &[], &["p"])])]);
    recipe.states.push("c".to_owned());
    recipe.ends = vec!["c".to_owned()];
    let guard = Guard::Test {
        name: "ok".to_owned(),
        inputs: vec!["p".to_owned()],
        at: vec!["camera".to_owned()],
    };
    for guard in [guard, Guard::Otherwise] {
        let transition = RecipeTransition::new("b", "c", guard, Vec::new());
        recipe.transitions.push(transition);
    }
    assert_eq!(
        obstacles(&layout, &recipe),
        [Obstacle::NoWay {
            transition: 1,
            step: None,
            part: "p".to_owned(),
            from: vec![0],
            to: vec![1],
        }]
    );
}
