//! JSON documents that the program wrote, each against the schema that `linewright schema` prints.

use jsonschema::Validator;
use jsonschema::error::ValidationErrorKind;
use linewright::cli::schema;
use serde_json::{Deserializer, Value};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::LazyLock;

/// The schemas, each made once.
static VALIDATORS: LazyLock<BTreeMap<String, Validator>> = LazyLock::new(|| {
    let all = schema::all();
    let validators = all.iter().map(|document| {
        let validator = jsonschema::draft202012::new(&document.schema());
        let validator =
            validator.unwrap_or_else(|e| panic!("the schema of {}: {e}", document.name));
        (document.id(), validator)
    });
    validators.collect()
});

/// What is wrong with a document; nothing where it is as its schema says.
pub fn faults(document: &Value) -> String {
    let id = document["schema"].as_str().unwrap_or_default();
    faults_by(id, document)
}

/// The same by the schema of this id.
pub fn faults_by(id: &str, document: &Value) -> String {
    let Some(validator) = VALIDATORS.get(id) else {
        return format!("there is no schema `{id}`\n");
    };
    let mut faults = String::new();
    if !validator.is_valid(document) {
        for error in validator.iter_errors(document) {
            // Of several forms the first is the one that is meant: the others are of failures.
            let inner = match error.kind() {
                ValidationErrorKind::AnyOf { context } => context.first(),
                _ => None,
            };
            for error in inner.map_or(std::slice::from_ref(&error), Vec::as_slice) {
                let (place, error) = (error.instance_path(), error.masked());
                let _ = writeln!(faults, "{id}, at `{place}`: {error}");
            }
        }
    }
    faults
}

/// The documents in what was printed: the whole of it, or one after the other. What is no JSON, or
/// of another program's format, is none.
pub fn documents(text: &[u8]) -> Vec<Value> {
    let values = Deserializer::from_slice(text).into_iter();
    let documents = values.map_while(Result::ok);
    let is_ours = |document: &Value| {
        let id = document.get("schema").and_then(Value::as_str);
        id.is_some_and(|id| id.starts_with("linewright/"))
    };
    documents.filter(is_ours).collect()
}

/// Asserts that what was printed holds only documents that are as their schemas say, and gives
/// these.
pub fn assert_valid(text: &[u8]) -> Vec<Value> {
    // Most of what is printed is for people.
    if !text.trim_ascii_start().starts_with(b"{") {
        return Vec::new();
    }
    let documents = documents(text);
    for document in &documents {
        let faults = faults(document);
        assert!(faults.is_empty(), "{faults}{document:#}");
    }
    documents
}

/// The same of the files below a folder whose names end in `.json`.
pub fn assert_files_valid(folder: &Path) -> Vec<Value> {
    let mut documents = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            documents.extend(assert_files_valid(&path));
        } else if path.extension().is_some_and(|e| e == "json") {
            documents.extend(assert_valid(&std::fs::read(&path).expect("a file")));
        }
    }
    documents
}
