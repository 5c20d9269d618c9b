//! The nodes of all functions of a kernel: a unique table, a cache of results, and a collector.
//!
//! The layout follows Brace, Rudell and Bryant ("Efficient implementation of a BDD package", DAC
//! 1990): complement edges, a common unique table and a lossy cache. A node is twelve bytes. The
//! unique table is a list of slots apart from the nodes, with open addressing. Each slot also holds
//! the hash of its node, so that a lookup reads a node only if it is almost surely the right one,
//! and growing the table reads no nodes. Nodes carry no reference counts: a collection marks what
//! the given roots reach. So an operation writes no node that exists already.

use super::super::link::Link;
use super::super::{Bit, Diagram, DiagramNode, Order};
use super::operations::Key;
use linewright_core::deadline::{Deadline, StopReason};
use rustc_hash::FxHashMap;

/// Level of the constant, below every bit.
pub(super) const BOTTOM: u32 = (1 << 30) - 1;

/// Level of a free place in the list of nodes.
const FREE: u32 = 1 << 30;

/// Flag in the level of a node that a walk has visited. Every walk removes it again.
const MARK: u32 = 1 << 31;

/// Number of slots of a new table.
const FIRST_SLOTS: usize = 1 << 12;

/// Number of entries of a new cache. Small games need no more, and these fit into the processor's
/// caches.
const FIRST_ENTRIES: usize = 1 << 12;

/// Maximum number of nodes: an edge to a node takes 31 bits, and the cache needs the last one.
pub const MAX_NODES: u64 = 1 << 30;

/// Number of results computed between two checks of the deadline; they take about a millisecond.
const CHECK_INTERVAL: u64 = 1 << 15;

/// Units of work per created node. A node of this kernel is looked up in a common table and moved
/// when the order changes, and so takes about this many times as long as a node that is owned by a
/// single function.
const WORK_PER_NODE: u64 = 10;

/// Units of work per result that is not in the cache.
const WORK_PER_RESULT: u64 = 1;

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
    Late(StopReason),
    /// More work was done than allowed.
    Work,
    /// The operation takes long; another order may be worthwhile.
    Tedious,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    key: Key,
    result: Link,
}

impl Entry {
    /// No result.
    const NONE: Self = Self {
        key: Key::NONE,
        result: Link::TRUE,
    };
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
    /// Maximum number of entries of the cache.
    max_entries: usize,
    /// Maximum number of nodes.
    capacity: usize,
    /// Bit of each level.
    bits: Vec<Bit>,
    /// Level of each bit.
    levels: Vec<u32>,
    order: Order,
    /// Number of nodes created so far.
    created: u64,
    /// Number of results computed so far.
    computed: u64,
    /// Value of `computed` from which the limits are checked again.
    next_check: u64,
    /// Value of `computed` from which the limits are checked or the cache grows.
    next_stop: u64,
    /// Deadline of the current operation.
    deadline: Deadline,
    /// Work from which on the current operation ends; see [`Self::work`].
    max_work: u64,
    /// Work from which on the current operation is interrupted for reordering.
    patience: u64,
}

