//! Names of the requirements on a line. The names of the goal formulas begin with them.

use super::shape::Shape;

/// No part is lost.
pub const NO_PART_LOST: &str = "no_part_lost";
/// No place takes more parts than it has room for.
pub const NO_OVERFLOW: &str = "no_overflow";
/// Something can always move.
pub const NO_CIRCULAR_WAIT: &str = "no_circular_wait";
/// Parts in a place proceed.
pub const GOES_ON: &str = "goes_on";
/// Components that wait to be joined are joined.
pub const COMPONENTS_GO_ON: &str = "components_go_on";
/// End products are finished again and again.
pub const ORDERS_ARE_FINISHED: &str = "orders_are_finished";

/// Name of the requirement that parts of this type, an end product, are finished again and again.
pub(super) fn orders_are_finished(shape: &Shape, product: usize) -> String {
    if shape.products.len() == 1 {
        ORDERS_ARE_FINISHED.to_owned()
    } else {
        format!("{ORDERS_ARE_FINISHED}_for_{}", shape.types[product])
    }
}
