//! Computes the output bits of a step in few walks.
//!
//! The functions of a controller's output bits test mostly the same signals, so evaluating each
//! function by itself would repeat these tests. A walk makes every test once for many bits. It
//! moves from place to place; a place either tests a signal and continues at one of two places, or
//! writes output bits whose values are decided. A place is identified by the list of undecided bits
//! with their residual functions, so walks that reach the same list share the rest. This is like
//! one decision diagram for all bits. If one output bit depends on another, the other is decided
//! first.
//!
//! In the worst case there are exponentially more places than nodes in the bits' decision diagrams.
//! A walk therefore takes further bits only while the number of its places stays below a limit that
//! is proportional to the number of its bits. The remaining bits go into another walk. A single bit
//! takes as many places as its diagram has nodes.

use linewright_solver::game::StrategyFunctions;
use linewright_solver::symbolic::{Bit, Diagram, DiagramNode, Edge, Order};
use std::collections::HashMap;

/// A place of a walk. Place 0 is the end; the others are numbered from 1.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Place {
    /// Continues according to the value of a signal.
    Test { bit: Bit, high: usize, low: usize },
    /// Sets these output bits (in this step, not the previous one) to 1, and continues.
    Write { bits: Vec<Bit>, next: usize },
}

/// The walks of a controller.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Walks {
    /// The places, in depth-first order, so that successive places of a walk are mostly adjacent.
    pub places: Vec<Place>,
    /// The starts of the walks of a step, in order: one list for step 0, then one list for each
    /// mode, goal by goal.
    pub starts: Vec<Vec<usize>>,
}

/// Undecided bits with their functions. A function can read only those undecided bits that come
/// before its own bit.
type Undecided = Vec<(Bit, Edge)>;

impl Walks {
    /// Computes the walks of a controller's functions.
    pub fn of(controls: &StrategyFunctions) -> Self {
        let modes = controls.goals.iter().flat_map(|g| &g.modes);
        let lists: Vec<&[(Bit, Edge)]> = std::iter::once(&controls.first)
            .chain(modes.map(|m| &m.outputs))
            .map(Vec::as_slice)
            .collect();
        Self::of_lists(&controls.diagram, &controls.order, &lists)
    }

    /// Like `of`, for lists of output bits with their functions; all lists have the same length and
    /// the same order of bits.
    fn of_lists(diagram: &Diagram, order: &Order, lists: &[&[(Bit, Edge)]]) -> Self {
        let bits = lists.first().map_or(0, |list| list.len());
        let decisions = diagram.nodes.len();
        let mut walks = Self {
            places: Vec::new(),
            starts: vec![Vec::new(); lists.len()],
        };
        let mut builder = WalkBuilder::new(diagram, order);
        let mut begin = 0;
        while begin < bits {
            let part = |count: usize| lists.iter().map(move |list| &list[begin..begin + count]);
            // A walk always takes one bit. It takes further bits only while the number of its
            // places stays within the share of its bits in all decisions.
            let mut taken = builder
                .walks(part(1), usize::MAX)
                .expect("a walk for a single bit reached a limit; please report this");
            let mut count = 1;
            while begin + count < bits && order.pairs().len() <= MAX_PAIRS {
                let max_places = (decisions * (count + 1) / bits).max(MIN_PLACES);
                let Some(more) = builder.walks(part(count + 1), max_places) else {
                    break;
                };
                taken = more;
                count += 1;
            }
            walks.append(taken);
            begin += count;
        }
        walks
    }

    /// Appends walks for further bits.
    fn append(&mut self, (places, starts): (Vec<Place>, Vec<usize>)) {
        let first = self.places.len();
        let moved = |place: usize| if place == 0 { 0 } else { first + place };
        self.places
            .extend(places.into_iter().map(|place| match place {
                Place::Test { bit, high, low } => Place::Test {
                    bit,
                    high: moved(high),
                    low: moved(low),
                },
                Place::Write { bits, next } => Place::Write {
                    bits,
                    next: moved(next),
                },
            }));
        for (list, start) in self.starts.iter_mut().zip(starts) {
            // A walk that begins at its end writes no bits, so it is omitted.
            list.extend((start != 0).then(|| moved(start)));
        }
    }
}