impl Store {
    /// Creates a store for at most `capacity` nodes and this number of cache entries, a power of
    /// two. The cache starts small, and reaches this size once half as many results have been
    /// computed.
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
            cache: vec![Entry::NONE; entries.min(FIRST_ENTRIES)],
            max_entries: entries,
            capacity,
            bits: Vec::new(),
            levels: Vec::new(),
            order: order.clone(),
            created: 0,
            computed: 0,
            next_check: CHECK_INTERVAL,
            next_stop: 0,
            deadline: Deadline::NONE,
            max_work: u64::MAX,
            patience: u64::MAX,
        };
        store.set_next_stop();
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
    #[cfg(test)]
    pub fn created(&self) -> u64 {
        self.created
    }

    /// Units of work of all operations so far.
    pub fn work(&self) -> u64 {
        WORK_PER_NODE * self.created + WORK_PER_RESULT * self.computed
    }

    /// Sets the deadline of the next operations, the work from which on they end, and the work from
    /// which on they are interrupted for reordering.
    pub fn set_limits(&mut self, deadline: Deadline, max_work: u64, patience: u64) {
        self.deadline = deadline;
        self.max_work = max_work;
        self.patience = patience;
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
        let negate = link.is_negated();
        (node.high.flipped(negate), node.low.flipped(negate))
    }

    /// Returns the cofactors for a level that is not below the target's.
    pub(super) fn cofactors(&self, link: Link, level: u32) -> (Link, Link) {
        if self.level(link) == level {
            self.children(link)
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
    pub(super) fn make(&mut self, level: u32, high: Link, low: Link) -> Result<Link, Stop> {
        if high == low {
            return Ok(high);
        }
        let negate = high.is_negated();
        let (high, low) = (high.flipped(negate), low.flipped(negate));
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
                    return Ok(Link::to(slot as u32).flipped(negate));
                }
            }
            place = (place + 1) & mask;
        }
        // At most seven of eight slots are used.
        let is_last = self.count + 1 >= self.slots.len() / 8 * 7;
        if is_last {
            self.check_room(2 * self.slots.len() * size_of::<u64>())?;
        }
        let number = self.add(Node { level, high, low })?;
        self.slots[place] = u64::from(hash) << 32 | u64::from(number);
        if is_last {
            self.grow();
        }
        Ok(Link::to(number).flipped(negate))
    }

    /// Stores a new node and returns its number.
    fn add(&mut self, node: Node) -> Result<u32, Stop> {
        if self.count >= self.capacity {
            return Err(Stop::Full);
        }
        if self.free != 0 {
            let number = self.free;
            let place = &mut self.nodes[number as usize];
            self.free = place.high.node();
            *place = node;
            self.count += 1;
            self.created += 1;
            return Ok(number);
        }
        if self.nodes.len() == self.nodes.capacity() {
            let more = self.nodes.len().min(self.capacity + 1 - self.nodes.len());
            self.check_room(more * size_of::<Node>())?;
            self.nodes.reserve_exact(more.max(1));
        }
        self.nodes.push(node);
        self.count += 1;
        self.created += 1;
        Ok(self.nodes.len() as u32 - 1)
    }

    /// Returns an error if the process may not take this many more bytes.
    fn check_room(&self, bytes: usize) -> Result<(), Stop> {
        if bytes as u64 > self.deadline.memory_left() {
            return Err(Stop::Full);
        }
        Ok(())
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

    pub(super) fn cached(&self, key: Key) -> (usize, Option<Link>) {
        let Key([a, b, c]) = key;
        let place = (mix(a, b, c) >> 32) as usize & (self.cache.len() - 1);
        let entry = &self.cache[place];
        (place, (entry.key == key).then_some(entry.result))
    }

    pub(super) fn remember(&mut self, place: usize, key: Key, result: Link) -> Link {
        self.cache[place] = Entry { key, result };
        result
    }

    /// Counts a result that has to be computed; checks the limits from time to time.
    pub(super) fn tick(&mut self) -> Result<(), Stop> {
        self.computed += 1;
        if self.computed >= self.next_stop {
            return self.pause();
        }
        Ok(())
    }

    /// Lets the cache grow, and checks the limits, if either is due.
    #[cold]
    fn pause(&mut self) -> Result<(), Stop> {
        let has_room = self.cache.len() < self.max_entries;
        if has_room && 2 * self.computed >= self.cache.len() as u64 {
            self.grow_cache();
        }
        let is_due = self.computed >= self.next_check;
        if is_due {
            self.next_check = self.computed + CHECK_INTERVAL;
        }
        self.set_next_stop();
        if is_due {
            self.deadline.check().map_err(Stop::Late)?;
            if self.work() > self.max_work {
                return Err(Stop::Work);
            }
            if self.work() > self.patience {
                return Err(Stop::Tedious);
            }
        }
        Ok(())
    }

    fn set_next_stop(&mut self) {
        let growth = self.cache.len() as u64 / 2;
        self.next_stop = if self.cache.len() < self.max_entries {
            self.next_check.min(growth)
        } else {
            self.next_check
        };
    }

    /// Doubles the cache. Operations in progress still store their results at the old places, where
    /// nobody finds them.
    fn grow_cache(&mut self) {
        let larger = vec![Entry::NONE; 2 * self.cache.len()];
        let entries = std::mem::replace(&mut self.cache, larger).into_iter();
        for entry in entries.filter(|entry| entry.key != Key::NONE) {
            let (place, _) = self.cached(entry.key);
            self.cache[place] = entry;
        }
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
        self.cache.fill(Entry::NONE);
        // The table is cleared in place: the pages of a new one would have to be mapped first.
        let is_live =
            |slot: &u64| *slot != 0 && self.nodes[*slot as u32 as usize].level & MARK != 0;
        let live: Vec<u64> = self.slots.iter().copied().filter(is_live).collect();
        self.slots.fill(0);
        for slot in live {
            self.place(slot);
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
            let [high, low] = [high, low].map(|link| link.export(|node| places[&node]));
            places.insert(link.node(), nodes.len());
            nodes.push(DiagramNode { bit, high, low });
        });
        let roots = roots.iter().map(|root| root.export(|node| places[&node]));
        let roots = roots.collect();
        Diagram { nodes, roots }
    }

    /// Replaces all nodes by those of `diagram`, which respects `order` and is not larger than the
    /// store. Returns its roots.
    pub fn replace(&mut self, diagram: &Diagram, order: &Order) -> Vec<Link> {
        // Nothing has to grow.
        self.deadline = Deadline::NONE;
        self.collect([]);
        self.free = 0;
        self.nodes.truncate(1);
        self.set_order(order);
        let created = self.created;
        let mut links: Vec<Link> = Vec::with_capacity(diagram.nodes.len());
        for node in &diagram.nodes {
            let level = self.levels[node.bit.index()];
            let [high, low] = [node.high, node.low].map(|e| Link::import(e, |node| links[node]));
            let made = self.make(level, high, low);
            links.push(made.expect("a smaller diagram has no room; please report this"));
        }
        self.created = created;
        let roots = diagram.roots.iter();
        roots
            .map(|root| Link::import(*root, |node| links[node]))
            .collect()
    }
}
