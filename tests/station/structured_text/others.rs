//! External tools: blark, a parser of Structured Text, and the schema of PLCopen XML with a
//! validator.
//!
//! Both run as separate processes, and both must reject damaged files; otherwise their acceptance
//! would mean nothing.

use crate::library::{as_functions, bundled, large, machines};
use crate::support::{self, python_with};
use crate::unit::pick_and_place;
use linewright::station::monitor;
use linewright::station::structured_text::{Block, block, block_with_tables};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Whether a command accepts a file; otherwise its output.
fn accepted(command: &mut Command) -> Result<(), String> {
    let output = command.output().expect("the checker starts");
    if output.status.success() {
        return Ok(());
    }
    let both = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&both).into_owned();
    let lines: Vec<&str> = text.lines().collect();
    Err(lines[lines.len().saturating_sub(5)..].join("\n"))
}

/// The bundled library as emitted, and two of its contracts in the forms of larger controllers.
/// blark needs some seconds for a long text.
fn blocks() -> Vec<Block> {
    let library = bundled().iter();
    let mut blocks: Vec<Block> = library
        .map(|c| block(&c.controller, &c.specification))
        .collect();
    for controlled in bundled() {
        let specification = &controlled.specification;
        let machine = controlled.controller.machine().expect("a machine");
        // One without enumerations, and one with.
        if machine.name == "Single" {
            blocks.push(block_with_tables(machine, specification));
        }
        if ["Single", "Pick"].contains(&machine.name.as_str()) {
            blocks.push(block(&as_functions(specification), specification));
        }
    }
    blocks.push(monitor::structured_text::block(&pick_and_place(true)));
    blocks
}

#[test]
fn blark_parses_the_library_and_every_form() {
    let Some(python) = python_with("blark", "blark") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let parse = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file can be written");
        accepted(
            Command::new(&python)
                .args(["-m", "blark", "parse"])
                .arg(&path),
        )
    };
    let blocks = blocks();
    blocks.par_iter().enumerate().for_each(|(place, block)| {
        let verdict = parse(&format!("{place}.st"), &block.to_text());
        verdict.unwrap_or_else(|e| panic!("{}: {e}\n{}", block.name, block.to_text()));
    });
    let text = blocks[0].to_text();
    let damage = [
        ("END_CASE;", "END_CAES;"),
        (" THEN", " THE"),
        (":= FALSE;", ":= ;"),
        ("VAR_INPUT", "VAR_INPUTS"),
    ];
    damage
        .par_iter()
        .enumerate()
        .for_each(|(place, (right, wrong))| {
            assert!(text.contains(right), "{right}");
            let damaged = text.replacen(right, wrong, 1);
            assert!(
                parse(&format!("damaged{place}.st"), &damaged).is_err(),
                "{wrong}"
            );
        });
}

/// The folder with schemas that may not be part of this repository.
fn schema() -> Option<PathBuf> {
    let folder = std::env::var_os("LINEWRIGHT_SCHEMAS").map_or_else(
        || support::root().join("../shared/facts/schemas"),
        PathBuf::from,
    );
    let path = folder.join("tc6_xml_v201.xsd");
    if path.is_file() {
        return Some(path);
    }
    support::skip("xsd", &format!("there is no {}", path.display()));
    None
}

/// Validates with lxml: prints every invalid path with the reason.
const VALIDATE: &str = "
import sys
from lxml import etree
schema = etree.XMLSchema(etree.parse(sys.argv[1]))
wrong = 0
for path in sys.argv[2:]:
    try:
        valid = schema.validate(etree.parse(path))
        why = schema.error_log.last_error
    except etree.XMLSyntaxError as error:
        valid, why = False, error
    if not valid:
        wrong += 1
        print(path, why)
sys.exit(1 if wrong else 0)
";

/// Returns the faults of the documents.
type Validator = dyn Fn(&[PathBuf]) -> Result<(), String>;

/// Validates documents against a schema.
fn validator(schema: &Path) -> Option<Box<Validator>> {
    let schema = schema.to_path_buf();
    if Command::new("xmllint").arg("--version").output().is_ok() {
        return Some(Box::new(move |paths| {
            accepted(
                Command::new("xmllint")
                    .args(["--noout", "--schema"])
                    .arg(&schema)
                    .args(paths),
            )
        }));
    }
    let python = python_with("xsd", "lxml")?;
    Some(Box::new(move |paths| {
        accepted(
            Command::new(&python)
                .args(["-c", VALIDATE])
                .arg(&schema)
                .args(paths),
        )
    }))
}

#[test]
fn documents_are_valid_against_the_schema() {
    let Some(schema) = schema() else {
        return;
    };
    let Some(validate) = validator(&schema) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: String, document: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, document).expect("a file can be written");
        path
    };
    let mut paths = Vec::new();
    for controlled in machines() {
        let specification = &controlled.specification;
        let machine = controlled.controller.machine().expect("a machine");
        let blocks = [
            block(&controlled.controller, specification),
            block_with_tables(machine, specification),
            block(&as_functions(specification), specification),
        ];
        for block in blocks {
            paths.push(write(format!("{}.xml", paths.len()), &block.to_plcopen()));
        }
    }
    for controlled in large() {
        let document = block(&controlled.controller, &controlled.specification).to_plcopen();
        paths.push(write(format!("{}.xml", paths.len()), &document));
    }
    let document = monitor::structured_text::block(&pick_and_place(true)).to_plcopen();
    paths.push(write(format!("{}.xml", paths.len()), &document));
    assert!(paths.len() > 40, "{} documents", paths.len());
    validate(&paths).unwrap_or_else(|e| panic!("{e}"));

    let document = std::fs::read_to_string(&paths[0]).expect("it was written");
    for (place, (right, wrong)) in [
        (" creationDateTime=\"1970-01-01T00:00:00\"", ""),
        ("<BOOL/>", "<BOOLEAN/>"),
        ("functionBlock", "functionblock"),
        ("<instances>", "<instance>"),
    ]
    .into_iter()
    .enumerate()
    {
        assert!(document.contains(right), "{right}");
        let damaged = write(
            format!("damaged{place}.xml"),
            &document.replacen(right, wrong, 1),
        );
        assert!(validate(&[damaged]).is_err(), "{wrong}");
    }
}
