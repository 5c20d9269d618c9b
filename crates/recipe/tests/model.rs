//! Validation, duplicates, and what parts and tests mean.

mod support;

use linewright_recipe::controller::Subject;
use linewright_recipe::model::{
    Action, DuplicateError, Guard, Layout, Part, Problem, Recipe, RecipeTransition, Resource,
    Transition,
};
use linewright_recipe::realize::{Obstacle, Outcome, Refusal, SearchLimits, SearchSize, realize};
use linewright_recipe::topology::{self, TopologyError};
use linewright_recipe::{replay, topology::TopologySize};
use support::pad::{self, step};

fn operation(name: &str) -> Action {
    Action::Operation(name.to_owned())
}

fn texts(problems: &[Problem]) -> Vec<String> {
    problems.iter().map(ToString::to_string).collect()
}

fn solve(layout: &Layout, recipe: &Recipe) -> Outcome {
    let outcome = realize(layout, recipe, SearchLimits::default()).expect("there are no problems");
    if let Outcome::Realizable(controller) = &outcome {
        assert_eq!(replay::verify(layout, recipe, controller), Ok(()));
    }
    outcome
}

fn worst_case(outcome: &Outcome) -> Option<u32> {
    match outcome {
        Outcome::Realizable(controller) => Some(controller.worst_case),
        _ => None,
    }
}

/// Returns a recipe with one transition.
fn simple(parts: &[(&str, &str)], steps: Vec<linewright_recipe::model::Step>) -> Recipe {
    Recipe {
        name: "Simple".to_owned(),
        parts: parts.iter().map(|(n, k)| Part::new(n, k)).collect(),
        states: vec!["a".to_owned(), "b".to_owned()],
        start: "a".to_owned(),
        ends: vec!["b".to_owned()],
        leftover: parts.iter().map(|(n, _)| (*n).to_owned()).collect(),
        transitions: vec![RecipeTransition::new("a", "b", Guard::Always, steps)],
    }
}

/// Returns two stations, joined by a route from the first to the second.
fn two_stations() -> Layout {
    let out = Action::Out("x".to_owned());
    let take = Action::In("x".to_owned());
    Layout {
        name: "Two".to_owned(),
        resources: vec![
            Resource::new("r1", &["s"], &[])
                .with("s", operation("make"), "s")
                .with("s", out, "s"),
            Resource::new("r2", &["s"], &[])
                .with("s", operation("use"), "s")
                .with("s", take, "s"),
        ],
    }
}

#[test]
fn the_demonstrator_has_no_problems() {
    assert_eq!(pad::layout(10).problems(), []);
    assert_eq!(pad::hinge(true).problems(), []);
}

#[test]
fn all_problems_of_a_layout_are_reported() {
    let mut bad = Resource::new("r1", &["s", "s"], &["t"])
        .with("s", Action::In("x".to_owned()), "u")
        .with("s", Action::Out("x".to_owned()), "s");
    bad.holds = vec!["p".to_owned(), "q".to_owned()];
    bad.transitions.push(Transition {
        from: "s".to_owned(),
        to: "s".to_owned(),
        action: operation("o"),
        seconds: Some(-1.0),
        watts: Some(f64::NAN),
    });
    let layout = Layout {
        name: "Bad".to_owned(),
        resources: vec![bad, Resource::new("r1", &["s"], &[])],
    };
    let expected = [
        "two resources are called `r1`",
        "resource `r1` has two states `s`",
        "resource `r1` has no state `u`",
        "resource `r1`: the duration of the transition from `s` to `s` is not a number of at least \
         zero",
        "resource `r1`: the power of the transition from `s` to `s` is not a number of at least \
         zero",
        "resource `r1` holds 2 parts at the start, but has room for 1",
        "resource `r1` may not wait in state `t`, and no transition leaves it",
        "resource `r1` has a transfer `in:x`, but no other resource is its partner",
        "resource `r1` has a transfer `out:x`, but no other resource is its partner",
    ];
    assert_eq!(texts(&layout.problems()), expected);
    let empty = Layout::default();
    assert_eq!(texts(&empty.problems()), ["the layout `` has no resources"]);
    let refused = topology::size(&empty, 10);
    assert!(matches!(refused, Err(TopologyError::Problems(p)) if p.len() == 1));
}

