//! `linewright schema`: prints the JSON Schema of a document.
//!
//! Most schemas are generated from the types that are serialized. If a document is assembled by
//! hand, its schema is a file next to that code.

use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::{algebra, build, check, console, din, doctor, explain, fmt, order, proof, recipe};
use crate::diagnostics::{json, nearest};
use crate::station::profile::{self, ProfileEntry};
use crate::station::{emit, toolchain};
use crate::{event_log, mealy, play, report};
use clap::Args;
use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform as _};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::fmt::Write as _;

/// The arguments of `schema`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright schema
    linewright schema check > check.schema.json

Each document names its schema in the field `schema`: `linewright/check/1` for `check`. The \
schemas are JSON Schema draft 2020-12; objects have no fields beyond those listed. The schema \
`uf-profile` describes a TOML file.")]
pub struct Arguments {
    /// The name of a document, such as check; if omitted, all documents are listed
    pub name: Option<String>,
}

/// The JSON document that lists all others.
#[derive(JsonSchema, Serialize)]
struct List {
    schema: String,
    /// The documents.
    schemas: Vec<Entry>,
}

/// A document that has a schema.
#[derive(JsonSchema, Serialize)]
struct Entry {
    /// The argument of `linewright schema`.
    name: &'static str,
    /// One-line description.
    title: &'static str,
}

/// Returns the schema of a form that a document can have, and adds the definitions to which it
/// refers.
type Form = fn(&mut SchemaGenerator) -> Schema;

/// A kind of document with a JSON Schema.
#[derive(Clone, Copy)]
pub struct Described {
    /// The name: the command that prints the document, or a name for the content of the file.
    pub name: &'static str,
    /// One-line description.
    pub title: &'static str,
    forms: &'static [Form],
}

impl Described {
    /// Describes a document that has one of these forms.
    pub(super) const fn new(
        name: &'static str,
        title: &'static str,
        forms: &'static [Form],
    ) -> Self {
        Self { name, title, forms }
    }

    /// Value of the document's field `schema`.
    pub fn id(&self) -> String {
        console::schema(self.name)
    }

    /// The JSON Schema of the document.
    pub fn schema(&self) -> Value {
        let settings = SchemaSettings::draft2020_12().for_serialize();
        let mut generator = settings.into_generator();
        let mut forms = Vec::new();
        for form in self.forms {
            let mut form = form(&mut generator).to_value();
            match form.get_mut("anyOf").map(Value::take) {
                Some(Value::Array(several)) => forms.extend(several),
                _ => forms.push(form),
            }
        }
        for form in &mut forms {
            if let Some(schema) = form.pointer_mut("/properties/schema") {
                *schema =
                    json!({"description": "The schema of this document.", "const": self.id()});
            }
        }
        let mut root = Map::new();
        root.insert(
            "$schema".to_owned(),
            generator.settings().meta_schema.as_deref().into(),
        );
        root.insert("title".to_owned(), self.id().into());
        root.insert("description".to_owned(), self.title.into());
        match forms.as_mut_slice() {
            [Value::Object(only)] => {
                let own = std::mem::take(only).into_iter();
                root.extend(own.filter(|(key, _)| key != "title" && key != "description"));
            }
            _ => drop(root.insert("anyOf".to_owned(), forms.into())),
        }
        let definitions = generator.take_definitions(true);
        if !definitions.is_empty() {
            root.insert("$defs".to_owned(), definitions.into());
        }
        let mut schema = Schema::from(root);
        RecursiveTransform(tidy).transform(&mut schema);
        schema.to_value()
    }
}

/// The schema of a type that `serde` serializes.
pub(super) fn form<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    T::json_schema(generator)
}

/// Parses a schema that is written by hand, and adds its definitions to the generator.
pub(super) fn by_hand(text: &str, generator: &mut SchemaGenerator) -> Schema {
    let mut schema: Schema =
        serde_json::from_str(text).expect("a schema is not a JSON object; please report this");
    if let Some(Value::Object(definitions)) = schema.remove("$defs") {
        generator.definitions_mut().extend(definitions);
    }
    schema
}

/// A value of a contract's variable.
pub struct AnyValue;

impl JsonSchema for AnyValue {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Value".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A truth value, a number or a label.",
            "type": ["boolean", "integer", "string"],
        })
    }
}

/// Excludes further fields of objects, excludes `null` for fields that can be absent, and joins the
/// lines of descriptions.
fn tidy(schema: &mut Schema) {
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text.replace('\n', " ");
    }
    let required = schema.get("required").cloned().unwrap_or_default();
    let is_required = |name: &String| {
        let mut names = required.as_array().into_iter().flatten();
        names.any(|r| r == name)
    };
    let Some(Value::Object(properties)) = schema.get_mut("properties") else {
        return;
    };
    for (name, property) in properties.iter_mut() {
        if let Value::Object(property) = property
            && !is_required(name)
        {
            exclude_null(property);
        }
    }
    if schema.get("additionalProperties").is_none() {
        schema.insert("additionalProperties".to_owned(), false.into());
    }
}

fn exclude_null(schema: &mut Map<String, Value>) {
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|t| t != "null");
        if let [only] = types.as_mut_slice() {
            let only = only.take();
            schema.insert("type".to_owned(), only);
        }
    }
    if let Some(Value::Array(forms)) = schema.get_mut("anyOf") {
        forms.retain(|f| *f != json!({"type": "null"}));
        if let [Value::Object(only)] = forms.as_mut_slice() {
            let only = std::mem::take(only);
            schema.remove("anyOf");
            schema.extend(only);
        }
    }
}

