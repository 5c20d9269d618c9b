//! Every formula of up to three operators over two inputs and two outputs, now and next. A formula
//! represents all equivalent ones: functions are distinguished by their values, and each is written
//! with the fewest operators.

use linewright::gr1::{Expr, VarId};
use std::collections::HashSet;
use std::ops::Range;

/// The values of a function for every valuation of the atoms: bit `i` of a valuation's number is
/// atom `i`.
pub type Values = [u64; 4];

/// Two inputs, two outputs, and their next values.
const ATOMS: usize = 8;

/// An atom is a variable now, or, four higher, its next value.
const VARIABLES: usize = 4;

pub const MOST_OPERATORS: usize = 3;

#[derive(Clone, Copy)]
enum Operator {
    And,
    Or,
    Iff,
}

#[derive(Clone, Copy)]
enum Form {
    Literal(usize, bool),
    Binary(Operator, usize, usize),
}

/// Every function of some atoms that up to three operators can express; a negated variable counts
/// as none.
pub struct Functions {
    all: Vec<(Values, Form)>,
    /// Start of each number of operators, and the end.
    begin: Vec<usize>,
}

impl Functions {
    pub fn of(atoms: &[usize]) -> Self {
        let mut all: Vec<(Values, Form)> = Vec::new();
        let mut known: HashSet<Values> = HashSet::new();
        for atom in atoms {
            for positive in [true, false] {
                let values = literal(*atom, positive);
                known.insert(values);
                all.push((values, Form::Literal(*atom, positive)));
            }
        }
        let mut begin = vec![0, all.len()];
        for operators in 1..=MOST_OPERATORS {
            let mut fresh = Vec::new();
            for left in 0..operators {
                let right = operators - 1 - left;
                if left < right {
                    continue;
                }
                for i in begin[left]..begin[left + 1] {
                    for j in begin[right]..begin[right + 1] {
                        for operator in [Operator::And, Operator::Or, Operator::Iff] {
                            let values = apply(operator, &all[i].0, &all[j].0);
                            if known.insert(values) {
                                fresh.push((values, Form::Binary(operator, i, j)));
                            }
                        }
                    }
                }
            }
            all.extend(fresh);
            begin.push(all.len());
        }
        Self { all, begin }
    }

    pub fn expr(&self, index: usize) -> Expr {
        match self.all[index].1 {
            Form::Literal(atom, positive) => {
                let variable = VarId((atom % VARIABLES) as u32);
                let atom = if atom < VARIABLES {
                    Expr::now(variable)
                } else {
                    Expr::next(variable)
                };
                if positive { atom } else { atom.not() }
            }
            Form::Binary(operator, left, right) => {
                let (left, right) = (self.expr(left), self.expr(right));
                match operator {
                    Operator::And => left.and(right),
                    Operator::Or => left.or(right),
                    Operator::Iff => left.equals(right),
                }
            }
        }
    }

    /// The functions that need exactly this many operators.
    pub fn of_length(&self, operators: usize) -> Range<usize> {
        self.begin[operators]..self.begin[operators + 1]
    }

    /// Number of functions.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// The index of a function's orbit under renaming: the same for all its members.
    pub fn set_of(&self, index: usize, renamings: &[Vec<usize>]) -> Values {
        let renamed = renamings.iter().map(|r| rename(&self.all[index].0, r));
        renamed
            .min()
            .expect("there is the one that changes nothing")
    }

    /// The first member of each orbit under renaming.
    pub fn up_to_renaming(&self) -> Vec<usize> {
        let renamings = renamings();
        let mut seen: HashSet<Values> = HashSet::new();
        let functions = 0..self.all.len();
        functions
            .filter(|index| seen.insert(self.set_of(*index, &renamings)))
            .collect()
    }
}

fn literal(atom: usize, positive: bool) -> Values {
    let mut values = [0; 4];
    for valuation in 0..1_usize << ATOMS {
        if (valuation >> atom & 1 == 1) == positive {
            values[valuation / 64] |= 1 << (valuation % 64);
        }
    }
    values
}

fn apply(operator: Operator, a: &Values, b: &Values) -> Values {
    std::array::from_fn(|i| match operator {
        Operator::And => a[i] & b[i],
        Operator::Or => a[i] | b[i],
        Operator::Iff => !(a[i] ^ b[i]),
    })
}

/// Inputs swapped or not, outputs swapped or not: the image of every valuation.
pub fn renamings() -> Vec<Vec<usize>> {
    let swap = |valuation: usize, a: usize, b: usize| {
        let different = (valuation >> a ^ valuation >> b) & 1;
        valuation ^ (different << a | different << b)
    };
    let mut renamings = Vec::new();
    for (inputs, outputs) in [(false, false), (true, false), (false, true), (true, true)] {
        let renamed = |mut valuation: usize| {
            if inputs {
                valuation = swap(swap(valuation, 0, 1), 4, 5);
            }
            if outputs {
                valuation = swap(swap(valuation, 2, 3), 6, 7);
            }
            valuation
        };
        renamings.push((0..1 << ATOMS).map(renamed).collect());
    }
    renamings
}

fn rename(values: &Values, renaming: &[usize]) -> Values {
    let mut renamed = [0; 4];
    for (valuation, becomes) in renaming.iter().enumerate() {
        let value = values[valuation / 64] >> (valuation % 64) & 1;
        renamed[becomes / 64] |= value << (becomes % 64);
    }
    renamed
}

#[test]
fn every_function_is_there_and_renaming_loses_none() {
    assert_eq!(Functions::of(&[0, 1]).all.len(), 16);
    let functions = Functions::of(&[0, 1, 2, 3, 4, 5, 6, 7]);
    let renamings = renamings();
    let first = functions.up_to_renaming().into_iter();
    let sizes = first.map(|index| {
        let values = &functions.all[index].0;
        let renamed = renamings.iter().map(|r| rename(values, r));
        renamed.collect::<HashSet<Values>>().len()
    });
    assert_eq!(sizes.sum::<usize>(), functions.all.len());
}