#[test]
fn all_problems_of_a_recipe_are_reported() {
    let mut recipe = simple(&[("p", "P"), ("p", "P")], vec![step(&[])]);
    recipe.states = ["a", "b", "b", "c", "d"].map(str::to_owned).to_vec();
    recipe.ends = vec!["b".to_owned(), "z".to_owned()];
    recipe.leftover = vec!["P".to_owned(), "Q".to_owned()];
    let test = |at: &str| Guard::Test {
        name: "good".to_owned(),
        inputs: vec!["q".to_owned()],
        at: vec![at.to_owned()],
    };
    recipe.transitions.extend([
        RecipeTransition::new("b", "a", Guard::Always, vec![step(&[("o", &[], &["r"])])]),
        RecipeTransition::new("c", "c", test("r9"), Vec::new()),
        RecipeTransition::new("a", "a", Guard::Otherwise, vec![step(&[("o", &[], &[])])]),
        RecipeTransition::new("a", "b", Guard::Otherwise, vec![step(&[("o", &[], &[])])]),
    ]);
    let expected = [
        "part `p` is declared twice",
        "state `b` of the recipe is declared twice",
        "the recipe has no state `z`",
        "`Q` may be left over, but is neither a part nor a type of a part",
        "step 0 of transition 0 has no operations",
        "transition 1: the recipe has no part `r`",
        "transition 1 leaves the end `b`",
        "transition 2: the recipe has no part `q`",
        "two transitions with `otherwise` leave state `a`",
        "the guards of state `c` do not cover every outcome: `otherwise` is missing",
        "no transition leaves state `d`, which is not an end",
    ];
    assert_eq!(texts(&recipe.problems()), expected);
    let on = recipe.problems_on(&two_stations());
    assert_eq!(
        texts(&on),
        ["transition 2: the layout has no resource `r9` for the test"]
    );
    recipe.ends.pop();
    let problems = texts(&recipe.problems());
    assert!(problems.contains(&"a loop through state `c` has no operation".to_owned()));
    let unreachable = "state `c` cannot be reached from the start of the recipe".to_owned();
    assert!(problems.contains(&unreachable));
}

#[test]
fn a_duplicate_needs_an_original_and_a_new_name() {
    let mut layout = pad::five();
    let unknown = layout.duplicate("r9", "r6");
    assert_eq!(unknown, Err(DuplicateError::Unknown("r9".to_owned())));
    let taken = layout.duplicate("r1", "r2");
    assert_eq!(taken, Err(DuplicateError::Taken("r2".to_owned())));
    assert_eq!(layout, pad::five());
}

#[test]
fn an_empty_resource_gives_nothing() {
    let layout = two_stations();
    let recipe = simple(&[("p", "P")], vec![step(&[("use", &["p"], &[])])]);
    let expected = Obstacle::NoSource {
        transition: 0,
        step: 0,
        part: "p".to_owned(),
    };
    let outcome = solve(&layout, &recipe);
    assert!(matches!(outcome, Outcome::Unrealizable(r) if r.obstacles == [expected]));
    let steps = vec![
        step(&[("make", &[], &["p"])]),
        step(&[("use", &["p"], &[])]),
    ];
    let outcome = solve(&layout, &simple(&[("p", "P")], steps));
    assert_eq!(worst_case(&outcome), Some(3));
}

#[test]
fn an_operation_that_no_resource_has_is_named() {
    let steps = vec![
        step(&[("make", &[], &["p"])]),
        step(&[("paint", &["p"], &["p"])]),
    ];
    let outcome = solve(&two_stations(), &simple(&[("p", "P")], steps));
    let expected = Refusal {
        obstacles: vec![Obstacle::NoPerformer {
            transition: 0,
            step: 1,
            operation: "paint".to_owned(),
        }],
        furthest_steps: vec![None],
        size: SearchSize::default(),
    };
    assert_eq!(outcome, Outcome::Unrealizable(expected));
}