/// All documents, sorted by name.
pub fn all() -> Vec<Described> {
    let mut all = OWN.to_vec();
    all.extend(algebra::DOCUMENTS);
    all.extend(order::DOCUMENTS);
    all.extend(recipe::DOCUMENTS);
    all.extend([
        build::DOCUMENT,
        check::DOCUMENT,
        din::DOCUMENT,
        doctor::DOCUMENT,
        explain::DOCUMENT,
        fmt::DOCUMENT,
        proof::DOCUMENT,
    ]);
    all.sort_by_key(|d| d.name);
    all
}

/// The document with a name.
pub fn find(name: &str) -> Option<Described> {
    all().into_iter().find(|d| d.name == name)
}

/// Documents that are not defined next to a command.
const OWN: [Described; 13] = [
    Described::new(
        "completions",
        "Why `completions` has no result",
        &[form::<console::Failed>],
    ),
    Described::new(
        "functions",
        "A symbolic controller: `synth --emit json` of a large contract",
        &[|generator| by_hand(mealy::functions::SCHEMA, generator)],
    ),
    Described::new(
        "draw",
        "Why `draw` has no result",
        &[form::<console::Failed>],
    ),
    Described::new(
        "import",
        "Why `import` has no result",
        &[form::<console::Failed>],
    ),
    Described::new(
        "library",
        "The file next to a station library: its machine and checksum",
        &[toolchain::manifest_schema],
    ),
    Described::new(
        "log",
        "The first line of the JSON lines that `run --trace` writes",
        &[|generator| by_hand(event_log::LOG_SCHEMA, generator)],
    ),
    Described::new(
        "machine",
        "A controller or a counterstrategy as states and transitions: `synth --emit json`",
        &[|generator| by_hand(mealy::json::SCHEMA, generator)],
    ),
    Described::new(
        "run",
        "The report of a run of a line",
        &[
            |generator| {
                generator.subschema_for::<json::Finding>();
                by_hand(report::RUN_SCHEMA, generator)
            },
            form::<console::Failed>,
        ],
    ),
    Described::new(
        "schema",
        "The documents with a schema",
        &[form::<List>, form::<console::Failed>],
    ),
    Described::new(
        "station",
        "What `station_describe` of a station library returns",
        &[|generator| {
            generator.subschema_for::<ProfileEntry>();
            by_hand(emit::DESCRIPTION_SCHEMA, generator)
        }],
    ),
    Described::new(
        "step",
        "A line of a play: `step --format json` prints one per move and answer",
        &[
            |generator| by_hand(play::LINE_SCHEMA, generator),
            form::<console::Failed>,
        ],
    ),
    Described::new(
        "synth",
        "Why `synth` has no result",
        &[form::<console::Failed>],
    ),
    Described::new(
        "uf-profile",
        "A layout of `UF_Value`, the file of `build --profile` (TOML)",
        &[|generator| by_hand(profile::FILE_SCHEMA, generator)],
    ),
];

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    options.refuse_sarif("a schema")?;
    let console = options.console();
    if let Some(name) = &arguments.name {
        let known = find(short(name.trim())).ok_or_else(|| unknown(name))?;
        console.document(&known.schema())?;
        return Ok(ExitCode::Success);
    }
    if options.format == Format::Json {
        console.document(&List {
            schema: console::schema("schema"),
            schemas: all()
                .iter()
                .map(|d| Entry {
                    name: d.name,
                    title: d.title,
                })
                .collect(),
        })?;
    } else {
        console.result(&list())?;
    }
    Ok(ExitCode::Success)
}

/// The name `check` in `linewright/check/1`; other texts are returned unchanged.
fn short(name: &str) -> &str {
    let within = name.strip_prefix("linewright/");
    within.and_then(|n| n.strip_suffix("/1")).unwrap_or(name)
}

fn unknown(name: &str) -> anyhow::Error {
    let all = all();
    let near = nearest(short(name.trim()), all.iter().map(|d| d.name));
    let meant = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
    anyhow::anyhow!("there is no document `{name}`: {meant}`linewright schema` lists them all")
}

/// A list of all documents, one per line.
fn list() -> String {
    let all = all();
    let width = all.iter().map(|d| d.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for document in all {
        let _ = writeln!(text, "{:<width$}  {}", document.name, document.title);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_object_is_closed_and_every_field_is_described() {
        fn visit(at: &str, schema: &Schema) {
            let Some(Value::Object(properties)) = schema.get("properties") else {
                return;
            };
            assert!(schema.get("additionalProperties").is_some(), "{at}");
            for (name, property) in properties {
                let described =
                    ["description", "const", "$ref"].map(|key| property.get(key).is_some());
                // References are described by their definition; `station` lists only numbers.
                assert!(
                    described.contains(&true) || at == "station",
                    "{at}: {name} has no description: {property}"
                );
            }
        }
        for document in all() {
            let mut schema = Schema::try_from(document.schema()).unwrap();
            let look = |schema: &mut Schema| visit(document.name, schema);
            RecursiveTransform(look).transform(&mut schema);
        }
    }

    #[test]
    fn names_are_distinguished() {
        let names: Vec<&str> = all().iter().map(|d| d.name).collect();
        let mut once = names.clone();
        once.dedup();
        assert_eq!(names, once);
        assert_eq!(short("linewright/check/1"), "check");
        assert!(find("check").is_some());
        assert!(
            unknown("chek")
                .to_string()
                .contains("did you mean `check`?")
        );
    }
}
