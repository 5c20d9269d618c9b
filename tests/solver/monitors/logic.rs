//! Temporal logic by definition, and a parser for the formulas in the tables.

use super::words::{Lanes, Lassos};

/// A formula with future or past operators. `Within` variants are bounded by a number of steps.
#[derive(Debug, Clone)]
pub enum Logic {
    Var(usize),
    Not(Box<Logic>),
    And(Box<Logic>, Box<Logic>),
    Or(Box<Logic>, Box<Logic>),
    Globally(Box<Logic>),
    Finally(Box<Logic>),
    FinallyWithin(usize, Box<Logic>),
    Until(Box<Logic>, Box<Logic>),
    UntilWithin(usize, Box<Logic>, Box<Logic>),
    Unless(Box<Logic>, Box<Logic>),
    Previous(Box<Logic>),
    Once(Box<Logic>),
    OnceWithin(usize, Box<Logic>),
    Historically(Box<Logic>),
    HistoricallyWithin(usize, Box<Logic>),
    Since(Box<Logic>, Box<Logic>),
}

use Logic as L;

impl Logic {
    /// The value at every position of the lassos. No past operators.
    pub fn on(&self, lassos: &Lassos) -> Vec<Lanes> {
        let length = lassos.letters.len();
        // The following positions up to the first repeated one: all that are ever reached.
        let walk = |from: usize| {
            let mut position = from;
            std::iter::from_fn(move || {
                let here = position;
                position = lassos.after(position);
                Some(here)
            })
        };
        let exists = |a: &[Lanes], from: usize, steps: usize| {
            walk(from)
                .take(steps)
                .fold(Lanes::NONE, |found, j| found | a[j])
        };
        let forall = |a: &[Lanes], from: usize| {
            walk(from)
                .take(length)
                .fold(Lanes::ALL, |found, j| found & a[j])
        };
        let until = |a: &[Lanes], b: &[Lanes], from: usize, steps: usize| {
            let (mut found, mut so_far) = (Lanes::NONE, Lanes::ALL);
            for j in walk(from).take(steps) {
                found = found | (so_far & b[j]);
                so_far = so_far & a[j];
            }
            found
        };
        let each = |value: &dyn Fn(usize) -> Lanes| (0..length).map(value).collect::<Vec<_>>();
        match self {
            L::Var(v) => each(&|i| lassos.letters[i][*v]),
            L::Not(a) => a.on(lassos).into_iter().map(|x| !x).collect(),
            L::And(a, b) => {
                let (a, b) = (a.on(lassos), b.on(lassos));
                each(&|i| a[i] & b[i])
            }
            L::Or(a, b) => {
                let (a, b) = (a.on(lassos), b.on(lassos));
                each(&|i| a[i] | b[i])
            }
            L::Globally(a) => {
                let a = a.on(lassos);
                each(&|i| forall(&a, i))
            }
            L::Finally(a) => {
                let a = a.on(lassos);
                each(&|i| exists(&a, i, length))
            }
            L::FinallyWithin(n, a) => {
                let a = a.on(lassos);
                each(&|i| exists(&a, i, n + 1))
            }
            L::Until(a, b) => {
                let (a, b) = (a.on(lassos), b.on(lassos));
                each(&|i| until(&a, &b, i, length))
            }
            L::UntilWithin(n, a, b) => {
                let (a, b) = (a.on(lassos), b.on(lassos));
                each(&|i| until(&a, &b, i, n + 1))
            }
            L::Unless(a, b) => {
                let (a, b) = (a.on(lassos), b.on(lassos));
                each(&|i| until(&a, &b, i, length) | forall(&a, i))
            }
            _ => panic!("{self:?} refers to the past"),
        }
    }

