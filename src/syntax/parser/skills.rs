//! What is said of skills and orders that do not parse.

use super::{Rule, after_comments, word_at};
use crate::diagnostics::{Diagnostic, codes, nearest};
use crate::source::{FileId, Span};

/// What is wrong with a piece of a component that is no skill.
pub(super) fn explain(file: FileId, start: usize, text: &str, context: Rule) -> Option<Diagnostic> {
    let code = after_comments(text);
    let word = sign_at(code);
    if context != Rule::bad_skill || word.is_empty() {
        return None;
    }
    let at = start + text.len() - code.len();
    let span = Span::new(file, at, at + word.len());
    let message = format!("`{word}` does not fit here");
    Some(
        Diagnostic::error(codes::SYNTAX, span, message).with_help(
            "a skill is written with the situation that it leads to: `Left -> left`; commas or new lines stand between skills",
        ),
    )
}

/// What to do instead, where something stands that does not follow events, or operands of a regular expression.
pub(super) fn hint(word: &str, expected: &[Rule]) -> Option<String> {
    if expected.contains(&Rule::k_order)
        && let Some(near) = nearest(word, ["component", "order"].into_iter())
    {
        return Some(format!("did you mean `{near}`?"));
    }
    if !expected.contains(&Rule::ampersand) {
        return None;
    }
    let list = expected.contains(&Rule::comma);
    let hint = match word {
        "or" | "|" | "and" if list => {
            "a list of which any is meant is written with commas, `Left, Right`; what is called at once with `&`, `Left & Right`"
        }
        "*" | "+" | "?" | "{" if !list => "put brackets around what is repeated: `(Left & Down)*`",
        _ => return None,
    };
    Some(hint.to_owned())
}

/// The phrase for a rule.
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

/// A word, or signs that belong together.
fn sign_at(text: &str) -> String {
    let sign: String = { text.chars() }
        .take_while(|c| "-=<>&|*+?.:".contains(*c))
        .collect();
    if sign.is_empty() { word_at(text) } else { sign }
}
