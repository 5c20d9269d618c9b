//! Decision procedures for the algebra of contracts: refinement, composition, conjunction,
//! quotient, merging, and the proof that components discharge one another's assumptions.
//!
//! A contract is a pair of an assumption A and a guarantee G. Each consists of initial conditions,
//! invariants, safety and justice, and denotes a set of infinite runs over the variables of all
//! contracts involved. Guarantees are saturated internally (`Ĝ = ¬A ∨ G`). Definitions follow
//! Benveniste et al., "Contracts for System Design" (2018), Passerone, Íncer Romeo and
//! Sangiovanni-Vincentelli, "Coherent extension, composition, and merging operators in contract
//! models" (2019), and Íncer Romeo et al., "Quotient for assume-guarantee contracts" (2018).
//!
//! ```text
//! Specification... ─join→ System ─prove→ Proof (discharges, or counterexamples) ─replay→ accepted
//! System, Contract (an expression over its components) ─Decider→ included, or a Lasso ─replay→ accepted
//! ```
//!
//! The results of composition, conjunction, quotient and merging are not GR(1) in general. So a
//! result remains an expression over its components ([`contract::Contract`]), and questions about
//! it are decided exactly on infinite runs ([`decide`]). The proof of a composition ([`proof`]) is
//! different: it follows the strict semantics, in which a guarantee must not rely on a later
//! violation by others.

pub mod caller;
pub mod closed;
pub mod compat;
pub mod contract;
pub mod decide;
pub mod join;
pub mod machine;
pub mod proof;
pub mod refine;
pub mod replay;
pub mod system;
