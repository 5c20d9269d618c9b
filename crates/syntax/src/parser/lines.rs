//! Messages about statements of lines and stations that cannot be parsed.

use super::{Rule, after_comments, explain_after, word_at};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};

/// A shift without options.
const SHIFT: &str = "shift 0 h to 24 h ";

/// A route to a list of places without a choice.
const ROUTE: &str = "route P: a -> b, c ";

/// A station, and a source, without options.
const STATION: &str = "station x ";
const SOURCE: &str = "source a: P every 1 s ";

/// Returns the finding for text that was meant to continue a statement. Returns `None` if it is
/// anything else.
pub(super) fn explain(file: FileId, start: usize, text: &str, context: Rule) -> Option<Diagnostic> {
    if !matches!(context, Rule::bad_line_item | Rule::bad_station_item) {
        return None;
    }
    let code = after_comments(text);
    let word = word_at(code);
    let before = match word.as_str() {
        "on" | "break" | "finish" => Some(SHIFT),
        "by" => Some(ROUTE),
        "times" if context == Rule::bad_line_item => Some(STATION),
        "," if word_at(after_comments(&code[1..])) == "at" => Some(SOURCE),
        _ => None,
    };
    if let Some(before) = before {
        return explain_after(before, Rule::only_line_item, file, start, text);
    }
    let help = match word.as_str() {
        "dwell" | "shelf" | "lifo" | "highest" | "lowest" if context == Rule::bad_line_item => {
            "write the options of a buffer in this order: `buffer tray capacity 10 lifo dwell 2 min shelf life 1 h`"
        }
        "from" if context == Rule::bad_line_item => {
            "the bill of materials stands in the part, `part Carton from 6 Bottle`; a route begins at its first place, `route Milk: tank -> filler`"
        }
        "pause" | "pauses" | "breaks" => {
            "did you mean `break`? It follows the hours of a shift: `shift 6 h to 14 h break 9 h to 9.25 h`"
        }
        "(" if after_comments(&code[1..]).starts_with(')') => {
            "write the parameters of a distribution in the brackets: `takes exponential(4 s)`, `takes discrete(2 s: 90 %, 5 s: 10 %)`"
        }
        _ => return None,
    };
    let at = start + text.len() - code.len();
    let span = Span::new(file, at, at + word.len());
    let message = format!("`{word}` does not fit here");
    Some(Diagnostic::error(codes::SYNTAX, span, message).with_help(help))
}

/// Returns help for a statement about failures; `before` is its text before the `word` that does
/// not fit.
pub(super) fn failures_hint(before: &str, word: &str, expected: &[Rule]) -> Option<String> {
    if word_at(after_comments(before)) != "failures" {
        return None;
    }
    if matches!(word, "parts" | "part") {
        return Some(
            "after a number of parts: `failures every 300 parts mttr 10 min`, or with a name `failures jam: every 300 parts mttr 10 min`"
                .to_owned(),
        );
    }
    (expected == [Rule::colon]).then(|| {
        "a name of failures is followed by `:`, as in `failures jam: mtbf 8 h mttr 10 min`, or `failures jam: every 300 parts mttr 10 min`"
            .to_owned()
    })
}
