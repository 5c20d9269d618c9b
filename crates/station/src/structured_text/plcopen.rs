//! Prints a block as PLCopen XML: the exchange format of PLCopen's technical committee 6, version
//! 2.01.
//!
//! The elements are in schema order. The same block always gives the same bytes, so the date that
//! the schema requires is fixed.

use super::{Block, Enumeration, Initial, Section, Type, Variable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use std::fmt::Write as _;

const NAMESPACE: &str = "http://www.plcopen.org/xml/tc6_0201";
const XHTML: &str = "http://www.w3.org/1999/xhtml";

/// Fixed date that the schema requires; the true date would make every output different.
const CREATED: &str = "1970-01-01T00:00:00";

/// An XML document under construction in memory.
struct Document(Writer<Vec<u8>>);

impl Document {
    fn event(&mut self, event: Event<'_>) {
        self.0
            .write_event(event)
            .expect("writing to memory does not fail");
    }

    fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let start = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.event(Event::Empty(start));
    }

    /// Writes an element with the content that `inside` writes.
    fn element(&mut self, name: &str, attributes: &[(&str, &str)], inside: impl FnOnce(&mut Self)) {
        let start = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.event(Event::Start(start));
        inside(self);
        self.event(Event::End(BytesEnd::new(name)));
    }

    /// Writes an element with text in the form that the schema requires.
    fn formatted(&mut self, name: &str, text: &str) {
        self.element(name, &[], |d| {
            d.element("xhtml", &[("xmlns", XHTML)], |d| {
                d.event(Event::Text(BytesText::new(text)));
            });
        });
    }

    fn documentation(&mut self, text: &str) {
        if !text.is_empty() {
            self.formatted("documentation", text);
        }
    }

    fn kind(&mut self, kind: &Type) {
        match kind {
            Type::Bool => self.empty("BOOL", &[]),
            Type::Integer(width) => self.empty(width.keyword(), &[]),
            Type::Enumeration(name) => self.empty("derived", &[("name", name)]),
            Type::Text(max_chars) => self.empty("string", &[("length", &max_chars.to_string())]),
            Type::Array(first, last, of) => self.element("array", &[], |d| {
                let (first, last) = (first.to_string(), last.to_string());
                d.empty("dimension", &[("lower", &first), ("upper", &last)]);
                d.element("baseType", &[], |d| d.kind(of));
            }),
        }
    }

    fn initial(&mut self, initial: &Initial) {
        let simple = |d: &mut Self, value: &str| d.empty("simpleValue", &[("value", value)]);
        match initial {
            Initial::Default => {}
            Initial::Value(value) => self.element("initialValue", &[], |d| simple(d, value)),
            Initial::Values(values) => self.element("initialValue", &[], |d| {
                d.element("arrayValue", &[], |d| {
                    for value in values {
                        d.element("value", &[], |d| simple(d, value));
                    }
                });
            }),
        }
    }

    fn variable(&mut self, variable: &Variable) {
        self.element("variable", &[("name", &variable.name)], |d| {
            d.element("type", &[], |d| d.kind(&variable.kind));
            d.initial(&variable.initial);
            d.documentation(&variable.description);
        });
    }

    fn enumeration(&mut self, declared: &Enumeration) {
        self.element("dataType", &[("name", &declared.name)], |d| {
            d.element("baseType", &[], |d| {
                d.element("enum", &[], |d| {
                    d.element("values", &[], |d| {
                        for (label, _) in &declared.labels {
                            d.empty("value", &[("name", label)]);
                        }
                    });
                });
            });
            d.documentation(&declared.description_text());
        });
    }
}

impl Enumeration {
    /// Description that includes the comments of all labels: the format has no element for them.
    fn description_text(&self) -> String {
        let mut out = self.description.clone();
        for (label, meaning) in self.labels.iter().filter(|(_, m)| !m.is_empty()) {
            if !out.is_empty() {
                out.push('\n');
            }
            let _ = write!(out, "{label}: {meaning}");
        }
        out
    }
}

impl Section {
    /// Name of the section's element, and whether its variables are constants.
    fn element(self) -> (&'static str, bool) {
        match self {
            Self::Input => ("inputVars", false),
            Self::Output => ("outputVars", false),
            Self::Local => ("localVars", false),
            Self::Constant => ("localVars", true),
            Self::Temporary => ("tempVars", false),
        }
    }
}

impl Block {
    /// Returns the types and the function block as a PLCopen XML project.
    pub fn to_plcopen(&self) -> String {
        let mut document = Document(Writer::new_with_indent(Vec::new(), b' ', 2));
        document.event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        document.element("project", &[("xmlns", NAMESPACE)], |d| {
            d.empty(
                "fileHeader",
                &[
                    ("companyName", ""),
                    ("productName", "linewright"),
                    ("productVersion", env!("CARGO_PKG_VERSION")),
                    ("creationDateTime", CREATED),
                ],
            );
            d.element("contentHeader", &[("name", &self.name)], |d| {
                d.element("coordinateInfo", &[], |d| {
                    for language in ["fbd", "ld", "sfc"] {
                        d.element(language, &[], |d| {
                            d.empty("scaling", &[("x", "1"), ("y", "1")]);
                        });
                    }
                });
            });
            d.element("types", &[], |d| {
                d.element("dataTypes", &[], |d| {
                    for declared in &self.types {
                        d.enumeration(declared);
                    }
                });
                d.element("pous", &[], |d| self.organization_unit(d));
            });
            d.element("instances", &[], |d| d.empty("configurations", &[]));
        });
        let bytes = document.0.into_inner();
        let mut text = String::from_utf8(bytes).expect("text was written");
        text.push('\n');
        text
    }

    fn organization_unit(&self, d: &mut Document) {
        let attributes = [("name", self.name.as_str()), ("pouType", "functionBlock")];
        d.element("pou", &attributes, |d| {
            d.element("interface", &[], |d| {
                for (section, variables) in &self.sections {
                    let (name, constant) = section.element();
                    let constant: &[(&str, &str)] = if constant {
                        &[("constant", "true")]
                    } else {
                        &[]
                    };
                    d.element(name, constant, |d| {
                        for variable in variables {
                            d.variable(variable);
                        }
                    });
                }
                d.documentation(self.description_text().trim_end());
            });
            d.element("body", &[], |d| d.formatted("ST", &self.body));
        });
    }
}
