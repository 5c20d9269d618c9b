//! Compiles expressions and determines their types.

use super::compiler::Compiler;
use super::interpreter::{Code, INTEGERS, NOTHING, Type, Variable, both, fault, one};
use super::syntax::{Expr, Section, Spec};
use std::panic::{AssertUnwindSafe, catch_unwind};

impl Compiler {
    /// Location of an element.
    pub fn place(&self, variable: &Variable, indices: &[Expr]) -> Result<Code, String> {
        let line = self.line;
        if indices.len() != variable.dimensions.len() {
            return self.wrong("an array and its indices do not go together");
        }
        let mut place = Code::Constant(variable.slot as i64);
        let mut stride = variable.length as i64;
        for (index, (low, high)) in indices.iter().zip(&variable.dimensions) {
            let (low, high) = (*low, *high);
            stride /= high - low + 1;
            let (of, code) = self.expression(index)?;
            if !matches!(of, Type::Integer(_) | Type::Literal) {
                return self.wrong("an index is a whole number");
            }
            let step = stride;
            let offset = move |index: i64| {
                if index < low || high < index {
                    fault(line, "an index leaves its array");
                }
                (index - low) * step
            };
            place = match (place, code) {
                (Code::Constant(base), Code::Constant(index)) => {
                    if index < low || high < index {
                        return self.wrong("an index leaves its array");
                    }
                    Code::Constant(base + offset(index))
                }
                (Code::Constant(base), code) => one(code, move |i| base + offset(i)),
                (place, code) => both(place, code, move |base, i| base + offset(i)),
            };
        }
        Ok(place)
    }

    /// A value where another type is expected: only untyped numbers fit any.
    pub fn fitted(&self, of: Type, code: Code, wanted: Type) -> Result<Code, String> {
        match (of, wanted, &code) {
            (Type::Literal, Type::Integer(place), Code::Constant(value)) => {
                let (name, low, high) = INTEGERS[place];
                if *value < low || high < *value {
                    return self.wrong(&format!("{value} is no {name}"));
                }
                Ok(code)
            }
            // Truncating a string counts as an error here.
            (Type::Text(length), Type::Text(most), _) if length <= most => Ok(code),
            _ if of == wanted => Ok(code),
            _ => self.wrong(&format!("{of:?} where {wanted:?} is wanted")),
        }
    }

    /// Two operands of one type.
    pub fn alike(&self, a: (Type, Code), b: (Type, Code)) -> Result<(Type, Code, Code), String> {
        let of = if a.0 == Type::Literal { b.0 } else { a.0 };
        Ok((of, self.fitted(a.0, a.1, of)?, self.fitted(b.0, b.1, of)?))
    }

    pub fn label(&self, name: &str) -> Option<(Type, Code)> {
        let places = self.enumerations.iter().enumerate();
        let mut found = places.filter_map(|(place, (_, labels))| {
            let value = labels.iter().position(|l| l == name)?;
            Some((Type::Enumeration(place), Code::Constant(value as i64)))
        });
        found.next()
    }

