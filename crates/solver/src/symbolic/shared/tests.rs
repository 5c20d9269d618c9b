//! Tests of what only this kernel has: collections, reordering, growth and limits within an
//! operation.

use super::*;
use crate::random::Random;

/// Bits of the functions in these tests; a function is compared by its truth table.
const BITS: u16 = 6;

fn kernel() -> SharedStore {
    SharedStore::new(&Order::natural(usize::from(BITS) / 2), &Limits::default()).unwrap()
}

/// Returns the truth table of a function; bit `row` is its value on the valuation `row`.
fn table(m: &SharedStore, f: &Function) -> u64 {
    let diagram = m.export(&[f]);
    (0..1u64 << BITS)
        .filter(|row| {
            let values: Vec<bool> = (0..BITS).map(|bit| row >> bit & 1 == 1).collect();
            diagram.evaluate(0, &values)
        })
        .fold(0, |table, row| table | 1 << row)
}

fn literal_table(bit: u16) -> u64 {
    (0..1u64 << BITS)
        .filter(|row| row >> bit & 1 == 1)
        .fold(0, |table, row| table | 1 << row)
}

/// Returns the table of `∃ bit. f`.
fn exists_table(table: u64, bit: u16) -> u64 {
    let (shift, ones) = (1 << bit, literal_table(bit));
    let (high, low) = (table & ones, table & !ones);
    high | high >> shift | low | low << shift
}

/// Functions survive any mixture of operations, collections and reorderings, and equal functions
/// stay equal.
#[test]
fn functions_survive_collections_and_reorderings() {
    let mut random = Random::new(24);
    for _ in 0..30 {
        let m = kernel();
        let mut known: Vec<(Function, u64)> = (0..BITS)
            .map(|bit| (m.literal(Bit(bit), true), literal_table(bit)))
            .collect();
        for _ in 0..300 {
            let mut pick = || known[random.below(known.len() as u64) as usize].clone();
            let ((a, table_a), (b, table_b), (c, table_c)) = (pick(), pick(), pick());
            let bit = random.below(u64::from(BITS)) as u16;
            let made = match random.below(9) {
                0 => (m.and(&a, &b).unwrap(), table_a & table_b),
                1 => (m.or(&a, &b).unwrap(), table_a | table_b),
                2 => (m.xor(&a, &b).unwrap(), table_a ^ table_b),
                3 => (m.and_not(&a, &b).unwrap(), table_a & !table_b),
                4 => {
                    let chosen = table_c & table_a | !table_c & table_b;
                    (m.ite(&c, &a, &b).unwrap(), chosen)
                }
                5 => {
                    let bits = BitSet::new([Bit(bit)]);
                    let both = table_a & table_b;
                    let made = m.and_exists(&a, &b, &bits).unwrap();
                    (made, exists_table(both, bit))
                }
                6 => {
                    let positive = random.chance(50);
                    let literal = literal_table(bit);
                    let half = table_a & if positive { literal } else { !literal };
                    let made = m.restrict(&a, &[(Bit(bit), positive)]).unwrap();
                    (made, exists_table(half, bit))
                }
                7 => {
                    m.state().collect();
                    (m.not(&a).unwrap(), !table_a)
                }
                _ => {
                    // Without a bound, a better order is used however small the gain is.
                    m.sift().unwrap();
                    (m.constant(true), u64::MAX)
                }
            };
            if known.len() > 20 {
                known.swap_remove(random.below(20) as usize);
            }
            known.push(made);
        }
        for (f, expected) in &known {
            assert_eq!(table(&m, f), *expected);
            for (g, other) in &known {
                assert_eq!(f == g, expected == other);
            }
        }
    }
}

/// A store that has grown holds each node once, and a collection leaves exactly the live ones.
#[test]
fn nodes_are_unique_and_collections_exact() {
    let m = SharedStore::new(&Order::natural(24), &Limits::default()).unwrap();
    let fresh = m.nodes();
    let pairs = || {
        (0..12).fold(m.constant(true), |all, i| {
            let a = m.literal(Bit(2 * i), true);
            let b = m.literal(Bit(2 * (i + 12)), true);
            m.and(&all, &m.iff(&a, &b).unwrap()).unwrap()
        })
    };
    let f = pairs();
    let made = m.nodes();
    assert!(made > 10_000, "{made}");
    m.state().collect();
    let live = m.nodes();
    // The literals stay, and the constant is no node.
    let shared = m.size(&f) as u64 + fresh;
    assert!(
        live <= shared && live + fresh >= shared,
        "{live} of {shared}"
    );
    assert!(pairs() == f);
    drop(f);
    m.state().collect();
    assert_eq!(m.nodes(), fresh);
    assert_eq!(m.peak_nodes(), made);
}

