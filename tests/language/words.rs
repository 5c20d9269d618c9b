//! The table of reserved words compared with the rules of the grammar.

use linewright::source::FileId;
use linewright::syntax::{parse, reserved_words};
use std::collections::BTreeSet;

/// The quoted words of a rule of the grammar.
fn words_of(rule: &str) -> BTreeSet<&'static str> {
    let grammar = include_str!("../../crates/syntax/src/lw.pest");
    let head = format!("\n{rule} ");
    let (_, body) = grammar.split_once(&head).expect("a rule");
    let (body, _) = body.split_once("~ end").expect("words end");
    body.split('"').skip(1).step_by(2).collect()
}

#[test]
fn the_table_holds_what_the_grammar_reserves() {
    let table: BTreeSet<&str> = reserved_words().collect();
    assert_eq!(table, words_of("reserved"));
    assert_eq!(
        table.len(),
        reserved_words().count(),
        "a word appears there twice"
    );
}

/// Among skills, the letters of temporal operators are names, and the other words are not.
#[test]
fn letters_of_temporal_operators_name_skills() {
    let names = reserved_words().filter(|word| {
        let text = format!(
            "skills S {{\n    component c: {{a}} = a {{\n        {word} -> a\n    }}\n}}\n"
        );
        parse(FileId::default(), &text).1.is_empty()
    });
    assert_eq!(names.collect::<BTreeSet<_>>(), words_of("temporal_letter"));
}
