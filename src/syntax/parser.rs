//! From text to a syntax tree and findings.
//!
//! pest stops at the first mistake, so recovery is in the grammar: what does not match an item is taken by a `bad_*` rule up
//! to the next item, and [`explain`] parses that piece once more with the rule that its first word asks for. The
//! error of that second parse says what was expected where.

use super::ast::File;
use super::build::Builder;
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};
use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};

#[allow(missing_docs)] // the derive makes an undocumented enum of the rules
mod grammar {
    #[derive(pest_derive::Parser)]
    #[grammar = "syntax/lw.pest"]
    pub struct Grammar;
}
pub(super) use grammar::{Grammar, Rule};

/// Brackets, conditionals and prefixes within one item may nest so deep, which bounds the stack that parsing needs.
const MAX_DEPTH: usize = 200;
/// Enough for `MAX_DEPTH` levels of the grammar's recursion, with a margin.
const STACK_BYTES: usize = 256 << 20;

/// Parses one file. What could not be understood is in the findings, the tree holds the rest.
pub fn parse(file: FileId, text: &str) -> (File, Vec<Diagnostic>) {
    if let Some(finding) = too_deep(file, text) {
        return (File::default(), vec![finding]);
    }
    let run = || {
        let mut builder = Builder::new(file);
        match Grammar::parse(Rule::file, text) {
            Ok(pairs) => builder.file(pairs),
            Err(error) => builder.findings.push(finding_of(file, 0, text, &error)),
        }
        (builder.tree, builder.findings)
    };
    if text.len() < 512 || !needs_stack(text) {
        return run();
    }
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, run)
            .ok()
            .and_then(|handle| handle.join().ok())
    })
    .unwrap_or_else(|| {
        let finding = Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, 0, 0),
            "there is not enough memory to parse this file",
        );
        (File::default(), vec![finding])
    })
}

/// Whether nesting goes beyond what a small stack holds.
fn needs_stack(text: &str) -> bool {
    nesting(text).0 > 12
}

fn too_deep(file: FileId, text: &str) -> Option<Diagnostic> {
    let (depth, offset) = nesting(text);
    (depth > MAX_DEPTH).then(|| {
        Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, offset, offset + 1),
            format!("this is nested more than {MAX_DEPTH} levels deep"),
        )
        .with_help("give the inner parts names with `define`, or use a constant array instead of a long `if ... else if`")
    })
}

/// A bound on how deep the grammar recurses: open brackets, plus the prefix words, signs and implications since the last
/// item word. Returns the largest value and where it was reached.
fn nesting(text: &str) -> (usize, usize) {
    let bytes = text.as_bytes();
    let (mut open, mut prefixes) = (0usize, 0usize);
    let (mut worst, mut place) = (0, 0);
    let mut i = 0;
    while i < bytes.len() {
        let rest = &text.as_bytes()[i..];
        if rest.starts_with(b"//") {
            i += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            continue;
        }
        if rest.starts_with(b"/*") {
            let end = rest.windows(2).position(|w| w == b"*/");
            i += end.map_or(rest.len(), |e| e + 2);
            continue;
        }
        match bytes[i] {
            b'(' | b'[' | b'{' => open += 1,
            b')' | b']' | b'}' => open = open.saturating_sub(1),
            b if b.is_ascii_alphabetic() || b == b'_' => {
                let end = rest
                    .iter()
                    .position(|b| !b.is_ascii_alphanumeric() && *b != b'_')
                    .unwrap_or(rest.len());
                match &text[i..i + end] {
                    "if" | "always" | "eventually" | "forall" | "exists" | "count" | "sum" => {
                        prefixes += 1;
                    }
                    "assume" | "guarantee" | "define" | "input" | "output" | "internal"
                    | "action" | "operation" | "write" | "abstract" | "const" | "contract"
                    | "machine" | "station" | "route" => prefixes = 0,
                    _ => {}
                }
                i += end - 1;
            }
            _ => {}
        }
        if open + prefixes > worst {
            (worst, place) = (open + prefixes, i);
        }
        i += 1;
    }
    (worst, place)
}

