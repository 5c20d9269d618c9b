//! Regular expressions over skills: as automata, as text, put together in short.
//!
//! An expression becomes a nondeterministic automaton with empty moves (Thompson, "Regular expression search algorithm", 1968), and that a
//! deterministic one by sets of its states.

use super::{Regex, Skills};
use linewright_automata::bound::{Bound, TooLarge};
use linewright_automata::dfa::Dfa;

/// So many places an expression may have when its repetitions are written out.
pub const MOST_PLACES: usize = 1 << 16;

/// What is read on the way from one place to another.
enum Move {
    Nothing,
    Skills(Vec<bool>),
}

struct Places {
    letters: usize,
    from: Vec<Vec<(Move, usize)>>,
}

impl Places {
    fn new_place(&mut self) -> Result<usize, TooLarge> {
        if self.from.len() == MOST_PLACES {
            return Err(TooLarge::Count {
                what: "places in a regular expression",
                limit: MOST_PLACES,
            });
        }
        self.from.push(Vec::new());
        Ok(self.from.len() - 1)
    }

    fn only(&self, skills: &[usize], inside: bool) -> Move {
        let mut set = vec![!inside; self.letters];
        for skill in skills {
            set[*skill] = inside;
        }
        Move::Skills(set)
    }

    /// Lays the expression behind `from`; gives where its words end.
    fn lay(&mut self, regex: &Regex, from: usize) -> Result<usize, TooLarge> {
        match regex {
            Regex::Nothing => self.new_place(),
            Regex::Empty => Ok(from),
            Regex::Skill(skill) => self.lay_one(self.only(&[*skill], true), from),
            Regex::AnyBut(skills) => self.lay_one(self.only(skills, false), from),
            Regex::AnyOrder(skills) => self.lay_any_order(skills, from),
            Regex::Concat(parts) => parts.iter().try_fold(from, |at, part| self.lay(part, at)),
            Regex::Either(parts) => {
                let end = self.new_place()?;
                for part in parts {
                    let begin = self.new_place()?;
                    self.from[from].push((Move::Nothing, begin));
                    let at = self.lay(part, begin)?;
                    self.from[at].push((Move::Nothing, end));
                }
                Ok(end)
            }
            Regex::Repeat { of, low, high } => {
                let mut at = from;
                for _ in 0..*low {
                    at = self.lay(of, at)?;
                    // Also nothing repeated takes a place, so that no number is too large to be refused.
                    let next = self.new_place()?;
                    self.from[at].push((Move::Nothing, next));
                    at = next;
                }
                let end = self.new_place()?;
                if let Some(high) = high {
                    for _ in *low..*high {
                        self.from[at].push((Move::Nothing, end));
                        let begin = self.new_place()?;
                        self.from[at].push((Move::Nothing, begin));
                        at = self.lay(of, begin)?;
                    }
                } else {
                    let around = self.new_place()?;
                    self.from[at].push((Move::Nothing, around));
                    let back = self.lay(of, around)?;
                    self.from[back].push((Move::Nothing, around));
                    at = around;
                }
                self.from[at].push((Move::Nothing, end));
                Ok(end)
            }
        }
    }

    fn lay_one(&mut self, step: Move, from: usize) -> Result<usize, TooLarge> {
        let to = self.new_place()?;
        self.from[from].push((step, to));
        Ok(to)
    }

    /// A place for every set of those that have been called.
    fn lay_any_order(&mut self, skills: &[usize], from: usize) -> Result<usize, TooLarge> {
        if skills.len() >= MOST_PLACES.ilog2() as usize {
            return Err(TooLarge::Count {
                what: "places in a regular expression",
                limit: MOST_PLACES,
            });
        }
        let mut places = vec![from];
        for _ in 1..1_usize << skills.len() {
            places.push(self.new_place()?);
        }
        for called in 0..places.len() {
            for (i, skill) in skills.iter().enumerate() {
                if called >> i & 1 == 0 {
                    let step = self.only(&[*skill], true);
                    self.from[places[called]].push((step, places[called | 1 << i]));
                }
            }
        }
        Ok(places[places.len() - 1])
    }

    /// These places and all that are reached by empty moves, in ascending order.
    fn closure(&self, places: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut waiting: Vec<usize> = places.into_iter().collect();
        let mut seen: std::collections::BTreeSet<usize> = waiting.iter().copied().collect();
        while let Some(place) = waiting.pop() {
            for (step, to) in &self.from[place] {
                if matches!(step, Move::Nothing) && seen.insert(*to) {
                    waiting.push(*to);
                }
            }
        }
        seen.into_iter().collect()
    }
}

