//! Shared by the tests: random cells with times, their plans and runs.

#[path = "../../../../tests/support/external.rs"]
pub mod external;
#[path = "../../../../tests/support/mesa.rs"]
pub mod mesa;
#[path = "../../../recipe/tests/support/pad.rs"]
pub mod pad;
#[allow(dead_code, reason = "each test program uses its own part")]
#[path = "../../../recipe/tests/support/random.rs"]
pub mod random;
#[path = "../../../recipe/tests/support/rename.rs"]
mod rename;

use linewright_b2mml::{Document, Performance, Record, Schedule, WriteError, read, write};
use linewright_recipe::model::{Layout, Problem, Recipe};
use linewright_recipe::realize::{Outcome, SearchLimits, realize};
use random::Random;
pub use rename::rename;

/// Returns a random cell, whose transitions have random durations and powers.
pub fn cell(seed: u64) -> (Layout, Recipe) {
    let (mut layout, mut recipe) = random::cell(seed);
    let mut random = Random(seed ^ 0x5eed);
    let values = [0.0, 12.0, 0.1, 1e-9, 123_456.789, 1e12];
    let mut value = || {
        let value = values.get(random.below(2 * values.len()));
        value.copied()
    };
    for transition in layout.resources.iter_mut().flat_map(|r| &mut r.transitions) {
        transition.seconds = value();
        transition.watts = value();
    }
    layout.name = format!("Cell {seed}");
    recipe.name = format!("Recipe {seed}");
    (layout, recipe)
}

/// Returns whether there are no problems but warnings.
pub fn is_sound(problems: &[Problem]) -> bool {
    problems.iter().all(Problem::is_warning)
}

/// Returns the schedule of a controller for a recipe on a layout, if a short search finds one.
pub fn schedule(layout: &Layout, recipe: &Recipe) -> Option<Schedule> {
    let limits = SearchLimits {
        nodes: 2_000,
        vectors: 20_000,
    };
    match realize(layout, recipe, limits) {
        Ok(Outcome::Realizable(controller)) => {
            Some(Schedule::of(layout, recipe, &controller).expect("the controller is right"))
        }
        _ => None,
    }
}

/// Returns a run that carries out the requests of a schedule one after the other.
pub fn performance(schedule: &Schedule) -> Performance {
    let mut time = 0.0;
    let records = schedule.requests.iter().enumerate();
    let records = records.map(|(number, request)| {
        let begin = time;
        time += request.seconds.unwrap_or(0.25).min(1e6);
        Record {
            activity: request.activity.clone(),
            recipe: request.recipe.clone(),
            product: format!("{} {}", request.recipe, number / 7),
            request: (number % 3 > 0).then(|| request.id.clone()),
            begin,
            end: time,
        }
    });
    Performance {
        name: format!("Run of {}", schedule.name),
        schedule: Some(schedule.name.clone()),
        started: 1_796_040_000,
        parts: schedule.parts.clone(),
        records: records.collect(),
    }
}

/// Writes a document anew. Recipes become definitions; of several layouts or recipes, the first is
/// written.
pub fn written(document: &Document) -> Result<String, WriteError> {
    match document {
        Document::Layouts(layouts) => write::equipment(&layouts[0]),
        Document::Recipes(recipes) => write::definition(&recipes[0]),
        Document::Schedule(schedule) => write::schedule(schedule),
        Document::Performance(performance) => write::performance(performance),
    }
}

/// Reads a document that was written, which leaves nothing out.
pub fn read_again(text: &str) -> Document {
    let reading = read(text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert!(reading.notes.list.is_empty(), "{}\n{text}", reading.notes);
    reading.document
}

/// Returns the documents of a cell: layout, recipe twice, schedule and performance if there are
/// any.
pub fn documents(layout: &Layout, recipe: &Recipe) -> Vec<String> {
    let mut documents = Vec::new();
    documents.extend(write::equipment(layout).ok());
    documents.extend(write::definition(recipe).ok());
    documents.extend(write::workflow(recipe).ok());
    if let Some(schedule) = schedule(layout, recipe) {
        documents.extend(write::schedule(&schedule).ok());
        documents.extend(write::performance(&performance(&schedule)).ok());
    }
    documents
}

/// Returns a name that is hard to write: each of them differs from the others, and from any other
/// name. `kind` chooses how.
pub fn odd(name: &str, kind: usize) -> String {
    match (name, kind % 12) {
        ("a", 0) => String::new(),
        ("a", 1) => " ".to_owned(),
        ("a", 2) => "\u{200b}".to_owned(),
        ("a", 3) => "_x_".to_owned(),
        (_, 0) => format!("  {name}  x "),
        (_, 1) => format!("<{name}>&amp;\"'"),
        (_, 2) => format!("Größe {name} → 3 µm"),
        (_, 3) => format!("_x0041_{name}"),
        (_, 4) => format!("{name}\t\r\n\u{1}\u{ffff}"),
        (_, 5) => format!("{}{name}", "long ".repeat(800)),
        (_, 6) => format!("{name}A{}", name.to_lowercase()),
        (_, 7) => format!("{name}a{}", name.to_lowercase()),
        (_, 8) => format!("]]>{name}<!-- -->"),
        (_, 9) => format!("{name}\u{301}\u{a0}\u{10ffff}"),
        (_, 10) => format!("state:{name}"),
        _ => format!("T1.S1.O1 {name}(x)(y); || when otherwise"),
    }
}
