//! Names that are hard to write.

use crate::support::{odd, pad, read_again};
use linewright_b2mml::{Document, decode, write};
use linewright_recipe::model::{Action, Layout, Resource};
use std::collections::HashSet;

/// All kinds of odd names in one layout, and names that differ in case only.
fn names() -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for kind in 0..12 {
        names.extend(["a", "b", "B"].map(|name| odd(name, kind)));
    }
    names.extend(["Robot", "robot", "ROBOT"].map(str::to_owned));
    names
}

/// Returns the texts of the elements with a name.
fn texts<'t>(document: &'t str, element: &str) -> Vec<&'t str> {
    let (open, close) = (format!("<{element}>"), format!("</{element}>"));
    let pieces = document.split(open.as_str()).skip(1);
    pieces
        .map(|p| p.split(close.as_str()).next().expect("it ends"))
        .collect()
}

#[test]
fn identifiers_are_legal_and_unique() {
    let names = names();
    assert_eq!(names.iter().collect::<HashSet<_>>().len(), names.len());
    let resources = names.iter().map(|name| {
        let mut resource = Resource::new(name, &[name.as_str()], &[]);
        let action = Action::Operation(name.clone());
        resource = resource.with(name, action, name);
        resource.holds = vec![name.clone()];
        resource
    });
    let layout = Layout {
        name: String::new(),
        resources: resources.collect(),
    };
    let text = write::equipment(&layout).expect("it is sound");
    let classes = texts(&text, "EquipmentClassID");
    assert_eq!(classes.len(), names.len());
    for class in &classes {
        assert!(!class.is_empty() && class.trim() == *class, "{class:?}");
        assert!(!class.contains(['\t', '\n', '\r', '\u{200b}']) && !class.contains("  "));
    }
    assert_eq!(classes.iter().collect::<HashSet<_>>().len(), names.len());
    assert_eq!(read_again(&text), Document::Layouts(vec![layout]));
}

/// Within a document of the demonstrator, no two segments, nodes, connections or requests have the
/// same identifier.
#[test]
fn identifiers_of_segments_are_unique() {
    let (layout, recipe) = (pad::layout(6), pad::hinge(true));
    let documents = crate::support::documents(&layout, &recipe);
    let elements = [
        ["EquipmentChild", "EquipmentClass"],
        ["OperationsSegment", "OperationsSegmentChild"],
        [
            "WorkflowSpecificationNode",
            "WorkflowSpecificationConnection",
        ],
        ["OperationsRequest", "EquipmentRequirement"],
        ["OperationsResponse", "SegmentResponse"],
    ];
    for (document, elements) in documents.iter().zip(elements) {
        let element = elements[0];
        let open = format!("<{element}>");
        let bodies = document.split(open.as_str()).skip(1);
        let ids: Vec<&str> = bodies.map(|b| texts(b, "ID")[0]).collect();
        assert!(ids.len() > 5, "{element}: {ids:?}");
        assert_eq!(
            ids.iter().collect::<HashSet<_>>().len(),
            ids.len(),
            "{ids:?}"
        );
        assert!(
            document.contains(&format!("<{}>", elements[1])),
            "{elements:?}"
        );
    }
}

#[test]
fn identifiers_of_other_programs_are_decoded() {
    assert_eq!(decode("Press_x0020__x0020_1"), "Press  1");
    assert_eq!(decode("Press_1"), "Press_1");
}
