//! The nodes of all functions of a kernel: a unique table, a cache of results, and a collector.
//!
//! The layout follows Brace, Rudell and Bryant ("Efficient implementation of a BDD package", DAC
//! 1990): complement edges, a common unique table and a lossy cache. A node is twelve bytes. The
//! unique table is a list of slots apart from the nodes, with open addressing. Each slot also holds
//! the hash of its node, so that a lookup reads a node only if it is almost surely the right one,
//! and growing the table reads no nodes. Nodes carry no reference counts: a collection marks what
//! the given roots reach. So an operation writes no node that exists already.

use super::super::{Bit, Diagram, DiagramNode, Edge, Limit, Limits, Order};
use rustc_hash::FxHashMap;

/// Level of the constant, below every bit.
const BOTTOM: u32 = (1 << 30) - 1;

/// Level of a free place in the list of nodes.
const FREE: u32 = 1 << 30;

/// Flag in the level of a node that a walk has visited. Every walk removes it again.
const MARK: u32 = 1 << 31;

/// Number of slots of a new table.
const FIRST_SLOTS: usize = 1 << 12;

/// Maximum number of nodes: an edge to a node takes 31 bits, and the cache needs the last one.
pub const MAX_NODES: u64 = 1 << 30;

/// Number of results computed between two checks of the deadline; they take about a millisecond.
const CHECK_INTERVAL: u32 = 1 << 15;

/// An edge: twice the number of its target node, plus one if it is negated. Node 0 is the constant
/// true.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Link(u32);

impl Link {
    /// The constant true.
    pub const TRUE: Self = Self(0);
    /// The constant false.
    pub const FALSE: Self = Self(1);

    pub fn to(node: u32) -> Self {
        Self(node << 1)
    }

    /// Number of the target node.
    pub fn node(self) -> u32 {
        self.0 >> 1
    }

    pub fn is_negated(self) -> bool {
        self.0 & 1 == 1
    }

    pub fn negated(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// Returns the edge, negated if `negate`.
    pub fn flipped(self, negate: bool) -> Self {
        Self(self.0 ^ u32::from(negate))
    }

    /// Returns the edge to the same node that is not negated.
    pub fn plain(self) -> Self {
        Self(self.0 & !1)
    }

    fn sign(self) -> u32 {
        self.0 & 1
    }
}

/// A decision node. Its high edge is not negated.
#[derive(Debug, Clone, Copy)]
struct Node {
    level: u32,
    high: Link,
    low: Link,
}

/// Why an operation ended without a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// There is no room for another node.
    Full,
    /// The deadline has passed, or the command was interrupted.
    Late,
}

/// Operations whose results the cache holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operation {
    And,
    Xor,
    Exists,
    Restrict,
    Rename,
}

/// Operands of an operation as the key of a cache entry. Edges leave the topmost bit of each number
/// free. It is set in the third if that is the set of bits of a fused product, and in the first if
/// the third is an [`Operation`]; otherwise the operands are those of a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Key([u32; 3]);

const FLAG: u32 = 1 << 31;

impl Key {
    const NONE: Self = Self([u32::MAX; 3]);

    fn of(operation: Operation, a: Link, b: Link) -> Self {
        Self([a.0 | FLAG, b.0, operation as u32])
    }

    fn product(a: Link, b: Link, bits: Link) -> Self {
        Self([a.0, b.0, bits.0 | FLAG])
    }

    fn choice(c: Link, a: Link, b: Link) -> Self {
        Self([c.0, a.0, b.0])
    }
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    key: Key,
    result: Link,
}

/// Mixes three numbers into 64 bits; each of these depends on all bits of the numbers.
fn mix(a: u32, b: u32, c: u32) -> u64 {
    let both =
        (u64::from(a) << 32 | u64::from(b)) ^ u64::from(c).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let product = u128::from(both ^ 0x2545_f491_4f6c_dd1d) * 0xd6e8_feb8_6659_fd93;
    product as u64 ^ (product >> 64) as u64
}

/// All nodes of a kernel.
#[derive(Debug)]
pub struct Store {
    nodes: Vec<Node>,
    /// First free place in `nodes`; the others are linked by their high edges. 0 at the end.
    free: u32,
    /// Number of nodes except the constant.
    count: usize,
    /// Unique table: the hash of a node in the upper half, its number in the lower; 0 if empty.
    slots: Vec<u64>,
    cache: Vec<Entry>,
    /// Maximum number of nodes.
    capacity: usize,
    /// Bit of each level.
    bits: Vec<Bit>,
    /// Level of each bit.
    levels: Vec<u32>,
    order: Order,
    /// Limits of the current operation, and results to compute until its next check of time.
    limits: Limits,
    until_check: u32,
    lateness: Option<Limit>,
    /// Number of nodes created so far.
    created: u64,
}

