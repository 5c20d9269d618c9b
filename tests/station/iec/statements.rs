//! Compiles statements.

use super::compiler::Compiler;
use super::interpreter::{
    Code, Flow, INTEGERS, NOTHING, Run, Type, Variable, fault, one, sequence, turn,
};
use super::syntax::{Expr, Kind, Label, Section, Statement};
use std::collections::HashMap;

impl Compiler {
    pub fn statements(&mut self, list: &[Statement]) -> Result<Vec<Run>, String> {
        list.iter().map(|s| self.statement(s)).collect()
    }

    pub fn statement(&mut self, statement: &Statement) -> Result<Run, String> {
        self.line = statement.line;
        let line = statement.line;
        Ok(match &statement.kind {
            Kind::Exit => Box::new(|_| Flow::Exit),
            Kind::Continue => Box::new(|_| Flow::Continue),
            Kind::Return => Box::new(|_| Flow::Return),
            Kind::Assign(target, value) => self.assignment(target, value)?,
            Kind::If(branches, otherwise) => {
                let mut compiled = Vec::new();
                for (condition, body) in branches {
                    let condition = self.condition(condition)?;
                    compiled.push((condition, self.statements(body)?));
                }
                let otherwise = self.statements(otherwise)?;
                Box::new(move |m| {
                    for (condition, body) in &compiled {
                        if condition.run(m) != 0 {
                            return sequence(body, m);
                        }
                    }
                    sequence(&otherwise, m)
                })
            }
            Kind::Case(selector, branches, otherwise) => {
                self.case(selector, branches, otherwise)?
            }
            Kind::While(condition, body) => {
                let condition = self.condition(condition)?;
                let body = self.statements(body)?;
                Box::new(move |m| {
                    while condition.run(m) != 0 {
                        turn(m, line);
                        match sequence(&body, m) {
                            Flow::On | Flow::Continue => {}
                            Flow::Exit => break,
                            Flow::Return => return Flow::Return,
                        }
                    }
                    Flow::On
                })
            }
            Kind::Repeat(body, condition) => {
                let body = self.statements(body)?;
                self.line = line;
                let condition = self.condition(condition)?;
                Box::new(move |m| {
                    loop {
                        turn(m, line);
                        match sequence(&body, m) {
                            Flow::On | Flow::Continue => {}
                            Flow::Exit => break,
                            Flow::Return => return Flow::Return,
                        }
                        if condition.run(m) != 0 {
                            break;
                        }
                    }
                    Flow::On
                })
            }
            Kind::For {
                variable,
                from,
                to,
                by,
                body,
            } => {
                let variable = self.written(variable)?;
                let (Type::Integer(place), true) = (variable.kind, variable.dimensions.is_empty())
                else {
                    return self.wrong("the variable of a FOR is a whole number");
                };
                let (_, low, high) = INTEGERS[place];
                let mut number = |expr: &Expr| {
                    let (of, code) = self.expression(expr)?;
                    self.fitted(of, code, variable.kind)
                };
                let (from, to) = (number(from)?, number(to)?);
                let by = by.as_ref().map_or(Ok(Code::Constant(1)), &mut number)?;
                if matches!(by, Code::Constant(0)) {
                    return self.wrong("a FOR that does not advance");
                }
                if assigns(body, variable.slot, &self.variables) {
                    return self.wrong("the variable of a FOR is changed within");
                }
                let slot = variable.slot;
                let temporary = variable.section == Section::Temporary;
                let body = self.statements(body)?;
                Box::new(move |m| {
                    let (from, to, by) = (from.run(m), to.run(m), by.run(m));
                    m[slot] = from;
                    while if by > 0 { m[slot] <= to } else { m[slot] >= to } {
                        turn(m, line);
                        match sequence(&body, m) {
                            Flow::On | Flow::Continue => {}
                            Flow::Exit => return Flow::On,
                            Flow::Return => return Flow::Return,
                        }
                        m[slot] = match m[slot].checked_add(by) {
                            Some(next) if low <= next && next <= high => next,
                            _ => fault(line, "the variable of a FOR overflows"),
                        };
                    }
                    if temporary {
                        m[slot] = NOTHING;
                    }
                    Flow::On
                })
            }
        })
    }

