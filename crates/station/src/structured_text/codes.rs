//! Converts values to integers and back, for tables and bits: a Boolean is 0 or 1, a label is its
//! index, an integer is itself.
//!
//! The standard has no conversion between enumerations and numbers, so CASE statements are used.

use super::interface::Port;
use super::{Type, Width};
use std::fmt::Write;

/// Width of a variable that can hold the value of any of these ports, encoded as a number.
pub(super) fn width(ports: &[Port<'_>]) -> Width {
    let widths = ports.iter().map(|p| match &p.kind {
        Type::Integer(width) => *width,
        _ => Width::of(0, p.labels.len() as i64),
    });
    widths.max().unwrap_or(Width::Int)
}

/// Statements that store the value of a port, encoded as a number, in `target`, a variable of this
/// width.
pub(super) fn read(port: &Port<'_>, target: &str, width: Width) -> String {
    let name = &port.name;
    match &port.kind {
        Type::Bool => {
            format!("IF {name} THEN {target} := 1; ELSE {target} := 0; END_IF;\n")
        }
        Type::Integer(own) => format!("{target} := {};\n", own.convert(width, name)),
        _ => {
            let mut out = format!("CASE {name} OF\n");
            for (number, label) in port.labels.iter().enumerate() {
                let _ = writeln!(out, "    {label}: {target} := {number};");
            }
            out + "END_CASE;\n"
        }
    }
}

/// Statements that set a port from its number in `source`, an expression of this width.
pub(super) fn write(port: &Port<'_>, source: &str, width: Width) -> String {
    let name = &port.name;
    match &port.kind {
        Type::Bool => format!("{name} := ({source} = 1);\n"),
        Type::Integer(own) => format!("{name} := {};\n", width.convert(*own, source)),
        _ => {
            let mut out = format!("CASE {source} OF\n");
            for (number, label) in port.labels.iter().enumerate() {
                let _ = writeln!(out, "    {number}: {name} := {label};");
            }
            out + "END_CASE;\n"
        }
    }
}
