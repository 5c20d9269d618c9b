//! A scan of a file's brackets, comments and quotes before the file is parsed.
//!
//! The grammar recovers from mistakes within an item, but not from a brace that is never closed.
//! Everything after such a brace would be part of one broken item, and the repeated search for its
//! end would take exponential time. This scan finds the brace, reports it, and returns a *mended
//! copy* in which blanks before the next declaration with braces are replaced by the missing `}`.
//! All other bytes keep their offsets, so places in the copy are places in the file.
//!
//! The scan also computes an upper bound of the grammar's recursion depth. The bound is safe for
//! two reasons. Strings, comments and words are split exactly as in the grammar. A prefix word
//! counts until a point at which no rule of the grammar could continue its operand.

use super::words::{ends_expressions, is_reserved_among_skills};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, Span};
use std::ops::Range;

/// Result of the scan.
pub(super) struct Scan {
    /// Mended copy of the text; `None` if the text needed no change.
    pub mended: Option<String>,
    /// Findings about the file.
    pub findings: Vec<Diagnostic>,
    /// Ranges of the file that are already reported; findings of the parser in these ranges are
    /// suppressed.
    pub silenced: Vec<Range<usize>>,
    /// Upper bound of the grammar's recursion depth: the number of open brackets and prefix words.
    pub depth: usize,
    /// Offset at which this depth is reached.
    pub deepest: usize,
}

/// Words that can precede an expression; the grammar recurses at each of them.
const PREFIXES: &[&str] = &[
    "if",
    "always",
    "eventually",
    "forall",
    "exists",
    "count",
    "sum",
    "array",
    "never",
    "previous",
    "once",
    "historically",
];

/// Words after which an expression continues.
const INFIX: &[&str] = &[
    "and", "or", "xor", "implies", "iff", "mod", "in", "then", "else", "of", "not", "next", "G",
    "F", "X", "O", "GF", "since", "precedes", "responds", "to", "within", "before", "between",
    "after", "until", "unless", "release", "U", "W", "R",
];

pub(super) const UNITS: &[&str] = &[
    "mm", "m", "kWh", "kW", "kg", "min", "cm", "ms", "deg", "rad", "W", "J", "Wh", "s", "h", "d",
    "g",
];

/// What precedes a word.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Before {
    /// The end of an operand: a name, a closing bracket, a prime.
    Operand,
    /// The end of a number, which a unit can follow.
    Number,
    /// A position at which an expression has to begin or continue.
    Open,
}

struct Bracket {
    kind: u8,
    offset: usize,
    /// Number of prefix words before the bracket. They count again once it is closed.
    prefixes: usize,
    /// Whether the bracket opens a set of skills, which contains no expressions.
    skills: bool,
}

struct Scanner<'t> {
    file: FileId,
    text: &'t str,
    stack: Vec<Bracket>,
    prefixes: usize,
    before: Before,
    /// End of the last token that is neither blank nor comment.
    code_end: usize,
    /// Whether the line has only blanks and comments so far.
    line_start: bool,
    /// Offset of the next skill set's brace.
    skills: Option<usize>,
    copy: Option<Vec<u8>>,
    scan: Scan,
}

/// Scans a file.
pub(super) fn scan(file: FileId, text: &str) -> Scan {
    let mut scanner = Scanner {
        file,
        text,
        stack: Vec::new(),
        prefixes: 0,
        before: Before::Open,
        code_end: 0,
        line_start: true,
        skills: None,
        copy: None,
        scan: Scan {
            mended: None,
            findings: Vec::new(),
            silenced: Vec::new(),
            depth: 0,
            deepest: 0,
        },
    };
    scanner.run();
    scanner.close_all();
    let mut scan = scanner.scan;
    scan.mended = scanner.copy.and_then(|bytes| String::from_utf8(bytes).ok());
    scan
}

/// Returns whether the text after the word `machine` declares an inner machine, such as
/// `left: PickUnit`, and not a top-level machine, such as `PickUnit {`.
pub fn declares_inner_machine(rest: &str) -> bool {
    let name = rest.trim_start();
    let end = name
        .find(|c: char| !c.is_alphanumeric() && c != '_')
        .unwrap_or(name.len());
    end > 0 && name[end..].trim_start().starts_with(':')
}

/// Returns whether the text after a keyword shows that the keyword was meant as a name, as in
/// `line -> left` or `line = c.a`. This is an error, but not one that a missing brace causes.
fn is_meant_as_name(rest: &str) -> bool {
    let rest = rest.trim_start();
    rest.starts_with("->") || rest.starts_with([',', ';', '=', '}'])
}

