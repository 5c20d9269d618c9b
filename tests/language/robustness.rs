//! For any text: the parser and the resolver end soon, without a panic, on the stack of an ordinary
//! thread, and their findings can be shown. Every file of the repository is damaged in many ways;
//! then come texts known to be hard for parsers.

use linewright::contract::{Library, load};
use linewright::diagnostics::{Diagnostic, has_errors, json, render, sarif};
use linewright::gr1::eval::eval;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Default stack size of a thread.
const STACK: usize = 2 << 20;

/// Every contract, machine and line of the repository.
fn files() -> Vec<(PathBuf, String)> {
    fn visit(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                visit(&path, found);
            } else if path.extension().is_some_and(|e| e == "lw") {
                let text = std::fs::read_to_string(&path).expect("a file");
                found.push((path, text));
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for folder in ["contracts", "examples", "tests/cases"] {
        visit(&root.join(folder), &mut found);
    }
    found.sort();
    found
}

fn read_import(wanted: &str, from: &str) -> Result<(String, String), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = match wanted.strip_prefix("std.") {
        Some(inner) => root.join("contracts").join(inner.replace('.', "/") + ".lw"),
        None => Path::new(from).parent().unwrap_or(root).join(wanted),
    };
    // One name per file.
    let path = path.canonicalize().map_err(|e| e.to_string())?;
    let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
    Ok((path.to_string_lossy().into_owned(), text))
}

/// Loads a text, checks its findings, shows them in all formats, and evaluates what was accepted.
fn survive(name: &Path, text: &str) -> (Library, Vec<Diagnostic>) {
    let (library, findings) = load(
        &[(name.to_string_lossy().into_owned(), text.to_owned())],
        &read_import,
    );
    for finding in &findings {
        let spans = finding
            .span
            .iter()
            .chain(finding.labels.iter().map(|l| &l.0));
        for span in spans {
            let text = &library.sources.file(span.file).text;
            let (start, end) = (span.start as usize, span.end as usize);
            assert!(start <= end && end <= text.len(), "{finding:?}");
            assert!(
                text.is_char_boundary(start) && text.is_char_boundary(end),
                "{finding:?}"
            );
        }
        assert!(!finding.message.is_empty());
    }
    let shown: Vec<_> = findings.iter().take(20).cloned().collect();
    let human = render::human(&library.sources, &shown);
    assert_eq!(human.is_empty(), findings.is_empty());
    assert!(render::short(&library.sources, &shown).lines().count() >= shown.len());
    let values = json::findings(&library.sources, &shown);
    assert_eq!(values.len(), shown.len());
    sarif::document(&library.sources, &shown);
    for contract in &library.contracts {
        let specification = &contract.specification;
        let low: Vec<i64> = specification
            .variables
            .iter()
            .map(|v| v.domain.low())
            .collect();
        let high: Vec<i64> = specification
            .variables
            .iter()
            .map(|v| v.domain.high())
            .collect();
        for formula in specification
            .assumptions
            .all()
            .chain(specification.guarantees.all())
        {
            for (now, next) in [(&low, &high), (&high, &low)] {
                let value = eval(&formula.expr, now, next);
                assert!(value == 0 || value == 1, "{}: {value}", formula.text);
            }
        }
    }
    (library, findings)
}

/// The same in a thread with a small stack, within this many seconds.
fn survive_within(text: String, seconds: u64) -> (Library, Vec<Diagnostic>) {
    let start = Instant::now();
    let thread = std::thread::Builder::new().stack_size(STACK);
    let result = thread
        .spawn(move || survive(Path::new("test.lw"), &text))
        .expect("a thread")
        .join()
        .expect("no panic");
    let taken = start.elapsed();
    assert!(taken < Duration::from_secs(seconds), "{taken:?}");
    result
}

#[test]
fn whole_files_are_sound() {
    for (path, text) in files() {
        let (_, findings) = survive(&path, &text);
        let case = path.components().any(|c| c.as_os_str() == "cases");
        assert!(case || !has_errors(&findings), "{findings:#?}");
    }
}

