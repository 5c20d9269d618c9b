//! Group sifting on plain data: each pair of twins moves as one, and a kernel is told the order that was found.
//!
//! Rudell's sifting ("Dynamic variable ordering for ordered binary decision diagrams", ICCAD 1993) with groups in the sense of
//! Panda and Somenzi ("Who are the variables in your neighborhood", ICCAD 1995), the groups being fixed: a variable and its
//! primed twin, current bit on top. Each pair, the largest first, goes to the nearer end and then to the other one, and comes
//! to rest where the diagrams were smallest; a direction is left when they have grown by a fifth, or when nothing that is left
//! of it could make them smaller than they were. Then neighbours that cling together go the same way as one, since neither
//! would leave the other alone. So a pass never ends with more nodes than it began with.
//!
//! It works on a copy, with counted references and complement edges (the high edge is never negated), and not inside a
//! kernel: swaps of levels need no locks here, an order serves every kernel, and running out of memory or time leaves the
//! kernel as it was. The work is bounded by a count of nodes that swaps touch, not by a clock, so that the same functions are
//! always sifted to the same order.

use super::{Bit, Diagram, Limits, Order};
use rustc_hash::FxHashMap;

/// A direction is left when there are more than this many percent of the fewest nodes met.
const GROWTH_PERCENT: usize = 120;

/// Passes go on while one leaves less than this many percent of the nodes.
const WORTHWHILE_PERCENT: usize = 95;

/// More passes than this are not made.
const MOST_PASSES: usize = 6;

/// The first pass is given up when a quarter of the work leaves more than this many percent of the nodes.
const HOPEFUL_PERCENT: usize = 99;

/// A call touches at most this many nodes, [`MORE_WORK`] more for each of the first [`MANY_NODES`], and [`WORK_PER_NODE`] for
/// every node.
const LEAST_WORK: usize = 300_000;

/// See [`LEAST_WORK`].
const MORE_WORK: usize = 3_000;

/// See [`LEAST_WORK`].
const MANY_NODES: usize = 20_000;

/// See [`LEAST_WORK`].
const WORK_PER_NODE: usize = 300;

/// What is not a bit: the level of the constant.
const CONSTANT: u16 = u16::MAX;

/// A node; edges are twice a node's number, plus one when negated. Node 0 is the constant `true`.
#[derive(Debug, Clone, Copy)]
struct Node {
    bit: u16,
    references: u32,
    high: u32,
    low: u32,
}

/// Diagrams whose order can be changed.
#[derive(Debug)]
pub struct Sifter {
    nodes: Vec<Node>,
    free: Vec<u32>,
    /// Scratch: the nodes of a bit that depend on the one below.
    moving: Vec<u32>,
    /// Scratch: edges to let go.
    dead: Vec<u32>,
    /// For every bit its nodes, by their edges.
    tables: Vec<FxHashMap<(u32, u32), u32>>,
    /// The pairs from the top to the bottom, and the reverse.
    order: Vec<u16>,
    positions: Vec<u16>,
    /// How many nodes are referenced, the constant aside.
    size: usize,
    /// How many nodes may still be touched.
    work: usize,
}

/// An order in which the diagrams are smaller, with the number of nodes before and after; `None` if none was found.
///
/// `diagram` must respect `order`. No more than `most_work` nodes are touched, however many there are.
pub fn sift(
    diagram: &Diagram,
    order: &Order,
    most_work: usize,
    limits: &Limits,
) -> Option<(Order, usize, usize)> {
    let mut sifter = Sifter::new(diagram, order);
    sifter.work = sifter.work.min(most_work);
    let before = sifter.size;
    sifter.work = sifter.work.min(most_work);
    let after = sifter.sift(limits);
    (after < before).then(|| {
        let order = Order::new(sifter.order).expect("sifting lost a pair; please report this");
        (order, before, after)
    })
}