    pub fn expression(&self, expr: &Expr) -> Result<(Type, Code), String> {
        let line = self.line;
        match expr {
            Expr::Number(value) => match i64::try_from(*value) {
                Ok(value) => Ok((Type::Literal, Code::Constant(value))),
                Err(_) => self.wrong("a number that no type holds"),
            },
            Expr::Text(text) => {
                let value = self.text(text);
                Ok((Type::Text(text.len()), Code::Constant(value)))
            }
            Expr::Typed(name, value) => self.typed(name, value),
            Expr::Name(name) if name == "TRUE" || name == "FALSE" => {
                Ok((Type::Bool, Code::Constant(i64::from(name == "TRUE"))))
            }
            Expr::Name(name) | Expr::Index(name, _) => {
                let Some(variable) = self.variables.get(name) else {
                    return match self.label(name) {
                        Some(label) if matches!(expr, Expr::Name(_)) => Ok(label),
                        _ => self.wrong(&format!("`{name}` is not declared")),
                    };
                };
                let indices: &[Expr] = if let Expr::Index(_, i) = expr { i } else { &[] };
                let checked = move |value: i64| {
                    if value == NOTHING {
                        fault(line, "a temporary variable has no value yet");
                    }
                    value
                };
                let temporary = variable.section == Section::Temporary;
                let code = match self.place(variable, indices)? {
                    Code::Constant(slot) if temporary => {
                        let slot = slot as usize;
                        Code::Other(Box::new(move |m| checked(m[slot])))
                    }
                    Code::Constant(slot) => Code::Slot(slot as usize),
                    place if temporary => Code::Other(Box::new(move |m| {
                        let slot = place.run(m) as usize;
                        checked(m[slot])
                    })),
                    place => Code::Other(Box::new(move |m| {
                        let slot = place.run(m) as usize;
                        m[slot]
                    })),
                };
                Ok((variable.kind, code))
            }
            Expr::Unary("NOT", a) => {
                let a = self.condition(a)?;
                Ok((Type::Bool, one(a, |v| 1 - v)))
            }
            Expr::Unary(_, a) => {
                let zero = (Type::Literal, Code::Constant(0));
                let (of, zero, a) = self.alike(zero, self.expression(a)?)?;
                self.arithmetic("-", of, zero, a)
            }
            Expr::Binary(op, a, b) => {
                let (of, a, b) = self.alike(self.expression(a)?, self.expression(b)?)?;
                let truth = |code| Ok((Type::Bool, code));
                match (*op, of) {
                    ("AND", Type::Bool) => truth(both(a, b, |a, b| a & b)),
                    ("OR", Type::Bool) => truth(both(a, b, |a, b| a | b)),
                    ("XOR", Type::Bool) => truth(both(a, b, |a, b| a ^ b)),
                    ("=", _) => truth(both(a, b, |a, b| i64::from(a == b))),
                    ("<>", _) => truth(both(a, b, |a, b| i64::from(a != b))),
                    ("<" | ">" | "<=" | ">=", Type::Integer(_) | Type::Literal) => {
                        truth(match *op {
                            "<" => both(a, b, |a, b| i64::from(a < b)),
                            ">" => both(a, b, |a, b| i64::from(a > b)),
                            "<=" => both(a, b, |a, b| i64::from(a <= b)),
                            _ => both(a, b, |a, b| i64::from(a >= b)),
                        })
                    }
                    ("+" | "-" | "*" | "/" | "MOD", Type::Integer(_) | Type::Literal) => {
                        self.arithmetic(op, of, a, b)
                    }
                    _ => self.wrong(&format!("`{op}` of {of:?}")),
                }
            }
            Expr::Call(name, arguments) => self.function(name, arguments),
        }
    }

    pub fn typed(&self, name: &str, value: &Expr) -> Result<(Type, Code), String> {
        if let Some(place) = self.enumerations.iter().position(|(n, _)| n == name) {
            let labels = &self.enumerations[place].1;
            let Expr::Name(label) = value else {
                return self.wrong("no label");
            };
            let Some(value) = labels.iter().position(|l| l == label) else {
                return self.wrong(&format!("`{name}` has no label `{label}`"));
            };
            return Ok((Type::Enumeration(place), Code::Constant(value as i64)));
        }
        let (kind, _) = self.kind(&Spec::Named(name.to_owned()))?;
        match (kind, value) {
            (Type::Bool, Expr::Number(bit @ (0 | 1))) => {
                Ok((Type::Bool, Code::Constant(*bit as i64)))
            }
            (_, Expr::Number(_) | Expr::Name(_)) => {
                let (of, code) = self.expression(value)?;
                Ok((kind, self.fitted(of, code, kind)?))
            }
            _ => self.wrong("no literal"),
        }
    }

