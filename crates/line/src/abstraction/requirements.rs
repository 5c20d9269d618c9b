//! The names of what is required of a line.

/// The requirements, by what they are about; the names of the goal's formulas begin with these.
pub const NO_PART_LOST: &str = "no_part_lost";
/// No place takes more than it has room for.
pub const NO_OVERFLOW: &str = "no_overflow";
/// Something can always move.
pub const NO_CIRCULAR_WAIT: &str = "no_circular_wait";
/// What is in a place goes on.
pub const GOES_ON: &str = "goes_on";
/// What waits in a place to be joined is joined.
pub const COMPONENTS_GO_ON: &str = "components_go_on";
/// End products are finished again and again.
pub const ORDERS_ARE_FINISHED: &str = "orders_are_finished";
