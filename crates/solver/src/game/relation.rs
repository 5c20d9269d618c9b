//! A transition relation as clusters, and its relational product with a set.
//!
//! A product conjoins the clusters one after the other, in an order that allows bits to be
//! quantified early (after Ranjan, Aziz, Brayton, Plessier and Pixley, "Efficient BDD algorithms
//! for FSM synthesis and verification", IWLS 1995): a bit is quantified together with the last
//! cluster that mentions it.

use super::clusters::Clustering;
use super::heuristics::{Heuristic, Heuristics};
use crate::symbolic::{Bit, BitSet, Kernel, Limit};
use std::collections::HashMap;

/// Maximum number of clusters that [`Relation::reschedule`] tries at each place.
const MAX_TRIALS: usize = 12;

/// Work that a trial may take in any case.
const TRIAL_WORK: u64 = 100_000;

/// Factor by which a trial may take more work than the first one at the same place.
const TRIAL_FACTOR: u64 = 4;

/// A conjunction of clusters, and the bits that a product with it quantifies.
#[derive(Debug, Clone)]
pub struct Relation<K: Kernel> {
    /// The clusters in the order of use, each with the bits that are quantified together with it.
    clusters: Vec<(K::Function, BitSet)>,
    /// Bits to quantify that no cluster mentions.
    first: BitSet,
    /// Whether conjunction and quantification are one operation.
    fused: bool,
}

impl<K: Kernel> Relation<K> {
    /// Creates the conjunction of `parts`, combined by `clustering`. `gone` are the bits that
    /// products quantify.
    pub fn new(
        kernel: &K,
        parts: &[K::Function],
        gone: &BitSet,
        clustering: Clustering,
        heuristics: Heuristics,
    ) -> Result<Self, Limit> {
        let clusters = if heuristics.has(Heuristic::Clusters) {
            // Conjuncts without bits to quantify stay separate and come last.
            let mentions = |part: &K::Function| {
                let support = kernel.support(part);
                support.into_iter().any(|bit| gone.contains(bit))
            };
            let (with, without): (Vec<_>, Vec<_>) = parts.iter().cloned().partition(mentions);
            let mut clusters = clustering.cluster(kernel, with, gone)?;
            clusters.extend(clustering.cluster(kernel, without, gone)?);
            clusters
        } else {
            let parts = parts.iter().filter(|p| !kernel.is_true(p));
            parts.cloned().collect()
        };
        let supports = supports(kernel, &clusters);
        let order = schedule(&supports, gone);
        let (mut ordered, mut first) = quantified_early(&clusters, &supports, &order, gone);
        if !heuristics.has(Heuristic::EarlyQuantification) && !ordered.is_empty() {
            for (_, bits) in &mut ordered {
                *bits = BitSet::default();
            }
            if let Some((_, bits)) = ordered.last_mut() {
                *bits = gone.clone();
            }
            first = BitSet::default();
        }
        Ok(Self {
            clusters: ordered,
            first,
            fused: heuristics.has(Heuristic::Fusion),
        })
    }

    /// `∃ gone. f ∧ relation`
    pub fn product(&self, kernel: &K, f: &K::Function) -> Result<K::Function, Limit> {
        let mut result = kernel.exists(f, &self.first)?;
        for (cluster, bits) in &self.clusters {
            result = if self.fused {
                kernel.and_exists(&result, cluster, bits)?
            } else {
                kernel.exists(&kernel.and(&result, cluster)?, bits)?
            };
        }
        Ok(result)
    }

    /// Like [`Self::product`], but first moves the clusters into an order that keeps the
    /// intermediate results small: of the clusters left, the one with the smallest result comes
    /// next. Conjunction and quantification become one operation.
    ///
    /// The order that [`schedule`] finds depends only on the bits that clusters mention. How far a
    /// cluster restricts a set shows only when it is tried. Takes about as long as half a product
    /// for each cluster.
    ///
    /// # Errors
    /// Returns the limit that was reached; the order is then as before.
    pub fn reschedule(&mut self, kernel: &K, f: &K::Function) -> Result<K::Function, Limit> {
        let gone = self.clusters.iter().flat_map(|(_, bits)| bits.iter());
        let gone = BitSet::new(gone.chain(self.first.iter()));
        let clusters: Vec<K::Function> = self.parts().cloned().collect();
        let supports = supports(kernel, &clusters);
        let mut left: Vec<usize> = (0..clusters.len()).collect();
        let mut order = Vec::new();
        let mut result = kernel.exists(f, &self.first)?;
        while left.len() > 1 {
            let candidates = left.iter().take(MAX_TRIALS).map(|index| {
                let is_last = |bit: &Bit| {
                    let mut others = left.iter().filter(|other| *other != index);
                    !others.any(|other| supports[*other].contains(*bit))
                };
                let own = supports[*index].iter().filter(|bit| gone.contains(*bit));
                (&clusters[*index], BitSet::new(own.filter(is_last)))
            });
            let (place, product) = smallest_product(kernel, &result, candidates)?;
            order.push(left.remove(place));
            result = product;
        }
        order.extend(left);
        (self.clusters, self.first) = quantified_early(&clusters, &supports, &order, &gone);
        self.fused = true;
        if let Some((cluster, bits)) = self.clusters.last() {
            result = kernel.and_exists(&result, cluster, bits)?;
        }
        Ok(result)
    }