#[test]
fn stock_replaces_a_part_only_while_there_is_none() {
    let mut layout = two_stations();
    layout.resources[1].holds = vec!["P".to_owned()];
    let used = vec![step(&[("use", &["p"], &[])])];
    let outcome = solve(&layout, &simple(&[("p", "P")], used));
    assert_eq!(worst_case(&outcome), Some(1));
    // The part that was made has to be used, and the stock is in its way.
    let made = vec![
        step(&[("make", &[], &["p"])]),
        step(&[("use", &["p"], &[])]),
    ];
    let recipe = simple(&[("p", "P")], made);
    let Outcome::Unrealizable(refusal) = solve(&layout, &recipe) else {
        panic!("it uses the stock");
    };
    assert_eq!(refusal.furthest_steps, [Some(1)]);
    layout.resources[1].capacity = 2;
    let Outcome::Realizable(controller) = solve(&layout, &recipe) else {
        panic!("there is room");
    };
    let end = &controller.positions[1];
    assert_eq!(end.parts, [vec![], vec!["P".to_owned()]]);
}

#[test]
fn what_may_not_remain_is_refused() {
    let mut recipe = simple(&[("p", "P")], vec![step(&[("make", &[], &["p"])])]);
    assert_eq!(worst_case(&solve(&two_stations(), &recipe)), Some(1));
    recipe.leftover = vec!["P".to_owned()];
    assert_eq!(worst_case(&solve(&two_stations(), &recipe)), Some(1));
    recipe.leftover.clear();
    assert_eq!(worst_case(&solve(&two_stations(), &recipe)), None);
}

#[test]
fn a_test_needs_its_part_at_the_resource_that_performs_it() {
    let mut recipe = simple(&[("p", "P")], vec![step(&[("make", &[], &["p"])])]);
    recipe.states.push("c".to_owned());
    recipe.ends = vec!["c".to_owned()];
    let test = |at: &[&str]| Guard::Test {
        name: "good".to_owned(),
        inputs: vec!["p".to_owned()],
        at: at.iter().map(|r| (*r).to_owned()).collect(),
    };
    recipe.transitions.extend([
        RecipeTransition::new("b", "c", Guard::Always, Vec::new()),
        RecipeTransition::new("b", "c", Guard::Otherwise, Vec::new()),
    ]);
    for (at, vectors) in [
        (&[][..], 1),
        (&["r1"][..], 1),
        (&["r2"][..], 2),
        (&["r2", "r1"][..], 1),
    ] {
        recipe.transitions[1].guard = test(at);
        assert_eq!(
            worst_case(&solve(&two_stations(), &recipe)),
            Some(vectors),
            "{at:?}"
        );
    }
}

/// A part is made again and again; what is used up each time can be repeated for ever.
#[test]
fn a_loop_is_realizable_if_it_can_be_repeated_for_ever() {
    let rounds = |steps| {
        let mut recipe = simple(&[("p", "P")], vec![step(&[("make", &[], &["p"])])]);
        recipe.states.push("c".to_owned());
        recipe.ends = vec!["c".to_owned()];
        recipe.transitions.extend([
            RecipeTransition::new("b", "a", Guard::test("bad", &["p"]), steps),
            RecipeTransition::new("b", "c", Guard::Otherwise, Vec::new()),
        ]);
        recipe
    };
    let used = rounds(vec![step(&[("use", &["p"], &[])])]);
    let Outcome::Realizable(controller) = solve(&two_stations(), &used) else {
        panic!("the loop uses up what it makes");
    };
    assert_eq!(used.closes_loop(), [false, true, false]);
    assert_eq!((controller.worst_case, controller.positions.len()), (3, 3));
    // Nothing takes the parts away, so the third one finds no room.
    let kept = rounds(Vec::new());
    let Outcome::Unrealizable(_) = solve(&two_stations(), &kept) else {
        panic!("the cell has no room for that");
    };
}

