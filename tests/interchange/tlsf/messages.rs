//! What is rejected, and at which place.

use super::{file, read_text, shown};
use linewright::diagnostics::has_errors;
use proptest::prelude::*;
use std::fmt::Write as _;

const SIGNALS: &str = "INPUTS { r; s; bus[2]; } OUTPUTS { g; h; }";

/// The texts at the places of errors.
fn places(text: &str) -> Vec<String> {
    let reading = read_text(text);
    assert!(
        reading.findings.iter().all(|f| f.code.id == "LW201"),
        "{}",
        shown(&reading, text)
    );
    reading
        .findings
        .iter()
        .filter_map(|f| f.span)
        .map(|s| text[s.start as usize..s.end as usize].to_owned())
        .collect()
}

#[test]
fn what_is_outside_is_refused_at_its_smallest_part() {
    let signals = SIGNALS.replace("h;", "h; q;");
    for (promises, place, mended) in [
        ("F G g", "F G g", "G (h -> X h); G (h -> g); G F h"),
        (
            "G (r -> X g); F (G g && h)",
            "G g",
            "G (r -> X g); F (q && h); G (q -> G g)",
        ),
        (
            "G F r; F G g || F G h",
            "F G g",
            "G F r; G (q -> X q); G (q -> g); G F q",
        ),
        (
            "G F r -> G F g; G F s -> G F h",
            "G F s",
            "G F g; G F h; } ASSUME { G F r; G F s",
        ),
        (
            "G F g; G F r -> G F h",
            "G F r",
            "G F g; G F h; } ASSUME { G F r",
        ),
        (
            "G (r -> g U (h U s))",
            "(h U s)",
            "G (r -> g U q); G (q -> h U s)",
        ),
        ("(g U h) U s", "(g U h)", "q U s; G (q -> g U h)"),
        (
            "G (r -> F (g && F h))",
            "F h",
            "G (r -> F (g && q)); G (q -> F h)",
        ),
        (
            "G (r -> X ((r -> F g) W h))",
            "F g",
            "G (r -> X ((r -> q) W h)); G (q -> F g)",
        ),
        (
            "G (r -> F g && X F (h && G g))",
            "G g",
            "G (r -> F g && X F (h && q)); G (q -> G g)",
        ),
    ] {
        let of = |promises: &str| {
            file(
                "Mealy",
                "Mealy",
                &format!("{signals} GUARANTEE {{ {promises}; }}"),
            )
        };
        let found = places(&of(promises));
        assert!(
            found.iter().any(|f| f == place),
            "{promises}: {found:?}, not {place}"
        );
        // The remedy named by the help.
        super::sound(&of(mended));
    }
}

/// The same conditions under ASSUME turn a Streett pair into a plain promise.
#[test]
fn a_condition_that_is_assumed_is_no_condition() {
    let of = |main: &str| file("Mealy", "Mealy", &format!("{SIGNALS} {main}"));
    super::sound(&of(
        "ASSUME { G F r; G F s; } GUARANTEE { G F r -> G F g; G F s -> G F h; G F (g || h); }",
    ));
    let text = of("ASSUME { G F r; } GUARANTEE { G F r -> G F g; G F s -> G F h; }");
    assert_eq!(places(&text), ["G F s"]);
}

#[test]
fn runs_that_end_are_outside_the_fragment() {
    for semantics in ["Finite", "Mealy,Finite", "Finite,Moore"] {
        let main = "INPUTS { a; } OUTPUTS { b; } GUARANTEE { X[!] b; }";
        assert_eq!(places(&file(semantics, "Mealy", main)), [semantics]);
    }
}

/// Sections and entries in any order, and repeated; only SEMANTICS and one signal are required.
#[test]
fn sections_stand_in_any_order() {
    let text = "MAIN { GUARANTEES { G (a -> X b) } OUTPUTS { b } ASSERT { } INPUTS { a; } GUARANTEE { c; } OUTPUTS { c; } }
        INFO { SEMANTICS: Strict,Moore }";
    let specification = super::sound(text);
    assert_eq!(specification.timing, linewright::gr1::Timing::Moore);
    assert_eq!(specification.guarantees.all().count(), 2);
}

