//! A proof that two specifications are the same game, formula by formula, as Boolean functions.
//!
//! The specification read from a written text may have other variables (a number becomes its bits),
//! formulas in another order, and formulas that keep bits within the domain of their number. So
//! every formula of both is encoded as a function of the bits of the second one's variables, and
//! conjoined with the domains of the first. Diagrams are canonical, so the lists agree if the sets
//! of these functions do. It remains to show that the second one's own formulas keep its bits
//! within those domains.

#![expect(
    clippy::mutable_key_type,
    reason = "a function's hash does not read the counters of its kernel"
)]

use linewright::gr1::{BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, VarId};
use linewright::interchange::lower;
use linewright::symbolic::{Biodivine, Bit, BitSet, Encoding, Kernel, Limit, Limits, Order};
use std::collections::HashSet;

/// Representation of a specification's variables in what was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Unchanged.
    Same,
    /// Inputs before outputs, and numbers counted from 0.
    FromZero,
    /// Inputs before outputs, and numbers as bits, the lowest first, counted from 0.
    Bits,
}

/// Proves that `b` equals `a` with its variables in this layout. The error describes the
/// difference.
pub fn prove(a: &Specification, b: &Specification, layout: Layout) -> Result<(), String> {
    let carried = carried(a, b, layout)?;
    let limits = Limits {
        deadline: linewright::deadline::Deadline::NONE,
        memory_mib: Some(2048),
        ..Limits::default()
    };
    let encoding = Encoding::new(b);
    let kernel = Biodivine::new(&Order::natural(encoding.pairs()), &limits);
    let kernel = kernel.map_err(gave_up)?;
    let mut proof = Proof {
        now: kernel.constant(true),
        next: kernel.constant(true),
        a,
        layout,
        free: false,
        at_ease: false,
        carried: &carried,
        kernel,
        encoding,
    };
    proof.find_domains().map_err(gave_up)?;
    proof.free = proof.asks_nothing(&a.assumptions, true).map_err(gave_up)?;
    proof.at_ease = proof.asks_nothing(&a.guarantees, false).map_err(gave_up)?;
    // Invariants apply to the first step and to every next one.
    let (a, b) = (lower::without_invariants(a), lower::without_invariants(b));
    for (who, owner, a, b) in [
        (
            "assumptions",
            Owner::Environment,
            &a.assumptions,
            &b.assumptions,
        ),
        ("guarantees", Owner::System, &a.guarantees, &b.guarantees),
    ] {
        let found = proof.side(owner, a, b);
        found
            .map_err(gave_up)?
            .map_err(|what| format!("{what} among the {who}"))?;
    }
    Ok(())
}

fn gave_up(limit: Limit) -> String {
    format!("gave up: {limit}")
}

/// Each variable of `a` as an expression over the current values of `b`.
fn carried(a: &Specification, b: &Specification, layout: Layout) -> Result<Vec<Expr>, String> {
    if a.timing != b.timing {
        return Err("another timing".to_owned());
    }
    let mut carried = vec![Expr::Const(0); a.variables.len()];
    let mut order: Vec<usize> = (0..a.variables.len()).collect();
    if layout != Layout::Same {
        order.sort_by_key(|i| a.variables[*i].owner == Owner::System);
    }
    let mut next = 0;
    for index in order {
        let variable = &a.variables[index];
        let (low, size) = (variable.domain.low(), variable.domain.size());
        let mut take = |wanted: &dyn Fn(&Domain) -> bool| {
            let id = VarId(next as u32);
            next += 1;
            let found = b.variables.get(id.index());
            let fits = found.is_some_and(|v| v.owner == variable.owner && wanted(&v.domain));
            let wrong = || format!("`{}` became {found:?}", variable.name);
            fits.then(|| Expr::now(id)).ok_or_else(wrong)
        };
        carried[index] = match layout {
            Layout::Same => take(&|d| (d.low(), d.size()) == (low, size))?,
            _ if variable.domain == Domain::Bool => take(&|d| *d == Domain::Bool)?,
            Layout::FromZero => {
                let from_zero = take(&|d| (d.low(), d.size()) == (0, size))?;
                Expr::binary(BinaryOp::Add, from_zero, Expr::Const(low))
            }
            Layout::Bits => {
                let mut value = Expr::Const(low);
                for k in 0..u64::BITS - (size - 1).leading_zeros() {
                    let bit = Box::new(take(&|d| *d == Domain::Bool)?);
                    let bit = Expr::If(bit, Expr::Const(1 << k).into(), Expr::Const(0).into());
                    value = Expr::binary(BinaryOp::Add, value, bit);
                }
                value
            }
        };
    }
    // A format that needs at least one output gets one that nothing mentions.
    let more = &b.variables[next..];
    if more.iter().any(|v| v.name != "unused") {
        return Err(format!("there is more: {more:?}"));
    }
    Ok(carried)
}

