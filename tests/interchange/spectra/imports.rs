//! Files that import others: what is included, how names are resolved, and the messages on failure.

use linewright::diagnostics::{Diagnostic, Severity, codes, render};
use linewright::gr1::Specification;
use linewright::interchange::{Format, Reading, read, read_with};
use linewright::source::{FileId, SourceMap};
use std::sync::Arc;

/// Reads the first of some files, which may import the others by name.
fn read_files(files: &[(&str, &str)]) -> (Reading, SourceMap) {
    let mut sources = SourceMap::new();
    for (name, text) in files {
        sources.add(*name, *text);
    }
    let root = FileId(0);
    let text = Arc::clone(&sources.file(root).text);
    let reading = read_with(Format::Spectra, "test", root, &text, &mut |path, _| {
        let found = sources.files().find(|(_, file)| file.name == path);
        let (id, file) = found.ok_or("there is no such file")?;
        Ok((id, Arc::clone(&file.text)))
    });
    (reading, sources)
}

fn shown(reading: &Reading, sources: &SourceMap) -> String {
    let text = render::human(sources, &reading.findings);
    anstream::adapter::strip_str(&text).to_string()
}

/// The specification of some files, which must have no errors.
fn specification(files: &[(&str, &str)]) -> Specification {
    let (reading, sources) = read_files(files);
    let shown = shown(&reading, &sources);
    assert!(reading.findings.is_empty(), "{shown}");
    reading.specification.expect("no finding")
}

/// Checks that some files mean the same as one text: equal formulas, one by one.
fn same(files: &[(&str, &str)], text: &str) {
    let theirs = specification(files);
    let reading = read(Format::Spectra, "test", FileId(0), text);
    let ours = reading.specification.expect("it is right");
    for (a, b) in [
        (&theirs.assumptions, &ours.assumptions),
        (&theirs.guarantees, &ours.guarantees),
    ] {
        let lists = |side: &linewright::gr1::Side| {
            let lists = [&side.initial, &side.invariants, &side.safety, &side.justice];
            lists.map(|l| l.iter().map(|f| f.expr.clone()).collect::<Vec<_>>())
        };
        assert_eq!(lists(a), lists(b), "{text}");
    }
}

fn errors(reading: &Reading) -> Vec<&Diagnostic> {
    let findings = reading.findings.iter();
    findings.filter(|f| f.severity == Severity::Error).collect()
}

const RULES: &str = "spec Rules\ntype Door = {open, shut};\ndefine limit := 2;\nnear := limit - 1;\n\
    predicate moves(Door d): next(d) != d;\npredicate small(Int(0..limit) n): n <= near;\n\
    pattern recurs(p) { var boolean seen; seen; G next(seen) <-> p; GF seen; }\nregexp twice := [true]{2};\n";

#[test]
fn definitions_are_imported_with_the_names_of_their_own_file() {
    let file = "import \"rules.spectra\"\nspec t\nenv Door door;\nsys Int(0..limit) n;\ndefine near := 0;\n\
        gar G moves(door) -> small(n);\nasm recurs(door = open);\ngar trig twice |=> [n = near];\n";
    // `near` is 1 in the imported predicate and 0 here.
    let alone = "spec t\ntype Door = {open, shut};\nenv Door door;\nsys Int(0..2) n;\n\
        pattern recurs(p) { var boolean seen; seen; G next(seen) <-> p; GF seen; }\n\
        gar G next(door) != door -> n <= 2 - 1;\nasm recurs(door = open);\ngar trig [true]{2} |=> [n = 0];\n";
    same(&[("t.spectra", file), ("rules.spectra", RULES)], alone);
}

#[test]
fn a_files_own_names_go_before_imported_ones_and_the_first_import_before_the_second() {
    let file = "import \"a.spectra\"\nimport \"b.spectra\"\nspec t\nenv boolean x;\ndefine one := x;\nsys boolean two;\ngar G one & two & three;\n";
    let a = "spec a\ndefine one := false;\ntwo := false;\nthree := 1 < 2;\n";
    let b = "spec b\ndefine three := false;\n";
    same(
        &[("t.spectra", file), ("a.spectra", a), ("b.spectra", b)],
        "spec t\nenv boolean x;\nsys boolean two;\ngar G x & two & 1 < 2;\n",
    );
}

