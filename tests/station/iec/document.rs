//! PLCopen XML, read back by a small independent reader.

use std::fmt::Write as _;

/// An element with its attributes and content; text is all its text, joined.
#[derive(Debug, Default)]
pub struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub text: String,
}

/// Text with entities replaced.
fn plain(text: &str) -> String {
    let named = [
        ("lt", "<"),
        ("gt", ">"),
        ("quot", "\""),
        ("apos", "'"),
        ("amp", "&"),
    ];
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('&') {
        let (name, after) = after.split_once(';').expect("an entity ends");
        out.push_str(before);
        if let Some((_, meaning)) = named.iter().find(|(n, _)| *n == name) {
            out.push_str(meaning);
        } else {
            let number = name.strip_prefix('#').expect("a known entity");
            let number = match number.strip_prefix('x') {
                Some(digits) => u32::from_str_radix(digits, 16),
                None => number.parse(),
            };
            let number = number.expect("a number");
            out.push(char::from_u32(number).expect("a character"));
        }
        rest = after;
    }
    out + rest
}

/// The outermost element of a document.
pub fn read(document: &str) -> Element {
    let mut open = vec![Element::default()];
    let mut rest = document;
    while let Some((before, after)) = rest.split_once('<') {
        let (tag, after) = after.split_once('>').expect("a tag ends");
        rest = after;
        let top = open.last_mut().expect("something is open");
        top.text.push_str(&plain(before));
        if tag.starts_with('?') {
            continue;
        }
        if let Some(name) = tag.strip_prefix('/') {
            let done = open.pop().expect("something is open");
            assert_eq!(done.name, name);
            open.last_mut()
                .expect("something is open")
                .children
                .push(done);
            continue;
        }
        let (tag, empty) = match tag.strip_suffix('/') {
            Some(tag) => (tag, true),
            None => (tag, false),
        };
        let (name, mut attributes) = tag.split_once(' ').unwrap_or((tag, ""));
        let mut element = Element {
            name: name.to_owned(),
            ..Element::default()
        };
        while let Some((name, value)) = attributes.split_once("=\"") {
            let (value, after) = value.split_once('"').expect("an attribute ends");
            element
                .attributes
                .push((name.trim().to_owned(), plain(value)));
            attributes = after;
        }
        if empty {
            open.last_mut()
                .expect("something is open")
                .children
                .push(element);
        } else {
            open.push(element);
        }
    }
    let mut outside = open.pop().expect("the document");
    assert!(open.is_empty(), "everything is closed");
    assert_eq!(outside.children.len(), 1);
    outside.children.remove(0)
}

impl Element {
    fn find(&self, path: &[&str]) -> Option<&Element> {
        let Some((name, rest)) = path.split_first() else {
            return Some(self);
        };
        self.children.iter().find(|c| c.name == *name)?.find(rest)
    }

    pub fn get(&self, path: &[&str]) -> &Element {
        let found = self.find(path);
        found.unwrap_or_else(|| panic!("{} has no {path:?}", self.name))
    }

    pub fn attribute(&self, name: &str) -> &str {
        let found = self.attributes.iter().find(|(n, _)| n == name);
        &found
            .unwrap_or_else(|| panic!("{} has no {name}", self.name))
            .1
    }
}

fn type_text(kind: &Element) -> String {
    let [only] = kind.children.as_slice() else {
        panic!("one type");
    };
    match only.name.as_str() {
        "derived" => only.attribute("name").to_owned(),
        "array" => {
            let dimension = only.get(&["dimension"]);
            let of = type_text(only.get(&["baseType"]));
            let (lower, upper) = (dimension.attribute("lower"), dimension.attribute("upper"));
            format!("ARRAY[{lower}..{upper}] OF {of}")
        }
        "string" => format!("STRING[{}]", only.attribute("length")),
        name => name.to_owned(),
    }
}

fn value_text(value: &Element) -> String {
    let [only] = value.children.as_slice() else {
        panic!("one value");
    };
    if only.name == "simpleValue" {
        return only.attribute("value").to_owned();
    }
    assert_eq!(only.name, "arrayValue");
    let values: Vec<String> = only.children.iter().map(value_text).collect();
    format!("[{}]", values.join(", "))
}

/// The types and the block of a document, as Structured Text.
pub fn text_of(document: &str) -> String {
    let project = read(document);
    assert_eq!(project.name, "project");
    let mut out = String::new();
    for declared in &project.get(&["types", "dataTypes"]).children {
        let values = declared.get(&["baseType", "enum", "values"]);
        let labels: Vec<&str> = values
            .children
            .iter()
            .map(|v| v.attribute("name"))
            .collect();
        let _ = writeln!(
            out,
            "TYPE {} : ({}); END_TYPE",
            declared.attribute("name"),
            labels.join(", ")
        );
    }
    let unit = project.get(&["types", "pous", "pou"]);
    assert_eq!(unit.attribute("pouType"), "functionBlock");
    let _ = writeln!(out, "FUNCTION_BLOCK {}", unit.attribute("name"));
    for section in &unit.get(&["interface"]).children {
        let constant = section
            .attributes
            .iter()
            .any(|(n, v)| n == "constant" && v == "true");
        let words = match (section.name.as_str(), constant) {
            ("inputVars", false) => "VAR_INPUT",
            ("outputVars", false) => "VAR_OUTPUT",
            ("localVars", false) => "VAR",
            ("localVars", true) => "VAR CONSTANT",
            ("tempVars", false) => "VAR_TEMP",
            ("documentation", false) => continue,
            other => panic!("{other:?}"),
        };
        let _ = writeln!(out, "{words}");
        for variable in &section.children {
            let name = variable.attribute("name");
            let _ = write!(out, "    {name} : {}", type_text(variable.get(&["type"])));
            if let Some(value) = variable.find(&["initialValue"]) {
                let _ = write!(out, " := {}", value_text(value));
            }
            out.push_str(";\n");
        }
        out.push_str("END_VAR\n");
    }
    out.push_str(&unit.get(&["body", "ST", "xhtml"]).text);
    out.push_str("END_FUNCTION_BLOCK\n");
    out
}
