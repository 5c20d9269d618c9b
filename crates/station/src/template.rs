//! Templates of emitted text: files in `templates/` that resemble their output, filled by
//! `minijinja`.
//!
//! - `@{name}` is replaced by a field. A field of several lines does not end with a line break.
//! - A line that begins with `@ ` is a statement and leaves no line in the output:
//!   `@ for row in rows`, `@ if several`, `@ endif`.
//! - `@% if several %@` is a statement within a line.
//!
//! None of these has a meaning in C, Structured Text, HTML or Markdown; in SimTalk, `@` is followed
//! by a dot. Values are never interpreted as templates, so that no name in a contract can add a
//! field.
//!
//! Rendering one row of a list takes about a microsecond, so the longest tables, those of
//! functions, are passed as one field of many lines.

use include_dir::{Dir, File, include_dir};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;
use std::collections::BTreeSet;
use std::sync::LazyLock;

static FILES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/templates");

static ENVIRONMENT: LazyLock<Environment<'static>> = LazyLock::new(|| {
    let mut environment = environment();
    environment.set_loader(|name| {
        let file = FILES.get_file(name).and_then(File::contents_utf8);
        Ok(file.map(str::to_owned))
    });
    environment
});

/// Creates an environment with the syntax above, without filters or functions, which rejects
/// undefined names and does not escape values.
fn environment() -> Environment<'static> {
    let syntax = SyntaxConfig::builder()
        .variable_delimiters("@{", "}")
        .block_delimiters("@%", "%@")
        .comment_delimiters("@#", "#@")
        .line_statement_prefix("@ ")
        .keep_trailing_newline(true)
        .build()
        .expect("the delimiters differ");
    let mut environment = Environment::empty();
    environment.set_syntax(syntax);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment
}

/// Fills a template of `templates/` with the fields of a structure.
///
/// # Panics
/// Panics if the template does not exist, has an error, or names a missing field. With debug
/// assertions, also if a field is never used.
pub(crate) fn render(name: &str, fields: impl Serialize) -> String {
    fill(&ENVIRONMENT, name, fields)
}

fn fill(environment: &Environment<'_>, name: &str, fields: impl Serialize) -> String {
    let fields = Value::from(Serde(fields));
    let filled = environment.get_template(name).and_then(|template| {
        if cfg!(debug_assertions) {
            let given: BTreeSet<String> = fields.try_iter()?.map(|key| key.to_string()).collect();
            let named: BTreeSet<String> =
                template.undeclared_variables(false).into_iter().collect();
            assert!(
                given == named,
                "template `{name}` and its fields differ in {:?}",
                given.symmetric_difference(&named).collect::<Vec<_>>()
            );
        }
        template.render(fields)
    });
    filled.unwrap_or_else(|e| panic!("template `{name}` cannot be filled: {e:#}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Row {
        low: i64,
        what: &'static str,
    }

    #[derive(Serialize)]
    struct Fields {
        name: &'static str,
        rows: Vec<Row>,
        big: bool,
    }

    fn filled(text: &'static str, fields: impl Serialize) -> String {
        let mut environment = environment();
        let added = environment.add_template("test", text);
        added.expect("the template has no mistakes");
        fill(&environment, "test", fields)
    }

    #[test]
    fn all_templates_can_be_read() {
        let mut folders = vec![&FILES];
        let mut count = 0;
        while let Some(folder) = folders.pop() {
            folders.extend(folder.dirs());
            for file in folder.files() {
                let name = file.path().to_str().expect("names are plain");
                let read = ENVIRONMENT.get_template(&name.replace('\\', "/"));
                assert!(read.is_ok(), "{name}: {:?}", read.err());
                count += 1;
            }
        }
        assert!(count > 0);
    }

    #[test]
    fn fields_rows_and_conditions_are_filled() {
        let text = "int @{name}_@{name}[] = {\n@ for row in rows\n    { @{row.low} }, /* @{row.what} */\n@ else\n    0\n@ endfor\n};\n\n    @ if big\nbig\n    @ else\n  small\n@ endif\n";
        let fields = |rows, big| Fields {
            name: "a",
            rows,
            big,
        };
        let rows = vec![
            Row {
                low: -1,
                what: "<&\"'>",
            },
            Row { low: 2, what: "" },
        ];
        assert_eq!(
            filled(text, fields(rows, true)),
            "int a_a[] = {\n    { -1 }, /* <&\"'> */\n    { 2 }, /*  */\n};\n\nbig\n"
        );
        assert_eq!(
            filled(text, fields(Vec::new(), false)),
            "int a_a[] = {\n    0\n};\n\n  small\n"
        );
    }

    #[test]
    fn values_are_not_templates() {
        #[derive(Serialize)]
        struct Fields {
            a: &'static str,
        }
        let fields = Fields {
            a: "@{a}\n@ if\n@%",
        };
        assert_eq!(filled("/* @{a} */\n", fields), "/* @{a}\n@ if\n@% */\n");
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "differ in [\"a\"]")]
    fn a_field_without_value_is_refused() {
        #[derive(Serialize)]
        struct Fields {}
        filled("@ if false\n@{a}\n@ endif\n", Fields {});
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "differ in [\"a\"]")]
    fn a_value_without_place_is_refused() {
        #[derive(Serialize)]
        struct Fields {
            a: u8,
        }
        filled("x\n", Fields { a: 1 });
    }

    #[test]
    #[should_panic(expected = "undefined")]
    fn a_part_that_a_row_lacks_is_refused() {
        let fields = Fields {
            name: "",
            rows: vec![Row { low: 0, what: "" }],
            big: false,
        };
        filled(
            "@{name}@{big}\n@ for row in rows\n@{row.high}\n@ endfor\n",
            fields,
        );
    }

    #[test]
    #[should_panic(expected = "template `none` cannot be filled")]
    fn an_unknown_template_is_refused() {
        render("none", ());
    }
}
