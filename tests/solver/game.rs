//! The naive solver: all valuations, all pairs of valuations, sets as bits of a word, the fixpoint
//! as in the textbook.

use linewright::game::GuaranteeRef;
use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, FormulaKind, Owner, Specification, Time, Timing, UnaryOp,
};

/// A set of valuations.
pub type Set = u128;

/// One formula over all pairs of valuations: for each current one the set of next ones for which it
/// holds.
pub type Relation = Vec<Set>;

/// The formulas of a side by kind.
pub struct Relations {
    pub initial: Vec<Relation>,
    pub invariants: Vec<Relation>,
    pub safety: Vec<Relation>,
    pub justice: Vec<Relation>,
}

/// All data on a small specification.
pub struct Board<'a> {
    pub specification: &'a Specification,
    pub valuations: Vec<Vec<i64>>,
    /// Number of each valuation's inputs, and of its outputs.
    pub parts: Vec<(usize, usize)>,
    inputs: usize,
    outputs: usize,
    pub assumed: Relations,
    pub guaranteed: Relations,
}

/// The guarantees that count.
pub enum Subset<'a> {
    All,
    Only(&'a [GuaranteeRef]),
}

/// What the real `examine_environment` is compared with.
pub struct Environment {
    pub cannot_start: bool,
    /// Sets of valuations, each with the larger one that it is part of.
    pub stuck_at_start: [Set; 2],
    pub dead_end: [Set; 2],
    pub forced: [Set; 2],
    pub forced_recklessly: [Set; 2],
    /// From how many of the valuations that can occur, and how many can; then for a machine without
    /// guarantees.
    pub forced_states: [u32; 2],
    pub forced_recklessly_states: [u32; 2],
    /// No play keeps all assumptions.
    pub unsatisfiable: bool,
}

/// The combined rules of a play.
pub struct Rules {
    pub env_start: Set,
    pub sys_start: Set,
    /// The next valuations with inputs that the environment may give.
    pub env_step: Relation,
    pub sys_step: Relation,
    pub assumptions: Vec<Relation>,
    pub goals: Vec<Relation>,
}

impl<'a> Board<'a> {
    pub fn new(specification: &'a Specification) -> Self {
        let mut valuations = vec![Vec::new()];
        for v in &specification.variables {
            let (low, high) = match &v.domain {
                Domain::Bool => (0, 1),
                Domain::Range { low, high } => (*low, *high),
                Domain::Enum { labels, .. } => (0, labels.len() as i64 - 1),
            };
            let mut longer = Vec::new();
            for valuation in &valuations {
                for value in low..=high {
                    let mut next: Vec<i64> = valuation.clone();
                    next.push(value);
                    longer.push(next);
                }
            }
            valuations = longer;
        }
        assert!(valuations.len() <= 128);
        let number = |owner: Owner| {
            let mut seen: Vec<Vec<i64>> = Vec::new();
            let numbers: Vec<usize> = valuations
                .iter()
                .map(|valuation| {
                    let pairs = specification.variables.iter().zip(valuation);
                    let part: Vec<i64> = pairs
                        .filter(|(v, _)| v.owner == owner)
                        .map(|(_, x)| *x)
                        .collect();
                    seen.iter().position(|s| *s == part).unwrap_or_else(|| {
                        seen.push(part);
                        seen.len() - 1
                    })
                })
                .collect();
            (numbers, seen.len())
        };
        let (ins, inputs) = number(Owner::Environment);
        let (outs, outputs) = number(Owner::System);
        let relation = |f: &Formula| -> Relation {
            let row = |now: &Vec<i64>| {
                let next = valuations.iter().enumerate();
                next.filter(|(_, next)| value(&f.expr, now, next) != 0)
                    .fold(0, |set, (i, _)| set | 1 << i)
            };
            valuations.iter().map(row).collect()
        };
        let relations = |side: &linewright::gr1::Side| Relations {
            initial: side.initial.iter().map(relation).collect(),
            invariants: side.invariants.iter().map(relation).collect(),
            safety: side.safety.iter().map(relation).collect(),
            justice: side.justice.iter().map(relation).collect(),
        };
        Self {
            assumed: relations(&specification.assumptions),
            guaranteed: relations(&specification.guarantees),
            parts: ins.into_iter().zip(outs).collect(),
            inputs,
            outputs,
            valuations,
            specification,
        }
    }