/// The smallest automaton of an expression over `letters` skills. What no longer leads to a word is refused.
///
/// # Errors
/// When the expression has more than [`MOST_PLACES`] places, or the automaton more states than `bound` allows, or when the time is over.
pub fn automaton(regex: &Regex, letters: usize, bound: impl Into<Bound>) -> Result<Dfa, TooLarge> {
    let mut places = Places {
        letters,
        from: vec![Vec::new()],
    };
    let end = places.lay(regex, 0)?;
    let step = |state: &Vec<usize>, letter: usize| {
        let moves = state.iter().flat_map(|place| &places.from[*place]);
        let reached = moves.filter_map(|(step, to)| match step {
            Move::Skills(set) if set[letter] => Some(*to),
            _ => None,
        });
        let reached = places.closure(reached);
        (!reached.is_empty()).then_some(reached)
    };
    let start = places.closure([0]);
    let dfa = Dfa::explore(letters, start, bound, step, |s| s.contains(&end))?;
    Ok(dfa.trimmed().minimal())
}

impl Regex {
    /// One after the other, without what changes nothing.
    pub fn concat(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut flat = Vec::new();
        for part in parts {
            match part {
                Self::Nothing => return Self::Nothing,
                Self::Empty => {}
                Self::Concat(inner) => flat.extend(inner),
                other => flat.push(other),
            }
        }
        // x* x is x+, and x* x* is x*.
        let mut short: Vec<Self> = Vec::new();
        for part in flat {
            match short.last().and_then(|last| joined(last, &part)) {
                Some(joined) => *short.last_mut().expect("it was looked at") = joined,
                None => short.push(part),
            }
        }
        match short.len() {
            0 => Self::Empty,
            1 => short.remove(0),
            _ => Self::Concat(short),
        }
    }

    /// One of them, without doubles; what begins or ends alike is said once.
    pub fn either(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut flat = Vec::new();
        let mut empty = false;
        for part in parts {
            let inner = match part {
                Self::Either(inner) => inner,
                other => vec![other],
            };
            for part in inner {
                match part {
                    Self::Nothing => {}
                    Self::Empty => empty = true,
                    Self::Repeat {
                        of,
                        low: 0,
                        high: Some(1),
                    } => {
                        empty = true;
                        let inner = match *of {
                            Self::Either(inner) => inner,
                            other => vec![other],
                        };
                        for part in inner {
                            push_new(&mut flat, part);
                        }
                    }
                    other => push_new(&mut flat, other),
                }
            }
        }
        factor(&mut flat);
        let body = match flat.len() {
            0 if empty => return Self::Empty,
            0 => return Self::Nothing,
            1 => flat.remove(0),
            _ => Self::Either(flat),
        };
        if empty { body.optional() } else { body }
    }

    /// As often as one likes, or not at all.
    #[must_use]
    pub fn star(self) -> Self {
        let of = match self {
            Self::Nothing | Self::Empty => return Self::Empty,
            // (x*)*, (x+)* and (x?)* are x*.
            Self::Repeat {
                of,
                low: 0 | 1,
                high: None | Some(1),
            } => *of,
            other => other,
        };
        // In a repetition, what is repeated itself need not say so.
        let of = match of {
            Self::Either(parts) => {
                let bare = parts.into_iter().map(|part| match part {
                    Self::Repeat {
                        of,
                        low: 0 | 1,
                        high: None | Some(1),
                    } => *of,
                    other => other,
                });
                Self::either(bare)
            }
            other => other,
        };
        Self::Repeat {
            of: Box::new(of),
            low: 0,
            high: None,
        }
    }

    /// Once, or not at all.
    #[must_use]
    pub fn optional(self) -> Self {
        match self {
            Self::Nothing | Self::Empty => Self::Empty,
            Self::Repeat {
                of,
                low: 0 | 1,
                high,
            } => Self::Repeat { of, low: 0, high },
            other if other.has_empty() => other,
            other => Self::Repeat {
                of: Box::new(other),
                low: 0,
                high: Some(1),
            },
        }
    }

    /// Whether the empty word is one of its words.
    pub fn has_empty(&self) -> bool {
        match self {
            Self::Empty => true,
            Self::Nothing | Self::Skill(_) | Self::AnyBut(_) => false,
            Self::AnyOrder(skills) => skills.is_empty(),
            Self::Concat(parts) => parts.iter().all(Self::has_empty),
            Self::Either(parts) => parts.iter().any(Self::has_empty),
            Self::Repeat { of, low, .. } => *low == 0 || of.has_empty(),
        }
    }

    /// How long it is: the skills and operators in it.
    pub fn size(&self) -> usize {
        match self {
            Self::Nothing | Self::Empty | Self::Skill(_) => 1,
            Self::AnyBut(skills) => 1 + skills.len(),
            Self::AnyOrder(skills) => skills.len(),
            Self::Concat(parts) => parts.iter().map(Self::size).sum(),
            Self::Either(parts) => parts.iter().map(|p| p.size() + 1).sum(),
            Self::Repeat { of, .. } => of.size() + 1,
        }
    }

