//! Recipes without choices.

use linewright_recipe::model::{Guard, Part, Recipe, RecipeTransition, Step};
use rustc_hash::FxHashMap;

/// Returns a recipe with one transition. Its parts are those of the steps, in the order of their
/// mention; a part of unknown type has its name as type. What is made more often than it is needed
/// may be left over.
pub(crate) fn linear_recipe(
    name: &str,
    kinds: &FxHashMap<&str, &Part>,
    steps: Vec<Step>,
) -> Recipe {
    let mut parts: Vec<Part> = Vec::new();
    let mut numbers: FxHashMap<&str, usize> = FxHashMap::default();
    let mut balance: Vec<i64> = Vec::new();
    for call in steps.iter().flat_map(|s| &s.operations) {
        let inputs = call.inputs.iter().map(|p| (p, -1));
        for (part, change) in inputs.chain(call.outputs.iter().map(|p| (p, 1))) {
            let number = *numbers.entry(part).or_insert_with(|| {
                let known = kinds.get(part.as_str()).map(|p| (*p).clone());
                parts.push(known.unwrap_or_else(|| Part::new(part, part)));
                balance.push(0);
                parts.len() - 1
            });
            balance[number] += change;
        }
    }
    let remains = parts.iter().zip(&balance).filter(|(_, b)| **b > 0);
    let leftover = remains.map(|(p, _)| p.name.clone()).collect();
    Recipe {
        name: name.to_owned(),
        parts,
        states: vec!["start".to_owned(), "end".to_owned()],
        start: "start".to_owned(),
        ends: vec!["end".to_owned()],
        leftover,
        transitions: vec![RecipeTransition::new("start", "end", Guard::Always, steps)],
    }
}
