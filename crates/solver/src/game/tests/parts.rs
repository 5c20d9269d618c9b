//! Tests clusters, relations and the diagram builder against a kernel's own operations, on random
//! functions.

use super::super::clusters::Clustering;
use super::super::diagram_builder::DiagramBuilder;
use super::super::heuristics::Heuristics;
use super::super::relation::Relation;
use super::Random;
use crate::symbolic::{Biodivine, Bit, BitSet, Edge, Kernel, Limit, Limits, Order, SharedStore};

const PAIRS: u16 = 6;

fn kernel<K: Kernel>(random: &mut Random) -> K {
    let mut pairs: Vec<u16> = (0..PAIRS).collect();
    for i in (1..pairs.len()).rev() {
        pairs.swap(i, random.below(i as u64 + 1) as usize);
    }
    let order = Order::new(pairs).expect("each pair once");
    let limits = Limits {
        max_nodes: Some(1 << 16),
        ..Limits::default()
    };
    K::new(&order, &limits).expect("it is small")
}

/// A conjunction of `clauses` clauses over some of the bits.
fn function<K: Kernel>(m: &K, random: &mut Random, clauses: usize, bits: &[Bit]) -> K::Function {
    let mut all = m.constant(true);
    for _ in 0..clauses {
        let mut clause = m.constant(false);
        for _ in 0..3 {
            let bit = bits[random.below(bits.len() as u64) as usize];
            let literal = m.literal(bit, random.chance(50));
            clause = m.or(&clause, &literal).expect("it is small");
        }
        all = m.and(&all, &clause).expect("it is small");
    }
    all
}

/// Whether two functions are equal. Biodivine's may be equal and stored in different order.
fn same<K: Kernel>(m: &K, a: &K::Function, b: &K::Function) -> bool {
    m.is_false(&m.xor(a, b).expect("it is small"))
}

fn all_bits() -> Vec<Bit> {
    (0..2 * PAIRS).map(Bit).collect()
}

fn clusters_are_their_parts<K: Kernel>(seed: u64) -> bool {
    let mut random = Random::new(seed);
    let m: K = kernel(&mut random);
    // Neighbors share bits, as formulas of a file do.
    let parts: Vec<K::Function> = (0..12)
        .map(|i| {
            let first = (random.below(3) + i / 2).min(u64::from(PAIRS) - 3);
            let bits: Vec<Bit> = (0..6).map(|b| Bit((2 * first + b) as u16)).collect();
            function(&m, &mut random, 2, &bits)
        })
        .collect();
    let gone = BitSet::new((0..PAIRS).map(|p| Bit(2 * p).primed()));
    let wanted = m.all(&parts).expect("it is small");
    let largest = parts.iter().map(|p| m.size(p)).max().unwrap_or(0);
    let bound = largest + random.below(20) as usize;
    let clusters = |clustering: Clustering| {
        let clusters = clustering
            .cluster(&m, parts.clone(), &gone)
            .expect("it is small");
        assert!(clusters.iter().all(|c| m.size(c) <= bound), "seed {seed}");
        assert!(clusters.len() <= parts.len(), "seed {seed}");
        let all = m.all(&clusters).expect("it is small");
        assert!(same(&m, &all, &wanted), "seed {seed}");
        clusters
    };
    let (in_order, by_bits) = (
        clusters(Clustering::InOrder(bound)),
        clusters(Clustering::ByBits(bound)),
    );
    let mut both = in_order.iter().zip(&by_bits);
    in_order.len() != by_bits.len() || !both.all(|(a, b)| same(&m, a, b))
}

#[test]
fn clusters_say_what_their_parts_say_and_keep_their_bound() {
    let mut differ = 0;
    for seed in 0..400 {
        let on_one = clusters_are_their_parts::<Biodivine>(seed);
        let on_other = clusters_are_their_parts::<SharedStore>(seed);
        differ += usize::from(on_one) + usize::from(on_other);
    }
    println!("clusters by bits differ from those in order {differ} times of 800");
    assert!(differ >= 50);
}

