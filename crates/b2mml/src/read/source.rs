//! Access to a valid tree, which keeps account of what was read.

use crate::finding::{Collector, Rule, quoted};
use crate::name::decode;
use crate::schema::replaced;
use crate::xml::{Element, Tree};
use std::str::FromStr;

/// Elements that describe or administrate others: they are left out without a note.
const ADMINISTRATIVE: [&str; 7] = [
    "Description",
    "PublishedDate",
    "Version",
    "EffectiveStartDate",
    "EffectiveEndDate",
    "DefinitionType",
    "DataType",
];

/// Maximum number of pieces of a material. Parts of a recipe are individuals, so more are surely
/// something else.
const MAX_PIECES: usize = 10_000;
/// Maximum number of pieces of all materials whose quantity is given.
const MAX_ALL_PIECES: usize = 1_000_000;

/// A valid tree, the findings about its meaning, and which elements were read.
pub(super) struct Source<'a, 't> {
    tree: &'a Tree<'t>,
    used: Vec<bool>,
    findings: Collector,
    /// Number of pieces of all materials.
    pieces: usize,
}

/// A property or parameter.
#[derive(Clone)]
pub(super) struct Property {
    /// The element.
    pub element: Element,
    /// Its identifier.
    pub id: String,
    /// Its values.
    pub values: Vec<PropertyValue>,
}

/// A value of a property.
#[derive(Clone)]
pub(super) struct PropertyValue {
    /// The element.
    pub element: Element,
    /// Text, as a name.
    pub text: String,
    /// Key; empty if there is none.
    pub key: String,
    /// Unit; empty if there is none.
    pub unit: String,
}

impl<'a, 't> Source<'a, 't> {
    pub(super) fn new(tree: &'a Tree<'t>) -> Self {
        let mut used = vec![false; tree.len()];
        used[0] = true;
        Self {
            tree,
            used,
            findings: Collector::default(),
            pieces: 0,
        }
    }

    /// Returns the findings, and a note for each element that was not read but whose parent was.
    pub(super) fn finish(self) -> (Collector, Collector) {
        let mut notes = Collector::default();
        for parent in (0..self.tree.len()).filter(|e| self.used[*e]) {
            for child in self.tree.children(parent) {
                let name = self.tree.name(child);
                if !self.used[child] && !ADMINISTRATIVE.contains(&name) {
                    let message = format!("{} is left out", quoted(name));
                    notes.add(self.tree.at(child), Rule::LeftOut, message);
                }
            }
        }
        (self.findings, notes)
    }

    /// Adds a finding at an element.
    pub(super) fn add(&mut self, element: Element, rule: Rule, message: impl Into<String>) {
        self.findings.add(self.tree.at(element), rule, message);
    }

    /// Returns the children with a name.
    pub(super) fn children(&mut self, parent: Element, name: &str) -> Vec<Element> {
        let tree = self.tree;
        let all = tree.children(parent);
        let found: Vec<Element> = all.filter(|c| tree.name(*c) == name).collect();
        for child in &found {
            self.used[*child] = true;
        }
        found
    }

    /// Returns the first child with a name.
    pub(super) fn child(&mut self, parent: Element, name: &str) -> Option<Element> {
        let tree = self.tree;
        let found = tree.children(parent).find(|c| tree.name(*c) == name)?;
        self.used[found] = true;
        Some(found)
    }

    /// Returns whether an element has a child with a name, without reading it.
    pub(super) fn has(&self, parent: Element, name: &str) -> bool {
        self.tree
            .children(parent)
            .any(|c| self.tree.name(c) == name)
    }

    /// Returns the text of an element, without white space at its ends.
    pub(super) fn text(&self, element: Element) -> String {
        replaced(self.tree.text(element))
            .trim_matches(' ')
            .to_owned()
    }

    /// Returns the text of an element as a name.
    pub(super) fn name(&self, element: Element) -> String {
        decode(&self.text(element))
    }

    /// Returns the identifier of an element as a name.
    pub(super) fn id(&mut self, element: Element) -> String {
        let id = self.child(element, "ID");
        id.map(|id| self.name(id)).unwrap_or_default()
    }

    /// Returns the identifier of an element as it is written.
    pub(super) fn raw_id(&mut self, element: Element) -> String {
        let id = self.child(element, "ID");
        id.map(|id| self.text(id)).unwrap_or_default()
    }

    /// Returns the names that the children with a name have as texts.
    pub(super) fn names(&mut self, parent: Element, name: &str) -> Vec<String> {
        let children = self.children(parent, name);
        children.into_iter().map(|c| self.name(c)).collect()
    }

    /// Returns the text of a child with a list of values, and its other value if the text is
    /// `Other`.
    pub(super) fn code(&mut self, parent: Element, name: &str) -> Option<(String, Option<String>)> {
        let child = self.child(parent, name)?;
        let text = self.text(child);
        let mut attributes = self.tree.attributes(child).iter();
        let other = attributes.find(|a| a.name == "OtherValue");
        let other = other.filter(|_| text == "Other").map(|a| a.value.clone());
        Some((text, other))
    }