    /// `+ - * / MOD` within a type. Division rounds toward 0; the remainder of a division by 0 is
    /// 0.
    pub fn arithmetic(&self, op: &str, of: Type, a: Code, b: Code) -> Result<(Type, Code), String> {
        let line = self.line;
        let (low, high) = match of {
            Type::Integer(place) => (INTEGERS[place].1, INTEGERS[place].2),
            Type::Literal => (i64::MIN, i64::MAX),
            _ => return self.wrong(&format!("`{op}` of {of:?}")),
        };
        let held = move |value: Option<i64>| match value {
            Some(value) if low <= value && value <= high => value,
            _ => fault(line, "a number leaves its type"),
        };
        let code = match op {
            "+" => both(a, b, move |a, b| held(a.checked_add(b))),
            "-" => both(a, b, move |a, b| held(a.checked_sub(b))),
            "*" => both(a, b, move |a, b| held(a.checked_mul(b))),
            "/" => both(a, b, move |a, b| {
                if b == 0 {
                    fault(line, "a division by 0");
                }
                held(a.checked_div(b))
            }),
            _ => both(a, b, |a, b| if b == 0 { 0 } else { a.wrapping_rem(b) }),
        };
        // Untyped operands give an untyped result, computed at once.
        if of == Type::Literal {
            let computed = catch_unwind(AssertUnwindSafe(|| code.run(&mut [])));
            return match computed {
                Ok(value) => Ok((of, Code::Constant(value))),
                Err(_) => self.wrong("a constant that cannot be computed"),
            };
        }
        Ok((of, code))
    }

    pub fn function(&self, name: &str, arguments: &[Expr]) -> Result<(Type, Code), String> {
        let line = self.line;
        let mut given = Vec::new();
        for argument in arguments {
            given.push(self.expression(argument)?);
        }
        let count = given.len();
        let mut given = given.into_iter();
        let mut next = || given.next().expect("they were counted");
        let integer = |of: Type| matches!(of, Type::Integer(_));
        match (name, count) {
            ("ABS", 1) => {
                let (of, a) = next();
                if let (Type::Literal, Code::Constant(value)) = (of, &a) {
                    return Ok((of, Code::Constant(value.abs())));
                }
                let Type::Integer(place) = of else {
                    return self.wrong("ABS of what is no number");
                };
                let high = INTEGERS[place].2;
                let code = one(a, move |v| match v.checked_abs() {
                    Some(v) if v <= high => v,
                    _ => fault(line, "a number leaves its type"),
                });
                Ok((of, code))
            }
            ("MIN" | "MAX", 2) => {
                let (of, a, b) = self.alike(next(), next())?;
                if !integer(of) {
                    return self.wrong("MIN and MAX of what are no numbers");
                }
                let code = if name == "MIN" {
                    both(a, b, i64::min)
                } else {
                    both(a, b, i64::max)
                };
                Ok((of, code))
            }
            ("LIMIT", 3) => {
                let (low, value, high) = (next(), next(), next());
                let (of, low, value) = self.alike(low, value)?;
                let high = self.fitted(high.0, high.1, of)?;
                if !integer(of) {
                    return self.wrong("LIMIT of what are no numbers");
                }
                Ok((of, both(both(low, value, i64::max), high, i64::min)))
            }
            ("SEL", 3) => {
                let (of, condition) = next();
                if of != Type::Bool {
                    return self.wrong("SEL chooses by a BOOL");
                }
                let (of, no, yes) = self.alike(next(), next())?;
                let code = Code::Other(Box::new(move |m| {
                    let (chosen, no) = (condition.run(m), no.run(m));
                    let yes = yes.run(m);
                    if chosen != 0 { yes } else { no }
                }));
                Ok((of, code))
            }
            (_, 1) => {
                let kind = |n: &str| INTEGERS.iter().position(|(name, ..)| *name == n);
                let pair = name.split_once("_TO_");
                let pair = pair.and_then(|(a, b)| Some((kind(a)?, kind(b)?)));
                let Some((from, to)) = pair else {
                    return self.wrong(&format!("there is no function `{name}`"));
                };
                let (of, a) = next();
                let a = self.fitted(of, a, Type::Integer(from))?;
                let (_, low, high) = INTEGERS[to];
                let code = one(a, move |v| {
                    if v < low || high < v {
                        fault(line, "a number leaves its type");
                    }
                    v
                });
                Ok((Type::Integer(to), code))
            }
            _ => self.wrong(&format!("there is no function `{name}` of {count}")),
        }
    }
}
