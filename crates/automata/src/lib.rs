//! Finite automata, regular expressions and formulas of linear temporal logic, and the ways from
//! one to another.
//!
//! Nothing here knows what a letter stands for: a skill that is called, conditions that hold in a
//! step. There are two kinds of automata, which are not the same thing twice:
//!
//! - [`dfa`] has a row of successors, one for each *letter*, and refuses what has no successor. Its
//!   letters are few and known beforehand, so that a row is an array, and comparing, trimming and
//!   minimising take time in its length.
//! - [`symbolic`] has a *decision* in each state: a tree over the conditions that matter there. A
//!   text may speak of fifty conditions, a few in each state; as letters these would be 2^50.
//!
//! And two kinds of regular expressions, for the same reason:
//!
//! - [`regex`] is over letters, becomes a [`dfa`] by way of a nondeterministic automaton, and is
//!   what [`eliminate`] makes of a [`dfa`]. It counts thousands of repetitions, which derivatives
//!   would copy at every step.
//! - [`derivative`] has complement and intersection, which a nondeterministic automaton does not
//!   take as they come, is over conditions, and becomes a [`symbolic`] automaton.
//!
//! [`ltl`] makes either kind: a [`dfa`] of a safety formula, a [`symbolic`] automaton of one that
//! asks for what has to come some day. Formulas that know where they were written, and are
//! rewritten before they get here, belong to those who read them.

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