/// What is wrong with a piece that matched no item. `context` is the `bad_*` rule that took it.
pub(super) fn explain(file: FileId, start: usize, piece: &str, context: Rule) -> Diagnostic {
    let text = piece.trim_end();
    let first: String = text
        .trim_start_matches(|c: char| c.is_whitespace())
        .chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .collect();
    let rule = match (context, first.as_str()) {
        (_, "import") => Some(Rule::only_import),
        (_, "type") => Some(Rule::only_type_decl),
        (_, "const") => Some(Rule::only_const_decl),
        (Rule::bad_item, "contract" | "moore") => Some(Rule::only_contract),
        (Rule::bad_item, "machine") => Some(Rule::only_machine),
        (Rule::bad_item, "line") => Some(Rule::only_line),
        (Rule::bad_contract_item, "input" | "output" | "internal") => Some(Rule::only_variables),
        (Rule::bad_contract_item, "define") => Some(Rule::only_define),
        (Rule::bad_contract_item, "assume" | "guarantee") => Some(Rule::only_formula),
        (
            Rule::bad_machine_item,
            "step" | "idle" | "power" | "limit" | "failures" | "property" | "parameter" | "signal"
            | "abstract" | "coordinator" | "action" | "operation" | "done" | "write",
        ) => Some(Rule::only_machine_item),
        (
            Rule::bad_line_item,
            "part" | "product" | "source" | "store" | "sink" | "buffer" | "conveyor" | "station"
            | "route" | "requirement" | "shift" | "limit",
        ) => Some(Rule::only_line_item),
        (Rule::bad_station_item, "perform" | "setup" | "defect" | "failures") => {
            Some(Rule::only_station_item)
        }
        (Rule::bad_component_item, _) if !first.is_empty() => Some(Rule::only_component_item),
        _ => None,
    };
    if let Some(rule) = rule
        && let Err(error) = Grammar::parse(rule, text)
    {
        return finding_of(file, start, text, &error);
    }
    let shown: String = text.chars().take_while(|c| *c != '\n').take(30).collect();
    let width = shown.len().max(1);
    let span = Span::new(file, start, start + width);
    let operator = word_at(text);
    if text.starts_with(['&', '|', '+', '-', '*', '/', '<', '>', '=', '!'])
        || ["and", "or", "xor", "implies", "iff", "mod", "not"].contains(&operator.as_str())
    {
        return Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, start, start + operator.len()),
            format!("an operand is missing beside `{operator}`"),
        )
        .with_help("an operator stands between two expressions");
    }
    if text.starts_with('[') {
        return Diagnostic::error(
            codes::SYNTAX,
            span,
            "an index or length does not belong here",
        )
        .with_help("an array's type is written `array[3] of bool`");
    }
    Diagnostic::error(
        codes::SYNTAX,
        span,
        format!("`{}` does not belong here", shown.trim_end()),
    )
    .with_help(match context {
        Rule::bad_contract_item => {
            "a contract holds `input`, `output`, `internal`, `define`, `assume` and `guarantee`; is an operator missing before this?"
        }
        Rule::bad_machine_item => {
            "a machine holds `property`, `parameter`, `signal`, `abstract`, `coordinator`, `action`, `operation`, `done`, `write`, `step`, `power`, `idle power`, `limit` and `failures`"
        }
        Rule::bad_component_item => "a component holds bindings `input = ...`, `time` and `power`",
        Rule::bad_line_item => {
            "a line holds `part`, `product`, `source`, `store`, `sink`, `buffer`, `conveyor`, `station`, `route`, `requirement`, `shift` and `limit`"
        }
        Rule::bad_station_item => "a station holds `perform`, `setup`, `defect` and `failures`",
        _ => "a file holds `import`, `type`, `const`, `contract`, `machine` and `line`",
    })
}