    pub fn all(&self) -> Set {
        if self.valuations.len() == 128 {
            Set::MAX
        } else {
            (1 << self.valuations.len()) - 1
        }
    }

    fn with_inputs(&self, x: usize) -> Set {
        let parts = self.parts.iter().enumerate();
        parts
            .filter(|(_, p)| p.0 == x)
            .fold(0, |s, (i, _)| s | 1 << i)
    }

    fn with_outputs(&self, y: usize) -> Set {
        let parts = self.parts.iter().enumerate();
        parts
            .filter(|(_, p)| p.1 == y)
            .fold(0, |s, (i, _)| s | 1 << i)
    }

    /// The valuations for which formulas without next values hold.
    pub fn satisfying(&self, relations: &[Relation]) -> Set {
        let all = self.all();
        let here = |r: &Relation| {
            let rows = r.iter().enumerate();
            rows.filter(|(_, row)| **row == all)
                .fold(0, |s, (i, _)| s | 1 << i)
        };
        relations.iter().map(here).fold(all, |a: Set, b: Set| a & b)
    }

    pub fn rules(&self, subset: &Subset<'_>) -> Rules {
        let chosen = |kind: FormulaKind, list: &[Relation]| -> Vec<Relation> {
            let list = list.iter().enumerate();
            list.filter(|(index, _)| match subset {
                Subset::All => true,
                Subset::Only(refs) => refs.contains(&GuaranteeRef {
                    kind,
                    index: *index,
                }),
            })
            .map(|(_, r)| r.clone())
            .collect()
        };
        let invariants = chosen(FormulaKind::Invariant, &self.guaranteed.invariants);
        let initial = chosen(FormulaKind::Initial, &self.guaranteed.initial);
        let safety = chosen(FormulaKind::Safety, &self.guaranteed.safety);
        let goals = chosen(FormulaKind::Justice, &self.guaranteed.justice);
        let env_always = self.satisfying(&self.assumed.invariants);
        let sys_always = self.satisfying(&invariants);
        let conjunction = |list: &[Relation], always: Set| -> Relation {
            let rows = 0..self.valuations.len();
            rows.map(|i| list.iter().fold(always, |set, r| set & r[i]))
                .collect()
        };
        Rules {
            env_start: env_always & self.satisfying(&self.assumed.initial),
            sys_start: sys_always & self.satisfying(&initial),
            env_step: conjunction(&self.assumed.safety, env_always),
            sys_step: conjunction(&safety, sys_always),
            assumptions: self.or_true(self.assumed.justice.clone()),
            goals: self.or_true(goals),
        }
    }

    fn or_true(&self, list: Vec<Relation>) -> Vec<Relation> {
        if list.is_empty() {
            vec![vec![self.all(); self.valuations.len()]]
        } else {
            list
        }
    }

    /// Whether the machine can make every next step lie in `target` of the current valuation.
    fn controls(&self, groups: &Groups, rules: &Rules, state: usize, target: Set) -> bool {
        let good = target & rules.sys_step[state];
        let legal: Vec<Set> = groups
            .inputs
            .iter()
            .copied()
            .filter(|x| x & rules.env_step[state] != 0)
            .collect();
        match self.specification.timing {
            Timing::Mealy => legal.iter().all(|x| x & good != 0),
            Timing::Moore => groups
                .outputs
                .iter()
                .any(|y| legal.iter().all(|x| x & y & good != 0)),
        }
    }

    pub fn groups(&self) -> Groups {
        Groups {
            inputs: (0..self.inputs).map(|x| self.with_inputs(x)).collect(),
            outputs: (0..self.outputs).map(|y| self.with_outputs(y)).collect(),
        }
    }

