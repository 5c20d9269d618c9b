//! Variables, labels and specifications named by reserved words: of Linewright's language, and of
//! every format that is read or written.

use super::equivalence::{Layout, prove};
use super::{TARGETS, support, there_and_back};
use crate::support::games::reload;
use linewright::diagnostics::has_errors;
use linewright::gr1::{Domain, Expr, Formula, Owner, Side, Specification, Timing, VarId, Variable};
use linewright::interchange::{Format, Target, contract, read, write};
use linewright::source::{FileId, Span};
use linewright::syntax;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

/// Every quoted word in the grammar of contracts and in the readers and writers of the formats: the
/// words that names are compared with, and many more.
fn words() -> Vec<String> {
    let mut texts = vec![text("crates/syntax/src/lw.pest")];
    gather(&support::root().join("crates/interchange/src"), &mut texts);
    let mut found: BTreeSet<String> = BTreeSet::new();
    for piece in texts.iter().flat_map(|t| t.split('"')) {
        let begins = piece.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if begins && piece.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            found.insert(piece.to_owned());
        }
    }
    assert!(syntax::reserved_words().all(|w| found.contains(w)));
    assert!(found.len() > 250, "only {}", found.len());
    found.into_iter().collect()
}

fn text(path: &str) -> String {
    std::fs::read_to_string(support::root().join(path)).expect("a text")
}

fn gather(folder: &Path, texts: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            gather(&path, texts);
        } else {
            texts.push(std::fs::read_to_string(&path).expect("a text"));
        }
    }
}

/// A file of a format with outputs of these names, each with a formula in every place where the
/// format has formulas.
fn file(format: Format, words: &[&str]) -> String {
    let each = |separator: &str, line: &dyn Fn(&str) -> String| {
        let lines: Vec<String> = words.iter().map(|w| line(w)).collect();
        lines.join(separator)
    };
    match format {
        Format::Spc => format!(
            "ENV: e__;\nSYS: {};\nENVINIT: ;\nENVTRANS: ;\nENVGOAL: []<>e__;\nSYSINIT: {};\nSYSTRANS: {};\nSYSGOAL: {};\n",
            each(" ", &str::to_owned),
            each(" & ", &|w| format!("(!{w} | e__)")),
            each(" & ", &|w| format!("[](e__ -> ({w}' | {w}))")),
            each(" & ", &|w| format!("[]<>({w} & e__)")),
        ),
        Format::Slugsin => format!(
            "[INPUT]\ne__\n[OUTPUT]\n{}\n[SYS_INIT]\n{}\n[SYS_TRANS]\n{}\n[SYS_LIVENESS]\n{}\n",
            each("\n", &str::to_owned),
            each("\n", &|w| format!("| ! {w} e__")),
            each("\n", &|w| format!("| ! e__ | {w}' {w}")),
            each("\n", &|w| format!("& {w} e__")),
        ),
        Format::StructuredSlugs => format!(
            "[INPUT]\ne__\n[OUTPUT]\n{}\n[SYS_INIT]\n{}\n[SYS_TRANS]\n{}\n[SYS_LIVENESS]\n{}\n",
            each("\n", &|w| format!("{w}: 0...2")),
            each("\n", &|w| format!("{w} = 0 | e__")),
            each("\n", &|w| format!("e__ -> ({w}' >= 1 | {w} = 2)")),
            each("\n", &|w| format!("{w} = 1 & e__")),
        ),
        Format::Spectra => format!(
            "spec {}\nenv boolean e__;\n{}\n",
            words.first().unwrap_or(&"s"),
            each("\n", &|w| format!(
                "sys boolean {w};\ngar ini !{w} | e__;\ngar G e__ -> (next({w}) | {w});\ngar GF {w} & e__;"
            )),
        ),
        Format::Tlsf => format!(
            "INFO {{ TITLE: \"t\" DESCRIPTION: \"\" SEMANTICS: Mealy,Strict TARGET: Mealy }}\nMAIN {{ INPUTS {{ e__; }} OUTPUTS {{ {} }}\n\
             INITIALLY {{ }} PRESET {{ {} }} ASSERT {{ {} }} GUARANTEE {{ {} }} }}\n",
            each(" ", &|w| format!("{w};")),
            each(" ", &|w| format!("! {w} || e__;")),
            each(" ", &|w| format!("e__ -> (X {w} || {w});")),
            each(" ", &|w| format!("G F ({w} && e__);")),
        ),
    }
}

fn accepted(format: Format, words: &[&str]) -> Option<Specification> {
    let text = file(format, words);
    let reading = read(format, "test", FileId(0), &text);
    assert_eq!(
        reading.specification.is_some(),
        !has_errors(&reading.findings)
    );
    reading.specification
}

