//! Collects the vocabulary of repairs: conditions from the user's own formulas, and their
//! negations.
//!
//! Only conditions about a single step are used. For each input with a small domain, conditions of
//! the form "the input has this value" are added for the values that occur in the play.

use crate::game::attack::Play;
use linewright_core::gr1::text::is_boolean;
use linewright_core::gr1::{
    BinaryOp, Domain, Expr, Formula, Owner, Specification, Time, UnaryOp, VarId,
};

/// Maximum number of conditions, not counting negations.
const MAX_WORDS: usize = 24;

/// Maximum size of domains for which single values are considered.
const SMALL_DOMAIN: u64 = 16;

/// A condition about the current step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Word {
    /// The condition.
    pub expr: Expr,
    /// Whether the condition mentions only inputs.
    pub inputs: bool,
}

impl Word {
    /// Returns the same condition about the next step.
    pub fn next(&self) -> Expr {
        self.expr.substitute(&mut |v, _| Expr::next(v))
    }
}

fn variables(expr: &Expr) -> Vec<VarId> {
    let mut found = Vec::new();
    expr.for_each_var(&mut |v, _| found.push(v));
    found.sort_unstable();
    found.dedup();
    found
}

/// Returns conditions from these formulas and from the play, each followed by its negation.
pub fn words<'f>(
    specification: &Specification,
    formulas: impl Iterator<Item = &'f Formula>,
    play: &Play,
) -> Vec<Word> {
    let mut atoms: Vec<Expr> = Vec::new();
    let mut mentioned: Vec<VarId> = Vec::new();
    for formula in formulas {
        collect(specification, &formula.expr, &mut atoms);
        formula.expr.for_each_var(&mut |v, _| {
            if !mentioned.contains(&v) {
                mentioned.push(v);
            }
        });
    }
    for v in mentioned {
        let variable = specification.variable(v);
        let few = variable.domain != Domain::Bool && variable.domain.size() <= SMALL_DOMAIN;
        if few && variable.owner == Owner::Environment {
            for step in &play.steps {
                let is = Expr::now(v).equals(Expr::Const(step[v.index()]));
                if !atoms.contains(&is) {
                    atoms.push(is);
                }
            }
        }
    }
    // Removes conditions on internal variables, such as the states of monitors, because they are
    // not the user's own.
    atoms.retain(|atom| {
        variables(atom)
            .iter()
            .all(|v| !specification.variable(*v).internal)
    });
    atoms.truncate(MAX_WORDS);
    let mut words = Vec::new();
    for atom in atoms {
        let vars = variables(&atom);
        let inputs = vars
            .iter()
            .all(|v| specification.variable(*v).owner == Owner::Environment);
        for expr in [atom.clone(), negation(atom)] {
            words.push(Word { expr, inputs });
        }
    }
    words
}

/// Negates a formula, without producing a double negation.
pub fn negation(expr: Expr) -> Expr {
    match expr {
        Expr::Unary(UnaryOp::Not, a) => *a,
        Expr::Binary(BinaryOp::Eq, a, b) => Expr::Binary(BinaryOp::Ne, a, b),
        Expr::Binary(BinaryOp::Ne, a, b) => Expr::Binary(BinaryOp::Eq, a, b),
        Expr::Binary(BinaryOp::Lt, a, b) => Expr::Binary(BinaryOp::Ge, a, b),
        Expr::Binary(BinaryOp::Ge, a, b) => Expr::Binary(BinaryOp::Lt, a, b),
        Expr::Binary(BinaryOp::Gt, a, b) => Expr::Binary(BinaryOp::Le, a, b),
        Expr::Binary(BinaryOp::Le, a, b) => Expr::Binary(BinaryOp::Gt, a, b),
        other => other.not(),
    }
}

/// Adds to `atoms` the conditions that `expr` combines with connectives. Conditions about the next
/// step are rewritten to the current step.
fn collect(specification: &Specification, expr: &Expr, atoms: &mut Vec<Expr>) {
    use BinaryOp as B;
    let truth = |e: &Expr| is_boolean(specification, e);
    // A condition on inputs alone is also used as a whole.
    if let Expr::Binary(B::And | B::Or, ..) = expr {
        let (mut inputs, mut times) = (true, Vec::new());
        expr.for_each_var(&mut |v, t| {
            inputs &= specification.variable(v).owner == Owner::Environment;
            times.push(t);
        });
        let whole = expr.substitute(&mut |v, _| Expr::Var(v, Time::Now));
        if inputs && times.windows(2).all(|w| w[0] == w[1]) && !atoms.contains(&whole) {
            atoms.push(whole);
        }
    }
    match expr {
        Expr::Unary(UnaryOp::Not, a) => collect(specification, a, atoms),
        Expr::Binary(B::And | B::Or | B::Implies, a, b) => {
            collect(specification, a, atoms);
            collect(specification, b, atoms);
        }
        Expr::Binary(B::Eq | B::Ne, a, b) if truth(a) && truth(b) => {
            collect(specification, a, atoms);
            collect(specification, b, atoms);
        }
        Expr::If(c, a, b) => {
            collect(specification, c, atoms);
            if truth(a) && truth(b) {
                collect(specification, a, atoms);
                collect(specification, b, atoms);
            }
        }
        Expr::Const(_) => {}
        atom if truth(atom) => {
            let mut times = Vec::new();
            atom.for_each_var(&mut |_, t| times.push(t));
            let one_step = times.windows(2).all(|w| w[0] == w[1]);
            // A condition and its negation count as one word.
            let atom = atom.substitute(&mut |v, _| Expr::Var(v, Time::Now));
            let known = atoms.contains(&atom) || atoms.contains(&negation(atom.clone()));
            if one_step && !times.is_empty() && !known {
                atoms.push(atom);
            }
        }
        _ => {}
    }
}
