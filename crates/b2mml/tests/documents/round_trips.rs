//! What is written is read again as it was.

use crate::support::{
    self, cell, is_sound, pad, performance, random::Random, read_again, rename, schedule,
};
use linewright_b2mml::{Activity, Document, NoSequence, Schedule, read, write};
use linewright_recipe::model::{Action, Guard, Layout, Recipe, RecipeTransition};
use linewright_recipe::realize::{Outcome, SearchLimits, realize};

/// Number of documents of each kind that were written and read.
#[derive(Debug, Default)]
struct Counts {
    layouts: usize,
    recipes: usize,
    schedules: usize,
}

impl Counts {
    fn check(&mut self, layout: &Layout, recipe: &Recipe) {
        if is_sound(&layout.problems()) {
            let text = write::equipment(layout).expect("it is sound");
            assert_eq!(read_again(&text), Document::Layouts(vec![layout.clone()]));
            self.layouts += 1;
        } else {
            assert!(write::equipment(layout).is_err());
        }
        if is_sound(&recipe.problems()) {
            let expected = Document::Recipes(vec![recipe.clone()]);
            for text in [write::definition(recipe), write::workflow(recipe)] {
                let text = text.expect("it is sound");
                assert_eq!(read_again(&text), expected, "{text}");
            }
            self.recipes += 1;
        } else {
            assert!(write::definition(recipe).is_err());
            assert!(write::workflow(recipe).is_err());
        }
        let Some(schedule) = schedule(layout, recipe) else {
            return;
        };
        if schedule.requests.is_empty() {
            return;
        }
        let text = write::schedule(&schedule).expect("it has requests");
        let mut expected = schedule.clone();
        for request in &mut expected.requests {
            request.seconds = request.seconds.filter(|s| *s < 1e9);
        }
        assert_eq!(read_again(&text), Document::Schedule(expected), "{text}");
        let run = performance(&schedule);
        let text = write::performance(&run).expect("it has records");
        assert_eq!(read_again(&text), Document::Performance(run), "{text}");
        self.schedules += 1;
    }
}

#[test]
fn the_demonstrator_comes_back() {
    let mut counts = Counts::default();
    for resources in 5..=10 {
        for parallel in [false, true] {
            counts.check(&pad::layout(resources), &pad::hinge(parallel));
        }
    }
    assert!(
        counts.layouts == 12 && counts.recipes == 12 && counts.schedules == 11,
        "{counts:?}"
    );
}

#[test]
fn random_cells_come_back() {
    let mut counts = Counts::default();
    for seed in 0..1_000 {
        let (layout, recipe) = cell(seed);
        counts.check(&layout, &recipe);
    }
    assert!(counts.layouts > 800, "{counts:?}");
    assert!(counts.recipes > 700, "{counts:?}");
    assert!(counts.schedules > 200, "{counts:?}");
}

#[test]
fn random_cells_with_odd_names_come_back() {
    let mut counts = Counts::default();
    for seed in 0..600 {
        let (mut layout, mut recipe) = cell(seed);
        let kind = |name: &str| name.bytes().map(usize::from).sum::<usize>() + seed as usize;
        rename(&mut layout, &mut recipe, &|name| {
            support::odd(name, kind(name))
        });
        counts.check(&layout, &recipe);
    }
    assert!(counts.layouts > 400 && counts.recipes > 300, "{counts:?}");
    assert!(counts.schedules > 100, "{counts:?}");
}

/// A loop for rework, choices without steps, and states that are left by many transitions.
#[test]
fn graphs_come_back() {
    let mut counts = Counts::default();
    let layout = pad::five();
    for seed in 0..300 {
        let mut random = Random(seed);
        let mut recipe = pad::hinge(seed % 2 == 0);
        recipe.states = (0..6).map(|s| format!("q{s}")).collect();
        recipe.start = "q0".to_owned();
        recipe.ends = vec!["q5".to_owned()];
        let steps = recipe.transitions[0].steps.clone();
        recipe.transitions = Vec::new();
        for from in 0..5 {
            let branches = random.below(4);
            for branch in 0..=branches {
                let guard = match (branch, branches) {
                    (0, 0) => Guard::Always,
                    (0, _) => Guard::Otherwise,
                    _ => Guard::test(&format!("test{branch}"), &["p", "h"][..random.below(3)]),
                };
                let to = if branch == 0 {
                    from + 1
                } else {
                    random.below(6)
                };
                let begin = random.below(steps.len());
                let least = usize::from(to <= from);
                let count = least + random.below(steps.len() - begin + 1 - least);
                let names = (format!("q{from}"), format!("q{to}"));
                recipe.transitions.push(RecipeTransition::new(
                    &names.0,
                    &names.1,
                    guard,
                    steps[begin..begin + count].to_vec(),
                ));
            }
        }
        assert!(is_sound(&recipe.problems()), "{:?}", recipe.problems());
        counts.check(&layout, &recipe);
    }
    assert_eq!(counts.recipes, 300, "{counts:?}");
}

