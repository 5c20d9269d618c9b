//! Builds temporal formulas. Equivalences move subformulas about the long run out of the scope of
//! temporal operators.
//!
//! `L` is a formula about the long run: `G F a`, `F G a`, or a combination of these with `&` and
//! `|`. It holds in a step exactly if it holds in any later step, so temporal operators do not
//! affect it. Esparza, Křetínský and Sickert (A unified translation of linear temporal logic to
//! ω-automata, 2020) use the same property.
//!
//! ```text
//! X L = G L = F L = L          G (a | L) = G a | L                 F (a & L) = F a & L
//! a U (b & L) = (a U b) & L                 a U (b | L) = (a U b) | L
//! (a & L) U b = (a U b) & (b | L)           (a | L) U b = F b & ((a U b) | L)
//! a W (b & L) = (a W b) & (G a | L)         a W (b | L) = (a W b) | L
//! (a & L) W b = (a W b) & (b | L)           (a | L) W b = (a W b) | L
//! a R (b & L) = (a R b) & L                 a R (b | L) = (a R b) | L
//! (a & L) R b = (a R b) & (G b | L)         (a | L) R b = (a R b) | L & b
//!
//! G F (a U b) = G F b                       F G (a R b) = F G b
//! G F (a W b) = G F b | F G a               F G (a U b) = G F b & F G (a | b)
//! G F (a R b) = G F (a & b) | F G b         F G (a W b) = F G (a | b)
//! G F (a & F b) = G F a & G F b             F G (a | G b) = F G a | F G b
//!
//! F (a U b) = F b = a U F b                 G (a R b) = G b
//! F (a W b) = F b | F G a                   G (a W b) = G (a | b)
//! F (a R b) = F (a & b) | F G b             G (a U b) = G (a | b) & G F b
//! F X a = X F a                             G X a = X G a
//! ```

use super::ltl::{FormulaId, Formulas, Op, Place};

impl Formulas {
    /// Whether the operators of `f` show that it holds in a step exactly if it holds in any later
    /// step.
    pub fn is_long_run(&self, f: FormulaId) -> bool {
        match self.op(f) {
            Op::Globally(a) => matches!(self.op(*a), Op::Finally(_)),
            Op::Finally(a) => matches!(self.op(*a), Op::Globally(_)),
            Op::And(list) | Op::Or(list) => list.iter().all(|g| self.is_long_run(*g)),
            _ => false,
        }
    }

    /// Splits operands into those about the long run and the others; `None` if no operand is about
    /// the long run.
    fn split_list(&self, list: &[FormulaId]) -> Option<(Vec<FormulaId>, Vec<FormulaId>)> {
        let (long, rest): (Vec<FormulaId>, Vec<FormulaId>) =
            list.iter().partition(|g| self.is_long_run(**g));
        (!long.is_empty()).then_some((long, rest))
    }

    /// Splits a conjunction (`true`) or disjunction (`false`) into its operands about the long run
    /// and the rest; `None` if there are no such operands.
    fn split(&mut self, f: FormulaId) -> Option<(bool, Vec<FormulaId>, FormulaId)> {
        let place = self.place(f);
        match self.op(f).clone() {
            Op::And(list) => {
                let (long, rest) = self.split_list(&list)?;
                Some((true, long, self.and(rest, place)))
            }
            Op::Or(list) => {
                let (long, rest) = self.split_list(&list)?;
                Some((false, long, self.or(rest, place)))
            }
            _ => None,
        }
    }

    /// `X a`
    pub fn next(&mut self, a: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(a) {
            return a;
        }
        match self.op(a).clone() {
            Op::And(list) | Op::Or(list) => {
                let and = matches!(self.op(a), Op::And(_));
                let list = list.into_iter().map(|b| self.next(b, place)).collect();
                let own = self.place(a);
                if and {
                    self.and(list, own)
                } else {
                    self.or(list, own)
                }
            }
            _ => self.make(Op::Next(a), place),
        }
    }