impl Store {
    /// Creates a store for at most `capacity` nodes, with this number of cache entries, a power of
    /// two.
    pub fn new(order: &Order, capacity: usize, entries: usize) -> Self {
        let mut store = Self {
            nodes: vec![Node {
                level: BOTTOM,
                high: Link::TRUE,
                low: Link::TRUE,
            }],
            free: 0,
            count: 0,
            slots: vec![0; FIRST_SLOTS],
            cache: vec![
                Entry {
                    key: Key::NONE,
                    result: Link::TRUE
                };
                entries
            ],
            capacity,
            bits: Vec::new(),
            levels: Vec::new(),
            order: order.clone(),
            limits: Limits::default(),
            until_check: CHECK_INTERVAL,
            lateness: None,
            created: 0,
        };
        store.set_order(order);
        store
    }

    fn set_order(&mut self, order: &Order) {
        self.order = order.clone();
        let pairs = order.pairs().iter();
        self.bits = pairs
            .flat_map(|pair| [Bit(2 * pair), Bit(2 * pair).primed()])
            .collect();
        self.levels = vec![0; self.bits.len()];
        for (level, bit) in self.bits.iter().enumerate() {
            self.levels[bit.index()] = level as u32;
        }
    }

    pub fn order(&self) -> &Order {
        &self.order
    }