impl Sifter {
    fn new(diagram: &Diagram, order: &Order) -> Self {
        let pairs = order.pairs().len();
        let mut sifter = Self {
            nodes: vec![Node {
                bit: CONSTANT,
                references: 1,
                high: 0,
                low: 0,
            }],
            free: Vec::new(),
            moving: Vec::new(),
            dead: Vec::new(),
            tables: vec![FxHashMap::default(); 2 * pairs],
            order: order.pairs().to_vec(),
            positions: order.positions(),
            size: 0,
            work: 0,
        };
        // A diagram's constant is `false`, this one's is `true`.
        let mut edges: Vec<u32> = Vec::with_capacity(diagram.nodes.len());
        let edge = |edges: &[u32], e: super::Edge| match e.node() {
            None => u32::from(!e.is_negated()),
            Some(n) => edges[n] ^ u32::from(e.is_negated()),
        };
        for node in &diagram.nodes {
            let (high, low) = (edge(&edges, node.high), edge(&edges, node.low));
            edges.push(sifter.make(node.bit, high, low));
        }
        for root in &diagram.roots {
            sifter.keep(edge(&edges, *root));
        }
        // What was made for the diagram's own sake is dropped: only roots and what they need stays.
        for edge in edges {
            sifter.release(edge);
        }
        sifter.work =
            LEAST_WORK + WORK_PER_NODE * sifter.size + MORE_WORK * sifter.size.min(MANY_NODES);
        sifter
    }

    fn keep(&mut self, edge: u32) {
        self.nodes[(edge >> 1) as usize].references += 1;
    }

    fn release(&mut self, edge: u32) {
        let node = &mut self.nodes[(edge >> 1) as usize];
        if node.references > 1 {
            node.references -= 1;
            return;
        }
        let mut dead = std::mem::take(&mut self.dead);
        dead.push(edge);
        while let Some(edge) = dead.pop() {
            let number = edge >> 1;
            let node = &mut self.nodes[number as usize];
            node.references -= 1;
            if node.references == 0 {
                let Node { bit, high, low, .. } = *node;
                self.tables[usize::from(bit)].remove(&(high, low));
                self.free.push(number);
                self.size -= 1;
                dead.extend([high, low]);
            }
        }
        self.dead = dead;
    }

    /// The node of these edges, with one more reference.
    fn make(&mut self, bit: Bit, high: u32, low: u32) -> u32 {
        if high == low {
            self.keep(high);
            return high;
        }
        let negated = high & 1;
        let key = (high ^ negated, low ^ negated);
        if let Some(number) = self.tables[bit.index()].get(&key) {
            let edge = number << 1;
            self.keep(edge);
            return edge ^ negated;
        }
        self.keep(key.0);
        self.keep(key.1);
        let node = Node {
            bit: bit.0,
            references: 1,
            high: key.0,
            low: key.1,
        };
        let number = if let Some(number) = self.free.pop() {
            self.nodes[number as usize] = node;
            number
        } else {
            self.nodes.push(node);
            self.nodes.len() as u32 - 1
        };
        self.tables[bit.index()].insert(key, number);
        self.size += 1;
        number << 1 ^ negated
    }

    /// The edges of an edge for both values of a bit that is not below its own.
    fn cofactors(&self, edge: u32, bit: u16) -> (u32, u32) {
        let node = &self.nodes[(edge >> 1) as usize];
        if node.bit == bit {
            (node.high ^ edge & 1, node.low ^ edge & 1)
        } else {
            (edge, edge)
        }
    }

    /// Swaps two bits of which the first lies directly above the second.
    fn swap_bits(&mut self, upper: Bit, lower: Bit) {
        let asks_lower =
            |sifter: &Self, edge: u32| sifter.nodes[(edge >> 1) as usize].bit == lower.0;
        let mut moving = std::mem::take(&mut self.moving);
        moving.clear();
        for ((high, low), number) in &self.tables[upper.index()] {
            if asks_lower(self, *high) || asks_lower(self, *low) {
                moving.push(*number);
            }
        }
        self.work = self
            .work
            .saturating_sub(self.tables[upper.index()].len() + 4 * moving.len() + 1);
        for number in &moving {
            let number = *number;
            let Node { high, low, .. } = self.nodes[number as usize];
            self.tables[upper.index()].remove(&(high, low));
            let (high_high, high_low) = self.cofactors(high, lower.0);
            let (low_high, low_low) = self.cofactors(low, lower.0);
            let new_high = self.make(upper, high_high, low_high);
            let new_low = self.make(upper, high_low, low_low);
            debug_assert_eq!(new_high & 1, 0, "a high edge is negated");
            let node = &mut self.nodes[number as usize];
            node.bit = lower.0;
            node.high = new_high;
            node.low = new_low;
            self.tables[lower.index()].insert((new_high, new_low), number);
            self.release(high);
            self.release(low);
        }
        self.moving = moving;
    }