    /// Returns the properties of an element, which are called `name`, without reading them.
    pub(super) fn properties(&mut self, parent: Element, name: &str) -> Vec<Property> {
        let tree = self.tree;
        let elements: Vec<Element> = (tree.children(parent))
            .filter(|c| tree.name(*c) == name)
            .collect();
        let properties = elements.into_iter().map(|element| {
            let id = self.raw_id(element);
            let values = self.children(element, "Value");
            let values = values.into_iter().map(|value| self.value(value)).collect();
            Property {
                element,
                id,
                values,
            }
        });
        properties.collect()
    }

    fn value(&mut self, element: Element) -> PropertyValue {
        let mut text = |name| {
            let child = self.child(element, name);
            child.map(|c| self.text(c)).unwrap_or_default()
        };
        PropertyValue {
            text: decode(&text("ValueString")),
            key: text("Key"),
            unit: text("UnitOfMeasure"),
            element,
        }
    }

    /// Marks a property as read.
    pub(super) fn take(&mut self, property: &Property) {
        self.used[property.element] = true;
    }

    /// Marks an element and all that it contains as read.
    pub(super) fn take_all(&mut self, element: Element) {
        let mut open = vec![element];
        while let Some(next) = open.pop() {
            self.used[next] = true;
            open.extend(self.tree.children(next));
        }
    }

    /// Reads the property with an identifier. A second one is a finding.
    pub(super) fn property<'p>(
        &mut self,
        properties: &'p [Property],
        id: &str,
    ) -> Option<&'p Property> {
        let mut found = properties.iter().filter(|p| p.id == id);
        let first = found.next()?;
        self.take(first);
        for second in found {
            self.take(second);
            let message = format!("the property {} occurs twice", quoted(id));
            self.add(second.element, Rule::Reference, message);
        }
        Some(first)
    }

    /// Reads the names that a property lists. Without the property there are none.
    pub(super) fn list(&mut self, properties: &[Property], id: &str) -> Vec<String> {
        let found = self.property(properties, id);
        let values = found.into_iter().flat_map(|p| &p.values);
        values.map(|v| v.text.clone()).collect()
    }

    /// Reads the only value of a property.
    pub(super) fn single<'p>(
        &mut self,
        properties: &'p [Property],
        id: &str,
    ) -> Option<&'p PropertyValue> {
        let property = self.property(properties, id)?;
        if property.values.len() != 1 {
            let message = format!("the property {} needs one value", quoted(id));
            self.add(property.element, Rule::Meaning, message);
        }
        property.values.first()
    }

    /// Reads a number. Another text is a finding, which says what is expected.
    pub(super) fn number<T: FromStr>(&mut self, value: &PropertyValue, what: &str) -> Option<T> {
        let number = value.text.parse().ok();
        if number.is_none() {
            let message = format!("{what} is expected, not {}", quoted(&value.text));
            self.add(value.element, Rule::Meaning, message);
        }
        number
    }

    /// Reads a quantity with a unit: a finite number that is not negative.
    pub(super) fn quantity(&mut self, value: &PropertyValue, unit: &str) -> Option<f64> {
        if !value.unit.is_empty() && value.unit != unit {
            let message = format!("the unit `{unit}` is expected, not {}", quoted(&value.unit));
            self.add(value.element, Rule::Meaning, message);
        }
        let number: f64 = self.number(value, "a number")?;
        if number.is_finite() && number >= 0.0 {
            return Some(number);
        }
        let message = "a finite number of at least zero is expected";
        self.add(value.element, Rule::Meaning, message);
        None
    }

    /// Reads how many pieces a material counts; one if that is not said.
    pub(super) fn pieces(&mut self, material: Element) -> usize {
        let Some(quantity) = self.child(material, "Quantity") else {
            return 1;
        };
        self.child(quantity, "UnitOfMeasure");
        let Some(text) = self.child(quantity, "QuantityString") else {
            return 1;
        };
        let written = self.text(text);
        let whole = written.strip_suffix(".0").unwrap_or(&written);
        match whole.parse() {
            Ok(pieces) if (1..=MAX_PIECES).contains(&pieces) => {
                self.pieces += pieces;
                if self.pieces <= MAX_ALL_PIECES {
                    return pieces;
                }
                let message = format!("there are more than {MAX_ALL_PIECES} pieces in all");
                self.add(text, Rule::Size, message);
                1
            }
            _ => {
                let message = format!(
                    "a number of pieces from 1 to {MAX_PIECES} is expected, not {}",
                    quoted(&written)
                );
                self.add(text, Rule::Meaning, message);
                1
            }
        }
    }
}
