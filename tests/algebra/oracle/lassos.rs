//! All lassos up to a bound, and contracts as sets of them: the definitions of the literature, on
//! plain values.
//!
//! Only data types of `crates/algebra/src` are used; formulas are evaluated by the oracle's own
//! evaluator.

use crate::game::value;
use linewright::algebra::system::{Component, System};
use linewright::game::Lasso;
use linewright::gr1::{Domain, Formula, Owner, Side, Variable};
use linewright::source::Span;

/// Membership of each lasso of a list in a set.
pub type Set = Vec<bool>;

/// A variable without a particular owner.
pub fn variable(name: &str, domain: Domain) -> Variable {
    Variable {
        name: name.to_owned(),
        owner: Owner::System,
        internal: false,
        domain,
        unit: String::new(),
        span: Span::default(),
    }
}

/// All valuations of some variables.
pub fn valuations(variables: &[Variable]) -> Vec<Vec<i64>> {
    variables.iter().fold(vec![Vec::new()], |shorter, v| {
        let values = v.domain.low()..=v.domain.high();
        let longer = |start: &Vec<i64>| {
            let with = |x| [&start[..], &[x]].concat();
            values.clone().map(with).collect::<Vec<_>>()
        };
        shorter.iter().flat_map(longer).collect()
    })
}

/// All lassos of at most `bound` positions.
pub fn all(variables: &[Variable], bound: usize) -> Vec<Lasso> {
    let valuations = valuations(variables);
    let mut found = Vec::new();
    let mut words: Vec<Vec<Vec<i64>>> = vec![Vec::new()];
    for length in 1..=bound {
        let longer = |w: &Vec<Vec<i64>>| {
            let with = |v: &Vec<i64>| [&w[..], std::slice::from_ref(v)].concat();
            valuations.iter().map(with).collect::<Vec<_>>()
        };
        words = words.iter().flat_map(longer).collect();
        for word in &words {
            for start in 0..length {
                found.push(Lasso {
                    prefix: word[..start].to_vec(),
                    cycle: word[start..].to_vec(),
                });
            }
        }
    }
    found
}

/// Whether a lasso keeps a side. It is treated as the infinite word that it represents: the step
/// after the last one is the first of the cycle.
pub fn keeps(side: &Side, run: &Lasso) -> bool {
    let word: Vec<&[i64]> = run
        .prefix
        .iter()
        .chain(&run.cycle)
        .map(Vec::as_slice)
        .collect();
    let back = run.prefix.len();
    let step = |f: &Formula, i: usize| {
        let next = if i + 1 == word.len() { back } else { i + 1 };
        value(&f.expr, word[i], word[next]) == 1
    };
    side.initial.iter().all(|f| step(f, 0))
        && side
            .invariants
            .iter()
            .chain(&side.safety)
            .all(|f| (0..word.len()).all(|i| step(f, i)))
        && side
            .justice
            .iter()
            .all(|f| (back..word.len()).any(|i| step(f, i)))
}

pub fn not(a: &Set) -> Set {
    a.iter().map(|x| !x).collect()
}

pub fn and(a: &Set, b: &Set) -> Set {
    a.iter().zip(b).map(|(x, y)| *x && *y).collect()
}

pub fn or(a: &Set, b: &Set) -> Set {
    a.iter().zip(b).map(|(x, y)| *x || *y).collect()
}

pub fn within(a: &Set, b: &Set) -> bool {
    a.iter().zip(b).all(|(x, y)| !x || *y)
}

/// A contract as two sets of lassos: the assumption, and the saturated guarantee Ĝ = ¬A ∨ G.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meaning {
    pub a: Set,
    pub g: Set,
}

impl Meaning {
    pub fn of(part: &Component, lassos: &[Lasso]) -> Self {
        let a: Set = lassos.iter().map(|l| keeps(&part.assumptions, l)).collect();
        let g = lassos.iter().map(|l| keeps(&part.guarantees, l)).collect();
        Self {
            g: or(&not(&a), &g),
            a,
        }
    }

    /// The meanings of all parts of a system.
    pub fn all(system: &System, lassos: &[Lasso]) -> Vec<Self> {
        let parts = system.components.iter();
        parts.map(|p| Self::of(p, lassos)).collect()
    }

    /// G = Ĝ₁ ∧ Ĝ₂, A = (A₁ ∧ A₂) ∨ ¬(Ĝ₁ ∧ Ĝ₂).
    pub fn compose(&self, other: &Self) -> Self {
        let g = and(&self.g, &other.g);
        Self {
            a: or(&and(&self.a, &other.a), &not(&g)),
            g,
        }
    }

    /// G = Ĝ₁ ∧ Ĝ₂, A = A₁ ∨ A₂.
    pub fn conjoin(&self, other: &Self) -> Self {
        Self {
            a: or(&self.a, &other.a),
            g: and(&self.g, &other.g),
        }
    }

    /// A = A ∧ Ĝ₁, G = (Ĝ ∧ A₁) ∨ ¬(A ∧ Ĝ₁).
    pub fn quotient(&self, existing: &Self) -> Self {
        let a = and(&self.a, &existing.g);
        Self {
            g: or(&and(&self.g, &existing.a), &not(&a)),
            a,
        }
    }

    /// A = A₁ ∧ A₂, G = (Ĝ₁ ∧ Ĝ₂) ∨ ¬(A₁ ∧ A₂).
    pub fn merge(&self, other: &Self) -> Self {
        let a = and(&self.a, &other.a);
        Self {
            g: or(&and(&self.g, &other.g), &not(&a)),
            a,
        }
    }

    /// The reciprocal: what is assumed and what is guaranteed, exchanged.
    pub fn reciprocal(&self) -> Self {
        Self {
            a: self.g.clone(),
            g: self.a.clone(),
        }
    }

    /// A₂ ⊆ A₁ and Ĝ₁ ⊆ Ĝ₂, restricted to these lassos.
    pub fn refines(&self, other: &Self) -> bool {
        within(&other.a, &self.a) && within(&self.g, &other.g)
    }
}
