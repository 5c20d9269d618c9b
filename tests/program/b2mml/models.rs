//! Models that are written as B2MML and imported are the same models, but for their names.

#[path = "../../../crates/recipe/tests/support/random.rs"]
#[allow(dead_code, reason = "each test program uses its own part")]
mod random;
#[path = "../../../crates/recipe/tests/support/rename.rs"]
mod rename;

use linewright::b2mml::write;
use linewright::contract::{self, Library};
use linewright::diagnostics::has_errors;
use linewright::engine::recipes::import::convert;
use linewright::recipe::model::{
    Action, Guard, Layout, OperationCall, Problem, Recipe, RecipeTransition, Transition,
};
use linewright::recipe::realize::{Outcome, SearchLimits, realize};
use rename::rename;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// The words that names have become: one for each, and no word twice.
#[derive(Default)]
struct Words {
    words: BTreeMap<(bool, String), String>,
    names: BTreeMap<(bool, String), String>,
}

impl Words {
    fn pair(&mut self, is_label: bool, name: &str, word: &str) {
        let known = self
            .words
            .insert((is_label, name.to_owned()), word.to_owned());
        assert!(known.is_none_or(|k| k == word), "{name} is {word}, too");
        let known = self
            .names
            .insert((is_label, word.to_owned()), name.to_owned());
        assert!(known.is_none_or(|k| k == name), "{word} is {name}, too");
    }

    fn same(&mut self, name: &str, word: &str) {
        self.pair(false, name, word);
    }

    fn same_lists(&mut self, names: &[String], words: &[String]) {
        assert_eq!(names.len(), words.len(), "{names:?} {words:?}");
        for (name, word) in names.iter().zip(words) {
            self.same(name, word);
        }
    }

    /// Compares a layout with the imported one. What no transition mentions, or what cannot happen
    /// because the first state is not left, is not imported.
    fn layout(&mut self, layout: &Layout, imported: &Layout) {
        assert_eq!(layout.resources.len(), imported.resources.len());
        for (resource, imported) in layout.resources.iter().zip(&imported.resources) {
            self.same(&resource.name, &imported.name);
            self.same(&resource.initial, &imported.initial);
            self.same_lists(&resource.holds, &imported.holds);
            assert_eq!(resource.capacity, imported.capacity);
            let ends = |t: &Transition| [t.from.clone(), t.to.clone()];
            let mut known: BTreeSet<String> = resource.transitions.iter().flat_map(ends).collect();
            let mut transitions = resource.transitions.as_slice();
            if known.insert(resource.initial.clone()) {
                known = BTreeSet::from([resource.initial.clone()]);
                transitions = &[];
            }
            assert_eq!(transitions.len(), imported.transitions.len());
            for (transition, imported) in transitions.iter().zip(&imported.transitions) {
                self.same(&transition.from, &imported.from);
                self.same(&transition.to, &imported.to);
                let bits = |value: Option<f64>| value.map(f64::to_bits);
                assert_eq!(bits(transition.seconds), bits(imported.seconds));
                assert_eq!(bits(transition.watts), bits(imported.watts));
                match (&transition.action, &imported.action) {
                    (Action::Operation(a), Action::Operation(b))
                    | (Action::Internal(a), Action::Internal(b)) => self.same(a, b),
                    (Action::In(a), Action::In(b)) | (Action::Out(a), Action::Out(b)) => {
                        self.pair(true, a, b);
                    }
                    other => panic!("{other:?}"),
                }
            }
            let states = resource.states.iter().filter(|s| known.contains(&s.name));
            let states = states.map(|s| (self.words[&(false, s.name.clone())].clone(), s.may_wait));
            let expected: BTreeSet<_> = states.collect();
            let states = imported.states.iter();
            let found: BTreeSet<_> = states.map(|s| (s.name.clone(), s.may_wait)).collect();
            assert_eq!(found, expected);
        }
    }

