//! Group sifting on plain data: each pair of twins moves as a unit, and the caller passes the
//! resulting order to a kernel.
//!
//! The method is Rudell's sifting ("Dynamic variable ordering for ordered binary decision
//! diagrams", ICCAD 1993) with groups in the sense of Panda and Somenzi ("Who are the variables in
//! your neighborhood", ICCAD 1995). The groups are fixed: each consists of a bit and its primed
//! twin, with the current bit on top. Each pair, the one with the most nodes first, moves to the
//! nearer end of the order, then to the other end, and finally to the position with the fewest
//! nodes. A direction is abandoned when the diagrams have grown by a fifth, or when its remaining
//! positions cannot have fewer nodes than the best one. After that, adjacent
//! pairs that seem to belong together (swapping them would add nodes) are moved as one block. Moved
//! one at a time, such pairs tend to hold each other in place. A pass never ends with more nodes
//! than it started with.
//!
//! The sifter does not work inside a kernel, but on a copy with reference counts and complement
//! edges (the high edge is never negated). So swapping levels needs no locks, every kernel can use
//! the resulting order, and running out of memory or time leaves the kernel unchanged. The work is
//! limited by the number of nodes that swaps touch, not by time, so that the same functions always
//! get the same order.

use super::link::Link;
use super::{Bit, Diagram, DiagramNode, Edge, Limits, Order};
use rustc_hash::FxHashMap;

/// A direction is abandoned when the node count exceeds this percentage of the smallest count so
/// far.
const GROWTH_PERCENT: usize = 120;

/// Another pass follows if a pass leaves less than this percentage of the nodes that it started
/// with.
const WORTHWHILE_PERCENT: usize = 95;

/// Maximum number of passes.
const MAX_PASSES: usize = 6;

/// Sifting ends during the first pass if at least this percentage of the nodes is left after a
/// quarter of the allowed work.
const HOPEFUL_PERCENT: usize = 99;

/// Base of the work limit of a call, in touched nodes. [`WORK_PER_NODE`] is added for every node,
/// and [`MORE_WORK`] for each of the first [`MANY_NODES`] nodes.
const BASE_WORK: usize = 300_000;

/// See [`BASE_WORK`].
const MORE_WORK: usize = 3_000;

/// See [`BASE_WORK`].
const MANY_NODES: usize = 20_000;

/// See [`BASE_WORK`].
const WORK_PER_NODE: usize = 300;

/// Number of nodes touched between two checks of the deadline; touching them takes a few
/// milliseconds.
const CHECK_INTERVAL: usize = 200_000;

/// Placeholder for the bit in the node of the constant, which tests no bit.
const CONSTANT: u16 = u16::MAX;

/// A node. An edge is encoded as twice the number of its target node, plus one if the edge is
/// negated. Node 0 is the constant `true`.
#[derive(Debug, Clone, Copy)]
struct Node {
    bit: u16,
    references: u32,
    high: u32,
    low: u32,
}

/// Diagrams with a changeable order.
///
/// A swap of two levels creates nodes only in the upper level and removes nodes only from the lower
/// level, because all nodes below stay in use. So a level is a plain list, and only one level at a
/// time needs a table that finds its nodes by their edges.
#[derive(Debug)]
pub struct Sifter {
    nodes: Vec<Node>,
    /// Edges to the roots.
    roots: Vec<u32>,
    free: Vec<u32>,
    /// Numbers of the nodes of each bit.
    levels: Vec<Vec<u32>>,
    /// Scratch: nodes of the upper bit of a swap, by edges.
    table: Table,
    /// Scratch: nodes of the upper bit that have a child of the lower bit.
    moving: Vec<u32>,
    /// Scratch: the other nodes of the upper bit.
    staying: Vec<u32>,
    /// The pairs from top to bottom.
    order: Vec<u16>,
    /// Position of each pair in the order.
    positions: Vec<u16>,
    /// Number of nodes except the constant.
    size: usize,
    /// Number of nodes that can still be touched; set to 0 once the deadline has passed.
    work: usize,
    limits: Limits,
    /// Number of nodes to touch until the next check of the deadline.
    until_check: usize,
}

/// A hash table that finds nodes by their edges, with open addressing. Incrementing the stamp
/// clears it.
#[derive(Debug, Default)]
struct Table {
    slots: Vec<Slot>,
    /// Slots with another stamp are empty.
    stamp: u32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    stamp: u32,
    high: u32,
    low: u32,
    node: u32,
}

