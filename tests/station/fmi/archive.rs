//! Content of an archive: everything required by the standard, the same bytes every time, and names
//! that every importer accepts.

use super::hosts::{binary_name, file_of, laboratory, run};
use crate::fixtures;
use crate::support::{linewright, python_with, root, sandbox};
use linewright::gr1::Domain;
use linewright::station::fmi::variables::{Causality, Start};
use linewright::station::fmi::{self, Unit, Version};
use linewright::station::{Package, toolchain::Platform};
use std::collections::BTreeSet;
use std::process::Command;
use std::sync::Arc;

/// The names of an archive's files, in order.
fn names(bytes: &[u8]) -> Vec<String> {
    let archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).expect("an archive");
    let names = archive.file_names();
    names.map(|n| n.expect("a name").into_owned()).collect()
}

#[test]
fn archives_hold_what_the_standard_wants() {
    for built in laboratory() {
        let stem = &built.unit.package.stem;
        let bytes = std::fs::read(&built.archive).unwrap();
        let names = names(&bytes);
        assert!(names.is_sorted(), "{names:?}");
        let mut wanted = vec![
            "modelDescription.xml".to_owned(),
            "documentation/index.html".to_owned(),
            format!("sources/{stem}.c"),
            "sources/fmi.c".to_owned(),
            "sources/station.h".to_owned(),
            binary_name(&built.unit, false),
        ];
        match built.unit.version {
            Version::Two => wanted.push("sources/fmi2.c".to_owned()),
            Version::Three => {
                wanted
                    .extend(["sources/fmi3.c", "sources/buildDescription.xml"].map(str::to_owned));
            }
        }
        for name in wanted {
            assert!(names.contains(&name), "{name} in {names:?}");
        }
        assert!(
            names.iter().all(|n| !n.contains("plant_simulation")),
            "{names:?}"
        );
        let description = file_of(&built.archive, "modelDescription.xml").unwrap();
        let description = String::from_utf8(description).unwrap();
        assert!(description.contains(&built.unit.token), "{description}");
        assert!(!description.contains("generationDateAndTime"));
        // The description and the binary belong to one unit.
        let source = file_of(&built.archive, &format!("sources/{stem}.c")).unwrap();
        assert!(
            String::from_utf8(source)
                .unwrap()
                .contains(&built.unit.token)
        );
    }
}

#[test]
fn two_builds_are_the_same_bytes() {
    for (machine, controllers) in [fixtures::manipulator(), fixtures::belt()] {
        let (toolchains, _) = fmi::toolchains();
        let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let built = [&one, &two].map(|folder| {
            let (files, _) =
                fmi::build(&machine, &controllers, &toolchains, folder.path()).unwrap();
            let left = std::fs::read_dir(folder.path()).unwrap().count();
            assert_eq!(left, files.len(), "nothing else is left behind");
            files
                .iter()
                .map(|f| std::fs::read(f).unwrap())
                .collect::<Vec<_>>()
        });
        assert!(built[0] == built[1], "{}", machine.name);
        // Another machine has another token.
        let mut other = (*machine).clone();
        other.base_watts += 0.1;
        for version in Version::ALL {
            let tokens = [&*machine, &other].map(|m| Unit::emit(m, &controllers, version).token);
            assert_ne!(tokens[0], tokens[1]);
        }
    }
}

#[test]
fn the_sources_have_no_warnings() {
    let folder = tempfile::tempdir().unwrap();
    for built in laboratory() {
        let file = built.unit.package.write_source(folder.path()).unwrap();
        for level in ["-O0", "-O2"] {
            let output = Command::new("cc")
                .args([
                    "-std=c99",
                    "-Wall",
                    "-Wextra",
                    "-Wconversion",
                    "-pedantic",
                    "-Werror",
                ])
                .args([level, "-fPIC", "-c"])
                .arg(&file)
                .arg("-o")
                .arg(folder.path().join("out.o"))
                .output()
                .expect("the compiler starts");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && said.is_empty(), "{said}");
        }
    }
}

