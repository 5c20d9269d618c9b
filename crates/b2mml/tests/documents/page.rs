//! The reference page `docs/reference/b2mml.md`: each example is read, and what is read or found is
//! the text below it.

use linewright_b2mml::{Activity, Document, Request, read};
use linewright_recipe::model::{Action, Guard, Layout, Recipe, Resource, Step};
use std::fmt::Write as _;
use std::path::Path;

/// Adds a line to a text.
macro_rules! line {
    ($text:expr, $($arguments:tt)*) => {
        writeln!($text, $($arguments)*).expect("a string takes all")
    };
}

fn layout(text: &mut String, layout: &Layout) {
    line!(text, "layout {}", layout.name);
    for resource in &layout.resources {
        add_resource(text, resource);
    }
}

fn add_resource(text: &mut String, resource: &Resource) {
    let Resource {
        name,
        initial,
        capacity,
        ..
    } = resource;
    let waiting = resource.states.iter().filter(|s| s.may_wait);
    let waiting: Vec<&str> = waiting.map(|s| s.name.as_str()).collect();
    let waiting = waiting.join(", ");
    line!(
        text,
        " {name} at {initial} holds {capacity}, may wait in {waiting}"
    );
    for transition in &resource.transitions {
        let action = match &transition.action {
            Action::Operation(name) => name.clone(),
            Action::Internal(name) => format!("internal {name}"),
            Action::In(label) => format!("in:{label}"),
            Action::Out(label) => format!("out:{label}"),
        };
        let time = transition.seconds.map(|s| format!(" in {s} s"));
        let time = time.unwrap_or_default();
        line!(
            text,
            "  {} -> {}: {action}{time}",
            transition.from,
            transition.to
        );
    }
}

fn step(step: &Step) -> String {
    let calls = step.operations.iter().map(|call| {
        let (inputs, outputs) = (call.inputs.join(", "), call.outputs.join(", "));
        format!("{}({inputs})({outputs})", call.name)
    });
    calls.collect::<Vec<_>>().join(" || ")
}

fn recipe(text: &mut String, recipe: &Recipe) {
    line!(text, "recipe {}", recipe.name);
    let parts = recipe
        .parts
        .iter()
        .map(|p| format!("{}: {}", p.name, p.kind));
    let parts: Vec<String> = parts.collect();
    if !parts.is_empty() {
        line!(text, " part {}", parts.join(", "));
    }
    let leftover = match recipe.leftover.join(", ") {
        names if names.is_empty() => names,
        names => format!("; leftover {names}"),
    };
    line!(
        text,
        " start {}; end {}{leftover}",
        recipe.start,
        recipe.ends.join(", ")
    );
    for transition in &recipe.transitions {
        let guard = match &transition.guard {
            Guard::Always => String::new(),
            Guard::Test { name, inputs, .. } => format!(" when {name}({})", inputs.join(", ")),
            Guard::Otherwise => " otherwise".to_owned(),
        };
        let steps: Vec<String> = transition.steps.iter().map(step).collect();
        let steps = match steps.join("; ") {
            steps if steps.is_empty() => steps,
            steps => format!(": {steps}"),
        };
        line!(
            text,
            " {} -> {}{guard}{steps}",
            transition.from,
            transition.to
        );
    }
}

fn request(text: &mut String, request: &Request) {
    let what = match &request.activity {
        Activity::Operation { resource, call, .. } => {
            let at = resource.as_ref().map(|r| format!(" at {r}"));
            let call = step(&Step::new(vec![call.clone()]));
            format!("{call}{}", at.unwrap_or_default())
        }
        Activity::Internal { resource, name } => format!("{name} of {resource}"),
        Activity::Transfer { from, to, part, .. } => {
            let part = part.as_deref().unwrap_or("part");
            format!("{part} from {from} to {to}")
        }
    };
    let time = request.seconds.map(|s| format!(" in {s} s"));
    let time = time.unwrap_or_default();
    line!(text, " {} of {}: {what}{time}", request.id, request.recipe);
}

/// Returns what a document says, or its findings.
fn told(document: &str) -> String {
    let mut text = String::new();
    match read(document.as_bytes()) {
        Ok(reading) => {
            assert!(reading.notes.list.is_empty(), "{}", reading.notes);
            match reading.document {
                Document::Layouts(all) => all.iter().for_each(|l| layout(&mut text, l)),
                Document::Recipes(all) => all.iter().for_each(|r| recipe(&mut text, r)),
                Document::Schedule(schedule) => {
                    line!(text, "schedule {}", schedule.name);
                    schedule.requests.iter().for_each(|r| request(&mut text, r));
                }
                Document::Performance(_) => panic!("the page has no performance"),
            }
        }
        Err(findings) => line!(text, "{findings}"),
    }
    text
}

#[test]
fn every_example_is_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/b2mml.md");
    let page = std::fs::read_to_string(path).expect("the page is there");
    let mut examples = 0;
    for piece in page.split("```xml\n").skip(1) {
        let (document, rest) = piece.split_once("```\n").expect("the example ends");
        let expected = rest
            .strip_prefix("\n```text\n")
            .expect("a text follows the example");
        let (expected, _) = expected.split_once("```\n").expect("the text ends");
        assert_eq!(told(document), expected, "{document}");
        examples += 1;
    }
    assert_eq!(examples, 8);
}

/// The page says what the crate can read, and which rules there are.
#[test]
fn the_tables_are_complete() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/b2mml.md");
    let page = std::fs::read_to_string(path).expect("the page is there");
    let types = include_str!("../../src/schema/types.txt");
    for root in types.lines().filter_map(|l| l.strip_prefix("root ")) {
        let name = root.split(' ').next().expect("a root has a name");
        assert!(page.contains(&format!("| `{name}` |")), "{name}");
    }
    let terms = include_str!("../../src/terms.rs");
    let words = terms
        .lines()
        .filter_map(|l| l.split_once(": &str = \"")?.1.split('"').next());
    let words: Vec<&str> = words.map(|w| w.trim_end_matches([':', ' '])).collect();
    assert!(words.len() > 40, "{words:?}");
    for word in words {
        assert!(page.contains(word), "{word}");
    }
    for rule in linewright_b2mml::Rule::ALL {
        assert!(page.contains(&format!("| {} |", rule.name())), "{rule:?}");
    }
}
