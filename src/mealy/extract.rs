//! From a won game to a machine.

use super::Machine;
use crate::game::{Limit, Limits, Won};
use crate::gr1::Specification;

/// The machine of a won game, minimised, not yet verified.
pub fn extract(
    specification: &Specification,
    won: &Won,
    limits: &Limits,
) -> Result<Machine, Limit> {
    let _ = (specification, won, limits);
    todo!("extraction")
}
