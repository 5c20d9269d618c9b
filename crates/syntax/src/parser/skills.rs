//! Messages about skills and orders that cannot be parsed.

use super::super::words::is_reserved_among_skills;
use super::{Rule, after_comments, word_at};
use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::{FileId, Span};

/// Words that can follow the name of a skill or of an order.
const FOLLOWING: [&str; 11] = [
    "before",
    "only",
    "until",
    "then",
    "twice",
    "between",
    "and",
    "deletes",
    "at",
    "order",
    "component",
];

/// Returns the finding for text in a component that is not a skill, or for a call without a skill's
/// name in the skill calls of a machine. Returns `None` for other contexts.
pub(super) fn explain(file: FileId, start: usize, text: &str, context: Rule) -> Option<Diagnostic> {
    if !matches!(context, Rule::bad_skill | Rule::bad_skill_call) {
        return None;
    }
    let code = after_comments(text);
    // In `Left -> then`, the skill itself was already parsed.
    let target = code.strip_prefix("->").map(after_comments);
    let code = target
        .filter(|t| is_reserved_among_skills(&word_at(t)))
        .unwrap_or(code);
    let word = sign_at(code);
    let at = start + text.len() - code.len();
    let finding = Diagnostic::error(
        codes::SYNTAX,
        Span::new(file, at, at + word.len()),
        format!("`{word}` does not fit here"),
    );
    if is_reserved_among_skills(&word) {
        return Some(finding.with_help(no_name(&word)));
    }
    if context == Rule::bad_skill_call || word.is_empty() {
        return None;
    }
    Some(finding.with_help(
        "write a skill with the situation that it leads to, `Left -> left`, and separate skills by commas or new lines",
    ))
}

/// Returns help for a word that cannot follow an event or an operand of a regular expression, or
/// that cannot be a name. `before` and `after` are the text around the word.
pub(super) fn hint(word: &str, (before, after): (&str, &str), expected: &[Rule]) -> Option<String> {
    if expected.contains(&Rule::k_order)
        && let Some(near) = nearest(word, ["component", "order"].into_iter())
    {
        return Some(format!("did you mean `{near}`?"));
    }
    let in_regex = expected.contains(&Rule::element);
    let list = expected.contains(&Rule::comma);
    let after_operand = [Rule::ampersand, Rule::bar]
        .iter()
        .any(|r| expected.contains(r));
    let hint = match word {
        "or" | "|" | "and" if list && after_operand => {
            "write alternatives with commas, `Left, Right`, and skills that are called in the same step with `&`, `Left & Right`"
        }
        "and" | "," if expected.contains(&Rule::arrow) && after_operand => {
            "combine situations of several components with `&`: `left & down -> right`"
        }
        "or" if in_regex && after_operand => "separate alternatives by `|`: `(Left | Right)`",
        "and" | "then" if in_regex && after_operand => {
            "write skills that follow each other side by side, `(Left Right)`, and join skills that are called in the same step by `&`"
        }
        "*" | "+" | "?" | "{" if expected.contains(&Rule::ampersand) && !list => {
            "put brackets around the repeated expression: `(Left & Down)*`"
        }
        _ if !is_reserved_among_skills(word) || !(in_regex || expected.contains(&Rule::word)) => {
            return None;
        }
        _ if last_word(before) == "at" => return Some(no_level(word)),
        _ if in_regex || is_meant_as_name(after) => return Some(no_name(word)),
        _ => return None,
    };
    Some(hint.to_owned())
}

fn no_name(word: &str) -> String {
    // All keywords are lower-case.
    let (first, rest) = word.split_at(1);
    format!(
        "expected a name; `{word}` is a keyword and cannot be a name: write `{}{rest}` or `{word}_`",
        first.to_ascii_uppercase()
    )
}

fn no_level(word: &str) -> String {
    format!("expected a level, such as `at reasonable`; `{word}` is a keyword")
}

/// Returns whether a word was meant as a name. This is the case if a symbol follows, or a word that
/// can follow a name. In `order home never Left`, by contrast, a symbol is missing before `never`,
/// so `never` was not meant as a name.
fn is_meant_as_name(after: &str) -> bool {
    let next = word_at(after_comments(after));
    !next.starts_with(|c: char| c.is_alphanumeric() || c == '_')
        || FOLLOWING.contains(&next.as_str())
}

fn last_word(text: &str) -> &str {
    let text = text.trim_end();
    let start = text.rfind(|c: char| !c.is_alphanumeric() && c != '_');
    // The symbol can have several bytes.
    start.map_or(text, |s| {
        text[s..].trim_start_matches(|c: char| !c.is_alphanumeric() && c != '_')
    })
}

/// Returns the phrase for a rule in a list of expected tokens.
pub(super) fn phrase(rule: Rule) -> Option<&'static str> {
    Some(match rule {
        Rule::word | Rule::order_name | Rule::event | Rule::events => "a name",
        Rule::skill | Rule::regex | Rule::in_turn | Rule::element => "a skill",
        Rule::situation | Rule::together => "a situation",
        Rule::order_rule => "a rule such as `never Left` or `after Down until Up: never Left`",
        Rule::situations => "situations `{left, right}`",
        Rule::group => "`(`",
        Rule::times => "`*`, `+`, `?` or `{2,3}`",
        Rule::effect => "`->`",
        Rule::initial => "`=`",
        Rule::level => "`at`",
        Rule::comma | Rule::up_to => "`,`",
        Rule::ampersand => "`&`",
        Rule::bar => "`|`",
        _ => return None,
    })
}

/// Returns the word or the sequence of symbols at the beginning of a text.
fn sign_at(text: &str) -> String {
    let sign: String = text
        .chars()
        .take_while(|c| "-=<>&|*+?.:".contains(*c))
        .collect();
    if sign.is_empty() { word_at(text) } else { sign }
}
