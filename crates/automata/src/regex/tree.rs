//! Syntax trees of regular expressions.

/// A regular expression over letters.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Regex {
    /// No word at all.
    Nothing,
    /// The empty word.
    Empty,
    /// One letter.
    Letter(usize),
    /// Any letter except these; an empty list is any letter (`.`).
    AnyBut(Vec<usize>),
    /// All of these letters, each exactly once, in any order.
    AnyOrder(Vec<usize>),
    /// Concatenation.
    Concat(Vec<Regex>),
    /// Union.
    Either(Vec<Regex>),
    /// From `low` to `high` repetitions; unbounded if `high` is `None`.
    Repeat {
        /// Repeated expression.
        of: Box<Regex>,
        /// Minimum count.
        low: u32,
        /// Maximum count.
        high: Option<u32>,
    },
}

impl Regex {
    /// Returns whether the expression matches the empty word.
    pub fn has_empty(&self) -> bool {
        match self {
            Self::Empty => true,
            Self::Nothing | Self::Letter(_) | Self::AnyBut(_) => false,
            Self::AnyOrder(letters) => letters.is_empty(),
            Self::Concat(parts) => parts.iter().all(Self::has_empty),
            Self::Either(parts) => parts.iter().any(Self::has_empty),
            Self::Repeat { of, low, .. } => *low == 0 || of.has_empty(),
        }
    }

    /// Returns the number of letters and operators, as a measure of length.
    pub fn size(&self) -> usize {
        match self {
            Self::Nothing | Self::Empty | Self::Letter(_) => 1,
            Self::AnyBut(letters) => 1 + letters.len(),
            Self::AnyOrder(letters) => letters.len(),
            Self::Concat(parts) => parts.iter().map(Self::size).sum(),
            Self::Either(parts) => parts.iter().map(|p| p.size() + 1).sum(),
            Self::Repeat { of, .. } => of.size() + 1,
        }
    }

    /// Replaces letter `i` by `places[i]`.
    pub fn renumber(&mut self, places: &[usize]) {
        match self {
            Self::Nothing | Self::Empty => {}
            Self::Letter(letter) => *letter = places[*letter],
            Self::AnyBut(letters) | Self::AnyOrder(letters) => {
                for letter in letters.iter_mut() {
                    *letter = places[*letter];
                }
                letters.sort_unstable();
            }
            Self::Concat(parts) | Self::Either(parts) => {
                for part in parts {
                    part.renumber(places);
                }
            }
            Self::Repeat { of, .. } => of.renumber(places),
        }
    }
}