    fn recipe(&mut self, recipe: &Recipe, imported: &Recipe) {
        assert_eq!(recipe.parts.len(), imported.parts.len());
        for (part, imported) in recipe.parts.iter().zip(&imported.parts) {
            self.same(&part.name, &imported.name);
            self.same(&part.kind, &imported.kind);
        }
        self.same(&recipe.start, &imported.start);
        let entered = |end: &&String| recipe.transitions.iter().any(|t| t.to == **end);
        let ends: Vec<String> = recipe.ends.iter().filter(entered).cloned().collect();
        self.same_lists(&ends, &imported.ends);
        self.same_lists(&recipe.leftover, &imported.leftover);
        assert_eq!(recipe.transitions.len(), imported.transitions.len());
        for (transition, imported) in recipe.transitions.iter().zip(&imported.transitions) {
            self.recipe_transition(transition, imported);
        }
    }

    fn recipe_transition(&mut self, transition: &RecipeTransition, imported: &RecipeTransition) {
        self.same(&transition.from, &imported.from);
        self.same(&transition.to, &imported.to);
        match (&transition.guard, &imported.guard) {
            (Guard::Always, Guard::Always) | (Guard::Otherwise, Guard::Otherwise) => {}
            (
                Guard::Test { name, inputs, at },
                Guard::Test {
                    name: word,
                    inputs: parts,
                    at: resources,
                },
            ) => {
                self.same(name, word);
                self.same_lists(inputs, parts);
                self.same_lists(at, resources);
            }
            other => panic!("{other:?}"),
        }
        let sizes = |t: &RecipeTransition| -> Vec<usize> {
            t.steps.iter().map(|s| s.operations.len()).collect()
        };
        assert_eq!(sizes(transition), sizes(imported));
        let calls = |t: &RecipeTransition| -> Vec<OperationCall> {
            let steps = t.steps.iter().flat_map(|s| &s.operations);
            steps.cloned().collect()
        };
        for (call, imported) in calls(transition).iter().zip(&calls(imported)) {
            self.same(&call.name, &imported.name);
            self.same_lists(&call.inputs, &imported.inputs);
            self.same_lists(&call.outputs, &imported.outputs);
        }
    }
}

/// Writes a layout and a recipe, imports them, and loads the text.
fn imported(layout: &Layout, recipe: &Recipe, as_graph: bool) -> (String, Library) {
    let equipment = write::equipment(layout).expect("it is sound");
    let recipe = if as_graph {
        write::workflow(recipe)
    } else {
        write::definition(recipe)
    };
    let recipe = recipe.expect("it is sound");
    let files = [("cell.xml", equipment), ("order.xml", recipe)];
    let files = files.map(|(name, text)| (name.to_owned(), text.into_bytes()));
    let imported = convert(&files);
    let text = imported
        .text
        .unwrap_or_else(|| panic!("{:?}", imported.findings));
    assert!(imported.findings.is_empty(), "{:?}", imported.findings);
    let loader = |path: &str, _: &str| Err(format!("{path} is not imported"));
    let file = ("order.lw".to_owned(), text.clone());
    let (library, findings) = contract::load(&[file], &loader);
    assert!(!has_errors(&findings), "{findings:?}\n{text}");
    assert_eq!(
        (library.layouts.len(), library.recipes.len()),
        (1, 1),
        "{text}"
    );
    assert_eq!(library.realizations.len(), 1, "{text}");
    (text, library)
}

/// What a short search finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    /// The recipe can be made, in this number of steps.
    Realizable(u32),
    Unrealizable,
    Undecided,
}

fn verdict(layout: &Layout, recipe: &Recipe) -> Verdict {
    let limits = SearchLimits {
        nodes: 2_000,
        vectors: 20_000,
    };
    match realize(layout, recipe, limits).expect("there are no problems") {
        Outcome::Realizable(controller) => Verdict::Realizable(controller.worst_case),
        Outcome::Unrealizable(_) => Verdict::Unrealizable,
        Outcome::GaveUp(_) => Verdict::Undecided,
    }
}

fn is_sound(problems: &[Problem]) -> bool {
    problems.iter().all(Problem::is_warning)
}

/// Whether a recipe has nothing that is left out: it does not begin at an end, and it can end.
fn ends(recipe: &Recipe) -> bool {
    let entered = |end: &String| recipe.transitions.iter().any(|t| t.to == *end);
    !recipe.ends.contains(&recipe.start) && recipe.ends.iter().any(entered)
}