/// The schedule has one request for each operation and each transfer of the controller.
#[test]
fn schedules_have_what_the_controller_does() {
    let (layout, recipe) = (pad::layout(6), pad::hinge(true));
    let outcome = realize(&layout, &recipe, SearchLimits::default());
    let Ok(Outcome::Realizable(mut controller)) = outcome else {
        panic!("{outcome:?}");
    };
    let schedule = Schedule::of(&layout, &recipe, &controller).expect("it is right");
    let (mut operations, mut transfers) = (0, 0);
    let legs = controller.positions.iter().flat_map(|p| &p.legs);
    for m in legs.flat_map(|l| &l.vectors).flat_map(|v| &v.moves) {
        match layout.resources[m.resource].transitions[m.transition].action {
            Action::Operation(_) => operations += 1,
            Action::Out(_) => transfers += 1,
            Action::In(_) | Action::Internal(_) => {}
        }
    }
    let is_transfer = |a: &Activity| matches!(a, Activity::Transfer { .. });
    let found = schedule
        .requests
        .iter()
        .filter(|r| is_transfer(&r.activity))
        .count();
    assert_eq!(
        (schedule.requests.len() - found, found),
        (operations, transfers)
    );
    assert!(operations > 8 && transfers > 15, "{operations} {transfers}");
    let kinds: Vec<&str> = schedule.parts.iter().map(|p| p.kind.as_str()).collect();
    assert_eq!(kinds, ["Fixture", "Pin", "Hinge", "Hinge"]);

    let text = write::schedule(&schedule).expect("it has requests");
    assert_eq!(
        text.matches("<OperationsRequest>").count(),
        operations + transfers
    );
    assert_eq!(
        text.matches("OtherValue=\"Routing\"").count(),
        2 * transfers
    );
    assert_eq!(
        schedule.recipes(),
        Err(NoSequence::Choices("Hinge".to_owned()))
    );

    controller.positions[0].legs[0].vectors.pop();
    assert!(Schedule::of(&layout, &recipe, &controller).is_err());
}

/// Without choices, a recipe comes back from its schedule, but for the names of its states.
#[test]
fn recipes_come_back_from_schedules() {
    let mut recipe = pad::hinge(true);
    recipe.transitions.truncate(1);
    recipe.states = vec!["start".to_owned(), "end".to_owned()];
    recipe.start = "start".to_owned();
    recipe.ends = vec!["end".to_owned()];
    recipe.leftover = vec!["h2".to_owned()];
    "start".clone_into(&mut recipe.transitions[0].from);
    "end".clone_into(&mut recipe.transitions[0].to);
    let schedule = schedule(&pad::layout(6), &recipe).expect("it is realizable");
    let text = write::schedule(&schedule).expect("it has requests");
    let Document::Schedule(schedule) = read_again(&text) else {
        panic!("{text}");
    };
    let mut found = schedule.recipes().expect("there are no choices");
    // Operations of a step are in the order of their resources.
    let sort = |recipe: &mut Recipe| {
        for step in recipe.transitions.iter_mut().flat_map(|t| &mut t.steps) {
            step.operations.sort_by(|a, b| a.name.cmp(&b.name));
        }
    };
    sort(&mut recipe);
    sort(&mut found[0]);
    assert_eq!(found, [recipe]);
}

/// A recipe with 10,000 operations: its documents, and a schedule of as many requests.
pub fn large() -> (Recipe, Schedule) {
    let mut recipe = pad::hinge(true);
    let steps = recipe.transitions[0].steps.clone();
    let repeated = steps[1..3].iter().cycle().take(6_666).cloned();
    recipe.transitions[0].steps = steps[..1].iter().cloned().chain(repeated).collect();
    let layout = pad::layout(6);
    let outcome = schedule(&layout, &pad::hinge(true)).expect("it is realizable");
    let mut large = outcome.clone();
    large.requests = (0..10_000)
        .map(|n| {
            let mut request = outcome.requests[n % outcome.requests.len()].clone();
            request.id = format!("{n}");
            request
        })
        .collect();
    (recipe, large)
}

#[test]
fn ten_thousand_segments_come_back() {
    let (recipe, schedule) = large();
    let text = write::definition(&recipe).expect("it is sound");
    assert!(text.matches("<OperationsSegmentChild>").count() > 9_999);
    assert_eq!(read_again(&text), Document::Recipes(vec![recipe.clone()]));
    let text = write::workflow(&recipe).expect("it is sound");
    assert_eq!(read_again(&text), Document::Recipes(vec![recipe]));
    let text = write::schedule(&schedule).expect("it has requests");
    assert_eq!(read_again(&text), Document::Schedule(schedule));
}

/// Returns the time that this thread has computed for, which Linux tells; elsewhere the time since
/// a fixed moment.
fn processor_time() -> std::time::Duration {
    static BEGIN: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    let status = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = status.split(' ').next().and_then(|n| n.parse().ok());
    nanoseconds.map_or_else(|| BEGIN.elapsed(), std::time::Duration::from_nanos)
}

/// Measures 10,000 segments. A release build may take well under a second for each.
#[test]
#[ignore = "measures: cargo test --release -p linewright-b2mml ten_thousand -- --ignored --nocapture"]
fn time_of_ten_thousand_segments() {
    let (recipe, schedule) = large();
    let writers: [(&str, &dyn Fn() -> String); 4] = [
        ("definition", &|| write::definition(&recipe).expect("sound")),
        ("workflow", &|| write::workflow(&recipe).expect("sound")),
        ("schedule", &|| write::schedule(&schedule).expect("sound")),
        ("performance", &|| {
            write::performance(&performance(&schedule)).expect("sound")
        }),
    ];
    for (name, writer) in writers {
        let start = processor_time();
        let text = writer();
        let middle = processor_time();
        let reading = read(text.as_bytes());
        let written = middle.saturating_sub(start);
        let taken = processor_time().saturating_sub(middle);
        assert!(reading.is_ok());
        println!(
            "{name}: {} bytes, written in {written:?}, read in {taken:?}",
            text.len()
        );
    }
}
