//! Keywords of the language, which cannot be names.
//!
//! The grammar has its own rule for keywords (`reserved` in `lw.pest`). This table serves the
//! parser's messages, the bracket scan and the printers of contracts. `tests/language/words.rs`
//! checks that the two agree.

/// Letters of temporal operators. In skill sets they can be names.
const TEMPORAL_LETTERS: [&str; 5] = ["GF", "G", "F", "X", "O"];

/// Keywords of expressions.
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

/// Keywords that begin an item; they never occur in an expression.
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

/// Returns the words that cannot be names.
pub fn reserved_words() -> impl Iterator<Item = &'static str> {
    EXPRESSION.into_iter().chain(ITEMS).chain(TEMPORAL_LETTERS)
}

/// Returns whether a word cannot be a name.
pub fn is_reserved(word: &str) -> bool {
    reserved_words().any(|reserved| reserved == word)
}

/// Returns whether a word cannot be a name in a skill set, where the letters of temporal operators
/// have no meaning.
pub(super) fn is_reserved_among_skills(word: &str) -> bool {
    is_reserved(word) && !TEMPORAL_LETTERS.contains(&word)
}

/// Returns whether a word begins an item, so that it cannot occur in an expression.
pub(super) fn ends_expressions(word: &str) -> bool {
    ITEMS.contains(&word)
}
