//! Random specifications, small enough for sets of valuations to be 128-bit words, and mutations of machines.

use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, UnaryOp, VarId,
    Variable,
};
use linewright::mealy::Machine;
use linewright::source::Span;

/// A generator of its own (xorshift), so that a seed means the same for ever.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        for _ in 0..8 {
            random.below(2);
        }
        random
    }

    /// A number from 0 to `n - 1`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % n
    }

    /// True in `percent` of all cases.
    pub fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// What an expression may mention.
struct Scope {
    now: Vec<VarId>,
    next: Vec<VarId>,
}

pub fn specification(r: &mut Random) -> Specification {
    let timing = if r.chance(35) {
        Timing::Moore
    } else {
        Timing::Mealy
    };
    let wide = r.chance(35);
    let count = if wide { 2 + r.below(3) } else { 2 + r.below(5) };
    let mut variables = Vec::new();
    for i in 0..count {
        let domain = match r.below(4) {
            0 if wide => Domain::Range { low: -1, high: 1 },
            1 if wide => Domain::Range { low: 2, high: 4 },
            2 if wide => Domain::Enum {
                name: None,
                labels: ["a", "b", "c"].map(str::to_owned).to_vec(),
            },
            _ => Domain::Bool,
        };
        // One of each side at least.
        let owner = match i {
            0 => Owner::Environment,
            1 => Owner::System,
            _ if r.chance(50) => Owner::Environment,
            _ => Owner::System,
        };
        variables.push(Variable {
            name: format!("v{i}"),
            owner,
            internal: r.chance(10) && owner == Owner::System,
            domain,
            span: Span::default(),
        });
    }
    let ids = |owner: Option<Owner>| -> Vec<VarId> {
        let all = variables.iter().enumerate();
        all.filter(|(_, v)| owner.is_none_or(|o| v.owner == o))
            .map(|(i, _)| VarId(i as u32))
            .collect()
    };
    let (inputs, all) = (ids(Some(Owner::Environment)), ids(None));
    let scope = |now: &[VarId], next: &[VarId]| Scope {
        now: now.to_vec(),
        next: next.to_vec(),
    };

    let mut list = |most: u64, percent: u64, scope: &Scope, name: &str| -> Vec<Formula> {
        let mut formulas = Vec::new();
        for i in 0..most {
            if r.chance(percent) {
                let depth = 1 + r.below(3) as u32;
                let mut expr = boolean(r, &variables, scope, depth);
                if name.ends_with("safety") || name.ends_with("invariant") {
                    // Weaker, or almost nothing would be realizable.
                    expr = boolean(r, &variables, scope, 1).or(expr);
                }
                formulas.push(Formula {
                    name: format!("{name} {i}"),
                    requirement: None,
                    text: format!("{expr:?}"),
                    expr,
                    span: Span::default(),
                });
            }
        }
        formulas
    };
    let step = scope(&all, &all);
    let now = scope(&all, &[]);
    let assumptions = Side {
        initial: list(1, 30, &scope(&inputs, &[]), "assumed initial"),
        invariants: list(1, 15, &scope(&inputs, &[]), "assumed invariant"),
        safety: list(2, 40, &scope(&all, &inputs), "assumed safety"),
        justice: [
            list(2, 45, &now, "assumed justice"),
            list(1, 20, &step, "assumed step justice"),
        ]
        .concat(),
    };
    let guarantees = Side {
        initial: list(1, 40, &now, "initial"),
        invariants: list(1, 40, &now, "invariant"),
        safety: list(3, 55, &step, "safety"),
        justice: [
            list(2, 60, &now, "justice"),
            list(1, 25, &step, "step justice"),
        ]
        .concat(),
    };
    Specification {
        name: "random".to_owned(),
        timing,
        variables,
        assumptions,
        guarantees,
    }
}