#[test]
fn definitions_and_parameters_are_expanded() {
    let head =
        "INFO { TITLE: \"t\" DESCRIPTION: \"d\" SEMANTICS: Mealy TARGET: Mealy TAGS: a, b }\n";
    let text = format!(
        "{head}GLOBAL {{ PARAMETERS {{ n = 3; S = {{0,2..6}}; }} DEFINITIONS {{
           respond(x, y) = G (x -> F y); respond(x) = G F x;
           next(f) = f ~ a U b : b  f ~ X a : a  otherwise : f;
           count(k) = k <= 0 : 0  otherwise : 1 + count(k - 1);
           enum mode = idle: 0*  busy: 10,11; /* nested /* comment */ */
         }} }}
         MAIN {{ INPUTS {{ r[n]; mode m; }} OUTPUTS {{ g[count(n)]; o[SIZE S]; }}
           ASSERT {{ &&[0 <= i < n, j IN {{0,1..n-1}}] (i != j -> !(g[i] && g[j]));
             m == busy -> next(X g[0]); ||[i IN {{0,1..2}} (\\) {{1}}] !o[i]; G[0:2] !o[3] || X[2] o[0];
             MAX S == 6 && SUM[i IN S] i == 12 && |S| == 4 && MIN S == 0; }}
           GUARANTEES {{ &&[0 <= i < SIZEOF r] respond(r[i], g[i]); respond(o[1]); next(true U o[0]); }} }}"
    );
    let reading = read_text(&text);
    let specification = reading
        .specification
        .clone()
        .unwrap_or_else(|| panic!("{}", shown(&reading, &text)));
    let names: Vec<&str> = specification
        .variables
        .iter()
        .filter(|v| !v.internal)
        .map(|v| v.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "r[0]", "r[1]", "r[2]", "m[0]", "m[1]", "g[0]", "g[1]", "g[2]", "o[0]", "o[1]", "o[2]",
            "o[3]"
        ]
    );
}

#[test]
fn messages() {
    let main = |main: &str| file("Mealy", "Mealy", main);
    let defined = |text: &str, promise: &str| {
        file(
            "Mealy",
            "Mealy",
            &format!("{SIGNALS} GUARANTEE {{ {promise}; }}"),
        )
        .replace(
            "MAIN",
            &format!("GLOBAL {{ DEFINITIONS {{ {text} }} }}\nMAIN"),
        )
    };
    let texts = [
        String::new(),
        "MAIN { INPUTS { a; } }".to_owned(),
        file("Finite", "Mealy", SIGNALS),
        file("Mealy", "Turing", SIGNALS),
        main("INPUTS { a; } OUTPUT { b; }"),
        main("INPUTS { a } OUTPUTS { b; } GUARANTEE { a && ; G (b -> ); X; }"),
        main("INPUTS { a; } OUTPUTS { a; b[0 - 1]; kind c; } GUARANTEE { a; }"),
        main(&format!(
            "{SIGNALS} GUARANTEE {{ gg; bus; bus[2]; g[0]; 1 + 1; f(g); }}"
        )),
        main(&format!(
            "{SIGNALS} GUARANTEE {{ &&[g] h; X[1:2] g; G[2] g; G[0:1000] g; }}"
        )),
        defined("f(x) = f(x);", "f(g)"),
        defined("f(x) = x ~ a U b : a;", "f(g)"),
        defined(
            "f(x) = g : x  otherwise : x; k(x) = x / 0;",
            "f(g); k(1) == 1; f(g, h)",
        ),
        defined("enum e = A: 01  B: 0*; f = 1; f = 2;", "g"),
        defined("f(x) = F G x;", "f(g)"),
        main(&format!(
            "{SIGNALS} INITIALLY {{ g; F r; }} PRESET {{ G F g; }} ASSUME {{ G F r -> G F s; }}"
        )),
        file(
            "Mealy,Strict",
            "Mealy",
            &format!(
                "{SIGNALS} INITIALLY {{ g; F r; }} REQUIRE {{ r; }} PRESET {{ G g; }} ASSERT {{ g; }}"
            ),
        ),
        file(
            "Mealy,Strict",
            "Mealy",
            &format!("{SIGNALS} REQUIRE {{ r -> X s; }} ASSERT {{ r -> X X g; }}"),
        ),
        file(
            "Mealy,Strict",
            "Mealy",
            &format!("{SIGNALS} REQUIRE {{ r; }} ASSERT {{ g && G h; }}"),
        ),
        main(&format!("{SIGNALS} GUARANTEE {{ g /* open; }}")),
        main(&format!("{SIGNALS} GUARANTEE {{ g & h; }}")),
    ];
    let mut report = String::new();
    for text in texts {
        let reading = read_text(&text);
        assert!(has_errors(&reading.findings), "{text}");
        let _ = writeln!(report, "{text}\n----\n{}\n====", shown(&reading, &text));
    }
    insta::assert_snapshot!(report);
}