/// A change to a text.
#[derive(Debug, Clone)]
enum Damage {
    /// Deletes this many characters at a place.
    Delete(usize, usize),
    /// Duplicates this many characters at a place.
    Double(usize, usize),
    /// Moves a piece to another place.
    Move(usize, usize, usize),
    /// Ends the text here.
    End(usize),
    /// Inserts a text.
    Insert(usize, String),
    /// Deletes a word, number or sign.
    DeleteToken(usize),
    /// Exchanges two of them.
    SwapTokens(usize, usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    let at = 0usize..20_000;
    let piece = prop_oneof![
        "\\PC{1,5}",
        prop::sample::select(vec![
            "{",
            "}",
            "(",
            ")",
            "[",
            "]",
            "\"",
            "/*",
            "*/",
            "//",
            "///",
            "'",
            ";",
            ",",
            ":",
            "=",
            "->",
            "\0",
            "\u{feff}",
            "\r",
            "\r\n",
            "\u{2028}",
            "e\u{301}",
            "□",
            "always",
            "contract",
            "if",
            "0..",
            "1e9",
            "in",
            "array",
            "import",
            "skills S {",
            "layout L {",
            "recipe R {",
            "realize 3 R on L",
            "resource r at s {",
            "transport t {",
            "at start r s holds",
            "s -> s: in:1, out, a",
            "a -> b when t(p): o(p)(p)",
            "|| o()(p)",
            "nop s",
            "order a: never",
            "sequence (",
            "deletes",
            "forall i in",
            "9007199254740993",
            "[R-1]",
            "\u{10ffff}",
        ])
        .prop_map(str::to_owned),
    ];
    prop_oneof![
        (at.clone(), 1usize..30).prop_map(|(a, n)| Damage::Delete(a, n)),
        (at.clone(), 1usize..30).prop_map(|(a, n)| Damage::Double(a, n)),
        (at.clone(), 1usize..30, at.clone()).prop_map(|(a, n, b)| Damage::Move(a, n, b)),
        at.clone().prop_map(Damage::End),
        (at.clone(), piece).prop_map(|(a, s)| Damage::Insert(a, s)),
        at.clone().prop_map(Damage::DeleteToken),
        (at.clone(), at).prop_map(|(a, b)| Damage::SwapTokens(a, b)),
    ]
}

fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let word = |c: char| c.is_alphanumeric() || c == '_';
    for c in text.chars() {
        match tokens.last_mut() {
            Some(last) if word(c) && last.ends_with(word) => last.push(c),
            _ => tokens.push(c.to_string()),
        }
    }
    tokens
}

fn damaged(text: &str, damage: &Damage) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    let n = chars.len() + 1;
    match damage {
        Damage::Delete(at, count) => {
            let at = at % n;
            let end = (at + count).min(chars.len());
            chars.drain(at..end);
        }
        Damage::Double(at, count) => {
            let at = at % n;
            let piece: Vec<char> = chars[at..].iter().take(*count).copied().collect();
            chars.splice(at..at, piece);
        }
        Damage::Move(at, count, to) => {
            let at = at % n;
            let end = (at + count).min(chars.len());
            let piece: Vec<char> = chars.drain(at..end).collect();
            let to = to % (chars.len() + 1);
            chars.splice(to..to, piece);
        }
        Damage::End(at) => chars.truncate(at % n),
        Damage::Insert(at, piece) => {
            let at = at % n;
            chars.splice(at..at, piece.chars());
        }
        Damage::DeleteToken(at) => {
            let mut tokens = tokens(text);
            if !tokens.is_empty() {
                tokens.remove(at % tokens.len());
            }
            return tokens.concat();
        }
        Damage::SwapTokens(a, b) => {
            let mut tokens = tokens(text);
            if !tokens.is_empty() {
                let n = tokens.len();
                tokens.swap(a % n, b % n);
            }
            return tokens.concat();
        }
    }
    chars.into_iter().collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_are_survived(pick in 0usize..1000, changes in prop::collection::vec(damage(), 1..4)) {
        let files = files();
        let (path, text) = &files[pick % files.len()];
        let mut text = text.clone();
        for change in &changes {
            text = damaged(&text, change);
        }
        let start = Instant::now();
        survive(path, &text);
        prop_assert!(start.elapsed() < Duration::from_secs(10));
    }

    #[test]
    fn any_text_is_survived(text in "\\PC{0,200}", words in prop::collection::vec(prop::sample::select(vec![
        "contract A {", "machine M {", "line L {", "}", "{", "guarantee", "always", "(", ")", "if", "then", "else", "a", "=",
        "input a: bool", "0..3", "\n", "array[2] of", "[", "]", "/*", "\"", "forall i in", ":", "next", "action a: A {", "station",
        "skills S {", "component c {", "order", "never", "sequence", "&", "|", "*", "deletes", "a -> a", "at", "skills S at valid {",
        "layout L {", "recipe R {", "realize", "R on L", "resource r", "transport t {", "at start r s", "holds", "nop", "a -> b", "when", "otherwise",
        "f(a)(b)", "||", ";", "part p: P", "start a", "end b", "leftover p", "out:1", "internal x", "2",
    ]), 0..40)) {
        survive(Path::new("test.lw"), &text);
        survive(Path::new("test.lw"), &words.join(" "));
        survive(Path::new("test.lw"), &words.join("\n"));
    }
}

fn contract(formula: &str) -> String {
    format!(
        "contract Test {{\n    input a: bool\n    input n: 0..9\n    output b: bool\n    guarantee g: always {formula}\n}}\n"
    )
}