#[test]
fn the_parts_of_a_transfer_are_chosen() {
    let mut layout = two_stations();
    layout.resources[0].capacity = 2;
    let steps = vec![
        step(&[("make", &[], &["p", "q"])]),
        step(&[("use", &["q"], &[])]),
    ];
    let Outcome::Realizable(controller) = solve(&layout, &simple(&[("p", "P"), ("q", "Q")], steps))
    else {
        panic!("it is realizable");
    };
    let vectors = &controller.positions[0].legs[0].vectors;
    let moved = &vectors[1].moves;
    assert_eq!(vectors.len(), 3);
    assert_eq!(controller.vectors(), 3);
    assert!(
        moved
            .iter()
            .all(|m| m.subject == Subject::Part("q".to_owned()))
    );
}

#[test]
fn limits_are_reported() {
    let limits = SearchLimits {
        nodes: 20,
        ..SearchLimits::default()
    };
    let outcome = realize(&pad::five(), &pad::hinge(false), limits);
    assert!(matches!(
        outcome,
        Ok(Outcome::GaveUp(SearchSize { nodes: 21.., .. }))
    ));
    let limits = SearchLimits {
        vectors: 20,
        ..SearchLimits::default()
    };
    let outcome = realize(&pad::five(), &pad::hinge(false), limits);
    assert!(matches!(outcome, Ok(Outcome::GaveUp(_))));
    let few = topology::size(&pad::five(), 287);
    assert_eq!(few, Err(TopologyError::TooManyStates(287)));
    let size = TopologySize {
        states: 288,
        transitions: 1_300,
    };
    assert_eq!(topology::size(&pad::five(), 288), Ok(size));
}

/// Twenty resources that turn at any time have a million vectors; one event at a time is enough.
#[test]
fn one_event_at_a_time_is_enough_where_all_may_wait() {
    let mut layout = two_stations();
    for number in 0..20 {
        let turn = Action::Internal("turn".to_owned());
        let resource = Resource::new(&format!("t{number}"), &["s", "t"], &[]);
        layout
            .resources
            .push(resource.with("s", turn.clone(), "t").with("t", turn, "s"));
    }
    let limits = SearchLimits {
        nodes: 20_000,
        vectors: 200_000,
    };
    let steps = vec![
        step(&[("make", &[], &["p"])]),
        step(&[("use", &["p"], &[])]),
    ];
    let recipe = simple(&[("p", "P")], steps);
    let outcome = realize(&layout, &recipe, limits);
    let Ok(Outcome::Realizable(controller)) = outcome else {
        panic!("{outcome:?}");
    };
    assert_eq!(replay::verify(&layout, &recipe, &controller), Ok(()));
    assert_eq!((controller.worst_case, controller.is_least), (3, false));
}

/// Neither the length of a recipe nor the number of retractions is a depth of recursion.
#[test]
fn long_recipes_and_long_loops_are_searched() {
    let length = 3_000;
    let states: Vec<String> = (0..=length).map(|n| format!("q{n}")).collect();
    let steps = || {
        vec![
            step(&[("make", &[], &["p"])]),
            step(&[("use", &["p"], &[])]),
        ]
    };
    let mut recipe = simple(&[("p", "P")], Vec::new());
    recipe.transitions = (states.windows(2))
        .map(|w| RecipeTransition::new(&w[0], &w[1], Guard::Always, steps()))
        .collect();
    recipe.start.clone_from(&states[0]);
    recipe.ends = vec![states[length].clone()];
    recipe.states = states;
    let outcome = solve(&two_stations(), &recipe);
    assert_eq!(worst_case(&outcome), Some(3 * length as u32));

    // Parts are made, and never used, until the buffer is full.
    let mut layout = two_stations();
    layout.resources[1].capacity = 300;
    let mut recipe = simple(&[("p", "P")], vec![step(&[("make", &[], &["p"])])]);
    recipe.states.push("c".to_owned());
    recipe.ends = vec!["c".to_owned()];
    recipe.transitions.extend([
        RecipeTransition::new("b", "a", Guard::test("more", &[]), Vec::new()),
        RecipeTransition::new("b", "c", Guard::Otherwise, Vec::new()),
    ]);
    let Outcome::Unrealizable(refusal) = solve(&layout, &recipe) else {
        panic!("the buffer is full at some time");
    };
    assert_eq!(refusal.furthest_steps, [Some(1), Some(0), Some(0)]);
}
