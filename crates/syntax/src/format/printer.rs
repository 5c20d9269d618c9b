//! The printer's state: the statement being printed, and the comments not yet printed.

use super::super::ast::{Expr, File, Name};
use super::comments::{Comment, Cut, Token, cut, newlines};
use super::layout::{Piece, Writer, flat, render};
use linewright_core::source::Span;

/// What precedes a statement.
#[derive(Clone, Copy, PartialEq)]
enum After {
    /// A line end.
    Line,
    /// A doc comment.
    Doc,
    /// A comment on the same line.
    Same,
}

/// Prints statements in sequence.
pub(super) struct Printer<'t> {
    text: &'t str,
    comments: std::iter::Peekable<std::vec::IntoIter<Comment>>,
    /// Start of each multi-line comment, and its number of line ends.
    long: Vec<(usize, usize)>,
    tokens: Vec<Token>,
    places: &'t [Span],
    pieces: Vec<Piece>,
    out: Writer,
    /// Nesting depth of the statement's block.
    base: usize,
    /// Additional indentation of the statement's next line.
    pub nest: usize,
    /// Level of breaks, see [`Piece::Break`].
    level: usize,
    /// Whether the last piece is a break.
    at_break: bool,
    /// Whether the block is still empty.
    fresh: bool,
    /// Ends of the open blocks.
    ends: Vec<usize>,
}

impl<'t> Printer<'t> {
    pub fn new(file: &'t File, text: &'t str) -> Self {
        let Cut { comments, tokens } = cut(text);
        Self {
            text,
            long: comments
                .iter()
                .filter(|c| c.text.contains('\n'))
                .map(|c| (c.start, newlines(&c.text)))
                .collect(),
            comments: comments.into_iter().peekable(),
            tokens,
            places: if text.is_empty() { &[] } else { &file.places },
            pieces: Vec::new(),
            out: Writer::new(),
            base: 0,
            nest: 0,
            level: 0,
            at_break: true,
            fresh: true,
            ends: vec![text.len()],
        }
    }

    /// Prints the remaining comments and returns the text.
    pub fn finish(mut self) -> String {
        self.leading(usize::MAX);
        self.out.finish()
    }

    /// Returns whether there is no source text, and therefore no comments and no line ends of the
    /// author.
    pub fn bare(&self) -> bool {
        self.text.is_empty()
    }

    // ---- statements -----------------------------------------------------------------------------

    /// Begins a statement on a new line, after the comments before it. Returns the statement's
    /// place in the text.
    pub fn begin(&mut self, apart: bool) -> Span {
        let place = self.take_place();
        if self.bare() {
            self.out.line(self.base, apart && !self.fresh);
        } else {
            let start = place.start as usize;
            let word = self.tokens.partition_point(|t| t.start < start);
            let word = self.tokens.get(word).copied();
            let start = word.map_or(start, |t| t.start);
            match self.leading(start) {
                After::Same => self.out.text(" "),
                after => {
                    let empty = word.is_some_and(|t| t.blank_before);
                    let empty = empty && !self.fresh && after != After::Doc;
                    self.out.line(self.base, empty);
                }
            }
        }
        self.fresh = false;
        self.start();
        place
    }

    /// Ends a statement; comments after it on the same line stay there.
    pub fn end(&mut self) {
        render(std::mem::take(&mut self.pieces), &mut self.out);
        let next = self.places.first().map_or(usize::MAX, |p| self.word_at(*p));
        let end = self.ends.last().copied().unwrap_or(usize::MAX).min(next);
        while let Some(c) = self
            .comments
            .next_if(|c| !c.own_line && !c.doc() && c.start < end)
        {
            self.out.append_comment(&c);
            if c.line() {
                break;
            }
        }
    }

    /// Prints a doc comment, given without slashes, if there is no source text. With a source text,
    /// the doc comment is printed as one of the comments of the source.
    pub fn doc(&mut self, doc: &str) {
        if self.bare() && !doc.is_empty() {
            for line in doc.split('\n') {
                self.out.text(format!("/// {line}").trim_end());
                self.out.line(self.base, false);
            }
        }
    }