/// Returns the offset of the brace if the text after the word `skills` is a name and a brace. Only
/// a set of skills has this form, since no expression contains two adjacent names.
fn skills_head(rest: &str) -> Option<usize> {
    let name = rest.trim_start();
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_')?;
    let word = &name[..end];
    let brace = name[end..].trim_start();
    let own = !word.is_empty() && !is_reserved_among_skills(word);
    (own && brace.starts_with('{')).then(|| rest.len() - brace.len())
}

/// Returns whether the text after the word `skills` declares a set of skills: a name, a brace, and
/// a component or an order after it.
pub fn declares_skill_set(rest: &str) -> bool {
    let Some(brace) = skills_head(rest) else {
        return false;
    };
    let mut within = rest[brace + 1..].trim_start();
    while within.starts_with("//") {
        let end = within.find(['\n', '\r']).unwrap_or(within.len());
        within = within[end..].trim_start();
    }
    // In a machine, a skill can have the name `component` or `order`: `order = ...`.
    let after = ["component", "order"].iter().find_map(|word| {
        let after = within.strip_prefix(word)?;
        (!after.starts_with(|c: char| c.is_alphanumeric() || c == '_')).then_some(after)
    });
    after.is_some_and(|after| !after.trim_start().starts_with('='))
}

/// Returns whether the word `layout` or `recipe` between these texts declares one: it is followed
/// by a name and a brace that is not the number of repetitions of a skill, as in `Up{2}`. After a
/// comma or a colon, it is the name of an operation: `glue in 4 s, layout power {a = b}.a`.
pub fn declares_layout_or_recipe(before: &str, rest: &str) -> bool {
    let is_operation = before.trim_end().ends_with([',', ':']);
    !is_operation
        && skills_head(rest).is_some_and(|brace| {
            let within = rest[brace + 1..].trim_start();
            !within.starts_with(|c: char| c.is_ascii_digit())
        })
}

/// Returns whether the text after the word `skills`, outside of all braces, begins a set of skills:
/// a name and a brace.
pub fn begins_skill_set(rest: &str) -> bool {
    skills_head(rest).is_some()
}

