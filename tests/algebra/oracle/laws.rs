//! The laws of the algebra on random contracts: exactly, by the procedure that decides questions
//! about all infinite runs, and by the definitions on all lassos up to the bound.

use super::contracts::{akin, any, refined, refining, system, variables};
use super::lassos::{Meaning, all};
use crate::random::Random;
use linewright::algebra::contract::Contract;
use linewright::algebra::decide::Decider;
use linewright::algebra::system::{Component, System};
use linewright::game::{Lasso, Limits};
use linewright::gr1::Variable;

const ROUNDS: u64 = 1_000;

/// Contracts as parts of one system, their meanings, and the procedure.
struct Bench<'a> {
    seed: u64,
    lassos: Vec<Lasso>,
    meanings: Vec<Meaning>,
    decider: Decider<'a>,
}

/// A contract made of parts, with its meaning by definition.
#[derive(Clone)]
struct Both(Contract, Meaning);

impl Both {
    fn compose(&self, other: &Self) -> Self {
        Self(self.0.compose(&other.0), self.1.compose(&other.1))
    }

    fn conjoin(&self, other: &Self) -> Self {
        Self(self.0.conjoin(&other.0), self.1.conjoin(&other.1))
    }

    fn quotient(&self, other: &Self) -> Self {
        Self(self.0.quotient(&other.0), self.1.quotient(&other.1))
    }

    fn merge(&self, other: &Self) -> Self {
        Self(self.0.merge(&other.0), self.1.merge(&other.1))
    }

    fn reciprocal(&self) -> Self {
        let swapped = Contract {
            assumption: self.0.guarantee.clone(),
            guarantee: self.0.assumption.clone(),
        };
        Self(swapped, self.1.reciprocal())
    }
}

impl<'a> Bench<'a> {
    fn new(seed: u64, system: &'a System, bound: usize) -> Self {
        let lassos = all(&system.variables, bound);
        Self {
            seed,
            meanings: Meaning::all(system, &lassos),
            decider: Decider::new(system, &Limits::default()).expect("room"),
            lassos,
        }
    }

    fn part(&self, index: usize) -> Both {
        Both(Contract::component(index), self.meanings[index].clone())
    }

    /// Whether one refines the other on all runs; then it also does on the lassos.
    fn refines(&mut self, small: &Both, large: &Both) -> bool {
        let found = self.decider.refutation(&small.0, &large.0);
        let refines = found.expect("no limit").is_none();
        let bounded = small.1.refines(&large.1);
        assert!(!refines || bounded, "seed {}", self.seed);
        refines
    }

    /// Both are the same, on all runs and on the lassos.
    #[track_caller]
    fn same(&mut self, a: &Both, b: &Both) {
        assert_eq!(a.1, b.1, "seed {}, {} lassos", self.seed, self.lassos.len());
        let same = self.decider.equivalent(&a.0, &b.0).expect("no limit");
        assert!(same, "seed {}", self.seed);
    }

    /// A law: one refines the other, on all runs and on the lassos.
    #[track_caller]
    fn holds(&mut self, small: &Both, large: &Both) {
        assert!(small.1.refines(&large.1), "seed {}", self.seed);
        assert!(self.refines(small, large), "seed {}", self.seed);
    }
}

