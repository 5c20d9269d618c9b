//! Every part of a formula is at the place of its span.

use linewright::source::FileId;
use linewright::syntax::ast::{ContractItem, Expr, File, Item};
use linewright::syntax::parse;

fn parsed(formula: &str) -> (String, File) {
    let text = format!("contract A {{\n    guarantee: {formula}\n}}\n");
    let (file, findings) = parse(FileId(0), &text);
    assert_eq!(findings, [], "{formula}");
    (text, file)
}

fn formula(file: &mut File) -> &mut Expr {
    let Some(Item::Contract(contract)) = file.items.first_mut() else {
        panic!("a contract");
    };
    let Some(ContractItem::Formula { expr, .. }) = contract.items.first_mut() else {
        panic!("a formula");
    };
    expr
}

/// Every part of a formula is at the place of its span, with all its brackets: parsed alone, that
/// text is the same part.
#[test]
fn spans_hold_brackets_that_match() {
    for (written, whole) in [
        ("(a -> c) and (c -> a)", ""),
        ("((a -> c) and (c -> a))", "(a -> c) and (c -> a)"),
        ("((((a))) or ((b)))", "(((a))) or ((b))"),
        ("(a)", "a"),
        ("always ((a -> c) and (c -> a))", ""),
        ("not (a and (b or c))", ""),
        ("not not ((a))", ""),
        ("next (x)' > -(y + (z))", ""),
        ("(a)[(1)] and (b).c and (d)'", ""),
        ("((x + 1) * (y - 2)) mod (3) = (0)", ""),
        ("(x) < (y + 1) <= (z)", ""),
        ("(x) in {(1), (2)} and (y) in (1)..(2)", ""),
        ("(a since (b)) since (c or d)", ""),
        ("(a -> (b -> c)) -> (d <-> (e xor (f)))", ""),
        ("(a) and (b) and (c) and (d) and (e)", ""),
        ("(if (a) then (b) else (c)) or (d)", ""),
        (
            "(forall i in 0..1: (h[i] > (0))) and (count i in 0..1: (g[i])) = (1)",
            "",
        ),
        (
            "(/* ) */ a // ( \n -> c /* ( */ ) and (\n c\n -> (a) // )\n )",
            "",
        ),
        (
            "(a /* ) */) responds to (b // (\n) within 3 steps after (c)",
            "",
        ),
        ("once (a) within 2 steps or previous ((b) or (c))", ""),
    ] {
        let (text, mut file) = parsed(written);
        let all = formula(&mut file).clone();
        let text_of = |e: &Expr| &text[e.span.start as usize..e.span.end as usize];
        let whole = if whole.is_empty() { written } else { whole };
        assert_eq!(text_of(&all), whole);
        let mut open = vec![&all];
        while let Some(part) = open.pop() {
            let mut wanted = file.clone();
            *formula(&mut wanted) = part.clone();
            let (_, alone) = parsed(text_of(part));
            let (alone, wanted) = (alone.without_spans(), wanted.without_spans());
            assert_eq!(alone, wanted, "{}", text_of(part));
            open.extend(part.children());
        }
    }
}
