//! Findings: what is wrong with a document, and where.

use std::fmt;

/// Maximum number of findings that are kept of one document.
pub const MAX_FINDINGS: usize = 1_000;
/// Maximum number of characters of a name or value that a message quotes.
const MAX_QUOTED: usize = 60;

/// A finding about a document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1. A byte order mark does not count.
    pub column: usize,
    /// The same place in bytes from the beginning of the text, without a byte order mark.
    pub offset: usize,
    /// Rule that is broken.
    pub rule: Rule,
    /// What is wrong, as a sentence without a full stop.
    pub message: String,
}

/// Rule that a document breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rule {
    /// The document is UTF-8.
    Encoding,
    /// The document is well-formed XML 1.0 with namespaces.
    Syntax,
    /// There is no document type declaration, so entities cannot be declared.
    DocumentType,
    /// The root is in the namespace of B2MML 7.
    Version,
    /// The root is an element that is read.
    Root,
    /// Elements occur where, in which order and as often as the schema says.
    Structure,
    /// Attributes are those of the schema.
    Attribute,
    /// Texts are values of the types of the schema.
    Value,
    /// The document is not larger than is read.
    Size,
    /// What the document says can be said of a layout, a recipe, a schedule or a performance.
    Meaning,
    /// What an element refers to exists, once.
    Reference,
    /// Valid, but of no use here: it is left out. These findings are notes.
    LeftOut,
}

/// Findings of a document, in the order of their places.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct Findings {
    /// The first [`MAX_FINDINGS`].
    pub list: Vec<Finding>,
    /// Number of further findings.
    pub omitted: usize,
}

impl Rule {
    /// All rules.
    pub const ALL: [Self; 12] = [
        Self::Encoding,
        Self::Syntax,
        Self::DocumentType,
        Self::Version,
        Self::Root,
        Self::Structure,
        Self::Attribute,
        Self::Value,
        Self::Size,
        Self::Meaning,
        Self::Reference,
        Self::LeftOut,
    ];

    /// Returns the name of the rule: one or two words in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Encoding => "encoding",
            Self::Syntax => "syntax",
            Self::DocumentType => "document type",
            Self::Version => "version",
            Self::Root => "root",
            Self::Structure => "structure",
            Self::Attribute => "attribute",
            Self::Value => "value",
            Self::Size => "size",
            Self::Meaning => "meaning",
            Self::Reference => "reference",
            Self::LeftOut => "left out",
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = (self.line, self.column);
        write!(f, "{line}:{column}: {}: {}", self.rule.name(), self.message)
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, finding) in self.list.iter().enumerate() {
            if number > 0 {
                writeln!(f)?;
            }
            write!(f, "{finding}")?;
        }
        if self.omitted > 0 {
            write!(f, "\nand {} more", self.omitted)?;
        }
        Ok(())
    }
}

/// Collects findings by byte offset. Its memory is bounded.
#[derive(Default)]
pub(crate) struct Collector {
    list: Vec<(usize, Rule, String)>,
    omitted: usize,
}

impl Collector {
    /// Adds a finding. `at` is a byte offset into the text.
    pub(crate) fn add(&mut self, at: usize, rule: Rule, message: impl Into<String>) {
        if self.list.len() < MAX_FINDINGS {
            self.list.push((at, rule, message.into()));
        } else {
            self.omitted += 1;
        }
    }

    /// Returns whether nothing was found.
    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns the findings with their lines and columns in `text`.
    pub(crate) fn into_findings(mut self, text: &str) -> Findings {
        self.list.sort_by_key(|(at, ..)| *at);
        let (mut line, mut column, mut seen) = (1, 1, 0);
        let list = self.list.into_iter().map(|(at, rule, message)| {
            let mut at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            for character in text[seen.min(at)..at].chars() {
                if character == '\n' {
                    line += 1;
                    column = 1;
                } else {
                    column += 1;
                }
            }
            seen = at;
            Finding {
                line,
                column,
                offset: at,
                rule,
                message,
            }
        });
        Findings {
            list: list.collect(),
            omitted: self.omitted,
        }
    }
}

/// Returns a name or value as a message quotes it: shortened, with what cannot be seen escaped.
pub(crate) fn quoted(text: &str) -> String {
    let mut shown = String::from("`");
    for (number, character) in text.chars().enumerate() {
        if number == MAX_QUOTED {
            shown.push_str("...");
            break;
        }
        if character.is_control() || (character.is_whitespace() && character != ' ') {
            shown.extend(character.escape_unicode());
        } else {
            shown.push(character);
        }
    }
    shown.push('`');
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_characters() {
        let mut collector = Collector::default();
        let text = "ä<b>\n  ü!\r\nend";
        collector.add(text.find('!').expect("it is there"), Rule::Value, "second");
        collector.add(2, Rule::Syntax, "first");
        collector.add(text.len() + 5, Rule::Size, "third");
        let findings = collector.into_findings(text);
        assert_eq!(
            findings.to_string(),
            "1:2: syntax: first\n2:4: value: second\n3:4: size: third"
        );
    }

    #[test]
    fn the_number_is_bounded() {
        let mut collector = Collector::default();
        for _ in 0..MAX_FINDINGS + 7 {
            collector.add(0, Rule::Value, quoted(&"x".repeat(1_000)));
        }
        let findings = collector.into_findings("");
        assert_eq!((findings.list.len(), findings.omitted), (MAX_FINDINGS, 7));
        assert!(findings.list[0].message.len() < 100);
        assert!(findings.to_string().ends_with("and 7 more"));
        assert_eq!(quoted("a\tb"), "`a\\u{9}b`");
    }
}
