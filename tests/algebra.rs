//! The algebra of contracts: proofs of composition, and the exact decisions, each against what does not share its code.

#[path = "algebra/machines.rs"]
mod machines;
