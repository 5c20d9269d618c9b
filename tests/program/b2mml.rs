//! B2MML documents on the command line: layouts and recipes that are imported, plans that are
//! written, and what is refused.

mod models;

use crate::support::mesa::Validator;
use crate::support::{linewright, root, sandbox};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Runs the program. Returns the exit code and both streams.
fn run(folder: &Path, line: &str) -> (i32, String, String) {
    let arguments: Vec<&str> = line.split_whitespace().collect();
    let output = linewright(folder, &arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let code = output.status.code().expect("an exit code");
    (code, text(&output.stdout), text(&output.stderr))
}

/// Name, verdict and worst case of each statement of a check.
fn verdicts(folder: &Path, file: &str) -> Vec<[Value; 3]> {
    let (_, text, errors) = run(folder, &format!("check {file} --format json"));
    let document: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e} {errors}"));
    let entries = document["realizations"].as_array().expect("realizations");
    let fields = ["name", "verdict", "worst_case"];
    let verdict = |e: &Value| fields.map(|field| e[field].clone());
    entries.iter().map(verdict).collect()
}

/// A document with a root and what it contains.
fn document(root: &str, content: &str) -> String {
    let namespace = linewright::b2mml::NAMESPACE;
    format!("<{root} xmlns=\"{namespace}\">\n{content}\n</{root}>\n")
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("a file can be written");
}

#[test]
fn plans_are_written_and_imported_again() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let all = folder.join("all");
    std::fs::create_dir(&all).expect("a folder");
    for (file, name) in [
        ("examples/pad/hinge.lw", "Hinge-on-Pad"),
        ("examples/pad/six.lw", "Hinge-on-Six"),
        ("examples/smc/nine.lw", "Violet-on-Nine"),
        ("examples/smc/ten.lw", "Violet-on-Ten"),
    ] {
        let (code, text, remarks) = run(
            folder,
            &format!("recipe plan {file} --emit b2mml --out {name}"),
        );
        assert_eq!((code, text.as_str()), (0, ""), "{remarks}");
        let kinds = ["equipment", "definition", "workflow", "schedule"];
        let files = kinds.map(|kind| format!("{name}/{name}.{kind}.xml"));
        for file in &files {
            assert!(remarks.contains(&format!("wrote {file}\n")), "{remarks}");
            let to = all.join(Path::new(file).file_name().expect("a name"));
            std::fs::copy(folder.join(file), to).expect("a copy");
        }
        // The schedule is left out: its recipe is defined.
        let all = files.join(" ");
        let (code, _, remarks) = run(folder, &format!("import {all} --out {name}.lw"));
        assert_eq!(code, 0, "{remarks}");
        assert!(
            remarks.contains("note[LW621]: the order of this schedule is left out"),
            "{remarks}"
        );
        let verdict = verdicts(folder, &format!("{name}.lw"));
        assert_eq!(verdict.len(), 1);
        assert_eq!(verdict[0][0], name.replace('-', " "));
        assert!(verdicts(folder, file).contains(&verdict[0]), "{verdict:?}");
        let (code, _, _) = run(folder, &format!("fmt --check {name}.lw"));
        assert_eq!(code, 0);
        // The recipe is the same from each of its documents.
        for kind in [1, 2] {
            let pair = format!("{} {}", files[0], files[kind]);
            let (code, text, remarks) = run(folder, &format!("import {pair}"));
            assert_eq!((code, remarks.as_str()), (0, ""));
            let imported = std::fs::read_to_string(folder.join(format!("{name}.lw")));
            let imported = imported.expect("a text");
            let body = |text: &str| text.split_once('\n').map(|(_, body)| body.to_owned());
            assert_eq!(body(&text), body(&imported));
        }
    }
    for name in ["cell.xml", "order.xml"] {
        let from = root().join("examples/b2mml").join(name);
        std::fs::copy(from, all.join(name)).expect("a copy");
    }
    if let Some(validator) = Validator::find(root()) {
        let (valid, reasons) = validator.valid(&all, true);
        let files = std::fs::read_dir(&all).expect("a folder");
        let names = files.map(|f| f.expect("a file").file_name());
        let names: BTreeSet<String> = names.map(|n| n.to_string_lossy().into_owned()).collect();
        assert_eq!(names.len(), 18);
        assert_eq!(valid, names, "{reasons}");
    }
}

#[test]
fn what_cannot_be_made_has_no_documents() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let (code, _, errors) = run(
        folder,
        "recipe plan examples/pad/missing-route.lw --emit b2mml --out documents --format short",
    );
    assert_eq!(code, 1);
    assert!(errors.contains("error[LW609]"), "{errors}");
    assert!(!folder.join("documents").exists());
    let (code, _, errors) = run(folder, "recipe plan examples/pad/hinge.lw --emit b2mml");
    assert_eq!(code, 2);
    assert!(errors.contains("--out <DIR>"), "{errors}");
}