/// A relation with rescheduled clusters has the same product with every set. Returns whether the
/// clusters are in another order.
fn rescheduling_keeps_products<K: Kernel>(seed: u64) -> bool {
    let mut random = Random::new(seed);
    let m: K = kernel(&mut random);
    let parts: Vec<K::Function> = (0..=random.below(6))
        .map(|_| function(&m, &mut random, 2, &all_bits()))
        .collect();
    let gone = BitSet::new(all_bits().into_iter().filter(|_| random.chance(40)));
    let one_each = Clustering::InOrder(0);
    let mut relation =
        Relation::new(&m, &parts, &gone, one_each, Heuristics::default()).expect("it is small");
    let before: Vec<K::Function> = relation.parts().cloned().collect();
    let [set, other] = [3, 5].map(|clauses| function(&m, &mut random, clauses, &all_bits()));
    let whole = m.all(&parts).expect("it is small");
    let wanted = |set| m.and_exists(set, &whole, &gone).expect("it is small");

    let stopped = relation.reschedule(&m.with_work(1), &other);
    assert!(
        matches!(stopped, Ok(_) | Err(Limit::Work(_))),
        "seed {seed}: {stopped:?}"
    );
    let product = relation.product(&m, &set).expect("it is small");
    assert!(same(&m, &product, &wanted(&set)), "seed {seed}");
    let product = relation.reschedule(&m, &set).expect("it is small");
    assert!(same(&m, &product, &wanted(&set)), "seed {seed}");
    for set in [&set, &other] {
        let product = relation.product(&m, set).expect("it is small");
        assert!(same(&m, &product, &wanted(set)), "seed {seed}");
    }
    assert_eq!(relation.count(), before.len(), "seed {seed}");
    relation.parts().ne(&before)
}

#[test]
fn rescheduled_relations_have_the_same_products() {
    let mut moved = 0;
    for seed in 0..300 {
        let on_one = rescheduling_keeps_products::<Biodivine>(seed);
        let on_other = rescheduling_keeps_products::<SharedStore>(seed);
        moved += usize::from(on_one) + usize::from(on_other);
    }
    println!("clusters moved {moved} times of 600");
    assert!(moved >= 100);
}

fn builder_agrees<K: Kernel>(seed: u64) {
    let mut random = Random::new(seed);
    let m: K = kernel(&mut random);
    let clauses = 1 + random.below(8) as usize;
    let any = |random: &mut Random| {
        let f = function(&m, random, clauses, &all_bits());
        if random.chance(50) {
            m.not(&f).expect("it is small")
        } else {
            f
        }
    };
    let (f, care) = (any(&mut random), any(&mut random));
    let mut bench = DiagramBuilder::new(&m.order(), &Limits::default());
    let edges = bench.add(&m, [&f, &care]).expect("it is small");
    let mut wanted = vec![m.and(&f, &care), m.or(&f, &care), m.xor(&f, &care)];
    let mut made = vec![
        bench.and(edges[0], edges[1]),
        bench.or(edges[0], edges[1]),
        bench.xor(edges[0], edges[1]),
    ];
    for bit in all_bits() {
        let at = |value| m.restrict(&f, &[(bit, value)]).expect("it is small");
        let choices = bench.choices(edges[0], bit).expect("it is small");
        wanted.extend([Ok(at(true)), m.or(&at(true), &at(false))]);
        wanted.push(m.xor(&at(true), &at(false)));
        made.extend([choices.may_set, choices.possible, choices.forced].map(Ok));
    }
    let simple = bench.simplify(edges[0], edges[1]).expect("it is small");
    let mut size = |edge| bench.measure(edge, &[]).1;
    assert!(size(simple) <= size(edges[0]), "seed {seed}");
    let made: Vec<Edge> = made.into_iter().map(|e| e.expect("it is small")).collect();
    let mut fresh = DiagramBuilder::new(&m.order(), &Limits::default());
    let mut roots = made;
    roots.push(simple);
    let roots = fresh.copy(&mut bench, &roots).expect("it is small");
    let mut diagram = fresh.into_diagram();
    diagram.roots = roots;
    let mut functions = m.import(&diagram).expect("it is small");
    let simple = functions.pop().expect("it was the last");
    let wanted: Vec<K::Function> = wanted
        .into_iter()
        .map(|f| f.expect("it is small"))
        .collect();
    assert_eq!(functions.len(), wanted.len());
    for (made, wanted) in functions.iter().zip(&wanted) {
        assert!(same(&m, made, wanted), "seed {seed}");
    }
    let different = m.xor(&simple, &f).expect("it is small");
    let matters = m.and(&different, &care).expect("it is small");
    assert!(m.is_false(&matters), "seed {seed}");
}

#[test]
fn the_diagram_builder_computes_what_a_kernel_does() {
    for seed in 0..400 {
        builder_agrees::<Biodivine>(seed);
        builder_agrees::<SharedStore>(seed);
    }
}