/// Several units in one program: with a prefix, no two of them share a symbol.
#[test]
fn units_can_be_linked_together() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = BTreeSet::new();
    for built in laboratory() {
        let (stem, version) = (&built.unit.package.stem, built.unit.version);
        let number = if version == Version::Two { 2 } else { 3 };
        let file = built.unit.package.write_source(folder.path()).unwrap();
        let object = folder.path().join(format!("{stem}{number}.o"));
        let output = Command::new("cc")
            .args(["-std=c99", "-c"])
            .arg(format!("-DFMI{number}_FUNCTION_PREFIX={stem}_"))
            .arg(&file)
            .arg("-o")
            .arg(&object)
            .output()
            .expect("the compiler starts");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let symbols = Command::new("nm")
            .args(["-g", "--defined-only"])
            .arg(&object)
            .output();
        let symbols = symbols.expect("nm starts").stdout;
        for line in String::from_utf8_lossy(&symbols).lines() {
            let symbol = line.split(' ').next_back().unwrap_or_default().to_owned();
            assert!(
                symbol.starts_with(&format!("{stem}_fmi{number}")),
                "{symbol}"
            );
            assert!(seen.insert(symbol.clone()), "{symbol} twice");
        }
    }
    assert!(seen.len() > 500);
}

#[test]
fn variables_are_those_of_the_machine() {
    for built in laboratory() {
        let interface = &built.unit.interface;
        let machine = &built.machine;
        let mut references = BTreeSet::new();
        for variable in &interface.variables {
            assert!(references.insert(variable.reference), "{}", variable.name);
            let settable = matches!(variable.causality, Causality::Input | Causality::Parameter);
            assert_eq!(variable.start.is_some(), settable, "{}", variable.name);
        }
        for component in &machine.components {
            for id in component.specification.outputs() {
                let v = component.specification.variable(id);
                let name = format!("{}.{}", component.name, v.name);
                let variable = interface.find(&name).unwrap_or_else(|| panic!("{name}"));
                assert_eq!(variable.causality == Causality::Local, v.internal, "{name}");
            }
        }
    }
    let cell = laboratory()
        .iter()
        .find(|b| b.machine.name == "AssemblyCell")
        .unwrap();
    let find = |name: &str| {
        cell.unit
            .interface
            .find(name)
            .unwrap_or_else(|| panic!("{name}"))
    };
    assert_eq!(find("part.angle").unit, "deg");
    assert_eq!(find("target_angle").start, Some(Start::Real(90.0)));
    assert_eq!(find("target_angle").causality, Causality::Parameter);
    assert_eq!(find("desired").causality, Causality::Local);
    assert_eq!(find("part_present").start, Some(Start::Whole(1)));
    // `hold` cannot be done twice in a row; `emptying` can.
    assert_eq!(find("operation").start, Some(Start::Whole(3)));
    let camera = laboratory()
        .iter()
        .find(|b| b.machine.name == "QualityCheck")
        .unwrap();
    let heights = camera.unit.interface.find("part.heights[1]").unwrap();
    assert_eq!(heights.limits, Some((0, 2)));
}

