//! Tests with orders that change during a fixpoint. Games small enough for thousands of tests never
//! reach the size at which a kernel reorders by itself, so these use a kernel that does so at every
//! safe point.

use super::super::arena::{Arena, initial_order};
use super::super::fixpoint::{Iterations, layers, winning_region};
use super::super::heuristics::{Heuristic, Heuristics};
use super::super::progress::Progress;
use super::super::set_up::set_up;
use super::{Random, specification, specification_with_goals};
use crate::symbolic::{
    Biodivine, Bit, BitSet, BudgetFactor, Diagram, Kernel, Limit, Limits, Order, SharedStore,
};
use linewright_core::deadline::Deadline;
use linewright_core::gr1::Specification;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

type Function = <SharedStore as Kernel>::Function;

/// The kernel with a shared store, with sifting at every safe point.
#[derive(Debug, Clone)]
struct Restless {
    inner: SharedStore,
    /// Number of safe points that changed the order.
    changed: Arc<AtomicU64>,
}

impl Kernel for Restless {
    type Function = Function;

    const NAME: &'static str = "restless";

    const REORDERS: bool = true;

    fn new(order: &Order, limits: &Limits) -> Result<Self, Limit> {
        Ok(Self {
            inner: SharedStore::new(order, limits)?,
            changed: Arc::default(),
        })
    }

    fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            inner: self.inner.with_limits(limits),
            changed: Arc::clone(&self.changed),
        }
    }

    fn work(&self) -> u64 {
        self.inner.work()
    }

    fn safe_point(&self) -> Result<(), Limit> {
        let before = self.order();
        self.inner.sift()?;
        if self.order() != before {
            self.changed.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    }

    fn limits(&self) -> Limits {
        self.inner.limits()
    }

    fn order(&self) -> Order {
        self.inner.order()
    }

    fn constant(&self, value: bool) -> Function {
        self.inner.constant(value)
    }

    fn literal(&self, bit: Bit, positive: bool) -> Function {
        self.inner.literal(bit, positive)
    }

    fn is_true(&self, a: &Function) -> bool {
        self.inner.is_true(a)
    }

    fn is_false(&self, a: &Function) -> bool {
        self.inner.is_false(a)
    }

    fn not(&self, a: &Function) -> Result<Function, Limit> {
        self.inner.not(a)
    }

    fn and(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.inner.and(a, b)
    }

    fn or(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.inner.or(a, b)
    }

    fn and_not(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.inner.and_not(a, b)
    }

    fn xor(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.inner.xor(a, b)
    }

    fn ite(&self, c: &Function, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.inner.ite(c, a, b)
    }

    fn and_exists(&self, a: &Function, b: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.inner.and_exists(a, b, bits)
    }

    fn exists(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.inner.exists(a, bits)
    }

    fn restrict(&self, a: &Function, values: &[(Bit, bool)]) -> Result<Function, Limit> {
        self.inner.restrict(a, values)
    }

    fn prime(&self, a: &Function) -> Result<Function, Limit> {
        self.inner.prime(a)
    }

    fn unprime(&self, a: &Function) -> Result<Function, Limit> {
        self.inner.unprime(a)
    }

    fn size(&self, a: &Function) -> usize {
        self.inner.size(a)
    }

    fn support(&self, a: &Function) -> Vec<Bit> {
        self.inner.support(a)
    }

    fn witness(&self, a: &Function) -> Option<Vec<bool>> {
        self.inner.witness(a)
    }

    fn export(&self, functions: &[&Function]) -> Diagram {
        self.inner.export(functions)
    }

    fn nodes(&self) -> u64 {
        self.inner.nodes()
    }

    fn peak_nodes(&self) -> u64 {
        self.inner.peak_nodes()
    }

    fn sift(&self) -> Result<(), Limit> {
        self.inner.sift()
    }

    fn set_reordering(&self, allowed: bool) {
        self.inner.set_reordering(allowed);
    }
}

const SMALL: Limits = Limits {
    deadline: Deadline::NONE,
    memory_mib: None,
    max_nodes: Some(1 << 16),
    max_created: None,
    max_work: None,
    budget_factor: BudgetFactor::ONE,
};

fn board<K: Kernel>(specification: &Specification, order: &Order, with: Heuristics) -> Arena<K> {
    let progress = Progress::default();
    let set_up = set_up::<K>(specification, order, with, &SMALL, &progress);
    set_up.expect("it is small").1
}

/// The winning region, and the steps toward every goal in it.
fn solved<K: Kernel>(arena: &Arena<K>) -> Option<Diagram> {
    let iterations = Iterations::default();
    let region = winning_region(arena, None, &iterations).expect("it is small")?;
    let mut functions = vec![region.clone()];
    for goal in 0..arena.goals.len() {
        for layer in layers(arena, goal, &region).expect("it is small") {
            functions.extend([layer.wait, layer.reached]);
        }
    }
    Some(arena.kernel.export(&functions.iter().collect::<Vec<_>>()))
}

#[test]
fn an_order_that_changes_within_the_fixpoint_changes_nothing() {
    let (mut changed, mut games, mut won) = (0, 0, 0);
    for seed in 0..800 {
        let mut random = Random::new(3_000_000 + seed);
        let specification = if seed % 4 == 0 {
            specification(&mut random)
        } else {
            specification_with_goals(&mut random)
        };
        // Before the fixpoint the bad order is kept.
        let heuristics = Heuristics::all().without(Heuristic::Sifting);
        let order = initial_order(&specification, heuristics.without(Heuristic::Structure));
        let worse: Vec<u16> = order.pairs().iter().rev().copied().collect();
        let worse = Order::new(worse).expect("a permutation");

        let still = board::<Biodivine>(&specification, &order, heuristics);
        let restless = board::<Restless>(&specification, &worse, heuristics);
        let (expected, found) = (solved(&still), solved(&restless));
        assert_eq!(expected.is_some(), found.is_some(), "seed {seed}");
        if let (Some(expected), Some(found)) = (&expected, &found) {
            let import = |diagram| still.kernel.import(diagram).expect("it is small");
            assert!(import(expected) == import(found), "seed {seed}");
            won += 1;
        }
        let count = restless.kernel.changed.load(Ordering::Relaxed);
        changed += count;
        games += u64::from(count > 0);
    }
    println!(
        "{games} of 800 games changed their order within the fixpoint, {changed} times in all; {won} realizable"
    );
    assert!(
        games > 200 && changed > 300,
        "{games} games, {changed} changes"
    );
    assert!(won > 200 && won < 600, "{won} realizable");
}
