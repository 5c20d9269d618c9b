//! A recipe as `WorkflowSpecification`.
//!
//! States and operations are nodes. The connections from a state lead to the operations of the
//! first step of a transition, then from step to step, and to the next state. A guard is a
//! dependency `Other`. Operations of a step are joined by a dependency `AtStart`.

use super::definition::{guard, write_dependency};
use super::{Value, WriteError, name, names, property, shown, without_problems};
use crate::name::encode;
use crate::schedule::segment_id;
use crate::schema::NAMESPACE;
use crate::terms::{OPERATION_PREFIX, STATE_PREFIX, node, recipe as keys};
use crate::xml::XmlWriter;
use linewright_recipe::model::{Guard, OperationCall, Recipe, RecipeTransition};
use rustc_hash::{FxHashMap, FxHashSet};

const PROPERTY: &str = "WorkflowSpecificationProperty";
const NODE_PROPERTY: &str = "WorkflowSpecificationNodeProperty";
const CONNECTION_PROPERTY: &str = "WorkflowSpecificationConnectionProperty";

/// Returns a recipe as a document with the root `WorkflowSpecification`.
///
/// Takes time proportional to the recipe.
///
/// # Errors
/// [`WriteError::Problems`].
pub fn workflow(recipe: &Recipe) -> Result<String, WriteError> {
    without_problems(recipe.problems())?;
    Ok(XmlWriter::document(
        "WorkflowSpecification",
        NAMESPACE,
        |w| {
            w.text("ID", &encode(&recipe.name));
            write_nodes(w, recipe);
            for (number, transition) in recipe.transitions.iter().enumerate() {
                write_connections(w, number, transition);
            }
            let parts: Vec<(String, String)> = (recipe.parts.iter())
                .map(|p| (encode(&p.name), encode(&p.kind)))
                .collect();
            let parts: Vec<Value<'_>> = (parts.iter())
                .map(|(name, kind)| Value::text(name).under(kind))
                .collect();
            property(w, PROPERTY, keys::PARTS, &parts);
            name(w, PROPERTY, keys::START, &recipe.start);
            names(w, PROPERTY, keys::ENDS, &recipe.ends);
            names(w, PROPERTY, keys::LEFTOVER, &recipe.leftover);
        },
    ))
}

fn state_id(state: &str) -> String {
    format!("{STATE_PREFIX}{}", encode(state))
}

fn operation_id(transition: usize, step: usize, operation: usize) -> String {
    format!(
        "{OPERATION_PREFIX}{}",
        segment_id(transition, step, operation)
    )
}

fn write_nodes(w: &mut XmlWriter, recipe: &Recipe) {
    let ends: FxHashSet<&str> = recipe.ends.iter().map(String::as_str).collect();
    let mut leaving: FxHashMap<&str, usize> = FxHashMap::default();
    for transition in &recipe.transitions {
        *leaving.entry(&transition.from).or_default() += 1;
    }
    for state in &recipe.states {
        let kind = if *state == recipe.start {
            node::START
        } else if ends.contains(state.as_str()) {
            node::END
        } else if leaving.get(state.as_str()).is_some_and(|l| *l > 1) {
            node::CHOICE
        } else {
            node::STATE
        };
        w.element("WorkflowSpecificationNode", |w| {
            w.text("ID", &state_id(state));
            w.text("WorkflowSpecificationNodeTypeID", kind);
        });
    }
    for (number, transition) in recipe.transitions.iter().enumerate() {
        for (step, of) in transition.steps.iter().enumerate() {
            for (operation, call) in of.operations.iter().enumerate() {
                w.element("WorkflowSpecificationNode", |w| {
                    w.text("ID", &operation_id(number, step, operation));
                    write_operation(w, call);
                });
            }
        }
    }
}

fn write_operation(w: &mut XmlWriter, call: &OperationCall) {
    w.text("Description", &shown(call));
    w.text("WorkflowSpecificationNodeTypeID", node::OPERATION);
    w.text("WorkMasterID", &encode(&call.name));
    names(w, NODE_PROPERTY, keys::CONSUMED, &call.inputs);
    names(w, NODE_PROPERTY, keys::PRODUCED, &call.outputs);
}

fn write_connections(w: &mut XmlWriter, number: usize, transition: &RecipeTransition) {
    let mut from = vec![state_id(&transition.from)];
    let steps = transition.steps.iter().enumerate().map(|(step, of)| {
        let operations = 0..of.operations.len();
        operations.map(|o| operation_id(number, step, o)).collect()
    });
    let targets = steps.chain([vec![state_id(&transition.to)]]);
    for (place, to) in targets.enumerate() {
        let id = format!("T{}.{place}", number + 1);
        let condition = if place == 0 {
            &transition.guard
        } else {
            &Guard::Always
        };
        w.element("WorkflowSpecificationConnection", |w| {
            w.text("ID", &id);
            write_ends(w, &from, &to);
            write_dependency(w, condition);
            guard(w, CONNECTION_PROPERTY, condition);
        });
        if let [first, others @ ..] = to.as_slice()
            && !others.is_empty()
        {
            w.element("WorkflowSpecificationConnection", |w| {
                w.text("ID", &format!("{id}.parallel"));
                write_ends(w, std::slice::from_ref(first), others);
                w.text("Dependency", "AtStart");
            });
        }
        from = to;
    }
}

fn write_ends(w: &mut XmlWriter, from: &[String], to: &[String]) {
    for node in from {
        w.text("FromWSNodeID", node);
    }
    for node in to {
        w.text("ToWSNodeID", node);
    }
}
