//! Computes the output bits of a step in few walks.
//!
//! The functions of a controller's output bits test largely the same signals: each would start with
//! the tests of those before it. A walk makes every test once for many bits. It moves from place to
//! place; a place either tests a signal and continues at one of two places, or writes output bits
//! that are decided by then. A place is identified by the list of undecided bits with their
//! residual functions, so walks that reach the same list share the rest. This is like a decision
//! diagram of all bits together, except for the order of the bits, in which a bit is decided before
//! it is tested.
//!
//! In the worst case there are exponentially more places than decisions. So a walk takes as many
//! bits as fit into their share of places, and the remaining bits go into another walk. A single
//! bit takes as many places as its function has decisions.

use linewright_solver::game::Controls;
use linewright_solver::symbolic::{Bit, Diagram, DiagramNode, Edge, Order};
use std::collections::HashMap;

/// A place of a walk. Place 0 is the end; the others are numbered from 1.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Place {
    /// Continues according to the value of a signal.
    Ask { bit: Bit, high: usize, low: usize },
    /// Sets these output bits, all of them next bits, and continues.
    Put { bits: Vec<Bit>, next: usize },
}

/// The walks of a controller.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Walks {
    /// The places; adjacent places of a walk are adjacent here.
    pub places: Vec<Place>,
    /// Starts of the walks of a step, one after the other: those of step 0, then those of all
    /// modes, goal by goal.
    pub starts: Vec<Vec<usize>>,
}

/// Undecided bits with their functions, in an order in which they may read each other.
type Open = Vec<(Bit, Edge)>;

impl Walks {
    /// Computes the walks of a controller's functions.
    pub fn of(controls: &Controls) -> Self {
        let modes = controls.goals.iter().flat_map(|g| &g.modes);
        let lists: Vec<&[(Bit, Edge)]> = std::iter::once(&controls.first)
            .chain(modes.map(|m| &m.outputs))
            .map(Vec::as_slice)
            .collect();
        Self::of_lists(&controls.diagram, &controls.order, &lists)
    }

    /// Like `of`, for lists of output bits of equal length, with their functions in this order.
    fn of_lists(diagram: &Diagram, order: &Order, lists: &[&[(Bit, Edge)]]) -> Self {
        let bits = lists.first().map_or(0, |list| list.len());
        let decisions = diagram.nodes.len();
        let mut walks = Self {
            places: Vec::new(),
            starts: vec![Vec::new(); lists.len()],
        };
        let mut maker = Maker::new(diagram, order);
        let mut begin = 0;
        while begin < bits {
            let part = |count: usize| lists.iter().map(move |list| &list[begin..begin + count]);
            // A single bit is always taken; the remaining bits share the remaining places.
            let mut taken = maker
                .walks(part(1), usize::MAX)
                .expect("a single bit knows of no others; please report this");
            let mut count = 1;
            while begin + count < bits && order.pairs().len() <= MOST_PAIRS {
                let most = (decisions * (count + 1) / bits).max(SMALL);
                let Some(more) = maker.walks(part(count + 1), most) else {
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
                Place::Ask { bit, high, low } => Place::Ask {
                    bit,
                    high: moved(high),
                    low: moved(low),
                },
                Place::Put { bits, next } => Place::Put {
                    bits,
                    next: moved(next),
                },
            }));
        for (list, start) in self.starts.iter_mut().zip(starts) {
            // A walk that begins at its end has nothing to do.
            list.extend((start != 0).then(|| moved(start)));
        }
    }
}

/// Maximum number of bit pairs for walks of several bits, since functions are followed recursively
/// bit by bit.
const MOST_PAIRS: usize = 4096;

/// Number of places that is always acceptable.
const SMALL: usize = 256;

/// Maximum ratio of new decisions, which arise while walks are searched, to those of the functions.
const MOST_NEW_NODES: usize = 4;

struct Maker {
    /// Decisions of the functions, and new ones.
    nodes: Vec<DiagramNode>,
    unique: HashMap<DiagramNode, usize>,
    restricted: HashMap<(Edge, Bit, bool), Edge>,
    /// Position of each pair in the order.
    positions: Vec<u16>,
    places: Vec<Place>,
    asking: HashMap<Open, usize>,
    putting: HashMap<Place, usize>,
    /// Known places from which the walk has not continued.
    waiting: Vec<(usize, Open)>,
    most_nodes: usize,
    most_places: usize,
}

impl Maker {
    fn new(diagram: &Diagram, order: &Order) -> Self {
        let nodes = diagram.nodes.clone();
        let unique = nodes.iter().enumerate().map(|(i, n)| (*n, i)).collect();
        Self {
            positions: order.positions(),
            most_nodes: (1 + MOST_NEW_NODES) * nodes.len() + 1000,
            most_places: 0,
            nodes,
            unique,
            restricted: HashMap::new(),
            places: Vec::new(),
            asking: HashMap::new(),
            putting: HashMap::new(),
            waiting: Vec::new(),
        }
    }