    /// As it stands in a file, with the names of these skills; what is repeated in parentheses where needed.
    pub fn text(&self, skills: &Skills) -> String {
        let name = |skill: &usize| skills.skills[*skill].name.as_str();
        match self {
            // No word is any skill but all of them.
            Self::Nothing => Self::AnyBut((0..skills.skills.len()).collect()).text(skills),
            Self::Empty => "()".to_owned(),
            Self::Skill(skill) => name(skill).to_owned(),
            Self::AnyBut(but) => match but.as_slice() {
                [] => ".".to_owned(),
                [skill] => format!("not {}", name(skill)),
                several => {
                    let names: Vec<&str> = several.iter().map(name).collect();
                    format!("not ({})", names.join(" | "))
                }
            },
            Self::AnyOrder(several) => {
                let names: Vec<&str> = several.iter().map(name).collect();
                names.join(" & ")
            }
            Self::Concat(parts) => {
                let parts = parts.iter().map(|part| match part {
                    Self::Either(_) => format!("({})", part.text(skills)),
                    _ => part.text(skills),
                });
                parts.collect::<Vec<_>>().join(" ")
            }
            Self::Either(parts) => {
                let parts = parts.iter().map(|part| part.text(skills));
                parts.collect::<Vec<_>>().join(" | ")
            }
            Self::Repeat { of, low, high } => {
                let of_text = of.text(skills);
                let one = matches!(**of, Self::Skill(_) | Self::Empty)
                    || matches!(&**of, Self::AnyBut(but) if but.is_empty());
                let of = if one { of_text } else { format!("({of_text})") };
                match (low, high) {
                    (0, None) => format!("{of}*"),
                    (1, None) => format!("{of}+"),
                    (0, Some(1)) => format!("{of}?"),
                    (low, None) => format!("{of}{{{low},}}"),
                    (low, Some(high)) if low == high => format!("{of}{{{low}}}"),
                    (low, Some(high)) => format!("{of}{{{low},{high}}}"),
                }
            }
        }
    }
}

fn push_new(parts: &mut Vec<Regex>, part: Regex) {
    if !parts.contains(&part) {
        parts.push(part);
    }
}

/// Two parts in a row as one.
fn joined(a: &Regex, b: &Regex) -> Option<Regex> {
    let many = |of: &Regex, low| Regex::Repeat {
        of: Box::new(of.clone()),
        low,
        high: None,
    };
    let inside = |r: &Regex| match r {
        Regex::Repeat {
            of,
            low,
            high: None,
        } if *low < 2 => Some(((**of).clone(), *low)),
        _ => None,
    };
    match (inside(a), inside(b)) {
        (Some((x, n)), Some((y, m))) if x == y && n + m < 2 => Some(many(&x, n + m)),
        (Some((x, 0)), None) if x == *b => Some(many(&x, 1)),
        (None, Some((y, 0))) if y == *a => Some(many(&y, 1)),
        // x? x* is x*.
        (None, Some((y, 0))) => match a {
            Regex::Repeat {
                of,
                low: 0,
                high: Some(1),
            } if **of == y => Some(many(&y, 0)),
            _ => None,
        },
        (Some((x, 0)), None) => match b {
            Regex::Repeat {
                of,
                low: 0,
                high: Some(1),
            } if **of == x => Some(many(&x, 0)),
            _ => None,
        },
        _ => None,
    }
}

/// The parts of a concatenation.
fn parts(regex: &Regex) -> Vec<Regex> {
    match regex {
        Regex::Concat(parts) => parts.clone(),
        other => vec![other.clone()],
    }
}

/// Says once what two alternatives begin or end with: `x y | x z` is `x (y | z)`, as long as that is shorter.
fn factor(flat: &mut Vec<Regex>) {
    'again: loop {
        for i in 0..flat.len() {
            for j in i + 1..flat.len() {
                if let Some(shorter) = factored(&flat[i], &flat[j]) {
                    flat[i] = shorter;
                    flat.remove(j);
                    continue 'again;
                }
            }
        }
        return;
    }
}

fn factored(a: &Regex, b: &Regex) -> Option<Regex> {
    // The letters of classes stay one class.
    if matches!((a, b), (Regex::Skill(_), Regex::Skill(_))) {
        return None;
    }
    let (x, y) = (parts(a), parts(b));
    let first = x.iter().zip(&y).take_while(|(a, b)| a == b).count();
    let rests = |x: &[Regex], y: &[Regex]| {
        Regex::either([Regex::concat(x.to_vec()), Regex::concat(y.to_vec())])
    };
    if first > 0 {
        let rest = rests(&x[first..], &y[first..]);
        let common = x[..first].iter().cloned();
        return Some(Regex::concat(common.chain([rest])));
    }
    let last = x.iter().rev().zip(y.iter().rev());
    let last = last.take_while(|(a, b)| a == b).count();
    if last > 0 {
        let rest = rests(&x[..x.len() - last], &y[..y.len() - last]);
        let common = x[x.len() - last..].iter().cloned();
        return Some(Regex::concat([rest].into_iter().chain(common)));
    }
    None
}
