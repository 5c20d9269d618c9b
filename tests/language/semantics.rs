//! The meaning of formulas. Random formulas are written as text with as few brackets and in as many
//! notations as the grammar allows; the parser must find the original tree, and the resolver's
//! result must have, for every valuation, the value of a direct evaluation of the syntax tree. That
//! evaluation is independent of the resolver.
#![expect(
    clippy::match_same_arms,
    reason = "an arm is an option with its weight"
)]

use linewright::contract::{Contract, load};
use linewright::diagnostics::has_errors;
use linewright::gr1::{self, Domain};
use linewright::source::FileId;
use linewright::syntax::ast::{
    BinaryOp, ContractItem, Define, DomainKind, Expr, ExprKind, Item, Quantifier,
};
use linewright::syntax::parse;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write as _;

const HEADER: &str = "\
const K = 3
const ROW: array[3] of 0..2 = [2, 0, 1]
type Colour = {red, green, blue}
contract Test {
    input p, q: bool
    input n: 0..5
    output m: -3..4
    output c: Colour
    output h: array[3] of 0..4
    output f: array[2] of bool
    define big = n > K
    define total = h[0] + m
";

// ---- trees, and their text ----------------------------------------------------------------------

/// A generated formula. Operators are named as in the canonical form in which trees are compared.
#[derive(Debug, Clone)]
enum Tree {
    /// A name or literal.
    Leaf(String),
    /// An operator of a level with two operands.
    Binary(&'static str, Box<Tree>, Box<Tree>),
    /// `a < b <= c`
    Chain(&'static str, &'static str, Box<Tree>, Box<Tree>, Box<Tree>),
    Not(Box<Tree>),
    Neg(Box<Tree>),
    Next(Box<Tree>),
    Index(&'static str, Box<Tree>),
    Call(&'static str, Vec<Tree>),
    If(Box<Tree>, Box<Tree>, Box<Tree>),
    /// Word, name, type, body.
    Quantifier(&'static str, &'static str, &'static str, Box<Tree>),
    /// `x in {a, b}`
    Member(Box<Tree>, Vec<Tree>),
    /// `x in a..b`
    Within(Box<Tree>, Box<Tree>, Box<Tree>),
}

/// Levels of the grammar, loosest first.
const NEGATION: u8 = 5;
const COMPARISON: u8 = NEGATION + 1;
const SUM: u8 = COMPARISON + 1;
const PRODUCT: u8 = SUM + 1;
const SIGNED: u8 = PRODUCT + 1;
const ATOM: u8 = SIGNED + 1;

fn level(op: &str) -> u8 {
    match op {
        "<->" => 0,
        "->" => 1,
        "or" => 2,
        "xor" => 3,
        "and" => 4,
        "=" | "!=" | "<" | "<=" | ">" | ">=" => COMPARISON,
        "+" | "-" => SUM,
        _ => PRODUCT,
    }
}

fn notations(op: &'static str) -> &'static [&'static str] {
    match op {
        "<->" => &["<->", "<=>", "iff", "↔", "⇔"],
        "->" => &["->", "=>", "implies", "→", "⇒"],
        "or" => &["or", "|", "||", "\\/", "∨"],
        "and" => &["and", "&", "&&", "/\\", "∧"],
        "=" => &["=", "=="],
        "!=" => &["!=", "≠"],
        "<=" => &["<=", "≤"],
        ">=" => &[">=", "≥"],
        "not" => &["not ", "!", "~", "¬"],
        "next" => &["next ", "X ", "○", "O ", "◯"],
        "xor" => &["xor"],
        "<" => &["<"],
        ">" => &[">"],
        "+" => &["+"],
        "-" => &["-"],
        "*" => &["*"],
        "/" => &["/"],
        _ => &["mod"],
    }
}

/// A source of choices that shrinks well: when none are left, everything takes its first option.
struct Choices {
    bytes: Vec<u8>,
    at: usize,
}

impl Choices {
    fn pick(&mut self, n: usize) -> usize {
        let byte = self.bytes.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        byte as usize % n
    }

    fn of<T: Copy>(&mut self, options: &[T]) -> T {
        options[self.pick(options.len())]
    }
}

fn boxed(tree: Tree) -> Box<Tree> {
    Box::new(tree)
}

fn leaf(text: impl Into<String>) -> Tree {
    Tree::Leaf(text.into())
}

/// A truth value. `next`: whether it may contain `next`; `bound`: whether the number `i` in 0..2 is
/// in scope.
fn condition(c: &mut Choices, depth: usize, next: bool, bound: bool) -> Tree {
    if depth == 0 {
        return match c.pick(6) {
            0 => leaf("p"),
            1 => leaf("q"),
            2 => leaf("big"),
            3 => leaf(c.of(&["true", "false"])),
            4 => Tree::Index("f", boxed(leaf(c.of(&["0", "1"])))),
            _ => Tree::Binary(
                "=",
                boxed(leaf("c")),
                boxed(leaf(c.of(&["red", "green", "blue"]))),
            ),
        };
    }
    let d = depth - 1;
    match c.pick(14) {
        0 => condition(c, 0, next, bound),
        1..=4 => {
            let op = c.of(&["<->", "->", "or", "xor", "and"]);
            Tree::Binary(
                op,
                boxed(condition(c, d, next, bound)),
                boxed(condition(c, d, next, bound)),
            )
        }
        5 => Tree::Not(boxed(condition(c, d, next, bound))),
        6 | 7 => {
            let op = c.of(&["=", "!=", "<", "<=", ">", ">="]);
            Tree::Binary(
                op,
                boxed(number(c, d, next, bound)),
                boxed(number(c, d, next, bound)),
            )
        }
        8 => Tree::Binary(
            c.of(&["=", "!="]),
            boxed(condition(c, d, next, bound)),
            boxed(condition(c, d, next, bound)),
        ),
        9 if next => Tree::Next(boxed(condition(c, d, false, bound))),
        9 => Tree::Not(boxed(condition(c, d, next, bound))),
        10 => Tree::If(
            boxed(condition(c, d, next, bound)),
            boxed(condition(c, d, next, bound)),
            boxed(condition(c, d, next, bound)),
        ),
        11 => {
            let (word, ty) = (
                c.of(&["forall", "exists"]),
                c.of(&["0..2", "1..2", "2..1", "K-2..2"]),
            );
            Tree::Quantifier(word, "i", ty, boxed(condition(c, d, next, true)))
        }
        12 => match c.pick(3) {
            0 => Tree::Member(
                boxed(number(c, d, next, bound)),
                vec![number(c, d, next, bound), number(c, 0, next, bound)],
            ),
            1 => Tree::Within(
                boxed(number(c, d, next, bound)),
                boxed(number(c, 0, next, bound)),
                boxed(number(c, d, next, bound)),
            ),
            _ => Tree::Member(
                boxed(leaf("c")),
                vec![leaf("red"), leaf(c.of(&["green", "blue", "red"]))],
            ),
        },
        _ => Tree::Chain(
            c.of(&["<", "<=", "="]),
            c.of(&["<", ">=", "!="]),
            boxed(number(c, d, next, bound)),
            boxed(number(c, 0, next, bound)),
            boxed(number(c, d, next, bound)),
        ),
    }
}

fn number(c: &mut Choices, depth: usize, next: bool, bound: bool) -> Tree {
    if depth == 0 {
        return match c.pick(7) {
            0 => leaf("n"),
            1 => leaf("m"),
            2 => leaf(c.of(&["0", "1", "2", "7", "K"])),
            3 => leaf("total"),
            4 => Tree::Index("ROW", boxed(leaf(c.of(&["0", "1", "2"])))),
            5 if bound => leaf("i"),
            6 if bound => Tree::Index("h", boxed(leaf("i"))),
            _ => Tree::Index("h", boxed(leaf(c.of(&["0", "1", "2"])))),
        };
    }
    let d = depth - 1;
    match c.pick(12) {
        0 => number(c, 0, next, bound),
        1 | 2 => {
            let op = c.of(&["+", "-", "*"]);
            Tree::Binary(
                op,
                boxed(number(c, d, next, bound)),
                boxed(number(c, d, next, bound)),
            )
        }
        3 => {
            let divisor = match c.pick(3) {
                0 => leaf(c.of(&["2", "3", "K"])),
                1 => Tree::Neg(boxed(leaf(c.of(&["2", "3"])))),
                _ => Tree::Call("max", vec![number(c, d, next, bound), leaf("1")]),
            };
            Tree::Binary(
                c.of(&["/", "mod"]),
                boxed(number(c, d, next, bound)),
                boxed(divisor),
            )
        }
        4 => Tree::Neg(boxed(number(c, d, next, bound))),
        5 if next => Tree::Next(boxed(number(c, d, false, bound))),
        5 => Tree::Call("abs", vec![number(c, d, next, bound)]),
        6 => Tree::Call(
            c.of(&["min", "max"]),
            vec![
                number(c, d, next, bound),
                number(c, d, next, bound),
                number(c, 0, next, bound),
            ],
        ),
        7 => Tree::Call("abs", vec![number(c, d, next, bound)]),
        8 => Tree::If(
            boxed(condition(c, d, next, bound)),
            boxed(number(c, d, next, bound)),
            boxed(number(c, d, next, bound)),
        ),
        9 => {
            let index = Tree::Binary("mod", boxed(number(c, d, next, bound)), boxed(leaf("3")));
            Tree::Index(c.of(&["h", "ROW"]), boxed(index))
        }
        10 => Tree::Quantifier(
            "count",
            "i",
            c.of(&["0..2", "0..0"]),
            boxed(condition(c, d, next, true)),
        ),
        _ => Tree::Quantifier(
            "sum",
            "i",
            c.of(&["0..2", "1..2", "2..0"]),
            boxed(number(c, d, next, true)),
        ),
    }
}

/// Writes a tree where the grammar expects a level of at least `min`; `last`: whether only a
/// closing bracket or word follows.
fn write_tree(tree: &Tree, min: u8, last: bool, c: &mut Choices, out: &mut String) {
    let own = match tree {
        Tree::Leaf(_) | Tree::Index(..) | Tree::Call(..) => ATOM,
        Tree::Binary(op, ..) => level(op),
        Tree::Chain(..) | Tree::Member(..) | Tree::Within(..) => COMPARISON,
        Tree::Not(_) => NEGATION,
        Tree::Neg(_) | Tree::Next(_) => SIGNED,
        Tree::If(..) | Tree::Quantifier(..) if last && min <= NEGATION => ATOM,
        Tree::If(..) | Tree::Quantifier(..) => 0,
    };
    let wide = matches!(tree, Tree::If(..) | Tree::Quantifier(..)) && own == 0;
    if own < min || wide {
        out.push('(');
        write_tree(tree, 0, true, c, out);
        out.push(')');
        return;
    }
    let put =
        |t: &Tree, min, last, c: &mut Choices, out: &mut String| write_tree(t, min, last, c, out);
    match tree {
        Tree::Leaf(text) => out.push_str(text),
        Tree::Binary(op, a, b) => {
            let (left, right) = match *op {
                "->" => (own + 1, own),
                _ if own == COMPARISON => (own + 1, own + 1),
                _ => (own, own + 1),
            };
            put(a, left, false, c, out);
            out.push(' ');
            out.push_str(c.of(notations(op)));
            out.push(' ');
            put(b, right, last, c, out);
        }
        Tree::Chain(first, second, x, y, z) => {
            put(x, own + 1, false, c, out);
            let _ = write!(out, " {first} ");
            put(y, own + 1, false, c, out);
            let _ = write!(out, " {second} ");
            put(z, own + 1, last, c, out);
        }
        Tree::Not(a) => {
            out.push_str(c.of(notations("not")));
            put(a, NEGATION, last, c, out);
        }
        Tree::Neg(a) => {
            out.push('-');
            put(a, SIGNED, last, c, out);
        }
        Tree::Next(a) if c.pick(2) == 0 => {
            put(a, ATOM, false, c, out);
            out.push('\'');
        }
        Tree::Next(a) => {
            out.push_str(c.of(notations("next")));
            put(a, SIGNED, last, c, out);
        }
        Tree::Index(name, index) => {
            out.push_str(name);
            out.push('[');
            put(index, 0, true, c, out);
            out.push(']');
        }
        Tree::Call(name, arguments) => {
            out.push_str(name);
            out.push('(');
            for (i, a) in arguments.iter().enumerate() {
                if i > 0 {
                    out.push_str(", ");
                }
                put(a, 0, true, c, out);
            }
            out.push(')');
        }
        Tree::If(x, y, z) => {
            out.push_str("if ");
            put(x, 0, true, c, out);
            out.push_str(" then ");
            put(y, 0, true, c, out);
            out.push_str(" else ");
            put(z, 0, true, c, out);
        }
        Tree::Quantifier(word, name, ty, body) => {
            let _ = write!(out, "{word} {name} in {ty}: ");
            put(body, 0, true, c, out);
        }
        Tree::Member(x, members) => {
            put(x, own + 1, false, c, out);
            out.push_str(" in {");
            for (i, m) in members.iter().enumerate() {
                if i > 0 {
                    out.push_str(", ");
                }
                put(m, 0, true, c, out);
            }
            out.push('}');
        }
        Tree::Within(x, low, high) => {
            put(x, own + 1, false, c, out);
            out.push_str(" in ");
            put(low, SUM, false, c, out);
            out.push_str("..");
            put(high, SUM, last, c, out);
        }
    }
}

// ---- one form for both kinds of trees -----------------------------------------------------------

/// An operator and its operands. If grouping does not matter, operands with the same operator are
/// flattened.
fn join(op: &str, operands: Vec<String>) -> String {
    let open = format!("({op} ");
    let free = ["and", "or", "xor", "<->", "+", "*"].contains(&op);
    let operands: Vec<String> = operands
        .into_iter()
        .map(|o| match o.strip_prefix(&open) {
            Some(inner) if free => inner[..inner.len() - 1].to_owned(),
            _ => o,
        })
        .collect();
    format!("{open}{})", operands.join(" "))
}

fn form(tree: &Tree) -> String {
    let all = |list: &[Tree]| list.iter().map(form).collect();
    match tree {
        Tree::Leaf(text) => text.clone(),
        Tree::Binary(op, a, b) => join(op, vec![form(a), form(b)]),
        Tree::Chain(first, second, x, y, z) => {
            let y = form(y);
            join(
                "and",
                vec![
                    join(first, vec![form(x), y.clone()]),
                    join(second, vec![y, form(z)]),
                ],
            )
        }
        Tree::Not(a) => join("not", vec![form(a)]),
        Tree::Neg(a) => join("neg", vec![form(a)]),
        Tree::Next(a) => join("next", vec![form(a)]),
        Tree::Index(name, i) => join("index", vec![(*name).to_owned(), form(i)]),
        Tree::Call(name, list) => join(name, all(list)),
        Tree::If(a, b, c) => join("if", vec![form(a), form(b), form(c)]),
        Tree::Quantifier(word, name, _, body) => join(word, vec![(*name).to_owned(), form(body)]),
        Tree::Member(x, list) => {
            let mut operands: Vec<String> = all(list);
            operands.insert(0, form(x));
            join("in", operands)
        }
        Tree::Within(a, b, c) => join("within", vec![form(a), form(b), form(c)]),
    }
}

fn form_of(e: &Expr) -> String {
    let mut operands: Vec<String> = e.children().into_iter().map(form_of).collect();
    let op = match &e.kind {
        ExprKind::Bool(b) => return b.to_string(),
        ExprKind::Int(i) => return i.to_string(),
        ExprKind::Quantity(x, unit) => return format!("{x} {unit}"),
        ExprKind::Path(names) => {
            return names
                .iter()
                .map(|n| n.text.as_str())
                .collect::<Vec<_>>()
                .join(".");
        }
        ExprKind::Index(..) => "index",
        ExprKind::Next(_) => "next",
        ExprKind::Always(_) => "always",
        ExprKind::Eventually(_) => "eventually",
        ExprKind::Not(_) => "not",
        ExprKind::Neg(_) => "neg",
        ExprKind::Binary(op, ..) => op.sign(),
        ExprKind::If(..) => "if",
        ExprKind::Quantifier(kind, name, ..) => {
            operands.insert(0, name.text.clone());
            match kind {
                Quantifier::Forall => "forall",
                Quantifier::Exists => "exists",
                Quantifier::Count => "count",
                Quantifier::Sum => "sum",
                Quantifier::Array => "array",
            }
        }
        ExprKind::Call(name, _) => return join(&name.text, operands),
        ExprKind::List(_) => "list",
        ExprKind::Member(..) => "in",
        ExprKind::Within(..) => "within",
        ExprKind::Field(_, name) => return join(&name.text, operands),
        ExprKind::Record(_) => "record",
        ExprKind::Past(op, ..) => op.word(),
        ExprKind::Since(..) => "since",
        ExprKind::Until(op, ..) => op.word(),
        ExprKind::Pattern(_) => "pattern",
        ExprKind::Unknown => "unknown",
    };
    join(op, operands)
}

// ---- the meaning, directly ----------------------------------------------------------------------

#[derive(Debug, Clone, PartialEq)]
enum Value {
    Number(i64),
    Truth(bool),
    Label(String),
    Array(Vec<Value>),
}

impl Value {
    fn number(&self) -> i64 {
        match self {
            Self::Number(n) => *n,
            other => panic!("{other:?} is no number"),
        }
    }

    fn truth(&self) -> bool {
        match self {
            Self::Truth(b) => *b,
            other => panic!("{other:?} is no truth value"),
        }
    }
}

type Valuation = BTreeMap<String, Value>;

struct Meaning<'a> {
    defines: BTreeMap<&'a str, &'a Expr>,
    constants: BTreeMap<&'a str, &'a Expr>,
    now: Valuation,
    next: Valuation,
}

impl Meaning<'_> {
    fn of(&self, e: &Expr, later: bool, bound: &[(String, i64)]) -> Value {
        let value = |x: &Expr| self.of(x, later, bound);
        let number = |x: &Expr| self.of(x, later, bound).number();
        let truth = |x: &Expr| self.of(x, later, bound).truth();
        match &e.kind {
            ExprKind::Bool(b) => Value::Truth(*b),
            ExprKind::Int(i) => Value::Number(*i),
            ExprKind::Path(names) => self.name(&names[0].text, later, bound),
            ExprKind::Index(base, index) => {
                let (Value::Array(values), i) = (value(base), number(index)) else {
                    panic!("no array");
                };
                values[usize::try_from(i).expect("an index")].clone()
            }
            ExprKind::Next(inner) => self.of(inner, true, bound),
            ExprKind::Not(a) => Value::Truth(!truth(a)),
            ExprKind::Neg(a) => Value::Number(-number(a)),
            ExprKind::Binary(op, a, b) => match op {
                BinaryOp::Iff => Value::Truth(truth(a) == truth(b)),
                BinaryOp::Implies => Value::Truth(!truth(a) || truth(b)),
                BinaryOp::Or => Value::Truth(truth(a) || truth(b)),
                BinaryOp::Xor => Value::Truth(truth(a) != truth(b)),
                BinaryOp::And => Value::Truth(truth(a) && truth(b)),
                BinaryOp::Eq => Value::Truth(value(a) == value(b)),
                BinaryOp::Ne => Value::Truth(value(a) != value(b)),
                BinaryOp::Lt => Value::Truth(number(a) < number(b)),
                BinaryOp::Le => Value::Truth(number(a) <= number(b)),
                BinaryOp::Gt => Value::Truth(number(a) > number(b)),
                BinaryOp::Ge => Value::Truth(number(a) >= number(b)),
                BinaryOp::Add => Value::Number(number(a) + number(b)),
                BinaryOp::Sub => Value::Number(number(a) - number(b)),
                BinaryOp::Mul => Value::Number(number(a) * number(b)),
                BinaryOp::Div => Value::Number(floored(number(a), number(b))),
                BinaryOp::Mod => {
                    let (a, b) = (number(a), number(b));
                    Value::Number(a - b * floored(a, b))
                }
            },
            ExprKind::If(c, a, b) => value(if truth(c) { a } else { b }),
            ExprKind::Quantifier(kind, name, domain, body) => {
                let DomainKind::Range(low, high, _) = &domain.kind else {
                    panic!("not generated");
                };
                let each = (number(low)..=number(high)).map(|i| {
                    let mut bound = bound.to_vec();
                    bound.push((name.text.clone(), i));
                    self.of(body, later, &bound)
                });
                let each: Vec<Value> = each.collect();
                match kind {
                    Quantifier::Forall => Value::Truth(each.iter().all(Value::truth)),
                    Quantifier::Exists => Value::Truth(each.iter().any(Value::truth)),
                    Quantifier::Count => {
                        Value::Number(each.iter().filter(|v| v.truth()).count() as i64)
                    }
                    Quantifier::Sum => Value::Number(each.iter().map(Value::number).sum()),
                    Quantifier::Array => Value::Array(each),
                }
            }
            ExprKind::Call(name, list) => {
                let values = list.iter().map(number);
                Value::Number(
                    match name.text.as_str() {
                        "min" => values.min(),
                        "max" => values.max(),
                        _ => values.map(i64::abs).next(),
                    }
                    .expect("an argument"),
                )
            }
            ExprKind::List(list) => Value::Array(list.iter().map(value).collect()),
            ExprKind::Member(x, list) => {
                let x = value(x);
                Value::Truth(list.iter().any(|m| value(m) == x))
            }
            ExprKind::Within(x, low, high) => {
                Value::Truth((number(low)..=number(high)).contains(&number(x)))
            }
            other => panic!("not generated: {other:?}"),
        }
    }

    fn name(&self, name: &str, later: bool, bound: &[(String, i64)]) -> Value {
        if let Some((_, i)) = bound.iter().rev().find(|(n, _)| n == name) {
            return Value::Number(*i);
        }
        if let Some(body) = self.defines.get(name) {
            return self.of(body, later, &[]);
        }
        let valuation = if later { &self.next } else { &self.now };
        if let Some(value) = valuation.get(name) {
            return value.clone();
        }
        match self.constants.get(name) {
            Some(body) => self.of(body, later, &[]),
            None => Value::Label(name.to_owned()),
        }
    }
}

fn floored(a: i64, b: i64) -> i64 {
    (a as f64 / b as f64).floor() as i64
}

/// Values for all variables, as stored in the program and in the evaluation above.
fn valuation(contract: &Contract, c: &mut Choices) -> (Vec<i64>, Valuation) {
    let mut shown = Valuation::new();
    let mut raw = Vec::new();
    for variable in &contract.specification.variables {
        let domain = &variable.domain;
        let value = domain.low() + c.pick(domain.size() as usize) as i64;
        raw.push(value);
        let value = match domain {
            Domain::Bool => Value::Truth(value == 1),
            Domain::Range { .. } => Value::Number(value),
            Domain::Enum { labels, .. } => Value::Label(labels[value as usize].clone()),
        };
        match variable.name.split_once('[') {
            None => {
                shown.insert(variable.name.clone(), value);
            }
            Some((array, _)) => {
                let entry = shown
                    .entry(array.to_owned())
                    .or_insert(Value::Array(Vec::new()));
                if let Value::Array(values) = entry {
                    values.push(value);
                }
            }
        }
    }
    (raw, shown)
}

fn resolved(text: &str) -> Contract {
    let (library, findings) = load(&[("test.lw".to_owned(), text.to_owned())], &|_, _| {
        Err("no imports".to_owned())
    });
    assert!(!has_errors(&findings), "{text}\n{findings:#?}");
    library.contracts.into_iter().next().expect("a contract")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn formulas_mean_what_they_say(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut c = Choices { bytes, at: 0 };
        let depth = 1 + c.pick(4);
        let tree = condition(&mut c, depth, true, false);
        let mut formula = String::new();
        write_tree(&tree, 0, true, &mut c, &mut formula);
        let text = format!("{HEADER}    guarantee g: always ({formula})\n}}\n");

        let (file, findings) = parse(FileId(0), &text);
        prop_assert!(findings.is_empty(), "{formula}\n{findings:#?}");
        let mut meaning = Meaning {
            defines: BTreeMap::new(),
            constants: BTreeMap::new(),
            now: Valuation::new(),
            next: Valuation::new(),
        };
        let mut parsed = None;
        for item in &file.items {
            match item {
                Item::Const(d) => {
                    meaning.constants.insert(&d.name.text, &d.value);
                }
                Item::Contract(contract) => {
                    for item in &contract.items {
                        match item {
                            ContractItem::Define(Define { name, value, .. }) => {
                                meaning.defines.insert(&name.text, value);
                            }
                            ContractItem::Formula { expr, .. } => parsed = Some(expr),
                            _ => {}
                        }
                    }
                }
                _ => {}
            }
        }
        let Some(Expr { kind: ExprKind::Always(parsed), .. }) = parsed else {
            panic!("no formula in {text}");
        };
        prop_assert_eq!(form_of(parsed), form(&tree), "{}", formula);

        let contract = resolved(&text);
        let side = &contract.specification.guarantees;
        let lowered: Vec<_> = side.invariants.iter().chain(&side.safety).collect();
        prop_assert_eq!(lowered.len(), 1);
        for _ in 0..8 {
            let (now, shown_now) = valuation(&contract, &mut c);
            let (next, shown_next) = valuation(&contract, &mut c);
            (meaning.now, meaning.next) = (shown_now, shown_next);
            let expected = meaning.of(parsed, false, &[]).truth();
            let found = gr1::eval::holds(&lowered[0].expr, &now, &next);
            prop_assert_eq!(found, expected, "{} at {:?}, then {:?}", formula, meaning.now, meaning.next);
        }
    }
}

// ---- notations and precedence -------------------------------------------------------------------

/// The tree of a formula in canonical form.
fn tree_of(formula: &str) -> String {
    let text = format!("contract Test {{ guarantee g: {formula} }}");
    let (file, findings) = parse(FileId(0), &text);
    assert!(findings.is_empty(), "{formula}: {findings:#?}");
    match &file.items[0] {
        Item::Contract(c) => match &c.items[0] {
            ContractItem::Formula { expr, .. } => form_of(expr),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn all_notations_agree() {
    let groups: &[&[&str]] = &[
        &[
            "always eventually p",
            "G F p",
            "GF p",
            "[]<>p",
            "[] <> p",
            "□◇p",
            "□ ◊ p",
            "always F p",
            "G eventually p",
        ],
        &["always p", "G p", "[] p", "□p", "G(p)"],
        &[
            "always (p -> next q)",
            "always (p -> X(q))",
            "always (p -> X q)",
            "always (p -> q')",
            "□ (p → ○q)",
            "[](p => O q)",
        ],
        &[
            "always (p -> next (not q))",
            "always (p -> next not q)",
            "G (p -> X !q)",
            "□ (p → ○¬q)",
        ],
        &["p and q", "p & q", "p && q", "p /\\ q", "p ∧ q"],
        &["p or q", "p | q", "p || q", "p \\/ q", "p ∨ q"],
        &["not p", "!p", "~p", "¬p", "! p"],
        &["p -> q", "p => q", "p implies q", "p → q", "p ⇒ q"],
        &["p <-> q", "p <=> q", "p iff q", "p ↔ q", "p ⇔ q"],
        &["n != 1", "n ≠ 1"],
        &["n <= 1", "n ≤ 1"],
        &["n >= 1", "n ≥ 1"],
        &["n = 1", "n == 1"],
    ];
    for group in groups {
        for notation in *group {
            assert_eq!(tree_of(notation), tree_of(group[0]), "{notation}");
        }
    }
}

/// The rows of the table in tests/cases/README.md, section "Precedence": a formula, and the same
/// with all its brackets.
fn table() -> Vec<(String, String)> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/README.md");
    let text = std::fs::read_to_string(path).expect("the page");
    let (_, section) = text.split_once("## Precedence").expect("the section");
    let rows = section.lines().filter_map(|line| {
        let cells: Vec<&str> = line
            .strip_prefix("| `")?
            .strip_suffix("` |")?
            .split("` | `")
            .collect();
        let cell = |i: usize| cells.get(i).map(|c| c.replace("\\|", "|"));
        Some((cell(0)?, cell(1)?))
    });
    rows.collect()
}

#[test]
fn precedence_is_as_documented() {
    let rows = table();
    assert!(rows.len() > 20, "only {} rows", rows.len());
    for (formula, bracketed) in rows {
        assert_eq!(tree_of(&formula), tree_of(&bracketed), "{formula}");
    }
}
