//! Writes documents. All elements are in the order of the schema; the same input gives the same
//! bytes, so no document has a date of publication.

mod activity;
mod definition;
mod equipment;
mod performance;
mod schedule;
mod workflow;

pub use definition::definition;
pub use equipment::equipment;
pub use performance::performance;
pub use schedule::schedule;
pub use workflow::workflow;

use crate::name::encode;
use crate::xml::XmlWriter;
use linewright_recipe::model::{OperationCall, Problem};
use std::fmt;

/// Reason why something cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// The layout or the recipe has these problems other than warnings.
    #[error("{}", Lines(.0))]
    Problems(Vec<Problem>),
    /// A schedule or performance has nothing in it, which B2MML does not allow.
    #[error("there is nothing to be done")]
    Nothing,
    /// Two requests of a schedule have the same identifier.
    #[error("two requests have the identifier `{0}`")]
    DuplicateRequest(String),
    /// A time is not a number, or its date is outside of the years 1 to 9999.
    #[error("a time of record {0} is not a date of the years 1 to 9999")]
    Time(usize),
}

/// Problems, one in a line.
struct Lines<'a>(&'a [Problem]);

impl fmt::Display for Lines<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, problem) in self.0.iter().enumerate() {
            let separator = if number > 0 { "\n" } else { "" };
            write!(f, "{separator}{problem}")?;
        }
        Ok(())
    }
}

/// Fails if there are problems other than warnings.
fn without_problems(problems: Vec<Problem>) -> Result<(), WriteError> {
    let problems: Vec<Problem> = (problems.into_iter()).filter(|p| !p.is_warning()).collect();
    if problems.is_empty() {
        Ok(())
    } else {
        Err(WriteError::Problems(problems))
    }
}

/// A value of a property or parameter.
struct Value<'a> {
    text: &'a str,
    kind: &'static str,
    unit: Option<&'static str>,
    key: Option<&'a str>,
}

impl<'a> Value<'a> {
    /// Creates a text, encoded already.
    fn text(text: &'a str) -> Self {
        Self {
            text,
            kind: "string",
            unit: None,
            key: None,
        }
    }

    /// Creates a number with a unit.
    fn number(text: &'a str, unit: &'static str) -> Self {
        Self {
            kind: "decimal",
            unit: Some(unit),
            ..Self::text(text)
        }
    }

    /// Creates a count.
    fn count(text: &'a str) -> Self {
        Self {
            kind: "integer",
            ..Self::text(text)
        }
    }

    /// Sets the key.
    fn under(self, key: &'a str) -> Self {
        Self {
            key: Some(key),
            ..self
        }
    }
}

/// Writes a property or a parameter, whose elements have the same content.
fn property(w: &mut XmlWriter, element: &str, id: &str, values: &[Value<'_>]) {
    w.element(element, |w| {
        w.text("ID", id);
        for value in values {
            w.element("Value", |w| {
                w.text("ValueString", value.text);
                w.text("DataType", value.kind);
                if let Some(unit) = value.unit {
                    w.text("UnitOfMeasure", unit);
                }
                if let Some(key) = value.key {
                    w.text("Key", key);
                }
            });
        }
    });
}

/// Writes a property with names, if there are any.
fn names(w: &mut XmlWriter, element: &str, id: &str, names: &[String]) {
    if names.is_empty() {
        return;
    }
    let encoded: Vec<String> = names.iter().map(|n| encode(n)).collect();
    let values: Vec<Value<'_>> = encoded.iter().map(|n| Value::text(n)).collect();
    property(w, element, id, &values);
}

/// Writes a property with one name.
fn name(w: &mut XmlWriter, element: &str, id: &str, name: &str) {
    property(w, element, id, &[Value::text(&encode(name))]);
}

/// Writes a quantity of one piece.
fn one_piece(w: &mut XmlWriter) {
    w.element("Quantity", |w| {
        w.text("QuantityString", "1");
        w.text("DataType", "integer");
        w.text("UnitOfMeasure", "ea");
    });
}

/// Returns a call as people read it: `glue(p)(p)`.
fn shown(call: &OperationCall) -> String {
    let list = |names: &[String]| {
        let names: Vec<String> = names.iter().map(|n| encode(n)).collect();
        names.join(", ")
    };
    let (inputs, outputs) = (list(&call.inputs), list(&call.outputs));
    format!("{}({inputs})({outputs})", encode(&call.name))
}