/// Maximum number of bit pairs for walks of several bits, which bounds the recursion over the bits
/// of a function.
const MAX_PAIRS: usize = 4096;

/// Number of places that a walk can always use.
const MIN_PLACES: usize = 256;

/// Maximum ratio of the decisions that are created while walks are computed to the decisions of the
/// functions.
const MAX_NEW_NODES: usize = 4;

struct WalkBuilder {
    /// Decisions of the functions, then the decisions that were created for walks.
    nodes: Vec<DiagramNode>,
    unique: HashMap<DiagramNode, usize>,
    restricted: HashMap<(Edge, Bit, bool), Edge>,
    /// Position of each pair in the order.
    positions: Vec<u16>,
    places: Vec<Place>,
    test_places: HashMap<Undecided, usize>,
    write_places: HashMap<Place, usize>,
    /// Places whose successors have not been computed.
    waiting: Vec<(usize, Undecided)>,
    max_nodes: usize,
    max_places: usize,
}

impl WalkBuilder {
    fn new(diagram: &Diagram, order: &Order) -> Self {
        let nodes = diagram.nodes.clone();
        let unique = nodes.iter().enumerate().map(|(i, n)| (*n, i)).collect();
        Self {
            positions: order.positions(),
            max_nodes: (1 + MAX_NEW_NODES) * nodes.len() + 1000,
            max_places: 0,
            nodes,
            unique,
            restricted: HashMap::new(),
            places: Vec::new(),
            test_places: HashMap::new(),
            write_places: HashMap::new(),
            waiting: Vec::new(),
        }
    }