type Function = <Biodivine as Kernel>::Function;

/// A formula as a function, and its display form.
type Item = (Function, String);

/// Formulas of one side.
struct Lists {
    /// Initial conditions and transitions as written.
    written: [Vec<Function>; 2],
    initial: Vec<Item>,
    safety: Vec<Item>,
    justice: Vec<Item>,
}

/// Initial conditions and transitions that can be continued for ever.
struct GoingOn {
    initial: Function,
    step: Function,
    /// What holds now in every such step.
    always: Function,
}

struct Proof<'s> {
    a: &'s Specification,
    layout: Layout,
    /// Whether every move of the environment is legal.
    free: bool,
    /// Whether every move of the machine is legal.
    at_ease: bool,
    carried: &'s [Expr],
    /// All variables of `a` have values now, and next.
    now: Function,
    next: Function,
    kernel: Biodivine,
    encoding: Encoding,
}

impl Proof<'_> {
    fn find_domains(&mut self) -> Result<(), Limit> {
        for index in 0..self.a.variables.len() {
            let id = VarId(index as u32);
            self.now = self.kernel.and(&self.now, &self.domain(id, Time::Now)?)?;
            self.next = self.kernel.and(&self.next, &self.domain(id, Time::Next)?)?;
        }
        Ok(())
    }

    fn side(&self, owner: Owner, a: &Side, b: &Side) -> Result<Result<(), String>, Limit> {
        let both = self.kernel.and(&self.now, &self.next)?;
        let of_a = |v: VarId, time| at(&self.carried[v.index()], time);
        let a = self.lists(owner, a, &of_a)?;
        let b = self.lists(owner, b, &Expr::Var)?;
        let (all_of_a, all_of_b) = (a, b);
        let (a, b) = (&all_of_a, &all_of_b);
        // If the other side has nothing to lose meanwhile, it does not matter in which step this
        // one loses.
        let some_time = match owner {
            Owner::Environment => self.at_ease,
            Owner::System => self.free,
        };
        for (what, a, b, domains, bound) in [
            (
                "initial conditions",
                &a.initial,
                &b.initial,
                &self.now,
                Some((Time::Now, &b.written[0])),
            ),
            (
                "transitions",
                &a.safety,
                &b.safety,
                &both,
                Some((Time::Next, &b.written[1])),
            ),
            ("justice", &a.justice, &b.justice, &both, None),
        ] {
            let (left, right) = (self.within(a, domains)?, self.within(b, domains)?);
            let same = left == right
                || bound.is_some() && {
                    // Conjunctions were pulled apart.
                    let all = |set: &HashSet<Function>| self.kernel.all(set.iter());
                    let (left, right) = (all(&left)?, all(&right)?);
                    self.kernel.and(&left, domains)? == self.kernel.and(&right, domains)?
                }
                || bound.is_some() && some_time && self.same_in_the_end(&all_of_a, &all_of_b)?;
            if !same {
                let only = |list: &[Item], others: &HashSet<Function>| -> Result<String, Limit> {
                    let mut found = Vec::new();
                    for (f, shown) in list {
                        let f = self.kernel.and(f, domains)?;
                        if f != *domains && !others.contains(&f) {
                            found.push(shown.as_str());
                        }
                    }
                    Ok(found.join("\n  "))
                };
                let (a, b) = (only(a, &right)?, only(b, &left)?);
                return Ok(Err(format!(
                    "{what} are different:\n  {a}\nbecame\n  {b}\n"
                )));
            }
            if what == "initial conditions" && self.impossible(&left)? {
                // The side has lost before the first step.
                return Ok(Ok(()));
            }
            let (Some((time, written)), Layout::Bits) = (bound, self.layout) else {
                continue;
            };
            // Bits are kept within domains by formulas that say nothing else.
            let mut keeping = self.kernel.constant(true);
            for f in written {
                if self.kernel.is_true(&self.kernel.implies(domains, f)?) {
                    keeping = self.kernel.and(&keeping, f)?;
                }
            }
            for (index, variable) in self.a.variables.iter().enumerate() {
                let domain = self.domain(VarId(index as u32), time)?;
                let kept = self.kernel.implies(&keeping, &domain)?;
                if variable.owner == owner && !self.kernel.is_true(&kept) {
                    return Ok(Err(format!("`{}` can leave its domain", variable.name)));
                }
            }
        }
        Ok(Ok(()))
    }

    /// Whether no move of a side of `a` is restricted, or, with `later`, none but the first.
    fn asks_nothing(&self, side: &Side, later: bool) -> Result<bool, Limit> {
        let both = self.kernel.and(&self.now, &self.next)?;
        let of_a = |v: VarId, time| at(&self.carried[v.index()], time);
        let mut lists = vec![&side.invariants, &side.safety];
        lists.extend((!later).then_some(&side.initial));
        for list in lists {
            if !self.within(&self.items(list, &of_a)?, &both)?.is_empty() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether the initial conditions and transitions allow the same runs.
    fn same_in_the_end(&self, a: &Lists, b: &Lists) -> Result<bool, Limit> {
        let (a, b) = (self.going_on(a)?, self.going_on(b)?);
        if [&a, &b].iter().all(|s| self.kernel.is_false(&s.initial)) {
            return Ok(true);
        }
        // What holds in every step of the runs of both.
        let always = self.kernel.and(&a.always, &b.always)?;
        let always_next = self.kernel.prime(&always)?;
        for side in [&a, &b] {
            let first = self.kernel.implies(&side.initial, &always)?;
            let later = self.kernel.implies(&side.step, &always_next)?;
            if !self.kernel.is_true(&first) || !self.kernel.is_true(&later) {
                return Ok(false);
            }
        }
        let steps = |side: &GoingOn| self.kernel.and(&side.step, &always);
        Ok(a.initial == b.initial && steps(&a)? == steps(&b)?)
    }

    fn going_on(&self, lists: &Lists) -> Result<GoingOn, Limit> {
        let all = |items: &[Item]| self.kernel.all(items.iter().map(|(f, _)| f));
        let both = self.kernel.and(&self.now, &self.next)?;
        let initial = self.kernel.and(&all(&lists.initial)?, &self.now)?;
        let mut step = self.kernel.and(&all(&lists.safety)?, &both)?;
        loop {
            let always = self.kernel.exists(&step, &self.bits(Time::Next))?;
            let further = self.kernel.and(&step, &self.kernel.prime(&always)?)?;
            if further == step {
                return Ok(GoingOn {
                    initial: self.kernel.and(&initial, &always)?,
                    step,
                    always,
                });
            }
            step = further;
        }
    }

    fn bits(&self, time: Time) -> BitSet {
        let pairs = self.encoding.pairs();
        BitSet::new((0..pairs).map(|p| {
            let bit = Bit(2 * p as u16);
            match time {
                Time::Now => bit,
                Time::Next => bit.primed(),
            }
        }))
    }

    /// The formulas of a side in a form that does not depend on which of several equivalent ways
    /// was used.
    fn lists(
        &self,
        owner: Owner,
        side: &Side,
        carry: &dyn Fn(VarId, Time) -> Expr,
    ) -> Result<Lists, Limit> {
        let initial = self.items(&side.initial, carry)?;
        let safety = self.items(&side.safety, carry)?;
        let written = |items: &[Item]| items.iter().map(|(f, _)| f.clone()).collect();
        let mut lists = Lists {
            written: [written(&initial), written(&safety)],
            initial,
            safety: Vec::new(),
            justice: Vec::new(),
        };
        for (f, shown) in safety {
            match self.over(&f, Time::Now)? {
                // Restricting every current step, or the first and every next one, differs only if
                // the environment is stuck.
                Some(f) if self.free && owner == Owner::System => {
                    lists.safety.push((self.kernel.prime(&f)?, shown.clone()));
                    lists.initial.push((f, shown));
                }
                _ => lists.safety.push((f, shown)),
            }
        }
        for (f, shown) in self.items(&side.justice, carry)? {
            // Again and again in the next step means again and again.
            let of_next = self.over(&f, Time::Next)?;
            let f = of_next.map_or(Ok(f), |f| self.kernel.unprime(&f))?;
            lists.justice.push((f, shown));
        }
        Ok(lists)
    }

    /// The function over values of this time alone, if it depends on no others where all variables
    /// have values.
    fn over(&self, f: &Function, time: Time) -> Result<Option<Function>, Limit> {
        let (here, there) = match time {
            Time::Now => (&self.now, &self.next),
            Time::Next => (&self.next, &self.now),
        };
        let bits = self.bits(match time {
            Time::Now => Time::Next,
            Time::Next => Time::Now,
        });
        let some = self.kernel.and_exists(f, there, &bits)?;
        let all = self.kernel.implies_forall(there, f, &bits)?;
        let same = self.kernel.and(&some, here)? == self.kernel.and(&all, here)?;
        Ok(same.then_some(some))
    }

    fn items(
        &self,
        formulas: &[Formula],
        carry: &dyn Fn(VarId, Time) -> Expr,
    ) -> Result<Vec<Item>, Limit> {
        let items = formulas.iter().map(|f| {
            let expr = f.expr.substitute(&mut |v, time| carry(v, time));
            let function = self.encoding.formula(&self.kernel, &expr)?;
            Ok((function, format!("{:?}", f.expr)))
        });
        items.collect()
    }

    /// The functions where all variables have values, without what holds everywhere there.
    fn within(&self, items: &[Item], domains: &Function) -> Result<HashSet<Function>, Limit> {
        let mut found = HashSet::new();
        for (f, _) in items {
            let f = self.kernel.and(f, domains)?;
            if f != *domains {
                found.insert(f);
            }
        }
        Ok(found)
    }

    fn impossible(&self, functions: &HashSet<Function>) -> Result<bool, Limit> {
        let all = self.kernel.all(functions)?;
        Ok(self.kernel.is_false(&all))
    }

    /// The variable of `a` has a value.
    fn domain(&self, v: VarId, time: Time) -> Result<Function, Limit> {
        let domain = &self.a.variables[v.index()].domain;
        let value = at(&self.carried[v.index()], time);
        let mut kept = self.encoding.formula(
            &self.kernel,
            &Expr::binary(BinaryOp::Le, value.clone(), Expr::Const(domain.high())),
        )?;
        // An encoded formula is undefined on codes that are no value.
        let mut own = Vec::new();
        value.for_each_var(&mut |w, _| own.push(w));
        for w in own {
            let values = self.encoding.in_domain(&self.kernel, w, time)?;
            kept = self.kernel.and(&kept, &values)?;
        }
        Ok(kept)
    }
}

/// An expression over current values, moved to another time.
fn at(expr: &Expr, time: Time) -> Expr {
    expr.substitute(&mut |v, _| Expr::Var(v, time))
}