    /// Number of nodes, including those that nothing refers to.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of bytes of the nodes and of their table, without the cache.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.slots.len() * size_of::<u64>()
    }

    /// Number of nodes created so far.
    pub fn created(&self) -> u64 {
        self.created
    }

    /// Sets the limits of the next operations.
    pub fn set_limits(&mut self, limits: &Limits) {
        self.limits = *limits;
    }

    /// Why the last operation that ended late did so.
    pub fn lateness(&self) -> Option<Limit> {
        self.lateness
    }

    pub fn level(&self, link: Link) -> u32 {
        self.nodes[link.node() as usize].level
    }

    pub fn bit(&self, link: Link) -> Option<Bit> {
        self.bits.get(self.level(link) as usize).copied()
    }

    /// Returns the cofactors for the values 1 and 0 of the bit that the target tests.
    pub fn children(&self, link: Link) -> (Link, Link) {
        let node = &self.nodes[link.node() as usize];
        (
            Link(node.high.0 ^ link.sign()),
            Link(node.low.0 ^ link.sign()),
        )
    }

    /// Returns the cofactors for a level that is not below the target's.
    fn cofactors(&self, link: Link, level: u32) -> (Link, Link) {
        let node = &self.nodes[link.node() as usize];
        if node.level == level {
            (
                Link(node.high.0 ^ link.sign()),
                Link(node.low.0 ^ link.sign()),
            )
        } else {
            (link, link)
        }
    }

    /// Returns the function that a bit is 1.
    pub fn literal(&mut self, bit: Bit) -> Result<Link, Stop> {
        let level = self.levels[bit.index()];
        self.make(level, Link::TRUE, Link::FALSE)
    }

    /// Returns the edge to the node with these children, creating it if it does not exist.
    fn make(&mut self, level: u32, high: Link, low: Link) -> Result<Link, Stop> {
        if high == low {
            return Ok(high);
        }
        let sign = high.sign();
        let (high, low) = (Link(high.0 ^ sign), Link(low.0 ^ sign));
        let hash = (mix(high.0, low.0, level) >> 32) as u32;
        let mask = self.slots.len() - 1;
        let mut place = hash as usize & mask;
        loop {
            let slot = self.slots[place];
            if slot == 0 {
                break;
            }
            if (slot >> 32) as u32 == hash {
                let node = &self.nodes[slot as u32 as usize];
                if node.high == high && node.low == low && node.level == level {
                    return Ok(Link((slot as u32) << 1 | sign));
                }
            }
            place = (place + 1) & mask;
        }
        let number = self.add(Node { level, high, low })?;
        self.slots[place] = u64::from(hash) << 32 | u64::from(number);
        // At most seven of eight slots are used.
        if self.count >= self.slots.len() / 8 * 7 {
            self.grow();
        }
        Ok(Link(number << 1 | sign))
    }

    /// Stores a new node and returns its number.
    fn add(&mut self, node: Node) -> Result<u32, Stop> {
        if self.count >= self.capacity {
            return Err(Stop::Full);
        }
        self.count += 1;
        self.created += 1;
        if self.free != 0 {
            let number = self.free;
            let place = &mut self.nodes[number as usize];
            self.free = place.high.node();
            *place = node;
            return Ok(number);
        }
        if self.nodes.len() == self.nodes.capacity() {
            let more = self.nodes.len().min(self.capacity + 1 - self.nodes.len());
            self.nodes.reserve_exact(more.max(1));
        }
        self.nodes.push(node);
        Ok(self.nodes.len() as u32 - 1)
    }

    /// Doubles the number of slots.
    #[cold]
    fn grow(&mut self) {
        let slots = std::mem::take(&mut self.slots);
        self.slots = vec![0; 2 * slots.len()];
        for slot in slots.into_iter().filter(|slot| *slot != 0) {
            self.place(slot);
        }
    }

    /// Writes a slot to the table, which must have room and not contain its node.
    fn place(&mut self, slot: u64) {
        let mask = self.slots.len() - 1;
        let mut place = (slot >> 32) as usize & mask;
        while self.slots[place] != 0 {
            place = (place + 1) & mask;
        }
        self.slots[place] = slot;
    }

    fn cached(&self, key: Key) -> (usize, Option<Link>) {
        let Key([a, b, c]) = key;
        let place = (mix(a, b, c) >> 32) as usize & (self.cache.len() - 1);
        let entry = &self.cache[place];
        (place, (entry.key == key).then_some(entry.result))
    }

    fn remember(&mut self, place: usize, key: Key, result: Link) -> Link {
        self.cache[place] = Entry { key, result };
        result
    }

    /// Counts a result that has to be computed; checks the deadline from time to time.
    fn tick(&mut self) -> Result<(), Stop> {
        self.until_check -= 1;
        if self.until_check == 0 {
            self.until_check = CHECK_INTERVAL;
            if let Err(limit) = self.limits.check_time() {
                self.lateness = Some(limit);
                return Err(Stop::Late);
            }
        }
        Ok(())
    }

    /// `a ∧ b`
    pub fn and(&mut self, a: Link, b: Link) -> Result<Link, Stop> {
        if a == b || b == Link::TRUE {
            return Ok(a);
        }
        if a == Link::TRUE {
            return Ok(b);
        }
        if a == Link::FALSE || b == Link::FALSE || a == b.negated() {
            return Ok(Link::FALSE);
        }
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let key = Key::of(Operation::And, a, b);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known);
        }
        self.tick()?;
        let level = self.level(a).min(self.level(b));
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let high = self.and(a_high, b_high)?;
        let low = self.and(a_low, b_low)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result))
    }

    /// `a ∨ b`
    pub fn or(&mut self, a: Link, b: Link) -> Result<Link, Stop> {
        Ok(self.and(a.negated(), b.negated())?.negated())
    }

    /// `a ⊕ b`
    pub fn xor(&mut self, a: Link, b: Link) -> Result<Link, Stop> {
        let negate = a.is_negated() != b.is_negated();
        let (a, b) = (a.plain(), b.plain());
        if a == b {
            return Ok(Link::FALSE.flipped(negate));
        }
        if a == Link::TRUE {
            return Ok(b.flipped(!negate));
        }
        if b == Link::TRUE {
            return Ok(a.flipped(!negate));
        }
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let key = Key::of(Operation::Xor, a, b);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        let level = self.level(a).min(self.level(b));
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let high = self.xor(a_high, b_high)?;
        let low = self.xor(a_low, b_low)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// `(c ∧ a) ∨ (¬c ∧ b)`
    pub fn choice(&mut self, c: Link, a: Link, b: Link) -> Result<Link, Stop> {
        let (c, a, b) = if c.is_negated() {
            (c.negated(), b, a)
        } else {
            (c, a, b)
        };
        if c == Link::TRUE || a == b {
            return Ok(a);
        }
        if a == c || a == Link::TRUE {
            return self.or(c, b);
        }
        if a == c.negated() || a == Link::FALSE {
            return self.and(c.negated(), b);
        }
        if b == c || b == Link::FALSE {
            return self.and(c, a);
        }
        if b == c.negated() || b == Link::TRUE {
            return self.or(c.negated(), a);
        }
        if a == b.negated() {
            return self.xor(c, b);
        }
        let negate = a.is_negated();
        let (a, b) = (a.flipped(negate), b.flipped(negate));
        let key = Key::choice(c, a, b);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        let level = self.level(c).min(self.level(a)).min(self.level(b));
        let (c_high, c_low) = self.cofactors(c, level);
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let high = self.choice(c_high, a_high, b_high)?;
        let low = self.choice(c_low, a_low, b_low)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// Returns a conjunction of positive literals without those above `level`.
    fn below(&self, mut bits: Link, level: u32) -> Link {
        loop {
            let node = &self.nodes[bits.node() as usize];
            if node.level >= level {
                return bits;
            }
            bits = node.high;
        }
    }

    /// `∃ bits. a`, for a conjunction of positive literals `bits`.
    pub fn exists(&mut self, a: Link, bits: Link) -> Result<Link, Stop> {
        let level = self.level(a);
        let bits = self.below(bits, level);
        if bits == Link::TRUE || level == BOTTOM {
            return Ok(a);
        }
        let key = Key::of(Operation::Exists, a, bits);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known);
        }
        self.tick()?;
        let (a_high, a_low) = self.children(a);
        let result = if self.level(bits) == level {
            let rest = self.children(bits).0;
            let high = self.exists(a_high, rest)?;
            if high == Link::TRUE {
                high
            } else {
                let low = self.exists(a_low, rest)?;
                self.or(high, low)?
            }
        } else {
            let high = self.exists(a_high, bits)?;
            let low = self.exists(a_low, bits)?;
            self.make(level, high, low)?
        };
        Ok(self.remember(place, key, result))
    }

    /// `∃ bits. a ∧ b`, for a conjunction of positive literals `bits`.
    pub fn product(&mut self, a: Link, b: Link, bits: Link) -> Result<Link, Stop> {
        if a == b || b == Link::TRUE {
            return self.exists(a, bits);
        }
        if a == Link::TRUE {
            return self.exists(b, bits);
        }
        if a == Link::FALSE || b == Link::FALSE || a == b.negated() {
            return Ok(Link::FALSE);
        }
        let level = self.level(a).min(self.level(b));
        let bits = self.below(bits, level);
        if bits == Link::TRUE {
            return self.and(a, b);
        }
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let key = Key::product(a, b, bits);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known);
        }
        self.tick()?;
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let result = if self.level(bits) == level {
            let rest = self.children(bits).0;
            let high = self.product(a_high, b_high, rest)?;
            if high == Link::TRUE {
                high
            } else {
                let low = self.product(a_low, b_low, rest)?;
                self.or(high, low)?
            }
        } else {
            let high = self.product(a_high, b_high, bits)?;
            let low = self.product(a_low, b_low, bits)?;
            self.make(level, high, low)?
        };
        Ok(self.remember(place, key, result))
    }

    /// Fixes the bits of `values`, a conjunction of literals, to the values that satisfy it.
    pub fn restrict(&mut self, a: Link, values: Link) -> Result<Link, Stop> {
        let negate = a.is_negated();
        let mut a = a.plain();
        let mut values = values;
        loop {
            let (level, fixed) = (self.level(a), self.level(values));
            if values == Link::TRUE || level == BOTTOM {
                return Ok(a.flipped(negate));
            }
            if fixed > level {
                break;
            }
            let (high, low) = self.children(values);
            let positive = high != Link::FALSE;
            values = if positive { high } else { low };
            if fixed == level {
                let (a_high, a_low) = self.children(a);
                return self
                    .restrict(if positive { a_high } else { a_low }, values)
                    .map(|result| result.flipped(negate));
            }
        }
        let key = Key::of(Operation::Restrict, a, values);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        let level = self.level(a);
        let (a_high, a_low) = self.children(a);
        a = self.restrict(a_high, values)?;
        let low = self.restrict(a_low, values)?;
        let result = self.make(level, a, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// Renames current bits to primed bits (`to_primed`), or primed bits to current bits. The
    /// function must not depend on both bits of a pair; the twins are adjacent, so the order of the
    /// levels stays.
    pub fn rename(&mut self, a: Link, to_primed: bool) -> Result<Link, Stop> {
        let negate = a.is_negated();
        let a = a.plain();
        if a == Link::TRUE {
            return Ok(a.flipped(negate));
        }
        let key = Key::of(Operation::Rename, a, Link::FALSE.flipped(to_primed));
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        // The current bit of a pair has an even level, its twin the next one.
        let level = self.level(a) & !1 | u32::from(to_primed);
        let (a_high, a_low) = self.children(a);
        let high = self.rename(a_high, to_primed)?;
        let low = self.rename(a_low, to_primed)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// Marks the nodes that `link` reaches and that have no mark yet; calls `visit` for each of
    /// them, after its children, the high one first.
    fn mark(&mut self, link: Link, visit: &mut impl FnMut(u32)) {
        let node = link.node();
        let place = &mut self.nodes[node as usize];
        if place.level & MARK != 0 || place.level == BOTTOM {
            return;
        }
        place.level |= MARK;
        let (high, low) = (place.high, place.low);
        self.mark(high, visit);
        self.mark(low, visit);
        visit(node);
    }

    /// Calls `visit` with every node that the links reach, children first, the high one before the
    /// low one: with the edge to it, its bit and its edges. A node is visited once.
    pub fn walk(
        &mut self,
        links: impl IntoIterator<Item = Link>,
        visit: &mut impl FnMut(Link, Bit, Link, Link),
    ) {
        let mut visited = Vec::new();
        for link in links {
            self.mark(link, &mut |node| visited.push(node));
        }
        for node in visited {
            let place = &mut self.nodes[node as usize];
            place.level &= !MARK;
            let Node { level, high, low } = *place;
            visit(Link::to(node), self.bits[level as usize], high, low);
        }
    }

    /// Removes all nodes that the roots do not reach, and all results from the cache.
    pub fn collect(&mut self, roots: impl IntoIterator<Item = Link>) {
        for root in roots {
            self.mark(root, &mut |_| ());
        }
        self.cache.fill(Entry {
            key: Key::NONE,
            result: Link::TRUE,
        });
        let slots = std::mem::take(&mut self.slots);
        self.slots = vec![0; slots.len()];
        for slot in slots {
            if slot != 0 && self.nodes[slot as u32 as usize].level & MARK != 0 {
                self.place(slot);
            }
        }
        self.free = 0;
        self.count = 0;
        for number in (1..self.nodes.len() as u32).rev() {
            let node = &mut self.nodes[number as usize];
            if node.level & MARK != 0 {
                node.level &= !MARK;
                self.count += 1;
            } else {
                node.level = FREE;
                node.high = Link::to(self.free);
                self.free = number;
            }
        }
    }

    /// Returns the nodes that the roots reach as plain data, with the roots in the given order.
    pub fn diagram(&mut self, roots: &[Link]) -> Diagram {
        let mut nodes = Vec::new();
        let mut places: FxHashMap<u32, usize> = FxHashMap::default();
        self.walk(roots.iter().copied(), &mut |link, bit, high, low| {
            let (high, low) = (exported(&places, high), exported(&places, low));
            places.insert(link.node(), nodes.len());
            nodes.push(DiagramNode { bit, high, low });
        });
        let roots = roots.iter().map(|root| exported(&places, *root)).collect();
        Diagram { nodes, roots }
    }

    /// Replaces all nodes by those of `diagram`, which respects `order` and is not larger than the
    /// store. Returns its roots.
    pub fn replace(&mut self, diagram: &Diagram, order: &Order) -> Vec<Link> {
        self.collect([]);
        self.free = 0;
        self.nodes.truncate(1);
        self.set_order(order);
        let created = self.created;
        let mut links: Vec<Link> = Vec::with_capacity(diagram.nodes.len());
        let link = |links: &[Link], edge: Edge| match edge.node() {
            Some(node) => links[node].flipped(edge.is_negated()),
            None => Link::TRUE.flipped(edge == Edge::FALSE),
        };
        for node in &diagram.nodes {
            let level = self.levels[node.bit.index()];
            let made = self.make(level, link(&links, node.high), link(&links, node.low));
            links.push(made.expect("a smaller diagram has no room; please report this"));
        }
        self.created = created;
        let roots = diagram.roots.iter();
        roots.map(|root| link(&links, *root)).collect()
    }
}

/// Returns the edge of a diagram; `places` holds the index of each node there.
fn exported(places: &FxHashMap<u32, usize>, link: Link) -> Edge {
    let edge = if link.node() == 0 {
        Edge::TRUE
    } else {
        Edge::to(places[&link.node()])
    };
    edge.flipped(link.is_negated())
}