    /// The value at every position of finite words. No future operators.
    pub fn in_the_past_of(&self, word: &[Vec<Lanes>]) -> Vec<Lanes> {
        let each = |value: &dyn Fn(usize) -> Lanes| (0..word.len()).map(value).collect::<Vec<_>>();
        let exists = |a: &[Lanes]| a.iter().fold(Lanes::NONE, |found, x| found | *x);
        let forall = |a: &[Lanes]| a.iter().fold(Lanes::ALL, |found, x| found & *x);
        match self {
            L::Var(v) => each(&|i| word[i][*v]),
            L::Not(a) => a.in_the_past_of(word).into_iter().map(|x| !x).collect(),
            L::And(a, b) => {
                let (a, b) = (a.in_the_past_of(word), b.in_the_past_of(word));
                each(&|i| a[i] & b[i])
            }
            L::Or(a, b) => {
                let (a, b) = (a.in_the_past_of(word), b.in_the_past_of(word));
                each(&|i| a[i] | b[i])
            }
            L::Previous(a) => {
                let a = a.in_the_past_of(word);
                each(&|i| if i == 0 { Lanes::NONE } else { a[i - 1] })
            }
            L::Once(a) => {
                let a = a.in_the_past_of(word);
                each(&|i| exists(&a[..=i]))
            }
            L::OnceWithin(n, a) => {
                let a = a.in_the_past_of(word);
                each(&|i| exists(&a[i.saturating_sub(*n)..=i]))
            }
            L::Historically(a) => {
                let a = a.in_the_past_of(word);
                each(&|i| forall(&a[..=i]))
            }
            L::HistoricallyWithin(n, a) => {
                let a = a.in_the_past_of(word);
                each(&|i| forall(&a[i.saturating_sub(*n)..=i]))
            }
            L::Since(a, b) => {
                let (a, b) = (a.in_the_past_of(word), b.in_the_past_of(word));
                each(&|i| {
                    (0..=i).fold(Lanes::NONE, |found, j| {
                        found | (b[j] & forall(&a[j + 1..=i]))
                    })
                })
            }
            _ => panic!("{self:?} refers to the future"),
        }
    }
}

/// Parses `G ((q & !r) -> (!p W r))`, with the letters of `names` as variables. Unary operators
/// bind tightest; then come `U`, `W` and `S`, then `&`, `or` and `->`. Future operators are `F`,
/// `G`, `U`, `W`, past ones `Y`, `O`, `H`, `S`; a bound is `F<=3`.
pub fn read(text: &str, names: &[char]) -> Logic {
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let symbols = ["->", "<=", "or"];
        let length = symbols.iter().find(|s| rest.starts_with(**s));
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let length = length.map_or(digits.max(1), |s| s.len());
        tokens.push(rest[..length].to_owned());
        rest = rest[length..].trim_start();
    }
    tokens.reverse();
    let mut reader = Reader { tokens, names };
    let formula = reader.formula(0);
    assert!(reader.tokens.is_empty(), "{text}: left {:?}", reader.tokens);
    formula
}

struct Reader<'a> {
    /// The next one is last.
    tokens: Vec<String>,
    names: &'a [char],
}

impl Reader<'_> {
    fn peek(&self) -> &str {
        self.tokens.last().map_or("", String::as_str)
    }

    fn bound(&mut self) -> Option<usize> {
        (self.peek() == "<=").then(|| {
            self.tokens.pop();
            let number = self.tokens.pop().expect("a bound");
            number.parse().expect("a number")
        })
    }

    fn formula(&mut self, strength: u8) -> Logic {
        let mut left = self.operand();
        loop {
            let operator = self.peek().to_owned();
            let binds = match operator.as_str() {
                "->" => 1,
                "or" => 2,
                "&" => 3,
                "U" | "W" | "S" => 4,
                _ => return left,
            };
            if binds <= strength {
                return left;
            }
            self.tokens.pop();
            let bound = self.bound();
            let right = Box::new(self.formula(binds - 1));
            let a = Box::new(left);
            left = match (operator.as_str(), bound) {
                ("->", None) => L::Or(Box::new(L::Not(a)), right),
                ("or", None) => L::Or(a, right),
                ("&", None) => L::And(a, right),
                ("U", None) => L::Until(a, right),
                ("U", Some(n)) => L::UntilWithin(n, a, right),
                ("W", None) => L::Unless(a, right),
                ("S", None) => L::Since(a, right),
                other => panic!("{other:?}"),
            };
        }
    }

    fn operand(&mut self) -> Logic {
        let token = self.tokens.pop().expect("an operand");
        if token == "(" {
            let inner = self.formula(0);
            assert_eq!(self.tokens.pop().as_deref(), Some(")"));
            return inner;
        }
        if let Some(v) = self.names.iter().position(|n| token == n.to_string()) {
            return L::Var(v);
        }
        let bound = self.bound();
        let a = Box::new(self.operand());
        match (token.as_str(), bound) {
            ("!", None) => L::Not(a),
            ("G", None) => L::Globally(a),
            ("F", None) => L::Finally(a),
            ("F", Some(n)) => L::FinallyWithin(n, a),
            ("Y", None) => L::Previous(a),
            ("O", None) => L::Once(a),
            ("O", Some(n)) => L::OnceWithin(n, a),
            ("H", None) => L::Historically(a),
            ("H", Some(n)) => L::HistoricallyWithin(n, a),
            other => panic!("{other:?} is not an operator"),
        }
    }
}
