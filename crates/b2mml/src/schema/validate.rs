//! Validates a tree against the schema.

use super::table::{ElementType, Particle, Schema, TextType, Type, TypeId};
use super::value::replaced;
use crate::finding::{Collector, Rule, quoted};
use crate::xml::{Element, Origin, Tree, is_blank};

/// Adds a finding for everything in the tree that the schema does not allow, at its place. Returns
/// false if the root is not one of the schema.
///
/// Takes time proportional to the tree. The recursion is as deep as the tree, which is bounded.
pub(crate) fn validate(tree: &Tree<'_>, findings: &mut Collector) -> bool {
    let schema = Schema::get();
    let Some(of) = schema.root(tree.name(0)) else {
        return false;
    };
    let mut validator = Validator {
        schema,
        tree,
        findings,
    };
    validator.element(0, of, false);
    true
}

struct Validator<'a, 't> {
    schema: &'static Schema,
    tree: &'a Tree<'t>,
    findings: &'a mut Collector,
}

impl Validator<'_, '_> {
    fn add(&mut self, element: Element, rule: Rule, message: String) {
        self.findings.add(self.tree.at(element), rule, message);
    }

    fn element(&mut self, element: Element, of: TypeId, is_nillable: bool) {
        let text = match self.schema.of(of) {
            Type::Sequence(_) => None,
            Type::Text(text) => Some(text),
        };
        let is_nil = self.attributes(element, text, is_nillable);
        let tree = self.tree;
        if is_nil {
            if tree.children(element).next().is_some() || !tree.text(element).is_empty() {
                let message = format!("{} is nil, so it must be empty", self.shown(element));
                self.add(element, Rule::Value, message);
            }
            return;
        }
        match self.schema.of(of) {
            Type::Sequence(particles) => {
                if let Some(at) = tree.text_at(element) {
                    let message = format!("{} cannot have text", self.shown(element));
                    self.findings.add(at, Rule::Structure, message);
                }
                self.sequence(element, particles);
            }
            Type::Text(of) => {
                if let Some(child) = tree.children(element).next() {
                    let message = format!("{} cannot have elements", self.shown(element));
                    self.add(child, Rule::Structure, message);
                } else if !of.accepts(tree.text(element)) {
                    let message = format!(
                        "{} is not {}, but {}",
                        self.shown(element),
                        expected(of),
                        quoted(&replaced(tree.text(element)))
                    );
                    self.add(element, Rule::Value, message);
                }
            }
        }
    }

    fn shown(&self, element: Element) -> String {
        quoted(self.tree.name(element))
    }

    /// Checks the attributes of an element. Returns whether it is nil.
    fn attributes(&mut self, element: Element, of: Option<&TextType>, is_nillable: bool) -> bool {
        let mut is_nil = false;
        for attribute in self.tree.attributes(element) {
            let (at, name, value) = (attribute.at, attribute.name, attribute.value.as_str());
            let declared = of.and_then(|of| of.attributes.iter().find(|a| a.0 == name));
            let problem = match (attribute.origin, declared) {
                (Origin::Own, Some((_, kind))) if kind.accepts(value) => continue,
                (Origin::Own, Some((_, kind))) => {
                    let kind = kind.description();
                    format!("{} is not {kind}, but {}", quoted(name), quoted(value))
                }
                (Origin::Instance, _) => match name {
                    "nil" if is_nillable => match value.trim() {
                        "true" | "1" => {
                            is_nil = true;
                            continue;
                        }
                        "false" | "0" => continue,
                        _ => format!("`nil` is not `true` or `false`, but {}", quoted(value)),
                    },
                    "schemaLocation" if is_location(value, 2) => continue,
                    "noNamespaceSchemaLocation" if is_location(value, 1) => continue,
                    _ => format!("the attribute `xsi:{name}` is not allowed here"),
                },
                _ => {
                    let (name, element) = (quoted(name), self.shown(element));
                    format!("{element} has no attribute {name}")
                }
            };
            self.findings.add(at, Rule::Attribute, problem);
        }
        is_nil
    }

    /// Checks the children of an element against its sequence.
    fn sequence(&mut self, parent: Element, particles: &[Particle]) {
        let tree = self.tree;
        let (mut place, mut count) = (0, 0);
        for child in tree.children(parent) {
            let name = tree.name(child);
            let found = particles.iter().enumerate().find_map(|(at, particle)| {
                let element = particle.elements.iter().find(|e| e.name == name);
                element.map(|e| (at, e))
            });
            let Some((at, of)) = found.filter(|_| tree.is_known(child)) else {
                let message = format!(
                    "{} cannot contain {}; {}",
                    self.shown(parent),
                    quoted(name),
                    following(particles, place, count)
                );
                self.add(child, Rule::Structure, message);
                continue;
            };
            if at < place {
                let before = &particles[place].elements[0].name;
                let message = format!("{} must stand before `{before}`", quoted(name));
                self.add(child, Rule::Structure, message);
            } else {
                if at > place {
                    self.missing(child, parent, &particles[place..at], count);
                    (place, count) = (at, 0);
                }
                if count > 0 && !particles[at].repeats {
                    let message = format!("{} cannot occur again here", quoted(name));
                    self.add(child, Rule::Structure, message);
                }
                count += 1;
            }
            self.element(child, of.of, of.is_nillable);
        }
        self.missing(
            parent,
            parent,
            particles.get(place..).unwrap_or_default(),
            count,
        );
    }

    /// Reports the required ones of places that were passed. The first has `count` elements.
    fn missing(&mut self, at: Element, parent: Element, passed: &[Particle], count: usize) {
        for (number, particle) in passed.iter().enumerate() {
            if particle.is_required && (number > 0 || count == 0) {
                let names: Vec<&str> = particle.elements.iter().map(|e| e.name).collect();
                let names = names.join("` or `");
                let message = format!("{} needs `{names}` before this", self.shown(parent));
                let message = if at == parent {
                    format!("{} needs `{names}`", self.shown(parent))
                } else {
                    message
                };
                self.add(at, Rule::Structure, message);
            }
        }
    }
}

/// Says which elements can come next.
fn following(particles: &[Particle], place: usize, count: usize) -> String {
    let mut names: Vec<&ElementType> = Vec::new();
    for (number, particle) in particles.iter().enumerate().skip(place) {
        let is_full = number == place && count > 0 && !particle.repeats;
        if !is_full {
            names.extend(&particle.elements);
        }
        let is_met = number == place && count > 0;
        if (particle.is_required && !is_met) || names.len() >= 5 {
            break;
        }
    }
    let names: Vec<String> = names
        .iter()
        .take(5)
        .map(|e| format!("`{}`", e.name))
        .collect();
    if names.is_empty() {
        "nothing can follow here".to_owned()
    } else {
        format!("here it can contain {}", names.join(", "))
    }
}

/// Says what a text has to be.
fn expected(of: &TextType) -> String {
    match of.values.len() {
        0 => of.base.description().to_owned(),
        1..=12 => format!("one of `{}`", of.values.join("`, `")),
        _ => format!("one of `{}`, ...", of.values[..12].join("`, `")),
    }
}

/// Returns whether a text is a list of URIs whose number is a multiple of `by`.
fn is_location(text: &str, by: usize) -> bool {
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let is_uri = |word: &&str| super::table::Builtin::AnyUri.accepts(word);
    let count = words.len();
    count > 0
        && count.is_multiple_of(by)
        && (by > 1 || count == 1)
        && words.iter().all(is_uri)
        && !is_blank(text)
}