fn finding_of(
    file: FileId,
    start: usize,
    text: &str,
    error: &pest::error::Error<Rule>,
) -> Diagnostic {
    let at = match error.location {
        InputLocation::Pos(p) | InputLocation::Span((p, _)) => p,
    };
    // Point at the word that does not fit, not at the blank before it.
    let at = at + text[at..].len() - text[at..].trim_start().len();
    let word: String = word_at(&text[at..]);
    let expected = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => expectations(positives),
        ErrorVariant::CustomError { message } => message.clone(),
    };
    let end = at + word.len();
    let message = if word.is_empty() {
        "something is missing here".to_owned()
    } else {
        format!("`{word}` does not fit here")
    };
    let span = Span::new(
        file,
        start + at,
        start + end.max(at + usize::from(at < text.len())),
    );
    let finding = Diagnostic::error(codes::SYNTAX, span, message);
    if RESERVED.contains(&word.as_str()) && expected.contains("a name") {
        return finding.with_help(format!(
            "expected {expected}; `{word}` is a word of the language and cannot be a name"
        ));
    }
    if expected.is_empty() {
        finding
    } else {
        finding.with_help(format!("expected {expected}"))
    }
}

const RESERVED: &[&str] = &[
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
    "GF",
    "G",
    "F",
    "X",
    "O",
];

fn word_at(text: &str) -> String {
    let mut chars = text.chars();
    let Some(first) = chars.next() else {
        return String::new();
    };
    if first.is_alphanumeric() || first == '_' {
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    } else {
        first.to_string()
    }
}

/// The rules that could have matched, in words; several rules share one phrase.
fn expectations(rules: &[Rule]) -> String {
    let mut words: Vec<String> = Vec::new();
    for rule in rules {
        // A keyword's rule is called `k_` and the word.
        let name = format!("{rule:?}");
        if let Some(keyword) = name.strip_prefix("k_") {
            let word = format!("`{keyword}`");
            if !words.contains(&word) {
                words.push(word);
            }
            continue;
        }
        let word = match rule {
            Rule::name | Rule::path => "a name",
            Rule::integer => "a whole number",
            Rule::expression
            | Rule::iff
            | Rule::implication
            | Rule::disjunction
            | Rule::exclusive
            | Rule::conjunction
            | Rule::negation
            | Rule::prefix
            | Rule::comparison
            | Rule::additive
            | Rule::product
            | Rule::signed
            | Rule::sign
            | Rule::postfix
            | Rule::atom
            | Rule::parenthesis
            | Rule::list
            | Rule::call
            | Rule::quantity
            | Rule::boolean
            | Rule::wide
            | Rule::conditional
            | Rule::quantifier
            | Rule::wide_always
            | Rule::wide_eventually
            | Rule::not_op
            | Rule::next_op
            | Rule::minus
            | Rule::always_word
            | Rule::eventually_word
            | Rule::tight_always
            | Rule::tight_eventually
            | Rule::quantifier_op
            | Rule::real => "an expression",
            Rule::iff_op
            | Rule::implies_op
            | Rule::or_op
            | Rule::xor_op
            | Rule::and_op
            | Rule::compare_op
            | Rule::add_op
            | Rule::mul_op
            | Rule::membership
            | Rule::index
            | Rule::prime => "an operator",
            Rule::domain | Rule::labels | Rule::range | Rule::array_of | Rule::unit_type => {
                "a type"
            }
            Rule::unit => "a unit",
            Rule::parameters | Rule::parameter => "parameters",
            Rule::arguments | Rule::argument => "arguments",
            Rule::implements => "`implements`",
            Rule::code => "a code such as `din:4.3.1`",
            Rule::EOI => "the end of the item",
            Rule::set => "a set `{a, b}` or a range",
            Rule::string => "a path in quotes",
            Rule::close_paren => "`)`",
            Rule::close_bracket => "`]`",
            Rule::close_brace => "`}`",
            Rule::colon | Rule::label | Rule::requirement_id => "`:`",
            Rule::equals => "`=`",
            _ => continue,
        };
        if !words.iter().any(|w| w == word) {
            words.push(word.to_owned());
        }
    }
    match words.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} or {last}", most.join(", ")),
    }
}
