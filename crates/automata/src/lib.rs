//! Finite automata, regular expressions and formulas of linear temporal logic, and conversions
//! between them.
//!
//! The meaning of a letter is left to the caller: a skill that is called, conditions that hold in a
//! step. There are two kinds of automata, for different purposes:
//!
//! - [`dfa`] has a row of successors, one for each *letter*, and refuses letters without a
//!   successor. Its letters are few and known beforehand, so a row is an array, and comparing,
//!   trimming and minimising take time in its length.
//! - [`symbolic`] has a *decision* in each state: a tree over the conditions that matter there. A
//!   text may mention fifty conditions, a few in each state; as letters these would be 2^50.
//!
//! There are also two kinds of regular expressions, for the same reason:
//!
//! - [`regex`] is over letters, becomes a [`dfa`] by way of a nondeterministic automaton, and is
//!   what [`eliminate`] makes of a [`dfa`]. It can count thousands of repetitions, which
//!   derivatives would copy at every step.
//! - [`derivative`] has complement and intersection, which a nondeterministic automaton does not
//!   support directly. It is over conditions, and becomes a [`symbolic`] automaton.
//!
//! [`ltl`] makes either kind: a [`dfa`] of a safety formula, a [`symbolic`] automaton of one with
//! eventualities. Formulas with source positions, and rewriting before this stage, belong to the
//! crates that read them.

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
