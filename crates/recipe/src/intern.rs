//! Numbers for sequences of words: each distinct sequence is stored once.

use rustc_hash::{FxBuildHasher, FxHashMap};
use std::hash::BuildHasher;

/// End of a chain.
const NONE: u32 = u32::MAX;

/// Distinct sequences, numbered in the order in which they were first given.
#[derive(Default)]
pub(crate) struct Interner {
    /// Sequences one after the other.
    words: Vec<u16>,
    /// End of each sequence in `words`.
    ends: Vec<usize>,
    /// For each hash, the last sequence that has it.
    heads: FxHashMap<u64, u32>,
    /// Another sequence with the same hash.
    next: Vec<u32>,
}

impl Interner {
    /// Returns the number of sequences.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns a sequence.
    pub fn get(&self, number: u32) -> &[u16] {
        let at = number as usize;
        let begin = if at == 0 { 0 } else { self.ends[at - 1] };
        &self.words[begin..self.ends[at]]
    }

    /// Returns the number of a sequence, and whether it is new.
    pub fn intern(&mut self, words: &[u16]) -> (u32, bool) {
        let hash = FxBuildHasher.hash_one(words);
        let head = self.heads.get(&hash).copied().unwrap_or(NONE);
        let mut at = head;
        while at != NONE {
            if self.get(at) == words {
                return (at, false);
            }
            at = self.next[at as usize];
        }
        let number = self.ends.len() as u32;
        self.words.extend_from_slice(words);
        self.ends.push(self.words.len());
        self.next.push(head);
        self.heads.insert(hash, number);
        (number, true)
    }
}