    /// `G a`
    pub fn globally(&mut self, a: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(a) {
            return a;
        }
        if let Some((false, mut list, rest)) = self.split(a) {
            list.push(self.globally(rest, place));
            return self.or(list, place);
        }
        match self.op(a).clone() {
            Op::Next(b) if self.ahead(a).is_none() => {
                let inner = self.globally(b, place);
                self.next(inner, place)
            }
            Op::Finally(b) => self.recurrent(b, place),
            Op::Weak(b, c) => {
                let either = self.or(vec![b, c], place);
                self.globally(either, place)
            }
            Op::Release(_, b) => self.globally(b, place),
            Op::Until(b, c) => {
                let either = self.or(vec![b, c], place);
                let list = vec![self.globally(either, place), self.recurrent(c, place)];
                self.and(list, place)
            }
            _ => self.make(Op::Globally(a), place),
        }
    }

    /// `F a`
    pub fn finally(&mut self, a: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(a) {
            return a;
        }
        if let Some((true, mut list, rest)) = self.split(a) {
            list.push(self.finally(rest, place));
            return self.and(list, place);
        }
        match self.op(a).clone() {
            Op::Next(b) if self.ahead(a).is_none() => {
                let inner = self.finally(b, place);
                self.next(inner, place)
            }
            Op::Globally(b) => self.persistent(b, place),
            Op::Until(_, b) => self.finally(b, place),
            Op::Weak(b, c) => {
                let list = vec![self.finally(c, place), self.persistent(b, place)];
                self.or(list, place)
            }
            Op::Release(b, c) => {
                let both = self.and(vec![b, c], place);
                let list = vec![self.finally(both, place), self.persistent(c, place)];
                self.or(list, place)
            }
            Op::Or(list) if self.ahead(a).is_none() => {
                let list = list.into_iter().map(|b| self.finally(b, place)).collect();
                self.or(list, place)
            }
            _ => self.make(Op::Finally(a), place),
        }
    }

    /// `G F a`
    fn recurrent(&mut self, a: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(a) {
            return a;
        }
        match self.op(a).clone() {
            _ if self.ahead(a).is_some() => {}
            Op::Or(list) => {
                let (near, far): (Vec<FormulaId>, Vec<FormulaId>) =
                    list.into_iter().partition(|g| self.ahead(*g).is_some());
                let near = self.or(near, place);
                let list = std::iter::once(near)
                    .chain(far)
                    .map(|g| self.recurrent(g, place))
                    .collect();
                return self.or(list, place);
            }
            Op::And(list) => {
                let free =
                    |s: &Self, g: FormulaId| s.is_long_run(g) || matches!(s.op(g), Op::Finally(_));
                let (far, rest): (Vec<FormulaId>, Vec<FormulaId>) =
                    list.into_iter().partition(|g| free(self, *g));
                if !far.is_empty() {
                    let rest = self.and(rest, place);
                    let list = far
                        .into_iter()
                        .chain([rest])
                        .map(|g| self.recurrent(g, place))
                        .collect();
                    return self.and(list, place);
                }
            }
            Op::Next(b) | Op::Finally(b) | Op::Until(_, b) => return self.recurrent(b, place),
            Op::Globally(b) => return self.persistent(b, place),
            Op::Weak(b, c) => {
                let list = vec![self.recurrent(c, place), self.persistent(b, place)];
                return self.or(list, place);
            }
            Op::Release(b, c) => {
                let both = self.and(vec![b, c], place);
                let list = vec![self.recurrent(both, place), self.persistent(c, place)];
                return self.or(list, place);
            }
            _ => {}
        }
        let inner = self.make(Op::Finally(a), place);
        self.make(Op::Globally(inner), place)
    }

