//! Random specifications, small enough for sets of valuations to be 128-bit words, and mutations of
//! machines.

use linewright::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Side, Specification, Time, Timing, UnaryOp, VarId,
    Variable,
};
use linewright::mealy::Machine;
use linewright::source::Span;

/// Its own generator (xorshift), so that a seed always means the same.
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

    /// True with this probability in percent.
    pub fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// What an expression may mention.
struct Scope {
    now: Vec<VarId>,
    next: Vec<VarId>,
}

/// Frequency of each formula of each kind in percent: one entry per possible formula.
struct Chances {
    assumed_initial: &'static [u64],
    assumed_invariants: &'static [u64],
    assumed_safety: &'static [u64],
    assumed_justice: &'static [u64],
    assumed_step_justice: &'static [u64],
    initial: &'static [u64],
    invariants: &'static [u64],
    safety: &'static [u64],
    justice: &'static [u64],
    step_justice: &'static [u64],
}

/// A random specification: every kind of formula, each of them often absent.
pub fn specification(r: &mut Random) -> Specification {
    let timing = timing(r);
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
        // At least one per side.
        let owner = match i {
            0 => Owner::Environment,
            1 => Owner::System,
            _ if r.chance(50) => Owner::Environment,
            _ => Owner::System,
        };
        let internal = r.chance(10) && owner == Owner::System;
        variables.push(variable_of(i, owner, internal, domain));
    }
    let chances = Chances {
        assumed_initial: &[30],
        assumed_invariants: &[15],
        assumed_safety: &[40, 40],
        assumed_justice: &[45, 45],
        assumed_step_justice: &[20],
        initial: &[40],
        invariants: &[40],
        safety: &[55, 55, 55],
        justice: &[60, 60],
        step_justice: &[25],
    };
    with_formulas(r, timing, variables, &chances)
}

/// A specification with an integer and with at least two justice formulas on either side, so that
/// the three fixpoints are really nested. Safety is rarer, since it would decide too often.
pub fn specification_with_goals(r: &mut Random) -> Specification {
    let timing = timing(r);
    let ranges = [(-1, 1), (2, 4), (0, 3), (-2, 2)];
    let mut variables = Vec::new();
    let integer = r.below(3);
    for i in 0..2 + r.below(3) {
        let owner = match i {
            0 => Owner::Environment,
            1 => Owner::System,
            _ if r.chance(50) => Owner::Environment,
            _ => Owner::System,
        };
        // An input, an output, or both.
        let domain = if i < 2 && (i == integer || integer == 2) {
            let (low, high) = ranges[r.below(ranges.len() as u64) as usize];
            Domain::Range { low, high }
        } else {
            Domain::Bool
        };
        let internal = r.chance(10) && owner == Owner::System;
        variables.push(variable_of(i, owner, internal, domain));
    }
    let chances = Chances {
        assumed_initial: &[25],
        assumed_invariants: &[10],
        assumed_safety: &[50, 25],
        assumed_justice: &[100, 100, 30],
        assumed_step_justice: &[20],
        initial: &[25],
        invariants: &[15],
        safety: &[60, 40],
        justice: &[100, 100, 30],
        step_justice: &[20],
    };
    with_formulas(r, timing, variables, &chances)
}

fn timing(r: &mut Random) -> Timing {
    if r.chance(35) {
        Timing::Moore
    } else {
        Timing::Mealy
    }
}

fn variable_of(i: u64, owner: Owner, internal: bool, domain: Domain) -> Variable {
    Variable {
        name: format!("v{i}"),
        owner,
        internal,
        unit: String::new(),
        domain,
        span: Span::default(),
    }
}

fn with_formulas(
    r: &mut Random,
    timing: Timing,
    variables: Vec<Variable>,
    chances: &Chances,
) -> Specification {
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

    let mut list = |percents: &[u64], scope: &Scope, name: &str| -> Vec<Formula> {
        let mut formulas = Vec::new();
        for (i, percent) in percents.iter().enumerate() {
            if r.chance(*percent) {
                let depth = 1 + r.below(3) as u32;
                let mut expr = boolean(r, &variables, scope, depth);
                if name.ends_with("safety") || name.ends_with("invariant") {
                    // Weakened, since almost nothing would be realizable otherwise.
                    expr = boolean(r, &variables, scope, 1).or(expr);
                }
                formulas.push(Formula {
                    defines: false,
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
    let start = scope(&inputs, &[]);
    let now = scope(&all, &[]);
    let step = scope(&all, &all);
    let c = chances;
    let assumptions = Side {
        initial: list(c.assumed_initial, &start, "assumed initial"),
        invariants: list(c.assumed_invariants, &start, "assumed invariant"),
        safety: list(c.assumed_safety, &scope(&all, &inputs), "assumed safety"),
        justice: [
            list(c.assumed_justice, &now, "assumed justice"),
            list(c.assumed_step_justice, &step, "assumed step justice"),
        ]
        .concat(),
    };
    let guarantees = Side {
        initial: list(c.initial, &now, "initial"),
        invariants: list(c.invariants, &now, "invariant"),
        safety: list(c.safety, &step, "safety"),
        justice: [
            list(c.justice, &now, "justice"),
            list(c.step_justice, &step, "step justice"),
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