fn boolean(r: &mut Random, variables: &[Variable], scope: &Scope, depth: u32) -> Expr {
    let sub = |r: &mut Random| boolean(r, variables, scope, depth - 1);
    if depth > 0 && r.chance(75) {
        let op = [
            BinaryOp::And,
            BinaryOp::Or,
            BinaryOp::Or,
            BinaryOp::Implies,
            BinaryOp::Eq,
            BinaryOp::Ne,
        ];
        return match r.below(9) {
            0 => sub(r).not(),
            1 => {
                let (c, a, b) = (sub(r), sub(r), sub(r));
                Expr::If(Box::new(c), Box::new(a), Box::new(b))
            }
            _ => {
                let op = op[r.below(op.len() as u64) as usize];
                let a = sub(r);
                Expr::binary(op, a, sub(r))
            }
        };
    }
    let var = variable(r, scope);
    let Expr::Var(id, _) = var else {
        return var;
    };
    if variables[id.index()].domain == Domain::Bool {
        return if r.chance(40) { var.not() } else { var };
    }
    let op = [
        BinaryOp::Eq,
        BinaryOp::Ne,
        BinaryOp::Lt,
        BinaryOp::Le,
        BinaryOp::Gt,
        BinaryOp::Ge,
    ];
    let op = op[r.below(op.len() as u64) as usize];
    Expr::binary(op, integer(r, var, scope), number(r, scope))
}

fn integer(r: &mut Random, a: Expr, scope: &Scope) -> Expr {
    let op = [
        BinaryOp::Add,
        BinaryOp::Sub,
        BinaryOp::Mul,
        BinaryOp::Min,
        BinaryOp::Max,
    ];
    match r.below(12) {
        0 => Expr::Unary(UnaryOp::Neg, Box::new(a)),
        1 => Expr::Unary(UnaryOp::Abs, Box::new(a)),
        2 => Expr::binary(BinaryOp::Div, a, Expr::Const(2)),
        3 => Expr::binary(BinaryOp::Mod, a, Expr::Const(-2)),
        4 | 5 => {
            let op = op[r.below(op.len() as u64) as usize];
            Expr::binary(op, a, number(r, scope))
        }
        _ => a,
    }
}

fn number(r: &mut Random, scope: &Scope) -> Expr {
    if r.chance(60) {
        Expr::Const(r.below(6) as i64 - 1)
    } else {
        variable(r, scope)
    }
}

fn variable(r: &mut Random, scope: &Scope) -> Expr {
    let count = scope.now.len() + scope.next.len();
    let i = r.below(count as u64) as usize;
    match scope.now.get(i) {
        Some(id) => Expr::Var(*id, Time::Now),
        None => Expr::Var(scope.next[i - scope.now.len()], Time::Next),
    }
}

/// The machine with one transition redirected, one output changed, or one transition dropped.
pub fn mutate(r: &mut Random, machine: &Machine) -> Option<Machine> {
    let mut mutant = machine.clone();
    let lists = 1 + mutant.states.len() as u64;
    let states = mutant.states.len() as u64;
    let list = match r.below(lists) {
        0 => &mut mutant.initial,
        i => &mut mutant.states[i as usize - 1],
    };
    if list.is_empty() {
        return None;
    }
    let i = r.below(list.len() as u64) as usize;
    match r.below(5) {
        0 | 1 => {
            let to = r.below(states) as usize;
            if list[i].to == to {
                return None;
            }
            list[i].to = to;
        }
        2 | 3 => {
            let k = r.below(machine.outputs.len() as u64) as usize;
            let domain = &machine.outputs[k].domain;
            let value = domain.low() + r.below(domain.size()) as i64;
            if list[i].output[k] == value {
                return None;
            }
            if machine.timing == Timing::Moore && r.chance(80) {
                // All of them, so that it stays a Moore machine.
                for transition in list {
                    transition.output[k] = value;
                }
            } else {
                list[i].output[k] = value;
            }
        }
        _ => {
            list.remove(i);
        }
    }
    Some(mutant)
}