/// A full store keeps its memory limit, with room for the copy that is sifted.
#[test]
fn a_full_store_keeps_its_memory_limit() {
    for memory_mib in [4, 9, 16, 33] {
        let limits = Limits {
            memory_mib: Some(memory_mib),
            ..Limits::default()
        };
        let m = SharedStore::new(&Order::natural(60), &limits).unwrap();
        m.set_reordering(false);
        // In this order, each further factor doubles the number of nodes.
        let end = (0..30).try_fold(m.constant(true), |all, i| {
            let a = m.literal(Bit(2 * i), true);
            let b = m.literal(Bit(2 * (i + 30)), true);
            m.and(&all, &m.iff(&a, &b)?)
        });
        assert_eq!(end, Err(Limit::Memory));
        let bytes = m.state().store.bytes() as u64;
        let limit = memory_mib << 20;
        assert!(bytes * 4 <= limit * 3, "{bytes} bytes at {memory_mib} MiB");
        assert!(bytes * 4 >= limit, "{bytes} bytes at {memory_mib} MiB");
    }
}

/// Without room for a result, what the caller has dropped makes room.
#[test]
fn a_full_store_is_collected_and_the_operation_repeated() {
    let limits = Limits {
        memory_mib: Some(4),
        ..Limits::default()
    };
    let m = SharedStore::new(&Order::natural(32), &limits).unwrap();
    for round in 0..40u16 {
        // About 2^14 nodes each, and no two rounds share many.
        let f = (0..13).fold(m.constant(round % 2 == 0), |all, i| {
            let a = m.literal(Bit(2 * ((i + round) % 16)), true);
            let b = m.literal(Bit(2 * (16 + i)), i % 3 != round % 3);
            m.xor(&all, &m.and(&a, &b).unwrap()).unwrap()
        });
        assert!(m.size(&f) > 5_000);
    }
    assert!(m.state().store.created() > 3 * m.shared.capacity);
}

/// An operation that takes long in the present order is repeated in a better one.
#[test]
fn an_operation_is_interrupted_to_reorder() {
    let equal = |m: &SharedStore, from: u16| {
        (from..from + 8).fold(m.constant(true), |all, i| {
            let (a, b) = (Bit(2 * i), Bit(2 * (16 + i)));
            let same = m.iff(&m.literal(a, true), &m.literal(b, true)).unwrap();
            m.and(&all, &same).unwrap()
        })
    };
    let both = |reordering| {
        let m = SharedStore::new(&Order::natural(32), &Limits::default()).unwrap();
        let (f, g) = (equal(&m, 0), equal(&m, 8));
        m.set_reordering(reordering);
        m.state().patience = 100_000;
        let both = m.and(&f, &g).unwrap();
        (m.size(&both), m.export(&[&both]).shares())
    };
    let (size, share) = both(false);
    let (reordered, same_share) = both(true);
    assert!(size > 1 << 16, "{size} nodes");
    assert!(reordered < 100, "{reordered} nodes");
    assert_eq!(share, same_share);
}

/// A single operation that is too large ends at the work limit, not after it.
#[test]
fn the_work_limit_ends_an_operation() {
    let m = SharedStore::new(&Order::natural(36), &Limits::default()).unwrap();
    // Pairs of distant bits: 2^9 nodes each, but the conjunction has 2^18.
    let equal = |from: u16| {
        (from..from + 9).fold(m.constant(true), |all, i| {
            let (a, b) = (Bit(2 * i), Bit(2 * (18 + i)));
            let same = m.iff(&m.literal(a, true), &m.literal(b, true)).unwrap();
            m.and(&all, &same).unwrap()
        })
    };
    let (f, g) = (equal(0), equal(9));
    let allowed = m.work() + 1_000_000;
    let limited = m.with_limits(&Limits {
        max_work: Some(allowed),
        ..Limits::default()
    });
    assert_eq!(limited.and(&f, &g), Err(Limit::Work(allowed)));
    assert!(m.work() < 2 * allowed, "{} units", m.work());
    assert!(m.and(&f, &g).is_ok());
    assert!(m.work() > 2 * allowed, "{} units", m.work());
}
