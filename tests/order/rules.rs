//! Skill orders compared with brute force.
//!
//! The meaning of rules is implemented a second time, by quantifiers over the positions of a word
//! and without automata (`naive`, `expression`); it shares only data types with
//! `crates/language/src/order`. All results of the automata are compared with it.
//!
//! | file | what it shows |
//! |---|---|
//! | `singles` | automaton, regular expression and meaning agree on all words up to eight skills out of six |
//! | `pairs` | all sequences of calls of one or two skills, up to eight skills in all: allowed when every order is, or when some order is |
//! | `at_once` | events of several skills in every place of a rule, what stands at the start, deleted transitions, calls of three skills |
//! | `equivalence` | random rules: words, their regular expression, smaller automata |
//! | `programs` | random programs: the first violation, the shortest way on, the shortest difference |
//! | `findings` | what is said to be wrong with random rules is, and what no rule excludes no other does either |
//! | `orders` | up to six skills at once against all orders; the order that a refusal names |

mod at_once;
mod equivalence;
mod expression;
mod findings;
mod naive;
mod orders;
mod pairs;
mod programs;
mod random;
mod singles;
mod units;