    /// Computes the walks that decide these lists of bits, one walk per list. Returns the places
    /// and the start of each walk; `None` if more than `max_places` places or too many new
    /// decisions are needed.
    fn walks<'a>(
        &mut self,
        lists: impl Iterator<Item = &'a [(Bit, Edge)]>,
        max_places: usize,
    ) -> Option<(Vec<Place>, Vec<usize>)> {
        self.max_places = max_places;
        self.places.clear();
        self.test_places.clear();
        self.write_places.clear();
        self.waiting.clear();
        let mut starts = Vec::new();
        for list in lists {
            starts.push(self.place_of(list.to_vec())?);
            self.walk()?;
        }
        Some(self.finish(&starts))
    }

    /// Level of a bit in the order: bits with a lower level are tested earlier.
    fn level(&self, bit: Bit) -> u32 {
        let position = self.positions[usize::from(bit.pair())];
        2 * u32::from(position) + u32::from(bit.0 & 1)
    }

    fn top(&self, edge: Edge) -> Option<Bit> {
        edge.node().map(|n| self.nodes[n].bit)
    }

    /// Returns the place that decides this list of bits. Bits that are already decided are written
    /// first.
    fn place_of(&mut self, mut undecided: Undecided) -> Option<usize> {
        let mut put = Vec::new();
        while let Some(decided) = undecided.iter().position(|(_, edge)| edge.node().is_none()) {
            let (bit, edge) = undecided.remove(decided);
            if edge.is_negated() {
                put.push(bit);
            }
            self.assign(&mut undecided, bit, edge.is_negated())?;
        }
        let next = self.test_place(undecided)?;
        if put.is_empty() {
            return Some(next);
        }
        put.sort_unstable();
        let place = Place::Write { bits: put, next };
        if let Some(known) = self.write_places.get(&place) {
            return Some(*known);
        }
        self.places.push(place.clone());
        self.write_places.insert(place, self.places.len());
        Some(self.places.len())
    }

    fn test_place(&mut self, undecided: Undecided) -> Option<usize> {
        if undecided.is_empty() {
            return Some(0);
        }
        if let Some(known) = self.test_places.get(&undecided) {
            return Some(*known);
        }
        if self.places.len() >= self.max_places {
            return None;
        }
        // `walk` replaces this placeholder by a test.
        let place = Place::Write {
            bits: Vec::new(),
            next: 0,
        };
        self.places.push(place);
        self.test_places
            .insert(undecided.clone(), self.places.len());
        self.waiting.push((self.places.len(), undecided));
        Some(self.places.len())
    }

    /// Computes the successors of all waiting places.
    fn walk(&mut self) -> Option<()> {
        while let Some((place, undecided)) = self.waiting.pop() {
            // Only decided bits can be tested. The first undecided bit depends on decided bits
            // only, so there is always a bit to test.
            let testable = undecided
                .iter()
                .filter_map(|(_, edge)| self.top(*edge))
                .filter(|bit| undecided.iter().all(|(other, _)| other != bit));
            let bit = testable.min_by_key(|bit| self.level(*bit))?;
            let mut successors = [true, false].map(|value| (value, undecided.clone()));
            for (value, undecided) in &mut successors {
                self.assign(undecided, bit, *value)?;
            }
            let [(_, high), (_, low)] = successors;
            let (high, low) = (self.place_of(high)?, self.place_of(low)?);
            self.places[place - 1] = Place::Test { bit, high, low };
        }
        Some(())
    }

    /// Replaces all functions by their residuals for one value of a bit.
    fn assign(&mut self, undecided: &mut Undecided, bit: Bit, value: bool) -> Option<()> {
        for (_, edge) in undecided {
            *edge = self.restrict(*edge, bit, value)?;
        }
        Some(())
    }

    fn restrict(&mut self, edge: Edge, bit: Bit, value: bool) -> Option<Edge> {
        let Some(node) = edge.node() else {
            return Some(edge);
        };
        let node = self.nodes[node];
        if self.level(node.bit) > self.level(bit) {
            return Some(edge);
        }
        let negated = edge.is_negated();
        if node.bit == bit {
            let target = if value { node.high } else { node.low };
            return Some(target.flipped(negated));
        }
        let key = (edge.flipped(negated), bit, value);
        if let Some(known) = self.restricted.get(&key) {
            return Some(known.flipped(negated));
        }
        let high = self.restrict(node.high, bit, value)?;
        let low = self.restrict(node.low, bit, value)?;
        let made = self.decision(node.bit, high, low)?;
        self.restricted.insert(key, made);
        Some(made.flipped(negated))
    }

    fn decision(&mut self, bit: Bit, high: Edge, low: Edge) -> Option<Edge> {
        if high == low {
            return Some(high);
        }
        // The high edge is never negated, so equal functions share a node.
        let negated = high.is_negated();
        let node = DiagramNode {
            bit,
            high: high.flipped(negated),
            low: low.flipped(negated),
        };
        let index = match self.unique.get(&node) {
            Some(index) => *index,
            None if self.nodes.len() >= self.max_nodes => return None,
            None => {
                self.nodes.push(node);
                self.unique.insert(node, self.nodes.len() - 1);
                self.nodes.len() - 1
            }
        };
        Some(Edge::to(index).flipped(negated))
    }

    /// Numbers the places in depth-first order, low edge first, so that successive places of a walk
    /// are mostly adjacent in memory.
    fn finish(&self, starts: &[usize]) -> (Vec<Place>, Vec<usize>) {
        let mut numbers = vec![0; self.places.len() + 1];
        let mut order = Vec::new();
        for start in starts {
            let mut stack = vec![*start];
            while let Some(place) = stack.pop() {
                if place == 0 || numbers[place] != 0 {
                    continue;
                }
                order.push(place);
                numbers[place] = order.len();
                match &self.places[place - 1] {
                    Place::Test { high, low, .. } => stack.extend([*high, *low]),
                    Place::Write { next, .. } => stack.push(*next),
                }
            }
        }
        let places = order.iter().map(|place| match &self.places[place - 1] {
            Place::Test { bit, high, low } => Place::Test {
                bit: *bit,
                high: numbers[*high],
                low: numbers[*low],
            },
            Place::Write { bits, next } => Place::Write {
                bits: bits.clone(),
                next: numbers[*next],
            },
        });
        let starts = starts.iter().map(|s| numbers[*s]).collect();
        (places.collect(), starts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    const PAIRS: usize = 7;
    const OUTPUTS: usize = 4;

    /// Signals that an output can read: all signals of the previous step, and in this step those of
    /// inputs and of outputs before it.
    fn allowed(output: usize) -> Vec<Bit> {
        let inputs = PAIRS - OUTPUTS;
        (0..PAIRS)
            .flat_map(|pair| {
                let current = Bit(2 * pair as u16);
                [
                    Some(current),
                    (pair < inputs + output).then(|| current.primed()),
                ]
            })
            .flatten()
            .collect()
    }

    /// Builds a function over some bits: a disjunction of conjunctions, each of randomly chosen
    /// bits with random signs.
    fn function(builder: &mut WalkBuilder, bits: &mut [Bit], terms: &[Vec<(usize, bool)>]) -> Edge {
        bits.sort_by_key(|bit| builder.level(*bit));
        let terms: Vec<BTreeMap<usize, bool>> = terms
            .iter()
            .map(|term| term.iter().map(|(b, v)| (b % bits.len(), *v)).collect())
            .collect();
        build(builder, bits, 0, &terms)
    }

    fn build(
        builder: &mut WalkBuilder,
        bits: &[Bit],
        from: usize,
        terms: &[BTreeMap<usize, bool>],
    ) -> Edge {
        if terms.iter().any(BTreeMap::is_empty) {
            return Edge::TRUE;
        }
        if terms.is_empty() {
            return Edge::FALSE;
        }
        let [high, low] = [true, false].map(|value| {
            let left: Vec<_> = terms
                .iter()
                .filter(|t| t.get(&from).is_none_or(|wanted| *wanted == value))
                .map(|t| {
                    t.iter()
                        .filter(|(b, _)| **b != from)
                        .map(|(b, v)| (*b, *v))
                        .collect()
                })
                .collect();
            build(builder, bits, from + 1, &left)
        });
        builder.decision(bits[from], high, low).expect("no limit")
    }

    fn follow(walks: &Walks, list: usize, signals: &mut [bool]) {
        for start in &walks.starts[list] {
            let mut place = *start;
            while place != 0 {
                place = match &walks.places[place - 1] {
                    Place::Test { bit, high, low } if signals[bit.index()] => *high,
                    Place::Test { low, .. } => *low,
                    Place::Write { bits, next } => {
                        for bit in bits {
                            signals[bit.index()] = true;
                        }
                        *next
                    }
                };
            }
        }
    }

    type Terms = Vec<Vec<(usize, bool)>>;

    proptest! {
        #[test]
        fn walks_decide_as_the_functions_do(
            order in Just((0..PAIRS as u16).collect::<Vec<_>>()).prop_shuffle(),
            lists in prop::collection::vec(
                prop::collection::vec(
                    prop::collection::vec(prop::collection::vec((0..2 * PAIRS, any::<bool>()), 1..5), 0..6),
                    OUTPUTS..=OUTPUTS,
                ),
                1..4,
            ),
        ) {
            let lists: Vec<Vec<Terms>> = lists;
            let order = Order::new(order).expect("a permutation");
            let mut builder = WalkBuilder::new(&Diagram::default(), &order);
            builder.max_nodes = usize::MAX;
            let lists: Vec<Vec<(Bit, Edge)>> = lists
                .iter()
                .map(|functions| {
                    let outputs = functions.iter().enumerate();
                    outputs
                        .map(|(output, terms)| {
                            let bit = Bit(2 * (PAIRS - OUTPUTS + output) as u16).primed();
                            (bit, function(&mut builder, &mut allowed(output), terms))
                        })
                        .collect()
                })
                .collect();
            let diagram = Diagram { nodes: builder.nodes.clone(), roots: Vec::new() };
            let slices: Vec<&[(Bit, Edge)]> = lists.iter().map(Vec::as_slice).collect();
            let walks = Walks::of_lists(&diagram, &order, &slices);
            for (number, list) in lists.iter().enumerate() {
                let roots = list.iter().map(|(_, edge)| *edge).collect();
                let functions = Diagram { nodes: diagram.nodes.clone(), roots };
                for letter in 0..1_u32 << (2 * PAIRS - OUTPUTS) {
                    let mut signals = vec![false; 2 * PAIRS];
                    let outputs: Vec<usize> = list.iter().map(|(bit, _)| bit.index()).collect();
                    let free = (0..2 * PAIRS).filter(|s| !outputs.contains(s));
                    for (place, signal) in free.enumerate() {
                        signals[signal] = letter >> place & 1 == 1;
                    }
                    let mut walked = signals.clone();
                    follow(&walks, number, &mut walked);
                    for (index, (bit, _)) in list.iter().enumerate() {
                        signals[bit.index()] = functions.evaluate(index, &signals);
                    }
                    prop_assert_eq!(&walked, &signals);
                }
            }
        }
    }
}
