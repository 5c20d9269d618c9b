//! The formatter: its output parses to the given tree, every comment is kept, formatting twice
//! changes nothing, and every file of the repository is formatted.

mod repository;
mod trees;

use linewright::diagnostics::Diagnostic;
use linewright::source::FileId;
use linewright::syntax::ast::File;
use linewright::syntax::{format, parse};
use proptest::prelude::*;
use trees::Choices;

/// The tree of a text without places, and the findings.
fn read(text: &str) -> (File, Vec<Diagnostic>) {
    let (tree, findings) = parse(FileId::default(), text);
    (tree.without_spans(), findings)
}

/// A text, formatted; requires it to pass all checks that the program makes before it writes a
/// file.
fn formatted(text: &str) -> String {
    let (tree, findings) = parse(FileId::default(), text);
    assert!(findings.is_empty(), "{findings:?} in\n{text}");
    match format::format_checked(&tree, text) {
        Ok(formatted) => formatted,
        Err(fault) => panic!(
            "{fault}:\n{text}\nis formatted as\n{}",
            format::format(&tree, text)
        ),
    }
}

/// Things to insert between two words; `N` is numbered.
const BETWEEN: &[&str] = &[
    " /* cN */ ",
    " // cN\n",
    "\n// cN\n",
    "\n",
    "\n\n\n",
    "/* cN\n  d */",
    "\n\n    /* cN */\n",
    "\n/// cN\n",
    "\r\n// cN \r\n\r\n",
];

/// The text with some of them inserted where they do not change its meaning; others are omitted.
fn with_comments(text: &str, places: &[(usize, usize)]) -> String {
    let (tree, _) = read(text);
    let mut text = text.to_owned();
    for (n, (at, what)) in places.iter().enumerate() {
        let word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let mut at = at % (text.len() + 1);
        while !text.is_char_boundary(at)
            || word(text[..at].chars().next_back()) && word(text[at..].chars().next())
        {
            at += 1;
        }
        let mut new = text.clone();
        new.insert_str(
            at,
            &BETWEEN[what % BETWEEN.len()].replace('N', &n.to_string()),
        );
        let (again, findings) = read(&new);
        if findings.is_empty() && again == tree {
            text = new;
        }
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, max_shrink_iters: 4000, ..ProptestConfig::default() })]

    #[test]
    fn what_is_printed_is_read_as_the_same_tree(numbers in prop::collection::vec(any::<u32>(), 0..250)) {
        let tree = Choices::new(&numbers).file();
        let text = format::format(&tree, "");
        let (again, findings) = read(&text);
        prop_assert!(findings.is_empty(), "{:?} in\n{}", findings, text);
        prop_assert_eq!(&again, &tree, "{}", text);
        // Its own text is also formatted, except for what only a text can express.
        let once = formatted(&text);
        prop_assert_eq!(&formatted(&once), &once);
    }
}

/// A limit below a source is the line's own if it says more than a number.
#[test]
fn a_source_does_not_take_the_limit_of_its_line() {
    use linewright::syntax::ast::{Item, LineItem, Supply};
    let line = |limits: &str| {
        let text = format!("line a {{\n    source b: c every 5 s{limits}\n}}\n");
        let (file, findings) = read(&text);
        assert!(findings.is_empty(), "{text}: {findings:?}");
        let [Item::Line(line)] = file.items.as_slice() else {
            panic!("{text}");
        };
        let LineItem::Source { supply, .. } = &line.items[0] else {
            panic!("{text}");
        };
        let Supply::Every { limit, .. } = supply else {
            panic!("{text}");
        };
        (*limit, line.items.len() - 1)
    };
    assert_eq!(line(" limit 8"), (Some(8), 0));
    assert_eq!(line("\n    limit 8 h"), (None, 1));
    assert_eq!(line("\n    limit 50 products"), (None, 1));
    assert_eq!(line("\n    limit 2 * 4 h"), (None, 1));
    assert_eq!(line(" limit 8\n    limit 50 products"), (Some(8), 1));
    assert_eq!(line(" limit 8\n    /// d\n    sink e"), (Some(8), 1));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, max_shrink_iters: 2000, ..ProptestConfig::default() })]

    #[test]
    fn comments_stay_in_order(
        numbers in prop::collection::vec(any::<u32>(), 0..60),
        places in prop::collection::vec(any::<(usize, usize)>(), 1..8),
    ) {
        let tree = Choices::new(&numbers).file();
        let text = with_comments(&format::format(&tree, ""), &places);
        let once = formatted(&text);
        let labels = |text: &str| -> Vec<String> {
            text.match_indices('c')
                .map(|(i, _)| text[i..].chars().take(2).collect::<String>())
                .filter(|l| l.ends_with(|c: char| c.is_ascii_digit()))
                .collect()
        };
        prop_assert_eq!(labels(&text), labels(&once), "{}\n{}", text, once);
        prop_assert_eq!(format::comments(&text), format::comments(&once));
        prop_assert_eq!(&formatted(&once), &once);
    }
}

