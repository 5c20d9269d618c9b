//! Other names for layouts and recipes.

use linewright_recipe::model::{Action, Guard, Layout, OperationCall, Part, Recipe};

/// Replaces all names.
pub fn rename(layout: &mut Layout, recipe: &mut Recipe, new: &dyn Fn(&str) -> String) {
    let apply = |name: &mut String| *name = new(name);
    apply(&mut layout.name);
    for resource in &mut layout.resources {
        apply(&mut resource.name);
        apply(&mut resource.initial);
        resource.states.iter_mut().for_each(|s| apply(&mut s.name));
        resource.holds.iter_mut().for_each(apply);
        for transition in &mut resource.transitions {
            apply(&mut transition.from);
            apply(&mut transition.to);
            match &mut transition.action {
                Action::Operation(name)
                | Action::Internal(name)
                | Action::In(name)
                | Action::Out(name) => apply(name),
            }
        }
    }
    apply(&mut recipe.name);
    apply(&mut recipe.start);
    for Part { name, kind } in &mut recipe.parts {
        apply(name);
        apply(kind);
    }
    let lists = [&mut recipe.states, &mut recipe.ends, &mut recipe.leftover];
    lists.into_iter().flatten().for_each(apply);
    for transition in &mut recipe.transitions {
        apply(&mut transition.from);
        apply(&mut transition.to);
        if let Guard::Test { name, inputs, at } = &mut transition.guard {
            apply(name);
            inputs.iter_mut().chain(at).for_each(apply);
        }
        let steps = transition.steps.iter_mut();
        for OperationCall {
            name,
            inputs,
            outputs,
        } in steps.flat_map(|s| &mut s.operations)
        {
            apply(name);
            inputs.iter_mut().chain(outputs).for_each(apply);
        }
    }
}
