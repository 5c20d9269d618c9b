//! Recipes from `WorkflowSpecification`: its nodes, connections and properties.
//!
//! A node is an operation if its type is `Operation` or it names a work master or directive, and
//! otherwise a state.

use super::definition::guard;
use super::graph::{Flow, Graph, Node};
use super::problems::{self, Places};
use super::source::Source;
use crate::finding::{Rule, quoted};
use crate::name::decode;
use crate::terms::{STATE_PREFIX, node, recipe as keys};
use crate::xml::Element;
use linewright_recipe::model::{Guard, OperationCall, Part, Recipe};
use rustc_hash::FxHashMap;

/// Reads a recipe from its element.
pub(super) fn workflow(source: &mut Source<'_, '_>, element: Element) -> Recipe {
    let name = source.id(element);
    let mut numbers: FxHashMap<String, usize> = FxHashMap::default();
    let mut graph = Graph::default();
    for found in source.children(element, "WorkflowSpecificationNode") {
        let id = source.raw_id(found);
        let read = read_node(source, found, &id);
        if numbers.insert(id.clone(), graph.nodes.len()).is_some() {
            let message = format!("two nodes have the identifier {}", quoted(&id));
            source.add(found, Rule::Reference, message);
        }
        graph.nodes.push(read);
    }
    for connection in source.children(element, "WorkflowSpecificationConnection") {
        read_connection(source, connection, &numbers, &mut graph);
    }
    let properties = source.properties(element, "WorkflowSpecificationProperty");
    let parts = source
        .property(&properties, keys::PARTS)
        .map(|p| p.values.clone());
    let parts = match parts {
        Some(values) => (values.iter())
            .map(|value| match decode(&value.key) {
                kind if value.key.is_empty() => (value.text.clone(), kind),
                kind => (kind, value.text.clone()),
            })
            .map(|(kind, name)| Part::new(&name, &kind))
            .collect(),
        None => graph.mentioned_parts(),
    };
    let start = source
        .single(&properties, keys::START)
        .map(|s| s.text.clone());
    let ends = source
        .property(&properties, keys::ENDS)
        .map(|p| p.values.clone());
    let leftover = source.list(&properties, keys::LEFTOVER);
    let mut places = Places {
        whole: element,
        ..Places::default()
    };
    let mut recipe = Recipe {
        name,
        parts,
        leftover,
        ..Recipe::default()
    };
    if graph.transitions(source, &mut recipe, &mut places) {
        recipe.start = start
            .or_else(|| graph.only_start(&recipe))
            .unwrap_or_default();
        recipe.ends = match ends {
            Some(ends) => ends.into_iter().map(|e| e.text).collect(),
            None => graph.ends(&recipe),
        };
        if recipe.start.is_empty() && !recipe.states.iter().any(String::is_empty) {
            let message = "it is not clear where the workflow starts";
            source.add(element, Rule::Meaning, message);
        } else {
            problems::of_recipe(source, &recipe, &places);
        }
    }
    recipe
}

fn read_node(source: &mut Source<'_, '_>, element: Element, id: &str) -> Node {
    let kind = source.child(element, "WorkflowSpecificationNodeTypeID");
    let kind = kind.map(|k| source.text(k)).unwrap_or_default();
    if let Some(inner) = source.child(element, "WorkflowSpecification") {
        let message = "a workflow within a node is not read";
        source.add(inner, Rule::Meaning, message);
    }
    let mut masters = source.names(element, "WorkMasterID");
    masters.extend(source.names(element, "WorkDirectiveID"));
    if masters.is_empty() && kind != node::OPERATION {
        let name = decode(id.strip_prefix(STATE_PREFIX).unwrap_or(id));
        return Node::state(element, name, kind == node::START);
    }
    if masters.len() > 1 {
        let message = "a node has one work master or directive";
        source.add(element, Rule::Meaning, message);
    }
    let properties = source.properties(element, "WorkflowSpecificationNodeProperty");
    let name = masters.into_iter().next().unwrap_or_else(|| decode(id));
    let call = OperationCall {
        name,
        inputs: source.list(&properties, keys::CONSUMED),
        outputs: source.list(&properties, keys::PRODUCED),
    };
    Node::operation(element, decode(id), call)
}

fn read_connection(
    source: &mut Source<'_, '_>,
    element: Element,
    numbers: &FxHashMap<String, usize>,
    graph: &mut Graph,
) {
    source.id(element);
    let mut ends = |name| {
        let mut found = Vec::new();
        let all = source.children(element, name);
        if all.is_empty() {
            let message = format!("a connection has at least one {}", quoted(name));
            source.add(element, Rule::Meaning, message);
            graph.is_broken = true;
        }
        for end in all {
            let id = source.text(end);
            if let Some(number) = numbers.get(&id) {
                found.push(*number);
            } else {
                let message = format!("there is no node {}", quoted(&id));
                source.add(end, Rule::Reference, message);
                graph.is_broken = true;
            }
        }
        found
    };
    let (from, to) = (ends("FromWSNodeID"), ends("ToWSNodeID"));
    if let Some(factor) = source.child(element, "DependencyFactor") {
        source.add(
            factor,
            Rule::Meaning,
            "a dependency with a factor is not read",
        );
    }
    let properties = source.properties(element, "WorkflowSpecificationConnectionProperty");
    let kind = source.child(element, "WorkflowSpecificationConnectionTypeID");
    let kind = kind.map(|k| source.name(k)).unwrap_or_default();
    let dependency = source.code(element, "Dependency").unwrap_or_default();
    let mut guard = guard(source, element, &properties);
    match dependency {
        (text, _) if text == "AfterEnd" => {}
        (text, _) if text == "AtStart" => {
            let nodes = from.into_iter().chain(to).collect();
            graph.parallel.push((element, nodes));
            return;
        }
        (_, Some(other)) => {
            if guard == Guard::Always {
                guard = written_guard(&kind, &other);
            }
        }
        (text, None) => {
            let message = format!("the dependency {} is not read", quoted(&text));
            source.add(element, Rule::Meaning, message);
        }
    }
    graph.flows.push(Flow {
        element,
        from,
        to,
        guard,
    });
}

/// Returns the guard that a connection of another program has: the name behind `guard:` of its
/// type, or else its other value.
fn written_guard(kind: &str, other: &str) -> Guard {
    let name = kind.strip_prefix("guard:").unwrap_or(other).trim();
    if name.eq_ignore_ascii_case("otherwise") || name.eq_ignore_ascii_case("else") {
        Guard::Otherwise
    } else {
        Guard::test(&decode(name), &[])
    }
}