/// The order of a schedule without choices is a recipe.
#[test]
fn schedules_are_sequences() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let order = "import examples/b2mml/cell.xml examples/b2mml/order.xml --out order.lw";
    assert_eq!(run(folder, order).0, 0);
    let plan = "recipe plan order.lw --emit b2mml --out plan";
    assert_eq!(run(folder, plan).0, 0);
    let pair = "plan/Cover-on-Cell_4.equipment.xml plan/Cover-on-Cell_4.schedule.xml";
    let (code, _, remarks) = run(folder, &format!("import {pair} --out again.lw"));
    assert_eq!((code, remarks.as_str()), (0, "wrote again.lw\n"));
    assert_eq!(verdicts(folder, "again.lw"), verdicts(folder, "order.lw"));

    let plan = "recipe plan examples/pad/hinge.lw --emit b2mml --out plan";
    assert_eq!(run(folder, plan).0, 0);
    let (code, text, errors) = run(
        folder,
        "import plan/Hinge-on-Pad.schedule.xml --format short",
    );
    assert_eq!((code, text.as_str()), (2, ""));
    let wanted = "plan/Hinge-on-Pad.schedule.xml:2:1: error[LW620]: the schedule has the choices of recipe `Hinge`";
    assert!(errors.starts_with(wanted), "{errors}");
}

#[test]
fn all_findings_of_all_documents_are_reported() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let performance = linewright::b2mml::Performance {
        name: "Monday".to_owned(),
        records: vec![linewright::b2mml::Record {
            activity: linewright::b2mml::Activity::Internal {
                resource: "robot".to_owned(),
                name: "turn".to_owned(),
            },
            recipe: "Hinge".to_owned(),
            product: "Hinge 1".to_owned(),
            request: None,
            begin: 0.0,
            end: 1.0,
        }],
        ..linewright::b2mml::Performance::default()
    };
    let run_text = linewright::b2mml::write::performance(&performance).expect("it has a record");
    write(folder, "run.xml", &run_text);
    write(
        folder,
        "old.xml",
        "<OperationsSchedule xmlns=\"http://www.mesa.org/xml/B2MML-V0600\"/>",
    );
    let wrong =
        "<PublishedDate>yesterday</PublishedDate>\n<Equipment><ID>saw</ID><Robot/></Equipment>";
    let text = format!("\u{feff}{}", document("EquipmentInformation", wrong));
    write(folder, "wrong.xml", &text);
    std::fs::write(folder.join("bytes.xml"), b"<a>\n\xff</a>").expect("a file");
    let full = "<ID>Cell</ID><Equipment><ID>saw</ID><EquipmentProperty><ID>Capacity</ID><Value>\
                <ValueString>20000</ValueString></Value></EquipmentProperty></Equipment>";
    write(folder, "full.xml", &document("EquipmentInformation", full));
    let files = "run.xml old.xml wrong.xml bytes.xml full.xml missing.xml";
    let (code, text, errors) = run(folder, &format!("import {files} --format short --out x.lw"));
    assert_eq!((code, text.as_str()), (2, ""));
    assert!(!folder.join("x.lw").exists());
    for wanted in [
        "error[LW001]: missing.xml cannot be read: there is no such file",
        "run.xml:2:1: error[LW620]: this OperationsPerformance says what the run `Monday` did",
        "old.xml:1:1: error[LW620]: version: this is a document of B2MML 6; B2MML 7 is read",
        "wrong.xml:2:1: error[LW620]: structure: `EquipmentInformation` needs `ID` before this",
        "wrong.xml:2:1: error[LW620]: value: `PublishedDate` is not a date and time",
        "wrong.xml:3:24: error[LW620]: structure: `Equipment` cannot contain `Robot`",
        "bytes.xml:2:1: error[LW620]: encoding: the document is not UTF-8 from here on",
        "full.xml:1:1: error[LW620]: `saw` has room for 20000 parts",
    ] {
        assert!(
            errors.lines().any(|l| l.starts_with(wanted)),
            "{wanted}\n{errors}"
        );
    }
    let (code, text, _) = run(folder, &format!("import {files} --format json"));
    let document: Value = serde_json::from_str(&text).expect("a document");
    let findings = document["findings"].as_array().expect("findings");
    assert_eq!((code, findings.len()), (2, 8), "{text}");
    assert!(findings.iter().all(|f| f["help"].is_string()), "{text}");
}

#[test]
fn other_uses_of_documents_are_refused() {
    let sandbox = sandbox();
    let folder = sandbox.path();
    let (cell, order) = ("examples/b2mml/cell.xml", "examples/b2mml/order.xml");
    let before = std::fs::read(folder.join(order)).expect("a file");
    let (code, _, errors) = run(folder, &format!("import {cell} {order} --out {order}"));
    assert_eq!(code, 2);
    assert!(errors.contains("it is a source of this result"), "{errors}");
    assert_eq!(std::fs::read(folder.join(order)).expect("a file"), before);
    let (code, _, errors) = run(
        folder,
        &format!("import {cell} examples/other-tools/arbiter.spc"),
    );
    assert_eq!(code, 2);
    assert!(
        errors.contains("only documents in B2MML (.xml) are imported together"),
        "{errors}"
    );
    let (code, text, _) = run(folder, &format!("check {cell}"));
    assert_eq!(code, 2);
    assert!(text.contains("`linewright import` converts it"), "{text}");
}