impl Scanner<'_> {
    fn run(&mut self) {
        let text = self.text;
        let mut i = 0;
        while let Some(c) = text[i..].chars().next() {
            let rest = &text[i..];
            let mut next = i + c.len_utf8();
            if rest.starts_with("//") {
                i += rest.find(['\n', '\r']).unwrap_or(rest.len());
                continue;
            }
            if let Some(comment) = rest.strip_prefix("/*") {
                let Some(end) = comment.find("*/") else {
                    self.unclosed_comment(i);
                    return;
                };
                i += end + 4;
                continue;
            }
            match c {
                '"' => match rest[1..].find(['"', '\n', '\r']) {
                    Some(end) if rest.as_bytes()[end + 1] == b'"' => {
                        next = i + end + 2;
                        self.before = Before::Operand;
                    }
                    end => {
                        let end = end.map_or(text.len(), |e| i + 1 + e);
                        self.unclosed_string(i, end);
                        next = end;
                    }
                },
                '(' | '[' | '{' => self.open(c as u8, i),
                ')' | ']' | '}' => self.close(c as u8),
                '\'' => self.before = Before::Operand,
                ';' => {
                    self.expression_ends();
                    self.before = Before::Open;
                }
                c if c.is_alphanumeric() || c == '_' => {
                    let end = rest
                        .find(|c: char| !c.is_alphanumeric() && c != '_')
                        .unwrap_or(rest.len());
                    self.word(&rest[..end], i);
                    next = i + end;
                }
                '\n' | '\r' => {
                    self.line_start = true;
                    i = next;
                    continue;
                }
                c if c.is_whitespace() || c == '\u{feff}' => {
                    i = next;
                    continue;
                }
                _ => self.before = Before::Open,
            }
            self.line_start = false;
            self.code_end = next;
            i = next;
        }
    }

    fn word(&mut self, word: &str, offset: usize) {
        let rest = &self.text[offset + word.len()..];
        let begins_item = match word {
            "contract" | "moore" | "line" | "import" => !is_meant_as_name(rest),
            "machine" => !declares_inner_machine(rest) && !is_meant_as_name(rest),
            "skills" => declares_skill_set(rest),
            "layout" | "recipe" => declares_layout_or_recipe(&self.text[..self.code_end], rest),
            _ => false,
        };
        if begins_item && self.line_start {
            self.missing_brace(word, offset);
        }
        if word == "skills" && self.stack.is_empty() {
            self.skills = skills_head(rest).map(|length| offset + word.len() + length);
        }
        if matches!(word, "component" | "order")
            && matches!(self.stack.as_slice(), [Bracket { skills: true, .. }])
        {
            // An order can end with a symbol after which an expression would continue:
            // `(Left Right)*`.
            self.expression_ends();
        }
        let goes_on = INFIX.contains(&word)
            || self.before == Before::Open
            || self.before == Before::Number && UNITS.contains(&word);
        if ends_expressions(word) || !goes_on {
            self.expression_ends();
        }
        if PREFIXES.contains(&word) {
            self.prefixes += 1;
            self.reach(offset);
        }
        self.before = if word.starts_with(|c: char| c.is_ascii_digit()) {
            Before::Number
        } else if INFIX.contains(&word) || PREFIXES.contains(&word) || ends_expressions(word) {
            Before::Open
        } else {
            Before::Operand
        };
    }

    fn open(&mut self, kind: u8, offset: usize) {
        self.stack.push(Bracket {
            kind,
            offset,
            prefixes: self.prefixes,
            skills: kind == b'{' && self.skills == Some(offset),
        });
        self.before = Before::Open;
        self.reach(offset);
    }

    fn close(&mut self, kind: u8) {
        self.before = Before::Operand;
        let opening = match kind {
            b')' => b'(',
            b']' => b'[',
            _ => b'{',
        };
        if kind == b'}' {
            // A closing brace also closes all brackets that are open within the braces.
            let Some(at) = self.stack.iter().rposition(|b| b.kind == opening) else {
                return;
            };
            self.stack.truncate(at + 1);
        }
        if self.stack.last().is_some_and(|b| b.kind == opening)
            && let Some(bracket) = self.stack.pop()
        {
            self.prefixes = bracket.prefixes;
        }
    }

    fn expression_ends(&mut self) {
        self.prefixes = self.stack.last().map_or(0, |b| b.prefixes);
    }

    fn reach(&mut self, offset: usize) {
        let depth = self.stack.len() + self.prefixes;
        if depth > self.scan.depth {
            (self.scan.depth, self.scan.deepest) = (depth, offset);
        }
    }

    fn copy(&mut self) -> &mut Vec<u8> {
        self.copy
            .get_or_insert_with(|| self.text.as_bytes().to_vec())
    }

    fn unclosed_comment(&mut self, start: usize) {
        self.scan.findings.push(
            Diagnostic::error(
                codes::SYNTAX,
                Span::new(self.file, start, start + 2),
                "this comment is never closed",
            )
            .with_help("end it with `*/`"),
        );
        self.copy()[start..].fill(b' ');
    }

    fn unclosed_string(&mut self, start: usize, end: usize) {
        self.scan.findings.push(
            Diagnostic::error(
                codes::SYNTAX,
                Span::new(self.file, start, end),
                "this text in quotes does not end on its line",
            )
            .with_help("end it with `\"`"),
        );
        self.copy()[start..end].fill(b' ');
        let line = self.text[..start].rfind('\n').map_or(0, |n| n + 1);
        self.scan.silenced.push(line..end + 1);
    }

    /// Handles a word within braces that is only allowed outside of braces: reports the braces as
    /// never closed, and closes them in the mended copy.
    fn missing_brace(&mut self, word: &str, offset: usize) {
        let blanks = self.text.as_bytes()[self.code_end..]
            .iter()
            .take_while(|b| b.is_ascii_whitespace())
            .count();
        let open: Vec<usize> = self
            .stack
            .iter()
            .filter(|b| b.kind == b'{')
            .map(|b| b.offset)
            .take(blanks + 1)
            .collect();
        if open.is_empty() || blanks < open.len() {
            return;
        }
        let end = self.code_end;
        self.copy()[end..end + open.len()].fill(b'}');
        self.stack.clear();
        self.prefixes = 0;
        let finding = self.never_closed(open[0]).with_label(
            Span::new(self.file, offset, offset + word.len()),
            "it has to be closed before this",
        );
        self.scan.findings.push(finding);
    }

    /// Closes the braces that are open at the end of the file.
    fn close_all(&mut self) {
        let open: Vec<usize> = self
            .stack
            .iter()
            .filter(|b| b.kind == b'{')
            .map(|b| b.offset)
            .collect();
        if let Some(first) = open.first() {
            let finding = self.never_closed(*first);
            self.scan.findings.push(finding);
            let copy = self.copy();
            copy.push(b'\n');
            copy.resize(copy.len() + open.len(), b'}');
        }
    }

    fn never_closed(&self, offset: usize) -> Diagnostic {
        Diagnostic::error(
            codes::SYNTAX,
            Span::new(self.file, offset, offset + 1),
            "this `{` is never closed",
        )
        .with_help("add the missing `}`")
    }
}