#[test]
fn random_cells_are_imported_as_they_are() {
    let (mut count, mut realizable) = (0, 0);
    for seed in 0..300 {
        let (mut layout, recipe) = random::cell(seed);
        if !is_sound(&layout.problems()) || !is_sound(&recipe.problems()) || !ends(&recipe) {
            continue;
        }
        let values = [0.0, 12.0, 0.1, 1e-3, 123_456.789, 1e6];
        let mut random = random::Random(seed ^ 0x5eed);
        for transition in layout.resources.iter_mut().flat_map(|r| &mut r.transitions) {
            transition.seconds = values.get(random.below(2 * values.len())).copied();
            transition.watts = values.get(random.below(2 * values.len())).copied();
        }
        let (text, library) = imported(&layout, &recipe, seed % 2 == 0);
        let (found, made) = (&library.layouts[0].model, &library.recipes[0].model);
        let mut words = Words::default();
        words.layout(&layout, found);
        words.recipe(&recipe, made);
        assert!(
            words.words.iter().all(|((_, name), word)| name == word),
            "{text}"
        );
        let verdict = verdict(&layout, &recipe);
        assert_eq!(self::verdict(found, made), verdict, "{text}");
        count += 1;
        realizable += usize::from(matches!(verdict, Verdict::Realizable(_)));
    }
    assert!(count >= 200 && realizable >= 50, "{count} {realizable}");
}

/// Each keyword of the language as every kind of name, and names that no language allows.
#[test]
fn names_become_words() {
    let grammar = include_str!("../../../crates/syntax/src/lw.pest");
    let mut odd: Vec<String> = grammar
        .split('"')
        .skip(1)
        .step_by(2)
        .filter(|word| word.len() > 1 && word.chars().all(|c| c.is_ascii_alphabetic()))
        .map(str::to_owned)
        .collect();
    odd.sort_unstable();
    odd.dedup();
    assert!(odd.len() > 100, "{odd:?}");
    let more = [
        "",
        " ",
        "a b",
        "a_b",
        "a_b_",
        "a  b",
        "Größe 3",
        "3",
        "3@r6",
        "belt#2",
        "→",
        "_",
        "__",
        "a\nb",
        "// x",
        "*/",
        "µ",
        "x_3",
        "x_",
        "'",
        "\u{0}",
    ];
    odd.extend(more.map(str::to_owned));
    let (mut layout, mut recipe) = random::cell(sound_seed());
    layout.resources[0].holds = vec!["a".to_owned()];
    for shift in 0..odd.len() {
        let name = |n: usize| odd[(shift + n) % odd.len()].clone();
        let names: RefCell<BTreeMap<String, String>> = RefCell::default();
        let (mut layout, mut recipe) = (layout.clone(), recipe.clone());
        rename(&mut layout, &mut recipe, &|old| {
            let mut names = names.borrow_mut();
            let next = name(names.len());
            names.entry(old.to_owned()).or_insert(next).clone()
        });
        let (text, library) = imported(&layout, &recipe, shift % 2 == 0);
        let mut words = Words::default();
        words.layout(&layout, &library.layouts[0].model);
        words.recipe(&recipe, &library.recipes[0].model);
        let differing = words.words.iter().filter(|((_, name), word)| name != *word);
        for ((_, name), word) in differing {
            let name = linewright::b2mml::encode(name);
            let note = format!("\n// renamed: {name} is {word} here\n");
            assert!(text.contains(&note), "{note}{text}");
        }
    }
    recipe.name = "Random".to_owned();
    layout.name = "Random".to_owned();
    let (text, _) = imported(&layout, &recipe, false);
    assert!(
        text.contains("// renamed: Random is Random_ here\n"),
        "{text}"
    );
    assert!(text.ends_with("realize Random_ on Random\n"), "{text}");
}

/// The seed of a cell without problems.
fn sound_seed() -> u64 {
    let is_right = |seed: &u64| {
        let (layout, recipe) = random::cell(*seed);
        let has_tests = recipe.transitions.iter().any(|t| t.guard != Guard::Always);
        is_sound(&layout.problems()) && is_sound(&recipe.problems()) && ends(&recipe) && has_tests
    };
    (0..1_000).find(is_right).expect("there are many")
}
