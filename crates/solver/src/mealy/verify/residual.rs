//! Residuals: the formulas that remain when the values of some variables are known.
//!
//! A [`Pool`] shares expressions; fixing a variable simplifies them. A [`Tree`] tests the values of
//! variables one after the other, but only of variables that the remaining formulas mention. Two
//! valuations that leave the same formulas lead to the same place in the tree, because the formulas
//! cannot distinguish these valuations. No diagrams of the solver are involved.

use linewright_core::gr1::eval;
use linewright_core::gr1::{BinaryOp, Expr, Time, UnaryOp};
use rustc_hash::FxHashMap;
use std::rc::Rc;

/// Number of an expression in its pool.
pub type Id = u32;

/// The current or next value of a variable, as a number: `2 · variable`, plus one for the next
/// value.
pub type Key = u32;

/// Returns the key of `variable` at the given time.
pub fn key(variable: usize, time: Time) -> Key {
    2 * variable as u32 + u32::from(time == Time::Next)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Node {
    Const(i64),
    Var(Key),
    Unary(UnaryOp, Id),
    Binary(BinaryOp, Id, Id),
    If(Id, Id, Id),
}

/// Shared, simplified expressions.
#[derive(Debug, Default)]
pub struct Pool {
    nodes: Vec<Node>,
    /// Keys that each expression mentions, ascending.
    keys: Vec<Rc<[Key]>>,
    ids: FxHashMap<Node, Id>,
    fixed: FxHashMap<(Id, Key, i64), Id>,
}

impl Pool {
    fn intern(&mut self, node: Node) -> Id {
        if let Some(id) = self.ids.get(&node) {
            return *id;
        }
        let of = |id: Id| self.keys[id as usize].iter().copied();
        let mut keys: Vec<Key> = match node {
            Node::Const(_) => Vec::new(),
            Node::Var(k) => vec![k],
            Node::Unary(_, a) => of(a).collect(),
            Node::Binary(_, a, b) => of(a).chain(of(b)).collect(),
            Node::If(c, a, b) => of(c).chain(of(a)).chain(of(b)).collect(),
        };
        keys.sort_unstable();
        keys.dedup();
        let id = self.nodes.len() as Id;
        self.nodes.push(node);
        self.keys.push(keys.into());
        self.ids.insert(node, id);
        id
    }

    /// Returns a constant.
    pub fn constant(&mut self, value: i64) -> Id {
        self.intern(Node::Const(value))
    }

    /// Returns the value of an expression, if it is a constant.
    pub fn value(&self, id: Id) -> Option<i64> {
        match self.nodes[id as usize] {
            Node::Const(value) => Some(value),
            _ => None,
        }
    }

    /// Returns the keys that an expression mentions, ascending.
    pub fn keys(&self, id: Id) -> &[Key] {
        &self.keys[id as usize]
    }

    /// Adds an expression. `time` maps the time of a variable in `expr` to the time of its key in
    /// the pool.
    pub fn add(&mut self, expr: &Expr, time: &impl Fn(Time) -> Time) -> Id {
        match expr {
            Expr::Const(c) => self.constant(*c),
            Expr::Var(v, t) => self.intern(Node::Var(key(v.index(), time(*t)))),
            Expr::Unary(op, a) => {
                let a = self.add(a, time);
                self.unary(*op, a)
            }
            Expr::Binary(op, a, b) => {
                let (a, b) = (self.add(a, time), self.add(b, time));
                self.binary(*op, a, b)
            }
            Expr::If(c, a, b) => {
                let (c, a, b) = (self.add(c, time), self.add(a, time), self.add(b, time));
                self.choose(c, a, b)
            }
        }
    }

    fn unary(&mut self, op: UnaryOp, a: Id) -> Id {
        match self.value(a) {
            Some(value) => self.constant(eval::unary(op, value)),
            None => self.intern(Node::Unary(op, a)),
        }
    }

    fn binary(&mut self, op: BinaryOp, a: Id, b: Id) -> Id {
        use BinaryOp::{And, Div, Eq, Implies, Mod, Or};
        let (x, y) = (self.value(a), self.value(b));
        match (op, x, y) {
            (Div | Mod, _, Some(0)) => self.intern(Node::Binary(op, a, b)),
            (_, Some(x), Some(y)) => self.constant(eval::binary(op, x, y)),
            (And, Some(0), _) | (And, _, Some(0)) => self.constant(0),
            (And, Some(_), _) | (Or, Some(0), _) | (Implies, Some(1), _) => b,
            (And, _, Some(_)) | (Or, _, Some(0)) => a,
            (Or, Some(_), _) | (Or, _, Some(_)) | (Implies, Some(0), _) | (Implies, _, Some(1)) => {
                self.constant(1)
            }
            (Implies, _, Some(0)) => self.unary(UnaryOp::Not, a),
            (Eq, ..) if a == b => self.constant(1),
            _ => self.intern(Node::Binary(op, a, b)),
        }
    }

    fn choose(&mut self, c: Id, a: Id, b: Id) -> Id {
        match self.value(c) {
            Some(0) => b,
            Some(_) => a,
            None if a == b => a,
            None => self.intern(Node::If(c, a, b)),
        }
    }

    /// Returns an expression with the value of one key fixed.
    pub fn fix(&mut self, id: Id, key: Key, value: i64) -> Id {
        if self.keys[id as usize].binary_search(&key).is_err() {
            return id;
        }
        if let Some(known) = self.fixed.get(&(id, key, value)) {
            return *known;
        }
        let result = match self.nodes[id as usize] {
            Node::Const(_) | Node::Var(_) => self.constant(value),
            Node::Unary(op, a) => {
                let a = self.fix(a, key, value);
                self.unary(op, a)
            }
            Node::Binary(op, a, b) => {
                let (a, b) = (self.fix(a, key, value), self.fix(b, key, value));
                self.binary(op, a, b)
            }
            Node::If(c, a, b) => {
                let c = self.fix(c, key, value);
                let (a, b) = (self.fix(a, key, value), self.fix(b, key, value));
                self.choose(c, a, b)
            }
        };
        self.fixed.insert((id, key, value), result);
        result
    }

    /// Evaluates an expression that mentions only next values; `next` is indexed by variable.
    pub fn eval(&self, id: Id, next: &[i64]) -> i64 {
        match self.nodes[id as usize] {
            Node::Const(value) => value,
            Node::Var(key) => next[(key / 2) as usize],
            Node::Unary(op, a) => eval::unary(op, self.eval(a, next)),
            Node::Binary(BinaryOp::And, a, b) => {
                i64::from(self.eval(a, next) != 0 && self.eval(b, next) != 0)
            }
            Node::Binary(BinaryOp::Or, a, b) => {
                i64::from(self.eval(a, next) != 0 || self.eval(b, next) != 0)
            }
            Node::Binary(BinaryOp::Implies, a, b) => {
                i64::from(self.eval(a, next) == 0 || self.eval(b, next) != 0)
            }
            Node::Binary(op, a, b) => eval::binary(op, self.eval(a, next), self.eval(b, next)),
            Node::If(c, a, b) => {
                if self.eval(c, next) == 0 {
                    self.eval(b, next)
                } else {
                    self.eval(a, next)
                }
            }
        }
    }
}

/// Number of a node of a [`Tree`].
pub type Place = u32;

/// A node of a [`Tree`].
#[derive(Debug)]
struct Branch {
    /// The remaining formulas.
    formulas: Rc<[Id]>,
    /// Index in [`Tree::order`] of the key that is tested next; `None` if the formulas mention no
    /// key of the order.
    question: Option<u32>,
    /// Children by value of the key, from the smallest value; [`UNKNOWN`] until computed.
    children: Vec<Place>,
}

/// A tree of formula lists: each level holds what remains of the formulas once the value of one
/// more variable is known.
#[derive(Debug)]
pub struct Tree {
    /// Keys in the order in which they are tested, each with its smallest and largest value.
    order: Vec<(Key, i64, i64)>,
    /// Index in `order` of each key; [`NEVER`] if the tree does not test the key.
    ranks: Vec<u32>,
    /// Whether the lists are conjunctions. If so, true formulas are dropped, and a false formula
    /// replaces the whole list.
    pub conjunction: bool,
    branches: Vec<Branch>,
    places: FxHashMap<Rc<[Id]>, Place>,
}

/// Marks a child that is not computed yet.
const UNKNOWN: Place = u32::MAX;

/// Rank of a key that the tree does not test.
const NEVER: u32 = u32::MAX;

impl Tree {
    /// Creates a tree that tests these keys in this order, each given with its smallest and largest
    /// value.
    pub fn new(order: Vec<(Key, i64, i64)>) -> Self {
        let ends = order.iter().map(|(k, ..)| *k as usize + 1);
        let mut ranks = vec![NEVER; ends.max().unwrap_or_default()];
        for (rank, (key, ..)) in order.iter().enumerate() {
            ranks[*key as usize] = rank as u32;
        }
        Self {
            order,
            ranks,
            conjunction: false,
            branches: Vec::new(),
            places: FxHashMap::default(),
        }
    }

    /// Finds or creates the place of a list of formulas.
    pub fn place(&mut self, pool: &Pool, mut formulas: Vec<Id>) -> Place {
        if self.conjunction {
            formulas.sort_unstable();
            formulas.dedup();
            if let Some(no) = formulas.iter().find(|id| pool.value(**id) == Some(0)) {
                formulas = vec![*no];
            } else {
                formulas.retain(|id| pool.value(*id).is_none());
            }
        }
        let formulas: Rc<[Id]> = formulas.into();
        if let Some(place) = self.places.get(&formulas) {
            return *place;
        }
        let keys = formulas.iter().flat_map(|id| pool.keys(*id));
        let ranks = keys.map(|k| self.ranks.get(*k as usize).copied().unwrap_or(NEVER));
        let question = ranks.min().filter(|r| *r != NEVER).map(|r| r as usize);
        let values = |q: usize| (self.order[q].2 - self.order[q].1 + 1) as usize;
        let children = question.map(values).unwrap_or_default();
        let place = self.branches.len() as Place;
        self.branches.push(Branch {
            formulas: Rc::clone(&formulas),
            question: question.map(|q| q as u32),
            children: vec![UNKNOWN; children],
        });
        self.places.insert(formulas, place);
        place
    }

    /// Returns the formulas that remain at a place.
    pub fn formulas(&self, place: Place) -> &[Id] {
        &self.branches[place as usize].formulas
    }

    /// Returns the key that is tested at a place, as an index into the order; `None` if no key is
    /// tested there.
    pub fn question(&self, place: Place) -> Option<usize> {
        self.branches[place as usize].question.map(|q| q as usize)
    }

    /// Returns the place to which this value of the key that is tested at `place` leads.
    pub fn answer(&mut self, pool: &mut Pool, place: Place, value: i64) -> Place {
        let branch = &self.branches[place as usize];
        let Some(question) = branch.question else {
            return place;
        };
        let (key, low, _) = self.order[question as usize];
        let slot = (value - low) as usize;
        let known = branch.children[slot];
        if known != UNKNOWN {
            return known;
        }
        let formulas = Rc::clone(&branch.formulas);
        let fixed = formulas
            .iter()
            .map(|id| pool.fix(*id, key, value))
            .collect();
        let child = self.place(pool, fixed);
        self.branches[place as usize].children[slot] = child;
        child
    }

    /// Returns the place to which this value of the key with index `rank` in the order leads;
    /// `place` itself if that key is not tested there.
    pub fn follow(&mut self, pool: &mut Pool, place: Place, rank: usize, value: i64) -> Place {
        if self.question(place) == Some(rank) {
            self.answer(pool, place, value)
        } else {
            place
        }
    }

    /// Follows, from `place` on, the branches that a valuation (`values`, by variable) selects;
    /// returns the place where no further variable is tested.
    pub fn descend(&mut self, pool: &mut Pool, mut place: Place, values: &[i64]) -> Place {
        while let Some(question) = self.question(place) {
            let variable = (self.order[question].0 / 2) as usize;
            place = self.answer(pool, place, values[variable]);
        }
        place
    }
}