/// A bench for every seed, with the parts returned by `make`.
fn rounds(
    first: u64,
    make: impl Fn(&mut Random, &[Variable]) -> Vec<Component>,
    mut check: impl FnMut(&mut Bench<'_>),
) {
    for seed in first..first + ROUNDS {
        let mut r = Random::new(seed);
        let (variables, bound) = variables(&mut r);
        let parts = make(&mut r, &variables);
        let system = system(&variables, parts);
        check(&mut Bench::new(seed, &system, bound));
    }
}

/// Every contract refines itself; and refinement is transitive. Chains arise by weakening and by
/// chance.
#[test]
fn refinement_is_a_preorder() {
    let (mut chains, mut strict, mut others) = (0, 0, 0);
    let make = |r: &mut Random, variables: &[Variable]| {
        let b = any(r, variables);
        let a = if r.chance(70) {
            refining(r, variables, &b)
        } else {
            akin(r, variables, &b)
        };
        let c = if r.chance(70) {
            refined(r, variables, &b)
        } else {
            akin(r, variables, &b)
        };
        vec![a, b, c]
    };
    rounds(10_000, make, |bench| {
        let parts = [0, 1, 2].map(|i| bench.part(i));
        let mut below = [[false; 3]; 3];
        for (i, row) in below.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                *cell = bench.refines(&parts[i], &parts[j]);
            }
            assert!(row[i], "seed {}", bench.seed);
        }
        for i in 0..3 {
            for j in (0..3).filter(|j| *j != i) {
                let k = 3 - i - j;
                if below[i][j] && below[j][k] {
                    chains += 1;
                    strict += u32::from(!below[j][i] && !below[k][j]);
                    assert!(below[i][k], "seed {}", bench.seed);
                } else {
                    others += 1;
                }
            }
        }
    });
    println!(
        "{ROUNDS} triples: {chains} chains, {strict} of them strict, {others} of three in another order"
    );
    assert!(chains >= 300 && strict >= 150 && others >= 300);
}

/// C₁ ⊗ C₂ = C₂ ⊗ C₁, (C₁ ⊗ C₂) ⊗ C₃ = C₁ ⊗ (C₂ ⊗ C₃), and C₁ ≼ C₁′ implies C₁ ⊗ C₂ ≼ C₁′ ⊗ C₂.
#[test]
fn composition_is_commutative_associative_and_monotone() {
    let (mut related, mut strict) = (0, 0);
    let make = |r: &mut Random, variables: &[Variable]| {
        let a = any(r, variables);
        let b = akin(r, variables, &a);
        let c = any(r, variables);
        vec![refined(r, variables, &a), a, b, c]
    };
    rounds(20_000, make, |bench| {
        let [weaker, a, b, c] = [0, 1, 2, 3].map(|i| bench.part(i));
        bench.same(&a.compose(&b), &b.compose(&a));
        bench.same(&a.compose(&b).compose(&c), &a.compose(&b.compose(&c)));
        for large in [&weaker, &b] {
            if bench.refines(&a, large) {
                related += 1;
                strict += u32::from(!bench.refines(large, &a));
                bench.holds(&a.compose(&c), &large.compose(&c));
            }
        }
    });
    println!("{ROUNDS} triples; {related} pairs in order, {strict} of them strictly");
    assert!(related >= 1_000 && strict >= 500);
}

/// C₁ ⊗ (C / C₁) ≼ C; and the quotient is the weakest such contract: C₁ ⊗ X ≼ C exactly when X ≼ C
/// / C₁.
#[test]
fn the_quotient_is_the_weakest_contract_that_completes_another() {
    let (mut complete, mut not) = (0, 0);
    let make = |r: &mut Random, variables: &[Variable]| {
        let c = any(r, variables);
        let c1 = akin(r, variables, &c);
        let x = match r.below(5) {
            0..=2 => any(r, variables),
            // The demands of C, with C₁ added to the assumptions.
            3 => {
                let mut x = refining(r, variables, &c);
                x.assumptions = c.assumptions.clone();
                x
            }
            _ => refining(r, variables, &c),
        };
        vec![c, c1, x]
    };
    rounds(30_000, make, |bench| {
        let [c, c1, x] = [0, 1, 2].map(|i| bench.part(i));
        let quotient = c.quotient(&c1);
        bench.holds(&c1.compose(&quotient), &c);
        // The quotient itself, something below it, and something that may not be.
        for x in [x.clone(), x.conjoin(&quotient), c.conjoin(&x)] {
            let completes = bench.refines(&c1.compose(&x), &c);
            let below = bench.refines(&x, &quotient);
            assert_eq!(completes, below, "seed {}", bench.seed);
            assert_eq!(c1.compose(&x).1.refines(&c.1), x.1.refines(&quotient.1));
            if completes {
                complete += 1;
            } else {
                not += 1;
            }
        }
    });
    println!("{ROUNDS} pairs: {complete} contracts complete the existing one, {not} do not");
    assert!(complete >= 600 && not >= 600);
}