/// Checks the formatted form of a text.
fn becomes(text: &str, wanted: &str) {
    assert_eq!(formatted(text), wanted);
}

#[test]
fn operators_are_words_with_few_brackets() {
    for (written, wanted) in [
        ("□(a ∧ b → ○c)", "always (a and b -> next c)"),
        ("[]<>a", "always eventually a"),
        ("GF a", "always eventually a"),
        ("G(a) && F b", "(always a) and eventually b"),
        ("a' == b''", "next a = next next b"),
        ("!a || ~(b)", "not a or not b"),
        ("a and (b and c)", "a and (b and c)"),
        ("(a and b) and c", "a and b and c"),
        ("a and b or c", "(a and b) or c"),
        ("a -> (b -> c)", "a -> b -> c"),
        ("(a -> b) -> c", "(a -> b) -> c"),
        ("a <-> (b -> c)", "a <-> (b -> c)"),
        ("0 <= a < b", "0 <= a < b"),
        ("0 <= a and a < b", "0 <= a and a < b"),
        ("c and 0 <= a < b", "c and 0 <= a < b"),
        ("not a = b", "not (a = b)"),
        ("always a = b", "always (a = b)"),
        ("a - (b - c) - d", "a - (b - c) - d"),
        ("(a - b) + c", "a - b + c"),
        ("a - -b", "a - (-b)"),
        ("-(-a)", "-(-a)"),
        ("x in 0 .. n - 1", "x in 0..n-1"),
        ("(a since b) and c", "(a since b) and c"),
        ("once a within 1 step", "once a within 1 step"),
        (
            "eventually (once a) within 5 steps",
            "eventually (once a) within 5 steps",
        ),
        (
            "s responds to p within 5 steps after q until r",
            "s responds to p within 5 steps after q until r",
        ),
        ("(if a then b else c) and d", "(if a then b else c) and d"),
        (
            "if a then (if b then c else d) else if e then f else g",
            "if a then (if b then c else d) else if e then f else g",
        ),
        ("next not a", "next not a"),
        ("007 = 1e-3 s", "007 = 1e-3 s"),
    ] {
        let text = |formula: &str| format!("contract A {{\n    assume f: {formula}\n}}\n");
        becomes(&text(written), &text(wanted));
    }
}

#[test]
fn long_lines_break_at_the_outermost_operator() {
    becomes(
        "contract A { guarantee long: always (first_condition_of_many and second_condition_of_many -> next first_result = first_wanted and next second_result = second_wanted) }",
        "contract A {
    guarantee long: always (first_condition_of_many and second_condition_of_many ->
        next first_result = first_wanted and next second_result = second_wanted)
}
",
    );
    becomes(
        "define planned = if task = hold then HOLD[phase] else if task = release then RELEASE[phase] else if task = dismantle then DISMANTLE[phase] else none_of_them",
        "define planned =
    if task = hold then HOLD[phase]
    else if task = release then RELEASE[phase]
    else if task = dismantle then DISMANTLE[phase]
    else none_of_them
",
    );
}