    /// A variable that may be written to.
    pub fn written(&self, name: &str) -> Result<Variable, String> {
        let Some(variable) = self.variables.get(name) else {
            return self.wrong(&format!("`{name}` is not declared"));
        };
        if matches!(variable.section, Section::Input | Section::Constant) {
            return self.wrong(&format!("`{name}` cannot be written to"));
        }
        Ok(variable.clone())
    }

    pub fn assignment(&mut self, target: &Expr, value: &Expr) -> Result<Run, String> {
        let line = self.line;
        let (Expr::Name(name) | Expr::Index(name, _)) = target else {
            return self.wrong("no variable");
        };
        let variable = self.written(name)?;
        let (of, code) = self.expression(value)?;
        let code = self.fitted(of, code, variable.kind)?;
        let code = match variable.range {
            None => code,
            Some((low, high)) => one(code, move |v| {
                if v < low || high < v {
                    fault(line, "a value leaves its subrange");
                }
                v
            }),
        };
        let indices: &[Expr] = if let Expr::Index(_, indices) = target {
            indices
        } else {
            &[]
        };
        Ok(match (self.place(&variable, indices)?, code) {
            (Code::Constant(slot), Code::Constant(value)) => {
                let slot = slot as usize;
                Box::new(move |m| {
                    m[slot] = value;
                    Flow::On
                })
            }
            (Code::Constant(slot), code) => {
                let slot = slot as usize;
                Box::new(move |m| {
                    m[slot] = code.run(m);
                    Flow::On
                })
            }
            (place, code) => Box::new(move |m| {
                let value = code.run(m);
                let slot = place.run(m) as usize;
                m[slot] = value;
                Flow::On
            }),
        })
    }

    pub fn case(
        &mut self,
        selector: &Expr,
        branches: &[(Vec<Label>, Vec<Statement>)],
        otherwise: &[Statement],
    ) -> Result<Run, String> {
        let (of, selector) = self.expression(selector)?;
        if !matches!(of, Type::Integer(_) | Type::Enumeration(_)) {
            return self.wrong("a CASE chooses by a number or a label");
        }
        let mut ranges: Vec<(i64, i64, usize)> = Vec::new();
        let mut bodies = Vec::new();
        for (labels, body) in branches {
            for label in labels {
                let constant = |expr: &Expr| {
                    let (kind, code) = self.expression(expr)?;
                    match self.fitted(kind, code, of)? {
                        Code::Constant(value) => Ok(value),
                        _ => self.wrong("a label of a CASE is no constant"),
                    }
                };
                let first = constant(&label.first)?;
                let last = label.last.as_ref().map_or(Ok(first), constant)?;
                if ranges.iter().any(|(a, b, _)| *a <= last && first <= *b) {
                    return self.wrong("a value of a CASE appears there twice");
                }
                ranges.push((first, last, bodies.len()));
            }
            bodies.push(self.statements(body)?);
        }
        ranges.sort_unstable();
        let otherwise = self.statements(otherwise)?;
        Ok(Box::new(move |m| {
            let value = selector.run(m);
            let place = ranges.partition_point(|(first, ..)| *first <= value);
            match place.checked_sub(1).map(|p| ranges[p]) {
                Some((_, last, body)) if value <= last => sequence(&bodies[body], m),
                _ => sequence(&otherwise, m),
            }
        }))
    }

    pub fn condition(&self, expr: &Expr) -> Result<Code, String> {
        let (of, code) = self.expression(expr)?;
        if of != Type::Bool {
            return self.wrong("a condition is a BOOL");
        }
        Ok(code)
    }
}

/// Whether statements assign to the variable in this slot.
fn assigns(list: &[Statement], slot: usize, variables: &HashMap<String, Variable>) -> bool {
    let is = |name: &String| variables.get(name).is_some_and(|v| v.slot == slot);
    let inside = |list: &[Statement]| assigns(list, slot, variables);
    list.iter().any(|statement| match &statement.kind {
        Kind::Assign(Expr::Name(name), _) => is(name),
        Kind::If(branches, otherwise) => {
            branches.iter().any(|(_, b)| inside(b)) || inside(otherwise)
        }
        Kind::Case(_, branches, otherwise) => {
            branches.iter().any(|(_, b)| inside(b)) || inside(otherwise)
        }
        Kind::For { variable, body, .. } => is(variable) || inside(body),
        Kind::While(_, body) | Kind::Repeat(body, _) => inside(body),
        _ => false,
    })
}