impl Table {
    /// Clears the table and makes room for `nodes` entries.
    fn begin(&mut self, nodes: usize) {
        let wanted = (2 * nodes).next_power_of_two();
        if self.slots.len() < wanted || self.stamp == u32::MAX {
            self.slots = vec![Slot::default(); wanted.max(self.slots.len())];
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// Returns the node with these edges, or else the slot where it belongs.
    fn find(&self, high: u32, low: u32) -> Result<u32, usize> {
        let mask = self.slots.len() - 1;
        let key = u64::from(high) << 32 | u64::from(low);
        // Fibonacci hashing: the upper half of the product depends on every bit of the key.
        let mut place = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        loop {
            let slot = &self.slots[place];
            if slot.stamp != self.stamp {
                return Err(place);
            }
            if slot.high == high && slot.low == low {
                return Ok(slot.node);
            }
            place = (place + 1) & mask;
        }
    }

    /// Stores a node in a slot returned by [`Self::find`].
    fn fill(&mut self, place: usize, high: u32, low: u32, node: u32) {
        self.slots[place] = Slot {
            stamp: self.stamp,
            high,
            low,
            node,
        };
    }
}

/// Functions in a better order.
#[derive(Debug)]
pub struct Sifted {
    /// The order found.
    pub order: Order,
    /// Number of nodes before.
    pub before: usize,
    /// Number of nodes after.
    pub after: usize,
    /// The functions in that order, with the roots as they were given.
    pub diagram: Diagram,
}

/// Searches for an order with fewer nodes; returns `None` if none was found.
///
/// `diagram` must respect `order`. Sifting stops after touching `max_work` nodes, or earlier if the
/// work limit of the diagram is lower (see [`BASE_WORK`]).
pub fn sift(diagram: &Diagram, order: &Order, max_work: usize, limits: &Limits) -> Option<Sifted> {
    let mut sifter = Sifter::new(diagram, order, limits);
    sifter.work = sifter.work.min(max_work);
    let before = sifter.size;
    let after = sifter.sift();
    (after < before).then(|| {
        let diagram = sifter.diagram();
        let order = Order::new(sifter.order).expect("sifting lost a pair; please report this");
        Sifted {
            order,
            before,
            after,
            diagram,
        }
    })
}

impl Sifter {
    fn new(diagram: &Diagram, order: &Order, limits: &Limits) -> Self {
        let pairs = order.pairs().len();
        let mut sifter = Self {
            nodes: vec![Node {
                bit: CONSTANT,
                references: 1,
                high: 0,
                low: 0,
            }],
            roots: Vec::new(),
            free: Vec::new(),
            levels: vec![Vec::new(); 2 * pairs],
            table: Table::default(),
            moving: Vec::new(),
            staying: Vec::new(),
            order: order.pairs().to_vec(),
            positions: order.positions(),
            size: 0,
            work: 0,
            limits: *limits,
            until_check: CHECK_INTERVAL,
        };
        // The constant of a `Diagram` is `false`; the constant here is `true`.
        let mut edges: Vec<u32> = Vec::with_capacity(diagram.nodes.len());
        let edge = |edges: &[u32], e: Edge| Link::import(e, |node| Link(edges[node])).0;
        let mut known: FxHashMap<(Bit, u32, u32), u32> = FxHashMap::default();
        for node in &diagram.nodes {
            let (high, low) = (edge(&edges, node.high), edge(&edges, node.low));
            let negated = high & 1;
            let (high, low) = (high ^ negated, low ^ negated);
            let made = if high == low {
                high
            } else {
                *known
                    .entry((node.bit, high, low))
                    .or_insert_with(|| sifter.add(node.bit, high, low))
            };
            edges.push(made ^ negated);
        }
        sifter.roots = diagram.roots.iter().map(|r| edge(&edges, *r)).collect();
        for root in sifter.roots.clone() {
            sifter.keep(root);
        }
        for pair in order.pairs() {
            sifter.drop_dead(Bit(2 * pair));
            sifter.drop_dead(Bit(2 * pair).primed());
        }
        sifter.work =
            BASE_WORK + WORK_PER_NODE * sifter.size + MORE_WORK * sifter.size.min(MANY_NODES);
        sifter
    }

    /// Returns the functions in the current order.
    fn diagram(&self) -> Diagram {
        let mut places = vec![0; self.nodes.len()];
        let exported =
            |places: &[usize], edge: u32| Link(edge).export(|node| places[node as usize]);
        let mut nodes = Vec::with_capacity(self.size);
        for pair in self.order.iter().rev() {
            for bit in [Bit(2 * pair).primed(), Bit(2 * pair)] {
                for number in &self.levels[bit.index()] {
                    let node = self.nodes[*number as usize];
                    let (high, low) = (exported(&places, node.high), exported(&places, node.low));
                    places[*number as usize] = nodes.len();
                    nodes.push(DiagramNode { bit, high, low });
                }
            }
        }
        let roots = self.roots.iter().map(|r| exported(&places, *r)).collect();
        Diagram { nodes, roots }
    }

    /// Removes the nodes of a bit that have no references.
    fn drop_dead(&mut self, bit: Bit) {
        let mut level = std::mem::take(&mut self.levels[bit.index()]);
        level.retain(|number| {
            let Node {
                references,
                high,
                low,
                ..
            } = self.nodes[*number as usize];
            if references == 0 {
                self.release(high);
                self.release(low);
                self.free.push(*number);
                self.size -= 1;
            }
            references > 0
        });
        self.levels[bit.index()] = level;
    }

    fn release(&mut self, edge: u32) {
        self.nodes[(edge >> 1) as usize].references -= 1;
    }

    fn keep(&mut self, edge: u32) {
        self.nodes[(edge >> 1) as usize].references += 1;
    }

    /// Adds a node without references and returns the edge to it. The high edge must not be
    /// negated.
    fn add(&mut self, bit: Bit, high: u32, low: u32) -> u32 {
        debug_assert_eq!(high & 1, 0, "a high edge is negated");
        self.keep(high);
        self.keep(low);
        let node = Node {
            bit: bit.0,
            references: 0,
            high,
            low,
        };
        let number = if let Some(number) = self.free.pop() {
            self.nodes[number as usize] = node;
            number
        } else {
            self.nodes.push(node);
            self.nodes.len() as u32 - 1
        };
        self.levels[bit.index()].push(number);
        self.size += 1;
        number << 1
    }

    /// Returns an edge to the node of `bit` with these edges, and counts a reference to it. The
    /// table must hold the nodes of `bit`.
    fn find_or_add(&mut self, bit: Bit, high: u32, low: u32) -> u32 {
        if high == low {
            self.keep(high);
            return high;
        }
        let negated = high & 1;
        let (high, low) = (high ^ negated, low ^ negated);
        let edge = match self.table.find(high, low) {
            Ok(number) => number << 1,
            Err(place) => {
                let edge = self.add(bit, high, low);
                self.table.fill(place, high, low, edge >> 1);
                edge
            }
        };
        self.keep(edge);
        edge ^ negated
    }

    /// Returns the cofactors of an edge for the values 1 and 0 of `bit`, which must not be below
    /// the bit that the edge's target tests.
    fn cofactors(&self, edge: u32, bit: u16) -> (u32, u32) {
        let node = &self.nodes[(edge >> 1) as usize];
        if node.bit == bit {
            (node.high ^ edge & 1, node.low ^ edge & 1)
        } else {
            (edge, edge)
        }
    }

    /// Swaps two bits; `upper` is directly above `lower`.
    fn swap_bits(&mut self, upper: Bit, lower: Bit) {
        let mut moving = std::mem::take(&mut self.moving);
        let mut staying = std::mem::take(&mut self.staying);
        moving.clear();
        staying.clear();
        let tests_lower = |edge: u32| self.nodes[(edge >> 1) as usize].bit == lower.0;
        for number in &self.levels[upper.index()] {
            let Node { high, low, .. } = self.nodes[*number as usize];
            if tests_lower(high) || tests_lower(low) {
                moving.push(*number);
            } else {
                staying.push(*number);
            }
        }
        let touched = staying.len() + 5 * moving.len() + 1;
        self.work = self.work.saturating_sub(touched);
        if touched < self.until_check {
            self.until_check -= touched;
        } else {
            self.until_check = CHECK_INTERVAL;
            if self.limits.check_time().is_err() {
                self.work = 0;
            }
        }
        if !moving.is_empty() {
            std::mem::swap(&mut self.levels[upper.index()], &mut staying);
            self.exchange(upper, lower, &moving);
        }
        self.moving = moving;
        self.staying = staying;
    }

    /// Turns the nodes `moving` of the upper bit into nodes of the lower bit. The upper level must
    /// already contain only its other nodes.
    fn exchange(&mut self, upper: Bit, lower: Bit, moving: &[u32]) {
        let staying = &self.levels[upper.index()];
        self.table.begin(staying.len() + 2 * moving.len());
        for number in staying {
            let Node { high, low, .. } = self.nodes[*number as usize];
            if let Err(place) = self.table.find(high, low) {
                self.table.fill(place, high, low, *number);
            }
        }
        for number in moving {
            let number = *number as usize;
            let Node { high, low, .. } = self.nodes[number];
            let (high_high, high_low) = self.cofactors(high, lower.0);
            let (low_high, low_low) = self.cofactors(low, lower.0);
            let new_high = self.find_or_add(upper, high_high, low_high);
            let new_low = self.find_or_add(upper, high_low, low_low);
            let node = &mut self.nodes[number];
            node.bit = lower.0;
            node.high = new_high;
            node.low = new_low;
            self.release(high);
            self.release(low);
        }
        // The new nodes refer to the children of the dead nodes, so no node below dies.
        self.drop_dead(lower);
        self.levels[lower.index()].extend_from_slice(moving);
    }

    /// Swaps the pair at a position with the one below it.
    fn swap(&mut self, position: usize) {
        let (a, b) = (self.order[position], self.order[position + 1]);
        let (a, b) = (Bit(2 * a), Bit(2 * b));
        // a a' b b' → a b a' b' → b a a' b' → b a b' a' → b b' a a'
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
        self.levels[bit].len() + self.levels[bit + 1].len()
    }

    /// Sifts until a pass saves too little or the work is used up; returns the number of nodes.
    fn sift(&mut self) -> usize {
        let all = self.work;
        for pass in 0..MAX_PASSES {
            let before = self.size;
            let mut pairs = self.order.clone();
            pairs.sort_by_key(|p| std::cmp::Reverse(self.nodes_of(*p)));
            for pair in pairs {
                if self.work == 0 {
                    return self.size;
                }
                if self.nodes_of(pair) > 0 {
                    self.move_to_best(pair, 1);
                }
                if pass == 0
                    && self.work < all / 4 * 3
                    && self.size * 100 >= before * HOPEFUL_PERCENT
                {
                    return self.size;
                }
            }
            for (upper, lower) in self.couples() {
                if self.work == 0 {
                    return self.size;
                }
                let below = self.positions[usize::from(upper)] + 1;
                if self.positions[usize::from(lower)] == below {
                    self.move_to_best(upper, 2);
                }
            }
            if self.size * 100 >= before * WORTHWHILE_PERCENT {
                break;
            }
        }
        self.size
    }

    /// Returns adjacent pairs whose swap would add nodes, as (upper, lower), the couple with the
    /// most nodes first. Each pair is in at most one couple.
    fn couples(&mut self) -> Vec<(u16, u16)> {
        let mut found = Vec::new();
        for position in 0..self.order.len().saturating_sub(1) {
            if self.work == 0 {
                break;
            }
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

    /// Moves the block of `length` pairs that starts with `top` to its best position.
    fn move_to_best(&mut self, top: u16, length: usize) {
        let mut here = usize::from(self.positions[usize::from(top)]);
        let (mut best, mut best_size) = (here, self.size);
        let last = self.order.len() - length;
        let upwards_first = here < last / 2;
        for upwards in [upwards_first, !upwards_first] {
            let below = &self.order[here + length..];
            let mut below: usize = below.iter().map(|p| self.nodes_of(*p)).sum();
            while here != if upwards { 0 } else { last } {
                // A lower bound of the node count for the rest of this direction. Moving down
                // leaves the nodes above the block unchanged, and at least as many nodes as the
                // block has now remain. Moving up leaves the nodes below the block unchanged.
                let least = if upwards { below } else { self.size - below };
                if least >= best_size {
                    break;
                }
                if !upwards {
                    below -= self.nodes_of(self.order[here + length]);
                }
                here = self.step(here, length, upwards);
                if upwards {
                    below += self.nodes_of(self.order[here + length]);
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

    /// Moves the block at position `here` up or down by one position; returns its new position.
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
