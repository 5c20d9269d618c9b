//! Files with errors: all of them are reported at once, each with a remedy; and no text is fatal.

use super::bench::shown;
use crate::support;
use linewright::interchange::{Format, Reading, read};
use linewright::source::FileId;
use proptest::prelude::*;
use std::fmt::Write as _;

fn read_text(text: &str) -> Reading {
    read(Format::Spectra, "test", FileId(0), text)
}

#[test]
fn messages_as_a_person_reads_them() {
    let folder = support::root().join("tests/interchange/spectra/bad");
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    assert!(paths.len() >= 15);
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for path in paths {
            let text = std::fs::read_to_string(&path).expect("a text");
            let reading = read_text(&text);
            assert!(reading.findings.iter().all(|f| f.help.is_some()));
            assert!(!reading.findings.is_empty(), "{}", path.display());
            let name = path.file_stem().expect("a name").to_string_lossy();
            insta::assert_snapshot!(name.to_string(), shown(&reading, &text));
        }
    });
}

const WORDS: [&str; 96] = [
    "spec",
    "t",
    "module",
    "import",
    "\"DwyerPatterns.spectra\"",
    "type",
    "env",
    "sys",
    "aux",
    "in",
    "out",
    "boolean",
    "Int",
    "(",
    "0",
    "..",
    "3",
    ")",
    "{",
    "}",
    "[",
    "]",
    "a",
    "b",
    "c",
    "p",
    "q",
    "x",
    ";",
    ";",
    ";",
    "=",
    ":=",
    "define",
    "predicate",
    "pattern",
    "var",
    "monitor",
    "counter",
    "inc",
    "dec",
    "reset",
    ":",
    "overflow",
    "keep",
    "modulo",
    "false",
    "true",
    "gar",
    "asm",
    "G",
    "GF",
    "alw",
    "ini",
    "trans",
    "next",
    "PREV",
    "ONCE",
    "H",
    "SINCE",
    "T",
    "&",
    "|",
    "!",
    "->",
    "<->",
    "xor",
    "iff",
    "!=",
    "<",
    "<=",
    "+",
    "-",
    "*",
    "/",
    "mod",
    "forall",
    "exists",
    ".",
    "not",
    "regexp",
    "trig",
    "|=>",
    "~",
    "?",
    "+",
    "*",
    ",",
    "()",
    "pRespondsToS",
    "weight",
    "regtest",
    "GE",
    "all",
    "-- x\n",
    "9999999999999999999",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn soups_of_words_are_survived(words in prop::collection::vec(prop::sample::select(WORDS.to_vec()), 0..60)) {
        read_text(&words.join(" "));
    }

    #[test]
    fn texts_with_words_exchanged_are_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(WORDS.to_vec())), 1..6)
    ) {
        let text = "import \"DwyerPatterns.spectra\" spec t type C = { a , b } ; env Int ( 0 .. 3 ) x ; env boolean [ 3 ] p ; \
            sys C c ; define q := c = a & x < 2 ; predicate r ( C d ) : d = a | next ( p [ x mod 3 ] ) ; \
            pattern s ( e ) { var boolean f ; ! f ; G next ( f ) <-> e ; GF f ; } \
            monitor Int ( 0 .. 3 ) m { m = 0 ; G next ( m ) = x ; } counter n ( 0 .. 3 ) { n = 0 ; inc : q ; overflow : keep ; } \
            gar G r ( c ) -> PREV ( q SINCE p . any ) ; asm s ( next ( q ) ) ; gar pRespondsToS ( q , ! q ) ; \
            gar trig [ q ] + |=> true * [ p [ 0 ] ] { 1 , 3 } ; gar k { C d } : GF c = d ; gar forall i in Int ( 0 .. 2 ) . s ( p [ i ] ) ;";
        prop_assert!(read_text(text).findings.is_empty(), "{}", shown(&read_text(text), text));
        let mut words: Vec<&str> = text.split(' ').collect();
        for (index, word) in changes {
            *index.get_mut(&mut words) = word;
        }
        read_text(&words.join(" "));
    }

    #[test]
    fn any_text_is_survived(text in "\\PC{0,80}") {
        read_text(&text);
        read_text(&format!("spec t env boolean a; gar G {text};"));
    }
}

