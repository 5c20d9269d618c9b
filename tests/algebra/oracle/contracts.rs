//! Random small contracts, and contracts related to others.

use super::lassos::variable;
use crate::random::Random;
use linewright::algebra::system::{Component, System};
use linewright::gr1::{BinaryOp, Domain, Expr, Formula, Side, Time, Timing, VarId, Variable};
use linewright::source::Span;

/// Some variables, and the maximum length of their lassos.
pub fn variables(r: &mut Random) -> (Vec<Variable>, usize) {
    let range = Domain::Range { low: -1, high: 1 };
    match r.below(4) {
        0 => (named(&[Domain::Bool, Domain::Bool]), 4),
        1 => (named(&[range, Domain::Bool]), 3),
        2 => (named(&[Domain::Bool, range]), 3),
        _ => (named(&[Domain::Bool, Domain::Bool, Domain::Bool]), 3),
    }
}

/// Variables of these domains.
pub fn named(domains: &[Domain]) -> Vec<Variable> {
    let all = domains.iter().zip(["x", "y", "z", "u", "v"]);
    all.map(|(d, name)| variable(name, d.clone())).collect()
}

/// Values that formulas may mention.
pub struct Scope<'a> {
    pub variables: &'a [Variable],
    pub now: Vec<VarId>,
    pub next: Vec<VarId>,
}

impl<'a> Scope<'a> {
    /// All variables now, and next if wanted.
    pub fn all(variables: &'a [Variable], next: bool) -> Self {
        let ids: Vec<VarId> = (0..variables.len()).map(|i| VarId(i as u32)).collect();
        Self {
            variables,
            next: if next { ids.clone() } else { Vec::new() },
            now: ids,
        }
    }
}

fn atom(r: &mut Random, scope: &Scope<'_>) -> Expr {
    // Next values matter most if there are any.
    let next = !scope.next.is_empty() && (scope.now.is_empty() || r.chance(55));
    let (list, time) = if next {
        (&scope.next, Time::Next)
    } else {
        (&scope.now, Time::Now)
    };
    let v = list[r.below(list.len() as u64) as usize];
    let var = Expr::Var(v, time);
    let domain = &scope.variables[v.index()].domain;
    if *domain == Domain::Bool {
        return if r.chance(50) { var } else { var.not() };
    }
    let op = [BinaryOp::Eq, BinaryOp::Ne, BinaryOp::Le, BinaryOp::Gt][r.below(4) as usize];
    let value = domain.low() + r.below(domain.size()) as i64;
    Expr::binary(op, var, Expr::Const(value))
}

/// A truth value over the scope.
pub fn expression(r: &mut Random, scope: &Scope<'_>) -> Expr {
    let a = atom(r, scope);
    let b = atom(r, scope);
    match r.below(8) {
        0 | 1 => a,
        2 | 3 => a.or(b),
        4 => a.implies(b.or(atom(r, scope))),
        5 => Expr::binary(BinaryOp::Eq, a, b),
        6 => a.and(b).or(atom(r, scope)),
        _ => Expr::If(Box::new(a), Box::new(b), Box::new(atom(r, scope))),
    }
}

pub fn formula(name: String, expr: Expr) -> Formula {
    Formula {
        defines: false,
        name,
        requirement: None,
        text: format!("{expr:?}"),
        expr,
        span: Span::default(),
    }
}

/// Frequency of each formula in percent.
pub struct Chances {
    pub initial: u64,
    pub invariants: u64,
    pub safety: u64,
    pub justice: u64,
    pub step_justice: u64,
}

const ASSUMED: Chances = Chances {
    initial: 25,
    invariants: 15,
    safety: 35,
    justice: 35,
    step_justice: 20,
};
const GUARANTEED: Chances = Chances {
    initial: 35,
    invariants: 25,
    safety: 50,
    justice: 40,
    step_justice: 25,
};

fn side(r: &mut Random, variables: &[Variable], chances: &Chances) -> Side {
    let mut side = Side::default();
    let now = Scope::all(variables, false);
    let step = Scope::all(variables, true);
    for n in 0..2 {
        let rarer = |percent: u64| if n == 0 { percent } else { percent / 3 };
        let mut add = |list: &mut Vec<Formula>, percent, scope: &Scope<'_>, kind: &str| {
            if r.chance(rarer(percent)) {
                let expr = expression(r, scope);
                list.push(formula(format!("{kind} {n}"), expr));
            }
        };
        add(&mut side.initial, chances.initial, &now, "initial");
        add(&mut side.invariants, chances.invariants, &now, "invariant");
        add(&mut side.safety, chances.safety, &step, "safety");
        add(&mut side.justice, chances.justice, &now, "justice");
        add(
            &mut side.justice,
            chances.step_justice,
            &step,
            "step justice",
        );
    }
    side
}

/// A contract from its two halves.
pub fn part(name: &str, assumptions: Side, guarantees: Side) -> Component {
    Component {
        name: name.to_owned(),
        timing: Timing::Mealy,
        drives: Vec::new(),
        assumptions,
        guarantees,
        definitions: Side::default(),
        completions: Side::default(),
    }
}

/// A random small contract.
pub fn any(r: &mut Random, variables: &[Variable]) -> Component {
    let assumptions = side(r, variables, &ASSUMED);
    part("any", assumptions, side(r, variables, &GUARANTEED))
}

fn lists(side: &mut Side) -> [&mut Vec<Formula>; 4] {
    [
        &mut side.initial,
        &mut side.invariants,
        &mut side.safety,
        &mut side.justice,
    ]
}

/// A weaker demand: formulas are dropped or relaxed.
pub fn weaker(r: &mut Random, variables: &[Variable], of: &Side) -> Side {
    let mut side = of.clone();
    for (kind, list) in lists(&mut side).into_iter().enumerate() {
        list.retain(|_| !r.chance(30));
        for formula in list {
            if r.chance(40) {
                let out = expression(r, &Scope::all(variables, kind > 1));
                formula.expr = formula.expr.clone().or(out);
            }
        }
    }
    side
}

/// A stronger demand: formulas are added.
pub fn stronger(r: &mut Random, variables: &[Variable], of: &Side) -> Side {
    let mut side = of.clone();
    let more = self::side(r, variables, &ASSUMED);
    side.append(&more);
    side
}

/// A contract that refines another: it assumes less, and guarantees more.
pub fn refining(r: &mut Random, variables: &[Variable], of: &Component) -> Component {
    let assumptions = weaker(r, variables, &of.assumptions);
    part(
        "refining",
        assumptions,
        stronger(r, variables, &of.guarantees),
    )
}

/// A contract that another refines.
pub fn refined(r: &mut Random, variables: &[Variable], of: &Component) -> Component {
    let assumptions = stronger(r, variables, &of.assumptions);
    part("refined", assumptions, weaker(r, variables, &of.guarantees))
}

/// A contract that is likely to be related to another, in either direction.
pub fn akin(r: &mut Random, variables: &[Variable], of: &Component) -> Component {
    match r.below(5) {
        0 | 1 => refining(r, variables, of),
        2 | 3 => refined(r, variables, of),
        _ => any(r, variables),
    }
}

/// Contracts over the same variables.
pub fn system(variables: &[Variable], parts: Vec<Component>) -> System {
    System {
        variables: variables.to_vec(),
        components: parts,
    }
}
