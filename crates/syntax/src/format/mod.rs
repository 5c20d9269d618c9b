//! Formatter: converts a syntax tree back to text.
//!
//! The output is generated from the tree, so it has the same meaning by construction. The comments,
//! the empty lines between declarations, and the author's line ends are taken from the source text.
//! To overwrite a file, use [`format_checked`], which verifies that nothing is lost or changed.

mod comments;
mod contract;
mod expression;
mod layout;
mod line;
mod machine;
mod parts;
mod printer;
mod recipe;
mod skills;

use super::ast::{Expr, File, Item};
use super::parser::parse;
use linewright_core::source::FileId;
use printer::Printer;

/// Formats a file's tree with the comments of `text`. The tree must have been parsed from `text`
/// without findings. Keeps a byte-order mark, and ends lines as `text` does.
///
/// Without a source text (`""`), the output has the doc comments that the tree contains, no other
/// comments, and an empty line between contracts.
pub fn format(file: &File, text: &str) -> String {
    let mut printer = Printer::new(file, text);
    let mut before = None;
    for item in &file.items {
        let kind = std::mem::discriminant(item);
        let block = matches!(
            item,
            Item::Contract(_)
                | Item::Machine(_)
                | Item::Line(_)
                | Item::Skills(_)
                | Item::Layout(_)
                | Item::Recipe(_)
        );
        let place = printer.begin(block || before.is_some_and(|b| b != kind));
        before = Some(kind);
        match item {
            Item::Import(i) => {
                printer.put("import ");
                printer.before(i.span);
                let quote = if i.dotted { "" } else { "\"" };
                printer.put(&format!("{quote}{}{quote}", i.path));
            }
            Item::Type(t) => printer.type_decl(t),
            Item::Const(c) => printer.const_decl(c),
            Item::Define(d) => printer.define(d),
            Item::Contract(c) => printer.contract(place, c),
            Item::Machine(m) => printer.machine(place, m),
            Item::Line(l) => printer.plant_line(place, l),
            Item::Skills(s) => printer.skills(place, s),
            Item::Layout(l) => printer.cell_layout(place, l),
            Item::Recipe(r) => printer.recipe(place, r),
            Item::Realize(r) => printer.realize(r),
        }
        printer.end();
    }
    let mut formatted = printer.finish();
    if text.find('\n').is_some_and(|n| text[..n].ends_with('\r')) {
        formatted = formatted.replace('\n', "\r\n");
    }
    if text.starts_with('\u{feff}') {
        formatted.insert(0, '\u{feff}');
    }
    formatted
}

/// Formats an expression on one line.
pub fn format_expression(e: &Expr) -> String {
    let file = File::default();
    let mut printer = Printer::new(&file, "");
    printer.begin(false);
    printer.expression(e);
    printer.end();
    let words = printer.finish();
    let words: Vec<&str> = words.split_whitespace().collect();
    words.join(" ").replace("( ", "(").replace(" )", ")")
}

/// Maximum number of times that a text is formatted until it is stable.
const MAX_ROUNDS: usize = 8;

/// Error in a formatted text, caused by a bug in this program and not by the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// The text parses to a different tree.
    #[error("the formatted text would have a different meaning")]
    Tree,
    /// A comment is missing or in a different order.
    #[error("a comment would be lost")]
    Comments,
    /// A word that is not in the tree is missing.
    #[error("a word would be lost")]
    Words,
    /// Formatting the result again changes it.
    #[error("formatting the result again would change it")]
    Unstable,
}

/// Like [`format()`], but verifies the result: it must parse to the same tree, have the same
/// comments and words in the same order, and not change when formatted again.
///
/// # Errors
/// If the result fails one of these checks.
pub fn format_checked(file: &File, text: &str) -> Result<String, FormatError> {
    let mut formatted = format(file, text);
    let (mut again, mut findings) = parse(FileId::default(), &formatted);
    // A comment that moves past a bracket can cause a new line break. Existing breaks are kept, so
    // this terminates.
    let mut settled = false;
    for _ in 0..MAX_ROUNDS {
        let next = format(&again, &formatted);
        settled = next == formatted;
        if settled || !findings.is_empty() {
            break;
        }
        formatted = next;
        (again, findings) = parse(FileId::default(), &formatted);
    }
    if !findings.is_empty() || again.clone().without_spans() != file.clone().without_spans() {
        return Err(FormatError::Tree);
    }
    let (before, after) = (comments::cut(text), comments::cut(&formatted));
    let texts = |cut: &comments::Cut| -> Vec<String> {
        cut.comments.iter().map(|c| c.text.clone()).collect()
    };
    if texts(&before) != texts(&after) {
        return Err(FormatError::Comments);
    }
    if comments::words(text, &before) != comments::words(&formatted, &after) {
        return Err(FormatError::Words);
    }
    if !settled {
        return Err(FormatError::Unstable);
    }
    Ok(formatted)
}

/// Returns the comments of a text, in order.
pub fn comments(text: &str) -> Vec<String> {
    comments::cut(text)
        .comments
        .into_iter()
        .map(|c| c.text)
        .collect()
}