    /// Swaps the pair at a position with the one below it.
    fn swap(&mut self, position: usize) {
        let (a, b) = (self.order[position], self.order[position + 1]);
        let (a, b) = (Bit(2 * a), Bit(2 * b));
        // a a' b b'  →  a b a' b'  →  b a a' b'  →  b a b' a'  →  b b' a a'
        self.swap_bits(a.primed(), b);
        self.swap_bits(a, b);
        self.swap_bits(a.primed(), b.primed());
        self.swap_bits(a, b.primed());
        self.order.swap(position, position + 1);
        self.positions[usize::from(a.pair())] = position as u16 + 1;
        self.positions[usize::from(b.pair())] = position as u16;
    }

    fn nodes_of(&self, pair: u16) -> usize {
        let bit = usize::from(2 * pair);
        self.tables[bit].len() + self.tables[bit + 1].len()
    }

    /// Sifts until it is no longer worthwhile; gives the number of nodes.
    fn sift(&mut self, limits: &Limits) -> usize {
        let all = self.work;
        for pass in 0..MOST_PASSES {
            let before = self.size;
            let mut pairs = self.order.clone();
            pairs.sort_by_key(|p| std::cmp::Reverse(self.nodes_of(*p)));
            for pair in pairs {
                if self.work == 0 || limits.check_time().is_err() {
                    return self.size;
                }
                if self.nodes_of(pair) > 0 {
                    self.place(pair, 1);
                }
                if pass == 0
                    && self.work < all / 4 * 3
                    && self.size * 100 >= before * HOPEFUL_PERCENT
                {
                    return self.size;
                }
            }
            for (upper, lower) in self.couples() {
                if self.work == 0 || limits.check_time().is_err() {
                    return self.size;
                }
                let below = self.positions[usize::from(upper)] + 1;
                if self.positions[usize::from(lower)] == below {
                    self.place(upper, 2);
                }
            }
            if self.size * 100 >= before * WORTHWHILE_PERCENT {
                break;
            }
        }
        self.size
    }

    /// Neighbours that would not be swapped, upper and lower, each pair in one couple at most; those of the most nodes first.
    fn couples(&mut self) -> Vec<(u16, u16)> {
        let mut found = Vec::new();
        for position in 0..self.order.len().saturating_sub(1) {
            let (upper, lower) = (self.order[position], self.order[position + 1]);
            let before = self.size;
            self.swap(position);
            let gain = self.size.saturating_sub(before);
            self.swap(position);
            if gain > 0 {
                found.push((gain, upper, lower));
            }
        }
        found.sort_by_key(|(gain, upper, _)| (std::cmp::Reverse(*gain), *upper));
        let mut taken = vec![false; self.order.len()];
        let mut couples = Vec::new();
        for (_, upper, lower) in found {
            if !taken[usize::from(upper)] && !taken[usize::from(lower)] {
                taken[usize::from(upper)] = true;
                taken[usize::from(lower)] = true;
                couples.push((upper, lower));
            }
        }
        couples.sort_by_key(|(a, b)| std::cmp::Reverse(self.nodes_of(*a) + self.nodes_of(*b)));
        couples
    }

    /// Moves a pair, and those directly below it that belong to its block, to their best place.
    fn place(&mut self, top: u16, length: usize) {
        let mut here = usize::from(self.positions[usize::from(top)]);
        let (mut best, mut best_size) = (here, self.size);
        let last = self.order.len() - length;
        let upwards_first = here < last / 2;
        for upwards in [upwards_first, !upwards_first] {
            let below = &self.order[here + length..];
            let mut below: usize = below.iter().map(|p| self.nodes_of(*p)).sum();
            while here != if upwards { 0 } else { last } {
                // What lies above a block that moves down stays, and so does every node of the block, under its bit or another;
                // what lies below a block that moves up stays.
                let least = if upwards { below } else { self.size - below };
                if least >= best_size {
                    break;
                }
                here = self.step(here, length, upwards);
                if upwards {
                    below += self.nodes_of(self.order[here + length]);
                } else {
                    let rest = &self.order[here + length..];
                    below = rest.iter().map(|p| self.nodes_of(*p)).sum();
                }
                if self.size < best_size {
                    (best, best_size) = (here, self.size);
                }
                if self.size * 100 > best_size * GROWTH_PERCENT || self.work == 0 {
                    break;
                }
            }
        }
        while here != best {
            here = self.step(here, length, here > best);
        }
    }

    /// Moves the block at a position by one; gives its new position.
    fn step(&mut self, here: usize, length: usize, upwards: bool) -> usize {
        if upwards {
            for position in here - 1..here - 1 + length {
                self.swap(position);
            }
            here - 1
        } else {
            for position in (here..here + length).rev() {
                self.swap(position);
            }
            here + 1
        }
    }
}
