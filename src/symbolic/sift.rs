//! Group sifting over OxiDD's store: each pair of twins moves as one.
//!
//! Rudell's sifting ("Dynamic variable ordering for ordered binary decision diagrams", ICCAD 1993) with groups in the sense of
//! Panda and Somenzi ("Who are the variables in your neighborhood", ICCAD 1995), the groups being fixed: a variable and its
//! primed twin, current bit on top. Each pair, the largest first, goes to the nearer end and then to the other one, and comes
//! to rest where the store was smallest; a direction is left when the store has grown by a fifth. So a pass never ends with
//! more nodes than it began with.
//!
//! The work is bounded by a count of nodes that swaps touch, not by a clock: the same functions are always sifted to the same
//! order.

use super::{Limits, Order};
use oxidd::bcdd::BCDDManagerRef;
use oxidd::{HasLevel, LevelNo, Manager, ManagerRef, VarNo};
use oxidd_core::LevelView as _;
use oxidd_reorder::{level_down, set_var_order_seq};

/// A direction is left when the store has more than this many percent of its best size.
const GROWTH_PERCENT: usize = 120;

/// Passes go on while one makes the store smaller than this many percent.
const WORTHWHILE_PERCENT: usize = 97;

/// More passes than this are not made.
const MOST_PASSES: usize = 4;

/// A call touches at most this many nodes, or [`WORK_PER_NODE`] for each node there is if that is more.
const LEAST_WORK: usize = 20_000_000;

/// See [`LEAST_WORK`].
const WORK_PER_NODE: usize = 200;

/// The order of the pairs in a store.
pub fn order(store: &BCDDManagerRef) -> Order {
    store.with_manager_shared(|m| {
        let levels = (0..m.num_levels()).step_by(2);
        let pairs = levels.map(|l| (m.level_to_var(l) / 2) as u16);
        Order::new(pairs.collect()).expect("twins are not neighbours; please report this")
    })
}

/// Brings the pairs into this order.
pub fn set_order(store: &BCDDManagerRef, order: &Order) {
    let variables = order.pairs().iter().map(|p| 2 * VarNo::from(*p));
    let variables: Vec<VarNo> = variables.flat_map(|v| [v, v + 1]).collect();
    store.with_manager_exclusive(|m| set_var_order_seq(m, &variables));
}

/// Looks for a better order.
pub fn sift(store: &BCDDManagerRef, limits: &Limits) {
    store.with_manager_exclusive(|m| {
        m.reorder(|m| {
            let start = m.num_inner_nodes();
            let mut sifter = Sifter {
                pairs: m.num_levels() as usize / 2,
                work: LEAST_WORK.max(WORK_PER_NODE * start),
                limits,
            };
            let mut size = start;
            for _ in 0..MOST_PASSES {
                let smaller = sifter.pass(m);
                let worthwhile = smaller * 100 < size * WORTHWHILE_PERCENT;
                size = smaller;
                if !worthwhile || sifter.exhausted() {
                    break;
                }
            }
        });
    });
}

struct Sifter<'a> {
    pairs: usize,
    /// How many nodes may still be touched.
    work: usize,
    limits: &'a Limits,
}

impl Sifter<'_> {
    fn exhausted(&self) -> bool {
        self.work == 0 || self.limits.check_time().is_err()
    }

    /// Sifts every pair once; gives the size of the store.
    fn pass<M: Manager>(&mut self, m: &mut M) -> usize
    where
        M::InnerNode: HasLevel,
    {
        // A pair is known by the variable of its current bit.
        let mut pairs: Vec<(usize, VarNo)> = (0..self.pairs)
            .map(|p| (nodes_of(m, p), m.level_to_var(2 * p as LevelNo)))
            .collect();
        pairs.sort_unstable_by_key(|(nodes, variable)| (std::cmp::Reverse(*nodes), *variable));
        let mut size = m.num_inner_nodes();
        for (_, variable) in pairs {
            if self.exhausted() {
                break;
            }
            size = self.place(m, variable, size);
        }
        size
    }

    /// Moves one pair to its best place; `size` is the size of the store.
    fn place<M: Manager>(&mut self, m: &mut M, variable: VarNo, mut size: usize) -> usize
    where
        M::InnerNode: HasLevel,
    {
        let mut here = m.var_to_level(variable) as usize / 2;
        if nodes_of(m, here) == 0 {
            return size;
        }
        let (mut best, mut best_size) = (here, size);
        let last = self.pairs - 1;
        let upwards_first = here < self.pairs / 2;
        for upwards in [upwards_first, !upwards_first] {
            while here != if upwards { 0 } else { last } {
                let upper = if upwards { here - 1 } else { here };
                size = self.swap(m, upper, size);
                here = if upwards { here - 1 } else { here + 1 };
                if size < best_size {
                    (best, best_size) = (here, size);
                }
                if size * 100 > best_size * GROWTH_PERCENT || self.exhausted() {
                    break;
                }
            }
        }
        while here != best {
            let upper = if here > best { here - 1 } else { here };
            size = self.swap(m, upper, size);
            here = if here > best { here - 1 } else { here + 1 };
        }
        size
    }

    /// Swaps the pair at `upper` with the one below it; gives the new size of the store.
    fn swap<M: Manager>(&mut self, m: &mut M, upper: usize, size: usize) -> usize
    where
        M::InnerNode: HasLevel,
    {
        let before = nodes_of(m, upper) + nodes_of(m, upper + 1);
        let level = 2 * upper as LevelNo;
        // a a' b b'  →  a b a' b'  →  b a a' b'  →  b a b' a'  →  b b' a a'
        for level in [level + 1, level, level + 2, level + 1] {
            #[expect(
                unsafe_code,
                reason = "the package's only way to exchange two levels"
            )]
            // SAFETY: called within `Manager::reorder`, with exclusive access to the whole manager, hence to these levels.
            unsafe {
                level_down(m, level);
            }
        }
        self.work = self.work.saturating_sub(4 * before + 8);
        let after = nodes_of(m, upper) + nodes_of(m, upper + 1);
        size + after - before
    }
}

/// How many nodes ask one of a pair's bits.
fn nodes_of<M: Manager>(m: &M, position: usize) -> usize {
    let level = 2 * position as LevelNo;
    m.level(level).len() + m.level(level + 1).len()
}
