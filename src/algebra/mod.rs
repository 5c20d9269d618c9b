//! The algebra of contracts, as decision procedures: refinement, composition, conjunction, quotient, merging, and the proof that
//! parts discharge one another's assumptions.
//!
//! A contract is a pair of an assumption A and a guarantee G, each an initial condition, invariants, safety and justice: a set of
//! infinite runs over the variables of all contracts in question. Guarantees are saturated inside (`Ĝ = ¬A ∨ G`), and nobody is
//! asked to do so. Definitions follow Benveniste et al., "Contracts for System Design" (2018), Passerone, Íncer Romeo and
//! Sangiovanni-Vincentelli, "Coherent extension, composition, and merging operators in contract models" (2019), and Íncer Romeo et al., "Quotient for
//! assume-guarantee contracts" (2018).

pub mod proof;
pub mod system;