#[test]
fn deep_and_large_files_are_survived() {
    let n = 50_000;
    let of = |formula: &str| {
        file(
            "Mealy",
            "Mealy",
            &format!("{SIGNALS} GUARANTEE {{ {formula}; }}"),
        )
    };
    let texts = [
        of(&"(".repeat(n)),
        of(&format!("{}g", "!".repeat(n))),
        of(&format!("{}g", "X ".repeat(n))),
        of(&format!("g{}", " -> h".repeat(n))),
        of(&format!("g{}", " && h".repeat(n))),
        of(&format!("G (g{})", " && X h".repeat(n))),
        of("&&[0 <= i < 60000] &&[0 <= j < 60000] g"),
        of(&format!("G (r -> {}g)", "X ".repeat(200))),
        of("G (r -> X[200] g W (s W X[100] h))"),
        of("f(60, g)").replace("MAIN", "GLOBAL { DEFINITIONS { f(n, x) = n <= 0 : x  otherwise : f(n - 1, x && X x); } }\nMAIN"),
        of("f(9999999)").replace("MAIN", "GLOBAL { DEFINITIONS { f(n) = n <= 0 : g  otherwise : f(n - 1); } }\nMAIN"),
        of("f(g)").replace("MAIN", "GLOBAL { DEFINITIONS { f(n) = f(f(n)); } }\nMAIN"),
        format!("INFO {{ {} ", "/*".repeat(n)),
        of(&format!("{}g{}", "(G F g || (F G h && ".repeat(90), "))".repeat(90))),
        of(&format!("{}g{}", "F (g && X G (h || ".repeat(90), "))".repeat(90))),
        of(&format!("{}g{}", "G (g || F (h && ".repeat(90), "))".repeat(90))),
        of(&format!("{}g{}", "(r R (g && ".repeat(90), "))".repeat(90))),
        of(&format!("{}g{}", "((G F r && g) W ".repeat(90), ")".repeat(90))),
        of(&format!("{}g{}", "(r <-> X F ".repeat(60), ")".repeat(60))),
        of("&&[i IN {}] g; ||[i IN {}] g; SUM[i IN {}] i == 0; &&[0 <= i < 0 - 5] g"),
        of("g").replace("bus[2]", "bus[0]; more[1000000000]"),
        of("g").replace("MAIN", "GLOBAL { PARAMETERS { n = m; m = n; } }\nMAIN").replace("bus[2]", "bus[n]"),
        of("S == S").replace("MAIN", "GLOBAL { PARAMETERS { S = {0,1..1000000000}; } }\nMAIN"),
    ];
    for text in texts {
        let start = std::time::Instant::now();
        let reading = read_text(&text);
        let spent = start.elapsed();
        let head: String = text.chars().skip(150).take(80).collect();
        println!("{spent:?} {} {head}", reading.findings.len());
        assert!(spent.as_secs() < 20, "{head}: {spent:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn no_soup_of_words_panics(words in prop::collection::vec(prop::sample::select(WORDS.to_vec()), 0..40), whole in any::<bool>()) {
        let soup = words.join(" ");
        let text = if whole { soup } else { file("Mealy", "Mealy", &format!("{SIGNALS} GUARANTEE {{ {soup} }}")) };
        let reading = read_text(&text);
        prop_assert_eq!(reading.specification.is_none(), has_errors(&reading.findings));
        for finding in &reading.findings {
            for span in finding.span.iter().chain(finding.labels.iter().map(|l| &l.0)) {
                prop_assert!(text.get(span.start as usize..span.end as usize).is_some());
            }
        }
    }
}

const WORDS: [&str; 60] = [
    "INFO",
    "MAIN",
    "GLOBAL",
    "{",
    "}",
    "{",
    "}",
    ";",
    ";",
    ",",
    ":",
    "(",
    ")",
    "(",
    ")",
    "[",
    "]",
    "r",
    "s",
    "g",
    "h",
    "bus",
    "bus[0]",
    "bus[i]",
    "G",
    "F",
    "X",
    "U",
    "W",
    "R",
    "!",
    "&&",
    "||",
    "->",
    "<->",
    "==",
    "<",
    "<=",
    "0",
    "1",
    "2",
    "&&[0 <= i < 2]",
    "||[i IN {0,1}]",
    "SUM[0<i<3]",
    "SIZEOF",
    "true",
    "false",
    "otherwise",
    "~",
    "_",
    "enum",
    "INPUTS",
    "OUTPUTS",
    "GUARANTEE",
    "G (",
    "X (",
    "g W",
    "|",
    "(\\)",
    "X[2]",
];

/// `F` of an empty interval is true, as in the format's tool, with a note; `G` of one is true
/// without question.
#[test]
fn an_empty_interval_is_noted() {
    let noted = |promise: &str| {
        let text = file(
            "Mealy",
            "Mealy",
            &format!("{SIGNALS} GUARANTEE {{ {promise} }}"),
        );
        let reading = read_text(&text);
        assert!(
            reading.specification.is_some(),
            "{}",
            shown(&reading, &text)
        );
        let found = reading.findings.iter().map(|f| f.code.id);
        found.collect::<Vec<_>>()
    };
    assert_eq!(noted("F[2:1] g;"), ["LW005"]);
    assert_eq!(noted("G (r -> F[1:0] g);"), ["LW005"]);
    assert!(noted("G[2:1] g;").is_empty());
    assert!(noted("F[1:1] g;").is_empty());
}

/// Findings of `check` about assumptions concern those of the file, not those that express its
/// meaning in GR(1).
#[test]
fn findings_about_assumptions_are_about_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let found = |main: &str| {
        let text = file("Mealy", "Mealy", main);
        let own = read_text(&text).with_own_assumptions;
        std::fs::write(folder.path().join("a.tlsf"), &text).expect("a file");
        let output = crate::support::linewright(folder.path(), &["check", "a.tlsf"]);
        let shown =
            String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        let ids = ["LW205", "LW206"].map(|id| shown.contains(id));
        (
            own.map(|s| s.assumptions.all().count()),
            ids,
            shown.into_owned(),
        )
    };
    // With PRESET an assumption about the first step is judged a step later: as if the plant had no
    // next step.
    let (own, ids, shown) =
        found("INPUTS { a; } OUTPUTS { b; } PRESET { b; } ASSUME { a; } GUARANTEE { G b; }");
    assert_eq!((own, ids), (Some(0), [false, false]), "{shown}");
    // A promise equivalent to an assumption that the machine can violate.
    let pairs = "GUARANTEE { F G x || F G y; }";
    let (own, ids, shown) = found(&format!("INPUTS {{ a; }} OUTPUTS {{ x; y; }} {pairs}"));
    assert_eq!((own, ids), (Some(0), [false, false]), "{shown}");
    // The file's own assumptions are judged, also together with such ones.
    let assumed = "ASSUME { G (x -> X ! a); G F a; }";
    for promise in [pairs, "GUARANTEE { G F x; }"] {
        let (own, ids, shown) = found(&format!(
            "INPUTS {{ a; }} OUTPUTS {{ x; y; }} {assumed} {promise}"
        ));
        assert_eq!(own, (promise == pairs).then_some(2));
        assert_eq!(ids, [true, false], "{shown}");
    }
}