    /// Prints a block of statements in braces. A single statement stays on the same line if the
    /// author wrote it there and `short` allows it.
    pub fn block<T>(
        &mut self,
        place: Span,
        items: &[T],
        short: bool,
        mut print: impl FnMut(&mut Self, Span, &T),
    ) {
        let close = (place.end as usize).saturating_sub(1);
        let comment = self.comments.peek().is_some_and(|c| c.start < close);
        if items.is_empty() && !comment {
            self.put(" {}");
            return;
        }
        if let [only] = items
            && short
            && !comment
            && self.on_one_line(close)
        {
            let (places, pieces) = (self.places, self.pieces.clone());
            self.put(" { ");
            let place = self.take_place();
            print(self, place, only);
            self.put(" }");
            let room = super::layout::WIDTH.saturating_sub(self.base * 4);
            if flat(&self.pieces, room).is_some() {
                return;
            }
            (self.places, self.pieces) = (places, pieces);
        }
        self.put(" {");
        self.ends.push(close);
        self.end();
        self.base += 1;
        self.fresh = true;
        for item in items {
            let place = self.begin(false);
            print(self, place, item);
            self.end();
        }
        if !self.bare() {
            self.leading(close);
        }
        self.ends.pop();
        self.base -= 1;
        self.fresh = false;
        self.out.line(self.base, false);
        self.start();
        self.put("}");
    }

    /// Returns whether the next statement, and the brace before it, are on the same line as the
    /// brace at `close`.
    fn on_one_line(&self, close: usize) -> bool {
        let Some(place) = self.places.first() else {
            return false;
        };
        let word = self
            .tokens
            .partition_point(|t| t.start < place.start as usize);
        let brace = word.checked_sub(1).map_or(0, |b| self.tokens[b].start);
        self.text
            .get(brace..close)
            .is_some_and(|t| newlines(t) == 0)
    }

    fn start(&mut self) {
        self.nest = 0;
        self.level = 0;
        self.at_break = false;
        self.pieces.push(Piece::Mark { level: 0 });
        self.level = 1;
    }

    fn take_place(&mut self) -> Span {
        match self.places {
            [first, rest @ ..] => {
                self.places = rest;
                *first
            }
            [] => Span::default(),
        }
    }

    /// Returns the offset of a statement's first word after its doc comment.
    fn word_at(&self, place: Span) -> usize {
        let start = place.start as usize;
        let word = self.tokens.partition_point(|t| t.start < start);
        self.tokens.get(word).map_or(start, |t| t.start)
    }

    // ---- comments -------------------------------------------------------------------------------

    /// Prints the comments before a statement, and returns the kind of text that now precedes the
    /// statement.
    fn leading(&mut self, before: usize) -> After {
        let mut after = After::Line;
        while let Some(c) = self.comments.next_if(|c| c.start < before) {
            if after == After::Same && !c.own_line {
                self.out.text(" ");
            } else {
                let empty = c.blank_before && !self.fresh && after != After::Doc;
                self.out.line(self.base, empty);
            }
            self.out.text(&c.text);
            self.fresh = false;
            after = if c.doc() {
                After::Doc
            } else if c.line() || c.newline_after {
                After::Line
            } else {
                After::Same
            };
        }
        after
    }

    /// Prints the comments before a place within a statement.
    pub fn before(&mut self, span: Span) {
        let indent = self.base + self.nest.max(1);
        while let Some(comment) = self.comments.next_if(|c| c.start < span.start as usize) {
            self.pieces.push(Piece::Comment { comment, indent });
        }
    }

    // ---- pieces ---------------------------------------------------------------------------------

    /// Prints text.
    pub fn put(&mut self, text: &str) {
        self.at_break = false;
        match self.pieces.last_mut() {
            Some(Piece::Text(last)) => last.push_str(text),
            _ => self.pieces.push(Piece::Text(text.to_owned())),
        }
    }

    /// Prints a name.
    pub fn name(&mut self, name: &Name) {
        self.before(name.span);
        self.put(&name.text);
    }

