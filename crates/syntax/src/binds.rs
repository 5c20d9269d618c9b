//! Binding strength of expressions, from loosest to tightest.

use super::ast::BinaryOp;

pub const PATTERN: u8 = 0;
pub const IFF: u8 = 1;
pub const IMPLICATION: u8 = 2;
pub const DISJUNCTION: u8 = 3;
pub const EXCLUSIVE: u8 = 4;
pub const CONJUNCTION: u8 = 5;
pub const SINCE: u8 = 6;
pub const NEGATION: u8 = 7;
pub const COMPARISON: u8 = 8;
pub const ADDITIVE: u8 = 9;
pub const PRODUCT: u8 = 10;
pub const SIGNED: u8 = 11;
pub const POSTFIX: u8 = 12;

/// Returns the binding strength of an operator.
pub fn of(op: BinaryOp) -> u8 {
    match op {
        BinaryOp::Iff => IFF,
        BinaryOp::Implies => IMPLICATION,
        BinaryOp::Or => DISJUNCTION,
        BinaryOp::Xor => EXCLUSIVE,
        BinaryOp::And => CONJUNCTION,
        BinaryOp::Eq | BinaryOp::Ne | BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge => {
            COMPARISON
        }
        BinaryOp::Add | BinaryOp::Sub => ADDITIVE,
        BinaryOp::Mul | BinaryOp::Div | BinaryOp::Mod => PRODUCT,
    }
}
