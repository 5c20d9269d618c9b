//! The operators and their precedence.
//!
//! The order is that of the format's definition, tightest first: `SIZEOF MIN MAX SIZE SUM PROD`,
//! `*`, `/ %`, `+ -`, set operators, comparisons, `IN`, `! X G F &&[..] ||[..]`, `&&`, `||`,
//! `-> <->`, `W`, `U`, `R`, `~`, `:`. So `a -> b W c` is `(a -> b) W c`.

use super::ast::{BigOperator, Binary, Unary};

/// Binding powers of prefix operators, by the type of their operand.
const NUMBER: u8 = 150;
const SET: u8 = 110;
const FORMULA: u8 = 70;

/// The binary operator of a word, its binding power, and whether it is right-associative.
pub(super) fn infix(word: &str) -> Option<(Binary, u8, bool)> {
    use Binary as B;
    Some(match word {
        "*" | "MUL" => (B::Times, 140, false),
        "/" | "DIV" => (B::Divide, 130, true),
        "%" | "MOD" => (B::Modulo, 130, true),
        "+" | "PLUS" => (B::Plus, 120, false),
        "-" | "MINUS" => (B::Minus, 120, false),
        "(-)" | "(\\)" | "SETMINUS" => (B::SetMinus, 100, true),
        "(*)" | "CAP" => (B::Cap, 95, false),
        "(+)" | "CUP" => (B::Cup, 90, false),
        "==" | "EQ" => (B::Equal, 80, false),
        "/=" | "!=" | "NEQ" => (B::Unequal, 80, false),
        ">" | "GE" => (B::Greater, 80, false),
        ">=" | "GEQ" => (B::GreaterEqual, 80, false),
        "<" | "LE" => (B::Less, 80, false),
        "<=" | "LEQ" => (B::LessEqual, 80, false),
        "<-" | "IN" | "ELEM" => (B::Element, 75, false),
        "&&" | "AND" => (B::And, 60, false),
        "||" | "OR" => (B::Or, 50, false),
        "->" | "IMPLIES" => (B::Implies, 40, true),
        "<->" | "EQUIV" => (B::Equivalent, 40, true),
        "W" => (B::Weak, 35, true),
        "U" => (B::Until, 30, true),
        "R" => (B::Release, 25, false),
        "~" => (B::Pattern, 20, false),
        ":" => (B::Colon, 10, false),
        _ => return None,
    })
}

pub(super) fn big(word: &str) -> Option<(BigOperator, u8)> {
    Some(match word {
        "+" | "SUM" => (BigOperator::Sum, NUMBER),
        "*" | "PROD" => (BigOperator::Product, NUMBER),
        "(+)" | "CUP" => (BigOperator::Cup, SET),
        "(*)" | "CAP" => (BigOperator::Cap, SET),
        "&&" | "AND" | "FORALL" => (BigOperator::And, FORMULA),
        "||" | "OR" | "EXISTS" => (BigOperator::Or, FORMULA),
        _ => return None,
    })
}

pub(super) fn prefix(word: &str) -> Option<(Unary, u8)> {
    Some(match word {
        "SIZEOF" => (Unary::SizeOf, NUMBER),
        "SIZE" => (Unary::Size, NUMBER),
        "MIN" => (Unary::Min, NUMBER),
        "MAX" => (Unary::Max, NUMBER),
        "!" | "NOT" => (Unary::Not, FORMULA),
        "X" => (Unary::Next, FORMULA),
        "G" => (Unary::Globally, FORMULA),
        "F" => (Unary::Finally, FORMULA),
        _ => return None,
    })
}

/// Whether a word is reserved.
pub(crate) fn is_reserved(word: &str) -> bool {
    let letters = word.starts_with(|c: char| c.is_ascii_alphabetic());
    (letters && (infix(word).is_some() || prefix(word).is_some() || big(word).is_some()))
        || matches!(word, "true" | "false" | "otherwise" | "_" | "enum")
}
