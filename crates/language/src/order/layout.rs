//! Table layout for monitors: one memory access per call.
//!
//! The number of a state is the offset of its row in the table, so the index of an entry is the
//! state plus the skill. The length of a row is a power of two. An entry of at least
//! [`Layout::refused`] encodes the reason for a refusal. The monitors in this process, in C and in
//! Structured Text use the same numbers.

use super::monitor::RefusalReason;
use super::table::{RECALL, REFUSED, TOGETHER, Table};

/// Table of a monitor: rows for single skills, and rows for sets of skills.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Number of entries in a row of [`Layout::single`]: a power of two, at least the number of
    /// skills.
    pub stride: usize,
    /// One row per state, with one entry per skill: the state after this skill or, if the entry is
    /// at least [`Layout::refused`], the reason why the skill is refused.
    pub single: Vec<u32>,
    /// Sets of two or more skills for which `at_once` has entries, as masks in ascending order.
    pub sets: Vec<u64>,
    /// One row per state, with one entry per set, encoded as in [`Layout::single`]. The index of
    /// the row is the state divided by `stride`.
    pub at_once: Vec<u32>,
    /// Smallest entry that encodes a refusal; smaller entries are states.
    pub refused: u32,
    /// State before the first call.
    pub start: u32,
    /// Number of rules.
    rules: u32,
}

impl Layout {
    /// Lays out the rows of a table.
    ///
    /// # Panics
    /// When the number of entries does not fit in `u32`.
    pub fn new(table: &Table) -> Self {
        let stride = table.skills.len().next_power_of_two();
        let small = |number: usize| {
            u32::try_from(number).expect("a table has too many entries; please report this")
        };
        let mut layout = Self {
            stride,
            single: Vec::new(),
            sets: Vec::new(),
            at_once: Vec::new(),
            refused: small(table.states * stride),
            start: table.start * small(stride),
            rules: small(table.rules.len()),
        };
        // Checks that the codes of the refusals, which follow the states, fit in `u32`, too.
        small(table.states * stride + table.rules.len() + 3);
        let mut sets: Vec<(u64, usize)> = Vec::new();
        let mut singles: Vec<Option<usize>> = vec![None; stride];
        for (column, &mask) in table.calls.iter().enumerate() {
            if mask.is_power_of_two() {
                singles[mask.trailing_zeros() as usize] = Some(column);
            } else {
                sets.push((mask, column));
            }
        }
        sets.sort_unstable();
        for state in 0..table.states {
            let row = singles.iter().map(|column| match column {
                Some(column) => layout.entry(table, state, *column),
                None => layout.refusal_code(RefusalReason::Unknown),
            });
            let row: Vec<u32> = row.collect();
            layout.single.extend(row);
            for (_, column) in &sets {
                layout.at_once.push(layout.entry(table, state, *column));
            }
        }
        layout.sets = sets.into_iter().map(|(mask, _)| mask).collect();
        layout
    }

    /// Returns the entry for a column of the table.
    fn entry(&self, table: &Table, state: usize, column: usize) -> u32 {
        let place = state * table.calls.len() + column;
        match table.next[place] {
            REFUSED => self.refusal_code(match table.reasons[place] {
                RECALL => RefusalReason::Recall,
                TOGETHER => RefusalReason::Together,
                rule => RefusalReason::Rule(usize::from(rule)),
            }),
            to => to * self.stride as u32,
        }
    }

    /// Returns the entry that encodes a refusal.
    pub fn refusal_code(&self, why: RefusalReason) -> u32 {
        self.refused
            + match why {
                RefusalReason::Rule(rule) => rule as u32,
                RefusalReason::Recall => self.rules,
                RefusalReason::Together => self.rules + 1,
                RefusalReason::Unknown => self.rules + 2,
            }
    }

    /// Decodes the reason for a refusal from an entry, which must be at least
    /// [`Layout::refused`].
    pub fn refusal_reason(&self, entry: u32) -> RefusalReason {
        match entry - self.refused {
            rule if rule < self.rules => RefusalReason::Rule(rule as usize),
            other if other == self.rules => RefusalReason::Recall,
            other if other == self.rules + 1 => RefusalReason::Together,
            _ => RefusalReason::Unknown,
        }
    }
}
