//! The words of the language that cannot be names.
//!
//! The grammar needs them as a rule of its own (`reserved` in `lw.pest`); everything else asks this
//! table: messages of the parser, the first look at brackets, and whoever prints contracts.
//! `tests/language/words.rs` compares the two.

/// The letters of temporal operators. Among skills they are names.
const TEMPORAL_LETTERS: [&str; 5] = ["GF", "G", "F", "X", "O"];

/// Words of expressions.
const EXPRESSION: [&str; 25] = [
    "always",
    "eventually",
    "next",
    "not",
    "and",
    "or",
    "xor",
    "implies",
    "iff",
    "mod",
    "if",
    "then",
    "else",
    "forall",
    "exists",
    "count",
    "sum",
    "true",
    "false",
    "in",
    "never",
    "previous",
    "once",
    "historically",
    "since",
];

/// Words that begin an item; no expression can hold them.
const ITEMS: [&str; 13] = [
    "input",
    "output",
    "internal",
    "define",
    "assume",
    "guarantee",
    "contract",
    "moore",
    "machine",
    "line",
    "import",
    "type",
    "const",
];

/// Words that cannot be names.
pub fn reserved() -> impl Iterator<Item = &'static str> {
    EXPRESSION.into_iter().chain(ITEMS).chain(TEMPORAL_LETTERS)
}

/// Whether a word cannot be a name.
pub fn is_reserved(word: &str) -> bool {
    reserved().any(|reserved| reserved == word)
}

/// Whether a word cannot be a name among skills, where the letters of temporal operators mean
/// nothing.
pub(super) fn is_reserved_among_skills(word: &str) -> bool {
    is_reserved(word) && !TEMPORAL_LETTERS.contains(&word)
}

/// Whether a word begins an item, so that no expression can hold it.
pub(super) fn ends_expressions(word: &str) -> bool {
    ITEMS.contains(&word)
}