/// A file with reserved words as variable names is printed as a contract that is the same game.
#[test]
fn words_as_names_are_imported_from_every_format() {
    let words = words();
    let mut counts = String::new();
    for format in Format::ALL {
        assert!(accepted(format, &["plain"]).is_some(), "{format:?}");
        let taken: Vec<&str> = words.iter().map(String::as_str).collect();
        let taken: Vec<&str> = taken
            .into_iter()
            .filter(|word| accepted(format, &[word]).is_some())
            .collect();
        for some in taken.chunks(40) {
            let specification = accepted(format, some)
                .unwrap_or_else(|| panic!("{format:?}: taken alone, not together: {some:?}"));
            let printed = contract::write(&specification, "a test");
            if let Err(what) = prove(&specification, &reload(&printed), Layout::Same) {
                panic!("{format:?}: {what}\n{printed}");
            }
        }
        // Each alone, with the specification named by the word as well.
        for word in &taken {
            let mut specification = accepted(format, &[word]).expect("it was taken before");
            (*word).clone_into(&mut specification.name);
            let printed = contract::write(&specification, word);
            assert_eq!(
                reload(&printed).variables.len(),
                specification.variables.len(),
                "{printed}"
            );
        }
        let reserved = syntax::reserved_words()
            .filter(|w| taken.contains(w))
            .count();
        let _ = writeln!(
            counts,
            "{format:?}: {} taken, {reserved} of ours",
            taken.len()
        );
        assert!(reserved > 10, "{format:?}: only {reserved} of ours");
    }
    println!("{counts}");
}

/// Variables and labels named by reserved words are written in each format and read as the same
/// game; also printed as a contract.
#[test]
fn words_as_names_are_written_in_every_format() {
    let words = words();
    for (at, some) in words.chunks(24).enumerate() {
        let specification = specification(some, &words[at % words.len()]);
        let printed = contract::write(&specification, "a test");
        if let Err(what) = prove(&specification, &reload(&printed), Layout::Same) {
            panic!("{what}\n{printed}");
        }
        for target in TARGETS {
            there_and_back(&specification, target);
        }
    }
}

/// A name that the format does not allow is replaced, but by no name that another variable has.
#[test]
fn replaced_names_remain_unique() {
    let names = ["True", "a", "x@1", "x_1", "h[2]", "True_", "7", "ü."];
    let labels = ["l1", "l2", "l3", "l4", "l5", "l6", "l7", "l8"];
    let words = names.iter().chain(&labels).map(|w| (*w).to_owned());
    let specification = specification(&words.collect::<Vec<_>>(), "Replaced");
    let written = write(&specification, Target::Spc).expect("a file");
    let outputs = written.lines().find_map(|line| line.strip_prefix("SYS: "));
    let outputs: Vec<&str> = outputs.expect("a line").split(' ').take(8).collect();
    let replaced = ["True_2", "a", "x_1_", "x_1", "h_2", "True_", "v_7", "v_"];
    assert_eq!(outputs, replaced);
}

/// Half of the words are Booleans of either side, the other half labels.
fn specification(words: &[String], name: &str) -> Specification {
    let span = Span::new(FileId(0), 0, 0);
    let (names, labels) = words.split_at(words.len() / 2);
    let mut variables: Vec<Variable> = Vec::new();
    let mut guarantees = Side::default();
    let mut add = |name: &str, domain: Domain, owner: Owner| {
        variables.push(Variable {
            name: name.to_owned(),
            owner,
            internal: false,
            domain,
            unit: String::new(),
            span,
        });
        VarId(variables.len() as u32 - 1)
    };
    let formula = |name: &str, expr: Expr| Formula {
        defines: false,
        name: name.to_owned(),
        requirement: None,
        expr,
        span,
        text: name.to_owned(),
    };
    let input = add("e__", Domain::Bool, Owner::Environment);
    for name in names {
        let v = add(name, Domain::Bool, Owner::System);
        let moved = Expr::next(v).or(Expr::now(v));
        guarantees
            .safety
            .push(formula("step", Expr::now(input).not().or(moved)));
        guarantees
            .justice
            .push(formula(name, Expr::now(v).and(Expr::now(input))));
    }
    for (number, labels) in labels.chunks(4).enumerate() {
        let domain = Domain::Enum {
            name: Some(format!("Labels{number}")),
            labels: labels.to_vec(),
        };
        let v = add(&format!("label__{number}"), domain, Owner::System);
        for value in 0..labels.len() as i64 {
            let is = Expr::now(v).equals(Expr::Const(value));
            guarantees
                .justice
                .push(formula(&labels[value as usize], is));
        }
    }
    Specification {
        name: name.to_owned(),
        timing: Timing::Mealy,
        variables,
        assumptions: Side::default(),
        guarantees,
    }
}