#[test]
fn deep_nesting_is_survived() {
    for n in [13, 100, 190, 1_000, 10_000, 100_000] {
        let texts = [
            contract(&("(".repeat(n) + "b" + &")".repeat(n))),
            contract(&("(".repeat(n) + "b")),
            contract(&("not ".repeat(n) + "b")),
            contract(&("!(".repeat(n) + "b" + &")".repeat(n))),
            contract(&("next ".repeat(n) + "b")),
            contract(&format!("{} n = 0", "-".repeat(n))),
            contract(&format!("b{}", "'".repeat(n))),
            contract(&format!("n{} = 1", "[0]".repeat(n))),
            contract(&("if a then b else ".repeat(n) + "b")),
            contract(&("if\noperation = a then b else ".repeat(n) + "b")),
            contract(&("always ".repeat(n) + "b")),
            contract(&("G ".repeat(n) + "b")),
            contract(&("forall i in 0..0: ".repeat(n) + "b")),
            contract(&("forall i in array[".repeat(n) + "b")),
            contract(&format!("{}n = 0", "abs(".repeat(n))),
            contract(&"[".repeat(n)),
            contract(&("if 1 s = 1 s then b else ".repeat(n) + "b")),
            contract(&("(0 = ".repeat(n) + "b" + &" = 0)".repeat(n))),
            contract(&("(n <= ".repeat(n) + "n" + &" <= n)".repeat(n))),
            "{".repeat(n),
            "}".repeat(n),
            "/*".repeat(n),
            format!(
                "contract A {{ input a: {} bool }}",
                "array[1] of ".repeat(n)
            ),
            format!("skills S {{ order: sequence {}", "(".repeat(n)),
            format!(
                "skills S {{ component c {{ A }}\norder: sequence {}A{}* }}",
                "(".repeat(n),
                ")?".repeat(n)
            ),
            format!(
                "skills S {{ component c {{ A }}\norder: sequence (A{}) }}",
                "*".repeat(n)
            ),
            format!("skills S {{ order: {} }}", "never ".repeat(n)),
            format!(
                "machine M {{ skills S {{ order = {}a }} }}",
                "if order then ".repeat(n)
            ),
            "skills S { ".repeat(n),
            "layout L { resource r at s { ".repeat(n),
            "recipe R { a -> b: ".repeat(n),
            format!(
                "layout L {{ resource r at s {{ s -> s: a in {}1 s",
                "(".repeat(n)
            ),
            format!("recipe R {{ a -> b: o{} }}", "(".repeat(n)),
            format!("recipe R {{ a -> b: {}o()() }}", "o()() || ".repeat(n)),
            format!("realize {}R on L", "R, ".repeat(n)),
            "machine M { action a: A { ".repeat(n),
            "line L {\n station a: A {\n".repeat(n),
            format!("contract A {{ /* {}", "{".repeat(n)),
            format!("import \"{}", "{".repeat(n)),
            format!("contract A {{ assume a [\"]: {} \"", "(".repeat(n)),
        ];
        for text in texts {
            survive_within(text, 30);
        }
    }
}

#[test]
fn long_chains_are_survived() {
    let n = 10_000;
    for (operator, accepted) in [
        (" and ", true),
        (" or ", true),
        (" xor ", true),
        (" <-> ", true),
        (" -> ", false),
        (" = ", true),
        (" -> not ", false),
    ] {
        let text = contract(&format!("({})", vec!["b"; n].join(operator)));
        let (library, findings) = survive_within(text, 30);
        assert_eq!(
            has_errors(&findings),
            !accepted,
            "{operator}: {:?}",
            findings.first()
        );
        assert_eq!(library.malformed_files.is_empty(), accepted);
    }
    for (operator, accepted) in [
        (" + ", true),
        (" - ", false),
        (" * ", false),
        (" / ", false),
        (" < ", true),
    ] {
        let text = contract(&format!("(b or {} = 0)", vec!["n"; n].join(operator)));
        let (_, findings) = survive_within(text, 30);
        assert_eq!(has_errors(&findings), !accepted, "{operator}");
    }
}

fn many(n: usize, line: &dyn Fn(usize) -> String) -> String {
    (0..n).map(line).collect::<Vec<_>>().concat()
}

