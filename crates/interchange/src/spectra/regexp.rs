//! Resolves the names of regular expressions over steps, and expands their repetitions.

use super::reader::Reader;
use super::scope::Symbol;
use super::syntax::{Name, Regexp, RegexpOp, RegexpShape};
use super::value::Value;
use linewright_automata::derivative::ExtendedRegex as Re;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Expr;

/// Maximum number of parts of a regular expression, with its repetitions expanded.
const MAX_PARTS: u64 = 4000;

impl Reader {
    /// Lowers a regular expression, and adds its conditions to `atoms`.
    pub fn regexp(&mut self, regexp: &Regexp, atoms: &mut Vec<Value>) -> Option<Re> {
        self.down(regexp.span)?;
        let mut parts = 0;
        let found = self.regexp_part(regexp, atoms, &mut parts);
        self.up();
        found
    }

    fn regexp_part(
        &mut self,
        regexp: &Regexp,
        atoms: &mut Vec<Value>,
        parts: &mut u64,
    ) -> Option<Re> {
        *parts += 1;
        if *parts > MAX_PARTS {
            self.too_many_states(regexp.span);
            return None;
        }
        self.down(regexp.span)?;
        let found = self.regexp_shape(regexp, atoms, parts);
        self.up();
        found
    }

    fn regexp_shape(
        &mut self,
        regexp: &Regexp,
        atoms: &mut Vec<Value>,
        parts: &mut u64,
    ) -> Option<Re> {
        match &regexp.shape {
            RegexpShape::Empty => Some(Re::Empty),
            RegexpShape::Constant(value) => Some(if *value { Re::Any } else { Re::Never }),
            RegexpShape::Chain(first, others) => {
                let mut found = self.regexp_part(first, atoms, parts);
                for (op, other) in others {
                    let other = self.regexp_part(other, atoms, parts);
                    if *parts > MAX_PARTS {
                        return None;
                    }
                    found = found.zip(other).map(|(a, b)| match op {
                        RegexpOp::Then => a.then(b),
                        RegexpOp::And => Re::and([a, b]),
                        RegexpOp::Or => Re::or([a, b]),
                    });
                }
                found
            }
            RegexpShape::Complement(inner) => Some(self.regexp_part(inner, atoms, parts)?.not()),
            RegexpShape::Step(node) => {
                let value = self.truth(node)?;
                match value.expr.simplify() {
                    Expr::Const(0) => return Some(Re::Never),
                    Expr::Const(_) => return Some(Re::Any),
                    _ => {}
                }
                let known = atoms.iter().position(|a| a.expr == value.expr);
                Some(Re::Step(known.unwrap_or_else(|| {
                    atoms.push(value);
                    atoms.len() - 1
                })))
            }
            RegexpShape::Named(name) => {
                let found = self.symbol(name, regexp.span).cloned();
                let Some((Symbol::Regexp(named), span)) = found else {
                    self.unknown("regular expression", name, regexp.span);
                    return None;
                };
                let name = Name {
                    text: name.clone(),
                    span,
                };
                self.expanded(&name, regexp.span, |reader| {
                    reader.regexp_part(&named, atoms, parts)
                })
            }
            RegexpShape::Repeat(inner, low, high) => {
                let before = *parts;
                let inner = self.regexp_part(inner, atoms, parts)?;
                let each = *parts - before;
                let low = self.number(low)?;
                let high = match high {
                    Some(high) => Some(self.number(high)?),
                    None => None,
                };
                if low < 0 || high.is_some_and(|h| h < low) {
                    self.error(
                        codes::DOMAIN_EMPTY,
                        regexp.span,
                        "the number of repetitions is invalid",
                        "repeat at least 0 times, and write the smaller number first",
                    );
                    return None;
                }
                let times = high.unwrap_or(low).unsigned_abs();
                *parts = parts.saturating_add(each.saturating_mul(times));
                if *parts > MAX_PARTS {
                    self.too_many_states(regexp.span);
                    return None;
                }
                let mut found = match high {
                    None => inner.clone().star(),
                    Some(high) => (low..high).fold(Re::Empty, |rest, _| {
                        Re::or([Re::Empty, inner.clone().then(rest)])
                    }),
                };
                for _ in 0..low {
                    found = inner.clone().then(found);
                }
                Some(found)
            }
        }
    }
}
