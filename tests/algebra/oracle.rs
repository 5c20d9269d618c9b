//! The algebra of contracts compared with brute force.
//!
//! Random small contracts; every set of runs is enumerated on all lassos up to a bound; every game
//! and every composition on explicit states. What is compared shares no code with
//! `crates/algebra/src` except its data types and look-ups in them (who sets a variable, which
//! formula is referenced, which variables it restricts).
//!
//! | file | what it shows |
//! |---|---|
//! | `operations` | the five operations are the sets that their definitions say, and questions about them are decided right |
//! | `laws` | the laws of the algebra, exactly and on all lassos |
//! | `refinement` | refinement with its reasons: the same verdict, reasons that are enough and none too many, real counterexamples |
//! | `compatibility` | environments exist where a naive solver of the swapped game finds one |
//! | `circles` | what a proof of a composition promises holds of all machines that keep the parts' contracts |

mod circles;
mod compatibility;
mod contracts;
mod graph;
mod lassos;
mod laws;
mod operations;
mod refinement;
mod wired;