#[test]
fn what_grows_when_it_is_written_out_is_bounded() {
    let chain = |n: usize, step: &dyn Fn(usize) -> String| {
        let mut text = "contract Test {\n    input n: 0..9\n    input i: 0..15\n    output h: array[16] of 0..15\n    define d0 = n\n".to_owned();
        for i in 1..=n {
            let _ = writeln!(text, "    define d{i} = {}", step(i - 1));
        }
        text + &format!("    guarantee g: always (h[0] = 0 and d{n} = 0)\n}}\n")
    };
    let texts = [
        chain(10_000, &|i| format!("d{i}")),
        chain(10_000, &|i| format!("(d{i} + 1) mod 10")),
        chain(100, &|i| format!("(d{i} + d{i}) mod 10")),
        chain(100, &|i| format!("if d{i} in {{1, 2, 3}} then 1 else 0")),
        chain(100, &|i| format!("if d{i} in 0..d{i} then 1 else 0")),
        chain(100, &|i| format!("h[d{i}]")),
        chain(300, &|i| format!("[0, 0, 0, d{i}][min(i, 3)]")),
        chain(60, &|i| format!("d{i} * 4")),
        contract("forall i in 0..4095: forall j in 0..4095: forall k in 0..4095: i = j or b"),
        "contract Test { output h, g: array[4096] of 0..4095\n guarantee a: always forall i in 0..4095: h = g }".to_owned(),
        "contract Test { output h, g: array[4096] of 0..4095\n guarantee a: always forall i in 0..4095: h[h[i]] = g[g[h[i]]] }".to_owned(),
        format!("contract Test {{ output {}: array[4096] of 0..4095 }}", (0..2000).map(|i| format!("h{i}")).collect::<Vec<_>>().join(", ")),
        "const A = 9007199254740992 * 9007199254740992 * 9007199254740992\ncontract T { output x: -A..A }".to_owned(),
        "const A = 4611686018427387 * 1000\ncontract T { output x: -A..A guarantee g: always forall i in -A..A: x = i }".to_owned(),
        many(10_000, &|i| format!("const C{i} = C{} + 1
", i + 1)) + "const C10000 = 0
",
        many(10_000, &|i| format!("const C{i} = D{i}
")),
        format!(
            "skills S {{\n component c {{\n{} }}\n{}}}",
            many(10_000, &|i| format!("S{i}\n")),
            many(10_000, &|i| format!("order: never T{i}\n"))
        ),
        format!("skills S {{ component c {{ A }}\norder: sequence ({})* }}", "A ".repeat(100_000)),
        format!("skills S {{ component c {{ A }}\norder: sequence ({} A) }}", "A & ".repeat(10_000)),
        format!("skills S {{ component c {{ A }}\norder: sequence {}A{} }}", "(".repeat(100), "){1000}".repeat(100)),
        format!("skills S {{ component c {{ A }}\n order: never {} A }}", "A, ".repeat(100_000)),
        "x\n".repeat(20_000),
        "guarantee\n".repeat(20_000),
        "contract A {\n".repeat(5_000),
        "contract A { guarantee a: b\n".repeat(2_000),
    ];
    for text in texts {
        survive_within(text, 60);
    }
}

#[test]
fn odd_files_are_survived() {
    let sound = "contract A {\n    output b: bool\n    guarantee g: always b\n}\n";
    let crlf = sound.replace('\n', "\r\n");
    for text in [
        sound.to_owned(),
        format!("\u{feff}{sound}"),
        crlf,
        sound.replace('\n', " "),
    ] {
        let (library, findings) = survive_within(text, 5);
        assert!(findings.is_empty(), "{findings:?}");
        assert_eq!(library.contracts.len(), 1);
    }
    let (library, findings) = survive_within(String::new(), 5);
    assert!(findings.is_empty() && library.contracts.is_empty());
    for text in [
        "\0",
        "contract\0A {}",
        "contract A { output b\0: bool }",
        "\u{feff}",
        "\r",
        "//",
        "/*",
        "\"",
        "///",
        "'",
    ] {
        survive_within(text.to_owned(), 5);
    }
}

#[test]
fn accepted_formulas_can_be_solved_on_a_small_stack() {
    use linewright::game::{Limits, solve};
    let texts = [
        contract(&("(".repeat(190) + "b" + &")".repeat(190))),
        contract(&("not (".repeat(90) + "b" + &")".repeat(90))),
        contract(&("if a then b else ".repeat(190) + "b")),
        contract(&format!("({})", vec!["b"; 10_000].join(" and "))),
        contract(&format!("({})", vec!["b"; 200].join(" -> "))),
        contract(&format!("(b or {} < 0)", vec!["n"; 150].join(" - "))),
    ];
    for text in texts {
        let (library, findings) = survive_within(text, 30);
        assert!(!has_errors(&findings), "{:?}", findings.first());
        let specification = library.contracts[0].specification.clone();
        let limits = Limits {
            deadline: linewright::deadline::Deadline::from_now(Duration::from_secs(20)),
            ..Limits::default()
        };
        std::thread::Builder::new()
            .stack_size(STACK)
            .spawn(move || {
                solve(&specification, &limits);
            })
            .expect("a thread")
            .join()
            .expect("no panic");
    }
}
