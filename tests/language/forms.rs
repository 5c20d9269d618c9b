//! The forms suggested by LW201 are accepted in its place:
//! `tests/cases/resolve/outside_gr1_shapes.lw`, formula by formula.
//!
//! A test beside them checks their meaning, `crates/language/src/contract/formula/forms/tests.rs`.

use linewright::contract::load;
use linewright::diagnostics::{Diagnostic, codes};
use linewright::syntax::ast::{ContractItem, Item};
use linewright::syntax::parse;
use std::fmt::Write as _;
use std::path::Path;

fn findings(text: &str) -> Vec<Diagnostic> {
    let none = |path: &str, _: &str| Err(format!("{path} is not needed"));
    load(&[("forms.lw".to_owned(), text.to_owned())], &none).1
}

/// Texts in backquotes that are items of a contract.
fn items(help: &str) -> Vec<String> {
    let quoted = help.split('`').skip(1).step_by(2);
    let item = |t: &&str| {
        ["internal ", "assume ", "guarantee "]
            .iter()
            .any(|w| t.starts_with(w))
    };
    quoted.filter(item).map(str::to_owned).collect()
}

#[test]
fn what_is_suggested_is_accepted() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/resolve/outside_gr1_shapes.lw");
    let text = std::fs::read_to_string(path).expect("a case");
    let (file, found) = parse(linewright::source::FileId::default(), &text);
    assert_eq!(found, []);
    let all = findings(&text);
    let (mut with_form, mut without) = (0, Vec::new());
    for item in &file.items {
        let Item::Contract(contract) = item else {
            continue;
        };
        let mut declarations = String::new();
        for item in &contract.items {
            if let ContractItem::Variables {
                names,
                domain,
                ownership,
            } = item
            {
                let names: Vec<&str> = names.iter().map(|n| n.text.as_str()).collect();
                let domain = &text[domain.span.start as usize..domain.span.end as usize];
                let word = format!("{ownership:?}").to_lowercase();
                let _ = writeln!(declarations, "    {word} {}: {domain}", names.join(", "));
            }
        }
        for item in &contract.items {
            let ContractItem::Formula { expr, .. } = item else {
                continue;
            };
            let own: Vec<&Diagnostic> = all
                .iter()
                .filter(|f| {
                    f.span
                        .is_some_and(|s| expr.span.start <= s.start && s.end <= expr.span.end)
                })
                .collect();
            let [finding] = own.as_slice() else {
                panic!("{own:#?}");
            };
            assert_eq!(finding.code, codes::NOT_GR1);
            let help = finding.help.as_deref().unwrap_or_default();
            let items = items(help);
            if items.is_empty() {
                without.push(contract.header.name.text.clone());
                continue;
            }
            with_form += 1;
            let mended = format!(
                "contract A {{\n{declarations}    {}\n}}\n",
                items.join("\n    ")
            );
            let found = findings(&mended);
            let wrong: Vec<&Diagnostic> =
                found.iter().filter(|f| f.code != codes::UNUSED).collect();
            assert!(wrong.is_empty(), "{help}\n{mended}{wrong:#?}");
        }
    }
    assert!(with_form > 40, "{with_form}");
    // Only cases that show that some have none.
    assert!(
        without.iter().all(|c| c == "Formless") && without.len() == 6,
        "{without:?}"
    );
}