#[test]
fn files_may_import_one_another_and_one_file_twice() {
    let file = "import \"a.spectra\"\nimport \"b.spectra\"\nspec t\nenv boolean x;\ngar G low(x) | high(x);\n";
    let a =
        "import \"b.spectra\"\nimport \"t.spectra\"\nspec a\npredicate low(boolean p): !high(p);\n";
    let b = "import \"a.spectra\"\nspec b\npredicate high(boolean p): p;\n";
    same(
        &[("t.spectra", file), ("a.spectra", a), ("b.spectra", b)],
        "spec t\nenv boolean x;\ngar G !x | x;\n",
    );
    // What a file imports is not passed on to its importers.
    let file = "import \"a.spectra\"\nspec t\nenv boolean x;\ngar G high(x);\n";
    let (reading, sources) = read_files(&[("t.spectra", file), ("a.spectra", a), ("b.spectra", b)]);
    let shown = shown(&reading, &sources);
    assert_eq!(reading.findings.len(), 1, "{shown}");
    assert_eq!(reading.findings[0].code, codes::NAME_UNKNOWN, "{shown}");
}

#[test]
fn a_definition_that_uses_itself_through_two_files_is_found() {
    let file = "import \"a.spectra\"\nspec t\nenv boolean x;\npredicate high(boolean p): low(p);\ngar G high(x);\n";
    let a = "import \"t.spectra\"\nspec a\npredicate low(boolean p): high(p);\n";
    let (reading, sources) = read_files(&[("t.spectra", file), ("a.spectra", a)]);
    assert!(shown(&reading, &sources).contains("is defined in terms of itself"));
}

#[test]
fn published_patterns_are_there_without_their_file_and_read_from_it() {
    let file = "import \"../patterns/DwyerPatterns.spectra\"\nspec t\nenv boolean a;\nenv boolean b;\ngar pRespondsToS(a, b);\n";
    let alone = specification(&[("t.spectra", file)]);
    assert_eq!(alone.guarantees.justice.len(), 1);
    let theirs = "spec DwyerPatterns\npattern pRespondsToS(p, s) { G p -> s; }\n";
    let read = specification(&[
        ("t.spectra", file),
        ("../patterns/DwyerPatterns.spectra", theirs),
    ]);
    assert!(read.guarantees.justice.is_empty());
    assert_eq!(read.guarantees.safety.len(), 1);
}

#[test]
fn messages_about_imports() {
    let files = [
        (
            "t.spectra",
            "import \"rules.spectra\"\nimport \"missing/Utils.spectra\"\nimport \"notes.txt\"\nspec Test\nenv boolean x;\nsys boolean y;\n\
             gar G allowed(x);\ngar G unknown(y);\ngar G count = 2;\ngar wrong(x, y);\n",
        ),
        (
            "rules.spectra",
            "spec Rules\nenv boolean lamp;\ncounter count(0..3) { count = 0; inc: lamp; }\npredicate allowed(boolean p): p -> lamp;\n\
             pattern wrong(p, q) { G p + q; }\ngar G lamp;\ndefine broken := ;\n",
        ),
    ];
    let (reading, sources) = read_files(&files);
    assert!(reading.findings.iter().all(|f| f.help.is_some()));
    let all = shown(&reading, &sources);
    // Without the errors that hide their consequences.
    let repaired = [
        (
            files[0].0,
            files[0].1.replace(
                "import \"missing/Utils.spectra\"\nimport \"notes.txt\"\n",
                "",
            ),
        ),
        (files[1].0, files[1].1.replace("define broken := ;\n", "")),
    ];
    let repaired: Vec<(&str, &str)> = repaired.iter().map(|(n, t)| (*n, t.as_str())).collect();
    let (reading, sources) = read_files(&repaired);
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        insta::assert_snapshot!(
            "imports",
            format!("{all}\n--- repaired ---\n{}", shown(&reading, &sources))
        );
    });
}

#[test]
fn the_number_of_imported_files_is_limited() {
    let chain = |count: usize| {
        let file = |n: usize| {
            let import = format!("import \"{}.spectra\"\n", n + 1);
            let import = if n + 1 < count { import } else { String::new() };
            (
                format!("{n}.spectra"),
                format!("{import}spec t\nsys boolean x;\n"),
            )
        };
        let files: Vec<(String, String)> = (0..count).map(file).collect();
        let files: Vec<(&str, &str)> = files
            .iter()
            .map(|(n, t)| (n.as_str(), t.as_str()))
            .collect();
        let (reading, _) = read_files(&files);
        errors(&reading).len()
    };
    assert_eq!(chain(65), 0);
    assert_eq!(chain(66), 1);
    assert_eq!(chain(200), 1);
    let missing = "import \"missing.spectra\"\n".repeat(20_000);
    let file = format!("{missing}spec t\nsys boolean x;\n");
    let (reading, _) = read_files(&[("t.spectra", &file)]);
    assert_eq!(errors(&reading).len(), 64);
}
