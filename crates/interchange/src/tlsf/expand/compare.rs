//! Evaluates `==` and `!=` on numbers, sets, and buses with values of their enumerations.

use super::super::ast::Tree;
use super::super::ltl::{FormulaId, Op, Place};
use super::super::value::Value;
use super::{Expander, Result};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::VarId;

impl Expander<'_, '_> {
    pub(super) fn equal(
        &mut self,
        x: &Value,
        y: &Value,
        tree: &Tree,
        site: u32,
    ) -> Result<FormulaId> {
        let place = Place::new(&tree.range, site);
        let decided = match (x, y) {
            (Value::Bus(bits), Value::Label(e, l)) | (Value::Label(e, l), Value::Bus(bits)) => {
                let codes = self.globals.enumerations[*e].labels[*l].codes.clone();
                if bits.len() != self.globals.enumerations[*e].width {
                    return self.fail(
                        codes::TYPE_MISMATCH,
                        &tree.range,
                        site,
                        "the bus and the enumeration have different numbers of bits",
                        "compare a bus with a value of its own enumeration",
                    );
                }
                return Ok(self.has_code(bits, &codes, place));
            }
            (Value::Bus(p), Value::Bus(q)) if p.len() == q.len() => {
                let mut parts = Vec::new();
                for (v, w) in p.iter().zip(q.iter()) {
                    let v = self.formulas.make(Op::Atom(*v), place);
                    let w = self.formulas.make(Op::Atom(*w), place);
                    parts.push(self.formulas.make(Op::Iff(v, w), place));
                }
                return Ok(self.formulas.and(parts, place));
            }
            (Value::Formula(f), Value::Formula(g)) => {
                let truths = (self.formulas.truth(*f), self.formulas.truth(*g));
                match truths {
                    (Some(a), Some(b)) => Some(a == b),
                    _ => None,
                }
            }
            (Value::Number(_), Value::Number(_))
            | (Value::Set(_), Value::Set(_))
            | (Value::Label(..), Value::Label(..)) => Some(x == y),
            _ => None,
        };
        match decided {
            Some(truth) => Ok(self.formulas.constant(truth, place)),
            None => self.fail(
                codes::TYPE_MISMATCH,
                &tree.range,
                site,
                format!("{} is compared with {} here", x.word(), y.word()),
                "use `==` for numbers, sets, and buses with values of their enumerations, and `<->` for formulas",
            ),
        }
    }

    /// The formula that is true if a bus has one of the codes.
    pub fn has_code(
        &mut self,
        bits: &[VarId],
        codes: &[Vec<Option<bool>>],
        place: Place,
    ) -> FormulaId {
        let mut cases = Vec::new();
        for code in codes {
            let mut parts = Vec::new();
            for (bit, wanted) in bits.iter().zip(code) {
                let Some(wanted) = wanted else { continue };
                let atom = self.formulas.make(Op::Atom(*bit), place);
                parts.push(if *wanted {
                    atom
                } else {
                    self.formulas.make(Op::Not(atom), place)
                });
            }
            cases.push(self.formulas.and(parts, place));
        }
        self.formulas.or(cases, place)
    }
}
