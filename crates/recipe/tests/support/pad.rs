//! Reconstruction of the Precision Assembly Demonstrator (PAD) of the paper.
//!
//! The transitions are drawn in the paper, not written. These fit every sentence of its text.

use linewright_recipe::model::{
    Action, Guard, Layout, OperationCall, Part, Recipe, RecipeTransition, Resource, Step,
};

fn operation(name: &str) -> Action {
    Action::Operation(name.to_owned())
}

fn take(label: &str) -> Action {
    Action::In(label.to_owned())
}

fn give(label: &str) -> Action {
    Action::Out(label.to_owned())
}

/// Returns the layout with five resources, without duplicates.
pub fn five() -> Layout {
    let r1 = Resource::new("r1", &["s0", "s1"], &["s2"])
        .with("s0", operation("load"), "s1")
        .with("s0", take("1"), "s2")
        .with("s1", give("1"), "s0")
        .with("s2", operation("store"), "s0")
        .with("s2", operation("remove"), "s0");
    let r2 = Resource::new("r2", &["s0", "s1", "s2", "s3"], &["s4", "s5"])
        .holding(2)
        .with("s0", take("2"), "s1")
        .with("s1", operation("separate"), "s2")
        .with("s2", give("2"), "s3")
        .with("s3", give("2"), "s0")
        .with("s1", take("2"), "s4")
        .with("s4", operation("insert"), "s5")
        .with("s5", give("2"), "s0");
    let r3 = Resource::new("r3", &["s0", "s1", "s2"], &["s3", "s4"])
        .holding(2)
        .with("s0", take("3"), "s1")
        .with("s1", operation("glue"), "s2")
        .with("s1", operation("engrave"), "s2")
        .with("s2", give("3"), "s0")
        .with("s2", take("3"), "s3")
        .with("s3", operation("glue"), "s4")
        .with("s3", operation("engrave"), "s4")
        .with("s4", give("3"), "s2");
    let r4 = Resource::new("r4", &["s0", "s3"], &["s1", "s2"])
        .with("s0", take("4"), "s1")
        .with("s1", operation("vision"), "s2")
        .with("s2", operation("force"), "s3")
        .with("s2", give("4"), "s0")
        .with("s3", give("4"), "s0");
    let mut r5 = Resource::new("r5", &["s0", "s1", "s2", "s3", "s4"], &[]);
    for label in ["1", "2", "3", "4"] {
        r5 = r5.with("s0", take(label), &format!("s{label}"));
    }
    let routes = [
        ("s1", "2"),
        ("s2", "3"),
        ("s2", "4"),
        ("s3", "2"),
        ("s4", "1"),
    ];
    for (from, label) in routes {
        r5 = r5.with(from, give(label), "s0");
    }
    Layout {
        name: "Pad".to_owned(),
        resources: vec![r1, r2, r3, r4, r5],
    }
}

/// Returns the layout with five or more resources: the first duplicate is one of R3, then R1, R2,
/// R4, R1, and again from R3.
pub fn layout(resources: usize) -> Layout {
    let mut layout = five();
    let order = ["r3", "r1", "r2", "r4", "r1"];
    for (at, of) in order.iter().cycle().take(resources - 5).enumerate() {
        (layout.duplicate(of, &format!("r{}", at + 6))).expect("the names are new");
    }
    layout
}

/// Returns one step.
pub fn step(calls: &[(&str, &[&str], &[&str])]) -> Step {
    Step::new(
        (calls.iter())
            .map(|(n, i, o)| OperationCall::new(n, i, o))
            .collect(),
    )
}

/// Returns the recipe of the hinge; glue and engrave are in parallel or in sequence.
pub fn hinge(parallel: bool) -> Recipe {
    let mut steps = vec![
        step(&[("load", &[], &["f"])]),
        step(&[("separate", &["f"], &["p", "h"])]),
    ];
    let glue: (&str, &[&str], &[&str]) = ("glue", &["p"], &["p"]);
    let engrave: (&str, &[&str], &[&str]) = ("engrave", &["h"], &["h"]);
    if parallel {
        steps.push(step(&[glue, engrave]));
    } else {
        steps.extend([step(&[glue]), step(&[engrave])]);
    }
    steps.extend([
        step(&[("insert", &["p", "h"], &["h2"])]),
        step(&[("vision", &["h2"], &["h2"])]),
    ]);
    let remove = || vec![step(&[("remove", &["h2"], &[])])];
    let test = |name| Guard::test(name, &["h2"]);
    Recipe {
        name: "Hinge".to_owned(),
        parts: vec![
            Part::new("f", "Fixture"),
            Part::new("p", "Pin"),
            Part::new("h", "Hinge"),
            Part::new("h2", "Hinge"),
        ],
        states: ["a", "b", "c", "d", "e"].map(str::to_owned).to_vec(),
        start: "a".to_owned(),
        ends: vec!["d".to_owned(), "e".to_owned()],
        leftover: Vec::new(),
        transitions: vec![
            RecipeTransition::new("a", "b", Guard::Always, steps),
            RecipeTransition::new(
                "b",
                "c",
                test("visionOk"),
                vec![step(&[("force", &["h2"], &["h2"])])],
            ),
            RecipeTransition::new("b", "d", Guard::Otherwise, remove()),
            RecipeTransition::new(
                "c",
                "e",
                test("forceOk"),
                vec![step(&[("store", &["h2"], &[])])],
            ),
            RecipeTransition::new("c", "d", Guard::Otherwise, remove()),
        ],
    }
}