#[test]
fn depth_and_length_are_bounded() {
    let head = "spec t\nenv boolean a;\nsys boolean b;\n";
    let of = |formula: String| read_text(&format!("{head}gar G {formula};\ngar G b;\n"));
    let nested = |open: &str, n: usize, close: &str| of(open.repeat(n) + "a" + &close.repeat(n));
    for (open, close) in [
        ("(", ")"),
        ("!", ""),
        ("!(", ")"),
        ("next(", ")"),
        ("PREV ", ""),
        ("a -> ", ""),
        ("a -> (", ")"),
        ("a & (b | ", ")"),
        ("p(", ")"),
        ("b[", "]"),
        ("forall i in boolean . ", ""),
        ("regexp(", ")"),
        ("(a = (b <-> ", "))"),
        ("a S (", ")"),
    ] {
        for n in [100, 399, 1000, 100_000] {
            let reading = nested(open, n, close);
            assert!(n < 400 || reading.specification.is_none(), "{open}");
        }
    }
    assert!(nested("(", 150, ")").specification.is_some());
    assert!(nested("!(", 150, ")").specification.is_some());
    for (open, close) in [
        ("(", ")"),
        ("~(", ")"),
        ("([a] ", ")"),
        ("[a] ", ""),
        ("[a] | ", ""),
        ("([a] & ", ")*"),
    ] {
        for n in [50, 390, 100_000] {
            let text = format!(
                "{head}gar trig {}[a]{} |=> [b];",
                open.repeat(n),
                close.repeat(n)
            );
            read_text(&text);
        }
    }
    // Long but not deeply nested.
    for sign in ["&", "|", "+"] {
        let chain = vec![if sign == "+" { "1" } else { "a" }; 20_000].join(sign);
        let text = if sign == "+" {
            format!("{chain} = 1")
        } else {
            chain
        };
        assert!(of(text).specification.is_some(), "{sign}");
    }
    // As many states as an automaton may have.
    for (expression, states) in [
        ("[a] ".repeat(1_500), 1_500),
        ("[!a]{1900}".to_owned(), 1_900),
        ("[a] | ".repeat(3_000) + "[a]", 0),
    ] {
        let specification = read_text(&format!("{head}gar trig [b] |=> {expression};"))
            .specification
            .expect("no limit is reached");
        let largest = specification.variables.iter().map(|v| v.domain.size());
        assert!(largest.max() > Some(states), "{states}");
    }
    // Definitions that double at each step, and long chains of defines.
    let mut doubling = String::from(head);
    doubling += "define d0 := a;\n";
    for n in 0..60 {
        let _ = writeln!(doubling, "d{} := d{n} & d{n};", n + 1);
    }
    assert!(
        read_text(&format!("{doubling}gar G d60;"))
            .specification
            .is_none()
    );
    assert!(
        read_text(&format!("{doubling}gar G d10;"))
            .specification
            .is_some()
    );
    let mut row = String::from(head);
    row += "define d0 := a;\n";
    for n in 0..5000 {
        let _ = writeln!(row, "d{} := !d{n};", n + 1);
    }
    assert!(
        read_text(&format!("{row}gar G d5000;"))
            .specification
            .is_none()
    );
    let repeated = "[a]{50}".repeat(30) + "~(true* [b] true{12})";
    read_text(&format!("{head}gar trig {repeated} |=> ~({repeated});"));
    let many = "gar each{Int(0..4000) i}: G i = i;\n".repeat(50);
    read_text(&format!("{head}{many}"));
}
