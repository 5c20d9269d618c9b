//! Finite automata, regular expressions and formulas of linear temporal logic, and conversions
//! between them.
//!
//! The caller defines the meaning of a letter: a skill that is called, or the conditions that hold
//! in a step. There are two kinds of automata, for different purposes:
//!
//! - A [`dfa`] has an array of successors for each state, one for each *letter*, and refuses
//!   letters without a successor. It is for few letters that are known beforehand, because
//!   comparing, trimming and minimizing visit all of them.
//! - A [`symbolic`] automaton has a *decision* in each state: a tree over the conditions that are
//!   relevant there. It is for many conditions of which each state reads only a few. As a [`dfa`],
//!   an automaton over fifty conditions would need 2^50 letters.
//!
//! There are also two kinds of regular expressions, for the same reason:
//!
//! - [`regex`] is over letters and is converted to a [`dfa`] through a nondeterministic automaton;
//!   [`eliminate`] converts a [`dfa`] back. It can count thousands of repetitions, which
//!   derivatives would copy at every step.
//! - [`derivative`] is over conditions and is converted to a [`symbolic`] automaton. It has
//!   complement and intersection, which a nondeterministic automaton does not support directly.
//!
//! [`ltl`] converts a safety formula to a [`dfa`], and a formula with eventualities to a
//! [`symbolic`] automaton. Formulas with source positions, and their rewriting before this stage,
//! belong to the crates that read the formulas.

pub mod antichain;
pub mod bound;
pub mod derivative;
pub mod dfa;
pub mod eliminate;
pub mod ltl;
mod partition;
pub mod regex;
pub mod search;
pub mod symbolic;
