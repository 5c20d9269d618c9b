//! Regular expressions over steps, as deterministic automata over finite words.
//!
//! By derivatives (Brzozowski: Derivatives of Regular Expressions, JACM 1964), which take complement and intersection as they come:
//! the derivative of r after a step is what may follow that step. A state is an expression; equal ones are found because sums and
//! intersections are sets.

use super::automaton::{Automaton, MAX_ATOMS, MAX_STATES, Tree};
use super::reader::Reader;
use super::scope::Symbol;
use super::syntax::{Name, Regexp, RegexpShape};
use super::value::Value;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Expr;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Repetitions written out may have so many parts.
const MAX_PARTS: u64 = 4000;

/// A regular expression; steps are numbered conditions.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Re {
    Never,
    Empty,
    /// One step, whatever holds in it.
    Any,
    Step(usize),
    Not(Rc<Re>),
    Sequence(Rc<Re>, Rc<Re>),
    Star(Rc<Re>),
    And(BTreeSet<Re>),
    Or(BTreeSet<Re>),
}

impl Re {
    pub fn not(self) -> Self {
        match self {
            Self::Not(inner) => (*inner).clone(),
            other => Self::Not(Rc::new(other)),
        }
    }

    pub fn then(self, next: Self) -> Self {
        match (self, next) {
            (Self::Never, _) | (_, Self::Never) => Self::Never,
            (Self::Empty, r) | (r, Self::Empty) => r,
            // To the right, so that equal ones look alike.
            (Self::Sequence(a, b), next) => Self::Sequence(a, Rc::new((*b).clone().then(next))),
            (a, b) => Self::Sequence(Rc::new(a), Rc::new(b)),
        }
    }

    pub fn star(self) -> Self {
        match self {
            Self::Never | Self::Empty => Self::Empty,
            star @ Self::Star(_) => star,
            other => Self::Star(Rc::new(other)),
        }
    }

    fn is_all(&self) -> bool {
        matches!(self, Self::Not(inner) if **inner == Self::Never)
            || matches!(self, Self::Star(inner) if **inner == Self::Any)
    }

    pub fn or(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut set = BTreeSet::new();
        for part in parts {
            match part {
                Self::Never => {}
                Self::Or(inner) => set.extend(inner),
                part if part.is_all() => return part,
                part => {
                    set.insert(part);
                }
            }
        }
        match set.len() {
            0 => Self::Never,
            1 => set.pop_first().unwrap_or(Self::Never),
            _ => Self::Or(set),
        }
    }

    pub fn and(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut set = BTreeSet::new();
        for part in parts {
            match part {
                Self::Never => return Self::Never,
                Self::And(inner) => set.extend(inner),
                part if part.is_all() => {}
                part => {
                    set.insert(part);
                }
            }
        }
        match set.len() {
            0 => Self::Never.not(),
            1 => set.pop_first().unwrap_or(Self::Never),
            _ => Self::And(set),
        }
    }

    /// Whether it matches the empty word.
    pub fn matches_empty(&self) -> bool {
        match self {
            Self::Never | Self::Any | Self::Step(_) => false,
            Self::Empty | Self::Star(_) => true,
            Self::Not(r) => !r.matches_empty(),
            Self::Sequence(a, b) => a.matches_empty() && b.matches_empty(),
            Self::And(set) => set.iter().all(Self::matches_empty),
            Self::Or(set) => set.iter().any(Self::matches_empty),
        }
    }

    /// The conditions that matter for the next step.
    fn heads(&self, found: &mut BTreeSet<usize>) {
        match self {
            Self::Never | Self::Empty | Self::Any => {}
            Self::Step(atom) => {
                found.insert(*atom);
            }
            Self::Not(r) | Self::Star(r) => r.heads(found),
            Self::Sequence(a, b) => {
                a.heads(found);
                if a.matches_empty() {
                    b.heads(found);
                }
            }
            Self::And(set) | Self::Or(set) => set.iter().for_each(|r| r.heads(found)),
        }
    }

    /// What may follow a step in which the conditions have these values.
    fn after(&self, values: &BTreeMap<usize, bool>) -> Self {
        match self {
            Self::Any => Self::Empty,
            Self::Step(atom) if values.get(atom) == Some(&true) => Self::Empty,
            Self::Never | Self::Empty | Self::Step(_) => Self::Never,
            Self::Not(r) => r.after(values).not(),
            Self::Star(r) => r.after(values).then(self.clone()),
            Self::Sequence(a, b) => {
                let first = a.after(values).then((**b).clone());
                if a.matches_empty() {
                    Self::or([first, b.after(values)])
                } else {
                    first
                }
            }
            Self::And(set) => Self::and(set.iter().map(|r| r.after(values))),
            Self::Or(set) => Self::or(set.iter().map(|r| r.after(values))),
        }
    }

    /// The automaton that is in an accepting state after the words that match; `None` if it is too large.
    pub fn automaton(&self) -> Option<Automaton> {
        let mut states = vec![self.clone()];
        let mut known = BTreeMap::from([(self.clone(), 0)]);
        let mut steps = Vec::new();
        while steps.len() < states.len() {
            if states.len() > MAX_STATES {
                return None;
            }
            let state = states[steps.len()].clone();
            let mut heads = BTreeSet::new();
            state.heads(&mut heads);
            if heads.len() > MAX_ATOMS {
                return None;
            }
            let heads: Vec<usize> = heads.into_iter().collect();
            steps.push(Tree::over(&heads, &mut |values| {
                let next = state.after(values);
                *known.entry(next.clone()).or_insert_with(|| {
                    states.push(next);
                    states.len() - 1
                })
            }));
        }
        let accepting = states.iter().map(Self::matches_empty).collect();
        Some(Automaton { steps, accepting }.minimal())
    }
}

impl Reader {
    /// A regular expression with its names looked up. Its conditions are added to `atoms`.
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
        let mut two = |reader: &mut Self, a: &Regexp, b: &Regexp| {
            let a = reader.regexp_part(a, atoms, parts);
            let b = reader.regexp_part(b, atoms, parts);
            Some((a?, b?))
        };
        match &regexp.shape {
            RegexpShape::Empty => Some(Re::Empty),
            RegexpShape::Constant(value) => Some(if *value { Re::Any } else { Re::Never }),
            RegexpShape::Sequence(a, b) => two(self, a, b).map(|(a, b)| a.then(b)),
            RegexpShape::And(a, b) => two(self, a, b).map(|(a, b)| Re::and([a, b])),
            RegexpShape::Or(a, b) => two(self, a, b).map(|(a, b)| Re::or([a, b])),
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
                        "this cannot be repeated so often",
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