    /// `F G a`
    fn persistent(&mut self, a: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(a) {
            return a;
        }
        match self.op(a).clone() {
            _ if self.ahead(a).is_some() => {}
            Op::And(list) => {
                let (near, far): (Vec<FormulaId>, Vec<FormulaId>) =
                    list.into_iter().partition(|g| self.ahead(*g).is_some());
                let near = self.and(near, place);
                let list = std::iter::once(near)
                    .chain(far)
                    .map(|g| self.persistent(g, place))
                    .collect();
                return self.and(list, place);
            }
            Op::Or(list) => {
                let free =
                    |s: &Self, g: FormulaId| s.is_long_run(g) || matches!(s.op(g), Op::Globally(_));
                let (far, rest): (Vec<FormulaId>, Vec<FormulaId>) =
                    list.into_iter().partition(|g| free(self, *g));
                if !far.is_empty() {
                    let rest = self.or(rest, place);
                    let list = far
                        .into_iter()
                        .chain([rest])
                        .map(|g| self.persistent(g, place))
                        .collect();
                    return self.or(list, place);
                }
            }
            Op::Next(b) | Op::Globally(b) | Op::Release(_, b) => return self.persistent(b, place),
            Op::Finally(b) => return self.recurrent(b, place),
            Op::Weak(b, c) => {
                let either = self.or(vec![b, c], place);
                return self.persistent(either, place);
            }
            Op::Until(b, c) => {
                let either = self.or(vec![b, c], place);
                let list = vec![self.recurrent(c, place), self.persistent(either, place)];
                return self.and(list, place);
            }
            _ => {}
        }
        let inner = self.make(Op::Globally(a), place);
        self.make(Op::Finally(inner), place)
    }

    /// `a U b`
    pub fn until(&mut self, a: FormulaId, b: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(b) || matches!(self.op(b), Op::Finally(_)) {
            return b;
        }
        if let Some((and, mut list, rest)) = self.split(b) {
            list.push(self.until(a, rest, place));
            return self.join(and, list, place);
        }
        let Some((and, list, rest)) = self.split_or_whole(a) else {
            return self.make(Op::Until(a, b), place);
        };
        let long = self.join(and, list, place);
        let until = self.until(rest, b, place);
        if and {
            let now = self.or(vec![b, long], place);
            return self.and(vec![until, now], place);
        }
        let (some_day, either) = (self.finally(b, place), self.or(vec![until, long], place));
        self.and(vec![some_day, either], place)
    }

    /// `a W b`
    pub fn weak(&mut self, a: FormulaId, b: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(b) {
            let always = self.globally(a, place);
            return self.or(vec![always, b], place);
        }
        if let Some((and, mut list, rest)) = self.split(b) {
            let weak = self.weak(a, rest, place);
            if !and {
                list.push(weak);
                return self.or(list, place);
            }
            let (long, always) = (self.and(list, place), self.globally(a, place));
            let either = self.or(vec![always, long], place);
            return self.and(vec![weak, either], place);
        }
        let Some((and, list, rest)) = self.split_or_whole(a) else {
            return self.make(Op::Weak(a, b), place);
        };
        let long = self.join(and, list, place);
        let weak = self.weak(rest, b, place);
        if and {
            let now = self.or(vec![b, long], place);
            return self.and(vec![weak, now], place);
        }
        self.or(vec![weak, long], place)
    }

    /// `a R b`
    pub fn release(&mut self, a: FormulaId, b: FormulaId, place: Place) -> FormulaId {
        if self.is_long_run(b) {
            return b;
        }
        if let Some((and, mut list, rest)) = self.split(b) {
            list.push(self.release(a, rest, place));
            return self.join(and, list, place);
        }
        let Some((and, list, rest)) = self.split_or_whole(a) else {
            return self.make(Op::Release(a, b), place);
        };
        let long = self.join(and, list, place);
        let release = self.release(rest, b, place);
        if and {
            let always = self.globally(b, place);
            let either = self.or(vec![always, long], place);
            return self.and(vec![release, either], place);
        }
        let now = self.and(vec![long, b], place);
        self.or(vec![release, now], place)
    }

    /// Like [`split`](Self::split), but the whole formula can also be about the long run.
    fn split_or_whole(&mut self, a: FormulaId) -> Option<(bool, Vec<FormulaId>, FormulaId)> {
        if self.is_long_run(a) {
            let place = self.place(a);
            return Some((true, vec![a], self.constant(true, place)));
        }
        self.split(a)
    }

    fn join(&mut self, and: bool, list: Vec<FormulaId>, place: Place) -> FormulaId {
        if and {
            self.and(list, place)
        } else {
            self.or(list, place)
        }
    }
}
