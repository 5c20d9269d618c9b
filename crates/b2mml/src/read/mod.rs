//! Reads documents: well-formedness, then the schema, then what it means.
//!
//! Each stage reports all that it finds, except that text which is not well-formed has one finding.
//! A document is read as a whole or not at all. What is valid but has no meaning here is left out,
//! with a note for each element.

mod activity;
mod definition;
mod equipment;
mod graph;
mod order;
mod performance;
mod problems;
mod schedule;
mod source;
mod workflow;

use crate::finding::{Collector, Findings, Rule, quoted};
use crate::performance::Performance;
use crate::schedule::Schedule;
use crate::schema::{NAMESPACE, validate};
use crate::xml::{Element, Tree, parse};
use linewright_recipe::model::{Layout, Recipe};
use rustc_hash::FxHashSet;
use source::Source;

/// Maximum length of a document in bytes.
pub const MAX_BYTES: usize = 256 << 20;

/// Beginning of the namespaces of earlier versions; the number of the version follows.
const EARLIER: &str = "http://www.mesa.org/xml/B2MML-V";

/// What a document says.
#[derive(Debug, Clone, PartialEq)]
pub enum Document {
    /// Layouts, from `EquipmentInformation`.
    Layouts(Vec<Layout>),
    /// Recipes, from `OperationsDefinition`, `OperationsDefinitionInformation`,
    /// `WorkflowSpecification` or `WorkflowSpecificationInformation`.
    Recipes(Vec<Recipe>),
    /// A schedule, from `OperationsSchedule`.
    Schedule(Schedule),
    /// A performance, from `OperationsPerformance`.
    Performance(Performance),
}

/// A document that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// What it says.
    pub document: Document,
    /// What was left out: findings with the rule [`Rule::LeftOut`].
    pub notes: Findings,
}

/// Reads a document of B2MML 7.
///
/// Takes time and memory proportional to the document, and little more than that to be refused.
///
/// # Errors
/// All findings, each with its place. There is at least one.
pub fn read(bytes: &[u8]) -> Result<Reading, Findings> {
    if bytes.len() > MAX_BYTES {
        let message = format!("the document has more than {MAX_BYTES} bytes");
        return Err(refusal(0, Rule::Size, message, ""));
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let (right, _) = bytes.split_at(error.valid_up_to());
            let right = std::str::from_utf8(right).unwrap_or_default();
            let message = "the document is not UTF-8 from here on".to_owned();
            return Err(refusal(right.len(), Rule::Encoding, message, right));
        }
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut findings = Collector::default();
    let Some(tree) = parse(text, NAMESPACE, &mut findings) else {
        return Err(findings.into_findings(text));
    };
    if let Some((rule, message)) = refused_root(&tree) {
        return Err(refusal(tree.at(0), rule, message, text));
    }
    validate(&tree, &mut findings);
    if !findings.is_empty() {
        return Err(findings.into_findings(text));
    }
    let mut source = Source::new(&tree);
    let document = match tree.name(0) {
        "EquipmentInformation" => Document::Layouts(equipment::layouts(&mut source)),
        "OperationsDefinition" => definitions(&mut source, &[0]),
        "OperationsDefinitionInformation" => {
            let elements = source.children(0, "OperationsDefinition");
            definitions(&mut source, &elements)
        }
        "WorkflowSpecification" => workflows(&mut source, &[0]),
        "WorkflowSpecificationInformation" => {
            let elements = source.children(0, "WorkflowSpecification");
            workflows(&mut source, &elements)
        }
        "OperationsSchedule" => Document::Schedule(schedule::schedule(&mut source)),
        _ => Document::Performance(performance::performance(&mut source)),
    };
    let (findings, notes) = source.finish();
    if findings.is_empty() {
        let notes = notes.into_findings(text);
        Ok(Reading { document, notes })
    } else {
        Err(findings.into_findings(text))
    }
}

fn definitions(source: &mut Source<'_, '_>, elements: &[Element]) -> Document {
    recipes(source, elements, "recipe", definition::definition)
}

fn workflows(source: &mut Source<'_, '_>, elements: &[Element]) -> Document {
    recipes(source, elements, "workflow", workflow::workflow)
}

/// Reads a recipe from each element. `noun` names one of the elements in findings.
fn recipes(
    source: &mut Source<'_, '_>,
    elements: &[Element],
    noun: &str,
    read: impl Fn(&mut Source<'_, '_>, Element) -> Recipe,
) -> Document {
    if elements.is_empty() {
        source.add(0, Rule::Meaning, format!("there is no {noun}"));
    }
    if elements != [0] {
        source.id(0);
    }
    let mut known = FxHashSet::default();
    let mut recipes = Vec::new();
    for element in elements {
        let recipe = read(source, *element);
        if !known.insert(recipe.name.clone()) {
            let message = format!("two {noun}s are called {}", quoted(&recipe.name));
            source.add(*element, Rule::Reference, message);
        }
        recipes.push(recipe);
    }
    Document::Recipes(recipes)
}

/// Returns findings with only one.
fn refusal(at: usize, rule: Rule, message: String, text: &str) -> Findings {
    let mut findings = Collector::default();
    findings.add(at, rule, message);
    findings.into_findings(text)
}

/// Returns why the root of a document is not read.
fn refused_root(tree: &Tree<'_>) -> Option<(Rule, String)> {
    if !tree.is_known(0) {
        let bound = tree.namespace();
        let version = bound.strip_prefix(EARLIER).map(|v| v.trim_matches('0'));
        let what = match version {
            Some(version) if !version.is_empty() => {
                let version = version.chars().take(4).collect::<String>();
                format!(
                    "this is a document of B2MML {}",
                    quoted(&version).replace('`', "")
                )
            }
            _ if bound.is_empty() => "the document has no namespace".to_owned(),
            _ => format!("the namespace is {}", quoted(bound)),
        };
        let message = format!("{what}; B2MML 7 is read, with the namespace `{NAMESPACE}`");
        return Some((Rule::Version, message));
    }
    let name = tree.name(0);
    if crate::schema::Schema::get().has_root(name) {
        return None;
    }
    let names = crate::schema::Schema::get().root_names().join("`, `");
    let message = format!("{} is not read; these are: `{names}`", quoted(name));
    Some((Rule::Root, message))
}
