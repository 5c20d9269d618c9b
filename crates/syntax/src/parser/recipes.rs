//! Messages about layouts and recipes that cannot be parsed.

use super::{Grammar, Rule, after_comments, finding_of, word_at};
use linewright_core::diagnostics::{Diagnostic, codes, nearest};
use linewright_core::source::{FileId, Span};
use pest::Parser as _;

/// Returns the finding for text in a resource, a transport or a recipe that is no item of it.
/// Returns `None` for other contexts, and if the first word shows nothing.
pub(super) fn explain(file: FileId, start: usize, text: &str, context: Rule) -> Option<Diagnostic> {
    let code = after_comments(text);
    let word = word_at(code);
    let rest = after_comments(&code[word.len()..]);
    if context == Rule::bad_layout_item && word == "at" {
        return without_state(file, start + text.len() - rest.len(), rest);
    }
    let is_transition = rest.starts_with("->");
    let (rule, begins_item) = match (context, word.as_str()) {
        (Rule::bad_resource_item, "nop") if !is_transition => (Rule::only_nop, true),
        (Rule::bad_resource_item, _) => (Rule::only_resource_item, false),
        (Rule::bad_transport_item, _) => (Rule::only_transport_item, rest.starts_with([':', ','])),
        (Rule::bad_recipe_item, "part") if !is_transition => (Rule::only_recipe_parts, true),
        (Rule::bad_recipe_item, "start") if !is_transition => (Rule::only_recipe_start, true),
        (Rule::bad_recipe_item, "end") if !is_transition => (Rule::only_recipe_ends, true),
        (Rule::bad_recipe_item, "leftover") if !is_transition => (Rule::only_leftover, true),
        (Rule::bad_recipe_item, _) => (Rule::only_recipe_item, false),
        _ => return None,
    };
    if context == Rule::bad_recipe_item
        && is_transition
        && let Some(finding) = after_states(file, start + text.len() - rest.len(), rest)
    {
        return Some(finding);
    }
    if context == Rule::bad_recipe_item && rest.starts_with('(') {
        let at = start + text.len() - code.len();
        let span = Span::new(file, at, at + word.len());
        return Some(
            Diagnostic::error(
                codes::SYNTAX,
                span,
                format!("the operation `{word}` is in no transition"),
            )
            .with_help("write the operations of a transition after its states: `a -> b: load()(f); glue(f)(f)`"),
        );
    }
    if !begins_item && !is_transition {
        return None;
    }
    let error = Grammar::parse(rule, text).err()?;
    Some(finding_of(file, start, text, &error))
}

/// Returns the finding for a word that stands where the guard or the `:` of a transition would,
/// from the arrow between its states.
fn after_states(file: FileId, start: usize, text: &str) -> Option<Diagnostic> {
    let target = after_comments(text.strip_prefix("->")?);
    let state = word_at(target);
    let after = &target[state.len()..];
    let is_name = |word: &str| word.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let same_line = |text: &str| {
        let word = text.trim_start_matches([' ', '\t']);
        let name = word_at(word);
        is_name(&name).then(|| (text.len() - word.len(), name))
    };
    let (mut skipped, mut word) = same_line(after)?;
    let mut expected = "`:`, `when` or `otherwise`";
    let mut rest = after;
    if word == "otherwise" {
        rest = &after[skipped + word.len()..];
        (skipped, word) = same_line(rest)?;
        expected = "`:`";
    }
    if word == "when" {
        return None;
    }
    let at = start + text.len() - rest.len() + skipped;
    let span = Span::new(file, at, at + word.len());
    let finding = Diagnostic::error(codes::SYNTAX, span, format!("`{word}` does not fit here"));
    let near = nearest(&word, ["when", "otherwise"].into_iter());
    Some(finding.with_help(match near {
        Some(near) => format!("did you mean `{near}`? Expected {expected}"),
        None => format!("expected {expected}"),
    }))
}

/// Returns the finding for a statement `at start` that names no state, from the text after `at`.
fn without_state(file: FileId, start: usize, text: &str) -> Option<Diagnostic> {
    let mut rest = text;
    let mut next = || {
        let word = word_at(rest);
        rest = after_comments(&rest[word.len()..]);
        word
    };
    let (first, resource, holds) = (next(), next(), next());
    let is_stock = rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    // A state can have this name, too.
    let is_state = word_at(rest) == "holds";
    if first != "start" || holds != "holds" || !is_stock || is_state {
        return None;
    }
    let end = rest.find(['\n', '\r', '/', ';', '}']).unwrap_or(rest.len());
    let parts = rest[..end].trim_end();
    let at = start + text.len() - rest.len();
    Some(
        Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, at, at + parts.len()),
            format!("the state of `{resource}` is missing before `holds`"),
        )
        .with_help(format!(
            "write in which state it is at the start: `at start {resource} s0 holds {parts}`"
        )),
    )
}

/// Returns the name of a context for messages, and what can begin an item there.
pub(super) fn allowed(context: Rule) -> (&'static str, &'static [&'static str]) {
    match context {
        Rule::bad_layout_item => ("a layout", &["resource", "transport", "at start", "const"]),
        Rule::bad_resource_item => ("a resource", &["s0 -> s1: ...", "nop"]),
        Rule::bad_transport_item => ("a transport", &["r1 -> r2"]),
        _ => (
            "a recipe",
            &["part", "start", "a -> b: ...", "end", "leftover"],
        ),
    }
}

/// Returns the phrase for a rule in a list of expected tokens.
pub(super) fn phrase(rule: Rule) -> Option<&'static str> {
    Some(match rule {
        Rule::action => "an operation, `in` or `out`",
        Rule::taking | Rule::lasts => "`in`",
        Rule::giving => "`out`",
        Rule::hidden => "`internal`",
        Rule::transfer_label => "a label, such as `in:3`",
        Rule::draws => "`power`",
        Rule::initially | Rule::tested_at => "`at`",
        Rule::holds => "`holds`",
        Rule::resource_kind => "`:`",
        Rule::dock | Rule::docks => "a resource",
        Rule::stock | Rule::recipe_part => "a part",
        Rule::part_names => "parts in brackets, such as `(p, h)`",
        Rule::recipe_step | Rule::recipe_call => "an operation, such as `insert(p, h)(h2)`",
        Rule::recipe_guard => "`when`",
        Rule::otherwise => "`otherwise`",
        Rule::wanted => "a recipe",
        _ => return None,
    })
}
