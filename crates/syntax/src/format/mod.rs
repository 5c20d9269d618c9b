//! From a syntax tree back to text.
//!
//! What is printed is made from the tree, so that it means the same by construction; the text that
//! the tree was made of gives the comments, the empty lines between declarations, and the places
//! where the author ended a line. Whoever writes the result over a file asks [`checked`] for it,
//! which takes nothing for granted.

mod comments;
mod contract;
mod expression;
mod layout;
mod line;
mod machine;
mod parts;
mod printer;
mod skills;

use super::ast::{Expr, File, Item};
use super::parser::parse;
use linewright_core::source::FileId;
use printer::Printer;

/// The text of a file's tree, with the comments of `text`, which the tree was parsed from without a
/// finding. Line ends are those of `text`, and a byte-order mark stays.
///
/// Without a text (`""`), the tree is printed as it is: its own doc comments, no other, and an
/// empty line between contracts.
pub fn format(file: &File, text: &str) -> String {
    let mut printer = Printer::new(file, text);
    let mut before = None;
    for item in &file.items {
        let kind = std::mem::discriminant(item);
        let block = matches!(
            item,
            Item::Contract(_) | Item::Machine(_) | Item::Line(_) | Item::Skills(_)
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

/// An expression in one line, as it would stand in a file.
pub fn expression(e: &Expr) -> String {
    let file = File::default();
    let mut printer = Printer::new(&file, "");
    printer.begin(false);
    printer.expression(e);
    printer.end();
    let words = printer.finish();
    let words: Vec<&str> = words.split_whitespace().collect();
    words.join(" ").replace("( ", "(").replace(" )", ")")
}

/// So often a text is formatted again until that changes nothing.
const MOST_ROUNDS: usize = 8;

/// What went wrong with a formatted text: a fault of this program, not of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// It is not read as the same tree.
    #[error("the formatted text would mean something else")]
    Tree,
    /// A comment is missing, or stands elsewhere among the comments.
    #[error("a comment would be lost")]
    Comments,
    /// A word is missing that the tree does not hold.
    #[error("a word would be lost")]
    Words,
    /// Formatting it again gives another text.
    #[error("formatting it again would change it again")]
    Unstable,
}

/// [`format()`], and a look at the result before anyone writes it over the file: it must be read as
/// the same tree, hold the same comments and the same words in the same order, and stay as it is
/// when it is formatted again.
pub fn checked(file: &File, text: &str) -> Result<String, Fault> {
    let mut formatted = format(file, text);
    let (mut again, mut findings) = parse(FileId::default(), &formatted);
    // A comment that moves past a bracket can make a line end where none did. What is broken stays
    // broken, so this comes to an end.
    let mut settled = false;
    for _ in 0..MOST_ROUNDS {
        let next = format(&again, &formatted);
        settled = next == formatted;
        if settled || !findings.is_empty() {
            break;
        }
        formatted = next;
        (again, findings) = parse(FileId::default(), &formatted);
    }
    if !findings.is_empty() || again.clone().without_spans() != file.clone().without_spans() {
        return Err(Fault::Tree);
    }
    let (before, after) = (comments::cut(text), comments::cut(&formatted));
    let texts = |cut: &comments::Cut| -> Vec<String> {
        cut.comments.iter().map(|c| c.text.clone()).collect()
    };
    if texts(&before) != texts(&after) {
        return Err(Fault::Comments);
    }
    if comments::words(text, &before) != comments::words(&formatted, &after) {
        return Err(Fault::Words);
    }
    if !settled {
        return Err(Fault::Unstable);
    }
    Ok(formatted)
}

/// The comments of a text, in order.
pub fn comments(text: &str) -> Vec<String> {
    comments::cut(text)
        .comments
        .into_iter()
        .map(|c| c.text)
        .collect()
}