    /// The walks that decide these lists of bits, one per list: the places, and the start of each.
    /// `None` if there would be more than `most` places.
    fn walks<'a>(
        &mut self,
        lists: impl Iterator<Item = &'a [(Bit, Edge)]>,
        most: usize,
    ) -> Option<(Vec<Place>, Vec<usize>)> {
        self.most_places = most;
        self.places.clear();
        self.asking.clear();
        self.putting.clear();
        self.waiting.clear();
        let mut starts = Vec::new();
        for list in lists {
            starts.push(self.enter(list.to_vec())?);
            self.walk()?;
        }
        Some(self.finish(&starts))
    }

    /// The lower a level, the earlier a bit is tested.
    fn level(&self, bit: Bit) -> u32 {
        let position = self.positions[usize::from(bit.pair())];
        2 * u32::from(position) + u32::from(bit.0 & 1)
    }

    fn top(&self, edge: Edge) -> Option<Bit> {
        edge.node().map(|n| self.nodes[n].bit)
    }

    /// The place at which these bits are undecided; bits that are decided are written first.
    fn enter(&mut self, mut open: Open) -> Option<usize> {
        let mut put = Vec::new();
        while let Some(decided) = open.iter().position(|(_, edge)| edge.node().is_none()) {
            let (bit, edge) = open.remove(decided);
            if edge.is_negated() {
                put.push(bit);
            }
            self.know(&mut open, bit, edge.is_negated())?;
        }
        let next = self.asking_place(open)?;
        if put.is_empty() {
            return Some(next);
        }
        put.sort_unstable();
        let place = Place::Put { bits: put, next };
        if let Some(known) = self.putting.get(&place) {
            return Some(*known);
        }
        self.places.push(place.clone());
        self.putting.insert(place, self.places.len());
        Some(self.places.len())
    }

    fn asking_place(&mut self, open: Open) -> Option<usize> {
        if open.is_empty() {
            return Some(0);
        }
        if let Some(known) = self.asking.get(&open) {
            return Some(*known);
        }
        if self.places.len() >= self.most_places {
            return None;
        }
        // Its test is determined when the walk continues from it.
        let place = Place::Put {
            bits: Vec::new(),
            next: 0,
        };
        self.places.push(place);
        self.asking.insert(open.clone(), self.places.len());
        self.waiting.push((self.places.len(), open));
        Some(self.places.len())
    }

    /// Continues from every waiting place.
    fn walk(&mut self) -> Option<()> {
        while let Some((place, open)) = self.waiting.pop() {
            // A bit may read those before it once they are decided; the first reads none of them.
            let asked = open
                .iter()
                .filter_map(|(_, edge)| self.top(*edge))
                .filter(|bit| open.iter().all(|(other, _)| other != bit));
            let bit = asked.min_by_key(|bit| self.level(*bit))?;
            let mut ways = [true, false].map(|value| (value, open.clone()));
            for (value, open) in &mut ways {
                self.know(open, bit, *value)?;
            }
            let [(_, high), (_, low)] = ways;
            let (high, low) = (self.enter(high)?, self.enter(low)?);
            self.places[place - 1] = Place::Ask { bit, high, low };
        }
        Some(())
    }

    /// Residuals of all functions for a value of a bit.
    fn know(&mut self, open: &mut Open, bit: Bit, value: bool) -> Option<()> {
        for (_, edge) in open {
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
            let way = if value { node.high } else { node.low };
            return Some(way.flipped(negated));
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
        // The high edge is never negated, so that equal functions share a node.
        let negated = high.is_negated();
        let node = DiagramNode {
            bit,
            high: high.flipped(negated),
            low: low.flipped(negated),
        };
        let index = match self.unique.get(&node) {
            Some(index) => *index,
            None if self.nodes.len() >= self.most_nodes => return None,
            None => {
                self.nodes.push(node);
                self.unique.insert(node, self.nodes.len() - 1);
                self.nodes.len() - 1
            }
        };
        Some(Edge::to(index).flipped(negated))
    }

    /// The places in depth-first order, low edge first, so that adjacent places of a walk are
    /// adjacent in memory.
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
                    Place::Ask { high, low, .. } => stack.extend([*high, *low]),
                    Place::Put { next, .. } => stack.push(*next),
                }
            }
        }
        let places = order.iter().map(|place| match &self.places[place - 1] {
            Place::Ask { bit, high, low } => Place::Ask {
                bit: *bit,
                high: numbers[*high],
                low: numbers[*low],
            },
            Place::Put { bits, next } => Place::Put {
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

    /// Signals that an output may read: all of the previous step, and the next ones of inputs and
    /// of outputs before it.
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

    /// A function over some bits: a sum of products, each with random signs for randomly chosen
    /// bits.
    fn function(maker: &mut Maker, bits: &mut [Bit], terms: &[Vec<(usize, bool)>]) -> Edge {
        bits.sort_by_key(|bit| maker.level(*bit));
        let terms: Vec<BTreeMap<usize, bool>> = terms
            .iter()
            .map(|term| term.iter().map(|(b, v)| (b % bits.len(), *v)).collect())
            .collect();
        build(maker, bits, 0, &terms)
    }

    fn build(
        maker: &mut Maker,
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
            build(maker, bits, from + 1, &left)
        });
        maker.decision(bits[from], high, low).expect("no limit")
    }

    fn follow(walks: &Walks, list: usize, signals: &mut [bool]) {
        for start in &walks.starts[list] {
            let mut place = *start;
            while place != 0 {
                place = match &walks.places[place - 1] {
                    Place::Ask { bit, high, low } if signals[bit.index()] => *high,
                    Place::Ask { low, .. } => *low,
                    Place::Put { bits, next } => {
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
            let mut maker = Maker::new(&Diagram::default(), &order);
            maker.most_nodes = usize::MAX;
            let lists: Vec<Vec<(Bit, Edge)>> = lists
                .iter()
                .map(|functions| {
                    let outputs = functions.iter().enumerate();
                    outputs
                        .map(|(output, terms)| {
                            let bit = Bit(2 * (PAIRS - OUTPUTS + output) as u16).primed();
                            (bit, function(&mut maker, &mut allowed(output), terms))
                        })
                        .collect()
                })
                .collect();
            let diagram = Diagram { nodes: maker.nodes.clone(), roots: Vec::new() };
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
