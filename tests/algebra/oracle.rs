//! The algebra of contracts compared with brute force.
//!
//! Random small contracts; every set of runs is enumerated on all lassos up to a bound; every game
//! and every composition on explicit states. What is compared shares no code with
//! `crates/algebra/src` except its data types and look-ups in them (who sets a variable, which
//! formula is referenced, which variables it restricts).
//!
//! | file | what it tests |
//! |---|---|
//! | `operations` | the five operations equal the sets in their definitions, and questions about them are decided correctly |
//! | `laws` | the laws of the algebra, exactly and on all lassos |
//! | `refinement` | refinement with its reasons: the same verdict, sufficient and minimal reasons, real counterexamples |
//! | `compatibility` | environments exist where a naive solver of the swapped game finds one |
//! | `circles` | the claims of a proof of composition hold for all machines that keep the parts' contracts |

mod circles;
mod compatibility;
mod contracts;
mod graph;
mod lassos;
mod laws;
mod operations;
mod refinement;
mod wired;
