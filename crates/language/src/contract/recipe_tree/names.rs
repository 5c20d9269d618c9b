//! Names of models as words of the language.

use linewright_core::rename::renamed;
use linewright_recipe::model::{Action, Guard, Layout, Recipe};
use linewright_syntax::{is_transfer_label, is_word};
use rustc_hash::{FxHashMap, FxHashSet};

/// Words that are not reserved, but would be read as something else: the transfer `out`.
const MISLEADING: [&str; 1] = ["out"];

/// The word for each name. The same name has the same word everywhere, and different names have
/// different words. Labels have words of their own, since these may begin with a digit.
pub(super) struct Words {
    /// For each layout, then for each recipe.
    declared: Vec<String>,
    plain: FxHashMap<String, String>,
    labels: FxHashMap<String, String>,
    /// Names that are not their own words, with these, in the order of their first mention.
    pub renamed: Vec<(String, String)>,
}

impl Words {
    /// Chooses the words of all names of the models.
    pub fn of(layouts: &[Layout], recipes: &[Recipe]) -> Self {
        let mut names = Names::default();
        for layout in layouts {
            names.add_layout(layout);
        }
        for recipe in recipes {
            names.add_recipe(recipe);
        }
        let declared = layouts.iter().map(|l| l.name.as_str());
        let declared: Vec<&str> = declared
            .chain(recipes.iter().map(|r| r.name.as_str()))
            .collect();
        let words = renamed(declared.iter().copied(), "x_", is_name);
        let mut changed = differing(&declared, &words);
        let mut seen: FxHashSet<(String, String)> = changed.iter().cloned().collect();
        let mut map = |list: &[&str], words: Vec<String>| -> FxHashMap<String, String> {
            let differing = differing(list, &words).into_iter();
            changed.extend(differing.filter(|pair| seen.insert(pair.clone())));
            list.iter().map(|n| (*n).to_owned()).zip(words).collect()
        };
        let plain = renamed(names.plain.list.iter().copied(), "x_", is_name);
        let plain = map(&names.plain.list, plain);
        let labels = renamed(names.labels.list.iter().copied(), "", is_transfer_label);
        let labels = map(&names.labels.list, labels);
        Self {
            declared: words,
            plain,
            labels,
            renamed: changed,
        }
    }

    /// Returns the word of a layout, by its number.
    pub fn layout(&self, number: usize) -> &str {
        &self.declared[number]
    }

    /// Returns the word of a recipe, by its number among all recipes, behind `layouts` layouts.
    pub fn recipe(&self, layouts: usize, number: usize) -> &str {
        &self.declared[layouts + number]
    }

    /// Returns the word of a name that the models mention.
    pub fn plain(&self, name: &str) -> String {
        self.plain.get(name).cloned().unwrap_or_default()
    }

    /// Returns the word of a label.
    pub fn label(&self, name: &str) -> String {
        self.labels.get(name).cloned().unwrap_or_default()
    }
}

fn is_name(word: &str) -> bool {
    is_word(word) && !MISLEADING.contains(&word)
}

fn differing(names: &[&str], words: &[String]) -> Vec<(String, String)> {
    let pairs = names.iter().zip(words).filter(|(name, word)| *name != word);
    pairs
        .map(|(name, word)| ((*name).to_owned(), word.clone()))
        .collect()
}

/// Names in the order of their first mention.
#[derive(Default)]
struct Distinct<'a> {
    list: Vec<&'a str>,
    seen: FxHashSet<&'a str>,
}

impl<'a> Distinct<'a> {
    fn add(&mut self, name: &'a str) {
        if self.seen.insert(name) {
            self.list.push(name);
        }
    }

    fn extend(&mut self, names: &'a [String]) {
        for name in names {
            self.add(name);
        }
    }
}

#[derive(Default)]
struct Names<'a> {
    plain: Distinct<'a>,
    labels: Distinct<'a>,
}

impl<'a> Names<'a> {
    fn add_layout(&mut self, layout: &'a Layout) {
        for resource in &layout.resources {
            self.plain.add(&resource.name);
            self.plain.add(&resource.initial);
            for state in &resource.states {
                self.plain.add(&state.name);
            }
            for transition in &resource.transitions {
                match &transition.action {
                    Action::Operation(name) | Action::Internal(name) => self.plain.add(name),
                    Action::In(label) | Action::Out(label) => self.labels.add(label),
                }
            }
            self.plain.extend(&resource.holds);
        }
    }

    fn add_recipe(&mut self, recipe: &'a Recipe) {
        for part in &recipe.parts {
            self.plain.add(&part.name);
            self.plain.add(&part.kind);
        }
        self.plain.extend(&recipe.states);
        self.plain.extend(&recipe.leftover);
        for transition in &recipe.transitions {
            if let Guard::Test { name, inputs, at } = &transition.guard {
                self.plain.add(name);
                self.plain.extend(inputs);
                self.plain.extend(at);
            }
            for call in transition.steps.iter().flat_map(|s| &s.operations) {
                self.plain.add(&call.name);
                self.plain.extend(&call.inputs);
                self.plain.extend(&call.outputs);
            }
        }
    }
}