    /// Prints a possible line end. The line ends if `forced` is set or if it has to; otherwise a
    /// blank is printed if `blank` is set.
    pub fn gap(&mut self, level: usize, blank: bool, forced: bool) {
        self.pieces.push(Piece::Break {
            level,
            indent: self.base + self.nest,
            blank,
            forced,
        });
        self.at_break = true;
    }

    /// Prints pieces with a new level of breaks, which `print` receives. Additional indentation
    /// that `print` sets ends with the level.
    pub fn level(&mut self, print: impl FnOnce(&mut Self, usize)) {
        let (level, nest) = (self.level, self.nest);
        self.pieces.push(Piece::Mark { level });
        self.level += 1;
        print(self, level);
        (self.level, self.nest) = (level, nest);
    }

    /// Indents the following lines by one more level, unless `at_break` is true.
    pub fn nest(&mut self, at_break: bool) {
        self.nest += usize::from(!at_break);
    }

    /// Returns whether the last piece is a break.
    pub fn at_break(&self) -> bool {
        self.at_break
    }

    /// Marks the beginning of an `if ... else if`; [`Self::ladder_ends`] marks the end.
    pub fn ladder_begins(&mut self, level: usize) -> usize {
        self.pieces.push(Piece::Ladder { level, length: 0 });
        self.pieces.len()
    }

    /// Marks the end of an `if ... else if`. `begun` is the result of [`Self::ladder_begins`].
    pub fn ladder_ends(&mut self, begun: usize) {
        let count = self.pieces.len() - begun;
        if let Some(Piece::Ladder { length, .. }) = self.pieces.get_mut(begun - 1) {
            *length = count;
        }
    }

    /// Returns whether the author ended a line between two places, not counting line ends in
    /// comments.
    pub fn broken(&self, before: Span, after: Span) -> bool {
        let gap = before.end as usize..after.start as usize;
        let ends = self.text.get(gap.clone()).map_or(0, newlines);
        let within = |list: &[(usize, usize)]| -> usize {
            let first = list.partition_point(|(start, _)| *start < gap.start);
            let comments = list[first..].iter();
            comments
                .take_while(|(start, _)| *start < gap.end)
                .map(|(_, lines)| lines)
                .sum()
        };
        ends > 0 && ends > within(&self.long)
    }

    /// Returns the source text of a place, if there is a source text.
    pub fn written(&self, span: Span) -> Option<&'t str> {
        self.text
            .get(span.start as usize..span.end as usize)
            .filter(|t| !t.is_empty())
    }

    /// Returns the words and symbols between two places.
    pub fn words_between(
        &self,
        before: u32,
        after: u32,
    ) -> impl Iterator<Item = &'t str> + use<'t, '_> {
        let (before, after) = (before as usize, after as usize);
        let text = self.text;
        self.tokens
            .iter()
            .filter(move |t| t.start >= before && t.end <= after)
            .map(move |t| &text[t.start..t.end])
    }

    /// Prints elements separated by commas, in brackets. `open` is the place of the bracket: if the
    /// author ended the line there, both brackets are on separate lines.
    pub fn sequence<T>(
        &mut self,
        brackets: [&str; 2],
        open: Span,
        items: &[T],
        span: impl Fn(&T) -> Span,
        mut print: impl FnMut(&mut Self, &T),
    ) {
        let wide = items.first().is_some_and(|i| self.broken(open, span(i)));
        self.level(|p, level| {
            p.put(brackets[0]);
            let outer = p.nest;
            p.nest += 1;
            let mut last = None;
            for item in items {
                if let Some(last) = last {
                    p.put(",");
                    let forced = p.broken(last, span(item));
                    p.gap(level, true, forced);
                } else if wide {
                    p.gap(level, false, true);
                }
                print(p, item);
                last = Some(span(item));
            }
            if wide {
                p.nest = outer;
                p.gap(level, false, true);
            }
            p.put(brackets[1]);
        });
    }

    /// Prints `= value`, on a new line if it does not fit.
    pub fn value(&mut self, before: Span, value: &Expr) {
        self.put(" =");
        let forced = self.broken(before, value.span);
        if !forced && self.opens_wide(value) {
            self.put(" ");
        } else {
            self.nest = 1;
            self.gap(0, true, forced);
        }
        self.expression(value);
        self.nest = 0;
    }
}