#[test]
fn breaks_and_groups_of_the_author_stay() {
    let text = "import std.common.command
import \"a.lw\"

// ---- a banner ----

type A = {a, b}
const M: array[2] of array[2] of 0..1 = [
    [0, 1],
    [1, 0]
]
define p(x: 0..3, y) =
    if x = 1 then y else if x = 2 then not y
    else y

/// What it is.
///
/// Longer.
contract Empty {
    // nothing yet
}
contract Short { output a: bool } // short
contract Long(
    n: 1..3 = 2
) implements din:4.1, vdi:Drehen {
    input a, b: bool // trailing

    /* before */ output c: bool /* behind */
    guarantee g [REQ-1]: always (a ->
        // why
        b or
        c) // end
    // last
}

line L {
    part P { property angle: deg = 0 }
    route P: a -> b otherwise
    station s: M {
        defect on P probability 5 %: one of heights becomes 1
    }
}
// the end
";
    becomes(text, text);
}

#[test]
fn blanks_semicolons_and_empty_lines_are_put_right() {
    becomes(
        "\n\ncontract   A(  ){input a:bool;output b  :bool\n\n\n\nguarantee :a=b // c   \n\n}\n\n\n",
        "contract A {\n    input a: bool\n    output b: bool\n\n    guarantee a = b // c\n}\n",
    );
    becomes("contract A{/* c */}", "contract A { /* c */\n}\n");
    becomes("", "");
    becomes("// only this", "// only this\n");
}

#[test]
fn a_number_and_the_word_behind_it_are_set_apart() {
    becomes(
        "line L{part C from 1B\nlimit 50products}",
        "line L {\n    part C from 1 B\n    limit 50 products\n}\n",
    );
}

#[test]
fn line_ends_and_the_byte_order_mark_stay() {
    becomes(
        "\u{feff}contract A {\r\n  /* b\r\n c */\r\n input a: bool\n}",
        "\u{feff}contract A {\r\n    /* b\r\n c */\r\n    input a: bool\r\n}\r\n",
    );
}

#[test]
fn what_says_nothing_new_twice_is_a_finding() {
    // The tree has one place for it, so the formatter would drop the other.
    let (_, findings) =
        read("machine M {\n    action a: A {\n        time 1 s\n        time 2 s\n    }\n}\n");
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].code.id, "LW102");
}

#[test]
fn skills_stand_one_a_line_and_orders_break_where_the_author_broke_them() {
    becomes(
        "skills Unit{component x:{left,right,}=left{Left->left;Right->right /* tail */, Stop->left} component camera{Inspect}
component none{}
order trays[R-1] at  reasonable:after Down,Up&Left until Up:never Left,Right deletes x.left->right,
down&left->z.up
order u: sequence((A,B)|((C)) (not A)* (A&B) not(B|C)|A&B|(D*)+|()*) order: at most 007 of A
order long: sequence (Right? Down Grip Up Left Down Release Up Right? Down Grip Up Left Down Release Up Right? Down Grip Up Left Down Release Up)*}
machine M { skills Unit at reasonable { Left = arm.call = left; Right = a and b } skills Other{A=true} skills None {} }",
        "skills Unit {
    component x: {left, right} = left {
        Left -> left
        Right -> right /* tail */
        Stop -> left
    }
    component camera { Inspect }
    component none {}
    order trays [R-1] at reasonable: after Down, Up & Left until Up: never Left, Right
        deletes x.left -> right,
            down & left -> z.up
    order u: sequence (A B | C (not A)* (A & B) not (B | C) | A & B | (D*)+ | ()*)
    order: at most 7 of A
    order long: sequence (Right? Down Grip Up Left Down Release Up Right? Down Grip Up Left Down Release Up Right? Down Grip Up Left
        Down Release Up)*
}
machine M {
    skills Unit at reasonable {
        Left = arm.call = left
        Right = a and b
    }
    skills Other { A = true }
    skills None {}
}
",
    );
}

#[test]
fn comments_are_distinguished_from_texts() {
    let text = "import \"a//b\" // c \"d\r\n\r\n/* e\r\n// f */ import g // h\r\n\r\n/// i\r\ntype T = 0..1\r\n";
    becomes(text, text);
}