    pub fn winning(&self, rules: &Rules) -> Set {
        let groups = self.groups();
        let count = self.valuations.len();
        let predecessor = |target: &dyn Fn(usize) -> Set| -> Set {
            let states = 0..count;
            states
                .filter(|s| self.controls(&groups, rules, *s, target(*s)))
                .fold(0, |set, s| set | 1 << s)
        };
        let mut z = self.all();
        loop {
            let mut all_goals = self.all();
            for goal in &rules.goals {
                let mut y = 0;
                loop {
                    let mut better = 0;
                    for assumption in &rules.assumptions {
                        let mut x = self.all();
                        loop {
                            let smaller =
                                predecessor(&|s| (goal[s] & z) | y | (!assumption[s] & x));
                            if smaller == x {
                                break;
                            }
                            x = smaller;
                        }
                        better |= x;
                    }
                    if better == y {
                        break;
                    }
                    y = better;
                }
                all_goals &= y;
            }
            if all_goals == z {
                return z;
            }
            z = all_goals;
        }
    }

    pub fn realizable(&self, subset: &Subset<'_>) -> bool {
        self.wins(&self.rules(subset))
    }

    /// Whether the machine wins under these rules.
    pub fn wins(&self, rules: &Rules) -> bool {
        let good = self.winning(rules) & rules.sys_start;
        let groups = self.groups();
        let starts = |x: &&Set| **x & rules.env_start != 0;
        match self.specification.timing {
            Timing::Mealy => groups.inputs.iter().filter(starts).all(|x| x & good != 0),
            Timing::Moore => groups.outputs.iter().any(|y| {
                groups
                    .inputs
                    .iter()
                    .filter(starts)
                    .all(|x| x & y & good != 0)
            }),
        }
    }

    /// The valuations that occur when both sides keep their safety; a Moore machine's answers are
    /// correct for all legal inputs.
    pub fn occurring(&self, rules: &Rules, start: Set) -> Set {
        let groups = self.groups();
        let mut reachable = start;
        loop {
            let mut more = reachable;
            for s in (0..self.valuations.len()).filter(|s| reachable >> s & 1 == 1) {
                let legal = rules.env_step[s];
                let mut good = rules.sys_step[s];
                if self.specification.timing == Timing::Moore {
                    // Only outputs that are correct for all legal inputs.
                    let x: Vec<Set> = groups
                        .inputs
                        .iter()
                        .copied()
                        .filter(|x| x & legal != 0)
                        .collect();
                    let y = groups.outputs.iter();
                    let blind: Set = y
                        .filter(|y| x.iter().all(|x| x & *y & good != 0))
                        .fold(0, |a, b| a | b);
                    good &= blind;
                }
                more |= legal & good;
            }
            if more == reachable {
                return reachable;
            }
            reachable = more;
        }
    }

    /// Whether these values ensure that a valuation of the second set belongs to the first, some
    /// valuation has them, and none of them can be left out. Without any, whether the first set is
    /// empty.
    pub fn is_prime_implicant(
        &self,
        situation: Option<&Vec<Option<i64>>>,
        [set, all]: [Set; 2],
    ) -> bool {
        let Some(situation) = situation else {
            return set == 0;
        };
        let having = |situation: &[Option<i64>]| {
            let fits = |valuation: &[i64]| {
                let mut values = valuation.iter().zip(situation);
                values.all(|(value, wanted)| wanted.is_none_or(|wanted| *value == wanted))
            };
            let fitting = (0..self.valuations.len()).filter(|s| fits(&self.valuations[*s]));
            fitting.fold(0, |set: Set, s| set | 1 << s) & all
        };
        let mut kept = (0..situation.len()).filter(|v| situation[*v].is_some());
        let shown = having(situation);
        shown != 0
            && shown & !set == 0
            && kept.all(|known| {
                let mut fewer = situation.clone();
                fewer[known] = None;
                having(&fewer) & !set != 0
            })
    }