/// C₁ ∧ C₂ lies below both, and everything that lies below both lies below it.
#[test]
fn conjunction_is_the_greatest_lower_bound() {
    let (mut common, mut not) = (0, 0);
    let make = |r: &mut Random, variables: &[Variable]| {
        let a = any(r, variables);
        let b = akin(r, variables, &a);
        let of = if r.chance(50) { &a } else { &b };
        let mut x = refining(r, variables, of);
        if r.chance(50) {
            // Often below both: no assumption, and the guarantees of both.
            let other = if r.chance(50) { &a } else { &b };
            x.assumptions = linewright::gr1::Side::default();
            x.guarantees.safety.extend(other.guarantees.safety.clone());
            x.guarantees
                .justice
                .extend(other.guarantees.justice.clone());
            x.guarantees
                .initial
                .extend(other.guarantees.initial.clone());
            let invariants = other.guarantees.invariants.clone();
            x.guarantees.invariants.extend(invariants);
        }
        vec![a, b, x]
    };
    rounds(40_000, make, |bench| {
        let [a, b, x] = [0, 1, 2].map(|i| bench.part(i));
        let both = a.conjoin(&b);
        bench.holds(&both, &a);
        bench.holds(&both, &b);
        let below_both = bench.refines(&x, &a) && bench.refines(&x, &b);
        assert_eq!(below_both, bench.refines(&x, &both), "seed {}", bench.seed);
        if below_both {
            common += 1;
        } else {
            not += 1;
        }
    });
    println!("{ROUNDS} pairs: {common} common refinements, {not} contracts that are none");
    assert!(common >= 200 && not >= 200);
}

/// Merging is composition with assumptions and guarantees exchanged: C₁ • C₂ = (C₁⁻¹ ⊗ C₂⁻¹)⁻¹,
/// where the reciprocal of a saturated contract is (A, Ĝ)⁻¹ = (Ĝ, A), which is saturated again
/// since A ∪ Ĝ is everything. This is the duality of Passerone, Íncer Romeo and
/// Sangiovanni-Vincentelli ("Coherent extension, composition, and merging operators in contract
/// models", 2019). So merging has the same properties as composition: it is commutative,
/// associative and monotone. `operations` tests its definition.
#[test]
fn merging_is_dual_to_composition() {
    let mut related = 0;
    let make = |r: &mut Random, variables: &[Variable]| {
        let a = any(r, variables);
        let b = akin(r, variables, &a);
        let c = any(r, variables);
        vec![refined(r, variables, &a), a, b, c]
    };
    rounds(50_000, make, |bench| {
        let [weaker, a, b, c] = [0, 1, 2, 3].map(|i| bench.part(i));
        let dual = |a: &Both, b: &Both| a.reciprocal().compose(&b.reciprocal()).reciprocal();
        bench.same(&a.merge(&b), &dual(&a, &b));
        bench.same(
            &a.compose(&b),
            &a.reciprocal().merge(&b.reciprocal()).reciprocal(),
        );
        bench.same(&a.merge(&b), &b.merge(&a));
        bench.same(&a.merge(&b).merge(&c), &a.merge(&b.merge(&c)));
        // Exchanging the halves reverses refinement.
        let upside_down = bench.refines(&b.reciprocal(), &a.reciprocal());
        assert_eq!(bench.refines(&a, &b), upside_down, "seed {}", bench.seed);
        if bench.refines(&a, &weaker) {
            related += 1;
            bench.holds(&a.merge(&c), &weaker.merge(&c));
        }
    });
    println!("{ROUNDS} triples; {related} pairs in order");
    assert!(related >= 800);
}