    /// Returns the relation as a single function.
    pub fn whole(&self, kernel: &K) -> Result<K::Function, Limit> {
        kernel.all(self.clusters.iter().map(|(c, _)| c))
    }

    /// Returns the clusters.
    pub fn parts(&self) -> impl Iterator<Item = &K::Function> {
        self.clusters.iter().map(|(c, _)| c)
    }

    /// Returns the number of clusters.
    pub fn count(&self) -> usize {
        self.clusters.len()
    }

    /// Returns the sum of the numbers of nodes of the clusters.
    pub fn size(&self, kernel: &K) -> usize {
        self.clusters.iter().map(|(c, _)| kernel.size(c)).sum()
    }
}

fn supports<K: Kernel>(kernel: &K, clusters: &[K::Function]) -> Vec<BitSet> {
    let supports = clusters.iter().map(|c| kernel.support(c));
    supports.map(BitSet::new).collect()
}

/// Returns the smallest product of `f` with one of the candidates, and the candidate's place. A
/// candidate is a cluster with the bits that its product quantifies; there is at least one.
fn smallest_product<'a, K: Kernel>(
    kernel: &K,
    f: &K::Function,
    candidates: impl Iterator<Item = (&'a K::Function, BitSet)>,
) -> Result<(usize, K::Function), Limit> {
    let mut best: Option<(usize, usize, K::Function)> = None;
    let mut first_work = None;
    for (place, (cluster, bits)) in candidates.enumerate() {
        let before = kernel.work();
        // A better candidate hardly takes far more work than the first one.
        let trial = first_work.map_or_else(
            || kernel.clone(),
            |work| kernel.with_work(TRIAL_WORK.max(TRIAL_FACTOR * work)),
        );
        let product = match trial.and_exists(f, cluster, &bits) {
            Err(Limit::Work(most)) if kernel.limits().max_work != Some(most) => continue,
            product => product?,
        };
        first_work.get_or_insert_with(|| kernel.work() - before);
        let size = kernel.size(&product);
        if best.as_ref().is_none_or(|(least, ..)| size < *least) {
            best = Some((size, place, product));
        }
    }
    let (_, place, product) = best.expect("no cluster was tried; please report this");
    Ok((place, product))
}

/// Returns the clusters in this order, each with the bits of `gone` that no later one mentions, and
/// the bits that none of them mentions.
fn quantified_early<F: Clone>(
    clusters: &[F],
    supports: &[BitSet],
    order: &[usize],
    gone: &BitSet,
) -> (Vec<(F, BitSet)>, BitSet) {
    let mut seen = BitSet::default();
    let mut ordered = Vec::new();
    for index in order.iter().rev() {
        let fresh: Vec<Bit> = gone
            .iter()
            .filter(|b| supports[*index].contains(*b) && !seen.contains(*b))
            .collect();
        for bit in &fresh {
            seen.insert(*bit);
        }
        ordered.push((clusters[*index].clone(), BitSet::new(fresh)));
    }
    ordered.reverse();
    let first = BitSet::new(gone.iter().filter(|b| !seen.contains(*b)));
    (ordered, first)
}

/// Returns the order in which a product uses clusters with these supports. The next cluster is
/// the one with the highest score: twice the number of bits that can then be quantified, minus the
/// number of new bits.
/// Clusters without bits to quantify come last, when the product is smallest.
fn schedule(supports: &[BitSet], gone: &BitSet) -> Vec<usize> {
    let mut left: Vec<usize> = (0..supports.len()).collect();
    let mut present = BitSet::default();
    let mut mentions: HashMap<Bit, usize> = HashMap::new();
    for bit in supports.iter().flat_map(BitSet::iter) {
        *mentions.entry(bit).or_default() += 1;
    }
    let has_bits: Vec<bool> = supports
        .iter()
        .map(|s| s.iter().any(|bit| gone.contains(bit)))
        .collect();
    let mut order = Vec::new();
    while !left.is_empty() {
        let score = |index: usize| {
            let bits = supports[index].iter();
            let worth = bits.map(|bit| {
                let freed = gone.contains(bit) && mentions[&bit] == 1;
                2 * i64::from(freed) - i64::from(!present.contains(bit))
            });
            (has_bits[index], worth.sum::<i64>())
        };
        // Ties are decided by file order.
        let (place, index) = left
            .iter()
            .copied()
            .enumerate()
            .max_by_key(|(place, index)| (score(*index), std::cmp::Reverse(*place)))
            .expect("no cluster is left; please report this");
        left.remove(place);
        for bit in supports[index].iter() {
            present.insert(bit);
            mentions.entry(bit).and_modify(|n| *n -= 1);
        }
        order.push(index);
    }
    order
}
