//! Source files, spans and line numbers.
//!
//! A [`SourceMap`] owns the text of every file that was read; a [`Span`] is a byte range in one of
//! them. This module does not access the disk: the caller reads the files.

use std::ops::Range;
use std::sync::Arc;

/// The index of a file in its [`SourceMap`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct FileId(pub u32);

/// A half-open byte range `start..end` of one file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Span {
    /// File that contains the range.
    pub file: FileId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// Creates the span `start..end` of `file`.
    pub fn new(file: FileId, start: usize, end: usize) -> Self {
        Self {
            file,
            start: start as u32,
            end: end as u32,
        }
    }

    /// Returns whether another span lies within this span or equals it.
    pub fn contains(self, other: Self) -> bool {
        self.file == other.file && self.start <= other.start && other.end <= self.end
    }

    /// Returns the smallest span that contains both spans, which must be in the same file.
    #[must_use]
    pub fn to(self, other: Self) -> Self {
        Self {
            file: self.file,
            start: self.start.min(other.start),
            end: self.end.max(other.end),
        }
    }
}

/// A file: display name and text.
#[derive(Debug, Clone)]
pub struct SourceFile {
    /// Name as the user wrote it, or `std/...` for the bundled library.
    pub name: String,
    /// The whole text.
    pub text: Arc<str>,
    line_starts: Vec<u32>,
}

/// A line and column for display; both start at 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// All files that were read, indexed by [`FileId`].
#[derive(Debug, Clone, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
}

impl SourceMap {
    /// Creates an empty map.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file and returns its id. Files with the same name are different files.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> FileId {
        let text = text.into();
        let line_starts = std::iter::once(0)
            .chain(text.match_indices('\n').map(|(i, _)| i as u32 + 1))
            .collect();
        self.files.push(SourceFile {
            name: name.into(),
            text,
            line_starts,
        });
        FileId(self.files.len() as u32 - 1)
    }

    /// Returns the file with this id.
    ///
    /// # Panics
    /// If the id is not from this map.
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// Returns all files in the order in which they were added.
    pub fn files(&self) -> impl Iterator<Item = (FileId, &SourceFile)> {
        self.files
            .iter()
            .enumerate()
            .map(|(i, f)| (FileId(i as u32), f))
    }

    /// Returns the text of a span; empty if the span is not in the file or splits a character.
    pub fn text(&self, span: Span) -> &str {
        let text = &self.file(span.file).text;
        text.get(span.start as usize..span.end as usize)
            .unwrap_or("")
    }

    /// Returns line and column of a span's first character.
    pub fn start(&self, span: Span) -> Position {
        self.position(span.file, span.start)
    }

    /// Returns line and column one past a span's last character.
    pub fn end(&self, span: Span) -> Position {
        self.position(span.file, span.end)
    }

    /// Returns the byte range of all lines from the first to the last of these places, which must
    /// be in one file.
    pub(crate) fn lines(&self, places: impl Iterator<Item = Span>) -> Range<usize> {
        let mut places = places.peekable();
        let Some(first) = places.peek() else {
            return 0..0;
        };
        let file = self.file(first.file);
        let (start, end) = places.fold((u32::MAX, 0), |(start, end), span| {
            (start.min(span.start), end.max(span.end))
        });
        let after = |offset| file.line_starts.partition_point(|&s| s <= offset).max(1);
        let end = file.line_starts.get(after(end));
        let start = file.line_starts[after(start) - 1] as usize;
        start..end.map_or(file.text.len(), |end| *end as usize).max(start)
    }

    /// Returns line and column of a byte of a file.
    pub(crate) fn position(&self, file: FileId, offset: u32) -> Position {
        let file = self.file(file);
        let line = file.line_starts.partition_point(|&s| s <= offset).max(1);
        let start = file.line_starts[line - 1] as usize;
        let prefix = file.text.get(start..offset as usize).unwrap_or("");
        // A byte order mark does not count as a character of the first line.
        let prefix = prefix.strip_prefix('\u{feff}').unwrap_or(prefix);
        Position {
            line,
            column: prefix.chars().count() + 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_order_mark_has_no_column() {
        let mut map = SourceMap::new();
        let file = map.add("a.lw", "\u{feff}type T");
        let span = Span::new(file, 8, 9);
        assert_eq!(map.text(span), "T");
        assert_eq!(map.start(span), Position { line: 1, column: 6 });
    }

    #[test]
    fn columns_count_characters() {
        let mut map = SourceMap::new();
        let file = map.add("a.lw", "ab\n□ x\n");
        let span = Span::new(file, 3 + '□'.len_utf8() + 1, 3 + '□'.len_utf8() + 2);
        assert_eq!(map.text(span), "x");
        assert_eq!(map.start(span), Position { line: 2, column: 3 });
    }
}
