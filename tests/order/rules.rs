//! Skill orders compared with brute force.
//!
//! The meaning of rules is implemented a second time, by quantifiers over the positions of a word
//! and without automata (`naive`, `expression`); it shares only data types with
//! `crates/language/src/order`. All results of the automata are compared with it.
//!
//! | file | what it tests |
//! |---|---|
//! | `singles` | automaton, regular expression and meaning agree on all words up to eight skills out of six |
//! | `pairs` | all sequences of calls of one or two skills, up to eight skills in total: allowed if every order is, or if some order is |
//! | `at_once` | events of several skills in every place of a rule, the initial situation, deleted transitions, calls of three skills |
//! | `equivalence` | random rules: words, their regular expression, smaller automata |
//! | `programs` | random programs: the first violation, the shortest continuation, the shortest difference |
//! | `findings` | findings about random rules are correct, and no finding is missing |
//! | `orders` | up to six skills at once compared with all orders; the order named in a refusal |

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