    pub fn environment(&self) -> Environment {
        let mut rules = self.rules(&Subset::All);
        let start = rules.env_start & rules.sys_start;
        let reachable = self.occurring(&rules, start);
        let stuck = (0..self.valuations.len())
            .filter(|s| rules.env_step[*s] == 0)
            .fold(0, |set: Set, s| set | 1 << s);
        rules.goals = vec![vec![0; self.valuations.len()]];
        let started = rules.env_start != 0;
        let forced = self.winning(&rules) & reachable;
        let mut reckless = self.rules(&Subset::Only(&[]));
        let first = reckless.env_start & reckless.sys_start;
        let anywhere = self.occurring(&reckless, first);
        // Both sides as one: a set of valuations from which all assumptions are met again and
        // again.
        let lasting = self.lasting(&reckless.env_step, &reckless.assumptions, self.all());
        reckless.goals = vec![vec![0; self.valuations.len()]];
        let recklessly = self.winning(&reckless) & anywhere;
        let count = |set: Set| if started { set.count_ones() } else { 0 };
        let within = |set: Set, all: Set| if started { [set & all, all] } else { [0, 0] };
        Environment {
            forced_states: [count(forced), count(reachable)],
            forced_recklessly_states: [count(recklessly), count(anywhere)],
            unsatisfiable: started && lasting & first == 0,
            cannot_start: !started,
            stuck_at_start: within(stuck, start),
            dead_end: within(stuck, reachable),
            forced: within(forced, reachable),
            forced_recklessly: within(recklessly, anywhere),
        }
    }

    /// The valuations of `within` from which some path of these steps stays there for ever and
    /// meets all of `justice` again and again.
    pub fn lasting(&self, steps: &Relation, justice: &[Relation], within: Set) -> Set {
        let count = self.valuations.len();
        let mut z = within;
        loop {
            let mut smaller = z;
            for goal in justice {
                let mut y = 0;
                loop {
                    let larger = (0..count)
                        .filter(|s| z >> s & 1 == 1 && steps[*s] & ((goal[*s] & z) | y) != 0)
                        .fold(0, |set: Set, s| set | 1 << s);
                    if larger == y {
                        break;
                    }
                    y = larger;
                }
                smaller &= y;
            }
            if smaller == z {
                return z;
            }
            z = smaller;
        }
    }
}

/// Valuations with the same inputs, and with the same outputs.
pub struct Groups {
    pub inputs: Vec<Set>,
    pub outputs: Vec<Set>,
}

/// An independent evaluator.
pub fn value(expr: &Expr, now: &[i64], next: &[i64]) -> i64 {
    let of = |e: &Expr| value(e, now, next);
    match expr {
        Expr::Const(c) => *c,
        Expr::Var(v, Time::Now) => now[v.0 as usize],
        Expr::Var(v, Time::Next) => next[v.0 as usize],
        Expr::Unary(UnaryOp::Not, a) => 1 - of(a),
        Expr::Unary(UnaryOp::Neg, a) => 0 - of(a),
        Expr::Unary(UnaryOp::Abs, a) => of(a).max(-of(a)),
        Expr::If(c, a, b) => of(if of(c) == 1 { a } else { b }),
        Expr::Binary(op, a, b) => {
            let (a, b) = (of(a), of(b));
            let truth = i64::from;
            match op {
                BinaryOp::And => truth(a + b == 2),
                BinaryOp::Or => truth(a + b > 0),
                BinaryOp::Implies => truth(b >= a),
                BinaryOp::Eq => truth(a == b),
                BinaryOp::Ne => truth(a != b),
                BinaryOp::Lt => truth(a < b),
                BinaryOp::Le => truth(a <= b),
                BinaryOp::Gt => truth(a > b),
                BinaryOp::Ge => truth(a >= b),
                BinaryOp::Add => a + b,
                BinaryOp::Sub => a - b,
                BinaryOp::Mul => a * b,
                // Division toward minus infinity, by definition.
                BinaryOp::Div | BinaryOp::Mod => {
                    let rest = ((a % b) + b) % b;
                    if *op == BinaryOp::Mod {
                        rest
                    } else {
                        (a - rest) / b
                    }
                }
                BinaryOp::Min => std::cmp::min(a, b),
                BinaryOp::Max => std::cmp::max(a, b),
            }
        }
    }
}
