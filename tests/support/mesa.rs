//! The schemas of MESA, and libxml2 as validator (by lxml).
//!
//! The schemas are no part of the repository: they are looked for in `b2mml-7.0.1` within
//! `LINEWRIGHT_SCHEMAS` or beside it, which is `../shared/facts/schemas` if it is not set.

use super::external::{python_with, skip};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Prints the name of each file that is valid.
const VALIDATE: &str = "
import os, sys
from lxml import etree
schema = etree.XMLSchema(etree.parse(sys.argv[1]))
parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True)
for name in sorted(os.listdir(sys.argv[2])):
    try:
        if schema.validate(etree.parse(os.path.join(sys.argv[2], name), parser)):
            print(name)
        elif len(sys.argv) > 3:
            print(name, schema.error_log.last_error, file=sys.stderr)
    except (etree.XMLSyntaxError, OSError) as error:
        if len(sys.argv) > 3:
            print(name, error, file=sys.stderr)
";

/// The schemas, and a Python with lxml.
pub struct Validator {
    /// Folder of the schemas.
    pub schemas: PathBuf,
    python: PathBuf,
}

impl Validator {
    /// Returns the validator. If it is missing, the test is skipped. `root` is the top folder of
    /// the repository.
    pub fn find(root: &Path) -> Option<Self> {
        let folder = std::env::var_os("LINEWRIGHT_SCHEMAS")
            .map_or_else(|| root.join("../shared/facts/schemas"), PathBuf::from);
        let places = [folder.join("b2mml-7.0.1"), folder.join("../b2mml-7.0.1")];
        let Some(schemas) = places.iter().find(|p| p.join("AllSchemas.xsd").is_file()) else {
            skip("b2mml", &format!("there is no {}", places[0].display()));
            return None;
        };
        Some(Self {
            schemas: schemas.clone(),
            python: python_with("xsd", "lxml")?,
        })
    }

    /// Returns the output of a Python program.
    pub fn python(&self, program: &str, arguments: &[&Path]) -> String {
        let mut command = Command::new(&self.python);
        let output = command.args(["-c", program]).args(arguments).output();
        let output = output.expect("Python starts");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{errors}");
        String::from_utf8(output.stdout).expect("it prints UTF-8") + &errors
    }

    /// Returns the names of the files of a folder that are valid, with the reasons for the others
    /// if they are asked for. Names have no spaces.
    pub fn valid(&self, folder: &Path, reasons: bool) -> (BTreeSet<String>, String) {
        let all = self.schemas.join("AllSchemas.xsd");
        let mut arguments: Vec<&Path> = vec![&all, folder];
        if reasons {
            arguments.push(Path::new("reasons"));
        }
        let printed = self.python(VALIDATE, &arguments);
        let (names, rest): (Vec<&str>, Vec<&str>) = printed.lines().partition(|l| !l.contains(' '));
        (
            names.into_iter().map(str::to_owned).collect(),
            rest.join("\n"),
        )
    }
}