/// Names that would break XML, C or a file's path, and duplicate names.
#[test]
fn hostile_names() {
    let (machine, controllers) = fixtures::manipulator();
    let mut hostile = (*machine).clone();
    hostile.name = "../\"<Fräse & Söhne>\" */ ??/ 'x'\u{0}\u{202e}".to_owned();
    hostile.doc = "]]> <script>alert(1)</script> & \"quotes\"\nand lines\u{1b}[31m".to_owned();
    let names = [
        "a\"b",
        "time",
        "<x>",
        "done",
        "total.seconds",
        "ä[0]",
        "enabled",
        "operation",
        "part",
    ];
    for (input, name) in hostile.plant.iter_mut().zip(names) {
        name.clone_into(&mut input.name);
    }
    for (i, component) in hostile.components.iter_mut().enumerate() {
        component.name =
            ["total", "total", "last & least", "</ScalarVariable>", "*/"][i % 5].to_owned();
        let mut specification = (*component.specification).clone();
        for variable in &mut specification.variables {
            if let Domain::Enum { labels, .. } = &mut variable.domain {
                for label in labels.iter_mut() {
                    *label = "<same>".to_owned();
                }
            }
            variable.name = "seconds".to_owned();
        }
        component.specification = Arc::new(specification);
    }
    for property in &mut hostile.properties {
        property.name = "same\"><".to_owned();
        property.unit = "furlong & \"co\"".to_owned();
    }
    for operation in &mut hostile.operations {
        operation.name = "\u{7f}]]>".to_owned();
    }
    let folder = tempfile::tempdir().unwrap();
    let (toolchains, _) = fmi::toolchains();
    let (files, _) = fmi::build(&hostile, &controllers, &toolchains, folder.path()).unwrap();
    for (file, version) in files.iter().zip(Version::ALL) {
        assert_eq!(
            file.parent(),
            Some(folder.path()),
            "the file stays in its folder"
        );
        let unit = Unit::emit(&hostile, &controllers, version);
        let names: BTreeSet<&str> = unit
            .interface
            .variables
            .iter()
            .map(|v| v.name.as_str())
            .collect();
        assert_eq!(names.len(), unit.interface.variables.len());
        let plain = |c: char| c.is_ascii_alphanumeric() || "_.[],".contains(c);
        assert!(names.iter().all(|n| n.chars().all(plain)), "{names:?}");
        let text = file_of(file, "modelDescription.xml").unwrap();
        let mut reader = quick_xml::Reader::from_reader(text.as_slice());
        reader.config_mut().check_end_names = true;
        loop {
            match reader.read_event() {
                Ok(quick_xml::events::Event::Eof) => break,
                Ok(_) => {}
                Err(e) => panic!("{e}: {}", String::from_utf8_lossy(&text)),
            }
        }
        let page = String::from_utf8(file_of(file, "documentation/index.html").unwrap()).unwrap();
        assert!(!page.contains("<script>"));
    }
    if let Some(python) = python_with("fmpy", "fmpy") {
        let script = "import sys\nfrom fmpy.validation import validate_fmu\nfor f in sys.argv[1:]:\n    for p in validate_fmu(f): print(p)\n";
        let path = folder.path().join("validate.py");
        std::fs::write(&path, script).unwrap();
        let mut command = Command::new(python);
        assert_eq!(run(command.arg(&path).args(&files)), "");
    }
}

/// Without a compiler the units are still written, and one finding lists what is missing in all of
/// them.
#[test]
fn a_missing_compiler_is_a_warning() {
    let sandbox = sandbox();
    let build = |variables: &[(&str, &str)]| {
        Command::new(crate::support::PROGRAM)
            .args([
                "build",
                "examples/ice-lab/belt.lw",
                "--target",
                "fmu",
                "--out",
                "units",
            ])
            .current_dir(sandbox.path())
            .env("LINEWRIGHT_CACHE", "off")
            .env("NO_COLOR", "1")
            .envs(variables.iter().copied())
            .output()
            .expect("the program starts")
    };
    let output = build(&[("PATH", "nowhere")]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert_eq!(said.matches("warning[LW530]").count(), 2, "{said}");
    assert!(
        said.contains("no binary for Windows") && said.contains("no binary for this computer"),
        "{said}"
    );
    assert!(said.contains("apt"), "{said}");
    for name in ["belt_fmi2.fmu", "belt_fmi3.fmu"] {
        let names = names(&std::fs::read(sandbox.path().join("units").join(name)).unwrap());
        assert!(
            names.iter().all(|n| !n.starts_with("binaries/")),
            "{names:?}"
        );
        assert!(names.contains(&"sources/belt.c".to_owned()), "{names:?}");
    }
    // A failing compiler is an error.
    let output = build(&[("CC", "false")]);
    assert_eq!(output.status.code(), Some(2));
    let json = linewright(
        sandbox.path(),
        &[
            "build",
            "examples/ice-lab/belt.lw",
            "--target",
            "fmu",
            "--format",
            "json",
        ],
    );
    let document: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(document["libraries"][0]["target"], "fmu");
    assert_eq!(
        document["libraries"][0]["files"].as_array().map(Vec::len),
        Some(2)
    );
}

/// A unit without binaries, and one for both systems, differ in nothing else.
#[test]
fn binaries_are_put_where_they_belong() {
    let (machine, controllers) = fixtures::belt();
    for version in Version::ALL {
        let unit = Unit::emit(&machine, &controllers, version);
        let bare = names(&unit.archive(&[]));
        let both = unit.archive(&[(Platform::Host, vec![1]), (Platform::Windows, vec![2])]);
        let both = names(&both);
        let added: Vec<&String> = both.iter().filter(|n| !bare.contains(n)).collect();
        assert_eq!(added.len(), 2);
        assert!(added.contains(&&binary_name(&unit, true)), "{added:?}");
        assert_eq!(
            unit.package.stem,
            Package::emit(&machine, &controllers).stem
        );
    }
    assert!(root().join("ffi/fmi.c").is_file());
}
